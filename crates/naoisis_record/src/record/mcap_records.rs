//! Reads the records of an MCAP file of any program, one after another.

use core::error::Error;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, parse_record};
use std::io::{self, ErrorKind, Read};

/// Whether a file that begins with `start` is an MCAP file.
pub fn is_mcap(start: &[u8]) -> bool {
    start.starts_with(MAGIC)
}

/// Reads an MCAP file from its start. Chunks are unpacked, and their checksums are checked.
pub struct McapRecords<R> {
    file: R,
    reader: LinearReader,
    /// Number of bytes read from the file.
    read_bytes: u64,
}

impl<R: Read> McapRecords<R> {
    /// Creates a reader. Records longer than `longest_bytes` are refused, which bounds the reader's memory.
    pub fn new(file: R, longest_bytes: usize) -> Self {
        let options =
            LinearReaderOptions::default().with_validate_chunk_crcs(true).with_record_length_limit(longest_bytes);
        Self { file, reader: LinearReader::new_with_options(options), read_bytes: 0 }
    }

    /// Reads records until `take` returns a value, and returns that value, or `None` at the end of the file.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged or cut off ([`UnexpectedEof`](ErrorKind::UnexpectedEof)), or `take` fails.
    pub fn find<T>(
        &mut self,
        mut take: impl FnMut(Record<'_>) -> Result<Option<T>, Box<dyn Error + Send + Sync>>,
    ) -> io::Result<Option<T>> {
        while let Some(event) = self.reader.next_event() {
            let (opcode, data) = match event {
                Ok(LinearReadEvent::Record { opcode, data }) => (opcode, data),
                Ok(LinearReadEvent::ReadRequest(needed)) => {
                    let read = self.file.read(self.reader.insert(needed))?;
                    self.reader.notify_read(read);
                    self.read_bytes += read as u64;
                    continue;
                }
                Err(McapError::UnexpectedEof) => return Err(ErrorKind::UnexpectedEof.into()),
                Err(error) => return Err(self.wrong(&error)),
            };
            let taken = parse_record(opcode, data).map_err(Into::into).and_then(&mut take);
            match taken {
                Ok(None) => {}
                Ok(found) => return Ok(found),
                Err(error) => return Err(self.wrong(&*error)),
            }
        }
        Ok(None)
    }

    fn wrong(&self, error: &dyn Error) -> io::Error {
        io::Error::new(ErrorKind::InvalidData, format!("before byte {} of the MCAP file: {error}", self.read_bytes))
    }
}

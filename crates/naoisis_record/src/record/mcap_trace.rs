//! Reads the trace in an MCAP file as lines.

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};
use std::io::{self, ErrorKind, Read};

/// Topic of the trace.
pub(super) const TRACE: &str = "/trace";
/// Names of the metadata with the first and the last line of the trace, and the key of the line in them.
pub(super) const HEADER: &str = "naoisis-trace";
pub(super) const END: &str = "naoisis-trace-end";
pub(super) const LINE: &str = "line";

/// Greatest size of a record without its line, bytes.
const BESIDE_BYTES: usize = 64 << 10;

/// Reads an MCAP file as the text of its trace: a line for the header, a line for each message on the trace's channel, and a line for the
/// end.
pub(super) struct McapTrace<R> {
    file: R,
    reader: LinearReader,
    /// Number of bytes read from the file.
    read_bytes: u64,
    /// Id of the trace's channel.
    channel: Option<u16>,
    has_header: bool,
    line: Vec<u8>,
    /// Number of bytes of the line that were returned.
    used: usize,
}

impl<R: Read> McapTrace<R> {
    /// Creates a reader. Lines longer than `longest_bytes` are refused, which bounds the reader's memory.
    pub(super) fn new(file: R, longest_bytes: usize) -> Self {
        let options = LinearReaderOptions::default()
            .with_validate_chunk_crcs(true)
            .with_record_length_limit(longest_bytes + BESIDE_BYTES);
        let reader = LinearReader::new_with_options(options);
        Self { file, reader, read_bytes: 0, channel: None, has_header: false, line: Vec::new(), used: 0 }
    }

    /// Reads the next line. It is empty at the end of the file.
    fn next_line(&mut self) -> io::Result<()> {
        self.line.clear();
        self.used = 0;
        let wrong = |at: u64, message: String| {
            io::Error::new(ErrorKind::InvalidData, format!("before byte {at} of the MCAP file: {message}"))
        };
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
                Err(error) => return Err(wrong(self.read_bytes, error.to_string())),
            };
            let record = parse_record(opcode, data).map_err(|error| wrong(self.read_bytes, error.to_string()))?;
            match record {
                Record::Metadata(metadata) if metadata.name == HEADER || metadata.name == END => {
                    self.has_header = true;
                    self.line.extend(metadata.metadata.get(LINE).map_or(&b""[..], |line| line.as_bytes()));
                }
                Record::Channel(channel) if !self.has_header => {
                    let message = format!(
                        "it has the channel `{}` before any trace: it was not written by naoisis, or its metadata `{HEADER}` is lost",
                        channel.topic
                    );
                    return Err(wrong(self.read_bytes, message));
                }
                Record::Channel(channel) if channel.topic == TRACE => self.channel = Some(channel.id),
                Record::Message { header, data } if Some(header.channel_id) == self.channel => {
                    self.line.extend_from_slice(&data);
                }
                _ => continue,
            }
            if !self.line.is_empty() {
                self.line.push(b'\n');
                break;
            }
        }
        Ok(())
    }
}

impl<R: Read> Read for McapTrace<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.used == self.line.len() {
            self.next_line()?;
        }
        let count = (&self.line[self.used..]).read(buffer)?;
        self.used += count;
        Ok(count)
    }
}

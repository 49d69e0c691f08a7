//! Reads the trace in an MCAP file as lines.

use mcap::records::Record;
use std::io::{self, Read};

use super::mcap_records::McapRecords;

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
    records: McapRecords<R>,
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
        let records = McapRecords::new(file, longest_bytes + BESIDE_BYTES);
        Self { records, channel: None, has_header: false, line: Vec::new(), used: 0 }
    }

    /// Reads the next line. It is empty at the end of the file.
    fn next_line(&mut self) -> io::Result<()> {
        self.line.clear();
        self.used = 0;
        self.records.find(|record| {
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
                    return Err(message.into());
                }
                Record::Channel(channel) if channel.topic == TRACE => self.channel = Some(channel.id),
                Record::Message { header, data } if Some(header.channel_id) == self.channel => {
                    self.line.extend_from_slice(&data);
                }
                _ => {}
            }
            if self.line.is_empty() {
                return Ok(None);
            }
            self.line.push(b'\n');
            Ok(Some(()))
        })?;
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

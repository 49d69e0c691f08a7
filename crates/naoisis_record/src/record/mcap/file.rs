//! Writes an MCAP file, channel by channel.

use foxglove::{Encode, Schema};
use mcap::records::MessageHeader;
use mcap::write::{Metadata, NoSeek};
use mcap::{Compression, McapError, WriteOptions, Writer};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};

use super::channels::ChannelSink;
use super::viewer_schema::viewer_schema;
use naoisis_sim::interface::trace_numbers::ShortestFloats;

/// Name of the writing library in the header. It has no version, so that files do not change with updates of a library.
const LIBRARY: &str = "naoisis";
/// Size of chunks before compression, bytes: at most this much is lost if the program is killed.
const CHUNK_BYTES: u64 = 256 << 10;
const COMPRESSION_LEVEL: u32 = 1;

/// An MCAP file that is being written. After an error nothing more is written.
pub(super) struct McapFile {
    writer: Writer<NoSeek<BufWriter<File>>>,
    /// The header of the next message of each topic.
    channels: BTreeMap<String, MessageHeader>,
    message: Vec<u8>,
    error: Option<io::Error>,
}

impl McapFile {
    pub(super) fn create(file: File) -> io::Result<Self> {
        // Chunks are compressed in this thread and written whole.
        let options = WriteOptions::new()
            .library(LIBRARY)
            .chunk_size(Some(CHUNK_BYTES))
            .compression(Some(Compression::Zstd))
            .compression_level(COMPRESSION_LEVEL)
            .compression_threads(0)
            .disable_seeking(true);
        let writer = options.create(NoSeek::new(BufWriter::new(file))).map_err(io_error)?;
        Ok(Self { writer, channels: BTreeMap::new(), message: Vec::new(), error: None })
    }

    pub(super) fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    /// Writes a metadata record.
    pub(super) fn metadata(&mut self, name: &str, entries: impl IntoIterator<Item = (&'static str, String)>) {
        let metadata = entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        let metadata = Metadata { name: name.to_owned(), metadata };
        self.attempt(|file| file.writer.write_metadata(&metadata).map_err(io_error));
    }

    /// Writes a message that is already the JSON of a `T`.
    pub(super) fn log_text<T: JsonSchema>(&mut self, topic: &str, time_ns: u64, text: &[u8]) {
        self.log_json_with::<T>(topic, time_ns, |bytes| bytes.write_all(text));
    }

    fn log_json_with<T: JsonSchema>(
        &mut self,
        topic: &str,
        time_ns: u64,
        write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) {
        self.log_with(topic, time_ns, "json", || Some(viewer_schema::<T>()), write);
    }

    fn log_with(
        &mut self,
        topic: &str,
        time_ns: u64,
        encoding: &str,
        schema: impl FnOnce() -> Option<Schema>,
        write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) {
        self.attempt(|file| {
            if !file.channels.contains_key(topic) {
                file.add_channel(topic, encoding, schema())?;
            }
            file.message.clear();
            write(&mut file.message)?;
            let Some(header) = file.channels.get_mut(topic) else { return Ok(()) };
            (header.log_time, header.publish_time) = (time_ns, time_ns);
            file.writer.write_to_known_channel(header, &file.message).map_err(io_error)?;
            header.sequence += 1;
            Ok(())
        });
    }

    fn add_channel(&mut self, topic: &str, encoding: &str, schema: Option<Schema>) -> io::Result<()> {
        let schema = match schema {
            Some(schema) => self.writer.add_schema(&schema.name, &schema.encoding, &schema.data).map_err(io_error)?,
            None => 0,
        };
        let id = self.writer.add_channel(schema, topic, encoding, &BTreeMap::new()).map_err(io_error)?;
        let header = MessageHeader { channel_id: id, sequence: 0, log_time: 0, publish_time: 0 };
        self.channels.insert(topic.to_owned(), header);
        Ok(())
    }

    /// Calls `act` unless there was an error before, and keeps its error.
    pub(super) fn attempt(&mut self, act: impl FnOnce(&mut Self) -> io::Result<()>) {
        if self.error.is_none() {
            self.error = act(self).err();
        }
    }

    /// Writes the index of the file.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.attempt(|file| file.writer.finish().map(drop).map_err(io_error));
        self.error.map_or(Ok(()), Err)?;
        self.writer.into_inner().into_inner().flush()
    }
}

impl ChannelSink for McapFile {
    fn log<T: Encode>(&mut self, topic: &str, time_ns: u64, message: &T) {
        self.log_with(topic, time_ns, "protobuf", T::get_schema, |bytes| {
            message.encode(bytes).map_err(|error| io::Error::other(error.to_string()))
        });
    }

    fn log_json<T: JsonSchema + Serialize>(&mut self, topic: &str, time_ns: u64, message: &T) {
        self.log_json_with::<T>(topic, time_ns, |bytes| {
            let mut serializer = serde_json::Serializer::with_formatter(bytes, ShortestFloats);
            message.serialize(&mut serializer).map_err(io::Error::from)
        });
    }

    fn fail(&mut self, error: io::Error) {
        self.attempt(|_| Err(error));
    }
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

//! The channels of a live view, for viewers that have subscribed to them.

use bevy::log::warn;
use foxglove::{ChannelBuilder, Context, Encode, PartialMetadata, RawChannel, Schema};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;

use crate::record::mcap::channels::ChannelSink;
use crate::record::mcap::viewer_schema::viewer_schema;
use naoisis_sim::interface::trace_numbers::ShortestFloats;

/// Sends messages to viewers. Messages that nobody has subscribed to are not encoded.
pub(super) struct LiveSink {
    context: Arc<Context>,
    channels: BTreeMap<String, Arc<RawChannel>>,
    message: Vec<u8>,
}

impl LiveSink {
    pub(super) fn new(context: Arc<Context>) -> Self {
        Self { context, channels: BTreeMap::new(), message: Vec::new() }
    }

    fn log_with(
        &mut self,
        topic: &str,
        time_ns: u64,
        encoding: &str,
        schema: impl FnOnce() -> Option<Schema>,
        write: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) {
        if !self.channels.contains_key(topic) {
            let channel = ChannelBuilder::new(topic).context(&self.context).message_encoding(encoding).schema(schema());
            match channel.build_raw() {
                Ok(channel) => _ = self.channels.insert(topic.to_owned(), channel),
                Err(error) => warn!("the live view lacks the topic {topic}: {error}"),
            }
        }
        let Some(channel) = self.channels.get(topic).filter(|channel| channel.has_sinks()) else { return };
        self.message.clear();
        match write(&mut self.message) {
            Ok(()) => channel.log_with_meta(&self.message, PartialMetadata::with_log_time(time_ns)),
            Err(error) => warn!("the live view lacks a message of the topic {topic}: {error}"),
        }
    }
}

impl ChannelSink for LiveSink {
    fn log<T: Encode>(&mut self, topic: &str, time_ns: u64, message: &T) {
        self.log_with(topic, time_ns, "protobuf", T::get_schema, |bytes| {
            message.encode(bytes).map_err(|error| io::Error::other(error.to_string()))
        });
    }

    fn log_json<T: JsonSchema + Serialize>(&mut self, topic: &str, time_ns: u64, message: &T) {
        self.log_with(
            topic,
            time_ns,
            "json",
            || Some(viewer_schema::<T>()),
            |bytes| {
                let mut serializer = serde_json::Serializer::with_formatter(bytes, ShortestFloats);
                message.serialize(&mut serializer).map_err(io::Error::from)
            },
        );
    }

    fn fail(&mut self, error: io::Error) {
        warn!("the live view lacks an image: {error}");
    }
}

//! A match while it is played, in Foxglove or Lichtblick: the channels of an [MCAP file](super::mcap) over their WebSocket protocol.
//!
//! A frame is sent at most 60 times a second of real time. The match waits for no viewer: while nobody is connected nothing is encoded, and
//! the frames that a slow viewer does not take in time are dropped. A viewer may pause the match, step through it and change its speed by
//! services of the protocol. None of this changes what happens in the match.

mod services;
mod sink;

use bevy::prelude::*;
use core::time::Duration;
use foxglove::websocket::{Capability, ChannelView, Client, ServerListener};
use foxglove::{Context, FoxgloveError, WebSocketServer, WebSocketServerHandle};
use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::Instant;

use super::live_control::LiveControl;
use super::mcap::channels::{ChannelSink, Channels};
use super::mcap::nanoseconds;
use super::mcap_trace::TRACE;
use super::recorder::{MatchEnd, RecordError, Recorder};
use naoisis_core::events::MatchEvent;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;
use sink::LiveSink;

/// Least time between two frames.
const FRAME: Duration = Duration::from_nanos(1_000_000_000 / 60);
/// Time that the server has to send the last frame, and then to say goodbye. It sends in the background, and a viewer that takes nothing
/// does not keep the program from ending.
const LAST_FRAME: Duration = Duration::from_millis(250);

/// Sends a match to viewers while it is played.
pub struct LiveRecorder {
    server: WebSocketServerHandle,
    sink: LiveSink,
    control: LiveControl,
    viewers: Arc<Viewers>,
    scenario: Scenario,
    channels: Option<Channels>,
    /// The events since the last frame.
    events: Vec<MatchEvent>,
    last_frame: Option<Instant>,
}

/// The viewers that are connected.
#[derive(Default)]
struct Viewers {
    count: AtomicUsize,
    /// Whether one has subscribed to a channel since the last frame. It needs the messages that are sent only once, such as the pitch.
    is_new: AtomicBool,
    control: LiveControl,
}

impl ServerListener for Viewers {
    fn on_subscribe(&self, _: Client, _: ChannelView) {
        self.is_new.store(true, Ordering::Release);
    }

    fn on_client_connect(&self) {
        self.count.fetch_add(1, Ordering::AcqRel);
    }

    fn on_client_disconnect(&self) {
        // A match that nobody can continue any more goes on.
        if self.count.fetch_sub(1, Ordering::AcqRel) <= 1 {
            self.control.pause(false);
        }
    }
}

impl LiveRecorder {
    /// Starts a server that viewers connect to.
    ///
    /// # Errors
    /// If the address cannot be used.
    pub fn start(host: &str, port: u16) -> Result<Self, RecordError> {
        let (context, control) = (Context::new(), LiveControl::default());
        let viewers = Arc::new(Viewers { control: control.clone(), ..default() });
        let server = WebSocketServer::new()
            .name("naoisis")
            .bind(host, port)
            .context(&context)
            .capabilities([Capability::Time])
            .supported_encodings(["json"])
            .services(services::all(&control))
            .listener(viewers.clone());
        let server = server.start_blocking().map_err(|error| {
            let error = match error {
                FoxgloveError::Bind(error) | FoxgloveError::IoError(error) => error,
                other => io::Error::other(other),
            };
            RecordError::Io { path: PathBuf::from(format!("{host}:{port}")), error }
        })?;
        let (sink, scenario) = (LiveSink::new(context), Scenario::default());
        Ok(Self { server, sink, control, viewers, scenario, channels: None, events: Vec::new(), last_frame: None })
    }

    /// Returns the port of the server.
    pub fn port(&self) -> u16 {
        self.server.port()
    }

    /// Sends a frame.
    fn send(&mut self, record: &CycleRecord, world: &World) {
        let time_ns = nanoseconds(record.time_s);
        let is_new = self.viewers.is_new.swap(false, Ordering::AcqRel);
        let channels = match self.channels.take().filter(|_| !is_new) {
            Some(channels) => channels,
            None => Channels::begin(&self.scenario, record, &Fields::default(), &mut self.sink),
        };
        let channels = self.channels.insert(channels);
        let record = CycleRecord { events: core::mem::take(&mut self.events), ..record.clone() };
        self.server.broadcast_time(time_ns);
        self.sink.log_json(TRACE, time_ns, &record);
        channels.write(&record, world, &mut self.sink);
        self.last_frame = Some(Instant::now());
    }
}

impl Recorder for LiveRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, world: &mut World) {
        world.insert_resource(self.control.clone());
        self.scenario = scenario.clone();
        // Viewers learn which channels there are.
        self.send(record, world);
    }

    fn needs_record(&self) -> bool {
        self.server.client_count() > 0
    }

    fn record(&mut self, record: &CycleRecord, world: &mut World) {
        if !self.needs_record() {
            return;
        }
        self.events.extend_from_slice(&record.events);
        // A step of a paused match is always shown.
        let is_due = self.last_frame.is_none_or(|last| last.elapsed() >= FRAME);
        if is_due || self.control.is_paused() {
            self.send(record, world);
        }
    }

    fn finish(mut self: Box<Self>, _: &MatchEnd, last: &CycleRecord) -> Result<Option<String>, RecordError> {
        self.send(last, &World::new());
        let is_watched = self.needs_record();
        if is_watched {
            thread::sleep(LAST_FRAME);
        }
        self.server.stop().detach_all();
        if is_watched {
            thread::sleep(LAST_FRAME);
        }
        Ok(None)
    }
}

//! Writes the channels that viewers show, in addition to the trace.

use bevy::prelude::*;
use foxglove::Encode;
use foxglove::messages::{CompressedImage, FrameTransforms, Log, SceneUpdate, log};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io;

use super::nanoseconds;
use super::pitch::pitch;
use super::robots::{RecordedFrames, Robot, ball_frame, calibration, frames};
use super::senses::{ErrorOfBelief, annotations, belief_scene, percepts_scene};
use super::shapes::{Entity, colour, scene, timestamp};
use crate::record::beliefs::{Sensed, truth};
use crate::record::encoder::Layer;
use crate::record::event_words::event_words;
use crate::record::match_renderer::newest_image;
use crate::record::png_file::encode_png;
use naoisis_core::ball::BallLook;
use naoisis_core::camera_model::CameraMount;
use naoisis_core::events::MatchEvent;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_sensing::appearance::ball;
use naoisis_sensing::belief::error::BeliefError;
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;

/// Rate of the messages about percepts, beliefs, commands and the state of the game, and the highest rate of messages from one robot to
/// another, Hz. Commands to kick, get up or dive are always written.
const SENSE_HZ: f64 = 10.0;

/// What receives the messages of channels: a file, or viewers.
pub(in crate::record) trait ChannelSink {
    /// Writes a message with a Foxglove schema.
    fn log<T: Encode>(&mut self, topic: &str, time_ns: u64, message: &T);
    /// Writes a JSON message, with numbers formatted as in a trace.
    fn log_json<T: JsonSchema + Serialize>(&mut self, topic: &str, time_ns: u64, message: &T);
    /// Notes that an image could not be encoded.
    fn fail(&mut self, error: io::Error);
}

/// The channels of a match that is being written.
pub(in crate::record) struct Channels {
    robots: Vec<Robot>,
    ball_radius_m: f32,
    ball_look: BallLook,
    cycle_s: f64,
    /// The cycle from which on the next messages of robots are due.
    due: u64,
    /// The robots that were drawn as penalised, and how many balls were drawn.
    drawn: Option<(Vec<RobotId>, usize)>,
    /// Whether records have the whole state of the game. Those of some traces lack it.
    has_game: bool,
    /// Whether records have percepts.
    has_percepts: bool,
    /// The frames of robots that records have.
    has_frames: RecordedFrames,
    /// The truth at the end of the previous cycle, when the robots sensed.
    sensed: Sensed,
    /// The time of the percepts of each robot that were written as annotations last, s.
    annotated: BTreeMap<RobotId, f64>,
    /// The cycle from which on the next message between two robots is written.
    next_message: BTreeMap<[RobotId; 2], u64>,
}

impl Channels {
    /// Writes the messages that do not change during the match.
    pub(in crate::record) fn begin(
        scenario: &Scenario,
        record: &CycleRecord,
        fields: &Fields,
        sink: &mut impl ChannelSink,
    ) -> Self {
        let time_ns = nanoseconds(record.time_s);
        let robots: Vec<Robot> = record.robots.iter().map(|robot| Robot::of(scenario, robot.id)).collect();
        sink.log("/pitch", time_ns, &pitch(scenario));
        let transforms = robots.iter().flat_map(Robot::camera_frames).collect();
        sink.log("/tf_static", time_ns, &FrameTransforms { transforms });
        for robot in &robots {
            for mount in robot.cameras.mounts.iter() {
                let camera = robot.camera_frame(mount.name);
                let topic = format!("/{camera}/calibration");
                sink.log(&topic, time_ns, &calibration(&robot.cameras.intrinsics(mount), camera));
            }
        }
        let ball = scenario.ball.unwrap_or_default();
        let (cycle_s, sensed, next_message) = (scenario.cycle_s, Sensed::of(record), BTreeMap::new());
        let has_game = fields.is_all() || fields.names().iter().any(|name| name == "game");
        Self {
            robots,
            ball_radius_m: ball.radius_m,
            ball_look: ball.look,
            cycle_s,
            due: 0,
            drawn: None,
            has_game,
            has_percepts: fields.has("robots.percepts"),
            has_frames: RecordedFrames::of(fields),
            sensed,
            annotated: BTreeMap::new(),
            next_message,
        }
    }

    /// Writes a cycle. Images are taken from the world, if it has any.
    pub(in crate::record) fn write(&mut self, record: &CycleRecord, world: &World, sink: &mut impl ChannelSink) {
        let time_ns = nanoseconds(record.time_s);
        sink.log("/tf", time_ns, &frames(&self.robots, record, self.has_frames, time_ns));
        self.draw(record, time_ns, sink);
        let every = (1.0 / (SENSE_HZ * self.cycle_s)).round().max(1.0) as u64;
        let is_due = record.cycle >= self.due;
        if is_due {
            self.due = (record.cycle / every + 1) * every;
            if self.has_game {
                sink.log_json("/game", time_ns, &record.game);
            }
        }
        for robot in &record.robots {
            let id = robot.id;
            if let Some(command) = &robot.command
                && (is_due || command.kick.is_some() || command.posture.is_some())
            {
                sink.log_json(&format!("/{id}/command"), time_ns, command);
            }
            for message in &robot.inbox {
                let next = self.next_message.entry([id, message.from]).or_default();
                if record.cycle >= *next {
                    *next = record.cycle + every;
                    sink.log_json(&format!("/{id}/inbox"), time_ns, message);
                }
            }
            if is_due {
                self.write_senses(record, robot, time_ns, sink);
            }
        }
        for event in &record.events {
            write_event(record.time_s, event, sink);
        }
        self.write_images(record, world, sink);
        self.sensed = Sensed::of(record);
    }

    /// Draws robots and ball, if their looks have changed. They move with their frames.
    fn draw(&mut self, record: &CycleRecord, time_ns: u64, sink: &mut impl ChannelSink) {
        let penalised = record.robots.iter().filter(|robot| robot.penalised.is_some()).map(|robot| robot.id);
        let now = (penalised.collect::<Vec<_>>(), record.ball.iter().chain(record.more_balls()).count());
        let before = self.drawn.replace(now.clone());
        for robot in &self.robots {
            let is_penalised = now.0.contains(&robot.id);
            if before.as_ref().is_none_or(|(penalised, _)| penalised.contains(&robot.id) != is_penalised) {
                sink.log(&format!("/{}/body", robot.id), time_ns, &robot.drawn(is_penalised, time_ns));
            }
        }
        if before.is_none_or(|(_, balls)| balls != now.1) {
            sink.log("/ball", time_ns, &self.balls(now.1, time_ns));
        }
    }

    fn balls(&self, count: usize, time_ns: u64) -> SceneUpdate {
        scene((1..=count).map(|number| {
            let frame = ball_frame(number);
            let mut entity = Entity::new(&frame, &frame, time_ns).locked();
            entity.sphere(Vec3::ZERO, self.ball_radius_m, colour(ball::ground(self.ball_look), 1.0));
            entity
        }))
    }

    fn write_senses(&self, record: &CycleRecord, robot: &RobotRecord, time_ns: u64, sink: &mut impl ChannelSink) {
        let id = robot.id;
        if self.has_percepts {
            sink.log(&format!("/{id}/percepts"), time_ns, &percepts_scene(id, &robot.percepts));
        }
        if let Some(reported) = &robot.reported {
            sink.log_json(&format!("/{id}/reported"), time_ns, reported);
        }
        let Some(belief) = &robot.belief else { return };
        let own_end = record.game.own_end(id.team);
        sink.log(&format!("/{id}/belief"), time_ns, &belief_scene(id, belief, own_end, time_ns));
        let Some(pose) = self.sensed.pose(id).filter(|_| self.has_frames.poses) else { return };
        let others = record.robots.iter().filter(|other| other.id.team != id.team && other.penalised.is_none());
        let opponents: Vec<_> =
            others.filter_map(|other| Some((other.id, self.sensed.pose(other.id)?.position))).collect();
        let error = BeliefError::of(belief, &truth(pose, self.sensed.ball, &opponents, own_end), |_| ());
        sink.log_json(&format!("/{id}/belief_error"), time_ns, &ErrorOfBelief::from(error));
    }

    /// Writes the images that arrived in this cycle, if there are any, and the objects recognised in earlier ones.
    fn write_images(&mut self, record: &CycleRecord, world: &World, sink: &mut impl ChannelSink) {
        if !world.contains_resource::<Roster>() {
            return;
        }
        for robot in &self.robots {
            for mount in robot.cameras.mounts.iter() {
                let Some(([taken, arrived], image)) = newest_image(world, robot.id, mount.name) else { continue };
                if arrived != record.cycle {
                    continue;
                }
                let camera = robot.camera_frame(mount.name);
                // An image is taken at the start of its cycle.
                let taken_ns = nanoseconds(taken.saturating_sub(1) as f64 * self.cycle_s);
                let mut data = Vec::new();
                if let Err(error) = encode_png(&mut data, Layer::Colours, image) {
                    sink.fail(error);
                }
                let (topic, time_ns) = (format!("/{camera}/image"), nanoseconds(record.time_s));
                let (timestamp, format) = (timestamp(taken_ns), "png".to_owned());
                let message = CompressedImage { timestamp, frame_id: camera.clone(), data: data.into(), format };
                sink.log(&topic, time_ns, &message);
            }
        }
        for robot in 0..self.robots.len() {
            self.write_annotations(robot, record, world, sink);
        }
    }

    /// Writes the objects recognised in the images of a robot, when they arrive. They have the time of their image.
    fn write_annotations(&mut self, robot: usize, record: &CycleRecord, world: &World, sink: &mut impl ChannelSink) {
        let Robot { id, cameras, .. } = &self.robots[robot];
        let Some(seen) = record.robot(*id) else { return };
        let of_image = |mount: &&CameraMount| newest_image(world, *id, mount.name).is_some();
        let mounts: Vec<&CameraMount> = cameras.mounts.iter().filter(of_image).collect();
        let time_s = seen.percepts.time_s;
        if mounts.is_empty() || self.annotated.insert(*id, time_s) == Some(time_s) {
            return;
        }
        for mount in mounts {
            let topic = format!("/{}/annotations", self.robots[robot].camera_frame(mount.name));
            sink.log(&topic, nanoseconds(record.time_s), &annotations(mount.name, &seen.percepts));
        }
    }
}

/// Writes an event, and the referee's reasons for it.
fn write_event(time_s: f64, event: &MatchEvent, sink: &mut impl ChannelSink) {
    let Some((sentence, reasons)) = event_words(time_s, event) else { return };
    let level = match event {
        MatchEvent::Penalty { .. } => log::Level::Warning,
        _ => log::Level::Info,
    };
    let time_ns = nanoseconds(time_s);
    let message = core::iter::once(sentence).chain(reasons).collect::<Vec<_>>().join("\n");
    let name = event.kind();
    sink.log(
        "/events",
        time_ns,
        &Log { timestamp: timestamp(time_ns), level: level.into(), message, name, ..Log::default() },
    );
}

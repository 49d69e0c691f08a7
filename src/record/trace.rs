//! Traces: a match as lines of JSON, one a cycle, written as it goes.
//!
//! A line has the world after its cycle, and the sensor readings and messages that the robots had in it. Lengths are
//! in metres, angles in degrees within (-180, 180], places in the pitch frame but for percepts, which are in the
//! robot's.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::ball::{Ball, BallPhysics, BallVelocity};
use crate::behaviour::drawings::Drawings;
use crate::belief::Belief;
use crate::communication::{Inbox, MessageStatistics, ReceivedMessage};
use crate::cycle::{Cycle, CycleClock, CycleSystems};
use crate::events::{CycleEvents, MatchEvent};
use crate::game::{Game, GameState, Penalty, PenaltyReason, Score};
use crate::geometry::{Pose, file_units, to_degrees, wrapped_degrees};
use crate::robot::head::HeadAngles;
use crate::robot::posture::Posture;
use crate::robot::{Roster, Velocity};
use crate::scenario::Scenario;
use crate::sensing::odometry::Odometry;
use crate::sensing::sonar::SonarReading;
use crate::sensing::vision::Percepts;
use crate::simulation::sensors::{ReadingsAreRecorded, SensorRecord};
use crate::team::RobotId;

/// The format's name in the header.
pub const FORMAT: &str = "naoisis-trace";
/// The format's version in the header.
pub const VERSION: u32 = 1;
/// How hard a compressed trace is compressed. Lines that are much alike need no more: level 3 takes twice the time, and
/// the file is larger.
const COMPRESSION_LEVEL: i32 = 1;

/// Writes a line a cycle in [`CycleSystems::Record`] while there is a [`TraceRecorder`].
pub struct TracePlugin;

impl Plugin for TracePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ReadingsAreRecorded>()
            .add_systems(Cycle, record_cycle.in_set(CycleSystems::Record).run_if(resource_exists::<TraceRecorder>));
    }
}

/// Where a trace goes.
enum Sink {
    Plain(BufWriter<Box<dyn Write + Send + Sync>>),
    Compressed(zstd::stream::write::Encoder<'static, Box<dyn Write + Send + Sync>>),
}

/// A trace that is being written.
#[derive(Resource)]
pub struct TraceRecorder {
    sink: Sink,
    line: Vec<u8>,
    error: Option<io::Error>,
}

impl TraceRecorder {
    /// A trace into a writer, as plain lines.
    pub fn plain(writer: impl Write + Send + Sync + 'static) -> Self {
        Self::new(Sink::Plain(BufWriter::new(Box::new(writer))))
    }

    /// A trace into a new file; compressed if its name ends in `.zst`.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path) -> io::Result<Self> {
        let file: Box<dyn Write + Send + Sync> = Box::new(File::create(path)?);
        Ok(Self::new(if path.extension().is_some_and(|extension| extension == "zst") {
            Sink::Compressed(zstd::stream::write::Encoder::new(file, COMPRESSION_LEVEL)?)
        } else {
            Sink::Plain(BufWriter::new(file))
        }))
    }

    fn new(sink: Sink) -> Self {
        Self { sink, line: Vec::new(), error: None }
    }

    /// Writes the header.
    pub fn write_header(&mut self, scenario: &Scenario) {
        self.write(&Header { line_type: "header", format: FORMAT, version: VERSION, seed: scenario.seed, scenario });
    }

    /// Writes the last line and closes the trace.
    ///
    /// # Errors
    /// The first error that occurred while writing.
    pub fn finish(
        mut self,
        reason: EndReason,
        score: Score,
        cycles: u64,
        messages: MessageStatistics,
    ) -> io::Result<()> {
        self.write(&End { line_type: "end", reason, score, cycles, messages });
        match (self.error, self.sink) {
            (Some(error), _) => Err(error),
            (None, Sink::Plain(mut writer)) => writer.flush(),
            (None, Sink::Compressed(encoder)) => encoder.finish()?.flush(),
        }
    }

    /// The first error that occurred while writing; after it, nothing more is written.
    pub fn error(&self) -> Option<&io::Error> {
        self.error.as_ref()
    }

    fn write(&mut self, line: &impl Serialize) {
        if self.error.is_some() {
            return;
        }
        self.line.clear();
        let result = serde_json::to_writer(&mut self.line, line).map_err(io::Error::from).and_then(|()| {
            self.line.push(b'\n');
            // Whatever ends the program leaves every line readable. What was compressed before helps to compress what
            // follows, so that this makes a compressed trace 2 % larger.
            let writer: &mut dyn Write = match &mut self.sink {
                Sink::Plain(writer) => writer,
                Sink::Compressed(encoder) => encoder,
            };
            writer.write_all(&self.line)?;
            writer.flush()
        });
        self.error = result.err();
    }
}

/// Why a match ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum EndReason {
    /// The final whistle.
    FinalWhistle,
    /// The duration is over.
    #[default]
    Duration,
    /// The user or the system stopped the run.
    Interrupted,
    /// An error stopped the run.
    Failed,
}

#[derive(Serialize)]
struct Header<'a> {
    #[serde(rename = "type")]
    line_type: &'static str,
    format: &'static str,
    version: u32,
    seed: u64,
    scenario: &'a Scenario,
}

#[derive(Serialize)]
struct End {
    #[serde(rename = "type")]
    line_type: &'static str,
    reason: EndReason,
    score: Score,
    cycles: u64,
    messages: MessageStatistics,
}

/// A line of a trace: the world after a cycle.
#[derive(Serialize)]
pub struct CycleLine<'a> {
    #[serde(rename = "type")]
    line_type: &'static str,
    cycle: u64,
    time_s: f64,
    ball: Option<BallLine>,
    robots: Vec<RobotLine<'a>>,
    game: GameLine,
    events: &'a [MatchEvent],
}

#[derive(Serialize)]
struct BallLine {
    position_m: Vec3,
    velocity_mps: Vec3,
}

#[derive(Serialize)]
struct RobotLine<'a> {
    id: RobotId,
    #[serde(with = "file_units::pose")]
    pose: Pose,
    velocity: [f32; 3],
    head_deg: [f32; 2],
    #[serde(skip_serializing_if = "is_upright")]
    posture: Posture,
    penalised: Option<PenaltyLine>,
    #[serde(with = "file_units::pose")]
    odometry: Pose,
    sonar_m: SonarReading,
    percepts: &'a Percepts,
    inbox: &'a [ReceivedMessage],
    belief: Option<&'a Belief>,
    /// What sensors of the program's own read.
    #[serde(skip_serializing_if = "Option::is_none")]
    sensors: Option<&'a BTreeMap<String, Value>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drawings: Option<&'a Drawings>,
}

fn is_upright(posture: &Posture) -> bool {
    posture.is_upright()
}

#[derive(Serialize)]
struct PenaltyLine {
    reason: PenaltyReason,
    time_left_s: f64,
}

#[derive(Serialize)]
struct GameLine {
    state: GameState,
    score: Score,
    half: u32,
    time_left_s: Option<f64>,
}

/// What a system needs to make a line of the match as it is.
#[derive(SystemParam)]
pub struct MatchLine<'w, 's> {
    /// The match's clock.
    pub clock: Res<'w, CycleClock>,
    /// What happened in the cycle.
    pub events: Res<'w, CycleEvents>,
    roster: Res<'w, Roster>,
    game: Res<'w, Game>,
    balls: Query<'w, 's, (&'static Pose, &'static BallVelocity, &'static BallPhysics), With<Ball>>,
    robots: Query<
        'w,
        's,
        (
            &'static Pose,
            &'static Velocity,
            &'static HeadAngles,
            &'static Posture,
            &'static Penalty,
            &'static Odometry,
            &'static SonarReading,
            &'static Percepts,
            &'static Inbox,
            Option<&'static Belief>,
            Option<&'static Drawings>,
            Option<&'static SensorRecord>,
        ),
    >,
}

impl MatchLine<'_, '_> {
    /// The line of the cycle under way, or of the start.
    pub fn line(&self) -> CycleLine<'_> {
        let (clock, game) = (&self.clock, &self.game);
        CycleLine {
            line_type: "cycle",
            cycle: clock.cycle,
            time_s: clock.end_time_s(),
            ball: self.balls.iter().next().map(|(pose, velocity, physics)| BallLine {
                position_m: pose.position.extend(physics.radius_m),
                velocity_mps: velocity.0.extend(0.0),
            }),
            robots: self.roster.iter().filter_map(|(id, entity)| self.robot_line(id, entity)).collect(),
            game: GameLine {
                state: game.state,
                score: game.score,
                half: game.half,
                time_left_s: game.cycles_left.map(|cycles| cycles as f64 * clock.period_s),
            },
            events: &self.events,
        }
    }

    fn robot_line(&self, id: RobotId, entity: Entity) -> Option<RobotLine<'_>> {
        let (pose, velocity, head, posture, penalty, odometry, sonar, percepts, inbox, belief, drawings, sensors) =
            self.robots.get(entity).ok()?;
        Some(RobotLine {
            id,
            pose: *pose,
            velocity: [velocity.linear.x, velocity.linear.y, to_degrees(velocity.angular)],
            head_deg: [wrapped_degrees(head.yaw), wrapped_degrees(head.pitch)],
            posture: *posture,
            penalised: penalty.0.map(|active| PenaltyLine {
                reason: active.reason,
                time_left_s: active.cycles_left as f64 * self.clock.period_s,
            }),
            odometry: odometry.0,
            sonar_m: *sonar,
            percepts,
            inbox: &inbox.0,
            belief,
            sensors: sensors.map(SensorRecord::readings).filter(|readings| !readings.is_empty()),
            drawings: drawings.filter(|drawings| !drawings.is_empty()),
        })
    }
}

/// Writes the line of the cycle under way, or of the start.
pub fn record_cycle(mut recorder: ResMut<TraceRecorder>, now: MatchLine) {
    recorder.write(&now.line());
}

//! Compares beliefs with the truth: a table with a row for each robot ten times a second, and a summary at the end.

use bevy::prelude::*;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::output_file::OutputFile;
use super::recorder::{MatchEnd, RecordError, Recorder};
use naoisis_core::geometry::{Pose, to_degrees};
use naoisis_core::pitch::End;
use naoisis_core::statistics::{median, quantile};
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::covariance::{ELLIPSE_95, ELLIPSOID_95};
use naoisis_sensing::belief::error::{BeliefError, Truth};
use naoisis_sensing::belief::{point_team_from_pitch, team_from_pitch};
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// Rows for each robot per second.
const RATE_HZ: f64 = 10.0;

const HEADER: &str = "cycle,time_s,robot,position_error_m,heading_error_deg,pose_nees,ball_error_m,\
                      ball_velocity_error_mps,ball_nees,opponents,opponents_known,opponents_within_ellipse,\
                      opponent_error_m,false_tracks,realism";

/// Writes the table of errors, and collects the values for its summary.
pub struct BeliefRecorder {
    output: OutputFile,
    file: BufWriter<File>,
    /// Number of cycles from row to row.
    every: u64,
    /// The truth at the end of the previous cycle, when the robots sensed.
    sensed: Sensed,
    /// The match's level of realism, in words.
    realism: String,
    robots: Vec<RobotErrors>,
    error: Option<io::Error>,
}

/// The truth at the end of a cycle, which the robots without a penalty sense in the next one. It is compared with their beliefs of that
/// next cycle.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Sensed {
    /// Position (m) and velocity (m/s) of the ball, pitch frame.
    pub ball: Option<[Vec2; 2]>,
    poses: Vec<(RobotId, Pose)>,
}

impl Sensed {
    /// Reads the truth from `record`.
    pub fn of(record: &CycleRecord) -> Self {
        let on_pitch = record.robots.iter().filter(|robot| robot.penalised.is_none());
        Self {
            ball: record.ball.map(|ball| [ball.position_m, ball.velocity_mps].map(Vec3::truncate)),
            poses: on_pitch.map(|robot| (robot.id, robot.pose)).collect(),
        }
    }

    /// Returns the pose of robot `id`, pitch frame. Returns `None` if it did not sense.
    pub fn pose(&self, id: RobotId) -> Option<Pose> {
        self.poses.iter().find(|(other, _)| *other == id).map(|(_, pose)| *pose)
    }
}

/// The errors of one robot, or of all robots if `id` is `None`.
#[derive(Default)]
struct RobotErrors {
    id: Option<RobotId>,
    position_m: Vec<f64>,
    heading_deg: Vec<f64>,
    /// How often the truth was inside the 95 % ellipse, and how often there was an ellipse. The pose, the ball and the opponents have a
    /// pair each.
    pose_within: [u32; 2],
    ball_m: Vec<f64>,
    ball_velocity_mps: Vec<f64>,
    ball_within: [u32; 2],
    opponent_m: Vec<f64>,
    opponents_within: [u32; 2],
    false_tracks: u32,
    /// The opponents that the robot does not know, each with the time at which this began, s. The next field is the same for the ball.
    unknown_since_s: Vec<(RobotId, f64)>,
    ball_unknown_since_s: Option<f64>,
    detect_ball_s: Vec<f64>,
    detect_opponent_s: Vec<f64>,
}

impl BeliefRecorder {
    /// Creates a table in a file. It replaces an earlier file when the match is over.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        let output = OutputFile::create(path)?;
        let mut file = BufWriter::new(output.writer()?);
        let error = writeln!(file, "{HEADER}").err();
        Ok(Self {
            output,
            file,
            every: 1,
            sensed: Sensed::default(),
            realism: String::new(),
            robots: Vec::new(),
            error,
        })
    }

    fn write_rows(&mut self, record: &CycleRecord) -> io::Result<()> {
        let ball = self.sensed.ball;
        let present = || record.robots.iter().filter(|robot| robot.penalised.is_none());
        // A robot that is off the pitch is not expected to find anything.
        for robot in &mut self.robots {
            if present().all(|present| Some(present.id) != robot.id) {
                robot.ball_unknown_since_s = None;
                robot.unknown_since_s.clear();
            }
        }
        for robot in present() {
            let Some(belief) = &robot.belief else { continue };
            let opponents: Vec<(RobotId, Vec2)> = present()
                .filter(|other| other.id.team != robot.id.team)
                .filter_map(|other| Some((other.id, self.sensed.pose(other.id)?.position)))
                .collect();
            let Some(pose) = self.sensed.pose(robot.id) else { continue };
            let truth = truth(pose, ball, &opponents, record.game.own_end(robot.id.team));
            let mut known = vec![false; opponents.len()];
            let error = BeliefError::of(belief, &truth, |index| known[index] = true);
            let ball_known = belief.ball.is_some() || ball.is_none();
            self.note(robot.id, record.time_s, &error, ball_known, &opponents, &known);
            self.write(record.cycle, record.time_s, robot.id, &error)?;
        }
        Ok(())
    }

    fn write(&mut self, cycle: u64, time_s: f64, id: RobotId, error: &BeliefError) -> io::Result<()> {
        let cell = |value: Option<f32>| value.map(|value| format!("{value:.4}")).unwrap_or_default();
        writeln!(
            self.file,
            "{cycle},{time_s:.3},{id},{:.4},{:.3},{},{},{},{},{},{},{},{},{},\"{}\"",
            error.position_m,
            to_degrees(error.heading),
            cell(error.pose_nees),
            cell(error.ball.map(|ball| ball.position_m)),
            cell(error.ball.map(|ball| ball.velocity_mps)),
            cell(error.ball.and_then(|ball| ball.nees)),
            error.opponents,
            error.opponents_known,
            error.opponents_within,
            cell(error.opponent_m),
            error.false_tracks,
            self.realism,
        )
    }

    fn note(
        &mut self,
        id: RobotId,
        time_s: f64,
        error: &BeliefError,
        ball_known: bool,
        opponents: &[(RobotId, Vec2)],
        known: &[bool],
    ) {
        let index = self.robots.iter().position(|robot| robot.id == Some(id)).unwrap_or_else(|| {
            self.robots.push(RobotErrors { id: Some(id), ..default() });
            self.robots.len() - 1
        });
        let robot = &mut self.robots[index];
        robot.position_m.push(f64::from(error.position_m));
        robot.heading_deg.push(f64::from(to_degrees(error.heading)));
        count(&mut robot.pose_within, error.pose_nees, ELLIPSOID_95);
        if let Some(ball) = error.ball {
            robot.ball_m.push(f64::from(ball.position_m));
            robot.ball_velocity_mps.push(f64::from(ball.velocity_mps));
            count(&mut robot.ball_within, ball.nees, ELLIPSE_95);
        }
        robot.opponent_m.extend(error.opponent_m.map(f64::from));
        robot.opponents_within[0] += error.opponents_within;
        robot.opponents_within[1] += error.opponents_known;
        robot.false_tracks += error.false_tracks;
        match (ball_known, robot.ball_unknown_since_s) {
            (false, None) => robot.ball_unknown_since_s = Some(time_s),
            (true, Some(since)) => {
                robot.detect_ball_s.push(time_s - since);
                robot.ball_unknown_since_s = None;
            }
            _ => {}
        }
        robot.unknown_since_s.retain(|(other, _)| opponents.iter().any(|(id, _)| id == other));
        for ((other, _), known) in opponents.iter().zip(known) {
            let since = robot.unknown_since_s.iter().position(|(id, _)| id == other);
            match (known, since) {
                (false, None) => robot.unknown_since_s.push((*other, time_s)),
                (true, Some(index)) => {
                    let (_, since) = robot.unknown_since_s.swap_remove(index);
                    robot.detect_opponent_s.push(time_s - since);
                }
                _ => {}
            }
        }
    }
}

impl Recorder for BeliefRecorder {
    fn start(&mut self, scenario: &Scenario, record: &CycleRecord, _: &mut World) {
        self.sensed = Sensed::of(record);
        self.realism = scenario.realism_in_words();
        self.every = (1.0 / (RATE_HZ * scenario.cycle_s)).round().max(1.0) as u64;
    }

    fn record(&mut self, record: &CycleRecord, _: &mut World) {
        if self.error.is_none() && record.cycle.is_multiple_of(self.every) {
            self.error = self.write_rows(record).err();
        }
        self.sensed = Sensed::of(record);
    }

    fn has_failed(&self) -> bool {
        self.error.is_some()
    }

    /// Returns the summary: a line for each robot and one for all of them.
    fn finish(mut self: Box<Self>, _: &MatchEnd, _: &CycleRecord) -> Result<Option<String>, RecordError> {
        let written = self.error.take().map_or_else(|| self.file.flush(), Err);
        self.output.close(written)?;
        if self.robots.is_empty() {
            return Ok(Some("no robot has beliefs\n".to_owned()));
        }
        self.robots.sort_by_key(|robot| robot.id);
        if self.robots.len() > 1 {
            self.robots.push(RobotErrors::of_all(&self.robots));
        }
        let cells = self.robots.iter().map(RobotErrors::cells);
        Ok(Some(aligned(core::iter::once(COLUMNS.map(str::to_owned)).chain(cells))))
    }
}

/// The columns of the summary: medians and quantiles; the shares of the time in which the pose error is over 0.5 m and over 1 m; how often
/// the truth is inside the 95 % ellipse; and the mean number of false tracks.
const COLUMNS: [&str; 17] = [
    "robot", "position m", "90 %", "most", "over 0.5 m", "over 1 m", "heading deg", "90 %", "in 95 %", "ball m",
    "ball m/s", "in 95 %", "found after s", "opponent m", "in 95 %", "found after s", "false tracks",
];

/// Formats rows with aligned columns.
fn aligned(rows: impl Iterator<Item = [String; COLUMNS.len()]>) -> String {
    let rows: Vec<_> = rows.collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default();
    let widths: [usize; COLUMNS.len()] = core::array::from_fn(width);
    rows.iter()
        .map(|row| {
            let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
            cells.join("  ") + "\n"
        })
        .collect()
}

impl RobotErrors {
    /// Returns the errors of several robots together.
    fn of_all(robots: &[Self]) -> Self {
        let mut all = Self::default();
        for robot in robots {
            all.position_m.extend(&robot.position_m);
            all.heading_deg.extend(&robot.heading_deg);
            all.ball_m.extend(&robot.ball_m);
            all.ball_velocity_mps.extend(&robot.ball_velocity_mps);
            all.opponent_m.extend(&robot.opponent_m);
            all.detect_ball_s.extend(&robot.detect_ball_s);
            all.detect_opponent_s.extend(&robot.detect_opponent_s);
            all.false_tracks += robot.false_tracks;
            let counts = [
                (&mut all.pose_within, robot.pose_within),
                (&mut all.ball_within, robot.ball_within),
                (&mut all.opponents_within, robot.opponents_within),
            ];
            for ([inside, of_all], robot) in counts {
                *inside += robot[0];
                *of_all += robot[1];
            }
        }
        all
    }

    fn cells(&self) -> [String; COLUMNS.len()] {
        let number = |values: &[f64]| median(values.to_vec()).map_or("-".to_owned(), |value| format!("{value:.3}"));
        let share = |[inside, all]: [u32; 2]| match all {
            0 => "-".to_owned(),
            all => format!("{:.0} %", 100.0 * f64::from(inside) / f64::from(all)),
        };
        let at = |values: &[f64], share: f64, digits: usize| {
            format!("{:.digits$}", quantile(values.to_vec(), share).unwrap_or_default())
        };
        let over = |limit_m: f64| {
            let over = self.position_m.iter().filter(|error_m| **error_m > limit_m).count();
            format!("{:.1} %", 100.0 * over as f64 / self.position_m.len().max(1) as f64)
        };
        let rows = self.position_m.len().max(1) as f64;
        [
            self.id.map_or_else(|| "all".to_owned(), |id| id.to_string()),
            number(&self.position_m),
            at(&self.position_m, 0.9, 3),
            at(&self.position_m, 1.0, 2),
            over(0.5),
            over(1.0),
            number(&self.heading_deg),
            at(&self.heading_deg, 0.9, 2),
            share(self.pose_within),
            number(&self.ball_m),
            number(&self.ball_velocity_mps),
            share(self.ball_within),
            number(&self.detect_ball_s),
            number(&self.opponent_m),
            share(self.opponents_within),
            number(&self.detect_opponent_s),
            format!("{:.2}", f64::from(self.false_tracks) / rows),
        ]
    }
}

/// Returns the truth, in the frame of a team that defends `own_end`, for a comparison with the belief of its robot at `pose`.
pub(super) fn truth(pose: Pose, ball: Option<[Vec2; 2]>, opponents: &[(RobotId, Vec2)], own_end: End) -> Truth {
    let to_team = |place: Vec2| point_team_from_pitch(place, own_end);
    Truth {
        pose: team_from_pitch(pose, own_end),
        ball: ball.map(|[place, velocity]| [to_team(place), to_team(velocity)]),
        opponents: opponents.iter().map(|(_, place)| to_team(*place)).collect(),
    }
}

fn count([inside, all]: &mut [u32; 2], nees: Option<f32>, edge: f32) {
    if let Some(nees) = nees {
        *all += 1;
        *inside += u32::from(nees <= edge);
    }
}

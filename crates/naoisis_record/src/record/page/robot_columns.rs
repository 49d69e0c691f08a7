//! Writes what a robot saw, believed and wanted to columns.

use bevy::math::{Vec2, ops};

use super::columns::{About, Columns};
use super::strings::Strings;
use naoisis_core::behaviour::drawings::{DrawnShape, Frame};
use naoisis_core::geometry::{Pose, to_degrees};
use naoisis_core::pitch::End;
use naoisis_core::robot::posture::{LyingOn, Posture};
use naoisis_core::team::Team;
use naoisis_sensing::belief::covariance::half_axes_95;
use naoisis_sensing::belief::{Belief, PlaceCovariance, point_pitch_from_team};
use naoisis_sensing::sensing::vision::{LandmarkKind, Percepts};
use naoisis_sim::interface::cycle_record::RobotRecord;

/// Resolution of poses: m and degrees.
pub(super) const POSE_M: f64 = 0.005;
pub(super) const HEADING_DEG: f64 = 0.5;
/// Resolution of head angles, degrees.
const HEAD_DEG: f64 = 2.0;
/// Resolution of positions of the ball and of targets, of other robots, and of percepts, m.
const BALL_M: f64 = 0.02;
const ROBOT_M: f64 = 0.05;
const SEEN_M: f64 = 0.08;
/// Resolution of the half axes of ellipses: of the logarithm of their length in cm, and of their direction in degrees.
const AXIS_LOGARITHM: f32 = 0.15;
const AXIS_DEG: f64 = 15.0;
const LONGEST_AXIS: f32 = 50.0;
/// Resolution of walk commands: m/s and degrees/s.
const WALK_MPS: f64 = 0.05;
const TURN_DEGPS: f64 = 10.0;
/// Distance along each axis to which the positions of percepts are limited, m.
const FARTHEST_M: f32 = 20.0;
/// Length of a list that is left out of this sample: the page shows the previous one.
const LEFT_OUT: i32 = -1;

/// The data that are left out of the page, in ascending order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub(super) enum Thinning {
    /// Nothing.
    #[default]
    None,
    /// Landmarks in every other sample.
    Landmarks,
    /// All percepts except the ball in every other sample.
    Seen,
    /// All landmarks; other robots and posts, seen or believed, except in every fourth sample.
    Others,
}

impl Thinning {
    pub(super) fn next(self) -> Self {
        match self {
            Self::None => Self::Landmarks,
            Self::Landmarks => Self::Seen,
            Self::Seen | Self::Others => Self::Others,
        }
    }

    /// Returns the note on the page about what is left out.
    pub(super) fn words(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Landmarks => Some("the lines that robots saw are there 5 times a second"),
            Self::Seen => Some("what robots saw, but for the ball, is there 5 times a second"),
            Self::Others => Some(
                "the lines that robots saw are left out, and other robots and posts, seen or believed, are there 2.5 times a second",
            ),
        }
    }

    /// Returns whether a sample has landmarks.
    fn has_landmarks(self, sample: u64) -> bool {
        match self {
            Self::None => true,
            Self::Landmarks | Self::Seen => sample.is_multiple_of(2),
            Self::Others => false,
        }
    }

    /// Returns whether a sample has the robots and posts that were seen.
    fn has_seen(self, sample: u64) -> bool {
        match self {
            Self::None | Self::Landmarks => true,
            Self::Seen => sample.is_multiple_of(2),
            Self::Others => sample.is_multiple_of(4),
        }
    }

    /// Returns whether a sample has the believed other robots.
    fn has_believed(self, sample: u64) -> bool {
        self < Self::Others || sample.is_multiple_of(4)
    }
}

/// Adds the true state of the robot.
pub(super) fn add_truth(columns: &mut Columns, robot: &RobotRecord) {
    let about = About::Robot(robot.id);
    columns.add(about, "x", f64::from(robot.pose.position.x), POSE_M);
    columns.add(about, "y", f64::from(robot.pose.position.y), POSE_M);
    columns.add_heading(about, "h", f64::from(to_degrees(robot.pose.heading)), HEADING_DEG);
    columns.add(about, "yaw", f64::from(to_degrees(robot.head.yaw)), HEAD_DEG);
    columns.add(about, "pitch", f64::from(to_degrees(robot.head.pitch)), HEAD_DEG);
    let posture = match robot.posture {
        Posture::Upright => 0,
        Posture::Fallen { on: LyingOn::Front, .. } => 1,
        Posture::Fallen { on: LyingOn::Back, .. } => 2,
        Posture::GettingUp { .. } => 3,
        Posture::Diving { .. } => 4,
    };
    columns.push(about, "s", posture + 8 * i32::from(robot.penalised.is_some()));
}

/// Adds the percepts of the robot, which sensed from the pose `sensed`.
pub(super) fn add_percepts(columns: &mut Columns, robot: &RobotRecord, sensed: Pose, thinning: Thinning, sample: u64) {
    let about = About::Robot(robot.id);
    let Percepts { ball, goal_posts, robots, landmarks, .. } = &robot.percepts;
    let far = Vec2::splat(FARTHEST_M);
    let place = |seen: Vec2| sensed.transform_point(seen.clamp(-far, far));
    columns.push(about, "v", i32::from(ball.is_some()));
    if let Some(ball) = ball {
        add_place(columns, about, ["vx", "vy"], place(ball.position_m), BALL_M);
    }
    if thinning.has_seen(sample) {
        columns.push(about, "t", (goal_posts.len() + robots.len()) as i32);
        let posts = goal_posts.iter().map(|post| (0, post.position_m));
        let kind = |team| if team == Team::Blue { 1 } else { 2 };
        for (kind, seen) in posts.chain(robots.iter().map(|robot| (kind(robot.team), robot.position_m))) {
            columns.push(about, "tk", kind);
            add_place(columns, about, ["tx", "ty"], place(seen), SEEN_M);
        }
    } else {
        columns.push(about, "t", LEFT_OUT);
    }
    if thinning.has_landmarks(sample) {
        columns.push(about, "l", landmarks.len() as i32);
        for landmark in landmarks {
            let kind = match landmark.kind {
                LandmarkKind::Line { .. } => 4,
                LandmarkKind::Junction { .. } => 5,
                LandmarkKind::PenaltyCross => 6,
                LandmarkKind::CentreCircle => 7,
                LandmarkKind::CornerArc => 8,
            };
            columns.push(about, "lk", kind);
            add_place(columns, about, ["lx", "ly"], place(landmark.position_m), SEEN_M);
            if let LandmarkKind::Line { end_position_m, .. } = landmark.kind {
                add_place(columns, about, ["ex", "ey"], place(end_position_m), SEEN_M);
            }
        }
    } else {
        let is_all = thinning == Thinning::Others;
        columns.push(about, "l", if is_all { 0 } else { LEFT_OUT });
    }
}

/// Adds the belief of the robot, whose team defends `own_end`.
pub(super) fn add_belief(columns: &mut Columns, robot: &RobotRecord, own_end: End, thinning: Thinning, sample: u64) {
    let about = About::Robot(robot.id);
    columns.push(about, "b", i32::from(robot.belief.is_some()));
    let Some(belief) = &robot.belief else {
        ["o", "m", "p"].into_iter().for_each(|quantity| columns.push(about, quantity, 0));
        return;
    };
    let Belief { pose_covariance: [xx, xy, yy, ..], ball, team_mates, opponents, .. } = belief;
    let pose = belief.pose_in_pitch(own_end);
    let place = |place| point_pitch_from_team(place, own_end);
    add_place(columns, about, ["bx", "by"], pose.position, POSE_M);
    columns.add_heading(about, "bh", f64::from(to_degrees(pose.heading)), HEADING_DEG);
    add_ellipse(columns, about, ["ba", "bb", "bc"], [*xx, *xy, *yy]);
    let source = ball.map_or(0, |ball| 1 + i32::from(ball.heard_from.is_some()));
    columns.push(about, "o", source);
    if let Some(ball) = ball {
        add_place(columns, about, ["ox", "oy"], place(ball.position_m), BALL_M);
        add_ellipse(columns, about, ["oa", "ob", "oc"], ball.position_covariance);
    }
    if !thinning.has_believed(sample) {
        columns.push(about, "m", LEFT_OUT);
        columns.push(about, "p", LEFT_OUT);
        return;
    }
    columns.push(about, "m", team_mates.len() as i32);
    for mate in team_mates {
        add_place(columns, about, ["mx", "my"], place(mate.position_m), ROBOT_M);
        add_ellipse(columns, about, ["ma", "mb", "mc"], mate.covariance);
    }
    columns.push(about, "p", opponents.len() as i32);
    for opponent in opponents {
        add_place(columns, about, ["px", "py"], place(opponent.position_m), ROBOT_M);
        add_ellipse(columns, about, ["pa", "pb", "pc"], opponent.covariance);
    }
}

/// Adds the robot's intention, its walk command, and the target that its behaviour draws.
pub(super) fn add_wish(columns: &mut Columns, strings: &mut Strings, robot: &RobotRecord, own_end: End, cycle_s: f64) {
    let about = About::Robot(robot.id);
    let command = robot.command.as_ref();
    columns.push(about, "i", strings.place(robot.intention().unwrap_or_default()));
    let walk = command.and_then(|command| command.walk).unwrap_or_default();
    columns.add(about, "wx", f64::from(walk.dx) / cycle_s, WALK_MPS);
    columns.add(about, "wy", f64::from(walk.dy) / cycle_s, WALK_MPS);
    columns.add(about, "wt", f64::from(to_degrees(walk.dtheta)) / cycle_s, TURN_DEGPS);
    let target = robot.drawings.iter().find_map(|drawing| match &drawing.shape {
        DrawnShape::Target { position_m, words } => Some((drawing.frame, *position_m, words)),
        _ => None,
    });
    // The index of its words in the list of strings, from 1; 0 without a target.
    columns.push(about, "g", target.map_or(0, |(_, _, words)| 1 + strings.place(words)));
    if let Some((frame, place, _)) = target {
        let place = match frame {
            Frame::Team => point_pitch_from_team(place, own_end),
            Frame::Robot => robot.pose.transform_point(place),
        };
        add_place(columns, about, ["gx", "gy"], place, BALL_M);
    }
}

fn add_place(columns: &mut Columns, about: About, [x, y]: [&'static str; 2], place: Vec2, unit: f64) {
    columns.add(about, x, f64::from(place.x), unit);
    columns.add(about, y, f64::from(place.y), unit);
}

/// Adds the 95 % ellipse: its half axes and the direction of the longer one.
fn add_ellipse(columns: &mut Columns, about: About, names: [&'static str; 3], covariance: PlaceCovariance) {
    let [long, short] = half_axes_95(covariance).unwrap_or_default();
    let logarithm = |axis: Vec2| (ops::ln((100.0 * axis.length()).max(1.0)) / AXIS_LOGARITHM).round().min(LONGEST_AXIS);
    columns.push(about, names[0], logarithm(long) as i32);
    columns.push(about, names[1], logarithm(short) as i32);
    columns.add(about, names[2], f64::from(to_degrees(ops::atan2(long.y, long.x))), AXIS_DEG);
}

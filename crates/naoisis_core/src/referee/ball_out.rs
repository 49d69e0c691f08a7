//! The ball out of play, and the throw-in (2010 rule book, section 3.9).

use bevy::prelude::*;

use super::boundary::{Boundary, Crossing};
use super::snapshot::MatchSnapshot;
use crate::events::BoundaryLine;
use crate::game::Evidence;
use crate::pitch::{End, Pitch};
use crate::team::Team;

/// Distance of the throw-in lines inside the side lines, m.
const THROW_IN_INSET: f32 = 0.4;
/// Distance of the ends of the throw-in lines from the goal lines, m: on the pitch of 2010 the throw-in lines are 4 m long.
const THROW_IN_END: f32 = 1.0;
/// Distance by which a ball is thrown in farther back, m.
const THROW_IN_BACK: f32 = 1.0;

/// A ball out of play.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BallOut {
    /// The line.
    pub line: BoundaryLine,
    /// The end of the goal line, or of the half in which the side line was crossed.
    pub end: End,
    /// Position, m, pitch frame.
    pub position: Vec2,
    /// The team that touched the ball last.
    pub last_touch: Option<Team>,
    /// The team of the restart: the one that did not touch the ball last. Without a touch, the one that defends the half in which the ball
    /// went out.
    pub restart_team: Team,
}

/// The ball out of play for a crossing; `None` if it is a goal or the rules have no outs. If goals do not count, a ball in the goal is out.
pub fn judge(snapshot: &MatchSnapshot, crossing: &Crossing) -> Option<BallOut> {
    if !snapshot.rules.ball_out {
        return None;
    }
    let half = if crossing.position.x > 0.0 { End::PositiveX } else { End::NegativeX };
    let (line, end) = match crossing.boundary {
        Boundary::Goal(_) if snapshot.rules.goals => return None,
        Boundary::Goal(end) | Boundary::GoalLine(end) => (BoundaryLine::Goal, end),
        Boundary::SideLine => (BoundaryLine::Side, half),
    };
    let last_touch = snapshot.last_touch.map(|touch| touch.robot.team);
    let restart_team = last_touch.map_or(snapshot.game.defender_of(half), Team::opponent);
    Some(BallOut { line, end, position: crossing.position, last_touch, restart_team })
}

/// The evidence that the ball is out, with the team of the restart.
pub fn evidence(snapshot: &MatchSnapshot, out: &BallOut) -> Evidence {
    let edges = snapshot.pitch.outer_half_extents();
    let radius = snapshot.ball.map_or(0.0, |ball| ball.radius);
    let (what, value, limit) = match out.line {
        BoundaryLine::Side => ("m of the ball's rear from the middle of the pitch", out.position.y.abs(), edges.y),
        BoundaryLine::Goal => ("m of the ball's rear from the halfway line", out.position.x.abs(), edges.x),
    };
    let mut evidence = snapshot
        .evidence(
            "The ball is out when the whole of it has passed the outer edge of a line; the team that did not touch it \
         last restarts.",
            out.position,
        )
        .with_measurement(what, value - radius, limit);
    match snapshot.last_touch {
        Some(touch) => {
            if let Some(index) = snapshot.robot_index(touch.robot) {
                evidence = evidence.with_robot(snapshot.robots[index].evidence());
            }
            evidence.otherwise(format!("A last touch by {} would have turned it round.", touch.robot.team.opponent()))
        }
        None => evidence.otherwise("Nobody had touched it: a touch by either team would have decided."),
    }
}

/// The position at which the ball is thrown in: on a line 40 cm inside the side line over which the ball went out, or which is nearer, and
/// at least 1 m from the goal lines. 'Back' is towards the goal of the team that touched the ball last.
///
/// - Over a side line: 1 m back from the point of leaving or from the robot that touched the ball, whichever is farther back.
/// - Over the goal line of the team that touched the ball: the near end of the throw-in line.
/// - Over the other goal line: 1 m back from the robot, or the halfway line, whichever is farther back.
///
/// If no robot touched the ball, it is thrown in level with the point of leaving, or at the near end of the line.
pub(crate) fn throw_in_place(snapshot: &MatchSnapshot, out: &BallOut) -> Vec2 {
    let most = throw_in_half_length(snapshot.pitch);
    let y = (snapshot.pitch.half_width() - THROW_IN_INSET).copysign(out.position.y);
    let Some(touch) = snapshot.last_touch else {
        return Vec2::new(out.position.x.clamp(-most, most), y);
    };
    let own_end = snapshot.game.own_end(touch.robot.team);
    let back = own_end.sign();
    let farther_back = |a: f32, b: f32| if a * back > b * back { a } else { b };
    let behind_robot = touch.robot_position.x + back * THROW_IN_BACK;
    let x = match out.line {
        BoundaryLine::Side => farther_back(out.position.x + back * THROW_IN_BACK, behind_robot),
        BoundaryLine::Goal if out.end == own_end => back * most,
        BoundaryLine::Goal => farther_back(0.0, behind_robot),
    };
    Vec2::new(x.clamp(-most, most), y)
}

fn throw_in_half_length(pitch: &Pitch) -> f32 {
    (pitch.half_length() - THROW_IN_END).max(0.0)
}

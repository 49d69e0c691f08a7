//! Free kicks: kick-in, goal kick, corner kick, pushing free kick (2025 rule book, sections 3.8 and 3.9), and the kick-off while the
//! ball belongs to the kicking team.
//!
//! Play continues, but for a time the ball belongs to one team, and the other team must keep away from it. The free kick is over when that
//! team has clearly moved the ball, or after that time.

use bevy::prelude::*;

use super::areas::{in_team_frame, touches_area, touches_goal_line};
use super::ball_out::BallOut;
use super::memory::RobotMemory;
use super::penalty_kick;
use super::positions::kick_off_player;
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::events::BoundaryLine;
use crate::game::{Evidence, SetPlay, SetPlayKind};
use crate::pitch::End;
use crate::team::Team;

/// Distance from which the ball counts as clearly moved, m.
pub(super) const MOVED_CLEARLY_M: f32 = 0.05;
/// Time for which a defender may be at an illegal position, s: the referee does not measure distances exactly.
const TOLERANCE_S: f32 = 1.0;

/// The state of a free kick after a cycle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Course {
    /// The free kick has not been taken yet.
    Waiting(SetPlay),
    /// The free kick has not been taken yet; the other team moved the ball, which is put back.
    BallBack(SetPlay),
    /// The free kick was taken.
    Taken,
    /// The free kick was not taken in time.
    TimeOver,
}

/// The free kick one cycle later.
pub fn advance(set_play: SetPlay, snapshot: &MatchSnapshot) -> Course {
    let touched = set_play.touched || snapshot.touches.iter().any(|(robot, _)| robot.team == set_play.team);
    let next = SetPlay { touched, ..set_play.later(true) };
    let moved = snapshot.ball.is_some_and(|ball| ball.position.distance(set_play.ball_m) > MOVED_CLEARLY_M);
    // A penalty kick is over with the first touch, even if the ball does not move clearly.
    if touched && (moved || set_play.kind == SetPlayKind::PenaltyKick) {
        Course::Taken
    } else if next.cycles_left == 0 {
        Course::TimeOver
    } else if moved {
        Course::BallBack(next)
    } else {
        Course::Waiting(next)
    }
}

/// The kind of the free kick after a ball out, and the position of the ball.
pub(crate) fn for_ball_out(snapshot: &MatchSnapshot, out: &BallOut) -> (SetPlayKind, Vec2) {
    let pitch = snapshot.pitch;
    let side = if out.position.y < 0.0 { -1.0 } else { 1.0 };
    match out.line {
        BoundaryLine::Side => {
            let x = out.position.x.clamp(-pitch.half_length(), pitch.half_length());
            (SetPlayKind::KickIn, Vec2::new(x, side * pitch.half_width()))
        }
        BoundaryLine::Goal if snapshot.game.defender_of(out.end) == out.restart_team => {
            (SetPlayKind::GoalKick, goal_kick_place(snapshot, out.restart_team, out.position.y))
        }
        BoundaryLine::Goal => (SetPlayKind::CornerKick, corner(snapshot, out.end, out.position.y)),
    }
}

/// The corner at `end`, on the side given by the sign of `y`.
pub(crate) fn corner(snapshot: &MatchSnapshot, end: End, y: f32) -> Vec2 {
    let side = if y < 0.0 { -1.0 } else { 1.0 };
    Vec2::new(end.sign() * snapshot.pitch.half_length(), side * snapshot.pitch.half_width())
}

/// The corner of the goal area (or penalty area) of `team`, on the side given by the sign of `y`.
pub(crate) fn goal_kick_place(snapshot: &MatchSnapshot, team: Team, y: f32) -> Vec2 {
    let pitch = snapshot.pitch;
    let area = pitch.goal_area.unwrap_or(pitch.penalty_area);
    let side = if y < 0.0 { -1.0 } else { 1.0 };
    let x = snapshot.game.own_end(team).sign() * (pitch.half_length() - area.depth_m);
    Vec2::new(x, side * area.width_m / 2.0)
}

/// The position of an indirect free kick of `team` for an offence at `place`. If the rules place it outside the opponents' penalty area, it
/// is the nearest point of the area's line that is parallel to the goal line.
pub(crate) fn indirect_free_kick_place(snapshot: &MatchSnapshot, team: Team, place: Vec2) -> Vec2 {
    let (pitch, end) = (snapshot.pitch, snapshot.game.own_end(team.opponent()));
    if !snapshot.rules.indirect_free_kick_at_area_line || !pitch.in_penalty_area(end, place) {
        return place;
    }
    let half_width = pitch.penalty_area.width_m / 2.0;
    Vec2::new(end.sign() * (pitch.half_length() - pitch.penalty_area.depth_m), place.y.clamp(-half_width, half_width))
}

/// Counts the cycles for which a robot of the other team has been at an illegal position in a free kick. The time to leave does not count,
/// unless the robot has been at a legal position since the call: a robot that comes back is not leaving.
pub(crate) fn note_encroachment(
    record: &mut RobotMemory,
    set_play: &SetPlay,
    snapshot: &MatchSnapshot,
    robot: &RobotSnapshot,
) {
    let leave_s = match set_play.kind {
        SetPlayKind::KickOff | SetPlayKind::PenaltyKick => 0.0,
        _ => snapshot.rules.free_kick_leave_s,
    };
    let encroaches = encroaches(set_play, snapshot, robot);
    record.has_kept_away |= !encroaches;
    let counts = encroaches && (record.has_kept_away || set_play.cycles >= snapshot.cycles(leave_s));
    record.cycles_encroaching = if counts { record.cycles_encroaching + 1 } else { 0 };
}

/// Whether a robot is at an illegal position. At a kick-off only the taker may be in the other half, no farther than within the circle; the
/// other team must also be outside the circle. At a free kick the other team must keep away from the ball.
fn encroaches(set_play: &SetPlay, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    if set_play.kind == SetPlayKind::PenaltyKick {
        return penalty_kick::encroaches(set_play, snapshot, robot);
    }
    let is_theirs = robot.id.team == set_play.team;
    match set_play.kind {
        SetPlayKind::KickOff => {
            let own_end = snapshot.game.own_end(robot.id.team);
            let is_ahead = in_team_frame(own_end, robot.pose.position).x > 0.0;
            let in_circle = robot.pose.position.length() < snapshot.pitch.centre_circle_diameter_m / 2.0;
            if is_theirs {
                is_ahead && !(in_circle && kick_off_player(snapshot, set_play.team) == Some(robot.id))
            } else {
                is_ahead || in_circle
            }
        }
        _ if is_theirs => false,
        _ => is_too_near(set_play, snapshot, robot) || is_in_cleared_area(set_play, snapshot, robot),
    }
}

/// Whether a robot is in the penalty area that it has to leave, as a free kick is taken from there.
fn is_in_cleared_area(set_play: &SetPlay, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let (pitch, end) = (snapshot.pitch, snapshot.game.own_end(set_play.team));
    snapshot.rules.goal_kick_clears_area
        && pitch.in_penalty_area(end, set_play.ball_m)
        && touches_area(pitch, pitch.penalty_area, end, robot)
}

/// Whether a robot is nearer to the ball of a free kick than it may be.
fn is_too_near(set_play: &SetPlay, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let (rules, pitch) = (snapshot.rules, snapshot.pitch);
    let place = robot.pose.position;
    let on_own_line = rules.free_kick_distance_m.is_none()
        && place.y.abs() < pitch.goal.width_m / 2.0
        && touches_goal_line(pitch, snapshot.game.own_end(robot.id.team), robot);
    !on_own_line && place.distance(set_play.ball_m) < rules.free_kick_radius_m(pitch)
}

/// Returns how far a place is inside the penalty area of the team that takes a free kick, m; 0 outside.
fn metres_inside_area(set_play: &SetPlay, snapshot: &MatchSnapshot, place: Vec2) -> f32 {
    let (pitch, end) = (snapshot.pitch, snapshot.game.own_end(set_play.team));
    let along = end.sign() * place.x - (pitch.half_length() - pitch.penalty_area.depth_m);
    along.min(pitch.penalty_area.width_m / 2.0 - place.y.abs()).max(0.0)
}

const KEEP_AWAY: &str =
    "During a free kick and before the ball is in play at a kick-off, the other team keeps away from it.";

/// The evidence against a robot that was at an illegal position for too long, or that touched the other team's ball.
pub fn judge(cycles: u64, set_play: &SetPlay, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    let is_theirs = robot.id.team == set_play.team;
    if is_theirs && !matches!(set_play.kind, SetPlayKind::PenaltyKick | SetPlayKind::KickOff) {
        return None;
    }
    // Who was at the ball when the free kick was called cannot have left it at once.
    let may_know = set_play.kind == SetPlayKind::KickOff || set_play.cycles >= snapshot.cycles(TOLERANCE_S);
    let touched = !is_theirs && may_know && snapshot.touches.iter().any(|(toucher, _)| *toucher == robot.id);
    let too_long = cycles > snapshot.cycles(TOLERANCE_S);
    // The last place counts: a robot that is far enough from the ball was penalised for being in the area.
    let of_area = !touched && !is_too_near(set_play, snapshot, robot) && is_in_cleared_area(set_play, snapshot, robot);
    (touched || too_long).then(|| {
        let rule = match set_play.kind {
            SetPlayKind::PenaltyKick => {
                "During a penalty kick only one attacker, and the keeper on its line, may be in the penalty area."
            }
            SetPlayKind::KickOff if is_theirs => {
                "Before the ball is in play at a kick-off, the team that takes it stays in its own half; one robot may be in the circle."
            }
            SetPlayKind::KickOff => KEEP_AWAY,
            _ if of_area => "During a free kick from inside a penalty area, the other team stays outside this area.",
            _ => KEEP_AWAY,
        };
        let place = robot.pose.position;
        let radius = snapshot.pitch.centre_circle_diameter_m / 2.0;
        let ahead = in_team_frame(snapshot.game.own_end(robot.id.team), place).x;
        let (quantity, value, limit) = match set_play.kind {
            SetPlayKind::KickOff if place.length() >= radius && ahead > 0.0 => ("m into the other half", ahead, 0.0),
            SetPlayKind::KickOff => ("m from the centre mark", place.length(), radius),
            _ if of_area => ("m inside the penalty area", metres_inside_area(set_play, snapshot, place), 0.0),
            _ => ("m from the ball", place.distance(set_play.ball_m), snapshot.rules.free_kick_radius_m(snapshot.pitch)),
        };
        snapshot.evidence_against(rule, robot).with_measurement(quantity, value, limit).otherwise(if touched {
            "It must not touch the ball."
        } else if is_theirs {
            "It had to wait until the ball had moved clearly, or was free."
        } else {
            "It had to stay away, or leave in time."
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::referee::testing::MatchFixture;
    use crate::team::RobotId;

    #[test]
    fn the_evidence_measures_what_the_robot_did() {
        let [x, y] = [-2.6, 0.9];
        let mut situation = MatchFixture::three_a_side();
        situation.rules.goal_kick_clears_area = true;
        situation.rules.free_kick_distance_m = Some(0.75);
        let mut set_play = SetPlay::new(SetPlayKind::GoalKick, Team::Blue, Vec2::new(x, y), 900);
        set_play.cycles = 1000;
        let pink = RobotId::new(Team::Pink, 2);
        for (place, what, value) in
            [([x + 0.5, y], "m from the ball", 0.5), ([-2.7, -0.8], "m inside the penalty area", 0.3)]
        {
            situation = situation.robot_at(pink, Pose::new(place[0], place[1], 0.0));
            let robot = *situation.robot_mut(pink);
            let evidence = judge(1000, &set_play, &situation.snapshot(), &robot).unwrap();
            let measured = evidence.measured.unwrap();
            assert_eq!(measured.what, what);
            assert!((measured.value - value).abs() < 1e-4, "{measured:?}");
        }
    }
}

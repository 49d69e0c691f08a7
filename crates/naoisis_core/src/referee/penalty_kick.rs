//! The penalty kick (2025 rule book, section 3.10): for a push near the ball in the pusher's own penalty area. Robots have some time to
//! walk to their positions (`ready`), wait there (`set`), and then one attacker plays the ball from the penalty mark against the keeper on
//! its goal line; no other robot is in the penalty area. The penalty kick is over as soon as the attackers have touched the ball, or their
//! time is over.

use bevy::prelude::*;

use super::areas::{in_goal, penalty_mark, touches_area, touches_goal_line};
use super::positions::{IllegalPosition, is_off_pitch};
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::{Evidence, SetPlay};
use crate::pitch::End;
use crate::team::Team;

/// The end whose goal a penalty kick of `team` is at.
pub fn end(snapshot: &MatchSnapshot, team: Team) -> End {
    snapshot.game.own_end(team.opponent())
}

/// Whether any part of a robot is in the penalty area of a penalty kick of `team`.
fn is_in_area(snapshot: &MatchSnapshot, team: Team, robot: &RobotSnapshot) -> bool {
    touches_area(snapshot.pitch, snapshot.pitch.penalty_area, end(snapshot, team), robot)
}

/// Whether a robot is where only the goalkeeper and the kicker may be at a penalty kick of `team`: in the penalty area, and if the rules say
/// so, ahead of the mark or within the distance of a free kick from it.
fn is_in_the_way(snapshot: &MatchSnapshot, team: Team, robot: &RobotSnapshot) -> bool {
    is_in_area(snapshot, team, robot) || is_near_mark(snapshot, team, robot)
}

/// Whether a robot is ahead of the mark, or within the distance of a free kick from it, if the rules of a penalty kick require a distance.
fn is_near_mark(snapshot: &MatchSnapshot, team: Team, robot: &RobotSnapshot) -> bool {
    if !snapshot.rules.penalty_kick_behind_mark {
        return false;
    }
    let end = end(snapshot, team);
    let mark = penalty_mark(snapshot.pitch, end);
    let place = robot.pose.position;
    let distance_m = snapshot.rules.free_kick_radius_m(snapshot.pitch);
    end.sign() * (place.x - mark.x) > 0.0 || place.distance(mark) < distance_m
}

/// Whether the robot is the only one of its team that may be in the penalty area: the one nearest to the mark that does not stand on the
/// mark.
fn is_kicker(snapshot: &MatchSnapshot, team: Team, robot: &RobotSnapshot) -> bool {
    let mark = penalty_mark(snapshot.pitch, end(snapshot, team));
    let others = snapshot.robots.iter().filter(|other| {
        other.is_present()
            && other.id.team == team
            && is_in_the_way(snapshot, team, other)
            && !blocks(snapshot, mark, other)
    });
    let nearest = others.min_by(|a, b| a.pose.position.distance(mark).total_cmp(&b.pose.position.distance(mark)));
    nearest.is_some_and(|nearest| nearest.id == robot.id)
}

/// Whether the robot stands on the mark.
fn blocks(snapshot: &MatchSnapshot, mark: Vec2, robot: &RobotSnapshot) -> bool {
    let radius = snapshot.ball.map_or(0.0, |ball| ball.radius);
    robot.bounds.base.footprint(robot.pose).overlap_disc(mark, radius).is_some()
}

/// The illegal position of each robot when the `set` of a penalty kick of `team` begins: one entry for each robot, `None` if it is legal or
/// the robot is penalised. A goalkeeper ahead of its line is put back instead.
pub(crate) fn illegal_positions(snapshot: &MatchSnapshot, team: Team) -> impl Iterator<Item = Option<IllegalPosition>> {
    let mark = penalty_mark(snapshot.pitch, end(snapshot, team));
    snapshot.robots.iter().map(move |robot| {
        if !robot.is_present() {
            return None;
        }
        let own_end = snapshot.game.own_end(robot.id.team);
        if is_off_pitch(snapshot, robot) && !in_goal(snapshot.pitch, own_end, robot.pose.position) {
            return Some(IllegalPosition::OffPitch);
        }
        let may_be_in_area = if robot.id.team == team {
            if blocks(snapshot, mark, robot) {
                return Some(IllegalPosition::OnPenaltyMark);
            }
            is_kicker(snapshot, team, robot)
        } else {
            snapshot.game.is_goalkeeper(robot.id)
        };
        if may_be_in_area {
            None
        } else if is_in_area(snapshot, team, robot) {
            Some(IllegalPosition::InPenaltyAreaAtKick)
        } else {
            is_near_mark(snapshot, team, robot).then_some(IllegalPosition::NearPenaltyMark)
        }
    })
}

/// Whether a robot is at an illegal position while the ball belongs to the attackers.
pub(crate) fn encroaches(set_play: &SetPlay, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let team = set_play.team;
    is_in_the_way(snapshot, team, robot)
        && if robot.id.team == team {
            !is_kicker(snapshot, team, robot) && !blocks(snapshot, set_play.ball_m, robot)
        } else {
            !(snapshot.game.is_goalkeeper(robot.id) && keeps_its_line(snapshot, team, robot))
        }
}

/// The index of a goalkeeper in its penalty area that is off its line, or not on its feet, at a penalty kick of `team`.
pub(crate) fn keeper_off_its_line(snapshot: &MatchSnapshot, team: Team) -> Option<usize> {
    snapshot.robots.iter().position(|robot| {
        robot.is_present()
            && robot.id.team != team
            && snapshot.game.is_goalkeeper(robot.id)
            && is_in_area(snapshot, team, robot)
            && !keeps_its_line(snapshot, team, robot)
    })
}

/// The evidence against a goalkeeper that has left its line, or its feet, before the attackers touched the ball.
pub(crate) fn keeper_left_too_early(penalty_kick: &SetPlay, snapshot: &MatchSnapshot) -> Option<Evidence> {
    let index = keeper_off_its_line(snapshot, penalty_kick.team).filter(|_| !penalty_kick.touched)?;
    let keeper = &snapshot.robots[index];
    let rule = "Until the attackers touch the ball, the keeper stays on its feet and in contact with the goal line.";
    Some(snapshot.evidence_against(rule, keeper).otherwise("It had to wait for that touch."))
}

/// Whether the goalkeeper is upright and in contact with the goal line.
fn keeps_its_line(snapshot: &MatchSnapshot, team: Team, keeper: &RobotSnapshot) -> bool {
    keeper.posture.is_upright() && touches_goal_line(snapshot.pitch, end(snapshot, team), keeper)
}

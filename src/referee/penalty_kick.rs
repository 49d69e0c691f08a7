//! The penalty kick (2025 rule book, section 3.10): for a push near the ball in the pusher's own penalty area. Robots have a time
//! to get to their places (`ready`), wait there (`set`), and then one attacker plays the ball from the penalty mark against the
//! keeper on its goal line; nobody else is in the penalty area. It is over as soon as the attackers have touched the ball, or
//! their time is.

use bevy::prelude::*;

use super::areas::{in_goal, penalty_mark, touches_area, touches_goal_line};
use super::decide::Referee;
use super::indirect_goal::Plays;
use super::placing::Occupied;
use super::positions::{IllegalPosition, is_off_pitch};
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::events::MatchEvent;
use crate::game::{GameState, SetPlay, SetPlayKind};
use crate::geometry::Pose;
use crate::pitch::End;
use crate::team::Team;

/// The end whose goal a penalty kick of `team` is at.
fn end(snapshot: &MatchSnapshot, team: Team) -> End {
    snapshot.game.own_end(team.opponent())
}

fn is_in_area(snapshot: &MatchSnapshot, team: Team, robot: &RobotSnapshot) -> bool {
    touches_area(snapshot.pitch, snapshot.pitch.penalty_area, end(snapshot, team), robot)
}

/// Whether the robot is its team's only one that may be in the penalty area: the one nearest to the mark that does not stand on
/// it.
fn is_kicker(snapshot: &MatchSnapshot, team: Team, robot: &RobotSnapshot) -> bool {
    let mark = penalty_mark(snapshot.pitch, end(snapshot, team));
    let others = snapshot.robots.iter().filter(|other| {
        other.is_present()
            && other.id.team == team
            && is_in_area(snapshot, team, other)
            && !blocks(snapshot, mark, other)
    });
    let nearest = others.min_by(|a, b| a.pose.position.distance(mark).total_cmp(&b.pose.position.distance(mark)));
    nearest.is_some_and(|nearest| nearest.id == robot.id)
}

/// Whether the robot stands where the ball goes.
fn blocks(snapshot: &MatchSnapshot, mark: Vec2, robot: &RobotSnapshot) -> bool {
    let radius = snapshot.ball.map_or(0.0, |ball| ball.radius);
    robot.bounds.base.footprint(robot.pose).overlap_disc(mark, radius).is_some()
}

/// What is wrong with the place of each robot when the `set` of a penalty kick of `team` begins: one entry a robot, none for a
/// legal place or a penalised robot. A keeper that is ahead of its line is put back instead.
pub fn illegal_positions(snapshot: &MatchSnapshot, team: Team) -> impl Iterator<Item = Option<IllegalPosition>> {
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
            snapshot.is_keeper(robot)
        };
        (is_in_area(snapshot, team, robot) && !may_be_in_area).then_some(IllegalPosition::InPenaltyAreaAtKick)
    })
}

/// Whether a robot is where it must not be while the ball is the attackers' own.
pub fn encroaches(set_play: &SetPlay, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    let team = set_play.team;
    is_in_area(snapshot, team, robot)
        && if robot.id.team == team {
            !is_kicker(snapshot, team, robot) && !blocks(snapshot, set_play.ball_m, robot)
        } else {
            !(snapshot.is_keeper(robot) && keeps_its_line(snapshot, team, robot))
        }
}

/// Whether the keeper is on its feet, and in contact with the goal line.
fn keeps_its_line(snapshot: &MatchSnapshot, team: Team, keeper: &RobotSnapshot) -> bool {
    keeper.posture.is_upright() && touches_goal_line(snapshot.pitch, end(snapshot, team), keeper)
}

impl Referee<'_, '_> {
    /// Play is stopped for a penalty kick of `team`: robots walk to their places.
    pub(super) fn begin_penalty_kick(&mut self, team: Team) {
        let mark = penalty_mark(self.seen.pitch, end(self.seen, team));
        let place = self.put_ball(mark);
        self.memory.kick_off = None;
        self.memory.cycles_lined_up = 0;
        let cycles = self.seen.cycles(self.seen.rules.penalty_kick_s);
        self.decisions.game.set_play = Some(SetPlay::new(SetPlayKind::PenaltyKick, team, place, cycles));
        for record in &mut self.memory.robots {
            record.forgive();
        }
        let set_play = SetPlayKind::PenaltyKick;
        self.decisions.events.push(MatchEvent::FreeKick { set_play, team, position_m: place });
        self.enter(GameState::Ready);
    }

    /// A keeper that stands ahead of its line in its penalty area is put back onto it, without being turned.
    pub(super) fn put_keeper_on_its_line(&mut self, team: Team) {
        let snapshot = self.now();
        let is_ahead = |robot: &RobotSnapshot| {
            robot.is_present()
                && robot.id.team != team
                && snapshot.is_keeper(robot)
                && is_in_area(&snapshot, team, robot)
                && !keeps_its_line(&snapshot, team, robot)
        };
        let Some(index) = snapshot.robots.iter().position(is_ahead) else { return };
        let robot = &snapshot.robots[index];
        let line = end(&snapshot, team).sign() * snapshot.pitch.half_length();
        let wanted = Pose { position: Vec2::new(line, robot.pose.position.y), ..robot.pose };
        let pose = Occupied::by_others(&snapshot, Some(index)).free_pose(wanted, &robot.bounds);
        let rule = "At a penalty kick the keeper is in contact with its goal line, or outside its penalty area.";
        let evidence = snapshot.evidence_against(rule, robot).otherwise("It had to be there before `set` began.");
        let robot = robot.id;
        self.decisions.robots[index].pose = pose;
        self.memory.robots[index].hand_placements += 1;
        self.decisions.events.push(MatchEvent::PlacedByHand { robot, position_m: pose.position, evidence });
    }

    /// The whistle: the ball is the attackers' own, and a direct goal of theirs counts.
    pub(super) fn begin_penalty_shot(&mut self, set_play: SetPlay) {
        self.whistle();
        self.memory.plays = Plays::direct_for(set_play.team);
        self.memory.stuck = default();
        self.decisions.game.set_play = Some(SetPlay { touched: false, ..set_play });
    }
}

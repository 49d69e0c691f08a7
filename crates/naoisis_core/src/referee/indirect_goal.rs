//! Indirect goals: a goal counts only if two robots of the team have played the ball since the last restart (2025 rule book, section 3.4).
//! Own goals always count. So does the first shot of the team that had to keep away from a free kick, if the free kick was not taken in
//! time.
//!
//! With [direct free kicks](crate::game::Rules::direct_free_kicks) this applies only to the team that restarted play with an
//! indirect one, until another robot of either team touches the ball (HSL 2026, laws 8 and 13).

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::areas::is_keeper_at_home;
use super::boundary::Crossing;
use super::kick_off_shot::KickOffPlay;
use super::snapshot::MatchSnapshot;
use crate::game::{Evidence, SetPlayKind};
use crate::team::{RobotId, Team};

/// Speed below which the ball has stopped, m/s.
const STOPPED_MPS: f32 = 0.05;

/// Speed above which a robot that walks into the ball plays it, m/s.
const DRIBBLE_MPS: f32 = 0.03;

/// The robots that have played the ball since the last restart.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Plays {
    /// The first robot of each team, blue first.
    pub first: [Option<RobotId>; 2],
    /// Whether another robot of the same team has played the ball, too.
    pub second: [bool; 2],
    /// The robot whose kick the ball still rolls from.
    pub shot: Option<RobotId>,
    /// The permission for a direct goal, if any.
    pub direct: Option<Direct>,
    /// The robot that touched the ball first since the restart: in a set play, its taker.
    pub taker: Option<RobotId>,
    /// Whether another robot has touched the ball since the restart.
    pub others: bool,
    /// The cycle in which the taker last touched the ball, while no other robot had touched it.
    pub taker_cycle: u64,
    /// The kind of the restart, and its team; `None` in a shoot-out, and if both teams may score.
    pub restart: Option<(SetPlayKind, Team)>,
}

/// Permission for a direct goal.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
pub struct Direct {
    /// The team.
    pub team: Team,
    /// The robot that has played the ball, if any.
    pub robot: Option<RobotId>,
}

impl Plays {
    /// The state after a restart of `kind` by `team`.
    pub fn after(kind: SetPlayKind, team: Team) -> Self {
        Self { restart: Some((kind, team)), ..Self::default() }
    }

    /// The state after a free kick that was not taken in time: `team`, which did not have the free kick, may score directly.
    pub(crate) fn direct_for(team: Team) -> Self {
        Self { direct: Some(Direct { team, robot: None }), ..Self::default() }
    }

    /// Records the touches of a cycle.
    pub fn advance(&mut self, snapshot: &MatchSnapshot) {
        for &(robot, kick) in snapshot.touches {
            let team = robot.team as usize;
            self.others |= *self.taker.get_or_insert(robot) != robot;
            self.taker_cycle = if self.others { self.taker_cycle } else { snapshot.clock.cycle };
            if is_deliberate(snapshot, robot, kick) {
                match self.first[team] {
                    None => self.first[team] = Some(robot),
                    Some(first) => self.second[team] |= first != robot,
                }
            }
            if kick {
                self.shot = Some(robot);
            }
            self.direct = self.direct.and_then(|direct| direct.after_touch(robot, kick));
        }
        if snapshot.touches.is_empty() && snapshot.ball.is_some_and(|ball| ball.velocity.length() < STOPPED_MPS) {
            self.shot = None;
            self.direct = self.direct.filter(|direct| direct.robot.is_none());
        }
    }
}

/// Whether a robot that touched the ball played it: it kicked the ball, walked into it (rather than the ball rolling into the robot), or is
/// a keeper that dives for it in its own penalty area.
fn is_deliberate(snapshot: &MatchSnapshot, robot: RobotId, kick: bool) -> bool {
    let (Some(ball), Some(index)) = (&snapshot.ball, snapshot.robot_index(robot)) else { return kick };
    let robot = &snapshot.robots[index];
    let [start, next] = [0, 1].map(|corner| *ball.path.get(corner).unwrap_or(&ball.position));
    let towards = (start - robot.previous.position).normalize_or_zero();
    let way_m: f32 = ball.path.windows(2).map(|way| way[0].distance(way[1])).sum();
    let ball_mps = -(next - start).normalize_or_zero().dot(towards) * way_m / snapshot.clock.period();
    let own_mps = robot.wanted_velocity.dot(towards);
    let dribbles = own_mps > DRIBBLE_MPS && own_mps > ball_mps;
    kick || dribbles || (!robot.posture.is_upright() && is_keeper_at_home(snapshot, robot))
}

/// The robot that took a kick-in, goal kick or corner kick and touches the ball again before another robot has, with the evidence. `plays`
/// is the state before this cycle. Touches less than a fifth of a second apart count as one.
pub fn judge_double_touch(snapshot: &MatchSnapshot, plays: &Plays) -> Option<(RobotId, Evidence)> {
    const APART_S: f32 = 0.2;
    let (kind, team) = plays.restart.filter(|_| snapshot.rules.double_touch && snapshot.game.set_play.is_none())?;
    let is_such = matches!(kind, SetPlayKind::KickIn | SetPlayKind::GoalKick | SetPlayKind::CornerKick);
    let taker = plays.taker.filter(|taker| is_such && taker.team == team && !plays.others)?;
    let (first, _) = snapshot.touches.first().filter(|(robot, _)| *robot == taker)?;
    let apart = snapshot.clock.cycle.saturating_sub(plays.taker_cycle);
    let index = snapshot.robot_index(*first)?;
    (apart > snapshot.cycles(APART_S)).then(|| {
        let rule = "The robot that has taken a set play may not touch the ball again before another robot has.";
        let evidence = snapshot.evidence_against(rule, &snapshot.robots[index]);
        let evidence = evidence.with_measurement("s between its touches", snapshot.seconds(apart), APART_S);
        (taker, evidence.otherwise("Another robot had to touch the ball first."))
    })
}

impl Direct {
    fn after_touch(self, robot: RobotId, kick: bool) -> Option<Direct> {
        match self.robot {
            None => (robot.team == self.team).then_some(Direct { robot: Some(robot), ..self }),
            // After a deflection the shot is still the same; after the ball is played again it is not.
            Some(shooter) => (shooter != robot && !kick).then_some(self),
        }
    }
}

/// Whether a goal of `team` came straight from an indirect restart of its own: no other robot of either team has touched the ball since.
/// After a kick-off of a team with fewer than three robots, it did not if the taker has played the ball again outside the circle (HSL 2026,
/// law 8).
fn is_straight(snapshot: &MatchSnapshot, plays: &Plays, kick_off: Option<&KickOffPlay>, team: Team) -> bool {
    let Some((kind, _)) = plays.restart.filter(|(kind, by)| *by == team && !kind.is_direct()) else { return false };
    let robots = snapshot.robots.iter().filter(|robot| robot.id.team == team && robot.is_present()).count();
    let alone = kind == SetPlayKind::KickOff && robots < 3;
    let has_played_on = alone && kick_off.is_some_and(|play| play.over);
    !plays.others && !has_played_on
}

/// The evidence against a goal of `team` that went straight from a set play of the other team into that team's own goal, if such a goal
/// [does not count](crate::game::Rules::own_set_play_goals).
pub fn judge_own(snapshot: &MatchSnapshot, plays: &Plays, team: Team, crossing: &Crossing) -> Option<Evidence> {
    let taken = |by: Team| plays.taker.is_some_and(|taker| taker.team == by);
    let straight = plays.restart.is_some_and(|(_, by)| by != team && taken(by)) && !plays.others;
    (straight && !snapshot.rules.own_set_play_goals).then(|| {
        let rule = "A set play that goes straight into the own goal gives the other team a corner kick.";
        snapshot.evidence(rule, crossing.position).otherwise("Another robot had to touch the ball before.")
    })
}

/// The evidence against a goal of `team` that had to be indirect and was not. `kick_off` is the kick-off whose shot is still under way.
pub fn judge(
    snapshot: &MatchSnapshot,
    plays: &Plays,
    kick_off: Option<&KickOffPlay>,
    team: Team,
    crossing: &Crossing,
) -> Option<Evidence> {
    if !snapshot.rules.indirect_goals {
        return None;
    }
    let shot_by_team = plays.shot.is_some_and(|robot| robot.team == team);
    let own_goal = snapshot.last_touch.is_some_and(|touch| touch.robot.team != team) && !shot_by_team;
    let indirect = plays.second[team as usize];
    let direct = plays.direct.is_some_and(|direct| direct.team == team && direct.robot.is_some());
    if own_goal
        || indirect
        || direct
        || (snapshot.rules.direct_free_kicks && !is_straight(snapshot, plays, kick_off, team))
    {
        return None;
    }
    let evidence = snapshot.evidence(
        "A goal counts only if two robots of the team have played the ball since the last restart.",
        crossing.position,
    );
    Some(evidence.otherwise(format!("Another robot of the {team} team had to play the ball before.")))
}

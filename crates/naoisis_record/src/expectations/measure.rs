//! What is measured of a match, cycle by cycle.

use bevy::prelude::*;
use std::collections::BTreeMap;

use naoisis_core::ball::Ball;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::{CollisionPartner, CycleEvents, KickResult, MatchEvent};
use naoisis_core::game::{Game, GameState, Penalty};
use naoisis_core::geometry::Pose;
use naoisis_core::referee::RefereeMemory;
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sensing::belief::{Belief, pitch_from_team, point_pitch_from_team};
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::scenario::{Quantity, RobotQuantity, TeamQuantity};

/// What was measured of a match so far.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct MatchMeasurement {
    /// The score when it began.
    score_before: PerTeam<u32>,
    teams: PerTeam<OfTeam>,
    robots: BTreeMap<RobotId, OfRobot>,
    /// Who struck the ball, while nobody else has touched it.
    kicker: Option<RobotId>,
}

#[derive(Clone, Copy, PartialEq, Debug, Default)]
struct OfTeam {
    goals: u32,
    own_goals: u32,
    kicks: u32,
    passes: u32,
    penalties: u32,
    falls: u32,
    outs: u32,
    programs_lost: u32,
    possession_cycles: u64,
}

#[derive(Clone, Copy, PartialEq, Debug, Default)]
struct OfRobot {
    kicks: u32,
    penalties: u32,
    falls: u32,
    path_m: f64,
    /// Cycles in which it might have seen the ball.
    cycles: u64,
    ball_seen_cycles: u64,
    pose_error_sum_m: f64,
    pose_error_cycles: u64,
    ball_error_sum_m: f64,
    ball_error_cycles: u64,
}

impl MatchMeasurement {
    /// Begins to measure a match where it is: what was before does not count.
    pub fn begin(world: &World) -> Self {
        Self { score_before: world.resource::<Game>().score, ..Self::default() }
    }

    /// Measures the cycle that has just ended.
    pub fn observe(&mut self, world: &World) {
        for event in world.resource::<CycleEvents>().iter() {
            self.count(event);
        }
        let game = world.resource::<Game>();
        for team in Team::BOTH {
            self.teams[team].goals = game.score[team].saturating_sub(self.score_before[team]);
        }
        if game.state == GameState::Playing
            && let Some(touch) = world.resource::<RefereeMemory>().last_touch
        {
            self.teams[touch.robot.team].possession_cycles += 1;
        }
        let period_s = world.resource::<CycleClock>().period_s;
        let mut balls = world.try_query_filtered::<&Pose, With<Ball>>();
        let ball = balls.as_mut().and_then(|balls| balls.iter(world).next()).map(|ball| ball.position);
        for (id, entity) in world.resource::<Roster>().iter() {
            let of_robot = self.robots.entry(id).or_default();
            of_robot.observe(world.entity(entity), game, id, ball, period_s);
        }
    }

    fn count(&mut self, event: &MatchEvent) {
        match event {
            MatchEvent::Goal { team, own_goal: true, .. } => self.teams[team.opponent()].own_goals += 1,
            MatchEvent::Kick { robot, result: KickResult::Kicked | KickResult::Reduced, .. } => {
                self.touched(*robot);
                self.teams[robot.team].kicks += 1;
                self.robot(*robot).kicks += 1;
                self.kicker = Some(*robot);
            }
            MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Ball, .. } => self.touched(*robot),
            MatchEvent::Penalty { robot, .. } => {
                self.teams[robot.team].penalties += 1;
                self.robot(*robot).penalties += 1;
            }
            MatchEvent::Fall { robot, .. } => {
                self.teams[robot.team].falls += 1;
                self.robot(*robot).falls += 1;
            }
            MatchEvent::AgentLost { robot, .. } => self.teams[robot.team].programs_lost += 1,
            MatchEvent::BallOut { last_touch, .. } => {
                if let Some(team) = last_touch {
                    self.teams[*team].outs += 1;
                }
                self.kicker = None;
            }
            MatchEvent::Goal { .. } | MatchEvent::KickOff { .. } | MatchEvent::DropBall { .. } => self.kicker = None,
            _ => {}
        }
    }

    fn robot(&mut self, id: RobotId) -> &mut OfRobot {
        self.robots.entry(id).or_default()
    }

    /// Somebody touches the ball: a pass, if it is another than a team-mate who struck it.
    fn touched(&mut self, robot: RobotId) {
        if let Some(kicker) = self.kicker
            && kicker != robot
        {
            if kicker.team == robot.team {
                self.teams[robot.team].passes += 1;
            }
            self.kicker = None;
        }
    }

    /// What a quantity comes to; none if there was nothing to measure. Mistakes are not measured here.
    pub fn value(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::OfTeam(team, quantity) => {
                let own = &self.teams[team];
                match quantity {
                    TeamQuantity::Goals => Some(own.goals.into()),
                    TeamQuantity::OwnGoals => Some(own.own_goals.into()),
                    TeamQuantity::Kicks => Some(own.kicks.into()),
                    TeamQuantity::Passes => Some(own.passes.into()),
                    TeamQuantity::Penalties => Some(own.penalties.into()),
                    TeamQuantity::ProgramsLost => Some(own.programs_lost.into()),
                    TeamQuantity::Falls => Some(own.falls.into()),
                    TeamQuantity::Outs => Some(own.outs.into()),
                    TeamQuantity::Mistakes(_) => None,
                    TeamQuantity::PossessionPercent => percent(
                        own.possession_cycles,
                        own.possession_cycles + self.teams[team.opponent()].possession_cycles,
                    ),
                }
            }
            Quantity::OfRobot(robot, quantity) => {
                let own = self.robots.get(&robot)?;
                match quantity {
                    RobotQuantity::Kicks => Some(own.kicks.into()),
                    RobotQuantity::Penalties => Some(own.penalties.into()),
                    RobotQuantity::Falls => Some(own.falls.into()),
                    RobotQuantity::PathM => Some(own.path_m),
                    RobotQuantity::BallSeenPercent => percent(own.ball_seen_cycles, own.cycles),
                    RobotQuantity::PoseErrorM => mean(own.pose_error_sum_m, own.pose_error_cycles),
                    RobotQuantity::BallErrorM => mean(own.ball_error_sum_m, own.ball_error_cycles),
                    RobotQuantity::Mistakes(_) => None,
                }
            }
        }
    }
}

impl OfRobot {
    fn observe(&mut self, robot: EntityRef, game: &Game, id: RobotId, ball: Option<Vec2>, period_s: f64) {
        if robot.get::<Penalty>().is_some_and(Penalty::is_active) {
            return;
        }
        if let Some(velocity) = robot.get::<Velocity>() {
            self.path_m += f64::from(velocity.linear.length()) * period_s;
        }
        self.cycles += 1;
        self.ball_seen_cycles += u64::from(robot.get::<Percepts>().is_some_and(|percepts| percepts.ball.is_some()));
        if let (Some(pose), Some(belief)) = (robot.get::<Pose>(), robot.get::<Belief>()) {
            let believed = pitch_from_team(belief.pose, game.own_end(id.team));
            self.pose_error_sum_m += f64::from(believed.position.distance(pose.position));
            self.pose_error_cycles += 1;
            if let (Some(ball), Some(believed)) = (ball, &belief.ball) {
                let believed = point_pitch_from_team(believed.position_m, game.own_end(id.team));
                self.ball_error_sum_m += f64::from(believed.distance(ball));
                self.ball_error_cycles += 1;
            }
        }
    }
}

fn mean(sum: f64, count: u64) -> Option<f64> {
    (count > 0).then(|| sum / count as f64)
}

fn percent(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| 100.0 * part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::kick_geometry::KickType;

    #[test]
    fn a_pass_is_a_kick_that_a_team_mate_touches_next() {
        let kick = |robot| MatchEvent::Kick {
            robot,
            kick_type: KickType::LeftStraight,
            speed: Some(1.0),
            result: KickResult::Kicked,
            reason: None,
            direction: None,
            launch_speed_mps: None,
        };
        let [one, two, other] =
            [(Team::Blue, 1), (Team::Blue, 2), (Team::Pink, 1)].map(|(team, id)| RobotId::new(team, id));
        let mut measurement = MatchMeasurement::default();
        for robot in [one, one, two, other, one, two] {
            measurement.count(&kick(robot));
        }
        let passes = |team| measurement.value(Quantity::OfTeam(team, TeamQuantity::Passes));
        assert_eq!((passes(Team::Blue), passes(Team::Pink)), (Some(2.0), Some(0.0)));
        assert_eq!(measurement.value(Quantity::OfRobot(one, RobotQuantity::Kicks)), Some(3.0));
        assert_eq!(measurement.value(Quantity::OfRobot(one, RobotQuantity::PoseErrorM)), None);
    }
}

//! What ends an episode, with success or failure.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::situation::Area;
use super::state::ball_of;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::{CollisionPartner, CycleEvents, KickResult, MatchEvent};
use naoisis_core::game::{Game, GameState};
use naoisis_core::geometry::{Pose, to_radians, wrap_angle};
use naoisis_core::robot::Roster;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sensing::belief::{Belief, pitch_from_team};
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::scenario::Scenario;

/// What ends an episode, besides its time limit and the final whistle. The conditions `ball_seen` to `believed_within_m` concern the first
/// controlled robot and the ball: the episode succeeds when all of them that are given hold, for `hold_s` without a break.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EndConditions {
    /// A goal for this team is a success, a goal for the other team a failure.
    pub goal_for: Option<Team>,
    /// A goal is a success only if two robots of the team touched the ball last, one after the other.
    pub passed: bool,
    /// The final whistle is a success if this team has won.
    pub win_for: Option<Team>,
    /// The episode fails when the ball leaves the pitch.
    pub ball_out: bool,
    /// The end of the time limit is a success.
    pub held: bool,
    /// The episode succeeds when the robot touches the ball.
    pub ball_touched: bool,
    /// The robot sees the ball.
    pub ball_seen: bool,
    /// The robot stands or walks, and the ball is at most this far from it, m.
    pub ball_within_m: Option<f32>,
    /// The ball is in front of the robot, at most this far from the direction in which it faces, deg.
    pub ball_ahead_deg: Option<f32>,
    /// The robot stands or walks in this area.
    pub robot_in: Option<Area>,
    /// The ball is in this area.
    pub ball_in: Option<Area>,
    /// The belief of the robot about its position is wrong by at most this, m.
    pub believed_within_m: Option<f32>,
    /// How long the conditions must hold without a break, s.
    pub hold_s: f32,
    /// The time before which the conditions do not count, s.
    pub after_s: f32,
}

/// The state of an episode after a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct EpisodeProgress {
    /// Whether the task has ended; no reward can follow.
    pub terminated: bool,
    /// Whether the time limit has ended it.
    pub truncated: bool,
    /// Whether the task succeeded.
    pub is_success: bool,
    /// Whether it is a success of each team: of the one that scored the goal, or won the match, that ended the task.
    pub success_of: PerTeam<bool>,
}

impl EpisodeProgress {
    /// Whether the episode is over.
    pub fn is_over(self) -> bool {
        self.terminated || self.truncated
    }
}

/// What the conditions need to know of the earlier cycles of an episode.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub(super) struct Course {
    /// The number of cycles in which the conditions have held without a break.
    held_cycles: u32,
    /// The last two different robots that touched the ball, the last one second.
    touches: [Option<RobotId>; 2],
}

impl EndConditions {
    /// Whether the last cycle ended the episode.
    pub(super) fn progress(&self, world: &World, control: &[RobotId], course: &mut Course) -> EpisodeProgress {
        let ended = |is_success, of: Option<Team>| EpisodeProgress {
            terminated: true,
            truncated: false,
            is_success,
            success_of: PerTeam::new(|team| of == Some(team)),
        };
        let first = control.first();
        if let Some(winner) = self.of_events(world.resource::<CycleEvents>().iter(), first, course) {
            let wanted = self.goal_for.or(first.map(|id| id.team));
            return ended(winner.is_some() && winner == wanted, winner);
        }
        let clock = world.resource::<CycleClock>();
        if let Some(id) = first {
            let holds = clock.end_time_s() >= f64::from(self.after_s) && self.holds(world, *id);
            course.held_cycles = if holds { course.held_cycles + 1 } else { 0 };
            if holds && course.held_cycles > clock.cycles_in(self.hold_s) {
                return ended(true, Some(id.team));
            }
        }
        let last_cycle = world.get_resource::<Scenario>().and_then(Scenario::last_cycle);
        let is_late = last_cycle.is_some_and(|last| clock.cycle >= last);
        if is_late && self.held {
            return ended(true, first.map(|id| id.team));
        }
        let game = world.resource::<Game>();
        let terminated = game.state == GameState::Finished;
        let has_won = |team: Team| terminated && game.score[team] > game.score[team.opponent()];
        EpisodeProgress {
            terminated,
            truncated: is_late,
            is_success: self.win_for.is_some_and(has_won),
            success_of: PerTeam::new(|team| self.win_for.is_some() && has_won(team)),
        }
    }

    /// Whether `events` of a cycle end the episode: with the team that succeeds, or `None` inside if nobody does.
    fn of_events<'a>(
        &self,
        events: impl Iterator<Item = &'a MatchEvent>,
        first: Option<&RobotId>,
        course: &mut Course,
    ) -> Option<Option<Team>> {
        let mut ended = None;
        for event in events {
            match event {
                MatchEvent::Kick { robot, result: KickResult::Kicked | KickResult::Reduced, .. }
                | MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Ball, .. } => {
                    course.touch(*robot);
                    if self.ball_touched && Some(robot) == first {
                        return Some(Some(robot.team));
                    }
                }
                MatchEvent::Goal { team, .. } if self.goal_for.is_some() => {
                    let counts = !self.passed || self.goal_for != Some(*team) || course.is_pass_of(*team);
                    return Some(counts.then_some(*team));
                }
                MatchEvent::BallOut { .. } if self.ball_out => ended = Some(None),
                _ => {}
            }
        }
        ended
    }

    /// Whether all given conditions of the robot `id` and the ball hold now; not if none is given.
    fn holds(&self, world: &World, id: RobotId) -> bool {
        let Some(robot) = world.resource::<Roster>().get(id) else { return false };
        let pose = world.get::<Pose>(robot).copied().unwrap_or_default();
        let ball = || ball_of(world).map(|(ball, _)| ball);
        let stands = !matches!(
            world.get::<BodyStatus>(robot),
            Some(BodyStatus::Fallen | BodyStatus::GettingUp | BodyStatus::Diving)
        );
        let sees_ball = || world.get::<Percepts>(robot).is_some_and(|percepts| percepts.ball.is_some());
        let is_near = |m: f32| stands && ball().is_some_and(|ball| ball.distance(pose.position) <= m);
        let is_ahead = |deg: f32| {
            let angle = |ball: Vec2| wrap_angle((ball - pose.position).to_angle() - pose.heading).abs();
            ball().is_some_and(|ball| angle(ball) <= to_radians(deg))
        };
        let believes = |m: f32| {
            let own_end = world.resource::<Game>().own_end(id.team);
            let believed = world.get::<Belief>(robot).map(|belief| pitch_from_team(belief.pose, own_end).position);
            believed.is_some_and(|believed| believed.distance(pose.position) <= m)
        };
        let conditions = [
            self.ball_seen.then(sees_ball),
            self.ball_within_m.map(is_near),
            self.ball_ahead_deg.map(is_ahead),
            self.robot_in.map(|area| stands && area.contains(pose.position)),
            self.ball_in.map(|area| ball().is_some_and(|ball| area.contains(ball))),
            self.believed_within_m.map(believes),
        ];
        let mut given = conditions.into_iter().flatten().peekable();
        given.peek().is_some() && given.all(|holds| holds)
    }
}

impl Course {
    fn touch(&mut self, robot: RobotId) {
        if self.touches[1] != Some(robot) {
            self.touches = [self.touches[1], Some(robot)];
        }
    }

    /// Whether two robots of `team` touched the ball last.
    fn is_pass_of(&self, team: Team) -> bool {
        self.touches.iter().all(|touch| touch.is_some_and(|robot| robot.team == team))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::game::Evidence;
    use naoisis_core::kick_geometry::KickType;

    fn kick(robot: &str) -> MatchEvent {
        MatchEvent::Kick {
            robot: robot.parse().unwrap(),
            kick_type: KickType::LeftStraight,
            speed: None,
            result: KickResult::Kicked,
            reason: None,
            direction: None,
            launch_speed_mps: None,
        }
    }

    fn goal(team: Team) -> MatchEvent {
        MatchEvent::Goal { team, scorer: None, own_goal: false, evidence: Evidence::default() }
    }

    #[test]
    fn a_goal_after_a_pass_is_another_than_one_alone() {
        let end = EndConditions { goal_for: Some(Team::Blue), passed: true, ..EndConditions::default() };
        for (kicks, team, ended) in [
            (&["blue1", "blue2"][..], Team::Blue, Some(Some(Team::Blue))),
            (&["blue2", "blue2"], Team::Blue, Some(None)),
            (&["blue1", "pink1", "blue2"], Team::Blue, Some(None)),
            (&["blue1", "blue2", "blue2", "blue2"], Team::Blue, Some(Some(Team::Blue))),
            (&["blue1"], Team::Pink, Some(Some(Team::Pink))),
        ] {
            let mut course = Course::default();
            for robot in kicks {
                assert_eq!(end.of_events([kick(robot)].iter(), None, &mut course), None);
            }
            assert_eq!(end.of_events([goal(team)].iter(), None, &mut course), ended, "{kicks:?}");
        }
    }
}

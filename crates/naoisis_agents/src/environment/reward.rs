//! Rewards of agents: named terms, each with a weight.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::state::ball_of;
use naoisis_core::game::Game;
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;

/// The weights of the terms of a reward. A missing term has the weight 0.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RewardWeights {
    /// 1 for each goal of the team, -1 for each goal of the opponents.
    pub score: f32,
    /// 1 for the successful end of a task of the agent's team.
    pub success: f32,
    /// 1 for each metre that the ball comes nearer to the opponents' goal.
    pub ball_to_goal: f32,
    /// 1 for each metre that the agent comes nearer to the ball.
    pub to_ball: f32,
    /// 1 for each second.
    pub time: f32,
}

impl RewardWeights {
    /// Only the score, with the weight 1.
    pub const SCORE: RewardWeights =
        RewardWeights { score: 1.0, success: 0.0, ball_to_goal: 0.0, to_ball: 0.0, time: 0.0 };
}

/// The names of the terms, with descriptions.
pub const REWARDS: [(&str, &str); 5] = [
    ("score", "1 for each goal of the team, -1 for each goal of the opponents"),
    ("success", "1 for the successful end of a task of the agent's team"),
    ("ball_to_goal", "1 for each metre that the ball comes nearer to the opponents' goal"),
    ("to_ball", "1 for each metre that the agent comes nearer to the ball"),
    ("time", "1 for each second; a negative weight makes agents hurry"),
];

/// The values from which rewards are computed.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub(super) struct Standing {
    /// Goals of the team minus goals of the opponents.
    lead: f32,
    /// The distance from the ball to the opponents' goal, m.
    ball_to_goal_m: Option<f32>,
    /// The distance from the agent to the ball, m.
    to_ball_m: Option<f32>,
}

impl Standing {
    /// The current values of each agent.
    pub fn of_all(world: &World, agents: &[RobotId]) -> impl Iterator<Item = Self> {
        let (game, roster) = (world.resource::<Game>(), world.resource::<Roster>());
        let half_length = world.resource::<Pitch>().half_length();
        let ball = ball_of(world);
        agents.iter().map(move |id| {
            let opponent = id.team.opponent();
            let lead = game.score[id.team] as f32 - game.score[opponent] as f32;
            let Some((ball, _)) = ball else { return Self { lead, ..default() } };
            let robot = roster.get(*id).and_then(|entity| world.get::<Pose>(entity));
            let goal = Vec2::new(game.own_end(opponent).sign() * half_length, 0.0);
            Self {
                lead,
                ball_to_goal_m: Some(goal.distance(ball)),
                to_ball_m: robot.map(|robot| robot.position.distance(ball)),
            }
        })
    }

    /// The reward for a change from `self` to `now` that took `period_s`.
    pub fn reward(&self, now: &Self, period_s: f32, is_success: bool, weights: &RewardWeights) -> f32 {
        /// The greatest speed of ball and robots, m/s. A larger change means that the referee moved them.
        const FASTEST_MPS: f32 = 5.0;

        let nearer = |before: Option<f32>, after: Option<f32>| match (before, after) {
            (Some(before), Some(after)) if (before - after).abs() <= FASTEST_MPS * period_s => before - after,
            _ => 0.0,
        };
        weights.score * (now.lead - self.lead)
            + weights.success * f32::from(u8::from(is_success))
            + weights.ball_to_goal * nearer(self.ball_to_goal_m, now.ball_to_goal_m)
            + weights.to_ball * nearer(self.to_ball_m, now.to_ball_m)
            + weights.time * period_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reward_is_the_weighted_sum_of_its_parts() {
        let before = Standing { lead: 0.0, ball_to_goal_m: Some(2.0), to_ball_m: Some(1.0) };
        let after = Standing { lead: 1.0, ball_to_goal_m: Some(1.9), to_ball_m: Some(1.05) };
        let weights = RewardWeights { score: 10.0, success: 5.0, ball_to_goal: 2.0, to_ball: 1.0, time: -0.5 };
        let reward = before.reward(&after, 0.1, true, &weights);
        assert!((reward - (10.0 + 5.0 + 0.2 - 0.05 - 0.05)).abs() < 1e-5, "{reward}");
        assert_eq!(before.reward(&after, 0.1, true, &RewardWeights::SCORE), 1.0);
    }

    #[test]
    fn what_the_referee_moves_is_nobodys_merit() {
        let before = Standing { lead: 0.0, ball_to_goal_m: Some(0.1), to_ball_m: Some(0.2) };
        let after = Standing { lead: 0.0, ball_to_goal_m: Some(3.0), to_ball_m: Some(3.0) };
        let weights = RewardWeights { ball_to_goal: 1.0, to_ball: 1.0, ..RewardWeights::default() };
        assert_eq!(before.reward(&after, 0.1, false, &weights), 0.0);
    }
}

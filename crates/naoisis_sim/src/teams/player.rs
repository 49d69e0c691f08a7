//! The knowledge of a built-in player, its decision in a cycle, and its memory.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::gaze_history::GazeHistory;
use super::gaze_search::Head;
use super::hearing::Whistles;
use super::obstacles::BALL_CLEARANCE_M;
use super::passing::Pass;
use naoisis_core::ball::Rolling;
use naoisis_core::communication::ReceivedMessage;
use naoisis_core::game::{DefenderLimit, Rules};
use naoisis_core::geometry::{Pose, unrotate};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::Pitch;
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadCommand;
use naoisis_core::robot::kick::{KickRequest, KickSettings};
use naoisis_core::robot::latency::Latency;
use naoisis_core::robot::motion::{MotionSettings, WalkCommand};
use naoisis_core::robot::posture::PostureRequest;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::{BallBelief, Belief};
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sensing::sensing::status::BodyStatus;

/// Half the width of a NAO with its arms, m. The clearances of the built-in teams were measured for a NAO with the paper's ball; other
/// robots and balls add the difference in size.
const NAO_HALF_WIDTH_M: f32 = 0.15;
/// Distance by which the feet of a NAO extend ahead of its origin, m.
const NAO_FRONT_M: f32 = 0.11;
/// The radius of the paper's ball, m.
const NAO_BALL_RADIUS_M: f32 = 0.03;
/// Distance by which the feet of a NAO extend to either side, m.
const NAO_FEET_HALF_WIDTH_M: f32 = 0.1;
/// Half the width that a NAO blocks for the paper's ball, m: its feet and the ball's radius.
const NAO_BLOCKED_HALF_WIDTH_M: f32 = 0.15;

/// Everything that a player's decision can depend on.
#[derive(Clone, Copy, Debug)]
pub struct Player<'a> {
    /// Its team and number.
    pub id: RobotId,
    /// Its belief.
    pub belief: &'a Belief,
    /// The messages that it received in this cycle.
    pub heard: &'a [ReceivedMessage],
    /// The state of the game, as reported to it.
    pub status: &'a GameStatus,
    /// What its body is doing.
    pub body: BodyStatus,
    /// The readings of its sonars.
    pub sonar: SonarReading,
    /// Where its sonars point.
    pub sonar_settings: &'a SonarSettings,
    /// How it walks.
    pub motion: &'a MotionSettings,
    /// Its kicks.
    pub kicks: &'a KickSettings,
    /// The delay of its commands.
    pub latency: &'a Latency,
    /// Its body.
    pub own_body: &'a Body,
    /// Its head, with the field of view of the cameras.
    pub head: Head,
    /// How the ball rolls.
    pub rolling: Rolling,
    /// The ball's radius, m.
    pub ball_radius_m: f32,
    /// The pitch.
    pub pitch: &'a Pitch,
    /// The rules of the match.
    pub rules: &'a Rules,
    /// Duration of a cycle, s.
    pub period: f32,
    /// The direction that it faces, unit vector, team frame.
    pub forward: Vec2,
}

/// The decision of a player in a cycle.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Decision {
    /// The step.
    pub walk: WalkCommand,
    /// The place that the player walks to, m, team frame: for display.
    pub target: Option<Vec2>,
    /// Where to look; `None` for what [`watch`](super::gaze_walking::watch) chooses.
    pub head: Option<HeadCommand>,
    /// The kick.
    pub kick: Option<KickRequest>,
    /// The motion of the whole body: a dive, or getting up.
    pub posture: Option<PostureRequest>,
    /// The intention, in a word.
    pub intention: &'static str,
    /// The pass to announce to the team-mates.
    pub pass: Option<Pass>,
    /// Whether to report the opponents in view to the team-mates.
    pub reports_opponents: bool,
}

/// The memory of a built-in player from cycle to cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Belief)]
pub struct PlayerMemory {
    /// Number of restarts at which the robots had been placed.
    pub restarts: Option<u32>,
    /// The referee's whistles, as the player understands them.
    pub whistles: Whistles,
    /// When it sent its last message, if messages are limited, s.
    pub spoke_at_s: Option<f32>,
    /// Whether the game was in `ready` or `set`.
    pub waited_for_kick_off: bool,
    /// When the current kick-off began, s; `None` once it is over.
    pub kick_off_since_s: Option<f32>,
    /// Since when the ball is seen in play during the kick-off, s.
    #[serde(default)]
    pub kick_off_over_since_s: Option<f32>,
    /// The direction in which the ball should go, team frame.
    pub aim: Option<Vec2>,
    /// The kick that is being prepared.
    pub kick: Option<KickType>,
    /// Since when the ball lies right for the kick that is being prepared, s.
    pub ready_since_s: Option<f32>,
    /// When it commanded its last kick, s.
    pub kicked_at_s: Option<f32>,
    /// Since when it is at the ball, s.
    pub at_ball_since_s: Option<f32>,
    /// Whether it is its turn to go for the ball.
    pub attacks: bool,
    /// When the ball was lost, s.
    pub lost_since_s: Option<f32>,
    /// On which side the ball was lost: whether on the left.
    pub lost_left: bool,
    /// Until when it looks at landmarks instead of the ball, s.
    pub glance_until_s: f32,
    /// When it last looked at landmarks, s.
    pub last_glance_s: f32,
    /// The pass that a team-mate announced to it, and when, s.
    pub expected_pass: Option<(Pass, f32)>,
    /// The place where it waits for a pass, m, team frame.
    pub free_place: Option<Vec2>,
    /// Opponents that team-mates reported: by whom, where, m, team frame, and when, s.
    pub told_opponents: Vec<(RobotId, Vec2, f32)>,
    /// The team-mates that said that they go for the ball: where they were, m, team frame, and when they said so, s.
    #[serde(default)]
    pub attackers: Vec<(RobotId, Vec2, f32)>,
    /// The velocity of its legs as it reckons from its commands: ahead and to the left, m/s, and counter-clockwise, rad/s. Zero for a
    /// robot without a gait.
    #[serde(default)]
    pub walks: Vec3,
    /// When it last looked in each direction.
    #[serde(default)]
    pub looked_around: GazeHistory,
}

impl<'a> Player<'a> {
    /// Its pose, team frame.
    pub fn pose(&self) -> Pose {
        self.belief.pose
    }

    /// Its place, m, team frame.
    pub fn position(&self) -> Vec2 {
        self.belief.pose.position
    }

    /// Returns the ball, if its place is known.
    pub fn ball(&self) -> Option<&'a BallBelief> {
        self.belief.ball.as_ref()
    }

    /// Returns how much wider the player's body is to either side than a NAO's, m. Other robots are assumed to be as wide.
    pub fn wider_than_nao_m(&self) -> f32 {
        self.own_body.torso.half_width_m - NAO_HALF_WIDTH_M
    }

    /// Returns how much further ahead a ball at the player's feet lies than at a NAO's feet, m.
    pub fn longer_than_nao_m(&self) -> f32 {
        (self.own_body.base.x_m[1] - NAO_FRONT_M) + (self.ball_radius_m - NAO_BALL_RADIUS_M)
    }

    /// Half the width that an opponent blocks for the ball, m: its feet and the ball's radius. Opponents are assumed to be as wide as this
    /// player.
    pub fn blocked_half_width_m(&self) -> f32 {
        NAO_BLOCKED_HALF_WIDTH_M
            + (self.own_body.base.half_width_m - NAO_FEET_HALF_WIDTH_M)
            + (self.ball_radius_m - NAO_BALL_RADIUS_M)
    }

    /// Returns the distance from the ball at which it walks around it, m.
    pub fn ball_clearance_m(&self) -> f32 {
        BALL_CLEARANCE_M + self.longer_than_nao_m()
    }

    /// Transforms a point from the team frame to the robot frame, m.
    pub fn in_robot(&self, point: Vec2) -> Vec2 {
        unrotate(self.forward, point - self.position())
    }

    /// Returns the middle of the own goal line, m, team frame.
    pub fn own_goal(&self) -> Vec2 {
        Vec2::new(-self.pitch.half_length(), 0.0)
    }

    /// Returns the middle of the opponents' goal line, m, team frame.
    pub fn opponent_goal(&self) -> Vec2 {
        Vec2::new(self.pitch.half_length(), 0.0)
    }

    /// Returns the distance from `place` to the nearest opponent, m.
    pub fn nearest_opponent(&self, place: Vec2) -> f32 {
        self.belief
            .opponents
            .iter()
            .map(|opponent| opponent.position_m.distance_squared(place))
            .fold(f32::MAX, f32::min)
            .sqrt()
    }

    /// Returns the places of opponents that were seen recently, m, team frame.
    pub fn fresh_opponents(&self) -> impl Iterator<Item = Vec2> + use<'a> {
        /// The greatest age of what is recent, s.
        const FRESH_S: f32 = 0.5;
        let opponents = self.belief.opponents.iter();
        opponents.filter(|opponent| opponent.age_s < FRESH_S).map(|opponent| opponent.position_m)
    }

    /// Returns whether its last kick command has not reached the legs yet. Another one would find them busy.
    pub fn is_kick_pending(&self, memory: &PlayerMemory) -> bool {
        let until_s = self.latency.kick_s + 0.5 * self.period;
        memory.kicked_at_s.is_some_and(|then| (0.0..until_s).contains(&(self.status.time_s - then)))
    }

    /// Returns the greatest speed from which the player can stop within `distance_m`, m/s, with the delay of its commands and of a step. A
    /// player without a gait stops at once.
    pub fn speed_to_stop_within_mps(&self, distance_m: f32) -> f32 {
        let Some(gait) = &self.motion.gait else { return f32::INFINITY };
        let (delay_s, distance_m) = (self.latency.walk_s + gait.step_s, distance_m.max(0.0));
        let brake_mps2 = gait.acceleration_mps2;
        brake_mps2 * ((delay_s * delay_s + 2.0 * distance_m / brake_mps2).sqrt() - delay_s)
    }

    /// The number by which a player of its team has its place and its task.
    pub fn role_number(&self, id: RobotId) -> u8 {
        id.role_number(self.status.goalkeeper)
    }

    /// Whether a player of its team is the goalkeeper.
    pub fn is_goalkeeper(&self, id: RobotId) -> bool {
        self.role_number(id) == RobotId::GOALKEEPER
    }

    /// Returns the goal posts, m, team frame: the own ones first.
    pub fn goal_posts(&self) -> [Vec2; 4] {
        let (x, y) = (self.pitch.goal_post_x(), self.pitch.goal.width_m / 2.0);
        [Vec2::new(-x, -y), Vec2::new(-x, y), Vec2::new(x, -y), Vec2::new(x, y)]
    }

    /// Returns the team whose kick-off is not over yet.
    pub fn kick_off_team(&self, memory: &PlayerMemory) -> Option<Team> {
        memory.kick_off_since_s.map(|_| self.status.kick_off_team)
    }

    /// Returns whether the rules let only the keeper into its own penalty area.
    pub fn is_own_area_for_keeper_only(&self) -> bool {
        self.rules.illegal_defender && self.rules.defender_limit == DefenderLimit::KeeperOnly
    }

    /// Returns whether the player walks in steps, as real robots do, and unlike those of the paper.
    pub fn walks_in_steps(&self) -> bool {
        self.motion.gait.is_some()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use naoisis_core::game::GameState;
    use naoisis_core::robot::motion::after_step;
    use naoisis_core::team::Team;

    /// Values for a [`Player`], for tests.
    #[derive(Clone, Debug)]
    pub struct PlayerFixture {
        pub id: RobotId,
        pub belief: Belief,
        pub heard: Vec<ReceivedMessage>,
        pub status: GameStatus,
        pub body: BodyStatus,
        pub sonar: SonarReading,
        pub sonar_settings: SonarSettings,
        pub motion: MotionSettings,
        pub kicks: KickSettings,
        pub latency: Latency,
        pub own_body: Body,
        pub head: Head,
        pub rolling: Rolling,
        pub pitch: Pitch,
        pub rules: Rules,
        pub period: f32,
    }

    impl PlayerFixture {
        /// Blue's number 2, with the ball in play.
        pub fn new(pose: Pose, ball: Vec2) -> Self {
            Self {
                id: RobotId::new(Team::Blue, 2),
                belief: Belief { ball: Some(BallBelief { position_m: ball, ..default() }), ..Belief::at(pose) },
                heard: Vec::new(),
                status: GameStatus { state: GameState::Playing, ..default() },
                body: BodyStatus::Standing,
                sonar: SonarReading::default(),
                sonar_settings: SonarSettings::default(),
                motion: MotionSettings::default(),
                kicks: KickSettings::default(),
                latency: Latency::default(),
                own_body: Body::default(),
                head: Head::default(),
                rolling: Rolling::default(),
                pitch: Pitch::default(),
                rules: Rules::default(),
                period: 1.0 / 30.0,
            }
        }

        /// Returns the player.
        pub fn player(&self) -> Player<'_> {
            Player {
                id: self.id,
                belief: &self.belief,
                heard: &self.heard,
                status: &self.status,
                body: self.body,
                sonar: self.sonar,
                sonar_settings: &self.sonar_settings,
                motion: &self.motion,
                kicks: &self.kicks,
                latency: &self.latency,
                own_body: &self.own_body,
                head: self.head,
                rolling: self.rolling,
                ball_radius_m: NAO_BALL_RADIUS_M,
                pitch: &self.pitch,
                rules: &self.rules,
                period: self.period,
                forward: self.belief.pose.forward(),
            }
        }
    }

    /// Where a step leads; it must be within the limits of 0.2 m/s and 90 degrees per second.
    pub fn after_decision(pose: Pose, decision: &Decision) -> Pose {
        let step = decision.walk;
        assert!(step.translation().length() < 0.2 / 30.0 + 1e-6);
        assert!(step.dtheta.abs() < core::f32::consts::FRAC_PI_2 / 30.0 + 1e-6);
        after_step(pose, step)
    }
}

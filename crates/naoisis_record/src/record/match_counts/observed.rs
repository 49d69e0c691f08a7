//! The input of the counter, from the record of a cycle or from the running match.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;

use super::MatchCounts;
use naoisis_core::ball::Ball;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::{CycleEvents, MatchEvent};
use naoisis_core::game::{Game, GameState, Penalty, Score};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::End;
use naoisis_core::robot::Velocity;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::scenario::Scenario;

/// A cycle, as the counter reads it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Observed<'a> {
    /// Its number.
    pub cycle: u64,
    /// Its end, s since the start of the match.
    pub time_s: f64,
    /// The state of the game after the cycle.
    pub state: GameState,
    /// The half after the cycle, from 1.
    pub half: u32,
    /// The score after the cycle.
    pub score: Score,
    /// The end that the blue team defends.
    pub blue_end: End,
    /// The numbers of the goalkeepers that have replaced those with number 1.
    pub goalkeepers: PerTeam<Option<u8>>,
    /// The position of the ball, m, pitch frame. `None` without a ball.
    pub ball_m: Option<Vec2>,
    /// The events of the cycle.
    pub events: &'a [MatchEvent],
}

impl Observed<'_> {
    /// Returns the end that `team` defends.
    pub fn own_end(&self, team: Team) -> End {
        match team {
            Team::Blue => self.blue_end,
            Team::Pink => self.blue_end.opposite(),
        }
    }
}

impl<'a> From<&'a CycleRecord> for Observed<'a> {
    fn from(record: &'a CycleRecord) -> Self {
        Self {
            cycle: record.cycle,
            time_s: record.time_s,
            state: record.game.state,
            half: record.game.half,
            score: record.game.score,
            blue_end: record.game.blue_end,
            goalkeepers: record.game.goalkeepers,
            ball_m: record.ball.map(|ball| ball.position_m.truncate()),
            events: &record.events,
        }
    }
}

/// A robot after a cycle, as the counter reads it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ObservedRobot<'a> {
    /// The robot's id.
    pub id: RobotId,
    /// True pose, pitch frame.
    pub pose: Pose,
    /// True speed, m/s.
    pub speed_mps: f32,
    /// Whether the robot serves a penalty.
    pub is_penalised: bool,
    /// Whether the robot is upright.
    pub is_upright: bool,
    /// Whether the robot recognises the ball.
    pub sees_ball: bool,
    /// The robot's belief.
    pub belief: Option<&'a Belief>,
}

impl<'a> From<&'a RobotRecord> for ObservedRobot<'a> {
    fn from(robot: &'a RobotRecord) -> Self {
        Self {
            id: robot.id,
            pose: robot.pose,
            speed_mps: robot.velocity.linear.length(),
            is_penalised: robot.penalised.is_some(),
            is_upright: robot.posture.is_upright(),
            sees_ball: robot.percepts.ball.is_some(),
            belief: robot.belief.as_ref(),
        }
    }
}

/// The components of a robot that are counted.
#[derive(QueryData)]
struct CountedRobot {
    id: &'static RobotId,
    pose: &'static Pose,
    velocity: &'static Velocity,
    penalty: &'static Penalty,
    posture: &'static Posture,
    percepts: Option<&'static Percepts>,
    belief: Option<&'static Belief>,
}

impl<'a> From<CountedRobotItem<'a, '_>> for ObservedRobot<'a> {
    fn from(robot: CountedRobotItem<'a, '_>) -> Self {
        Self {
            id: *robot.id,
            pose: *robot.pose,
            speed_mps: robot.velocity.linear.length(),
            is_penalised: robot.penalty.is_active(),
            is_upright: robot.posture.is_upright(),
            sees_ball: robot.percepts.is_some_and(|percepts| percepts.ball.is_some()),
            belief: robot.belief,
        }
    }
}

/// Counts a running match. It reads components, so that no records are needed.
pub struct MatchCounter {
    counts: MatchCounts,
    balls: QueryState<&'static Pose, With<Ball>>,
    robots: QueryState<CountedRobot>,
}

impl MatchCounter {
    /// Begins to count the match in `world` in its present state. Earlier events do not count.
    pub fn begin(world: &mut World) -> Self {
        let counts = MatchCounts::new(world.resource::<Scenario>());
        let mut counter = Self { counts, balls: world.query_filtered(), robots: world.query() };
        counter.observe(world);
        counter
    }

    /// Counts the last completed cycle.
    pub fn observe(&mut self, world: &World) {
        let (clock, game) = (world.resource::<CycleClock>(), world.resource::<Game>());
        let cycle = Observed {
            cycle: clock.cycle,
            time_s: clock.end_time_s(),
            state: game.state,
            half: game.half,
            score: game.score,
            blue_end: game.blue_end,
            goalkeepers: game.goalkeepers,
            ball_m: self.balls.iter(world).next().map(|ball| ball.position),
            events: world.resource::<CycleEvents>(),
        };
        self.counts.look(&cycle, self.robots.iter(world).map(ObservedRobot::from));
    }

    /// Returns the counts up to now.
    pub fn counts(&self) -> &MatchCounts {
        &self.counts
    }
}

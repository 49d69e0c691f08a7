//! Continues a match from one moment many times, with different random numbers ("what if").
//!
//! A [`Moment`] is the state of a match between two cycles. A [branch](play_branches) continues it with its own random numbers. Values that
//! were drawn before, such as the mounting errors of a robot's cameras, stay the same. [`Outcomes`] has statistics of the results.

use bevy::prelude::*;
use serde::Serialize;
use std::sync::atomic::AtomicBool;

use naoisis_agents::agents;
use naoisis_core::cycle::{CycleClock, run_cycle};
use naoisis_core::events::{CycleEvents, MatchEvent};
use naoisis_core::game::{Game, GameState};
use naoisis_core::geometry::Pose;
use naoisis_core::statistics::{self, Estimate};
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::simulation::{MatchApp, Snapshot, SnapshotError, play_in_order};

pub mod chances;

/// The state of a match between two cycles as bytes. Each thread restores it into its own world.
#[derive(Clone, PartialEq, Debug)]
pub struct Moment {
    bytes: Vec<u8>,
    /// Time of the match, s since its start.
    pub time_s: f64,
    /// The score at that time.
    pub score: PerTeam<u32>,
    /// The state of the game at that time.
    pub state: GameState,
}

impl Moment {
    /// Saves the match in `world` in its present state.
    ///
    /// # Errors
    /// If the state cannot be saved.
    pub fn of(world: &mut World) -> Result<Moment, SnapshotError> {
        let bytes = Snapshot::take(world)?.to_bytes(world)?;
        let time_s = world.resource::<CycleClock>().end_time_s();
        Ok(Moment { bytes, time_s, score: score(world), state: world.resource::<Game>().state })
    }

    /// Restores the match in `world`, to continue as it did.
    ///
    /// # Errors
    /// If the state is not of a match that `world` can have.
    pub fn put_back(&self, world: &mut World) -> Result<(), SnapshotError> {
        Snapshot::from_bytes(&self.bytes, world)?.restore(world)
    }

    /// Returns the bytes of the match in the format of a [saved match](Snapshot::save).
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the memory that the moment takes, bytes.
    pub fn size_bytes(&self) -> usize {
        self.bytes.len()
    }

    /// Restores the match in `world`, to continue with the random numbers of `seed`.
    ///
    /// # Errors
    /// If the state is not of a match that `world` can have.
    pub fn restore(&self, world: &mut World, seed: u64) -> Result<(), SnapshotError> {
        Snapshot::from_bytes(&self.bytes, world)?.restore_with_chance(world, seed)
    }
}

/// Returns whether the match in `app` agrees with the record of its last cycle in a trace that has `fields`. Compares the positions of robots and ball,
/// as far as they are recorded.
pub fn is_same(app: &App, record: &CycleRecord, fields: &Fields) -> bool {
    /// The tolerance of positions, m: traces have rounded numbers.
    const TOLERANCE_M: f32 = 2e-3;
    let is_near = |here: Pose, there: Vec2| here.position.distance(there) < TOLERANCE_M;
    let is_there =
        |robot: &RobotRecord| app.robot_pose(robot.id).is_some_and(|here| is_near(here, robot.pose.position));
    let same_robots = !fields.has("robots.pose") || record.robots.iter().all(is_there);
    let balls = record.ball.as_ref().zip(app.ball());
    same_robots && balls.is_none_or(|(ball, here)| is_near(here, ball.position_m.truncate()))
}

fn score(world: &World) -> PerTeam<u32> {
    world.resource::<Game>().score
}

/// The result of one branch.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Continuation {
    /// Index of the branch, from 0.
    pub index: usize,
    /// The seed of its random numbers.
    pub seed: u64,
    /// The goals of both teams since the moment.
    pub goals: PerTeam<u32>,
    /// The team that scored first, and the time after the moment, s.
    pub first_goal: Option<(Team, f64)>,
    /// The position of the ball at the end, m, pitch frame. `None` without a ball.
    pub ball_m: Option<Vec2>,
    /// The time at the end, s since the start of the match.
    pub end_s: f64,
    /// The robots that lost their programs, and how.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub programs_lost: Vec<ProgramLost>,
}

/// A program that was lost.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct ProgramLost {
    /// The robot that it played.
    pub robot: RobotId,
    /// What happened.
    pub message: String,
}

/// The programs that were lost in the last cycle of the match in `world`.
pub fn programs_lost(world: &World) -> impl Iterator<Item = ProgramLost> {
    world.resource::<CycleEvents>().iter().filter_map(|event| match event {
        MatchEvent::AgentLost { robot, message, .. } => Some(ProgramLost { robot: *robot, message: message.clone() }),
        _ => None,
    })
}

/// The number, length and seeds of branches.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Continuations {
    /// Number of branches to play.
    pub times: usize,
    /// Length of a branch, s. It ends earlier at the final whistle.
    pub for_s: f64,
    /// Seed of the first branch; it grows by one from branch to branch.
    pub first_seed: u64,
    /// Number of branches that are played at the same time, at least 1.
    pub threads: usize,
}

/// Plays branches of `moment`, each with the next seed, and passes their results to `finished` in the order of the seeds. When `stop`
/// becomes true, the branches under way are finished and no others begin.
///
/// # Errors
/// If the moment cannot be restored in an app that `simulator` makes.
pub fn play_branches(
    moment: &Moment,
    branches: &Continuations,
    simulator: impl Fn() -> App + Sync,
    stop: &AtomicBool,
    finished: impl FnMut(Continuation),
) -> Result<(), SnapshotError> {
    let begin = |app: &mut App, seed: u64| moment.restore(app.world_mut(), seed);
    play_branches_from(moment, begin, branches, simulator, stop, finished)
}

/// Plays branches of `moment` like [`play_branches`]. `begin` brings the match in an app to the moment, with the random numbers of a seed:
/// for matches of programs, whose thoughts are not saved.
///
/// # Errors
/// The first error of `begin`.
pub fn play_branches_from<E: Send>(
    moment: &Moment,
    begin: impl Fn(&mut App, u64) -> Result<(), E> + Sync,
    branches: &Continuations,
    simulator: impl Fn() -> App + Sync,
    stop: &AtomicBool,
    mut finished: impl FnMut(Continuation),
) -> Result<(), E> {
    let worker = || {
        let mut app = simulator();
        // The branches themselves use the cores.
        app.insert_resource(SensingThreads(1));
        app
    };
    let play = |app: &mut App, index: usize| {
        let seed = branches.first_seed.wrapping_add(index as u64);
        begin(app, seed)?;
        Ok(play(app, moment, branches.for_s, index, seed))
    };
    play_in_order(0..branches.times, branches.threads, stop, worker, play, |branch| branch.map(&mut finished))
}

/// Plays a branch that has begun.
fn play(app: &mut App, moment: &Moment, for_s: f64, index: usize, seed: u64) -> Continuation {
    let world = app.world_mut();
    let (mut first_goal, mut lost) = (None, Vec::new());
    let goals = |world: &World| {
        let now = score(world);
        PerTeam { blue: now.blue.saturating_sub(moment.score.blue), pink: now.pink.saturating_sub(moment.score.pink) }
    };
    while world.resource::<CycleClock>().end_time_s() - moment.time_s < for_s - 1e-6
        && world.resource::<Game>().state != GameState::Finished
    {
        run_cycle(world);
        lost.extend(programs_lost(world));
        if first_goal.is_none() {
            let scorer = Team::BOTH.into_iter().find(|team| goals(world)[*team] > 0);
            first_goal = scorer.map(|team| (team, world.resource::<CycleClock>().end_time_s() - moment.time_s));
        }
    }
    agents::dismiss(world, "end");
    let goals = goals(world);
    let end_s = world.resource::<CycleClock>().end_time_s();
    let ball_m = app.ball().map(|ball| ball.position);
    Continuation { index, seed, goals, first_goal, ball_m, end_s, programs_lost: lost }
}

/// Statistics of the branches of a moment, with intervals of 95 % confidence.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[non_exhaustive]
pub struct Outcomes {
    /// Number of branches that were played.
    pub times: usize,
    /// Share of branches in which each team scores.
    pub scores: PerTeam<Option<Estimate>>,
    /// Share of branches in which each team scores first.
    pub scores_first: PerTeam<Option<Estimate>>,
    /// Share of branches without a goal.
    pub nobody_scores: Option<Estimate>,
    /// Mean of blue's goals minus pink's.
    pub goal_difference: Option<Estimate>,
    /// Median time of the first goal, s after the moment, of the branches with a goal.
    pub first_goal_s: Option<f64>,
    /// Mean position of the ball at the end, m, pitch frame.
    pub ball_m: Option<[Estimate; 2]>,
}

impl Outcomes {
    /// Computes the outcomes of `branches`.
    pub fn of(branches: &[Continuation]) -> Self {
        let share = |holds: &dyn Fn(&Continuation) -> bool| {
            statistics::share(branches.iter().filter(|branch| holds(branch)).count(), branches.len())
        };
        let per_team = |holds: fn(&Continuation, Team) -> bool| {
            let of = |team| share(&|branch| holds(branch, team));
            PerTeam { blue: of(Team::Blue), pink: of(Team::Pink) }
        };
        let mean = |value: &dyn Fn(&Continuation) -> Option<f64>| {
            statistics::mean(&branches.iter().filter_map(value).collect::<Vec<f64>>())
        };
        let ball = |axis: usize| mean(&|branch| branch.ball_m.map(|ball| f64::from(ball[axis])));
        Self {
            times: branches.len(),
            scores: per_team(|branch, team| branch.goals[team] > 0),
            scores_first: per_team(|branch, team| branch.first_goal.is_some_and(|(scorer, _)| scorer == team)),
            nobody_scores: share(&|branch| branch.first_goal.is_none()),
            goal_difference: mean(&|branch| Some(f64::from(branch.goals.blue) - f64::from(branch.goals.pink))),
            first_goal_s: statistics::median(
                branches.iter().filter_map(|branch| branch.first_goal.map(|(_, time_s)| time_s)).collect(),
            ),
            ball_m: ball(0).zip(ball(1)).map(|(x, y)| [x, y]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn simulator() -> App {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app
    }

    fn moment() -> Moment {
        let mut app = simulator();
        let scenario = Scenario::from_json(
            r#"{ "realism": "realistic", "rules": "free", "ball": { "position_m": [0.16, -0.05] }, "robots": [
                 { "number": 1, "behaviour": { "script": [{ "from_s": 4, "kick": { "type": "right_straight" } }] } }] }"#,
        );
        app.start_match(&scenario.unwrap()).unwrap();
        // Shortly before the kick, whose direction and speed are random.
        app.run_cycles(100);
        Moment::of(app.world_mut()).unwrap()
    }

    fn played(moment: &Moment, threads: usize) -> Vec<Continuation> {
        let branches = Continuations { times: 4, for_s: 3.0, first_seed: 7, threads };
        let mut rows = Vec::new();
        play_branches(moment, &branches, simulator, &AtomicBool::new(false), |branch| rows.push(branch)).unwrap();
        rows
    }

    #[test]
    fn branches_differ_by_their_seed_alone_and_come_in_order_on_any_number_of_threads() {
        let moment = moment();
        let rows = played(&moment, 1);
        assert_eq!(played(&moment, 3), rows);
        assert_eq!(
            rows.iter().map(|branch| (branch.index, branch.seed)).collect::<Vec<_>>(),
            [(0, 7), (1, 8), (2, 9), (3, 10)]
        );
        assert!(rows.iter().all(|branch| (branch.end_s - moment.time_s - 3.0).abs() < 0.02));
        assert!(rows.windows(2).any(|pair| pair[0].ball_m != pair[1].ball_m));
    }

    #[test]
    fn a_moment_with_its_own_seed_begins_as_it_was() {
        let moment = moment();
        let mut app = simulator();
        moment.restore(app.world_mut(), 3).unwrap();
        let again = Moment::of(app.world_mut()).unwrap();
        assert_eq!((again.time_s, again.score), (moment.time_s, moment.score));
    }

    #[test]
    fn outcomes_are_shares_of_the_branches() {
        let branch = |index: usize, blue: u32, pink: u32, first: Option<(Team, f64)>| Continuation {
            index,
            seed: 1,
            goals: PerTeam { blue, pink },
            first_goal: first,
            ball_m: Some(Vec2::new(1.0, -1.0)),
            end_s: 30.0,
            programs_lost: Vec::new(),
        };
        let outcomes = Outcomes::of(&[
            branch(0, 2, 1, Some((Team::Pink, 4.0))),
            branch(1, 1, 0, Some((Team::Blue, 8.0))),
            branch(2, 0, 0, None),
            branch(3, 0, 0, None),
        ]);
        let value = |estimate: Option<Estimate>| estimate.unwrap().value;
        assert_eq!((value(outcomes.scores.blue), value(outcomes.scores.pink)), (0.5, 0.25));
        assert_eq!((value(outcomes.scores_first.blue), value(outcomes.nobody_scores)), (0.25, 0.5));
        assert_eq!((value(outcomes.goal_difference), outcomes.first_goal_s), (0.5, Some(6.0)));
        assert_eq!(outcomes.ball_m.unwrap()[1].value, -1.0);
    }
}

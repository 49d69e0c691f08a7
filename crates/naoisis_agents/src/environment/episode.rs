//! One world of an environment: episode after episode.

use bevy::prelude::*;
use rand::{Rng, RngExt};
use std::sync::Arc;

use super::action::{ActionKind, command};
use super::challenge::{EndConditions, Situation};
use super::observation::{Memory, ObservationKind, observe};
use super::reward::{RewardWeights, Standing};
use crate::agents::{self, RobotCommand};
use naoisis_core::camera_model::CameraName;
use naoisis_core::communication::TeamMessage;
use naoisis_core::cycle::{CycleClock, perceive, run_cycle};
use naoisis_core::events::CycleEvents;
use naoisis_core::game::{Game, GameState};
use naoisis_core::geometry::Pose;
use naoisis_core::random::RandomStream;
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::Roster;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::camera::CameraImages;
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::scenario::{Scenario, ScenarioFault};
use naoisis_sim::simulation::{Snapshot, start_match};

/// What episodes start from.
pub enum Start {
    /// One of several scenarios, drawn anew for each episode; their seeds do not matter.
    Scenarios {
        /// The first of them.
        first: Box<Scenario>,
        /// The others, if any.
        others: Vec<Scenario>,
        /// Where things stand, drawn anew as well.
        situation: Situation,
    },
    /// A moment of a match, with other chance to come each time.
    Moment(Snapshot),
}

/// Why an episode cannot begin.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// Its match cannot be started.
    #[error(transparent)]
    Scenario(#[from] ScenarioFault),
    /// Its moment is none that the simulator can go on from.
    #[error("{0}")]
    Moment(String),
    /// It is another match than the environment was made for.
    #[error("an episode cannot begin so: {0}")]
    Different(String),
}

/// What all worlds of an environment have in common.
#[derive(Clone)]
pub struct EnvironmentSettings {
    /// What episodes start from, unless a world was told otherwise.
    pub start: Arc<Start>,
    /// The robots that are controlled, at least one, in the order of their ids.
    pub control: Vec<RobotId>,
    /// What ends episodes.
    pub end: EndConditions,
    /// What agents observe.
    pub observation: ObservationKind,
    /// The camera whose images they observe, too, if any.
    pub camera: Option<CameraName>,
    /// What agents do.
    pub action: ActionKind,
    /// Cycles that an action lasts, at least 1.
    pub cycles_per_step: u32,
    /// What they are rewarded for.
    pub reward: RewardWeights,
}

/// How an episode goes on after a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct EpisodeProgress {
    /// It is over, and what comes after it is worth nothing.
    pub terminated: bool,
    /// Its time is over.
    pub truncated: bool,
    /// It ended as the task wants it.
    pub is_success: bool,
}

impl EpisodeProgress {
    /// Whether the episode is over.
    pub fn is_over(self) -> bool {
        self.terminated || self.truncated
    }
}

/// One world, in which one episode after the other is played.
pub struct Episode {
    /// The match under way.
    pub world: World,
    /// What its episodes start from, if not what those of all worlds do.
    pub start: Option<Arc<Start>>,
    seeds: RandomStream,
    memories: Vec<Memory>,
    standings: Vec<Standing>,
    /// How the last step left the episode.
    pub progress: EpisodeProgress,
}

impl Episode {
    /// An episode that has not begun, in a simulator without a match.
    pub fn new(world: World, seed: u64) -> Self {
        let (memories, standings, progress) = (Vec::new(), Vec::new(), EpisodeProgress::default());
        Self { world, start: None, seeds: seeds(seed), memories, standings, progress }
    }

    /// Begins with the episodes of this seed.
    pub fn seed(&mut self, seed: u64) {
        self.seeds = seeds(seed);
    }

    /// Starts the next episode.
    ///
    /// # Errors
    /// When its match cannot be started.
    pub fn begin(&mut self, settings: &EnvironmentSettings) -> Result<(), StartError> {
        let seed = self.seeds.next_u64();
        match &**self.start.as_ref().unwrap_or(&settings.start) {
            Start::Scenarios { first, others, situation } => {
                let scenario = Scenario { seed, ..one_of(first, others, seed).clone() };
                start_match(&mut self.world, &situation.drawn(scenario))?;
            }
            Start::Moment(snapshot) => {
                let restored = snapshot.restore_with_chance(&mut self.world, seed);
                restored.map_err(|error| StartError::Moment(error.to_string()))?;
            }
        }
        for id in &settings.control {
            if settings.observation == ObservationKind::Belief {
                // They are remote, and there.
                let _ = agents::believe(&mut self.world, *id);
            }
        }
        perceive(&mut self.world);
        self.progress = EpisodeProgress::default();
        self.memories.clear();
        let odometry_of =
            |id: &RobotId| self.world.resource::<Roster>().get(*id).map(|robot| odometry(&self.world, robot));
        let odometries = settings.control.iter().map(|id| odometry_of(id).unwrap_or_default());
        self.memories.extend(odometries.map(|odometry| Memory { odometry }));
        self.standings.clear();
        self.standings.extend(settings.control.iter().map(|id| Standing::of(&self.world, *id)));
        Ok(())
    }

    /// Plays a step with the actions of all agents, one after the other, and fills in what each is rewarded with.
    pub fn step(&mut self, settings: &EnvironmentSettings, actions: &[f32], rewards: &mut [f32]) {
        let world = &mut self.world;
        let length = settings.action.len();
        let mut commands: Vec<RobotCommand> = settings
            .control
            .iter()
            .zip(actions.chunks(length))
            .map(|(id, action)| {
                let say = (settings.observation == ObservationKind::Belief).then(|| words(world, *id)).flatten();
                RobotCommand { say, ..command(settings.action, action, world, *id) }
            })
            .collect();
        let mut progress = EpisodeProgress::default();
        let mut cycles = 0;
        while cycles < settings.cycles_per_step.max(1) && !progress.is_over() {
            for (id, command) in settings.control.iter().zip(&mut commands) {
                let given = command.clone();
                // Walking goes on; the rest is done once.
                *command = RobotCommand { walk: given.walk, ..default() };
                // They are remote, and there.
                let _ = agents::command(world, *id, given);
            }
            run_cycle(world);
            cycles += 1;
            progress = progress_of(world, settings);
        }
        let period_s = cycles as f32 * world.resource::<CycleClock>().period();
        for ((id, reward), standing) in settings.control.iter().zip(rewards).zip(&mut self.standings) {
            let now = Standing::of(world, *id);
            let is_success = progress.is_success && settings.end.is_for(id.team);
            *reward = standing.reward(&now, period_s, is_success, &settings.reward);
            *standing = now;
        }
        self.progress = progress;
        perceive(world);
    }

    /// Fills in what each agent observes now: numbers, and images where they observe some.
    pub fn observe(&mut self, settings: &EnvironmentSettings, observations: &mut [f32], images: &mut [u8]) {
        let agents = settings.control.len().max(1);
        let (length, bytes) = (observations.len() / agents, images.len() / agents);
        for (index, id) in settings.control.iter().enumerate() {
            let array = &mut observations[index * length..(index + 1) * length];
            let entity = self.world.resource::<Roster>().get(*id);
            if let Some(memory) = self.memories.get_mut(index) {
                observe(array, settings.observation, &self.world, *id, memory);
                memory.odometry = entity.map(|entity| odometry(&self.world, entity)).unwrap_or_default();
            }
            if let Some(side) = settings.camera {
                let image = &mut images[index * bytes..(index + 1) * bytes];
                let seen = entity.and_then(|entity| self.world.get::<CameraImages>(entity));
                match seen.map(|images| &images.of(side).rgb) {
                    Some(rgb) if rgb.len() == image.len() => image.copy_from_slice(rgb),
                    // Who is not on the pitch sees nothing.
                    _ => image.fill(0),
                }
            }
        }
    }
}

/// One of several scenarios, by chance. Of a single one, chance decides nothing.
fn one_of<'a>(first: &'a Scenario, others: &'a [Scenario], seed: u64) -> &'a Scenario {
    let index = RandomStream::for_match(seed, "scenario").random_range(0..=others.len());
    index.checked_sub(1).and_then(|index| others.get(index)).unwrap_or(first)
}

/// A robot's way by its own steps.
fn odometry(world: &World, robot: Entity) -> Pose {
    world.get::<Odometry>(robot).map(|odometry| odometry.0).unwrap_or_default()
}

/// What a robot that believes something tells its team-mates, as those of the built-in teams do: where it is, and where it has
/// seen the ball of late. Nothing where a league counts messages.
fn words(world: &World, id: RobotId) -> Option<TeamMessage> {
    /// A ball seen within this time is worth telling of, s.
    const FRESH_BALL_S: f32 = 0.5;
    let robot = world.get_entity(world.resource::<Roster>().get(id)?).ok()?;
    let belief = robot.get::<Belief>()?;
    if robot.get::<GameStatus>().is_some_and(|status| status.penalised || status.messages_left.is_some()) {
        return None;
    }
    let ball = belief.ball.filter(|ball| ball.heard_from.is_none() && ball.age_s < FRESH_BALL_S);
    Some(TeamMessage { pose: Some(belief.pose), ball_m: ball.map(|ball| ball.position_m), ..default() })
}

fn seeds(seed: u64) -> RandomStream {
    RandomStream::for_match(seed, "episodes")
}

/// Whether the last cycle ended the episode.
fn progress_of(world: &World, settings: &EnvironmentSettings) -> EpisodeProgress {
    if let Some(is_success) = settings.end.of_events(world.resource::<CycleEvents>().iter()) {
        return EpisodeProgress { terminated: true, truncated: false, is_success };
    }
    let sees_ball = |id: &RobotId| {
        let entity = world.resource::<Roster>().get(*id);
        entity.and_then(|entity| world.get::<Percepts>(entity)).is_some_and(|percepts| percepts.ball.is_some())
    };
    if settings.end.ball_seen && settings.control.first().is_some_and(sees_ball) {
        return EpisodeProgress { terminated: true, truncated: false, is_success: true };
    }
    let cycle = world.resource::<CycleClock>().cycle;
    let last_cycle = world.get_resource::<Scenario>().and_then(Scenario::last_cycle);
    let game = world.resource::<Game>();
    let terminated = game.state == GameState::Finished;
    let has_won = |team: Team| game.score[team] > game.score[team.opponent()];
    EpisodeProgress {
        terminated,
        truncated: last_cycle.is_some_and(|last| cycle >= last),
        is_success: terminated && settings.end.win_for.is_some_and(has_won),
    }
}

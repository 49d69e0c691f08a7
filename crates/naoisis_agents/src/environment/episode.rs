//! The episodes of one world of an environment.

use bevy::prelude::*;
use core::sync::atomic::{AtomicBool, Ordering};
use rand::{Rng, RngExt};
use std::sync::Arc;

use super::action::{ActionKind, command};
use super::action_space::ActionSpace;
use super::counts::{BeginCounter, EndedEpisode, EpisodeCounter, EpisodeOrigin};
use super::draws::DrawnScenarios;
use super::ending::{Course, EndConditions, EpisodeProgress};
use super::heard::with_words;
use super::kind::{ObservationForm, ObservationKind};
use super::memory::Memory;
use super::observation::{TrueState, observe};
use super::reward::{RewardWeights, Standing};
use super::situation::Situation;
use super::start_error::StartError;
use crate::agents::{self, AgentSettings, Commander, RobotCommand};
use naoisis_core::behaviour::{REMOTE, WithoutBehaviour};
use naoisis_core::camera_model::CameraName;
use naoisis_core::communication::TeamMessage;
use naoisis_core::cycle::{CycleClock, perceive, run_cycle};
use naoisis_core::events::{CycleEvents, MatchEvent};
use naoisis_core::geometry::Pose;
use naoisis_core::random::RandomStream;
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::camera::CameraImages;
use naoisis_sensing::sensing::latency::LatencyQueues;
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::scene::SensesNothing;
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sensing::sensing::vision::{Percepts, VisionSettings, VisionSource};
use naoisis_sim::scenario::{BehaviourSpec, Scenario};
use naoisis_sim::simulation::{Snapshot, give_belief, start_match};

/// The start of episodes.
pub enum Start {
    /// One of several scenarios, drawn for each episode; their seeds are ignored.
    Scenarios {
        /// The first scenario.
        first: Box<Scenario>,
        /// Further scenarios.
        others: Vec<Scenario>,
        /// The areas of start positions.
        situation: Situation,
    },
    /// Scenarios of which some fields are drawn for each episode.
    Drawn(Box<DrawnScenarios>),
    /// A moment of a match; each episode continues from it with other random numbers.
    Moment(Snapshot),
}

/// The settings that all worlds of an environment share.
#[derive(Clone)]
pub struct EnvironmentSettings {
    /// The start of episodes, unless a world has one of its own.
    pub start: Arc<Start>,
    /// The controlled robots, at least one, sorted by id.
    pub control: Vec<RobotId>,
    /// What ends episodes.
    pub end: EndConditions,
    /// What is observed, and what robots can say.
    pub observed: ObservationForm,
    /// The camera whose images are observed, if any.
    pub camera: Option<CameraName>,
    /// Whether the controlled robots have no vision and no sonar, because nothing reads them. Robots that see by camera images keep them.
    pub blind: bool,
    /// The kind of actions.
    pub action: ActionKind,
    /// The number of cycles for which an action is held, at least 1.
    pub cycles_per_step: u32,
    /// The weights of the reward.
    pub reward: RewardWeights,
    /// What counts the episodes, if anything does.
    pub counter: Option<BeginCounter>,
}

impl EnvironmentSettings {
    /// The numbers of an action. Words for which an action has no place are left out.
    pub fn actions(&self) -> ActionSpace {
        ActionSpace::new(self.action, self.observed.extras.words).unwrap_or_else(|_| self.action.into())
    }
}

/// One world, in which episodes are played one after the other.
pub struct Episode {
    /// The current match.
    pub world: World,
    /// The start of its episodes, if it differs from that of the settings.
    pub start: Option<Arc<Start>>,
    /// The seed of the match of the next episode, instead of that of its sequence.
    pub match_seed: Option<u64>,
    /// Breaks off a step when it becomes true. Its episode cannot go on then.
    pub stop: Arc<AtomicBool>,
    pub(super) seeds: RandomStream,
    pub(super) memories: Vec<Memory>,
    pub(super) standings: Vec<Standing>,
    pub(super) course: Course,
    pub(super) origin: EpisodeOrigin,
    pub(super) counter: Option<Box<dyn EpisodeCounter>>,
    /// Commands the robots of its world, from the first step of an episode on.
    commander: Option<Commander>,
    /// The episode that ended in the last step, if one did.
    pub(super) ended: Option<EndedEpisode>,
    /// The robot whose program was lost in the last step, and what happened.
    pub(super) lost: Option<(RobotId, String)>,
    /// The state after the last step.
    pub progress: EpisodeProgress,
}

impl Episode {
    /// Creates a world without an episode, from a simulator without a match.
    pub fn new(world: World, seed: u64) -> Self {
        let (memories, standings, progress) = (Vec::new(), Vec::new(), EpisodeProgress::default());
        let (stop, seeds, course) = (Arc::default(), seeds(seed), Course::default());
        let (origin, counter, ended) = (EpisodeOrigin::default(), None, None);
        Self {
            world,
            start: None,
            match_seed: None,
            stop,
            seeds,
            memories,
            standings,
            course,
            origin,
            counter,
            commander: None,
            ended,
            lost: None,
            progress,
        }
    }

    /// Restarts the sequence of episodes with `seed`.
    pub fn seed(&mut self, seed: u64) {
        self.seeds = seeds(seed);
    }

    /// The seed of the match of the first episode after [`seed`](Self::seed).
    pub(super) fn first_seed(seed: u64) -> u64 {
        seeds(seed).next_u64()
    }

    /// The scenario of the episode whose match has `seed`.
    pub(super) fn scenario_of(first: &Scenario, others: &[Scenario], situation: &Situation, seed: u64) -> Scenario {
        let index = one_of(1 + others.len(), seed);
        let scenario = index.checked_sub(1).and_then(|index| others.get(index)).unwrap_or(first);
        situation.drawn(Scenario { seed, ..scenario.clone() })
    }

    /// Starts the next episode.
    ///
    /// # Errors
    /// If the match of the episode cannot be started.
    pub fn begin(&mut self, settings: &EnvironmentSettings) -> Result<(), StartError> {
        let drawn = self.seeds.next_u64();
        let seed = self.match_seed.take().unwrap_or(drawn);
        self.origin = EpisodeOrigin { seed, ..default() };
        match &**self.start.as_ref().unwrap_or(&settings.start) {
            Start::Scenarios { first, others, situation } => {
                self.origin.scenario = one_of(1 + others.len(), seed);
                start_match(&mut self.world, &Self::scenario_of(first, others, situation, seed))?;
            }
            Start::Drawn(scenarios) => {
                self.origin.scenario = one_of(scenarios.files.len(), seed);
                let (scenario, values) = scenarios.scenario(&self.world, self.origin.scenario, seed)?;
                start_match(&mut self.world, &scenario)?;
                self.origin.drawn = values;
            }
            Start::Moment(snapshot) => {
                let restored = snapshot.restore_with_chance(&mut self.world, seed);
                restored.map_err(|error| StartError::Moment(error.to_string()))?;
            }
        }
        self.set_senses(settings);
        self.commander = None;
        if self.world.contains_resource::<AgentSettings>() {
            agents::start_programs(&mut self.world)?;
        }
        perceive(&mut self.world);
        self.progress = EpisodeProgress::default();
        self.course = Course::default();
        self.counter = settings.counter.map(|begin| begin(&mut self.world));
        self.memories.clear();
        let odometry_of =
            |id: &RobotId| self.world.resource::<Roster>().get(*id).map(|robot| odometry(&self.world, robot));
        let odometries = settings.control.iter().map(|id| odometry_of(id).unwrap_or_default());
        self.memories.extend(odometries.map(Memory::at));
        self.listen(settings);
        self.standings.clear();
        self.standings.extend(Standing::of_all(&self.world, &settings.control));
        Ok(())
    }

    /// Keeps the messages that arrived at the controlled robots in this cycle, if they are observed.
    fn listen(&mut self, settings: &EnvironmentSettings) {
        if !settings.observed.extras.messages {
            return;
        }
        for (id, memory) in settings.control.iter().zip(&mut self.memories) {
            if let Some(robot) = self.world.resource::<Roster>().get(*id) {
                memory.listen(&self.world, robot);
            }
        }
    }

    /// Gives the controlled robots beliefs if they are needed, or takes their vision and their sonar away, and says that they have no behaviour.
    pub(super) fn set_senses(&mut self, settings: &EnvironmentSettings) {
        let needs_belief =
            settings.observed.kind == ObservationKind::Belief || settings.end.believed_within_m.is_some();
        for id in &settings.control {
            if needs_belief {
                give_belief(&mut self.world, *id);
            }
            let Some(robot) = self.world.resource::<Roster>().get(*id) else { continue };
            let is_remote = self.world.get_resource::<Scenario>().is_some_and(|scenario| is_remote(scenario, *id));
            let mut robot = self.world.entity_mut(robot);
            if is_remote {
                robot.insert(WithoutBehaviour);
            }
            if !settings.blind {
                continue;
            }
            if robot.get::<VisionSettings>().is_none_or(|vision| vision.source != VisionSource::Image) {
                // What a moment's robot saw before does not stay.
                robot.insert((SensesNothing, Percepts::default(), SonarReading::default(), LatencyQueues::default()));
            }
        }
    }

    /// Plays a step with the `actions` of all agents one after the other, and writes the reward of each agent to `rewards`.
    pub fn step(&mut self, settings: &EnvironmentSettings, actions: &[f32], rewards: &mut [f32]) {
        let world = &self.world;
        let space = settings.actions();
        let commands: Vec<RobotCommand> = settings
            .control
            .iter()
            .zip(actions.chunks(space.len()))
            .map(|(id, action)| RobotCommand {
                say: said(space, action, settings.observed.kind, world, *id),
                ..command(settings.action, &action[..settings.action.len()], world, *id)
            })
            .collect();
        self.step_with(settings, commands, rewards);
    }

    /// Plays a step with the `commands` of all agents, like [`step`](Self::step).
    pub(super) fn step_with(
        &mut self,
        settings: &EnvironmentSettings,
        mut commands: Vec<RobotCommand>,
        rewards: &mut [f32],
    ) {
        let mut progress = EpisodeProgress::default();
        let mut cycles = 0;
        self.lost = None;
        while cycles < settings.cycles_per_step.max(1) && !progress.is_over() && !self.stop.load(Ordering::Relaxed) {
            let world = &mut self.world;
            let commander = self.commander.get_or_insert_with(|| Commander::new(world));
            for (id, command) in settings.control.iter().zip(&mut commands) {
                let given = command.clone();
                // The walk is commanded in each cycle of the step, everything else only in the first.
                *command = RobotCommand { walk: given.walk, ..default() };
                commander.command(world, *id, given);
            }
            run_cycle(world);
            if let Some(counter) = &mut self.counter {
                counter.observe(world);
            }
            let lost = || {
                world.resource::<CycleEvents>().iter().find_map(|event| match event {
                    MatchEvent::AgentLost { robot, message, .. } => Some((*robot, message.clone())),
                    _ => None,
                })
            };
            self.lost = self.lost.take().or_else(lost);
            cycles += 1;
            progress = settings.end.progress(world, &settings.control, &mut self.course);
            self.listen(settings);
        }
        let world = &mut self.world;
        let period_s = cycles as f32 * world.resource::<CycleClock>().period();
        let now = settings.control.iter().zip(Standing::of_all(world, &settings.control));
        for (((id, now), reward), standing) in now.zip(rewards).zip(&mut self.standings) {
            *reward = standing.reward(&now, period_s, progress.success_of[id.team], &settings.reward);
            *standing = now;
        }
        self.progress = progress;
        self.ended = progress.is_over().then(|| EndedEpisode {
            origin: self.origin.clone(),
            counts: self.counter.as_ref().map(|counter| counter.counts()).unwrap_or_default(),
        });
        perceive(world);
        self.listen(settings);
    }

    /// Writes the current observations of all agents: numbers, and images if a camera is observed.
    pub fn observe(&mut self, settings: &EnvironmentSettings, observations: &mut [f32], images: &mut [u8]) {
        let agents = settings.control.len().max(1);
        let (length, bytes) = (observations.len() / agents, images.len() / agents);
        let truth = TrueState::for_observation(settings.observed, &self.world);
        for (index, id) in settings.control.iter().enumerate() {
            let array = &mut observations[index * length..(index + 1) * length];
            let entity = self.world.resource::<Roster>().get(*id);
            if let Some(memory) = self.memories.get_mut(index) {
                if settings.observed.extras.tracked {
                    memory.follow(settings.observed, &self.world, *id);
                }
                observe(array, settings.observed, &self.world, *id, memory, &truth);
                memory.odometry = entity.map(|entity| odometry(&self.world, entity)).unwrap_or_default();
            }
            if let Some(side) = settings.camera {
                let image = &mut images[index * bytes..(index + 1) * bytes];
                let seen = entity.and_then(|entity| self.world.get::<CameraImages>(entity));
                match seen.map(|images| &images.of(side).rgb) {
                    Some(rgb) if rgb.len() == image.len() => image.copy_from_slice(rgb),
                    // A robot that is off the pitch has no image.
                    _ => image.fill(0),
                }
            }
        }
    }
}

/// The index of one of `count` scenarios, drawn by `seed`. A single scenario uses no random number.
fn one_of(count: usize, seed: u64) -> usize {
    RandomStream::for_match(seed, "scenario").random_range(0..count.max(1))
}

/// Whether a scenario lists a robot as one that is commanded from outside.
fn is_remote(scenario: &Scenario, id: RobotId) -> bool {
    let robot = scenario.robots.iter().find(|robot| robot.id() == id);
    robot.is_some_and(|robot| matches!(&robot.behaviour, BehaviourSpec::Named(name) if name == REMOTE))
}

/// The pose of a robot by its own odometry.
fn odometry(world: &World, robot: Entity) -> Pose {
    world.get::<Odometry>(robot).map(|odometry| odometry.0).unwrap_or_default()
}

/// The message that a robot with a belief sends its team-mates, like those of the built-in teams: its pose, and the position at which it
/// recently saw the ball. `None` in leagues with a limited number of messages.
pub(crate) fn team_message(world: &World, id: RobotId) -> Option<TeamMessage> {
    /// The greatest age of a ball position that is sent, s.
    const FRESH_BALL_S: f32 = 0.5;
    let robot = world.get_entity(world.resource::<Roster>().get(id)?).ok()?;
    let belief = robot.get::<Belief>()?;
    if robot.get::<GameStatus>().is_some_and(|status| status.penalised || status.messages_left.is_some()) {
        return None;
    }
    let ball = belief.ball.filter(|ball| ball.heard_from.is_none() && ball.age_s < FRESH_BALL_S);
    Some(TeamMessage { pose: Some(belief.pose), ball_m: ball.map(|ball| ball.position_m), ..default() })
}

/// What a robot says with an action: the message of its belief, if that is observed, and the words of the action. With words, the action
/// decides when the robot says something in leagues with a limited number of messages.
pub(crate) fn said(
    space: ActionSpace,
    action: &[f32],
    observation: ObservationKind,
    world: &World,
    id: RobotId,
) -> Option<TeamMessage> {
    let believed = || (observation == ObservationKind::Belief).then(|| team_message(world, id)).flatten();
    let is_penalised = || {
        let status = world.resource::<Roster>().get(id).and_then(|robot| world.get::<GameStatus>(robot));
        status.is_some_and(|status| status.penalised)
    };
    match space.said(action).filter(|_| !is_penalised()) {
        Some(words) => Some(with_words(believed(), &words)),
        None => believed(),
    }
}

fn seeds(seed: u64) -> RandomStream {
    RandomStream::for_match(seed, "episodes")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::player::ChallengePlayer;
    use crate::environment::state::ball_of;
    use crate::environment::{Challenge, prepared};
    use naoisis_core::robot::head::{HeadAngles, HeadLimits};
    use naoisis_core::team::Team;
    use naoisis_sim::scenario::Realism;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn simulator() -> App {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app
    }

    /// Plays 60 steps of two robots against a goalkeeper and a chaser. Returns whether the first robot saw anything, and all poses at the end,
    /// the ball's last.
    fn played(observation: ObservationKind) -> (bool, Vec<Pose>) {
        let challenge = Challenge::named("TwoOnTwo").unwrap().with(Realism::Realistic, None).unwrap();
        let settings = prepared::settings(&challenge, &ChallengePlayer::Random, simulator().world()).unwrap();
        let settings = EnvironmentSettings {
            observed: observation.into(),
            blind: observation == ObservationKind::Truth,
            ..settings
        };
        let mut episode = Episode::new(prepared::world(simulator), 3);
        episode.begin(&settings).unwrap();
        let robot = |world: &World, id| world.resource::<Roster>().get(id).unwrap();
        let actions = [0.7, 0.1, 0.2, 0.0, 0.3, 0.0, 0.0, 0.0].repeat(2);
        let mut has_seen = false;
        for _ in 0..60 {
            episode.step(&settings, &actions, &mut [0.0, 0.0]);
            let first = robot(&episode.world, settings.control[0]);
            has_seen |= !episode.world.get::<Percepts>(first).unwrap().landmarks.is_empty();
        }
        let keeper = robot(&episode.world, RobotId::new(Team::Pink, 1));
        assert!(!episode.world.entity(keeper).contains::<SensesNothing>(), "opponents sense");
        let roster = episode.world.resource::<Roster>();
        let robots = roster.iter().map(|(_, robot)| *episode.world.get::<Pose>(robot).unwrap());
        let (ball, _) = ball_of(&episode.world).unwrap();
        (has_seen, robots.chain([Pose::new(ball.x, ball.y, 0.0)]).collect())
    }

    #[test]
    fn robots_whose_truth_is_observed_sense_nothing_and_the_match_is_the_same() {
        let [perception, truth] = [ObservationKind::Perception, ObservationKind::Truth].map(played);
        assert_eq!((perception.0, truth.0), (true, false));
        assert_eq!(perception.1, truth.1);
    }

    #[test]
    fn the_head_of_a_robot_that_knows_the_truth_looks_at_the_ball() {
        let challenge = Challenge::named("GoToBall").unwrap();
        let settings = prepared::settings(&challenge, &ChallengePlayer::Random, simulator().world()).unwrap();
        let settings = EnvironmentSettings {
            observed: ObservationKind::Truth.into(),
            blind: true,
            action: ActionKind::Discrete,
            ..settings
        };
        let mut episode = Episode::new(prepared::world(simulator), 3);
        episode.begin(&settings).unwrap();
        for _ in 0..20 {
            // It turns to the left until the ball is ahead.
            episode.step(&settings, &[5.0], &mut [0.0]);
        }
        let robot = episode.world.resource::<Roster>().get(settings.control[0]).unwrap();
        let ball = ball_of(&episode.world).unwrap().0;
        let ball = episode.world.get::<Pose>(robot).unwrap().inverse_transform_point(ball);
        let head = *episode.world.get::<HeadAngles>(robot).unwrap();
        let limits = *episode.world.get::<HeadLimits>(robot).unwrap();
        let [least, most] = limits.yaw;
        assert!((head.yaw - ball.to_angle().clamp(least, most)).abs() < 0.35, "{head:?} {ball}");
    }
}

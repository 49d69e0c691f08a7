//! Demonstrations: what players observe and do in the episodes of a challenge, for imitation and offline learning.

use bevy::prelude::*;
use core::sync::atomic::AtomicBool;

use super::action::{CONTINUOUS, continuous};
use super::attempts::{AttemptError, Attempts, ChallengePlayer};
use super::challenge::Challenge;
use super::entry::ObservationEntry;
use super::episode::{EnvironmentSettings, Episode};
use super::kind::ObservationKind;
use super::observation::entries;
use super::prepared::{settings, world};
use super::recorded_commands::{RecordedCommands, record_commands};
use crate::agents::{RobotCommand, dismiss};
use naoisis_core::team::RobotId;
use naoisis_sim::simulation::play_in_order;

/// What one robot observed and did in an episode. There is one more observation than there are steps.
#[derive(Clone, PartialEq, Debug)]
pub struct Demonstration {
    /// The seed of the episode.
    pub seed: u64,
    /// The robot.
    pub robot: RobotId,
    /// The observations before each step and after the last one, one after the other, as many numbers each as there are
    /// [entries](Demonstrations::entries).
    pub observations: Vec<f32>,
    /// The [continuous action](CONTINUOUS) of each step.
    pub actions: Vec<[f32; CONTINUOUS.len()]>,
    /// The reward of each step.
    pub rewards: Vec<f32>,
    /// Whether the episode ended with a success of the robot's team.
    pub is_success: bool,
    /// Whether the time limit ended the episode.
    pub is_truncated: bool,
}

/// A player whose episodes are recorded.
pub struct Demonstrations {
    settings: EnvironmentSettings,
    entries: Vec<ObservationEntry>,
}

impl Demonstrations {
    /// Prepares a challenge, played by a behaviour, a policy or a team, with this kind of observation.
    ///
    /// # Errors
    /// The player does not exist, or does not decide in the match, such as `random`.
    pub fn new(
        challenge: &Challenge,
        player: &ChallengePlayer,
        observation: ObservationKind,
        simulator: impl Fn() -> App + Sync,
    ) -> Result<Self, AttemptError> {
        if !player.has_own_robots() {
            return Err(AttemptError::Outside(player.clone()));
        }
        let settings = settings(challenge, player, simulator().world())?;
        let settings = EnvironmentSettings { observed: observation.into(), ..settings };
        let mut episode = Episode::new(world(&simulator), 0);
        episode.begin(&settings)?;
        let entries =
            settings.control.first().map_or_else(Vec::new, |id| entries(observation.into(), &episode.world, *id));
        dismiss(&mut episode.world, "the episode is over");
        Ok(Self { settings, entries })
    }

    /// The entries of an observation.
    pub fn entries(&self) -> &[ObservationEntry] {
        &self.entries
    }

    /// The number of cycles of a step.
    pub fn cycles_per_step(&self) -> u32 {
        self.settings.cycles_per_step
    }

    /// Plays episodes and passes the demonstrations of all controlled robots to `finished`, in the order of seeds and robots. When `stop`
    /// turns true, running episodes are finished and no new ones start.
    ///
    /// # Errors
    /// An episode cannot start, a program is lost, or `finished` returns an error.
    pub fn play<E: From<AttemptError> + Send>(
        &self,
        attempts: &Attempts,
        simulator: impl Fn() -> App + Sync,
        stop: &AtomicBool,
        mut finished: impl FnMut(Demonstration) -> Result<(), E>,
    ) -> Result<(), E> {
        let recording = || {
            let mut app = simulator();
            record_commands(&mut app);
            app
        };
        let worker = || Episode::new(world(recording), 0);
        let play = |episode: &mut Episode, index: usize| {
            self.demonstrate(episode, attempts.first_seed.wrapping_add(index as u64))
        };
        play_in_order(0..attempts.episodes, attempts.threads, stop, worker, play, |episode| {
            episode.map_err(E::from)?.into_iter().try_for_each(&mut finished)
        })
    }

    fn demonstrate(&self, episode: &mut Episode, seed: u64) -> Result<Vec<Demonstration>, AttemptError> {
        let settings = &self.settings;
        episode.seed(seed);
        episode.begin(settings)?;
        let robots = settings.control.iter().map(|robot| Demonstration {
            seed,
            robot: *robot,
            observations: Vec::new(),
            actions: Vec::new(),
            rewards: Vec::new(),
            is_success: false,
            is_truncated: false,
        });
        let mut robots: Vec<Demonstration> = robots.collect();
        let (mut observations, mut rewards) = (vec![0.0; robots.len() * self.entries.len()], vec![0.0; robots.len()]);
        let mut heads = vec![None; robots.len()];
        self.observe(episode, &mut observations, &mut robots);
        while !episode.progress.is_over() {
            // The robots decide for themselves.
            episode.step(settings, &[], &mut rewards);
            if let Some((robot, message)) = episode.lost.take() {
                return Err(AttemptError::Lost { seed, robot, message });
            }
            let cycles = episode.world.resource_mut::<RecordedCommands>().take(&settings.control);
            for (index, ((robot, head), reward)) in robots.iter_mut().zip(&mut heads).zip(&rewards).enumerate() {
                let mut command = command_of_step(&cycles, index);
                // The head keeps its target until it gets another one.
                *head = command.head.or(*head);
                command.head = *head;
                robot.actions.push(continuous(&command, &episode.world, robot.robot));
                robot.rewards.push(*reward);
            }
            self.observe(episode, &mut observations, &mut robots);
        }
        for robot in &mut robots {
            robot.is_success = episode.progress.success_of[robot.robot.team];
            robot.is_truncated = episode.progress.truncated;
        }
        dismiss(&mut episode.world, "the episode is over");
        Ok(robots)
    }

    fn observe(&self, episode: &mut Episode, observations: &mut [f32], robots: &mut [Demonstration]) {
        episode.observe(&self.settings, observations, &mut []);
        for (robot, observation) in robots.iter_mut().zip(observations.chunks(self.entries.len().max(1))) {
            robot.observations.extend(observation);
        }
    }
}

/// The command of a controlled robot in a step: its walk in the first cycle, and its head and kick in whichever cycle it gave them.
fn command_of_step(cycles: &[Vec<RobotCommand>], robot: usize) -> RobotCommand {
    let commands = || cycles.iter().filter_map(|cycle| cycle.get(robot));
    RobotCommand {
        walk: commands().next().and_then(|command| command.walk),
        head: commands().filter_map(|command| command.head).next_back(),
        kick: commands().find_map(|command| command.kick),
        ..default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::action::ActionKind;
    use naoisis_sim::scenario::Realism;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn simulator() -> App {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app
    }

    fn demonstrations(challenge: &Challenge, player: &str, threads: usize) -> (Demonstrations, Vec<Demonstration>) {
        let Ok(player) = player.parse();
        let demonstrations = Demonstrations::new(challenge, &player, ObservationKind::Belief, simulator).unwrap();
        let attempts = Attempts { episodes: 3, first_seed: 5, threads };
        let mut played = Vec::new();
        let finished = |robot| {
            played.push(robot);
            Ok::<_, AttemptError>(())
        };
        demonstrations.play(&attempts, simulator, &AtomicBool::new(false), finished).unwrap();
        (demonstrations, played)
    }

    #[test]
    fn a_demonstration_has_an_observation_more_than_actions_and_is_the_same_on_any_number_of_threads() {
        let challenge = Challenge::named("ScoreEmptyGoal").unwrap().with(Realism::Ideal, None).unwrap();
        let (demonstrations, played) = demonstrations(&challenge, "striker", 2);
        assert_eq!(played.iter().map(|robot| robot.seed).collect::<Vec<_>>(), [5, 6, 7]);
        for robot in &played {
            assert_eq!(robot.observations.len(), (robot.actions.len() + 1) * demonstrations.entries().len());
            assert_eq!(robot.actions.len(), robot.rewards.len());
            assert!(robot.is_success && !robot.is_truncated);
            assert!(robot.actions.iter().flatten().all(|number| (-1.0..=1.0).contains(number)));
            // It walks, looks about and kicks.
            let any = |index: usize, least: f32| robot.actions.iter().any(|action| action[index] > least);
            assert!(any(0, 0.5) && any(3, 0.05) && any(5, 0.5), "{robot:?}");
        }
        assert_eq!(played, self::demonstrations(&challenge, "striker", 1).1);
    }

    #[test]
    fn played_back_cycle_by_cycle_the_actions_score_as_well() {
        let mut challenge = Challenge::named("ScoreEmptyGoal").unwrap().with(Realism::Ideal, None).unwrap();
        challenge.cycles_per_step = 1;
        let (demonstrations, played) = demonstrations(&challenge, "striker", 1);
        let Ok(player) = "random".parse();
        let settings = settings(&challenge, &player, simulator().world()).unwrap();
        let settings = EnvironmentSettings {
            observed: ObservationKind::Belief.into(),
            action: ActionKind::Continuous,
            ..settings
        };
        let mut episode = Episode::new(world(simulator), 0);
        for robot in &played {
            episode.seed(robot.seed);
            episode.begin(&settings).unwrap();
            let mut observation = vec![0.0; demonstrations.entries().len()];
            episode.observe(&settings, &mut observation, &mut []);
            assert_eq!(robot.observations[..observation.len()], observation);
            for action in &robot.actions {
                episode.step(&settings, action, &mut [0.0]);
            }
            assert!(episode.progress.is_success, "seed {}", robot.seed);
        }
    }

    #[test]
    fn a_player_outside_of_the_match_demonstrates_nothing() {
        let challenge = Challenge::named("ScoreEmptyGoal").unwrap();
        let Ok(player) = "random".parse();
        let refused = Demonstrations::new(&challenge, &player, ObservationKind::Belief, simulator);
        assert!(refused.err().unwrap().to_string().contains("expected a behaviour or a team"));
    }
}

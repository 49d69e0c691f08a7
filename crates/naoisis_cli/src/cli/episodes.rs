//! `naoisis episodes`: episodes of learning tasks as a data set, for imitation and offline learning.

use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{fs, io};

use super::batch::progress_bar;
use super::challenge::{realism, threads};
use super::interrupt::Interrupt;
use super::report::{CommandResult, OrReport};
use super::terminal::Printer;
use super::{Program, report};
use naoisis_agents::environment::action::CONTINUOUS;
use naoisis_agents::environment::attempts::{AttemptError, Attempts, ChallengePlayer};
use naoisis_agents::environment::challenge::CHALLENGES;
use naoisis_agents::environment::demonstrations::{Demonstration, Demonstrations};
use naoisis_agents::environment::{Challenge, ObservationEntry, ObservationKind};
use naoisis_record::record::minari::{EpisodeSteps, MinariDataset};
use naoisis_sim::scenario::Realism;

/// The word for all tasks.
const ALL: &str = "all";

/// The seed of the first episode by default.
const FIRST_SEED: u64 = 1;

/// Arguments of `naoisis episodes`.
#[derive(Args, Debug, Clone)]
pub struct EpisodesArguments {
    /// The task, see `naoisis list challenges`, or `all`, each a data set of its own
    #[arg(value_name = "NAME", default_value = ALL)]
    name: String,
    /// The behaviour of its robots
    #[arg(long, value_name = "B", required_unless_present_any = ["team", "policy"], conflicts_with_all = ["team", "policy"])]
    behaviour: Option<String>,
    /// The team that plays its robots, or a program: "exec:python3 team.py"
    #[arg(long, value_name = "T", conflicts_with = "policy")]
    team: Option<String>,
    /// The learned policy that plays its robots
    #[arg(long, value_name = "FILE.onnx")]
    policy: Option<String>,
    /// What robots observe
    #[arg(long, value_name = "perception|belief|truth|body", default_value = "belief", value_parser = observation)]
    observation: ObservationKind,
    /// The realism
    #[arg(long, value_name = "paper|ideal|realistic", default_value = "paper", value_parser = realism)]
    realism: Realism,
    /// The model of the robots, instead of the task's
    #[arg(long, value_name = "MODEL")]
    robot: Option<String>,
    /// Number of episodes
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    episodes: u32,
    /// Seed of the first episode; each further episode has the next seed
    #[arg(long, value_name = "N", default_value_t = FIRST_SEED)]
    seed: u64,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// The folder of data sets, as in `MINARI_DATASETS_PATH`
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace a data set of the same name
    #[arg(long)]
    force: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Parses a kind of observation.
fn observation(word: &str) -> Result<ObservationKind, String> {
    serde_json::from_value(word.into()).map_err(|_| "expected one of perception, belief, truth, body".to_owned())
}

/// Why the episodes ended early.
enum EpisodesError {
    Episode(AttemptError),
    File(io::Error),
}

impl From<AttemptError> for EpisodesError {
    fn from(error: AttemptError) -> Self {
        EpisodesError::Episode(error)
    }
}

/// Runs the command.
pub fn episodes(program: Program, arguments: &EpisodesArguments) -> CommandResult {
    let interrupt = Interrupt::finish_running().or_failure()?;
    let names = match arguments.name.as_str() {
        ALL => CHALLENGES.iter().map(|(name, _)| *name).collect(),
        name => vec![name],
    };
    let mut printer = Printer::default();
    for name in names {
        match write_data_set(program, name, arguments, &interrupt) {
            Ok(_) if arguments.quiet => {}
            Ok(words) => printer.print(words),
            Err(status) => return Ok(interrupt.finish(printer.finish(status))),
        }
        if interrupt.is_stopped() {
            break;
        }
    }
    Ok(interrupt.finish(printer.finish(ExitCode::SUCCESS)))
}

/// Plays the episodes of a task and writes their data set. Returns a description of it.
fn write_data_set(
    program: Program,
    name: &str,
    arguments: &EpisodesArguments,
    interrupt: &Interrupt,
) -> Result<String, ExitCode> {
    let challenge =
        Challenge::named(name).and_then(|challenge| challenge.with(arguments.realism, arguments.robot.as_deref()));
    let challenge = challenge.or_usage_error()?;
    let player = player(arguments);
    let simulator = || program.simulator();
    let demonstrations = Demonstrations::new(&challenge, &player, arguments.observation, simulator);
    let demonstrations = demonstrations.or_usage_error()?;
    let id = id(&challenge, &player, arguments);
    let facts = facts(&challenge, &player, &demonstrations, arguments);
    let ranges: Vec<[f32; 2]> = demonstrations.entries().iter().map(|entry| [entry.low, entry.high]).collect();
    let actions = [[-1.0, 1.0]; CONTINUOUS.len()];
    let failed = |error: &io::Error| {
        let message = format!("--out: {}: {error}", arguments.out.join(&id).display());
        if error.kind() == io::ErrorKind::AlreadyExists {
            report::usage_error(&format!("{message}; --force replaces it"))
        } else {
            report::failure(&message)
        }
    };
    let mut dataset = MinariDataset::create(&arguments.out, &id, [&ranges, &actions], facts, arguments.force)
        .map_err(|error| failed(&error))?;
    let attempts = Attempts {
        episodes: arguments.episodes as usize,
        first_seed: arguments.seed,
        threads: threads(arguments.threads),
    };
    let progress = progress_bar(attempts.episodes, 0, arguments.quiet);
    let mut successes = 0;
    let played = demonstrations.play(&attempts, simulator, interrupt.stop(), |robot: Demonstration| {
        if challenge.control.first() == Some(&robot.robot) {
            progress.inc(1);
        }
        successes += usize::from(robot.is_success);
        let written = dataset.add(&EpisodeSteps {
            observations: &robot.observations,
            actions: robot.actions.as_flattened(),
            rewards: &robot.rewards,
            is_terminated: !robot.is_truncated,
            is_truncated: robot.is_truncated,
            seed: robot.seed,
            agent: &robot.robot.to_string(),
        });
        written.map_err(EpisodesError::File)
    });
    progress.finish_and_clear();
    let [episodes, steps] = dataset.written();
    // What was played before an error or an interruption is a data set, too.
    let finished = dataset.finish();
    match (played, finished) {
        (Err(EpisodesError::Episode(error)), _) => {
            if episodes == 0 {
                // Nothing can be removed but what has just been made.
                let _ = fs::remove_dir_all(arguments.out.join(&id));
            }
            return Err(report::failure(&error.to_string()));
        }
        (Err(EpisodesError::File(error)), _) | (Ok(()), Err(error)) => return Err(failed(&error)),
        (Ok(()), Ok(())) => {}
    }
    Ok(format!(
        "{id}: episodes of one robot each: {episodes}, with success: {successes}, steps of {} cycles: {steps}\n\
         MINARI_DATASETS_PATH={} python -c 'import minari; print(minari.load_dataset(\"{id}\"))'\n",
        demonstrations.cycles_per_step(),
        arguments.out.display()
    ))
}

fn player(arguments: &EpisodesArguments) -> ChallengePlayer {
    match (&arguments.team, &arguments.policy, &arguments.behaviour) {
        (Some(team), ..) => ChallengePlayer::Team(team.clone()),
        (_, Some(file), _) => ChallengePlayer::Policy(file.clone()),
        (.., word) => {
            let Ok(player) = word.as_deref().unwrap_or("idle").parse();
            player
        }
    }
}

/// The name of the data set, such as `naoisis/ScoreEmptyGoal/striker-ideal-v0`. What is not as by default is in it.
fn id(challenge: &Challenge, player: &ChallengePlayer, arguments: &EpisodesArguments) -> String {
    let player = match player {
        ChallengePlayer::Policy(file) => Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        ChallengePlayer::Team(name) if !name.contains(':') => name.clone(),
        ChallengePlayer::Team(_) => "program".to_owned(),
        player => player.to_string(),
    };
    let is_word = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let player: String = player.chars().map(|letter| if is_word(letter) { letter } else { '_' }).collect();
    let robot = arguments.robot.as_ref().map(|robot| format!("-{robot}")).unwrap_or_default();
    let observation = match arguments.observation {
        ObservationKind::Belief => String::new(),
        other => format!("-{}", serde_json::to_value(other).ok().as_ref().and_then(Value::as_str).unwrap_or_default()),
    };
    let seed = if arguments.seed == FIRST_SEED { String::new() } else { format!("-seed{}", arguments.seed) };
    let realism = arguments.realism.name();
    format!("naoisis/{}/{player}-{realism}{robot}{observation}{seed}-v{}", challenge.name, challenge.version)
}

/// What the metadata says of the episodes.
fn facts(
    challenge: &Challenge,
    player: &ChallengePlayer,
    demonstrations: &Demonstrations,
    arguments: &EpisodesArguments,
) -> Value {
    let observation = serde_json::to_value(arguments.observation).unwrap_or_default();
    let names: Vec<String> = demonstrations.entries().iter().map(ObservationEntry::to_string).collect();
    let env_id = format!("naoisis/{}-v{}", challenge.name, challenge.version);
    let kwargs = json!({
        "scenario": challenge.name,
        "observation": observation,
        "action": "continuous",
        "cycles_per_step": demonstrations.cycles_per_step(),
        "realism": arguments.realism.name(),
        "set": { "model": challenge.scenario().map(|file| file.scenario.model).unwrap_or_default() },
    });
    // As Gymnasium writes the specification of an environment.
    let env_spec = json!({
        "id": env_id,
        "entry_point": "naoisis.environments:MatchEnv",
        "reward_threshold": null,
        "nondeterministic": false,
        "max_episode_steps": null,
        "order_enforce": true,
        "disable_env_checker": false,
        "kwargs": kwargs,
        "additional_wrappers": [],
        "vector_entry_point": "naoisis.environments:VectorEnv",
    });
    json!({
        "env_spec": env_spec.to_string(),
        "algorithm_name": player.to_string(),
        "author": ["naoisis"],
        "code_permalink": env!("CARGO_PKG_REPOSITORY"),
        "description": challenge.description,
        "requirements": [concat!("naoisis==", env!("CARGO_PKG_VERSION"))],
        "naoisis": {
            "realism": arguments.realism.name(),
            "robot": arguments.robot,
            "first_seed": arguments.seed,
            "observation_names": names,
            "action_names": CONTINUOUS.map(|(name, _)| name),
        },
    })
}

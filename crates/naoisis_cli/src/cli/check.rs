//! `naoisis check`: reports errors in the files of scenarios and robot models.

use bevy::prelude::*;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::agents::{AgentArguments, connected};
use super::check_program::{TestMatch, check_program};
use super::expect::{cores, play_many, print_verdicts, write_junit};
use super::game_controller::GameControllerArguments;
use super::interrupt::Interrupt;
use super::notes;
use super::report::{CommandResult, OrReport};
use super::teams::TeamArguments;
use super::terminal::Printer;
use super::{Program, report};
use naoisis_agents::game_controller::MatchNetwork;
use naoisis_agents::policy::LoadedPolicy;
use naoisis_record::expectations::Verdict;
use naoisis_sim::scenario::{RobotModel, ScenarioError, ScenarioFile, Setting, TeamsSpec};
use naoisis_sim::simulation::{MatchApp, names};

/// Arguments of `naoisis check`.
#[derive(Args, Debug, Clone)]
pub struct CheckArguments {
    /// Scenario files (.ron or .json), names of built-in scenarios, robot models (.ron), or programs that are to play:
    /// "exec:python3 team.py"
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<String>,
    /// Also play the scenarios and check what they expect; exit status 1 if an expectation fails
    #[arg(long)]
    pub play: bool,
    /// With --play, write the verdicts on expectations as JUnit XML
    #[arg(long, value_name = "FILE", requires = "play")]
    pub junit: Option<PathBuf>,
    /// Set a field of the scenarios that are played, with --play or for a program: teams.blue=passers
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<Setting>,
    /// The scenario in which a program plays as the blue team [default: match3v3]
    #[arg(long, value_name = "SCENARIO")]
    pub scenario: Option<String>,
    /// With --play, the teams; for a program, the other team.
    #[command(flatten)]
    pub teams: TeamArguments,
    #[command(flatten)]
    pub agents: AgentArguments,
    /// With --play or for a program, the network of the matches.
    #[command(flatten)]
    pub game_controller: GameControllerArguments,
}

impl CheckArguments {
    /// An error about options that have no effect; `None` if all have one.
    fn in_vain(&self, has_network: bool) -> Option<String> {
        let programs = self.files.iter().filter(|file| file.starts_with(TeamsSpec::EXEC)).count();
        let options = |given: &[(bool, &str)]| {
            let named: Vec<&str> = given.iter().filter(|(is_given, _)| *is_given).map(|(_, name)| *name).collect();
            (!named.is_empty()).then(|| named.join(", "))
        };
        let plays_scenarios = self.play && programs < self.files.len();
        let teams = [(self.teams.blue.is_some(), "--blue"), (self.teams.pink.is_some() && programs == 0, "--pink")];
        let played = [(!self.set.is_empty(), "--set"), (has_network, "--game-controller, --team-messages")];
        if let Some(options) = options(&teams).filter(|_| !plays_scenarios) {
            let expected = if programs > 0 {
                "a program plays as the blue team"
            } else {
                "nothing is played; expected --play, too"
            };
            return Some(format!("{options}: {expected}"));
        }
        if let Some(options) = options(&played).filter(|_| !plays_scenarios && programs == 0) {
            return Some(format!("{options}: nothing is played; expected --play, too"));
        }
        (self.scenario.is_some() && programs == 0)
            .then(|| "--scenario: there is no program to check; expected \"exec:COMMAND\"".to_owned())
    }
}

/// Checks every file, and prints `ok` or all its errors. Returns exit status 2 if there are any.
pub fn check(program: Program, arguments: &CheckArguments) -> CommandResult {
    let network = arguments.game_controller.of_many(cores()).or_usage_error()?;
    if let Some(message) = arguments.in_vain(network.is_some()) {
        return Err(report::usage_error(&message));
    }
    let interrupt = Interrupt::watch(|| {}).or_failure()?;
    let (printer, app) = (Printer::default(), program.simulator());
    let mut check = Check { program, arguments, network, interrupt, printer, app };
    let (mut status, mut outcomes) = (0, Vec::new());
    for file in &arguments.files {
        let outcome = check.file(file);
        if check.interrupt.is_stopped() {
            return Ok(check.interrupt.finish(check.printer.finish(ExitCode::SUCCESS)));
        }
        status = status.max(outcome.status());
        outcomes.extend(outcome.for_junit().map(|outcome| (file.clone(), outcome)));
    }
    let mut status = ExitCode::from(status);
    if let Some(Err(message)) = arguments.junit.as_ref().map(|path| write_junit(path, &outcomes)) {
        status = report::failure(&message);
    }
    Ok(check.printer.finish(status))
}

/// What came of a file.
enum Outcome {
    /// It is right, and nothing was played.
    Checked,
    /// It was played.
    Played(Vec<Verdict>),
    /// It is right, and cannot be played.
    NotPlayed(String),
    /// It is wrong.
    Wrong(String),
}

impl Outcome {
    fn status(&self) -> u8 {
        match self {
            Outcome::Checked => 0,
            Outcome::Played(verdicts) => u8::from(verdicts.iter().any(|verdict| !verdict.holds)),
            Outcome::NotPlayed(_) => 1,
            Outcome::Wrong(_) => report::USAGE_ERROR,
        }
    }

    /// What is in the report; `None` if nothing was to be played.
    fn for_junit(self) -> Option<Result<Vec<Verdict>, String>> {
        match self {
            Outcome::Checked => None,
            Outcome::Played(verdicts) => Some(Ok(verdicts)),
            Outcome::NotPlayed(message) | Outcome::Wrong(message) => Some(Err(message)),
        }
    }
}

/// The command while it runs.
struct Check<'a> {
    program: Program<'a>,
    arguments: &'a CheckArguments,
    network: Option<MatchNetwork>,
    interrupt: Interrupt,
    printer: Printer,
    app: App,
}

impl Check<'_> {
    /// Checks a file, and plays it if that is asked for.
    fn file(&mut self, file: &str) -> Outcome {
        if file.starts_with(TeamsSpec::EXEC) {
            self.printer.print(format_args!("{file}:\n"));
            let CheckArguments { scenario, set, agents, teams, .. } = self.arguments;
            let scenario = scenario.as_deref().unwrap_or("match3v3");
            let (pink, network) = (teams.pink.as_deref(), self.network.as_ref());
            let played = TestMatch { scenario, set, agents, pink, network };
            let plays = check_program(self.program, file, &played, &mut self.printer);
            return if plays {
                Outcome::Checked
            } else {
                Outcome::Wrong("the program does not play as it should".to_owned())
            };
        }
        if Path::new(file).extension().is_some_and(|ending| ending == "onnx") {
            return self.policy(file);
        }
        let errors = match RobotModel::check(file) {
            Some(Ok(model)) => {
                self.printer.print(format_args!("{file}: ok, the model of a robot\n"));
                self.print_notes(file, notes::of_model(&model).into_iter().chain(notes::unsourced(&model)));
                return Outcome::Checked;
            }
            Some(Err(errors)) => errors,
            None => errors_of(file, &mut self.app),
        };
        if errors.is_empty() {
            return self.scenario(file);
        }
        for error in &errors {
            report::scenario_error(error);
        }
        if errors.len() == ScenarioFile::MOST_ERRORS {
            report::note(&format!("{file}: there may be more errors than the first {}", errors.len()));
        }
        Outcome::Wrong(errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
    }

    /// Reads a learned policy, and tells what it reads and answers.
    fn policy(&mut self, file: &str) -> Outcome {
        match LoadedPolicy::read(Path::new(file)) {
            Ok(policy) => {
                self.printer.print(format_args!("{file}: ok, a learned policy: {policy}\n"));
                Outcome::Checked
            }
            Err(error) => {
                let error = error.to_string();
                report::failure(&error);
                Outcome::Wrong(error)
            }
        }
    }

    /// Tells of a scenario that is right, and plays it if that is asked for.
    fn scenario(&mut self, file: &str) -> Outcome {
        self.printer.print(format_args!("{file}: ok\n"));
        let notes = ScenarioFile::find(file).map(|file| notes::of_scenario(&file)).unwrap_or_default();
        self.print_notes(file, notes);
        if !self.arguments.play {
            return Outcome::Checked;
        }
        match self.play(file) {
            Ok(verdicts) => {
                print_verdicts(&mut self.printer, &verdicts, false);
                Outcome::Played(verdicts)
            }
            Err(message) => {
                report::failure(&format!("{file}: {message}"));
                Outcome::NotPlayed(message)
            }
        }
    }

    /// Plays a valid scenario and returns the verdicts on its expectations.
    fn play(&self, file: &str) -> Result<Vec<Verdict>, String> {
        let Check { program, arguments, ref network, .. } = *self;
        let file = ScenarioFile::find(file).map_err(|error| error.to_string())?;
        let mut file = file.with(&arguments.set).map_err(|error| error.to_string())?;
        arguments.teams.choose(program.simulator().world(), &mut file)?;
        let settings = arguments.agents.settings(&file.source.name, &arguments.teams);
        let simulator = || connected(program.simulator(), &settings, network.as_ref());
        play_many(simulator, &file.scenario, &file.scenario.expectations, &self.interrupt)
    }

    fn print_notes(&mut self, file: &str, notes: impl IntoIterator<Item = String>) {
        for words in notes {
            self.printer.print(format_args!("{file}: note: {words}\n"));
        }
    }
}

/// Returns the errors of a file: those of its fields, then of the names in it, and finally of starting its match.
fn errors_of(file: &str, app: &mut App) -> Vec<ScenarioError> {
    match ScenarioFile::check(file, |scenario| names::unknown(app.world(), scenario)) {
        Ok(file) => app.start_match(&file.scenario).err().map(|fault| file.source.error(&fault)).into_iter().collect(),
        Err(errors) => errors,
    }
}

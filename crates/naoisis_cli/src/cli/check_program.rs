//! `naoisis check "exec:COMMAND"`: tests a program in a short match, and reports what it does wrong.

use bevy::prelude::*;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::Program;
use super::agents::{AgentArguments, connected};
use super::teams::TeamArguments;
use super::terminal::Printer;
use naoisis_agents::agents::{self, AgentPlayer};
use naoisis_agents::game_controller::{MatchNetwork, open_network};
use naoisis_core::events::MatchEvent;
use naoisis_core::robot::Roster;
use naoisis_core::team::{RobotId, Team};
use naoisis_record::record::RecordPlugin;
use naoisis_sim::interface::gather::{CurrentRecord, gather_start};
use naoisis_sim::interface::vocabulary::RobotCommand;
use naoisis_sim::scenario::{ScenarioFile, Setting};
use naoisis_sim::simulation::MatchApp;

/// The match of the test, in which the program plays as the blue team.
pub struct TestMatch<'a> {
    /// The name or the path of the scenario.
    pub scenario: &'a str,
    /// Changes of the scenario.
    pub set: &'a [Setting],
    /// Settings for programs.
    pub agents: &'a AgentArguments,
    /// The other team, if not the scenario's.
    pub pink: Option<&'a str>,
    /// What the match sends and carries over UDP.
    pub network: Option<&'a MatchNetwork>,
}

/// The length of the test, cycles: ten seconds.
const CYCLES: u32 = 300;
/// The robot whose program is checked. The other robots of its team are played by the same command.
const ROBOT: RobotId = RobotId::new(Team::Blue, 1);

/// Tests the program of a team in a match, and prints each step. Returns whether all is well.
pub fn check_program(program: Program, team: &str, played: &TestMatch, printer: &mut Printer) -> bool {
    let mut step = |what: &str, outcome: Result<String, String>| {
        let (is_ok, word, details) = match &outcome {
            Ok(details) => (true, "ok", details),
            Err(details) => (false, "wrong", details),
        };
        let details = if details.is_empty() { String::new() } else { format!(": {details}") };
        printer.print(format_args!("  {what:<26} {word}{details}\n"));
        is_ok
    };
    let teams = TeamArguments { blue: Some(team.to_owned()), pink: played.pink.map(str::to_owned) };
    let settings = played.agents.settings(played.scenario, &teams);
    let mut app = connected(program.simulator_with(RecordPlugin), &settings, played.network);
    let found = ScenarioFile::find(played.scenario).and_then(|file| file.with(played.set));
    let begun = found.map_err(|error| error.to_string()).and_then(|mut file| {
        teams.choose(app.world(), &mut file)?;
        app.start_match(&file.scenario).map_err(|fault| fault.to_string())?;
        open_network(app.world_mut()).map_err(|error| format!("the network of the match: {error}"))
    });
    let started = Instant::now();
    let begun = begun.and_then(|()| agents::start_programs(app.world_mut()).map_err(|error| error.to_string()));
    if !step("starts", begun.map(|()| String::new())) {
        return false;
    }
    gather_start(app.world_mut());
    let hello = hello_of(&app).map(|hello| format!("{hello}, after {:.2} s", started.elapsed().as_secs_f64()));
    let mut trial = Trial::default();
    trial.run(&mut app);
    let was_welcome = hello.is_some();
    if !step("sends a hello", hello.ok_or_else(|| trial.lost.clone().unwrap_or_default())) {
        return false;
    }
    let answers = match &trial.lost {
        Some(message) => Err(format!("in cycle {}: {message}", app.cycle())),
        None => Ok(format!("all {CYCLES} cycles, the slowest took {:.1} ms", 1e3 * trial.slowest.as_secs_f64())),
    };
    let mut is_ok = was_welcome && step("answers in every cycle", answers);
    let commands = if trial.commands.is_empty() {
        Ok("none, its robot stood".to_owned())
    } else if let Some((what, count)) = trial.refused.iter().next() {
        Err(format!("{count} refused, such as {what}"))
    } else {
        let count = |(word, count): (&&str, &u32)| format!("{word} in {count} cycles");
        Ok(trial.commands.iter().map(count).collect::<Vec<_>>().join(", "))
    };
    is_ok &= step("sends valid commands", commands);
    if trial.lost.is_none() {
        let ended = agents::dismiss(app.world_mut(), "end");
        let outcome = if ended.is_empty() { Ok(String::new()) } else { Err("it had to be killed".to_owned()) };
        is_ok &= step("ends with the match", outcome);
    }
    is_ok
}

/// Returns the name and protocol of the program, if it was accepted.
fn hello_of(app: &App) -> Option<String> {
    let entity = app.world().resource::<Roster>().get(ROBOT)?;
    let hello = app.world().get::<AgentPlayer>(entity)?.hello()?;
    let name = if hello.name.is_empty() { "without a name" } else { &hello.name };
    Some(format!("{name}, protocol {}", hello.protocol))
}

/// The results of a test match.
#[derive(Default)]
struct Trial {
    /// Reason why the program was lost, if it was.
    lost: Option<String>,
    slowest: Duration,
    /// Number of cycles with each part of a command.
    commands: BTreeMap<&'static str, u32>,
    /// Refused commands with their numbers.
    refused: BTreeMap<String, u32>,
}

impl Trial {
    fn run(&mut self, app: &mut App) {
        for _ in 0..CYCLES {
            let began = Instant::now();
            app.run_cycles(1);
            self.slowest = self.slowest.max(began.elapsed());
            for event in app.events() {
                match event {
                    MatchEvent::AgentLost { robot: ROBOT, message, .. } => self.lost = Some(message.clone()),
                    MatchEvent::CommandRefused { robot, command, reason } if robot.team == ROBOT.team => {
                        *self.refused.entry(format!("{command:?} ({reason:?})").to_lowercase()).or_default() += 1;
                    }
                    _ => {}
                }
            }
            if self.lost.is_some() {
                break;
            }
            let record = &app.world().resource::<CurrentRecord>().record;
            let command = record.robot(ROBOT).and_then(|robot| robot.command.as_ref());
            for word in command.map(words_of).into_iter().flatten() {
                *self.commands.entry(word).or_default() += 1;
            }
        }
    }
}

/// Returns the names of the parts that a command sets, as in a trace.
fn words_of(command: &RobotCommand) -> impl Iterator<Item = &'static str> {
    let RobotCommand { walk, head, kick, posture, request, say } = command;
    let words = [
        ("walk", walk.is_some()),
        ("head_deg", head.is_some()),
        ("kick", kick.is_some()),
        ("posture", posture.is_some()),
        ("request", request.is_some()),
        ("say", say.is_some()),
    ];
    words.into_iter().filter_map(|(word, is_wanted)| is_wanted.then_some(word))
}

//! `naoisis whatif`: plays on from one moment of a match many times, with other random numbers.

use bevy::prelude::*;
use clap::Args;
use core::error::Error;
use core::fmt::Write;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::agents::{AgentArguments, connected};
use super::batch::progress_bar;
use super::begin::{change_match, is_snapshot, scenario_file};
use super::challenge::threads;
use super::game_controller::GameControllerArguments;
use super::interrupt::Interrupt;
use super::outputs::{Output, check_files};
use super::report::{CommandResult, OrReport};
use super::teams::TeamArguments;
use super::terminal::Printer;
use super::{Program, report};
use naoisis_agents::agents::{self, ReplayedCommands, remote_robots};
use naoisis_core::behaviour::{self, Remote};
use naoisis_core::cycle::{CycleClock, run_cycle};
use naoisis_core::events::MatchEvent;
use naoisis_core::game::{Game, GameState};
use naoisis_core::replace_file::replace_file;
use naoisis_core::statistics::{Estimate, rounded};
use naoisis_core::team::{RobotId, Team};
use naoisis_record::batch::begin_programs;
use naoisis_record::record::read::TraceReader;
use naoisis_record::whatif::{
    Continuation, Continuations, Moment, Outcomes, ProgramLost, is_same, play_branches, play_branches_from,
    programs_lost,
};
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::scenario::{Format, SavedMatch, Scenario, ScenarioFile, Setting};
use naoisis_sim::simulation::snapshot::reseed;
use naoisis_sim::simulation::{MatchApp, Snapshot};

/// Arguments of `naoisis whatif`.
#[derive(Args, Debug, Clone)]
pub struct WhatIfArguments {
    /// A saved match (.naoisis), a scenario that continues one, or a trace and a time in it: match.jsonl@312.5
    #[arg(value_name = "FILE|TRACE@SECONDS")]
    moment: String,
    /// Number of repetitions
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    times: u32,
    /// Duration after the moment, s; at most until the final whistle
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = super::run_arguments::positive_seconds)]
    until: f32,
    /// The teams that play on, instead of those of the moment.
    #[command(flatten)]
    teams: TeamArguments,
    #[command(flatten)]
    agents: AgentArguments,
    #[command(flatten)]
    game_controller: GameControllerArguments,
    /// Change a field of the scenario at the moment: messages.loss=1
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Setting>,
    /// Seed of the first repetition; each further one has the next seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Write the statistics and the outcome of each repetition
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

/// Runs the command.
pub fn whatif(program: Program, arguments: &WhatIfArguments) -> CommandResult {
    let input = trace_and_time(&arguments.moment).map_or(Path::new(&arguments.moment), |(trace, _)| trace);
    if let Some(path) = &arguments.json {
        let output = Output { option: "--json", path: path.clone() };
        check_files(input, &[output], arguments.force).or_usage_error()?;
    }
    let cores = threads(arguments.threads);
    let network = arguments.game_controller.of_many(cores).or_usage_error()?;
    let settings = arguments.agents.settings(&arguments.moment, &arguments.teams);
    let simulator = || connected(program.simulator(), &settings, network.as_ref());
    let mut app = simulator();
    let gone = go_to_moment(&mut app, arguments);
    agents::dismiss(app.world_mut(), "end");
    let (moment, again) = gone.and_then(|again| Ok((moment_of(&mut app)?, again)))?;
    if app.world().resource::<Game>().state == GameState::Finished {
        return Err(report::usage_error("the match is over at that moment; expected an earlier one"));
    }
    let interrupt = Interrupt::finish_running().or_failure()?;
    let branches = Continuations {
        times: arguments.times as usize,
        for_s: f64::from(arguments.until),
        first_seed: arguments.seed,
        threads: cores,
    };
    let progress = progress_bar(branches.times, 0, arguments.quiet);
    let mut rows: Vec<Continuation> = Vec::new();
    let finished = |branch| {
        progress.inc(1);
        rows.push(branch);
    };
    let played = match &again {
        None => {
            let played = play_branches(&moment, &branches, simulator, interrupt.stop(), finished);
            played.map_err(|error| error.to_string())
        }
        Some(again) => {
            let begin = |app: &mut App, seed: u64| {
                again.go_to_moment(app, arguments)?;
                reseed(app.world_mut(), seed);
                Ok(())
            };
            play_branches_from(&moment, begin, &branches, simulator, interrupt.stop(), finished)
        }
    };
    progress.finish_and_clear();
    played.or_failure()?;
    let outcomes = Outcomes::of(&rows);
    if let Some(note) = note_of_losses(&rows) {
        report::note(&note);
    }
    let scenario = app.world().resource::<Scenario>();
    let realism = scenario.realism_in_words();
    if let Some(path) = &arguments.json {
        let value = json!({
            "moment": arguments.moment, "time_s": moment.time_s, "for_s": arguments.until, "realism": realism,
            "outcomes": outcomes, "branches": rows,
        });
        let written = replace_file(path, |mut file| {
            serde_json::to_writer_pretty(&mut file, &value)?;
            std::io::Write::write_all(&mut file, b"\n")
        });
        written.map_err(|problem| format!("--json: {}: {problem}", path.display())).or_failure()?;
    }
    let mut printer = Printer::default();
    if !arguments.quiet {
        printer.print(in_words(&moment, &scenario.name, &realism, arguments.until, &outcomes));
    }
    Ok(interrupt.finish(printer.finish(ExitCode::SUCCESS)))
}

/// A note about programs that were lost; `None` if none was.
fn note_of_losses(rows: &[Continuation]) -> Option<String> {
    let losses = rows.iter().filter(|row| !row.programs_lost.is_empty()).count();
    let ProgramLost { robot, message } = rows.iter().find_map(|row| row.programs_lost.first())?;
    Some(format!("programs were lost in {losses} of {} repetitions; the first one, of {robot}: {message}", rows.len()))
}

/// Returns the trace and the time that `word` names, if it has this form.
fn trace_and_time(word: &str) -> Option<(&Path, f64)> {
    let (path, time) = word.rsplit_once('@')?;
    let time: f64 = time.parse().ok()?;
    (time.is_finite() && !is_snapshot(Path::new(word))).then_some((Path::new(path), time))
}

/// A match of programs, which each branch plays again up to the moment: what the programs have in mind there is not saved.
struct PlayedAgain {
    scenario: Scenario,
    /// The number of the cycle at the moment.
    cycle: u64,
    /// What the trace has of the cycles before the moment; nothing if the match begins there.
    traced: Vec<TracedCycle>,
}

/// What a trace has of the programs in a cycle.
struct TracedCycle {
    cycle: u64,
    commands: ReplayedCommands,
    /// The robots that lost their programs.
    lost: Vec<RobotId>,
}

impl TracedCycle {
    /// What `record` has of the robots `commanded`, and the robots that lost their programs.
    fn of(record: &CycleRecord, commanded: &[RobotId]) -> Self {
        let command = |robot: &RobotRecord| (robot.id, robot.command.clone().unwrap_or_default());
        let robots = record.robots.iter().filter(|robot| commanded.contains(&robot.id));
        let lost = record.events.iter().filter_map(|event| match event {
            MatchEvent::AgentLost { robot, .. } => Some(*robot),
            _ => None,
        });
        Self { cycle: record.cycle, commands: ReplayedCommands(robots.map(command).collect()), lost: lost.collect() }
    }

    /// Plays the cycle again, and those before it that the trace left out. Programs answer as in the trace.
    ///
    /// # Errors
    /// A program was lost that was not lost in the trace.
    fn play(&self, world: &mut World) -> Result<(), String> {
        while world.resource::<CycleClock>().cycle < self.cycle {
            let is_last = world.resource::<CycleClock>().cycle + 1 == self.cycle;
            world.insert_resource(if is_last { self.commands.clone() } else { ReplayedCommands::default() });
            run_cycle(world);
            if let Some(ProgramLost { robot, message }) =
                programs_lost(world).find(|lost| !self.lost.contains(&lost.robot))
            {
                let time_s = world.resource::<CycleClock>().end_time_s();
                return Err(format!("{robot} lost its program at {time_s:.2} s, before the moment: {message}"));
            }
        }
        world.remove_resource::<ReplayedCommands>();
        Ok(())
    }
}

impl PlayedAgain {
    /// Plays the match in `app` up to the moment, and changes the settings of the command line there.
    fn go_to_moment(&self, app: &mut App, arguments: &WhatIfArguments) -> Result<(), String> {
        app.start_match(&self.scenario).map_err(|fault| fault.to_string())?;
        begin_programs(app.world_mut()).map_err(|error| error.to_string())?;
        self.traced.iter().try_for_each(|cycle| cycle.play(app.world_mut()))?;
        while app.world().resource::<CycleClock>().cycle < self.cycle {
            run_cycle(app.world_mut());
        }
        change(app, arguments).map_err(|_| "the settings of the command line cannot be changed".to_owned())
    }
}

fn moment_of(app: &mut App) -> Result<Moment, ExitCode> {
    Moment::of(app.world_mut()).or_failure()
}

/// Brings the match in `app` to the moment, with the settings of the command line. Returns how branches get there, if programs play.
fn go_to_moment(app: &mut App, arguments: &WhatIfArguments) -> Result<Option<PlayedAgain>, ExitCode> {
    let path = Path::new(&arguments.moment);
    let (mut scenario, mut traced) = (None, Vec::new());
    if is_snapshot(path) {
        let snapshot = Snapshot::load(path, app.world()).or_usage_error()?;
        snapshot
            .restore(app.world_mut())
            .map_err(|error| report::usage_error(&format!("{}: {error}", path.display())))?;
    } else if let Some((path, time_s)) = trace_and_time(&arguments.moment) {
        let (played, cycles) = play_again(app, path, time_s)?;
        (scenario, traced) = (Some(played), cycles);
    } else if Format::of_path(path).is_some() {
        let scenario = go_on_from_saved(app, arguments)?;
        let cycle = app.world().resource::<CycleClock>().cycle;
        return Ok((!remote_teams(app).is_empty()).then_some(PlayedAgain { scenario, cycle, traced: Vec::new() }));
    } else {
        return Err(no_moment(&arguments.moment));
    }
    let changed = change_teams(app, arguments)?;
    let remote = remote_teams(app);
    let again = if remote.is_empty() {
        None
    } else if let Some(scenario) = changed.filter(|_| remote.iter().all(|team| arguments.teams.of(*team).is_some())) {
        Some((scenario, Vec::new()))
    } else if let Some(scenario) = scenario.filter(|_| !arguments.teams.are_given()) {
        refuse_absent_programs(app)?;
        Some((scenario, traced))
    } else {
        return Err(unknown_thoughts());
    };
    change(app, arguments)?;
    let cycle = app.world().resource::<CycleClock>().cycle;
    Ok(again.map(|(scenario, traced)| PlayedAgain { scenario, cycle, traced }))
}

/// Changes the settings of the command line.
fn change(app: &mut App, arguments: &WhatIfArguments) -> Result<(), ExitCode> {
    if arguments.set.is_empty() { Ok(()) } else { change_match(app, &arguments.moment, &arguments.set) }
}

/// Replaces the teams of the match in `app` by those of the command line. Returns the scenario that does so, if there are any.
fn change_teams(app: &mut App, arguments: &WhatIfArguments) -> Result<Option<Scenario>, ExitCode> {
    if !arguments.teams.are_given() {
        return Ok(None);
    }
    let failure = |error: &dyn Error| report::failure(&error.to_string());
    let moment = moment_of(app)?;
    let saved = SavedMatch::of_bytes(moment.bytes()).map_err(|error| failure(&error))?;
    let scenario = saved.scenario().map_err(|error| failure(&error))?;
    let text = Scenario { from: Some(saved), ..scenario }.resolved_json();
    let text = text.or_failure()?;
    let file = ScenarioFile::from_text(&text, Format::Json, &arguments.moment);
    let mut file = file.map_err(|error| report::scenario_error(&error))?;
    arguments.teams.choose(app.world(), &mut file).or_usage_error()?;
    app.start_match(&file.scenario).map_err(|fault| report::scenario_error(&file.source.error(&fault)))?;
    Ok(Some(file.scenario))
}

/// Loads the saved match of a scenario that continues one, with the behaviours and settings of the scenario. Returns the scenario.
fn go_on_from_saved(app: &mut App, arguments: &WhatIfArguments) -> Result<Scenario, ExitCode> {
    let file = scenario_file(&arguments.moment)?;
    let mut file = file.check_with(&arguments.set).map_err(|errors| report::scenario_errors(&errors))?;
    if file.scenario.from.is_none() {
        return Err(no_moment(&arguments.moment));
    }
    arguments.teams.choose(app.world(), &mut file).or_usage_error()?;
    app.start_match(&file.scenario).map_err(|fault| report::scenario_error(&file.source.error(&fault)))?;
    Ok(file.scenario)
}

fn no_moment(word: &str) -> ExitCode {
    report::usage_error(&format!(
        "`{word}` is no moment of a match; expected a saved match (`.naoisis`), a scenario that goes on `from` one, or a trace and a \
         time in seconds, such as match.jsonl@312.5"
    ))
}

fn unknown_thoughts() -> ExitCode {
    report::usage_error(
        "programs play robots of this match, and what they have in mind at that moment is not saved; expected a trace of the match \
         (match.jsonl@312.5), with which they play it again, or teams that begin there, by --blue and --pink",
    )
}

/// Refuses to go on with robots whose programs connected to the match: a trace does not say how to start them.
fn refuse_absent_programs(app: &mut App) -> Result<(), ExitCode> {
    let mut robots = app.world_mut().query_filtered::<&RobotId, (With<Remote>, Without<behaviour::Program>)>();
    let mut absent: Vec<RobotId> = robots.iter(app.world()).copied().collect();
    absent.sort();
    if absent.is_empty() {
        return Ok(());
    }
    let absent = absent.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    Err(report::usage_error(&format!(
        "{absent}: programs that had connected played these robots, and nothing says how they are started; expected teams that go on \
         from there, by --blue and --pink"
    )))
}

/// Returns the teams with robots that programs play.
fn remote_teams(app: &mut App) -> Vec<Team> {
    let mut teams: Vec<Team> = remote_robots(app.world()).iter().map(|id| id.team).collect();
    teams.sort();
    teams.dedup();
    teams
}

/// Replays the match of a trace until `time_s`, with its programs, which answer as in the trace, and checks that it is the same match.
/// Returns its scenario, and what the trace has of the programs.
fn play_again(app: &mut App, path: &Path, time_s: f64) -> Result<(Scenario, Vec<TracedCycle>), ExitCode> {
    let usage_error = |message: String| report::usage_error(&format!("{}: {message}", path.display()));
    let mut trace = TraceReader::open(path).or_usage_error()?;
    if time_s < 0.0 {
        return Err(usage_error(format!("there is no moment at {time_s} s")));
    }
    app.start_match(trace.scenario()).map_err(|fault| usage_error(fault.to_string()))?;
    begin_programs(app.world_mut()).map_err(|error| usage_error(error.to_string()))?;
    let commanded = if trace.fields().has("robots.command") { remote_robots(app.world()) } else { Vec::new() };
    let (mut last_s, mut cycles) = (0.0, Vec::new());
    loop {
        let record = trace.next_cycle().or_usage_error()?;
        let Some(record) = record else {
            return Err(usage_error(format!("the trace ends at {last_s:.1} s; there is no moment at {time_s} s")));
        };
        last_s = record.time_s;
        let cycle = TracedCycle::of(&record, &commanded);
        cycle.play(app.world_mut()).map_err(usage_error)?;
        cycles.push(cycle);
        if !is_same(app, &record, trace.fields()) {
            let message = format!(
                "played again, the match is another one from {last_s:.2} s on: its behaviours or the program have changed since, \
                 something was done to it by hand, or its programs do not answer the same way each time, and the trace does not have the \
                 commands of all cycles; expected an earlier moment"
            );
            return Err(usage_error(message));
        }
        if record.time_s >= time_s - 1e-6 {
            return Ok((trace.scenario().clone(), cycles));
        }
    }
}

/// Returns the statistics as text.
fn in_words(moment: &Moment, scenario: &str, realism: &str, until_s: f32, outcomes: &Outcomes) -> String {
    let percent = |estimate: Option<Estimate>| match estimate {
        Some(Estimate { value, low, high }) => {
            format!("{:5.1} % ({:.1} to {:.1})", 100.0 * value, 100.0 * low, 100.0 * high)
        }
        None => "-".to_owned(),
    };
    let mut text = format!(
        "{scenario} from {:.2} s on, at {}:{}, {} times, for {until_s} s; realism {realism}\n",
        moment.time_s, moment.score.blue, moment.score.pink, outcomes.times
    );
    for team in Team::BOTH {
        let _ = writeln!(text, "{:20} {}", format!("{team} scores"), percent(outcomes.scores[team]));
        let _ = writeln!(text, "{:20} {}", format!("{team} scores first"), percent(outcomes.scores_first[team]));
    }
    let _ = writeln!(text, "{:20} {}", "neither scores", percent(outcomes.nobody_scores));
    if let Some(estimate) = outcomes.goal_difference {
        let (value, margin) = (rounded(estimate.value, 2), estimate.margin());
        let _ = writeln!(text, "{:20} {value:+.2} ± {margin:.2}", "goals, blue - pink");
    }
    if let Some(time_s) = outcomes.first_goal_s {
        let _ = writeln!(text, "{:20} after {time_s:.1} s (median, of those with a goal)", "the first goal");
    }
    if let Some([x, y]) = outcomes.ball_m {
        let _ = writeln!(text, "{:20} ({:.2}, {:.2}) m (mean position at the end)", "the ball", x.value, y.value);
    }
    text.push_str("Intervals are those of 95 % confidence.\n");
    text
}

//! `naoisis run`: plays a match without a window, as fast as possible.

use bevy::log::{Level, LogPlugin};
use bevy::prelude::*;
use core::time::Duration;
use indicatif::{ProgressBar, ProgressStyle};
use std::process::ExitCode;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use super::agents::connected;
use super::expect::{print_verdicts, write_junit};
use super::interrupt::Interrupt;
use super::pace::Pace;
use super::report::{CommandResult, OrReport};
use super::run_arguments::RunArguments;
use super::run_summary::{Outcome, summary, tally, title, words_of};
use super::terminal::Printer;
use super::{Program, begin, outputs, report};
use naoisis_agents::agents::server::{Address, Server, free_robots};
use naoisis_agents::agents::{self, AgentPlayer, AgentSettings, BreakOff, PlayedElsewhere, remote_robots};
use naoisis_core::cycle::{CycleClock, run_cycle};
use naoisis_core::events::{CycleEvents, MatchEvent};
use naoisis_core::game::{Game, GameState, Rules};
use naoisis_core::referee::report::report as match_report;
use naoisis_core::robot::Roster;
use naoisis_core::team::{PerTeam, RobotId};
use naoisis_record::batch::refuse_real_time;
use naoisis_record::expectations::{self, Watch};
use naoisis_record::record::RecordPlugin;
use naoisis_record::record::live_control::LiveControl;
use naoisis_record::record::recorder::{self, EndReason, Recorders};
use naoisis_sim::scenario::{Scenario, ScenarioFile};
use naoisis_sim::simulation::Snapshot;

/// Number of cycles between two updates of the progress bar: few enough that it also moves while pictures are written.
const CYCLES_PER_PROGRESS: u64 = 16;

/// The time after which a paused match looks whether it goes on.
const PAUSED: Duration = Duration::from_millis(10);

/// Runs the command.
pub fn run(program: Program, arguments: &RunArguments) -> CommandResult {
    run_match(program, arguments, None, |app| begin::begin(app, arguments))
}

/// Plays a scenario with the other arguments of the command.
pub fn run_scenario(program: Program, file: &ScenarioFile, arguments: &RunArguments) -> CommandResult {
    run_match(program, arguments, None, |app| begin::begin_with(app, file, arguments))
}

/// Plays the match that `begin` starts in the app. With an address, it first waits for programs to connect.
pub(super) fn run_match(
    program: Program,
    arguments: &RunArguments,
    listen: Option<&Address>,
    begin: impl FnOnce(&mut App) -> Result<(), ExitCode>,
) -> CommandResult {
    // If a graphics adapter is needed and missing, that is reported elsewhere.
    let filter = "warn,wgpu_hal::vulkan::instance=off,rustdds=off".to_owned();
    let log = LogPlugin { level: Level::WARN, filter, ..default() };
    let mut app = program.simulator_with((log, RecordPlugin));
    arguments.check_outputs().or_usage_error()?;
    begin(&mut app)?;
    let scenario = app.world().resource::<Scenario>().clone();
    check_arguments(app.world(), &scenario, arguments).or_usage_error()?;
    let interrupt = Interrupt::watch(|| {}).or_failure()?;
    let watched = interrupt.clone();
    app.world_mut().resource_mut::<AgentSettings>().break_off = Some(BreakOff(Arc::new(move || watched.is_stopped())));
    arguments.game_controller.start(app.world_mut()).or_usage_error()?;
    agents::start_programs(app.world_mut()).or_usage_error()?;
    #[cfg(feature = "booster")]
    arguments.booster.start(app.world_mut());
    let mut server = match listen {
        Some(address) => let_programs_in(app.world_mut(), address, &interrupt).or_usage_error()?,
        None => None,
    };
    if server.is_none() {
        tell_of_nobodys_robots(app.world());
    }
    let recorders = arguments.recordings.open(app.world(), arguments.force).or_usage_error()?;
    if !recorders.is_empty() {
        recorder::start(app.world_mut(), recorders);
    }
    let taken = arguments.recordings.take_standard_output();
    let mut printer = if taken { Printer::to_stderr() } else { Printer::default() };
    if arguments.explain {
        printer.print(title(&scenario));
    }
    let started_at_cycle = app.world().resource::<CycleClock>().cycle;
    let started = Instant::now();
    let mut run_cycle = |world: &mut World| {
        // A program that was lost may come back.
        if let Some(server) = &mut server {
            server.look(world, report::note);
        }
        run_cycle(world);
    };
    let mut outcome = run_to_the_end(app.world_mut(), &scenario, &interrupt, &mut printer, arguments, &mut run_cycle);
    let wall_s = started.elapsed().as_secs_f64();
    if !outcome.saved {
        outcome.not_saved = save(app.world_mut(), arguments).err();
        if let Some(save_at_s) = arguments.save_at {
            report::note(&format!("the match ended before {save_at_s} s: it was saved at its end"));
        }
    }
    outcome.all_programs_lost = outcome.agents_lost != PerTeam::default() && !is_any_played(app.world());
    agents::dismiss(app.world_mut(), words_of(outcome.reason));
    let status = finish(app.world_mut(), &outcome, started_at_cycle, wall_s, &mut printer, arguments);
    let status = match judge((program, &interrupt), &outcome, &scenario, &mut printer, &app, arguments) {
        Ok(()) => status,
        Err(failed) if status == ExitCode::SUCCESS => failed,
        Err(_) => status,
    };
    let status = printer.finish(status);
    Ok(if outcome.reason == EndReason::Interrupted { interrupt.finish(status) } else { status })
}

/// Checks the arguments that depend on the match.
fn check_arguments(world: &World, scenario: &Scenario, arguments: &RunArguments) -> Result<(), String> {
    arguments.expectations.check(scenario)?;
    arguments.check_time_of_saving(world, scenario)?;
    arguments.network_of_many()?;
    if arguments.expectations.asks_for_many() {
        refuse_real_time(world).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// Prints a note about robots that stand still because no program can connect.
fn tell_of_nobodys_robots(world: &World) {
    let free: Vec<String> = free_robots(world).iter().map(ToString::to_string).collect();
    if !free.is_empty() {
        report::note(&format!("note: no program plays {}: `naoisis serve` lets programs connect", free.join(", ")));
    }
}

/// Waits until every remote robot of the match is played by a program that connects. Returns no server if others play all remote robots.
fn let_programs_in(world: &mut World, address: &Address, interrupt: &Interrupt) -> Result<Option<Server>, String> {
    let free: Vec<String> = free_robots(world).iter().map(ToString::to_string).collect();
    if free.is_empty() {
        if !remote_robots(world).is_empty() {
            return Ok(None);
        }
        return Err(
            "no robot of the match is remote; expected a scenario with remote robots, or --blue remote".to_owned()
        );
    }
    let mut server = Server::listen(address).map_err(|error| format!("--listen: {address}: {error}"))?;
    report::note(&format!("listening at {}; waiting for {}", server.address(), free.join(", ")));
    if server.address().is_reachable() && world.resource::<AgentSettings>().token.is_none() {
        report::note(
            "warning: every program that reaches this address over the network may play; --token lets in only those that know it",
        );
    }
    server.let_in(world, || interrupt.is_stopped(), report::note);
    Ok(Some(server))
}

/// Judges the expectations, prints the verdicts and writes them to a file.
///
/// # Errors
/// The exit status if an expectation fails.
fn judge(
    (program, interrupt): (Program, &Interrupt),
    outcome: &Outcome,
    scenario: &Scenario,
    printer: &mut Printer,
    app: &App,
    arguments: &RunArguments,
) -> Result<(), ExitCode> {
    let expectations = &arguments.expectations;
    if expectations.expect.is_empty() && expectations.junit.is_none() || outcome.reason == EndReason::Interrupted {
        return Ok(());
    }
    let mut verdicts = expectations::judge(&outcome.watch, &expectations.of_match());
    let settings = app.world().get_resource::<AgentSettings>().cloned().unwrap_or_default();
    let network = arguments.network_of_many().or_usage_error()?;
    let simulator = || connected(program.simulator(), &settings, network.as_ref());
    verdicts.extend(expectations.judge_many(simulator, scenario, interrupt).map_err(|message| {
        let status = report::failure(&message);
        if interrupt.is_stopped() { interrupt.finish(ExitCode::SUCCESS) } else { status }
    })?);
    let all_hold = print_verdicts(printer, &verdicts, arguments.quiet);
    if let Some(path) = &expectations.junit {
        let written = write_junit(path, &[(arguments.scenario.clone(), Ok(verdicts))]);
        written.or_failure()?;
    }
    if all_hold { Ok(()) } else { Err(ExitCode::FAILURE) }
}

/// Saves the match, if the arguments say so.
fn save(world: &mut World, arguments: &RunArguments) -> Result<(), String> {
    let Some(path) = &arguments.save else { return Ok(()) };
    let saved = Snapshot::take(world).and_then(|snapshot| snapshot.save(path, world));
    saved.map_err(|error| format!("cannot save the match: {error}"))
}

fn run_to_the_end(
    world: &mut World,
    scenario: &Scenario,
    interrupt: &Interrupt,
    printer: &mut Printer,
    arguments: &RunArguments,
    run_cycle: &mut impl FnMut(&mut World),
) -> Outcome {
    let period_s = world.resource::<CycleClock>().period_s;
    let last_cycle = scenario.last_cycle();
    let progress = progress_bar(length_s(scenario), arguments.quiet);
    let mut outcome = Outcome::default();
    let expected = arguments.expectations.of_match();
    outcome.watch = Watch::begin(world, &expected);
    let save_cycle = arguments.save_at.map(|at_s| outputs::cycle_at(at_s, world.resource::<CycleClock>()));
    let pace = arguments.pace.or(arguments.game_controller.pace());
    #[cfg(feature = "booster")]
    let pace = pace.or_else(|| super::booster::pace(world));
    let mut pace = pace.map(|times| Pace::new(times, period_s));
    loop {
        let cycle = world.resource::<CycleClock>().cycle;
        if save_cycle == Some(cycle) {
            outcome.not_saved = save(world, arguments).err();
            outcome.saved = true;
        }
        if cycle.is_multiple_of(CYCLES_PER_PROGRESS) {
            progress.set_position((cycle as f64 * period_s) as u64);
        }
        if let Some(reason) = end_reason(world, last_cycle, interrupt) {
            outcome.reason = reason;
            break;
        }
        if let Some(live) = world.get_resource::<LiveControl>() {
            while !live.may_play() && !interrupt.is_stopped() {
                thread::sleep(PAUSED);
            }
            if let Some(times) = live.take_speed() {
                pace = Some(Pace::new(times, period_s));
            }
        }
        if let Some(pace) = &mut pace {
            pace.wait(|| interrupt.is_stopped());
        }
        run_cycle(world);
        if !expected.is_empty() {
            outcome.watch.observe(world, &expected);
        }
        note_events(world, &mut outcome, &progress, printer, arguments);
    }
    progress.finish_and_clear();
    outcome
}

/// Returns why the match ends before its next cycle. Returns `None` if it goes on.
fn end_reason(world: &World, last_cycle: Option<u64>, interrupt: &Interrupt) -> Option<EndReason> {
    if world.resource::<Game>().state == GameState::Finished {
        return Some(EndReason::FinalWhistle);
    }
    if last_cycle.is_some_and(|last| world.resource::<CycleClock>().cycle >= last) {
        return Some(EndReason::Duration);
    }
    if interrupt.is_stopped() {
        return Some(EndReason::Interrupted);
    }
    world.get_resource::<Recorders>().is_some_and(Recorders::has_failed).then_some(EndReason::Failed)
}

/// Takes the events of the cycle into `outcome`, and prints those that the user is told at once.
fn note_events(
    world: &World,
    outcome: &mut Outcome,
    progress: &ProgressBar,
    printer: &mut Printer,
    arguments: &RunArguments,
) {
    let time_s = world.resource::<CycleClock>().end_time_s();
    let to_play_s = world.resource::<Game>().time_left_s(world.resource::<CycleClock>());
    for event in world.resource::<CycleEvents>().iter() {
        if arguments.explain
            && let Some(text) = match_report(time_s, to_play_s, event)
        {
            *outcome.decisions.entry(event.kind()).or_default() += 1;
            progress.suspend(|| printer.print(format_args!("{text}\n")));
        }
        match event {
            MatchEvent::AgentLost { robot, message, .. } => {
                outcome.agents_lost[robot.team] += 1;
                progress.suspend(|| report::note(&format!("{robot} lost its program at {time_s:.2} s: {message}")));
            }
            MatchEvent::CommandRefused { robot, command, reason } if is_played_by_program(world, *robot) => {
                *outcome.refused.entry((*robot, *command, *reason)).or_default() += 1;
            }
            MatchEvent::Kick { robot, kick_type, reason: Some(reason), .. } if is_played_by_program(world, *robot) => {
                *outcome.missed.entry((*robot, kick_type.to_string(), *reason)).or_default() += 1;
            }
            MatchEvent::Goal { team, .. } => outcome.goals.push((time_s, *team)),
            MatchEvent::InvariantBroken { message } => {
                outcome.broken_invariants.push(format!("{time_s:.2} s: {message}"));
            }
            _ => {}
        }
    }
}

/// Returns the length of a match by its own clock, s: without time that the referee adds.
pub(super) fn length_s(scenario: &Scenario) -> f32 {
    scenario.longest_s().unwrap_or(scenario.rules.longest_s())
}

/// Returns a progress bar of the simulated seconds; it is hidden if standard error is not a terminal.
fn progress_bar(length_s: f32, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let progress = ProgressBar::new(length_s.ceil() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} s simulated, {eta} left") {
        progress.set_style(style);
    }
    progress
}

fn finish(
    world: &mut World,
    outcome: &Outcome,
    started_at_cycle: u64,
    wall_s: f64,
    printer: &mut Printer,
    arguments: &RunArguments,
) -> ExitCode {
    let clock = *world.resource::<CycleClock>();
    let result = world.resource::<Game>().result(world.resource::<Rules>());
    let realism = world.get_resource::<Scenario>().map(Scenario::realism_in_words).unwrap_or_default();
    for said in recorder::finish(world, outcome.reason) {
        match said {
            Ok(Some(summary)) if !arguments.quiet => printer.print(summary),
            Ok(_) => {}
            // The program that reads the trace may have closed the pipe.
            Err(error) if error.is_broken_pipe() => return ExitCode::SUCCESS,
            Err(error) => {
                return report::failure(&format!("cannot write {error}{}", outputs::use_of_a_part(&error)));
            }
        }
    }
    if !arguments.quiet {
        printer.print(tally(&outcome.decisions));
        printer.print(summary(outcome, clock, started_at_cycle, result, &realism, wall_s));
    }
    if let Some(message) = &outcome.not_saved {
        return report::failure(message);
    }
    match outcome.broken_invariants.first() {
        // Expectations decide where there are any.
        None if outcome.all_programs_lost && arguments.expectations.expect.is_empty() => {
            report::failure("every robot that a program played has lost it")
        }
        None => ExitCode::SUCCESS,
        Some(first) => report::failure(&format!(
            "invariants were broken {} times; first at {first}",
            outcome.broken_invariants.len()
        )),
    }
}

/// Returns whether a program still plays a robot.
fn is_any_played(world: &World) -> bool {
    let plays = |(_, entity)| {
        world.get::<AgentPlayer>(entity).is_some_and(AgentPlayer::has_program)
            || world.get::<PlayedElsewhere>(entity).is_some()
    };
    world.resource::<Roster>().iter().any(plays)
}

fn is_played_by_program(world: &World, robot: RobotId) -> bool {
    let entity = world.resource::<Roster>().get(robot);
    let is_played =
        |entity| world.get::<AgentPlayer>(entity).is_some() || world.get::<PlayedElsewhere>(entity).is_some();
    entity.is_some_and(is_played)
}

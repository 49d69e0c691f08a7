//! Runs the match: pause, single cycle, speed, restart.
//!
//! The [`Cycle`](naoisis_core::cycle::Cycle) runs from `FixedUpdate` with the period of the scenario; pause and speed
//! change `Time<Virtual>`. At unlimited speed, more cycles are due than a frame has time for. The match is the same at
//! every speed.

use bevy::prelude::*;
use bevy::time::TimeSystems;
use core::time::Duration;
use std::path::Path;
use std::time::Instant;

#[cfg(test)]
mod tests;

use super::commands::ViewerCommand;
use super::event_log::EventLog;
use super::keyframes::{self, Keyframes, Simulator};
use super::memory::ViewerMemory;
use super::plots;
use super::shared::{DisplayFraction, Notice, OVER, Playback, is_over, replace_match};
use super::speed::Speed;
use super::timeline::{self, Timeline, TimelinePlugin, TimelineSystems};
use naoisis_core::behaviour::AskAhead;
use naoisis_core::cycle::{CycleClock, CyclePanic, PendingHalf, try_run_cycle};
use naoisis_core::game::{Game, Interventions};
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_sim::scenario::{Scenario, ScenarioFault, ScenarioFile};
use naoisis_sim::simulation::{self, Snapshot};

/// The least and the longest time of a frame for cycles at unlimited speed.
const BUDGETS: [Duration; 2] = [Duration::from_millis(12), Duration::from_millis(600)];
/// The longest frame that the match follows in real time. With slower frames the match becomes slower, too.
const LONGEST_FRAME: Duration = Duration::from_secs(2);
/// The longest time of a frame for cycles in real time and slower. If they take longer, the match becomes slower, too.
/// Faster speeds have the budget of the unlimited one, so that none is faster than that.
const LONGEST_CYCLES: Duration = Duration::from_millis(500);
/// The speed of Bevy's clock at unlimited speed: more cycles are due than a frame has time for.
const FASTEST: f64 = 10_000.0;
/// The number of cycles that a frame runs whatever its budget, if they take no longer than that.
const LEAST_CYCLES: u32 = 4;
/// The time over which the achieved speed is measured, s.
const MEASURED_OVER_S: f32 = 0.5;

/// Runs the match in the window.
pub struct DrivePlugin;

impl Plugin for DrivePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(TimelinePlugin)
            .configure_sets(
                RunFixedMainLoop,
                TimelineSystems.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop).after(find_display_fraction),
            )
            .add_message::<ViewerCommand>()
            .init_resource::<Playback>()
            .init_resource::<PlayedFile>()
            .init_resource::<Notice>()
            .init_resource::<DisplayFraction>()
            .init_resource::<FrameTime>()
            .add_systems(Startup, set_longest_frame)
            .add_systems(First, (note_frame, handle_commands, set_clocks).chain().before(TimeSystems))
            .add_systems(FixedUpdate, run_cycle_in_time)
            .add_systems(RunFixedMainLoop, find_display_fraction.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop))
            .add_systems(Update, measure_speed);
    }
}

fn is_over_in(world: &World) -> bool {
    is_over(world.resource(), world.resource(), world.resource())
}

fn set_longest_frame(mut time: ResMut<Time<Virtual>>) {
    time.set_max_delta(LONGEST_FRAME);
}

pub(super) fn handle_commands(world: &mut World) {
    let commands: Vec<ViewerCommand> = world.resource_mut::<Messages<ViewerCommand>>().drain().collect();
    for command in commands {
        match command {
            ViewerCommand::TogglePause => toggle_pause(world),
            ViewerCommand::Step => {
                world.resource_mut::<Playback>().paused = true;
                if world.resource::<Timeline>().is_past() {
                    timeline::step(world, 1);
                } else {
                    *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
                    advance(world);
                }
            }
            ViewerCommand::Faster => set_speed(world, |speed| speed.neighbour(1)),
            ViewerCommand::Slower => set_speed(world, |speed| speed.neighbour(-1)),
            ViewerCommand::SetSpeed(wanted) => set_speed(world, |_| wanted),
            ViewerCommand::Restart => restart(world, 0),
            ViewerCommand::RestartWithNextSeed => restart(world, 1),
            // The module of the match before handles this one.
            ViewerCommand::MatchBefore => {}
            ViewerCommand::Load(name) => {
                let result = load(world, name);
                world.resource_mut::<Playback>().problem = result.err();
            }
        }
    }
}

fn load(world: &mut World, name: &str) -> Result<(), String> {
    start_file(world, ScenarioFile::named(name).map_err(|error| error.to_string())?)?;
    if let Some(mut memory) = world.get_resource_mut::<ViewerMemory>() {
        memory.note_scenario(name);
    }
    Ok(())
}

fn set_speed(world: &mut World, choose: impl FnOnce(Speed) -> Speed) {
    let mut playback = world.resource_mut::<Playback>();
    playback.speed = choose(playback.speed);
}

fn toggle_pause(world: &mut World) {
    let mut playback = world.resource_mut::<Playback>();
    playback.paused = !playback.paused;
    let plays = !playback.paused;
    let is_over = is_over_in(world);
    let timeline = world.resource::<Timeline>();
    if plays && is_over && !timeline.is_past() && !timeline.is_replay() {
        world.resource_mut::<Notice>().tell(OVER);
        return;
    }
    let last = world.resource::<History>().last_cycle();
    if plays && timeline.is_replay() && timeline.cursor() == last.map(|last| last as f64) {
        timeline::go_to(world, 0.0);
    }
}

fn restart(world: &mut World, seed_step: u64) {
    if world.resource::<Timeline>().is_replay() {
        if seed_step != 0 {
            world
                .resource_mut::<Notice>()
                .tell("A replay keeps the seed of its match. R: from the start, F: new branch from here");
            return;
        }
        timeline::go_to(world, 0.0);
        world.resource_mut::<Playback>().paused = false;
        return;
    }
    let Some(mut scenario) = world.get_resource::<Scenario>().cloned() else { return };
    scenario.seed = scenario.seed.wrapping_add(seed_step);
    let result = start(world, &scenario);
    world.resource_mut::<Playback>().problem = result.err().map(|fault| fault.to_string());
}

/// The text of the scenario, if it is known. Later choices are merged into it.
#[derive(Resource, Clone, Debug, Default)]
pub struct PlayedFile(pub Option<ScenarioFile>);

impl PlayedFile {
    /// Returns the name of the file without its folder; empty without a file.
    pub fn name(&self) -> String {
        let path = self.0.as_ref().map(|file| Path::new(&file.source.name));
        path.and_then(Path::file_name).map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }
}

/// Starts the match of a file, in place of the current one.
///
/// # Errors
/// A message about the scenario if it is invalid. The current match then continues.
pub(super) fn start_file(world: &mut World, file: ScenarioFile) -> Result<(), String> {
    start(world, &file.scenario).map_err(|fault| file.source.error(&fault).to_string())?;
    world.insert_resource(PlayedFile(Some(file)));
    Ok(())
}

/// Starts a match, in place of the current one.
///
/// # Errors
/// The fault of the scenario if it is invalid. The current match then continues.
pub(super) fn start(world: &mut World, scenario: &Scenario) -> Result<(), ScenarioFault> {
    replace(world, |world| simulation::start_match(world, scenario))
}

/// Puts another match in place of the current one.
///
/// # Errors
/// That of `begin`. The current match then continues.
pub(super) fn replace<E>(world: &mut World, begin: impl FnOnce(&mut World) -> Result<(), E>) -> Result<(), E> {
    replace_match(world, begin)?;
    timeline::forget(world);
    world.resource_mut::<EventLog>().clear();
    world.resource_mut::<Playback>().failed = false;
    *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
    Ok(())
}

/// Continues a saved match, in place of the current one.
///
/// # Errors
/// A message about the file. The current match then continues.
pub(super) fn go_on(world: &mut World, path: &Path) -> Result<(), String> {
    let saved = Snapshot::load(path, world).map_err(|error| error.to_string())?;
    replace(world, |world| saved.restore(world)).map_err(|error| format!("{}: {error}", path.display()))?;
    world.insert_resource(PlayedFile::default());
    Ok(())
}

/// Plays up to a cycle, for a part of a frame. Returns whether it was reached or the match cannot come that far.
pub(super) fn play_until(world: &mut World, cycle: u64) -> bool {
    let started = Instant::now();
    while started.elapsed() < LONGEST_CYCLES {
        if world.resource::<CycleClock>().cycle >= cycle || !advance(world) {
            return true;
        }
    }
    false
}

/// Sets Bevy's clocks to the period of the match and the wanted speed.
pub(super) fn set_clocks(
    scenario: Option<Res<Scenario>>,
    mut playback: ResMut<Playback>,
    mut fixed: ResMut<Time<Fixed>>,
    mut virtual_time: ResMut<Time<Virtual>>,
) {
    if let Some(scenario) = scenario.filter(|scenario| scenario.is_changed()) {
        let overstep = fixed.overstep();
        fixed.discard_overstep(overstep);
        fixed.set_timestep(Duration::from_secs_f64(scenario.cycle_s));
        playback.last_cycle = scenario.last_cycle();
    }
    let factor = match playback.speed {
        Speed::Times(factor) => factor,
        Speed::Unlimited => FASTEST,
    };
    if playback.paused {
        virtual_time.pause();
    } else {
        virtual_time.unpause();
        virtual_time.set_relative_speed_f64(factor);
    }
}

/// Runs a cycle. Returns false if the match is over, there is none, its past is shown, or a program has not answered yet. In that case, the
/// next call continues the cycle.
fn advance(world: &mut World) -> bool {
    let stands = world.resource::<Timeline>().is_past() || world.resource::<Playback>().failed;
    if stands || !world.contains_resource::<Scenario>() || is_over_in(world) {
        return false;
    }
    if world.contains_resource::<Simulator>() && *world.resource::<PendingHalf>() == PendingHalf::Whole {
        keyframes::keep_if_due(world);
        // Interventions of the user are not repeated when the match is played again from a keyframe, so they are noted as a change.
        if !world.resource::<Interventions>().queue.is_empty() {
            world.resource::<Keyframes>().note_change();
        }
    }
    let result = run_cycle_unless_a_program_thinks(world);
    if result == Ok(None) {
        plots::note_cycle(world);
    }
    let mut playback = world.resource_mut::<Playback>();
    match &result {
        Ok(Some(robot)) => {
            let since = playback.awaited.filter(|(awaited, _)| awaited == robot).map(|(_, since)| since);
            playback.awaited = Some((*robot, since.unwrap_or_else(Instant::now)));
        }
        Ok(None) => {
            playback.awaited = None;
            playback.note_progress(1.0);
        }
        Err(panic) => {
            playback.failed = true;
            playback.problem = Some(format!("{panic}. The match cannot continue; restart it or open another."));
        }
    }
    result == Ok(None)
}

/// Runs a cycle, or the rest of it. Returns the robot whose program has not answered yet, if the cycle has to stop for it.
fn run_cycle_unless_a_program_thinks(world: &mut World) -> Result<Option<RobotId>, CyclePanic> {
    let ask_ahead = world.get_resource::<AskAhead>().copied();
    let awaited = ask_ahead.map_or(Ok(None), |AskAhead(ask_ahead)| ask_ahead(world))?;
    if awaited.is_none() {
        try_run_cycle(world)?;
    }
    Ok(awaited)
}

/// The time that cycles have in this frame.
#[derive(Resource)]
struct FrameTime {
    /// The time at which the frame began.
    began: Instant,
    /// The time for cycles at unlimited speed.
    budget: Duration,
    /// The time that cycles have taken, and their number.
    taken: Duration,
    cycles: u32,
    /// Whether no further cycle can run.
    is_done: bool,
}

impl FrameTime {
    /// Whether another cycle can run, if cycles may take this long.
    fn has_time(&self, longest: Duration) -> bool {
        self.taken < longest || (self.cycles < LEAST_CYCLES && self.taken < LONGEST_CYCLES)
    }
}

impl Default for FrameTime {
    fn default() -> Self {
        Self { began: Instant::now(), budget: BUDGETS[0], taken: Duration::ZERO, cycles: 0, is_done: false }
    }
}

fn note_frame(mut frame: ResMut<FrameTime>) {
    let rest = frame.began.elapsed().saturating_sub(frame.taken);
    *frame = FrameTime { budget: budget(rest), ..default() };
}

/// Runs a cycle if this frame still has time for it, else drops the cycles that are due in it: each would still cost a run of the
/// fixed schedule.
fn run_cycle_in_time(world: &mut World) {
    let frame = world.resource::<FrameTime>();
    let longest = longest_cycles(world.resource::<Playback>().speed, frame.budget);
    let started = Instant::now();
    let is_done = frame.is_done || !frame.has_time(longest) || !advance(world);
    let mut frame = world.resource_mut::<FrameTime>();
    frame.is_done = is_done;
    frame.taken += started.elapsed();
    frame.cycles += 1;
    if is_done {
        let mut fixed = world.resource_mut::<Time<Fixed>>();
        let due = whole_steps(fixed.overstep(), fixed.timestep());
        fixed.discard_overstep(due);
    }
}

/// The part of a duration that consists of whole steps.
fn whole_steps(duration: Duration, step: Duration) -> Duration {
    let rest = duration.as_nanos().checked_rem(step.as_nanos()).and_then(|rest| u64::try_from(rest).ok());
    rest.map_or(Duration::ZERO, |rest| duration - Duration::from_nanos(rest))
}

/// The longest time of a frame for cycles at a speed.
fn longest_cycles(speed: Speed, budget: Duration) -> Duration {
    match speed {
        Speed::Times(factor) if factor <= 1.0 => LONGEST_CYCLES,
        Speed::Times(_) | Speed::Unlimited => budget,
    }
}

/// The time of a frame for cycles at unlimited speed, if the rest of the frame takes this long: where drawing is slow,
/// cycles get more time than pictures.
fn budget(rest: Duration) -> Duration {
    (2 * rest).clamp(BUDGETS[0], BUDGETS[1])
}

fn find_display_fraction(
    playback: Res<Playback>,
    timeline: Res<Timeline>,
    game: Res<Game>,
    clock: Res<CycleClock>,
    fixed: Res<Time<Fixed>>,
    mut fraction: ResMut<DisplayFraction>,
) {
    // The displayed moment of the past has its own fraction.
    if timeline.is_past() {
        return;
    }
    // While the match is paused, the displayed fraction stays as it is.
    if playback.speed == Speed::Unlimited || is_over(&game, &clock, &playback) {
        fraction.0 = 1.0;
    } else if !playback.paused {
        fraction.0 = fixed.overstep_fraction();
    }
}

fn measure_speed(time: Res<Time<Real>>, clock: Res<CycleClock>, mut playback: ResMut<Playback>) {
    playback.measured.1 += time.delta_secs();
    let (cycles, elapsed_s) = playback.measured;
    if elapsed_s >= MEASURED_OVER_S {
        playback.achieved = (cycles * clock.period_s) as f32 / elapsed_s;
        playback.measured = (0.0, 0.0);
    }
}

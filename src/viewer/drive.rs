//! Runs the match: pause, single cycle, speed, restart.
//!
//! The [`Cycle`](crate::cycle::Cycle) runs from `FixedUpdate`, whose step is the scenario's cycle; pause and speed act on
//! `Time<Virtual>`. As fast as it goes, cycles fill a part of every frame instead. What a cycle does depends on
//! neither: the match is the same at every speed.

use bevy::prelude::*;
use bevy::time::TimeSystems;
use core::fmt;
use core::time::Duration;
use std::time::Instant;

use super::event_log::EventLog;
use super::timeline::{self, Timeline, TimelinePlugin, TimelineSystems};
use crate::cycle::{CycleClock, try_run_cycle};
use crate::record::history::History;
use crate::referee::{Game, GameState};
use crate::scenario::{Scenario, ScenarioFile};
use crate::simulation;

/// The part of a frame that is spent on cycles when they go as fast as possible.
const BUDGET: Duration = Duration::from_millis(12);
/// A frame that took longer than this does not make the match jump: a slow display shows a slow match.
const LONGEST_FRAME: Duration = Duration::from_millis(500);
/// Over which time the achieved speed is measured, s.
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
            .init_resource::<DisplayFraction>()
            .add_systems(Startup, set_longest_frame)
            .add_systems(First, (obey_commands, set_clocks).chain().before(TimeSystems))
            .add_systems(FixedUpdate, run_cycle_in_time)
            .add_systems(RunFixedMainLoop, find_display_fraction.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop))
            .add_systems(Update, (run_cycles_as_fast_as_possible, measure_speed).chain());
    }
}

/// What the user wants of the match.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum ViewerCommand {
    /// Stop, or go on.
    TogglePause,
    /// Stop if it runs, and run one cycle.
    Step,
    /// The next higher speed.
    Faster,
    /// The next lower speed.
    Slower,
    /// This speed.
    SetSpeed(Speed),
    /// From the start, the same match again.
    Restart,
    /// From the start, with the next seed.
    RestartWithNextSeed,
    /// The built-in scenario of this name, from the start.
    Load(&'static str),
}

/// How fast the match is shown.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Speed {
    /// This many simulated seconds a second.
    Times(f64),
    /// As fast as it goes.
    Unlimited,
}

impl Speed {
    /// The speeds to choose from, in order.
    pub const ALL: [Speed; 9] = [
        Speed::Times(0.1),
        Speed::Times(0.25),
        Speed::Times(0.5),
        Speed::Times(1.0),
        Speed::Times(2.0),
        Speed::Times(4.0),
        Speed::Times(8.0),
        Speed::Times(16.0),
        Speed::Unlimited,
    ];

    /// The next of [`Speed::ALL`] in a direction, if there is one.
    fn neighbour(self, steps: isize) -> Speed {
        let index = Speed::ALL.iter().position(|speed| *speed == self).unwrap_or(3);
        index.checked_add_signed(steps).and_then(|index| Speed::ALL.get(index)).copied().unwrap_or(self)
    }
}

impl fmt::Display for Speed {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Speed::Times(factor) => write!(formatter, "{factor}×"),
            Speed::Unlimited => formatter.write_str("max"),
        }
    }
}

/// How the match is being shown.
#[derive(Resource, Clone, PartialEq, Debug)]
pub struct Playback {
    /// Whether the match stands still.
    pub paused: bool,
    /// The wanted speed.
    pub speed: Speed,
    /// The speed of late, in simulated seconds a second.
    pub achieved: f32,
    /// What is wrong with the last command, if anything.
    pub problem: Option<String>,
    /// The cycle after which the match is over, where the scenario says.
    last_cycle: Option<u64>,
    /// Whether a cycle could not be finished, so that the match cannot go on.
    failed: bool,
    /// Cycles run, and over which time, since the achieved speed was last worked out.
    measured: (f64, f32),
}

impl Playback {
    /// Notes that so many cycles were shown.
    pub(super) fn note_progress(&mut self, cycles: f64) {
        self.measured.0 += cycles;
    }
}

impl Default for Playback {
    fn default() -> Self {
        Self {
            paused: false,
            speed: Speed::Times(1.0),
            achieved: 0.0,
            problem: None,
            last_cycle: None,
            failed: false,
            measured: (0.0, 0.0),
        }
    }
}

/// Where between the start (0) and the end (1) of the last cycle the match is shown.
#[derive(Resource, Clone, Copy, PartialEq, Debug)]
pub struct DisplayFraction(pub f32);

impl Default for DisplayFraction {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Whether the match has come to its end.
pub fn is_over(game: &Game, clock: &CycleClock, playback: &Playback) -> bool {
    game.state == GameState::Finished || playback.last_cycle.is_some_and(|last| clock.cycle >= last)
}

fn is_over_in(world: &World) -> bool {
    is_over(world.resource(), world.resource(), world.resource())
}

fn set_longest_frame(mut time: ResMut<Time<Virtual>>) {
    time.set_max_delta(LONGEST_FRAME);
}

fn obey_commands(world: &mut World) {
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
            ViewerCommand::Load(name) => match ScenarioFile::named(name) {
                Ok(file) => start(world, &file.scenario),
                Err(error) => world.resource_mut::<Playback>().problem = Some(error.to_string()),
            },
        }
    }
}

fn set_speed(world: &mut World, choose: impl FnOnce(Speed) -> Speed) {
    let mut playback = world.resource_mut::<Playback>();
    playback.speed = choose(playback.speed);
}

fn toggle_pause(world: &mut World) {
    let mut playback = world.resource_mut::<Playback>();
    playback.paused = !playback.paused;
    let plays = !playback.paused;
    let timeline = world.resource::<Timeline>();
    let last = world.resource::<History>().last_cycle();
    if plays && timeline.is_replay() && timeline.cursor() == last.map(|last| last as f64) {
        timeline::go_to(world, 0.0);
    }
}

fn restart(world: &mut World, seed_step: u64) {
    if world.resource::<Timeline>().is_replay() {
        timeline::go_to(world, 0.0);
        world.resource_mut::<Playback>().paused = false;
        return;
    }
    let Some(mut scenario) = world.get_resource::<Scenario>().cloned() else { return };
    scenario.seed = scenario.seed.wrapping_add(seed_step);
    start(world, &scenario);
}

/// Starts a match in place of the present one, or says why not.
pub(super) fn start(world: &mut World, scenario: &Scenario) {
    let problem = simulation::start_match(world, scenario).err().map(|fault| fault.to_string());
    if problem.is_none() {
        timeline::forget(world);
        world.resource_mut::<EventLog>().clear();
        world.resource_mut::<Playback>().failed = false;
        *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
    }
    world.resource_mut::<Playback>().problem = problem;
}

/// Makes Bevy's clocks those of the match and of the wanted speed.
fn set_clocks(
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
    let Speed::Times(factor) = playback.speed else {
        virtual_time.pause();
        return;
    };
    if playback.paused {
        virtual_time.pause();
    } else {
        virtual_time.unpause();
        virtual_time.set_relative_speed_f64(factor);
    }
}

/// Runs a cycle unless the match is over, there is none, or its past is shown.
fn advance(world: &mut World) -> bool {
    let stands = world.resource::<Timeline>().is_past() || world.resource::<Playback>().failed;
    if stands || !world.contains_resource::<Scenario>() || is_over_in(world) {
        return false;
    }
    let result = try_run_cycle(world);
    let mut playback = world.resource_mut::<Playback>();
    playback.note_progress(1.0);
    if let Err(panic) = &result {
        playback.failed = true;
        playback.problem = Some(format!("{panic}. The match cannot go on; start it again, or another."));
    }
    result.is_ok()
}

fn run_cycle_in_time(world: &mut World) {
    advance(world);
}

fn run_cycles_as_fast_as_possible(world: &mut World) {
    let playback = world.resource::<Playback>();
    if playback.paused || playback.speed != Speed::Unlimited {
        return;
    }
    let started = Instant::now();
    while started.elapsed() < BUDGET && advance(world) {}
}

fn find_display_fraction(
    playback: Res<Playback>,
    timeline: Res<Timeline>,
    game: Res<Game>,
    clock: Res<CycleClock>,
    fixed: Res<Time<Fixed>>,
    mut fraction: ResMut<DisplayFraction>,
) {
    // The past has a moment of its own.
    if timeline.is_past() {
        return;
    }
    // While it stands still, what is shown stays.
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

#[cfg(test)]
mod tests {
    use super::super::event_log::EventLogPlugin;
    use super::*;
    use crate::robot::{RobotId, Team};
    use crate::simulation::{MatchApp, NaoisisPlugins};
    use bevy::time::TimeUpdateStrategy;

    /// A ball that rolls and a robot that watches it, 1/30 s a cycle, shown at 60 frames/s.
    fn app() -> App {
        let scenario = Scenario::from_json(
            r#"{ "rules": "free", "seed": 7, "duration_s": 4.0, "ball": { "velocity_mps": [1.0, 0.0] },
                 "robots": [{ "number": 1, "pose": [-2.0, 0.0, 0.0] }] }"#,
        );
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(16_667)));
        app.start_match(&scenario.expect("a scenario")).expect("a match");
        // The first frame only starts the clock.
        app.update();
        app
    }

    fn frames(app: &mut App, count: usize) -> u64 {
        let before = app.cycle();
        for _ in 0..count {
            app.update();
        }
        app.cycle() - before
    }

    #[test]
    fn the_match_keeps_the_time_of_the_clock() {
        // 30 frames of 1/60 s and a bit are half a second: 15 cycles of 1/30 s.
        assert_eq!(frames(&mut app(), 30), 15);
    }

    #[test]
    fn speeds_scale_the_number_of_cycles() {
        for (speed, expected) in [(0.1, 1), (0.5, 7), (2.0, 30), (4.0, 60)] {
            let mut app = app();
            app.world_mut().write_message(ViewerCommand::SetSpeed(Speed::Times(speed)));
            assert_eq!(frames(&mut app, 30), expected, "at {speed} times");
        }
    }

    #[test]
    fn a_pause_stops_and_a_step_is_one_cycle() {
        let mut app = app();
        app.world_mut().write_message(ViewerCommand::TogglePause);
        assert_eq!(frames(&mut app, 30), 0);
        app.world_mut().write_message(ViewerCommand::Step);
        assert_eq!(frames(&mut app, 30), 1);
        assert_eq!(*app.world().resource::<DisplayFraction>(), DisplayFraction(1.0));
        app.world_mut().write_message(ViewerCommand::TogglePause);
        assert_eq!(frames(&mut app, 30), 15);
    }

    #[test]
    fn the_match_ends_where_the_scenario_ends() {
        let mut app = app();
        app.world_mut().write_message(ViewerCommand::SetSpeed(Speed::Unlimited));
        for _ in 0..10_000 {
            app.update();
        }
        assert_eq!(app.cycle(), 120);
    }

    #[test]
    fn a_restart_plays_the_same_match_again_and_the_next_seed_another() {
        let mut app = app();
        frames(&mut app, 40);
        let ball = app.ball();
        app.world_mut().write_message(ViewerCommand::Restart);
        app.update();
        assert!(app.cycle() <= 1);
        app.run_until(60, |app| app.cycle() == 20);
        assert_eq!(app.ball(), ball);
        app.world_mut().write_message(ViewerCommand::RestartWithNextSeed);
        app.update();
        assert_eq!(app.world().resource::<Scenario>().seed, 8);
        assert!(app.robot_pose(RobotId::new(Team::Blue, 1)).is_some());
    }

    #[test]
    fn another_scenario_can_be_loaded() {
        let mut app = app();
        frames(&mut app, 10);
        app.world_mut().write_message(ViewerCommand::Load("match3v3"));
        app.update();
        assert_eq!(app.world().resource::<Scenario>().name, "match3v3");
        assert!(app.robot_pose(RobotId::new(Team::Pink, 3)).is_some());
        // What cannot be loaded changes nothing, and is said.
        app.world_mut().write_message(ViewerCommand::Load("nothing"));
        app.update();
        assert_eq!(app.world().resource::<Scenario>().name, "match3v3");
        assert!(app.world().resource::<Playback>().problem.is_some());
    }

    #[test]
    fn changing_speeds_do_not_change_the_match() {
        let mut watched = app();
        for (speed, count) in [(0.25, 20), (16.0, 3), (1.0, 10), (0.5, 7)] {
            watched.world_mut().write_message(ViewerCommand::SetSpeed(Speed::Times(speed)));
            frames(&mut watched, count);
        }
        let cycle = watched.cycle();
        assert!(cycle > 20);
        let mut headless = app();
        headless.run_until(1000, |app| app.cycle() == cycle);
        assert_eq!(watched.ball(), headless.ball());
        assert_eq!(watched.ball_velocity(), headless.ball_velocity());
    }

    #[test]
    fn speeds_are_in_order_and_stop_at_the_ends() {
        assert_eq!(Speed::Times(1.0).neighbour(1), Speed::Times(2.0));
        assert_eq!(Speed::Times(1.0).neighbour(-1), Speed::Times(0.5));
        assert_eq!(Speed::Unlimited.neighbour(1), Speed::Unlimited);
        assert_eq!(Speed::ALL[0].neighbour(-1), Speed::ALL[0]);
    }
}

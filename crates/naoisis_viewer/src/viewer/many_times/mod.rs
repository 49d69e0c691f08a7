//! Repetitions of a moment: plays on from it many times in the background with other random numbers, and counts the
//! outcomes.
//!
//! One moment at a time is played on, on all cores but one. The final positions of the ball are drawn on the pitch
//! while the panel is open. Each repetition can be watched as a [branch](super::branches), and the moment can be saved
//! as a test.

use bevy::prelude::*;
use bevy_egui::{EguiPostUpdateSet, EguiPrimaryContextPass};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

mod heat_map;
mod panel;
mod saved_test;

use super::branches::BranchCommand;
use super::camera::{CameraMode, ViewerCamera};
use super::commands::ViewPreset;
use super::display_settings::DisplaySettings;
use super::keyframes::{Keyframes, Simulator};
use super::layout::LayoutSystems;
use super::overlays::OverlaySystems;
use super::rebuild::{RebuildSystems, Rebuilt};
use super::shared::{Notice, Playback};
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Intervention, Interventions};
use naoisis_core::pitch::Pitch;
use naoisis_core::team::Team;
use naoisis_record::whatif::{self, Continuation, Continuations, Moment};
use naoisis_sim::scenario::Scenario;

/// Plays on from moments many times, and shows the outcomes.
pub struct ManyTimesPlugin;

impl Plugin for ManyTimesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ManyTimes>()
            .add_message::<ManyTimesCommand>()
            .add_systems(Update, (apply, begin_when_known, listen).chain().after(RebuildSystems))
            .add_systems(
                PostUpdate,
                heat_map::draw.after(OverlaySystems).before(EguiPostUpdateSet::EndPass).run_if(is_open),
            )
            .add_systems(EguiPrimaryContextPass, panel::show.run_if(is_open).in_set(LayoutSystems::Right));
    }
}

fn is_open(display: Res<DisplaySettings>) -> bool {
    display.many_times
}

/// Commands about repetitions.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum ManyTimesCommand {
    /// Starts repetitions from the moment that is shown.
    Begin,
    /// Stops: repetitions in progress are finished.
    Stop,
    /// Shows the first repetition with this outcome.
    Watch(Outcome),
    /// Saves the moment, and a scenario that continues from it and expects a team to score.
    Save {
        /// The team.
        team: Team,
        /// The least percentage of repetitions in which it scores.
        percent: f64,
    },
}

/// The outcome of a repetition.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// This team scores first.
    ScoresFirst(Team),
    /// No team scores.
    NobodyScores,
}

impl Outcome {
    /// All outcomes.
    pub const ALL: [Outcome; 3] =
        [Outcome::ScoresFirst(Team::Blue), Outcome::ScoresFirst(Team::Pink), Outcome::NobodyScores];

    /// Returns the outcome in words.
    pub fn words(self) -> &'static str {
        match self {
            Outcome::ScoresFirst(Team::Blue) => "blue scores first",
            Outcome::ScoresFirst(Team::Pink) => "pink scores first",
            Outcome::NobodyScores => "nobody scores",
        }
    }

    /// Returns whether a repetition has this outcome.
    pub fn is_of(self, branch: &Continuation) -> bool {
        match self {
            Outcome::ScoresFirst(team) => branch.first_goal.is_some_and(|(scorer, _)| scorer == team),
            Outcome::NobodyScores => branch.first_goal.is_none(),
        }
    }
}

/// The settings and results of repetitions.
#[derive(Resource)]
pub struct ManyTimes {
    /// The number of repetitions.
    pub times: usize,
    /// The duration of a repetition, s.
    pub for_s: f64,
    /// The last run, which may be in progress.
    pub run: Option<Run>,
    /// The folder for saved tests.
    pub folder: PathBuf,
    /// The cycle of the moment from which to start as soon as it is rebuilt.
    awaited: Option<u64>,
}

impl Default for ManyTimes {
    fn default() -> Self {
        Self { times: 200, for_s: 30.0, run: None, folder: PathBuf::new(), awaited: None }
    }
}

/// Repetitions of a moment.
pub struct Run {
    /// The cycle that had just ended.
    pub cycle: u64,
    /// The outcomes so far.
    pub rows: Vec<Continuation>,
    /// The number of repetitions.
    pub times: usize,
    /// The duration of a repetition, s.
    pub for_s: f64,
    /// Whether it is in progress.
    pub is_running: bool,
    moment: Moment,
    /// The name of the match, and the duration of its cycle, s.
    of: (String, f64),
    /// The interventions that were pending.
    asked: Vec<Intervention>,
    /// The match of the moment.
    keyframes: Keyframes,
    stop: Arc<AtomicBool>,
    said: Mutex<Receiver<Said>>,
}

/// A message of the threads.
enum Said {
    /// A repetition has ended.
    Played(Continuation),
    /// All have ended, or an error.
    Over(Result<(), String>),
}

impl Drop for Run {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl Run {
    fn begin(simulator: Simulator, whole: Whole, times: usize, for_s: f64) -> std::io::Result<Run> {
        let Whole { cycle, moment, of, asked, keyframes } = whole;
        let (sender, said) = mpsc::channel();
        let stop = Arc::new(AtomicBool::new(false));
        let cores = thread::available_parallelism().map_or(1, usize::from);
        // One core is left for the window.
        let threads = cores.saturating_sub(1).max(1);
        let branches = Continuations { times, for_s, first_seed: saved_test::FIRST_SEED, threads };
        let (of_thread, stopped) = (moment.clone(), stop.clone());
        thread::Builder::new().name("many times".to_owned()).spawn(move || {
            let played = |branch| drop(sender.send(Said::Played(branch)));
            let result = whatif::play_branches(&of_thread, &branches, simulator.0, &stopped, played);
            let _nobody_listens = sender.send(Said::Over(result.map_err(|error| error.to_string())));
        })?;
        let said = Mutex::new(said);
        Ok(Run { cycle, rows: Vec::new(), times, for_s, is_running: true, moment, of, asked, keyframes, stop, said })
    }

    /// Whether an intervention was added at this moment since the run.
    fn is_changed_since(&self, clock: &CycleClock, interventions: &Interventions, keyframes: &Keyframes) -> bool {
        clock.cycle == self.cycle && keyframes.is_same(&self.keyframes) && interventions.queue != self.asked
    }
}

/// A rebuilt moment.
struct Whole {
    cycle: u64,
    moment: Moment,
    of: (String, f64),
    asked: Vec<Intervention>,
    keyframes: Keyframes,
}

fn apply(world: &mut World) {
    let commands: Vec<ManyTimesCommand> = world.resource_mut::<Messages<ManyTimesCommand>>().drain().collect();
    for command in commands {
        let result = match command {
            ManyTimesCommand::Begin => {
                // The match is paused, so that the moment does not pass.
                world.resource_mut::<Playback>().paused = true;
                world.resource_mut::<ManyTimes>().awaited = Some(world.resource::<CycleClock>().cycle);
                Ok(())
            }
            ManyTimesCommand::Stop => {
                if let Some(run) = &world.resource::<ManyTimes>().run {
                    run.stop.store(true, Ordering::Relaxed);
                }
                Ok(())
            }
            ManyTimesCommand::Watch(outcome) => watch(world, outcome),
            ManyTimesCommand::Save { team, percent } => save_as_test(world, team, percent),
        };
        if let Err(message) = result {
            world.resource_mut::<Notice>().tell(message);
        }
    }
}

/// Starts as soon as the moment is rebuilt.
fn begin_when_known(world: &mut World) {
    let Some(cycle) = world.resource::<ManyTimes>().awaited else { return };
    if world.resource::<CycleClock>().cycle != cycle {
        world.resource_mut::<ManyTimes>().awaited = None;
        return;
    }
    let whole = match shown_moment(world, cycle) {
        Ok(Some(whole)) => Ok(whole),
        Ok(None) => return,
        Err(message) => Err(message),
    };
    let (times, for_s) = (world.resource::<ManyTimes>().times, world.resource::<ManyTimes>().for_s);
    let simulator = world.get_resource::<Simulator>().copied().ok_or("This program cannot play the match again");
    let run = whole.and_then(|whole| {
        Run::begin(simulator?, whole, times, for_s).map_err(|error| format!("cannot start a thread: {error}"))
    });
    world.resource_mut::<ManyTimes>().awaited = None;
    match run {
        Ok(run) => world.resource_mut::<ManyTimes>().run = Some(run),
        Err(message) => world.resource_mut::<Notice>().tell(message),
    }
}

/// The moment after `cycle`, which is shown; `None` until it is rebuilt.
fn shown_moment(world: &mut World, cycle: u64) -> Result<Option<Whole>, String> {
    let keyframes = world.resource::<Keyframes>().clone();
    let scenario = world.resource::<Scenario>();
    let of = (scenario.name.clone(), scenario.cycle_s);
    if let Some(fault) = keyframes.fault() {
        return Err(format!("It cannot be played on: {fault}"));
    }
    if !world.resource::<Timeline>().is_past() {
        if world.resource::<Game>().state == GameState::Finished {
            return Err("The match is over at this moment".to_owned());
        }
        let asked = world.resource::<Interventions>().queue.clone();
        let moment = Moment::of(world).map_err(|error| error.to_string())?;
        return Ok(Some(Whole { cycle, moment, of, asked, keyframes }));
    }
    let rebuilt = world.resource::<Rebuilt>();
    match rebuilt.moment(cycle, &keyframes) {
        Some(moment) if moment.is_same => {
            Ok(Some(Whole { cycle, moment: moment.moment.clone(), of, asked: Vec::new(), keyframes }))
        }
        Some(_) => Err("The replayed match differs here, so it cannot be played on from this moment".to_owned()),
        None => rebuilt.why_not(world.resource::<CycleClock>(), &keyframes).map_or(Ok(None), Err),
    }
}

fn listen(mut many: ResMut<ManyTimes>, mut notice: ResMut<Notice>) {
    let Some(run) = &many.run else { return };
    let said: Vec<Said> = run.said.lock().unwrap_or_else(PoisonError::into_inner).try_iter().collect();
    if said.is_empty() {
        return;
    }
    let Some(run) = &mut many.run else { return };
    for said in said {
        match said {
            Said::Played(branch) => run.rows.push(branch),
            Said::Over(result) => {
                run.is_running = false;
                if let Err(message) = result {
                    notice.tell(message);
                }
            }
        }
    }
}

fn watch(world: &mut World, outcome: Outcome) -> Result<(), String> {
    let Some(run) = &world.resource::<ManyTimes>().run else { return Ok(()) };
    if !run.keyframes.is_same(world.resource::<Keyframes>()) {
        return Err("That moment belongs to another branch: show that branch first, on the timeline".to_owned());
    }
    let row = run.rows.iter().find(|row| outcome.is_of(row)).ok_or("No repetition has this outcome")?;
    let moment = Box::new(run.moment.clone());
    let outcome = outcome.words();
    let (cycle, seed) = (run.cycle, row.seed);
    world.write_message(BranchCommand::PlayOn { moment, cycle, seed, outcome });
    show_pitch(world);
    Ok(())
}

/// Shows the whole pitch if the camera looks at a place from nearby: play leaves it.
fn show_pitch(world: &mut World) {
    let mut cameras = world.query::<&ViewerCamera>();
    let pitch = world.get_resource::<Pitch>();
    let is_close = |camera: &ViewerCamera| {
        camera.mode == CameraMode::Orbit && pitch.is_some_and(|pitch| camera.wanted.is_close_up(pitch))
    };
    if cameras.iter(world).any(is_close) {
        world.write_message(ViewPreset::Broadcast);
    }
}

fn save_as_test(world: &mut World, team: Team, percent: f64) -> Result<(), String> {
    let many = world.resource::<ManyTimes>();
    let Some(run) = &many.run else { return Ok(()) };
    let path = saved_test::save(&many.folder, team, percent, run)
        .map_err(|message| format!("The test was not saved: {message}"))?;
    let path = path.display();
    world
        .resource_mut::<Notice>()
        .tell(format!("Saved as {path}, with its moment beside it: naoisis check --play {path}"));
    Ok(())
}

#[cfg(test)]
mod tests;

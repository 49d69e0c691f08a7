//! This moment, many times: played on in the background with other chance, for what comes of it and how often.
//!
//! One moment at a time is played on, on all cores but one. Where the ball ends is drawn on the pitch while the panel is open; any
//! one of the times can be watched, as a [branch](super::branches), and the moment can be saved as a test.

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
use super::display_settings::DisplaySettings;
use super::keyframes::{Keyframes, Simulator};
use super::layout::LayoutSystems;
use super::overlays::OverlaySystems;
use super::rebuild::{RebuildSystems, Rebuilt};
use super::shared::{Notice, Playback};
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Intervention, Interventions};
use naoisis_core::team::Team;
use naoisis_record::whatif::{self, Continuation, Continuations, Moment};
use naoisis_sim::scenario::Scenario;

/// Plays moments on, and shows what comes of them.
pub struct ManyTimesPlugin;

impl Plugin for ManyTimesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ManyTimes>()
            .add_message::<ManyTimesCommand>()
            .add_systems(Update, (obey, begin_when_known, listen).chain().after(RebuildSystems))
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

/// What is wanted of the moment.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum ManyTimesCommand {
    /// To play the moment that is shown on.
    Begin,
    /// To play it on no further: those under way are finished.
    Stop,
    /// To watch the first of the times that came out like this.
    Watch(Outcome),
    /// To save the moment, and beside it a scenario that goes on from it and expects a team to score.
    Save {
        /// The team.
        team: Team,
        /// In at least so many of a hundred times.
        percent: f64,
    },
}

/// What can come of a moment.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// This team scores first.
    ScoresFirst(Team),
    /// Nobody scores.
    NobodyScores,
}

impl Outcome {
    /// All of them.
    pub const ALL: [Outcome; 3] =
        [Outcome::ScoresFirst(Team::Blue), Outcome::ScoresFirst(Team::Pink), Outcome::NobodyScores];

    /// Whether one of the times came out like this.
    pub fn is_of(self, branch: &Continuation) -> bool {
        match self {
            Outcome::ScoresFirst(team) => branch.first_goal.is_some_and(|(scorer, _)| scorer == team),
            Outcome::NobodyScores => branch.first_goal.is_none(),
        }
    }
}

/// How often and for how long a moment is played on, and what came of the last one.
#[derive(Resource)]
pub struct ManyTimes {
    /// How often.
    pub times: usize,
    /// For how long, s.
    pub for_s: f64,
    /// The last one, which may be under way.
    pub run: Option<Run>,
    /// Where tests are saved.
    pub folder: PathBuf,
    /// The cycle of the moment that is to be played on as soon as it is known whole.
    awaited: Option<u64>,
}

impl Default for ManyTimes {
    fn default() -> Self {
        Self { times: 200, for_s: 30.0, run: None, folder: PathBuf::new(), awaited: None }
    }
}

/// A moment that is played on, or was.
pub struct Run {
    /// The cycle that had just ended.
    pub cycle: u64,
    /// What came of it so far.
    pub rows: Vec<Continuation>,
    /// How often it is to be played on.
    pub times: usize,
    /// For how long, s.
    pub for_s: f64,
    /// Whether it is still being played.
    pub is_running: bool,
    moment: Moment,
    /// The name of the match, and the duration of its cycle, s.
    of: (String, f64),
    /// What had been asked for by hand, and had not happened yet.
    asked: Vec<Intervention>,
    /// The match that the moment is of.
    keyframes: Keyframes,
    stop: Arc<AtomicBool>,
    said: Mutex<Receiver<Said>>,
}

/// What the threads say.
enum Said {
    /// One of the times is over.
    Played(Continuation),
    /// All are, or they cannot be, and why.
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
        // One is left for the window.
        let threads = cores.saturating_sub(1).max(1);
        let branches = Continuations { times, for_s, first_seed: saved_test::FIRST_SEED, threads };
        let (of_thread, stopped) = (moment.clone(), stop.clone());
        thread::Builder::new().name("many times".to_owned()).spawn(move || {
            let played = |branch| drop(sender.send(Said::Played(branch)));
            let result = whatif::play_branches(&of_thread, &branches, simulator.0, &stopped, played);
            let _nobody_listens = sender.send(Said::Over(result));
        })?;
        let said = Mutex::new(said);
        Ok(Run { cycle, rows: Vec::new(), times, for_s, is_running: true, moment, of, asked, keyframes, stop, said })
    }

    /// Whether something was done by hand at this very moment since it was played on.
    fn is_changed_since(&self, clock: &CycleClock, interventions: &Interventions, keyframes: &Keyframes) -> bool {
        clock.cycle == self.cycle && keyframes.is_same(&self.keyframes) && interventions.queue != self.asked
    }
}

/// A moment whole.
struct Whole {
    cycle: u64,
    moment: Moment,
    of: (String, f64),
    asked: Vec<Intervention>,
    keyframes: Keyframes,
}

fn obey(world: &mut World) {
    let commands: Vec<ManyTimesCommand> = world.resource_mut::<Messages<ManyTimesCommand>>().drain().collect();
    for command in commands {
        let result = match command {
            ManyTimesCommand::Begin => {
                // The moment that is played on must not go by.
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

/// Begins as soon as the moment is known whole.
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
        Run::begin(simulator?, whole, times, for_s).map_err(|error| format!("no thread for it: {error}"))
    });
    world.resource_mut::<ManyTimes>().awaited = None;
    match run {
        Ok(run) => world.resource_mut::<ManyTimes>().run = Some(run),
        Err(message) => world.resource_mut::<Notice>().tell(message),
    }
}

/// The moment that is shown, after a cycle, as soon as it is known whole.
fn shown_moment(world: &mut World, cycle: u64) -> Result<Option<Whole>, String> {
    let keyframes = world.resource::<Keyframes>().clone();
    let scenario = world.resource::<Scenario>();
    let of = (scenario.name.clone(), scenario.cycle_s);
    if let Some(fault) = keyframes.fault() {
        return Err(format!("It cannot be played on: {fault}"));
    }
    if !world.resource::<Timeline>().is_past() {
        if world.resource::<Game>().state == GameState::Finished {
            return Err("The match is over: nothing comes of this moment any more".to_owned());
        }
        let asked = world.resource::<Interventions>().queue.clone();
        return Ok(Some(Whole { cycle, moment: Moment::of(world)?, of, asked, keyframes }));
    }
    let rebuilt = world.resource::<Rebuilt>();
    match rebuilt.moment(cycle, &keyframes) {
        Some(moment) if moment.is_same => {
            Ok(Some(Whole { cycle, moment: moment.moment.clone(), of, asked: Vec::new(), keyframes }))
        }
        Some(_) => Err("Played again, the match is another one here: it cannot go on from it".to_owned()),
        None => rebuilt.why_not(cycle, &keyframes).map_or(Ok(None), Err),
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
        return Err("That was a moment of another match: show that one first, on the timeline".to_owned());
    }
    let row = run.rows.iter().find(|row| outcome.is_of(row)).ok_or("None of the times came out like this")?;
    let command = BranchCommand::PlayOn { moment: Box::new(run.moment.clone()), cycle: run.cycle, seed: row.seed };
    world.write_message(command);
    Ok(())
}

fn save_as_test(world: &mut World, team: Team, percent: f64) -> Result<(), String> {
    let many = world.resource::<ManyTimes>();
    let Some(run) = &many.run else { return Ok(()) };
    let path = saved_test::save(&many.folder, team, percent, run)
        .map_err(|message| format!("The test is not saved: {message}"))?;
    let path = path.display();
    world
        .resource_mut::<Notice>()
        .tell(format!("Saved as {path}, with its moment beside it: naoisis check --play {path}"));
    Ok(())
}

#[cfg(test)]
mod tests;

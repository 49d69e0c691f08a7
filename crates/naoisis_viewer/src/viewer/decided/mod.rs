//! What decided the match: plays on from every keyframe many times in the background with other random numbers, and
//! finds the intervals in which the chance to score first changed most, with the mistakes and kicks in them.
//!
//! The moments are played from coarse to fine, on all cores but one. Only moments in play count.

use bevy::prelude::*;
use bevy_egui::EguiPrimaryContextPass;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

mod chart;
mod panel;

use super::branches::Branches;
use super::display_settings::DisplaySettings;
use super::keyframes::{INTERVAL_S, Keyframes, Simulator};
use super::layout::LayoutSystems;
use super::rebuild::{RebuildProgress, RebuildSystems, Rebuilt};
use super::shared::Notice;
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::GameState;
use naoisis_record::record::history::History;
use naoisis_record::record::match_marks::MarkKind;
use naoisis_record::whatif::chances::{self, Chance, Restart, Swing};
use naoisis_record::whatif::{self, Continuations};

/// Finds and shows what decided the match.
pub struct DecidedPlugin;

impl Plugin for DecidedPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Decided>()
            .add_message::<DecidedCommand>()
            .add_systems(Update, (begin_when_opened, apply, go_on, listen).chain().after(RebuildSystems))
            .add_systems(EguiPrimaryContextPass, panel::show.run_if(is_open).in_set(LayoutSystems::Right));
    }
}

fn is_open(display: Res<DisplaySettings>) -> bool {
    display.decided
}

/// Commands about the search.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum DecidedCommand {
    /// Begins, or continues after a stop.
    Begin,
    /// Plays every moment as many times again, for more precise chances.
    Again,
    /// Stops: repetitions in progress are finished.
    Stop,
}

/// The settings and results of the search.
#[derive(Resource)]
pub struct Decided {
    /// The number of repetitions of each moment.
    pub times: usize,
    /// The duration of a repetition, s.
    pub for_s: f64,
    /// The results of the match that is shown.
    shown: Results,
    /// The results of other branches and of the match before.
    others: Vec<Results>,
    thread: Option<Thread>,
}

/// The results of a match.
#[derive(Default)]
struct Results {
    /// The match.
    of: Keyframes,
    /// Whether the search was begun.
    has_begun: bool,
    /// The chances so far, by the cycle of their moment.
    chances: BTreeMap<u64, Chance>,
    /// The largest swings of these chances, the largest first.
    swings: Vec<Swing>,
    /// The duration of the repetitions of the chances, s.
    played_s: f64,
    /// The number of repetitions that each moment shall have; `None` while nothing is wanted.
    wanted: Option<usize>,
}

impl Results {
    /// The part before a cycle, as results of another match that is the same until then.
    fn until(&self, cycle: u64, of: Keyframes) -> Results {
        let chances: BTreeMap<u64, Chance> = self.chances.range(..cycle).map(|(at, chance)| (*at, *chance)).collect();
        let until_s = chances.values().next_back().map_or(0.0, |chance| chance.time_s);
        let swings = self.swings.iter().filter(|swing| swing.until_s <= until_s).cloned().collect();
        Results { of, chances, swings, played_s: self.played_s, ..default() }
    }
}

impl Default for Decided {
    fn default() -> Self {
        Self { times: 24, for_s: 20.0, shown: Results::default(), others: Vec::new(), thread: None }
    }
}

/// The number of moments that have been played, and of all.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Progress {
    /// Moments with all their repetitions.
    pub played: usize,
    /// Moments with some of their repetitions.
    pub begun: usize,
    /// All moments, including those that are expected.
    pub all: usize,
}

impl Progress {
    /// Returns the progress in words. While nothing more is played, they say that it was stopped.
    fn words(&self, is_played_on: bool) -> String {
        let Progress { played, begun, all } = *self;
        let stopped = if !is_played_on && played < all && played + begun > 0 { "Stopped: " } else { "" };
        let begun = if begun > 0 { format!(", {begun} begun") } else { String::new() };
        format!("{stopped}{played} of {all} moments{begun}")
    }
}

impl Decided {
    /// Returns the largest swings so far, the largest first.
    pub fn swings(&self) -> &[Swing] {
        &self.shown.swings
    }

    /// Returns the chances so far, by the cycle of their moment.
    pub fn chances(&self) -> impl Iterator<Item = (u64, &Chance)> {
        self.shown.chances.iter().map(|(cycle, chance)| (*cycle, chance)).filter(|(_, chance)| chance.times > 0)
    }

    /// Returns whether moments are being played.
    pub fn is_running(&self) -> bool {
        self.thread.is_some()
    }

    /// Returns the progress, in a match in which `awaited` further keyframes are expected.
    pub fn progress(&self, awaited: usize) -> Progress {
        let times = self.shown.wanted.unwrap_or(self.times).max(1);
        let chances = || self.shown.chances.values();
        let played = chances().filter(|chance| chance.times >= times).count();
        let begun = chances().filter(|chance| (1..times).contains(&chance.times)).count();
        Progress { played, begun, all: self.shown.of.cycles(is_in_play).len().max(played + begun) + awaited }
    }

    /// Keeps the results of the match that was shown as long as it can be shown again, and takes those of another one if
    /// there are any. Those of a branch begin with the results of its parent until the cycle at which it starts.
    fn change_match(&mut self, keyframes: &Keyframes, parent: Option<(&Keyframes, u64)>) {
        self.thread = None;
        self.others.push(core::mem::take(&mut self.shown));
        self.others.retain(|results| results.of.is_shared() && !results.chances.is_empty());
        let index_of = |others: &[Results], of: &Keyframes| others.iter().position(|results| results.of.is_same(of));
        self.shown = if let Some(index) = index_of(&self.others, keyframes) {
            self.others.swap_remove(index)
        } else {
            let of_parent = parent.and_then(|(of, cycle)| Some((index_of(&self.others, of)?, cycle)));
            match of_parent {
                Some((index, cycle)) => self.others[index].until(cycle, keyframes.clone()),
                None => Results { of: keyframes.clone(), ..default() },
            }
        };
    }
}

/// Whether chances of a moment are of interest: in a break, nothing can happen.
fn is_in_play(moment: &whatif::Moment) -> bool {
    moment.state == GameState::Playing
}

/// The thread that plays.
struct Thread {
    stop: Arc<AtomicBool>,
    said: Mutex<Receiver<Said>>,
}

impl Drop for Thread {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// A message of the thread.
enum Said {
    /// A repetition has ended: the chance at the moment after this cycle.
    Played(u64, Chance),
    /// All have ended, or an error.
    Over(Result<(), String>),
}

/// The work of the thread.
struct Work {
    simulator: Simulator,
    keyframes: Keyframes,
    /// The chances so far, by the cycle of their moment.
    chances: BTreeMap<u64, Chance>,
    wanted: usize,
    for_s: f64,
}

impl Thread {
    fn begin(work: Work) -> std::io::Result<Thread> {
        let (sender, said) = mpsc::channel();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = stop.clone();
        thread::Builder::new().name("what decided it".to_owned()).spawn(move || {
            let result = work.play(&stopped, &sender);
            let _nobody_listens = sender.send(Said::Over(result));
        })?;
        Ok(Thread { stop, said: Mutex::new(said) })
    }
}

impl Work {
    /// Plays all moments that there are now.
    fn play(mut self, stop: &AtomicBool, sender: &Sender<Said>) -> Result<(), String> {
        // One core is left for the window.
        let threads = thread::available_parallelism().map_or(1, usize::from).saturating_sub(1).max(1);
        while let Some(cycle) = next_moment(&self.keyframes.cycles(is_in_play), &self.chances, self.wanted) {
            // A keyframe may have been dropped since.
            let kept = self.keyframes.before(cycle).filter(|(kept, _)| *kept == cycle);
            let Some((_, moment)) = kept.filter(|_| !stop.load(Ordering::Relaxed)) else { break };
            let chance = self.chances.entry(cycle).or_insert(Chance::of(&moment));
            let (times, first_seed) = (self.wanted - chance.times, 1 + chance.times as u64);
            let branches = Continuations { times, for_s: self.for_s, first_seed, threads };
            let played = |branch| {
                chance.note(&branch);
                let _nobody_listens = sender.send(Said::Played(cycle, *chance));
            };
            whatif::play_branches(&moment, &branches, self.simulator.0, stop, played)
                .map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

/// The next moment to play, from coarse to fine: of those with too few repetitions, the one furthest from all others.
/// `cycles` are those of all moments, in order.
fn next_moment(cycles: &[u64], chances: &BTreeMap<u64, Chance>, wanted: usize) -> Option<u64> {
    let is_played = |cycle: &u64| chances.get(cycle).is_some_and(|chance| chance.times >= wanted);
    let distance = |cycle: u64| {
        let played = cycles.iter().filter(|other| is_played(other));
        played.map(|other| other.abs_diff(cycle)).min().unwrap_or(u64::MAX)
    };
    let left = cycles.iter().copied().filter(|cycle| !is_played(cycle));
    left.max_by_key(|cycle| (distance(*cycle), core::cmp::Reverse(*cycle)))
}

/// Begins when the panel is opened for the first time in a match.
fn begin_when_opened(
    display: Res<DisplaySettings>,
    (keyframes, branches): (Res<Keyframes>, Res<Branches>),
    mut decided: ResMut<Decided>,
    mut was_open: Local<bool>,
    mut commands: MessageWriter<DecidedCommand>,
) {
    if !decided.shown.of.is_same(&keyframes) {
        decided.change_match(&keyframes, branches.parent(&keyframes));
    }
    if display.decided && !*was_open && !decided.shown.has_begun {
        commands.write(DecidedCommand::Begin);
    }
    *was_open = display.decided;
}

fn apply(
    mut commands: MessageReader<DecidedCommand>,
    keyframes: Res<Keyframes>,
    rebuilt: Res<Rebuilt>,
    simulator: Option<Res<Simulator>>,
    mut decided: ResMut<Decided>,
    mut notice: ResMut<Notice>,
) {
    for command in commands.read() {
        if *command == DecidedCommand::Stop {
            (decided.shown.wanted, decided.thread) = (None, None);
            continue;
        }
        if let Some(reason) = refusal(&keyframes, &rebuilt, simulator.is_some()) {
            notice.tell(format!("It cannot be found what decided this match: {reason}"));
            continue;
        }
        if decided.shown.played_s != decided.for_s {
            // Chances within another duration are not comparable.
            decided.thread = None;
            decided.shown = Results { of: keyframes.clone(), played_s: decided.for_s, ..default() };
        }
        decided.shown.has_begun = true;
        let most = decided.shown.chances.values().map(|chance| chance.times).max().unwrap_or_default();
        let again = if *command == DecidedCommand::Again { most } else { 0 };
        decided.shown.wanted = Some(again + decided.times);
    }
}

/// Why the match cannot be played on from its keyframes, if so.
fn refusal(keyframes: &Keyframes, rebuilt: &Rebuilt, can_play: bool) -> Option<String> {
    if !can_play {
        return Some("this program cannot replay it".to_owned());
    }
    let failed = match &rebuilt.progress {
        RebuildProgress::Failed(message) => Some(message.clone()),
        _ => None,
    };
    keyframes.fault().or(failed)
}

/// Starts the thread while there are moments to play.
fn go_on(
    keyframes: Res<Keyframes>,
    simulator: Option<Res<Simulator>>,
    mut decided: ResMut<Decided>,
    mut notice: ResMut<Notice>,
) {
    let (Some(wanted), Some(simulator)) = (decided.shown.wanted, simulator) else { return };
    if decided.is_running() || next_moment(&keyframes.cycles(is_in_play), &decided.shown.chances, wanted).is_none() {
        return;
    }
    let (keyframes, chances) = (keyframes.clone(), decided.shown.chances.clone());
    let work = Work { simulator: *simulator, keyframes, chances, wanted, for_s: decided.shown.played_s };
    match Thread::begin(work) {
        Ok(thread) => decided.thread = Some(thread),
        Err(error) => {
            decided.shown.wanted = None;
            notice.tell(format!("cannot start a thread: {error}"));
        }
    }
}

fn listen(
    history: Res<History>,
    keyframes: Res<Keyframes>,
    clock: Res<CycleClock>,
    mut decided: ResMut<Decided>,
    mut notice: ResMut<Notice>,
) {
    let Some(thread) = &decided.thread else { return };
    let said: Vec<Said> = thread.said.lock().unwrap_or_else(PoisonError::into_inner).try_iter().collect();
    if said.is_empty() {
        return;
    }
    for said in said {
        match said {
            Said::Played(cycle, chance) => drop(decided.shown.chances.insert(cycle, chance)),
            Said::Over(result) => {
                decided.thread = None;
                if let Err(message) = result {
                    decided.shown.wanted = None;
                    notice.tell(message);
                }
            }
        }
    }
    // A moment under way would have a swing of few repetitions.
    let played = &decided.shown.chances;
    let least = played.values().map(|chance| chance.times).max().unwrap_or_default().min(decided.times);
    let chances: Vec<Chance> = played.values().filter(|chance| chance.times >= least).copied().collect();
    decided.shown.swings = chances::swings(&chances, &restarts(&history, &keyframes, clock.period_s));
}

/// The goals and breaks of the match, in their order.
fn restarts(history: &History, keyframes: &Keyframes, period_s: f64) -> Vec<Restart> {
    let time_s = |cycle: u64| cycle as f64 * period_s;
    let of_mark = history.marks().iter().filter_map(|mark| match mark.kind {
        MarkKind::Goal => Some(Restart { time_s: time_s(mark.cycle), goal: mark.team }),
        MarkKind::Whistle => Some(Restart { time_s: time_s(mark.cycle), goal: None }),
        _ => None,
    });
    let breaks = keyframes.cycles(|moment| !is_in_play(moment));
    let of_breaks = breaks.into_iter().map(|cycle| Restart { time_s: time_s(cycle), goal: None });
    let mut restarts: Vec<Restart> = of_mark.chain(of_breaks).collect();
    // The goal itself is before the break that follows it.
    restarts
        .sort_by(|one, other| one.time_s.total_cmp(&other.time_s).then(one.goal.is_none().cmp(&other.goal.is_none())));
    restarts
}

/// The number of keyframes that are still expected of a trace that is being replayed.
pub fn awaited(timeline: &Timeline, rebuilt: &Rebuilt, history: &History, period_s: f64) -> usize {
    let (true, RebuildProgress::Until(until)) = (timeline.is_replay(), &rebuilt.progress) else { return 0 };
    let left = history.last_cycle().unwrap_or_default().saturating_sub(*until);
    (left as f64 * period_s / INTERVAL_S) as usize
}

#[cfg(test)]
mod tests;

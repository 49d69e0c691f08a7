//! Branches of a match: any moment can be played on as a match of its own, and the original match stays.
//!
//! The branches of a match are a tree. One of them is shown and played. The others are stored as they were left, and
//! each can be shown again.

use bevy::prelude::*;

use super::keyframes::Keyframes;
use super::rebuild::{RebuildSystems, Rebuilt};
use super::shared::{DisplayFraction, Notice, Playback};
use super::theme::minutes;
use super::timeline::{self, BranchData, Timeline};
use naoisis_core::cycle::CycleClock;
use naoisis_record::record::history::History;
use naoisis_record::whatif::Moment;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::interface::gather::CurrentRecord;
use naoisis_sim::simulation::SnapshotError;

/// The name of the root branch.
const FIRST: &str = "The match as it was";

/// Keeps the [`Branches`].
pub struct BranchesPlugin;

impl Plugin for BranchesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Branches>()
            .add_message::<BranchCommand>()
            .add_systems(Update, (forget, apply, fork_when_known).chain().after(RebuildSystems));
    }
}

/// Commands about the branches of the match.
#[derive(Message, Clone, PartialEq, Debug)]
pub enum BranchCommand {
    /// Plays on from the moment that is shown, as a new branch.
    PlayFromHere,
    /// Plays on from a moment of the shown branch with the random numbers of a seed, as a new branch.
    PlayOn {
        /// The moment.
        moment: Box<Moment>,
        /// The cycle that has just ended.
        cycle: u64,
        /// The seed of the random numbers.
        seed: u64,
        /// What is known to happen in it, for its name.
        outcome: &'static str,
    },
    /// Shows the branch with this index in [`Branches`].
    Show(usize),
}

/// The branches of the match, and the one that is shown.
#[derive(Resource, Debug, Default)]
pub struct Branches {
    list: Vec<Branch>,
    shown: usize,
    /// The cycle of the moment from which to play on as soon as it is rebuilt, and whether the match was paused there.
    awaited: Option<(u64, bool)>,
}

/// A branch of the match.
#[derive(Debug)]
pub struct Branch {
    /// The parent branch, and the cycle after which this one differs from it; `None` for the root.
    pub from: Option<(usize, u64)>,
    /// The name in the window.
    pub name: String,
    /// The last cycle that was played when the branch was stored.
    pub last_cycle: u64,
    /// Identifies the match.
    keyframes: Keyframes,
    /// The stored match; `None` for the branch that is shown.
    aside: Option<Aside>,
}

/// A stored match.
#[derive(Debug)]
struct Aside {
    data: BranchData,
    place: Place,
}

impl Branches {
    /// Returns all branches; the first is the root.
    pub fn list(&self) -> &[Branch] {
        &self.list
    }

    /// Returns the index of the branch that is shown.
    pub fn shown(&self) -> usize {
        self.shown
    }

    /// Returns whether the match with these keyframes is a branch other than the root.
    pub fn is_fork(&self, keyframes: &Keyframes) -> bool {
        self.list.iter().any(|branch| branch.from.is_some() && branch.keyframes.is_same(keyframes))
    }

    /// Returns the keyframes of the branch from which the one with these keyframes starts, and the cycle after which both
    /// differ; `None` for the root.
    pub fn parent(&self, keyframes: &Keyframes) -> Option<(&Keyframes, u64)> {
        let (from, cycle) = self.list.iter().find(|branch| branch.keyframes.is_same(keyframes))?.from?;
        Some((&self.list.get(from)?.keyframes, cycle))
    }

    /// Returns the record of a cycle of a stored branch, if it has this cycle.
    pub fn record(&mut self, index: usize, cycle: u64) -> Option<CycleRecord> {
        let aside = self.list.get_mut(index)?.aside.as_mut()?;
        aside.data.history.record(cycle).ok().flatten()
    }

    /// Returns the last cycle that two branches have in common.
    pub fn common(&self, one: usize, other: usize) -> u64 {
        // The branches from this one up to the root, each with the last cycle that it contributes to this branch.
        let way = |index: usize| {
            let mut way = vec![(index, u64::MAX)];
            while let Some((from, cycle)) = way.last().and_then(|(index, _)| self.list.get(*index)?.from) {
                let until = way.last().map_or(cycle, |(_, until)| cycle.min(*until));
                way.push((from, until));
            }
            way
        };
        let (one, other) = (way(one), way(other));
        let shared = one.iter().flat_map(|(index, until)| {
            other.iter().filter(move |(with, _)| with == index).map(move |(_, until_too)| *until.min(until_too))
        });
        shared.max().unwrap_or_default()
    }
}

/// Starts new branches for a new match.
fn forget(keyframes: Res<Keyframes>, mut branches: ResMut<Branches>) {
    let is_known = branches.list.get(branches.shown).is_some_and(|branch| branch.keyframes.is_same(&keyframes));
    if !is_known {
        let first =
            Branch { from: None, name: FIRST.to_owned(), last_cycle: 0, keyframes: keyframes.clone(), aside: None };
        *branches = Branches { list: vec![first], ..default() };
    }
}

fn apply(world: &mut World) {
    let commands: Vec<BranchCommand> = world.resource_mut::<Messages<BranchCommand>>().drain().collect();
    for command in commands {
        let result = match command {
            BranchCommand::PlayFromHere => play_from_here(world),
            BranchCommand::PlayOn { moment, cycle, seed, outcome } => {
                fork(world, (cycle, moment.time_s), outcome, false, |world| moment.restore(world, seed))
            }
            BranchCommand::Show(index) => show(world, index),
        };
        if let Err(message) = result {
            world.resource_mut::<Notice>().tell(message);
        }
    }
}

fn play_from_here(world: &mut World) -> Result<(), String> {
    if !world.resource::<Timeline>().is_past() {
        return Err("This is the present, which continues anyway: go to a moment of the past first".to_owned());
    }
    let cycle = world.resource::<CycleClock>().cycle;
    // The match is paused, so that the moment does not pass while it is being rebuilt.
    let stood = core::mem::replace(&mut world.resource_mut::<Playback>().paused, true);
    let mut branches = world.resource_mut::<Branches>();
    // If this is asked for a second time, the match was paused by the first request: the state before that one counts.
    let stood = branches.awaited.filter(|(other, _)| *other == cycle).map_or(stood, |(_, before)| before);
    branches.awaited = Some((cycle, stood));
    if world.resource::<Rebuilt>().moment(cycle, world.resource::<Keyframes>()).is_none() {
        world.resource_mut::<Notice>().tell("Rebuilding this moment…");
    }
    Ok(())
}

/// Plays on from the moment that was asked for, as soon as it is rebuilt.
fn fork_when_known(world: &mut World) {
    let Some((cycle, stood)) = world.resource::<Branches>().awaited else { return };
    if world.resource::<CycleClock>().cycle != cycle || !world.resource::<Timeline>().is_past() {
        world.resource_mut::<Branches>().awaited = None;
        return;
    }
    let rebuilt = world.resource::<Rebuilt>();
    let moment = rebuilt.moment(cycle, world.resource::<Keyframes>());
    let why_not = rebuilt.why_not(world.resource::<CycleClock>(), world.resource::<Keyframes>());
    let result = match (moment.map(|moment| (moment.is_same, moment.moment.clone())), why_not) {
        (Some((true, moment)), _) => fork(world, (cycle, moment.time_s), "", stood, |world| moment.put_back(world)),
        (Some((false, _)), _) => {
            Err("The replayed match differs here, so it cannot be played on from this moment".to_owned())
        }
        (None, Some(why)) => Err(why),
        (None, None) => return,
    };
    world.resource_mut::<Branches>().awaited = None;
    let text = match result {
        Ok(()) if stood => "New branch from here, paused as before; Space: continue".to_owned(),
        Ok(()) => "New branch from here; the original match stays on the timeline".to_owned(),
        Err(message) => message,
    };
    world.resource_mut::<Notice>().tell(text);
}

/// Starts a branch from the end of a cycle, at a time in s, of the branch that is shown, paused or running; `restore` puts
/// the match into the world. Its name has the time and the `outcome`, if that is known.
fn fork(
    world: &mut World,
    (cycle, time_s): (u64, f64),
    outcome: &str,
    stands: bool,
    restore: impl FnOnce(&mut World) -> Result<(), SnapshotError>,
) -> Result<(), String> {
    let shown = world.resource::<Branches>().shown;
    leave(world)?;
    let until = match &world.resource::<Branches>().list[shown].aside {
        Some(aside) => aside.data.until(cycle, time_s).map_err(|error| error.to_string()),
        None => return Ok(()),
    };
    let restored = |data| restore(world).map(|()| data).map_err(|error| error.to_string());
    let result = until.and_then(restored);
    let data = match result {
        Ok(data) => data,
        Err(message) => {
            bring_back(world, shown)?;
            return Err(message);
        }
    };
    let keyframes = data.keyframes.clone();
    // The random numbers may differ from here on.
    keyframes.note_change();
    data.put(world);
    take_record(world);
    let mut branches = world.resource_mut::<Branches>();
    let number = branches.list.len();
    let outcome = if outcome.is_empty() { String::new() } else { format!(", {outcome}") };
    let name = format!("{number}: from {}{outcome}", minutes(time_s as f32));
    branches.list.push(Branch { from: Some((shown, cycle)), name, last_cycle: cycle, keyframes, aside: None });
    branches.shown = branches.list.len() - 1;
    let mut playback = world.resource_mut::<Playback>();
    (playback.paused, playback.failed, playback.problem) = (stands, false, None);
    *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
    Ok(())
}

/// Shows another branch, as it was left.
fn show(world: &mut World, index: usize) -> Result<(), String> {
    let branches = world.resource::<Branches>();
    if index == branches.shown || index >= branches.list.len() {
        return Ok(());
    }
    leave(world)?;
    bring_back(world, index)?;
    world.resource_mut::<Branches>().shown = index;
    Ok(())
}

/// Stores the branch that is shown.
fn leave(world: &mut World) -> Result<(), String> {
    let place = Place::of(world)?;
    put_aside(world, place);
    Ok(())
}

/// Where a branch was left: the end of the match, from which it continues, none for a trace; and the moment that was
/// shown, if it was in the past.
#[derive(Debug)]
pub(super) struct Place {
    present: Option<Moment>,
    cursor: Option<f64>,
}

impl Place {
    /// The place of the branch that is shown. The window then shows its present.
    pub fn of(world: &mut World) -> Result<Place, String> {
        let cursor = world.resource::<Timeline>().cursor();
        if world.resource::<Timeline>().is_replay() {
            return Ok(Place { present: None, cursor });
        }
        timeline::return_to_present(world);
        let present = Some(Moment::of(world).map_err(|error| error.to_string())?);
        Ok(Place { present, cursor })
    }

    /// The present of the match as the bytes of a saved match; none for a trace.
    pub fn present_bytes(&self) -> &[u8] {
        self.present.as_ref().map_or(&[], Moment::bytes)
    }

    /// Shows the moment again that was shown.
    pub fn show(&self, world: &mut World) {
        if let Some(cursor) = self.cursor {
            timeline::go_to(world, cursor);
        }
    }
}

/// Stores the branch that is shown, as it was left.
pub(super) fn put_aside(world: &mut World, place: Place) {
    let last_cycle = world.resource::<History>().last_cycle().unwrap_or_default();
    let data = BranchData::take(world);
    let mut branches = world.resource_mut::<Branches>();
    let shown = branches.shown;
    let branch = &mut branches.list[shown];
    branch.last_cycle = last_cycle;
    branch.aside = Some(Aside { data, place });
}

/// Makes the record of the cycle that is shown the current one. Until the next cycle, the world has that of another match.
fn take_record(world: &mut World) {
    let cycle = world.resource::<CycleClock>().cycle;
    let record = world.resource_mut::<History>().record(cycle).ok().flatten().filter(|record| record.cycle == cycle);
    if let (Some(record), Some(mut current)) = (record, world.get_resource_mut::<CurrentRecord>()) {
        current.record = record;
    }
}

/// Puts a stored branch back into the world, paused.
pub(super) fn bring_back(world: &mut World, index: usize) -> Result<(), String> {
    let Some(Aside { data, place }) = world.resource_mut::<Branches>().list[index].aside.take() else {
        return Ok(());
    };
    match &place.present {
        Some(present) => {
            present.put_back(world).map_err(|error| error.to_string())?;
            data.put(world);
            take_record(world);
        }
        None => timeline::show_trace(world, data).map_err(|fault| fault.to_string())?,
    }
    let mut playback = world.resource_mut::<Playback>();
    (playback.paused, playback.failed, playback.problem) = (true, false, None);
    *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
    place.show(world);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_ways_are_one_until_they_part() {
        let branch =
            |from| Branch { from, name: String::new(), last_cycle: 1000, keyframes: Keyframes::default(), aside: None };
        // 1 and 2 start from the root, and 3 from 1.
        let list = vec![branch(None), branch(Some((0, 300))), branch(Some((0, 500))), branch(Some((1, 700)))];
        let branches = Branches { list, ..default() };
        assert_eq!((branches.common(0, 1), branches.common(1, 0)), (300, 300));
        assert_eq!((branches.common(1, 2), branches.common(2, 3)), (300, 300));
        assert_eq!((branches.common(1, 3), branches.common(3, 0)), (700, 300));
        assert_eq!(branches.common(2, 2), u64::MAX);
    }
}

//! Branching time: any moment becomes a match of its own that is played on, and the one that it is from stays.
//!
//! The ways that the match went are a tree. One of them is shown, and played; the others are put aside as they were left, and any of
//! them can be shown again.

use bevy::prelude::*;

use super::keyframes::Keyframes;
use super::rebuild::{RebuildSystems, Rebuilt};
use super::shared::{DisplayFraction, Notice, Playback};
use super::theme::minutes;
use super::timeline::{self, Timeline, Way};
use naoisis_core::cycle::CycleClock;
use naoisis_record::record::history::History;
use naoisis_record::whatif::Moment;
use naoisis_sim::interface::cycle_record::CycleRecord;

/// What the way is called that all others come from.
const FIRST: &str = "The match as it was";

/// Keeps the [`Branches`].
pub struct BranchesPlugin;

impl Plugin for BranchesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Branches>()
            .add_message::<BranchCommand>()
            .add_systems(Update, (forget, obey, fork_when_known).chain().after(RebuildSystems));
    }
}

/// What is wanted of the ways that the match went.
#[derive(Message, Clone, PartialEq, Debug)]
pub enum BranchCommand {
    /// The moment that is shown is played on, as a match of its own.
    PlayFromHere,
    /// A moment of the match that is shown is played on with other chance, that of a seed.
    PlayOn {
        /// The moment.
        moment: Box<Moment>,
        /// The cycle that had just ended.
        cycle: u64,
        /// The seed.
        seed: u64,
    },
    /// This one of the [`Branches`] is shown.
    Show(usize),
}

/// The ways that the match went, and the one that is shown.
#[derive(Resource, Debug, Default)]
pub struct Branches {
    list: Vec<Branch>,
    shown: usize,
    /// The moment that is to be played on as soon as it is known whole, and whether the match stood there.
    awaited: Option<(u64, bool)>,
}

/// One way that the match went.
#[derive(Debug)]
pub struct Branch {
    /// The one that it is from, and the cycle after which it went its own way.
    pub from: Option<(usize, u64)>,
    /// What it is called.
    pub name: String,
    /// The last cycle that was played, when it was put aside.
    pub last_cycle: u64,
    /// What tells it from other matches.
    keyframes: Keyframes,
    /// What it was like when it was put aside; none of the one that is shown.
    aside: Option<Aside>,
}

/// A match that is put aside.
#[derive(Debug)]
struct Aside {
    way: Way,
    /// Where it goes on; nowhere, of a trace.
    present: Option<Moment>,
    /// The moment that was shown, if it was not the present.
    cursor: Option<f64>,
}

impl Branches {
    /// All of them; the first is the one that all others come from.
    pub fn list(&self) -> &[Branch] {
        &self.list
    }

    /// Which of them is shown.
    pub fn shown(&self) -> usize {
        self.shown
    }

    /// Whether a match, by what is kept of it, is one of them that is from another.
    pub fn is_fork(&self, keyframes: &Keyframes) -> bool {
        self.list.iter().any(|branch| branch.from.is_some() && branch.keyframes.is_same(keyframes))
    }

    /// The record of a cycle of one that is put aside, if it went so far.
    pub fn record(&mut self, index: usize, cycle: u64) -> Option<CycleRecord> {
        let aside = self.list.get_mut(index)?.aside.as_mut()?;
        aside.way.history.record(cycle).ok().flatten()
    }

    /// The last cycle that two of them have in common.
    pub fn common(&self, one: usize, other: usize) -> u64 {
        // From each of them to the first one, with the cycle until which it has been that way.
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

/// Another match has other branches, at first one.
fn forget(keyframes: Res<Keyframes>, mut branches: ResMut<Branches>) {
    let is_known = branches.list.get(branches.shown).is_some_and(|branch| branch.keyframes.is_same(&keyframes));
    if !is_known {
        let first =
            Branch { from: None, name: FIRST.to_owned(), last_cycle: 0, keyframes: keyframes.clone(), aside: None };
        *branches = Branches { list: vec![first], ..default() };
    }
}

fn obey(world: &mut World) {
    let commands: Vec<BranchCommand> = world.resource_mut::<Messages<BranchCommand>>().drain().collect();
    for command in commands {
        let result = match command {
            BranchCommand::PlayFromHere => play_from_here(world),
            BranchCommand::PlayOn { moment, cycle, seed } => {
                fork(world, cycle, moment.time_s, false, |world| moment.restore(world, seed))
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
        return Err("This is the present, which goes on anyway: go to a moment of the past first".to_owned());
    }
    let cycle = world.resource::<CycleClock>().cycle;
    // The moment that is played on must not go by while it is worked out.
    let stood = core::mem::replace(&mut world.resource_mut::<Playback>().paused, true);
    let mut branches = world.resource_mut::<Branches>();
    // Who asks twice has stopped it himself.
    let stood = branches.awaited.filter(|(other, _)| *other == cycle).map_or(stood, |(_, before)| before);
    branches.awaited = Some((cycle, stood));
    if world.resource::<Rebuilt>().moment(cycle, world.resource::<Keyframes>()).is_none() {
        world.resource_mut::<Notice>().tell("The match is played again to here…");
    }
    Ok(())
}

/// Plays on from the moment that was wanted, as soon as it is there.
fn fork_when_known(world: &mut World) {
    let Some((cycle, stood)) = world.resource::<Branches>().awaited else { return };
    if world.resource::<CycleClock>().cycle != cycle || !world.resource::<Timeline>().is_past() {
        world.resource_mut::<Branches>().awaited = None;
        return;
    }
    let rebuilt = world.resource::<Rebuilt>();
    let moment = rebuilt.moment(cycle, world.resource::<Keyframes>());
    let why_not = rebuilt.why_not(cycle, world.resource::<Keyframes>());
    let result = match (moment.map(|moment| (moment.is_same, moment.moment.clone())), why_not) {
        (Some((true, moment)), _) => fork(world, cycle, moment.time_s, stood, |world| moment.put_back(world)),
        (Some((false, _)), _) => Err("Played again, the match is another one here: it cannot go on from it".to_owned()),
        (None, Some(why)) => Err(why),
        (None, None) => return,
    };
    world.resource_mut::<Branches>().awaited = None;
    let text = match result {
        Ok(()) if stood => "A match of its own from here: it stands as before, Space lets it go on".to_owned(),
        Ok(()) => "A match of its own goes on from here; the one that it is from stays, on the timeline".to_owned(),
        Err(message) => message,
    };
    world.resource_mut::<Notice>().tell(text);
}

/// Begins a match that goes on from the end of a cycle of the one that is shown, at a time, s, and stands there, or goes on at once;
/// `restore` puts it into the world.
fn fork(
    world: &mut World,
    cycle: u64,
    time_s: f64,
    stands: bool,
    restore: impl FnOnce(&mut World) -> Result<(), String>,
) -> Result<(), String> {
    let shown = world.resource::<Branches>().shown;
    put_aside(world)?;
    let until = match &world.resource::<Branches>().list[shown].aside {
        Some(aside) => aside.way.until(cycle, time_s),
        None => return Ok(()),
    };
    let result = until.and_then(|way| restore(world).map(|()| way));
    let way = match result {
        Ok(way) => way,
        Err(message) => {
            bring_back(world, shown)?;
            return Err(message);
        }
    };
    let keyframes = way.keyframes.clone();
    // Its chance may be another from here on.
    keyframes.note_change();
    way.put(world);
    let mut branches = world.resource_mut::<Branches>();
    let number = branches.list.len();
    let name = format!("{number}: from {}", minutes(time_s as f32));
    branches.list.push(Branch { from: Some((shown, cycle)), name, last_cycle: cycle, keyframes, aside: None });
    branches.shown = branches.list.len() - 1;
    let mut playback = world.resource_mut::<Playback>();
    (playback.paused, playback.failed, playback.problem) = (stands, false, None);
    *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
    Ok(())
}

/// Shows another one, as it was left.
fn show(world: &mut World, index: usize) -> Result<(), String> {
    let branches = world.resource::<Branches>();
    if index == branches.shown || index >= branches.list.len() {
        return Ok(());
    }
    put_aside(world)?;
    bring_back(world, index)?;
    world.resource_mut::<Branches>().shown = index;
    Ok(())
}

/// Puts the one that is shown aside.
fn put_aside(world: &mut World) -> Result<(), String> {
    let cursor = world.resource::<Timeline>().cursor();
    let present = if world.resource::<Timeline>().is_replay() {
        None
    } else {
        timeline::return_to_present(world);
        Some(Moment::of(world)?)
    };
    let last_cycle = world.resource::<History>().last_cycle().unwrap_or_default();
    let way = Way::take(world);
    let mut branches = world.resource_mut::<Branches>();
    let shown = branches.shown;
    let branch = &mut branches.list[shown];
    branch.last_cycle = last_cycle;
    branch.aside = Some(Aside { way, present, cursor });
    Ok(())
}

/// Puts one that is aside back into the world. It stands.
fn bring_back(world: &mut World, index: usize) -> Result<(), String> {
    let Some(Aside { way, present, cursor }) = world.resource_mut::<Branches>().list[index].aside.take() else {
        return Ok(());
    };
    match present {
        Some(present) => {
            present.put_back(world)?;
            way.put(world);
        }
        None => timeline::show_trace(world, way).map_err(|fault| fault.to_string())?,
    }
    let mut playback = world.resource_mut::<Playback>();
    (playback.paused, playback.failed, playback.problem) = (true, false, None);
    *world.resource_mut::<DisplayFraction>() = DisplayFraction(1.0);
    if let Some(cursor) = cursor {
        timeline::go_to(world, cursor);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_ways_are_one_until_they_part() {
        let branch =
            |from| Branch { from, name: String::new(), last_cycle: 1000, keyframes: Keyframes::default(), aside: None };
        // 1 and 2 leave the first one, 3 leaves 1.
        let list = vec![branch(None), branch(Some((0, 300))), branch(Some((0, 500))), branch(Some((1, 700)))];
        let branches = Branches { list, ..default() };
        assert_eq!((branches.common(0, 1), branches.common(1, 0)), (300, 300));
        assert_eq!((branches.common(1, 2), branches.common(2, 3)), (300, 300));
        assert_eq!((branches.common(1, 3), branches.common(3, 0)), (700, 300));
        assert_eq!(branches.common(2, 2), u64::MAX);
    }
}

//! The objects that the selected robot did not recognise, and why.
//!
//! While the panel of a robot is shown, the vision of the match notes them. Other moments are rebuilt: those of the past, and the present if
//! the robot was selected after the match was paused.

use bevy::prelude::*;

use super::display_settings::DisplaySettings;
use super::keyframes::{Keyframes, Simulator};
use super::overlays::OverlaySystems;
use super::rebuild::{OTHER_MATCH, Rebuilt, why_unknown};
use super::shared::{Playback, Selection};
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::robot::Roster;
use naoisis_sensing::sensing::vision::{MissedObject, Percepts, Unrecognised};
use naoisis_sim::scenario::Scenario;

/// Finds the objects that the selected robot did not recognise.
pub struct UnrecognisedPlugin;

impl Plugin for UnrecognisedPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<ShownUnrecognised>()
            .add_systems(First, (forget.run_if(resource_exists_and_changed::<Scenario>), ask_vision).chain())
            .add_systems(PostUpdate, read.before(OverlaySystems));
    }
}

/// The objects that the selected robot did not recognise at the moment that is shown, or why they are not known.
#[derive(Resource, Clone, PartialEq, Debug)]
pub struct ShownUnrecognised(pub Result<Vec<MissedObject>, String>);

impl Default for ShownUnrecognised {
    fn default() -> Self {
        Self(Ok(Vec::new()))
    }
}

fn forget(unrecognised: Option<ResMut<Unrecognised>>) {
    if let Some(mut unrecognised) = unrecognised {
        unrecognised.clear();
    }
}

/// Makes the vision note what robots do not recognise while the panel of a robot is shown.
fn ask_vision(
    display: Res<DisplaySettings>,
    selection: Res<Selection>,
    noted: Option<Res<Unrecognised>>,
    mut commands: Commands,
) {
    match (display.robot && selection.0.is_some(), noted.is_some()) {
        (true, false) => commands.init_resource::<Unrecognised>(),
        (false, true) => commands.remove_resource::<Unrecognised>(),
        _ => {}
    }
}

/// Reads the objects of the moment that is shown: of the present from the vision of the match, otherwise from the rebuilt moment.
fn read(
    (display, selection): (Res<DisplaySettings>, Res<Selection>),
    (timeline, playback, clock): (Res<Timeline>, Res<Playback>, Res<CycleClock>),
    (keyframes, simulator): (Res<Keyframes>, Option<Res<Simulator>>),
    roster: Res<Roster>,
    robots: Query<&Percepts>,
    noted: Option<Res<Unrecognised>>,
    mut rebuilt: ResMut<Rebuilt>,
    mut shown: ResMut<ShownUnrecognised>,
) {
    let selected = selection.0.filter(|_| display.robot);
    let is_past = timeline.is_past();
    let of_present = selected.filter(|_| !is_past).and_then(|id| {
        let percepts = robots.get(roster.get(id)?).ok()?;
        noted.as_ref()?.of(id, percepts)
    });
    let wants_present = selected.is_some() && !is_past && playback.paused && of_present.is_none() && clock.cycle > 0;
    if rebuilt.wants_present != wants_present {
        rebuilt.wants_present = wants_present;
    }
    let Some(id) = selected else { return };
    let found = of_present.ok_or(()).or_else(|()| match rebuilt.moment(clock.cycle, &keyframes) {
        Some(moment) if moment.is_same => {
            moment.unrecognised.get(&id).cloned().ok_or_else(|| "Not known for this cycle.".to_owned())
        }
        Some(_) => Err(OTHER_MATCH.to_owned()),
        None if clock.cycle == 0 => Err("Nothing has been sensed yet.".to_owned()),
        None if !is_past && !playback.paused => Err("Known from the next cycle on.".to_owned()),
        None => Err(why_unknown(&rebuilt, &clock, &keyframes, simulator.is_some())),
    });
    shown.set_if_neq(ShownUnrecognised(found));
}

#[cfg(test)]
mod tests;

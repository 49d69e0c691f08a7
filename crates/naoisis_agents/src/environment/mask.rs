//! The choices of an action that have an effect now.

use bevy::prelude::*;

use super::action::{ActionKind, KICKS, LOOKS, WALKS, available_kick};
use super::action_space::ActionSpace;
use naoisis_core::referee::GameStatus;
use naoisis_core::robot::Roster;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::status::BodyStatus;

/// Returns for each choice of an action, list by list, whether it has an effect for robot `id` now, by what the robot knows of itself: it can walk and
/// kick, and has the kick. The first choice of a list, which does nothing, is always allowed. A continuous action has no choices.
pub(super) fn mask(space: ActionSpace, world: &World, id: RobotId) -> Vec<bool> {
    let robot = world.resource::<Roster>().get(id).and_then(|entity| world.get_entity(entity).ok());
    let body = robot.and_then(|robot| robot.get::<BodyStatus>().copied()).unwrap_or_default();
    let is_penalised = robot.and_then(|robot| robot.get::<GameStatus>()).is_some_and(|status| status.penalised);
    let kicks = robot.and_then(|robot| robot.get::<KickSettings>().copied()).unwrap_or_default();
    let moves = !is_penalised && body.is_free();
    let walks = |count: usize| (0..count).map(move |index| index == 0 || moves);
    let kicks = KICKS.iter().map(|(_, kind)| match kind {
        Some(kind) => moves && kicks.get(available_kick(*kind, &kicks)).is_some(),
        None => true,
    });
    let said = space.names().get(space.kind().len()).map_or(0, Vec::len);
    let said = (0..said).map(|index| index == 0 || !is_penalised);
    match space.kind() {
        ActionKind::Continuous => Vec::new(),
        ActionKind::Discrete => walks(WALKS.len()).chain(kicks.skip(1)).collect(),
        ActionKind::MultiDiscrete => {
            let looks = (0..LOOKS.len()).map(|index| index == 0 || !is_penalised);
            walks(WALKS.len()).chain(looks).chain(kicks).chain(said).collect()
        }
        ActionKind::Velocities => {
            let lists = space.names();
            let speeds = lists.iter().take(3).flat_map(|names| walks(names.len()));
            speeds.chain(kicks).chain(said).collect()
        }
    }
}

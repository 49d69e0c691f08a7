//! That a match is one of those that an environment was made for.

use bevy::prelude::*;

use super::entry::ObservationEntry;
use super::episode::EnvironmentSettings;
use super::observation::entries;
use super::start_error::StartError;
use super::state::state_entries;
use crate::agents::remote_robots;
use naoisis_sensing::sensing::camera::CameraRendering;
use naoisis_sim::scenario::Scenario;

/// The number of bytes of an image of the robots of a match.
pub(super) fn image_bytes(world: &World) -> usize {
    let cameras = world.get_resource::<Scenario>().map(|scenario| scenario.settings.cameras);
    let cameras = cameras.filter(|cameras| !matches!(cameras.render, CameraRendering::Auto | CameraRendering::Off));
    cameras.map_or(0, |cameras| 3 * (cameras.width * cameras.height) as usize)
}

/// Checks that a match has the agents that the environment was made for, and the same observations.
pub(super) fn check_same(
    settings: &EnvironmentSettings,
    world: &World,
    expected: &[ObservationEntry],
    expected_state: &[ObservationEntry],
    expected_bytes: usize,
) -> Result<(), StartError> {
    let remote = remote_robots(world);
    if let Some(id) = settings.control.iter().find(|id| !remote.contains(id)) {
        return Err(StartError::Different(format!(
            "`{id}` is not decided for from outside in it; expected a match in which it is controlled"
        )));
    }
    let found = settings.control.first().map(|id| entries(settings.observed, world, *id)).unwrap_or_default();
    // The ranges of an environment may be wider.
    let fits = |(found, expected): &(&ObservationEntry, &ObservationEntry)| {
        let wide = ObservationEntry { low: expected.low, high: expected.high, ..**found };
        wide == **expected && expected.low <= found.low && found.high <= expected.high
    };
    let mut pairs = found.iter().zip(expected);
    if found.len() != expected.len() || !pairs.clone().all(|pair| fits(&pair)) || state_entries(world) != expected_state
    {
        let of_range = |entry: &ObservationEntry| format!("{} to {}", entry.low, entry.high);
        let different = pairs.find(|pair| !fits(pair));
        let message = match different.filter(|_| found.len() == expected.len()) {
            Some((found, expected)) => {
                format!(
                    "`{found}` is from {}, and `{expected}` from {} in this environment",
                    of_range(found),
                    of_range(expected)
                )
            }
            None => {
                format!("its {} numbers to observe are not the {} of this environment", found.len(), expected.len())
            }
        };
        return Err(StartError::Different(format!("{message}; expected as many robots of the same models")));
    }
    let bytes = image_bytes(world);
    if settings.camera.is_some() && bytes != expected_bytes {
        return Err(StartError::Different(format!("its images have {bytes} bytes; expected {expected_bytes}")));
    }
    Ok(())
}

//! Starts the programs of a match that nobody watches.

use bevy::prelude::*;

use naoisis_agents::agents::{self, AgentSettings, ProgramStartError};
use naoisis_agents::game_controller::{NetworkError, open_network};
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::ScenarioFault;

/// A match cannot be played.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum PlayError {
    /// The scenario cannot be started.
    #[error(transparent)]
    Scenario(#[from] ScenarioFault),
    /// Programs in real time [play](agents::PlayedElsewhere) robots. Such programs join one match.
    #[error("{}: programs in real time play these robots, in one match at a time; expected `naoisis run`", names(.0))]
    RealTime(Vec<RobotId>),
    /// The network of the match cannot be opened.
    #[error("the network of the match: {0}")]
    Network(#[from] NetworkError),
    /// A program cannot be started.
    #[error(transparent)]
    Programs(#[from] ProgramStartError),
    /// Playing was interrupted.
    #[error("interrupted after {played} of {matches} matches")]
    Interrupted {
        /// The number of matches that were played.
        played: usize,
        /// The number of matches that were to be played.
        matches: usize,
    },
}

naoisis_core::debug_as_displayed!(PlayError);

fn names(robots: &[RobotId]) -> String {
    robots.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// Opens the network of the match in `world`, if it has one, and then starts the programs of its robots.
///
/// # Errors
/// [`PlayError::RealTime`], [`PlayError::Network`] or [`PlayError::Programs`].
pub fn begin_programs(world: &mut World) -> Result<(), PlayError> {
    refuse_real_time(world)?;
    if world.contains_resource::<AgentSettings>() {
        open_network(world)?;
        agents::start_programs(world)?;
    }
    Ok(())
}

/// Refuses a match with robots that are [played elsewhere](agents::PlayedElsewhere): such programs live in real time, and join one match.
///
/// # Errors
/// [`PlayError::RealTime`].
pub fn refuse_real_time(world: &World) -> Result<(), PlayError> {
    let robots = agents::robots_played_elsewhere(world);
    if robots.is_empty() { Ok(()) } else { Err(PlayError::RealTime(robots)) }
}

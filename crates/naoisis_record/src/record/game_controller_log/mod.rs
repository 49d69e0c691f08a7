//! Logs of the league's GameController: written of simulated matches, read of real ones.
//!
//! The GameController of the Standard Platform League from 2023 on (`GameController3`), and that of the Humanoid Soccer League, write
//! what they decide as YAML: a list of entries, each with a time since the start. An entry is the parameters of the match (the first),
//! an action of the referee, the state of the game after it, a status message of a robot, a team message, or the end.
//! `naoisis run --log gamecontroller=FILE` writes such a log, so that the league's own `game_controller_logs` counts simulated matches.
//! [`GameControllerLog`] reads one, and counts with [`MatchCounts`](super::match_counts::MatchCounts).
//!
//! What a log of a simulated match has and has not:
//!
//! - The blue team is `home`, number 1, the pink one `away`, number 2. The date is 1970-01-01: a match has no date.
//! - Each robot sends a status message every two seconds, with the place and the ball that it believes in.
//! - A team message has as many bytes as the robot's, all of them 0. Its action has no state of its own after it.
//! - Reasons that the league does not know are the nearest it knows: illegal defending is an illegal position, stalling and obstruction
//!   are a local game stuck, an intervention or a rule of one's own is a request for pick-up.
//! - Shots of a shoot-out are not logged.

mod dialect;
mod entries;
mod read_entries;
mod reader;
mod writer;

pub use dialect::PICK_UP;
pub use reader::{GameControllerLog, GameControllerLogError};
pub use writer::GameControllerLogRecorder;

#[cfg(test)]
mod tests;

//! Logs of the league's GameController: written for simulated matches, and read from real ones.
//!
//! The GameController of the Standard Platform League since 2023 (`GameController3`), and that of the Humanoid Soccer League, write their
//! decisions as YAML: a list of entries, each with a time since the start. An entry has the parameters of the match (the first entry), an
//! action of the referee, the state of the game after it, a status message of a robot, a team message, or the end.
//! `naoisis run --log gamecontroller=FILE` writes such a log, so that the league's own `game_controller_logs` counts simulated matches.
//! [`GameControllerLog`] reads a log, and counts with [`MatchCounts`](super::match_counts::MatchCounts).
//!
//! Differences between a log of a simulated match and a real one:
//!
//! - The blue team is `home`, number 1, the pink one `away`, number 2. The date is 1970-01-01: a simulated match has none, and
//!   [`GameControllerLog`] leaves it empty.
//! - Each robot sends a status message every two seconds, with its believed pose and ball position.
//! - A team message is as long as the robot's message, but all its bytes are 0. Its action has no state after it.
//! - Offences that the league does not have become the nearest one: illegal defending is an illegal position, stalling and obstruction are
//!   a local game stuck, an intervention or a custom rule is a request for pick-up.
//! - Shots of a shoot-out are not logged.

mod dialect;
mod entries;
mod parameters;
mod read_entries;
mod reader;
mod writer;

pub use dialect::PICK_UP;
pub use reader::{GameControllerLog, GameControllerLogError};
pub use writer::GameControllerLogRecorder;

/// The date of simulated matches.
const NO_DATE: &str = "1970-01-01T00:00:00Z";

#[cfg(test)]
mod tests;

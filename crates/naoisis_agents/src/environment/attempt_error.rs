//! Why a challenge cannot be played.

use super::challenge::ChallengeError;
use super::player::ChallengePlayer;
use super::start_error::StartError;
use naoisis_core::team::RobotId;

/// Why a challenge cannot be played.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum AttemptError {
    /// The challenge is invalid.
    #[error(transparent)]
    Challenge(#[from] ChallengeError),
    /// No team has this name.
    #[error("there is no team `{name}`{meant}; expected one of {known}")]
    NoTeam {
        /// Its name.
        name: String,
        /// A suggestion, in words.
        meant: String,
        /// All names of teams.
        known: String,
    },
    /// The player has no robots that decide in the match.
    #[error("`{0}` decides outside of the match; expected a behaviour or a team")]
    Outside(ChallengePlayer),
    /// The command line of a program is malformed.
    #[error("`{0}` names no program; expected a command line after `exec:`, with closed quotes")]
    NoProgram(String),
    /// There is no episode to play back.
    #[error("{player}: no episode of {tried} succeeds, so there is nothing to play back")]
    NothingToPlayBack {
        /// The player that should succeed.
        player: String,
        /// The number of episodes.
        tried: u64,
    },
    /// The commands in a file of results cannot be read.
    #[error("the recorded commands of the episode of seed {seed} cannot be read; the file is damaged")]
    DamagedCommands {
        /// The seed of the episode.
        seed: u64,
    },
    /// The program of a robot was lost.
    #[error("the program of {robot} was lost in the episode of seed {seed}: {message}")]
    Lost {
        /// The seed of the episode.
        seed: u64,
        /// The robot.
        robot: RobotId,
        /// What happened.
        message: String,
    },
    /// An episode cannot start, for example because a behaviour does not exist.
    #[error(transparent)]
    Start(#[from] StartError),
}

naoisis_core::debug_as_displayed!(AttemptError);

//! The players of a challenge, and their names.

use core::convert::Infallible;
use core::fmt;
use core::str::FromStr;

use naoisis_sim::scenario::TeamsSpec;

/// The controller of the robots of a challenge.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum ChallengePlayer {
    /// Random actions.
    Random,
    /// Straight ahead at full speed.
    Ahead,
    /// The commands of the first successful episode of this player, in every episode, independent of what is sensed.
    OpenLoop(Box<ChallengePlayer>),
    /// The behaviour with this name, for each robot.
    Behaviour(String),
    /// The learned policy in this file, for each robot.
    Policy(String),
    /// The team with this name, or the program with this command line after `exec:`.
    Team(String),
}

impl ChallengePlayer {
    /// Whether its robots decide for themselves.
    pub(super) fn has_own_robots(&self) -> bool {
        matches!(self, ChallengePlayer::Behaviour(_) | ChallengePlayer::Policy(_) | ChallengePlayer::Team(_))
    }

    /// Whether it starts programs, which may decide otherwise the next time, or not be there.
    pub fn is_program(&self) -> bool {
        match self {
            ChallengePlayer::Team(name) => TeamsSpec::command_line(name).is_some(),
            ChallengePlayer::OpenLoop(player) => player.is_program(),
            _ => false,
        }
    }
}

impl FromStr for ChallengePlayer {
    type Err = Infallible;

    /// Parses `random`, `ahead`, `open loop of` and a player, the name of a behaviour, `team` and the name of a team, a command line
    /// after `exec:`, or a file after `policy:`.
    fn from_str(word: &str) -> Result<Self, Infallible> {
        if let Some(player) = word.strip_prefix("open loop of ") {
            return Ok(ChallengePlayer::OpenLoop(Box::new(player.parse()?)));
        }
        if let Some(file) = TeamsSpec::policy(word) {
            return Ok(ChallengePlayer::Policy(file.to_owned()));
        }
        Ok(match (word, word.strip_prefix("team ")) {
            ("random", _) => ChallengePlayer::Random,
            ("ahead", _) => ChallengePlayer::Ahead,
            (_, Some(team)) => ChallengePlayer::Team(team.to_owned()),
            _ if word.starts_with(TeamsSpec::EXEC) => ChallengePlayer::Team(word.to_owned()),
            _ => ChallengePlayer::Behaviour(word.to_owned()),
        })
    }
}

impl fmt::Display for ChallengePlayer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ChallengePlayer::Random => formatter.write_str("random"),
            ChallengePlayer::Ahead => formatter.write_str("ahead"),
            ChallengePlayer::OpenLoop(player) => write!(formatter, "open loop of {player}"),
            ChallengePlayer::Behaviour(name) => formatter.write_str(name),
            ChallengePlayer::Policy(file) => write!(formatter, "{}{file}", TeamsSpec::POLICY),
            ChallengePlayer::Team(name) if name.starts_with(TeamsSpec::EXEC) => formatter.write_str(name),
            ChallengePlayer::Team(name) => write!(formatter, "team {name}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_player_is_a_word() {
        for word in [
            "random", "ahead", "striker", "team roles", "open loop of team roles", "exec:python3 'my team.py'",
            "policy:score.onnx",
        ] {
            let Ok(player) = word.parse::<ChallengePlayer>();
            assert_eq!(player.to_string(), word);
        }
    }
}

//! The terms of the GameController in both leagues.

use heck::ToSnakeCase;
use naoisis_core::game::{GameState, PenaltyReason, SetPlayKind};

/// Name of the custom reason for a robot that its team has picked up.
pub const PICK_UP: &str = "request_for_pick_up";

/// The league whose terms are used.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) enum Dialect {
    /// The Standard Platform League.
    #[default]
    StandardPlatform,
    /// The Humanoid Soccer League.
    Humanoid,
}

impl Dialect {
    /// Returns the dialect of the league with this name.
    pub fn of_league(league: Option<&str>) -> Self {
        if league.is_some_and(|league| league.starts_with("hsl")) { Self::Humanoid } else { Self::StandardPlatform }
    }

    pub fn set_play(self, kind: Option<SetPlayKind>) -> &'static str {
        let is_humanoid = self == Self::Humanoid;
        match kind {
            None => "noSetPlay",
            Some(SetPlayKind::KickOff) => "kickOff",
            Some(SetPlayKind::KickIn) if is_humanoid => "throwIn",
            Some(SetPlayKind::KickIn) => "kickIn",
            Some(SetPlayKind::GoalKick) => "goalKick",
            Some(SetPlayKind::CornerKick) => "cornerKick",
            Some(SetPlayKind::PushingFreeKick) if is_humanoid => "directFreeKick",
            Some(SetPlayKind::IndirectFreeKick) if is_humanoid => "indirectFreeKick",
            Some(SetPlayKind::PushingFreeKick | SetPlayKind::IndirectFreeKick) => "pushingFreeKick",
            Some(SetPlayKind::PenaltyKick) => "penaltyKick",
        }
    }

    pub fn state(self, state: GameState) -> &'static str {
        match state {
            GameState::Standby if self == Self::Humanoid => "initial",
            state => state.name(),
        }
    }

    /// Returns the call and the penalty for an offence.
    pub fn penalty(self, reason: PenaltyReason) -> [&'static str; 2] {
        use PenaltyReason as Reason;
        let [standard, humanoid] = match reason {
            Reason::Pushing => [["pushing", "playerPushing"], ["pushing", "pushing"]],
            Reason::BallHolding => [["ballHolding"; 2]; 2],
            Reason::LeavingField => [["leavingTheField"; 2]; 2],
            Reason::IllegalDefender | Reason::IllegalPosition => {
                [["illegalPosition"; 2], ["illegalPosition", "illegalPositioning"]]
            }
            Reason::Inactive | Reason::Fallen => [["fallenInactive"; 2], ["incapableRobot"; 2]],
            Reason::Stalling | Reason::Obstruction | Reason::GameStuck => [["localGameStuck"; 2]; 2],
            Reason::MotionInSet | Reason::MotionInStop => [["motionInSet"; 2]; 2],
            Reason::MotionInStandby => [["motionInStandby"; 2], ["motionInSet"; 2]],
            Reason::SentOff => [["requestForPickUp", "pickedUp"], ["sendOff", "sentOff"]],
            Reason::ShootOut | Reason::Substitute => [["requestForPickUp", "substitute"]; 2],
            Reason::Manual | Reason::PickUp | Reason::Custom(_) => [["requestForPickUp", "pickedUp"]; 2],
        };
        if self == Self::Humanoid { humanoid } else { standard }
    }

    /// Returns the penalties that a robot can serve.
    pub fn penalties(self) -> &'static [&'static str] {
        match self {
            Self::StandardPlatform => &[
                "noPenalty", "substitute", "pickedUp", "illegalPositionInSet", "illegalPosition", "motionInStandby",
                "motionInSet", "fallenInactive", "localGameStuck", "ballHolding", "playerStance", "playerPushing",
                "playingWithArmsHands", "leavingTheField",
            ],
            Self::Humanoid => &[
                "noPenalty", "illegalPositioning", "motionInSet", "localGameStuck", "incapableRobot", "pickedUp",
                "ballHolding", "leavingTheField", "playingWithArmsHands", "pushing", "sentOff", "substitute",
            ],
        }
    }

    /// Returns the names of the set plays.
    pub fn set_plays(self) -> &'static [&'static str] {
        match self {
            Self::StandardPlatform => {
                &["noSetPlay", "kickOff", "kickIn", "goalKick", "cornerKick", "pushingFreeKick", "penaltyKick"]
            }
            Self::Humanoid => &[
                "noSetPlay", "kickOff", "directFreeKick", "indirectFreeKick", "penaltyKick", "throwIn", "goalKick",
                "cornerKick",
            ],
        }
    }
}

/// Returns the set play for a word of either league. Returns `None` for a kick-off and for unknown words.
pub(super) fn set_play_of(word: &str) -> Option<SetPlayKind> {
    Some(match word {
        "kickIn" | "throwIn" => SetPlayKind::KickIn,
        "goalKick" => SetPlayKind::GoalKick,
        "cornerKick" => SetPlayKind::CornerKick,
        "pushingFreeKick" | "directFreeKick" => SetPlayKind::PushingFreeKick,
        "indirectFreeKick" => SetPlayKind::IndirectFreeKick,
        "penaltyKick" => SetPlayKind::PenaltyKick,
        _ => return None,
    })
}

/// Returns the game state for a word.
pub(super) fn state_of(word: &str) -> GameState {
    match word {
        "standby" => GameState::Standby,
        "ready" => GameState::Ready,
        "set" => GameState::Set,
        "playing" => GameState::Playing,
        "finished" => GameState::Finished,
        "timeout" => GameState::Timeout,
        _ => GameState::Initial,
    }
}

/// Returns the offence of a call, and the set play that it brings to the opponents. Returns `None` for calls that remove no robot.
pub(super) fn offence_of(call: &str) -> Option<(PenaltyReason, Option<SetPlayKind>)> {
    let reason = match call {
        "pushing" => PenaltyReason::Pushing,
        "foul" => return Some((PenaltyReason::Pushing, Some(SetPlayKind::PushingFreeKick))),
        "penaltyKick" => return Some((PenaltyReason::Pushing, Some(SetPlayKind::PenaltyKick))),
        "illegalPosition" | "illegalPositioning" => PenaltyReason::IllegalPosition,
        "leavingTheField" => PenaltyReason::LeavingField,
        "fallenInactive" | "incapableRobot" => PenaltyReason::Fallen,
        "localGameStuck" => PenaltyReason::GameStuck,
        "ballHolding" => PenaltyReason::BallHolding,
        "motionInSet" => PenaltyReason::MotionInSet,
        "motionInStandby" => PenaltyReason::MotionInStandby,
        "sendOff" => PenaltyReason::SentOff,
        "warn" | "caution" => return None,
        "requestForPickUp" => custom(PICK_UP)?,
        other => custom(&other.to_snake_case()).unwrap_or(PenaltyReason::Manual),
    };
    Some((reason, None))
}

fn custom(name: &str) -> Option<PenaltyReason> {
    name.parse().ok().map(PenaltyReason::Custom)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_of_an_offence_is_an_offence_of_its_league() {
        for dialect in [Dialect::StandardPlatform, Dialect::Humanoid] {
            for reason in PenaltyReason::built_in() {
                let [call, penalty] = dialect.penalty(reason);
                assert!(dialect.penalties().contains(&penalty), "{reason:?}: {penalty}");
                assert!(offence_of(call).is_some(), "{reason:?}: {call}");
            }
        }
        let same =
            [PenaltyReason::Pushing, PenaltyReason::Fallen, PenaltyReason::LeavingField, PenaltyReason::BallHolding];
        for reason in same {
            assert_eq!(offence_of(Dialect::StandardPlatform.penalty(reason)[0]), Some((reason, None)));
        }
    }

    #[test]
    fn set_plays_read_as_they_are_written() {
        use SetPlayKind::{CornerKick, GoalKick, KickIn, PenaltyKick, PushingFreeKick};
        for dialect in [Dialect::StandardPlatform, Dialect::Humanoid] {
            for kind in [KickIn, GoalKick, CornerKick, PushingFreeKick, PenaltyKick] {
                let word = dialect.set_play(Some(kind));
                assert!(dialect.set_plays().contains(&word));
                assert_eq!(set_play_of(word), Some(kind), "{word}");
            }
        }
        assert_eq!(set_play_of("kickOff"), None);
    }

    #[test]
    fn calls_of_other_versions_are_reasons_of_their_own() {
        let name = |call| offence_of(call).map(|(reason, _)| reason.name().to_owned());
        assert_eq!(name("playerStance").as_deref(), Some("player_stance"));
        assert_eq!(name("requestForPickUp").as_deref(), Some(PICK_UP));
        assert_eq!(offence_of("caution"), None);
        assert_eq!(offence_of("foul"), Some((PenaltyReason::Pushing, Some(SetPlayKind::PushingFreeKick))));
    }
}

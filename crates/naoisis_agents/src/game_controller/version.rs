//! The versions of the GameController's protocol. The features that differ between them are in a table, `LAYOUTS`.

use naoisis_core::game::{GameState, PenaltyReason, Rules, SetPlayKind};

/// The number of robots per team that a packet has room for.
pub const MOST_PLAYERS: usize = 20;
/// The number of bytes of a packet before the teams, and of a team before its players.
pub(super) const HEAD_BYTES: usize = 18;
pub(super) const TEAM_HEAD_BYTES: usize = 10;

/// A version of the protocol.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ProtocolVersion {
    /// Standard Platform League, 2025
    V18,
    /// Humanoid Soccer League, German Open 2026
    V19,
    /// Humanoid Soccer League, RoboCup 2026
    V20,
}

/// The features that differ between versions of the protocol. A new version is a row of [`LAYOUTS`].
pub(super) struct Layout {
    version: ProtocolVersion,
    /// Its version number on the wire.
    number: u8,
    /// Its name on the command line.
    name: &'static str,
    league: &'static str,
    /// The bytes of a robot, in order.
    pub(super) player: &'static [PlayerField],
    /// Whether the two bytes after the number of players are the division and whether play is stopped, instead of phase and type of the
    /// competition.
    pub(super) has_division: bool,
    /// The code of `standby`.
    pub(super) standby: u8,
    /// The codes of penalties. A reason is written as the first code that lists it; a code is read as its first reason.
    penalties: &'static [(u8, &'static [PenaltyReason])],
    /// The code of penalties that the league does not have, which appear as the operator's own decision.
    other_penalty: u8,
    substitute: u8,
    /// The codes of set plays, as for penalties.
    set_plays: &'static [(u8, &'static [SetPlayKind])],
}

/// A byte of a robot in a packet.
#[derive(Clone, Copy)]
pub(super) enum PlayerField {
    Penalty,
    SecondsLeft,
    Warnings,
    Cautions,
}

const LAYOUTS: [Layout; 3] = [
    Layout {
        version: ProtocolVersion::V18,
        number: 18,
        name: "v18",
        league: "Standard Platform League, 2025",
        player: &[PlayerField::Penalty, PlayerField::SecondsLeft],
        has_division: false,
        standby: 5,
        penalties: &[
            (1, &[PenaltyReason::BallHolding]),
            (2, &[PenaltyReason::Pushing, PenaltyReason::Obstruction]),
            (3, &[PenaltyReason::MotionInSet, PenaltyReason::MotionInStop]),
            (4, &[PenaltyReason::Inactive, PenaltyReason::Fallen]),
            (5, &[PenaltyReason::IllegalPosition, PenaltyReason::IllegalDefender]),
            (6, &[PenaltyReason::LeavingField]),
            (7, &[PenaltyReason::PickUp]),
            (8, &[PenaltyReason::GameStuck, PenaltyReason::Stalling]),
            (9, &[PenaltyReason::IllegalPosition]),
            (11, &[PenaltyReason::MotionInStandby]),
        ],
        other_penalty: 15,
        substitute: 14,
        set_plays: &[
            (1, &[SetPlayKind::GoalKick]),
            // The only difference between direct and indirect free kicks is which goals count.
            (2, &[SetPlayKind::PushingFreeKick, SetPlayKind::IndirectFreeKick]),
            (3, &[SetPlayKind::CornerKick]),
            (4, &[SetPlayKind::KickIn]),
            (5, &[SetPlayKind::PenaltyKick]),
        ],
    },
    Layout {
        version: ProtocolVersion::V19,
        number: 19,
        name: "v19",
        league: "Humanoid Soccer League, German Open 2026",
        player: &[PlayerField::Penalty, PlayerField::SecondsLeft, PlayerField::Warnings, PlayerField::Cautions],
        has_division: true,
        standby: 0,
        penalties: &[
            (1, &[PenaltyReason::IllegalPosition, PenaltyReason::IllegalDefender]),
            (2, &[PenaltyReason::MotionInSet, PenaltyReason::MotionInStop]),
            (3, &[PenaltyReason::GameStuck, PenaltyReason::Stalling]),
            (4, &[PenaltyReason::Inactive, PenaltyReason::Fallen]),
            (5, &[PenaltyReason::PickUp]),
            (6, &[PenaltyReason::BallHolding]),
            (7, &[PenaltyReason::LeavingField]),
            (9, &[PenaltyReason::Pushing, PenaltyReason::Obstruction]),
            (10, &[PenaltyReason::SentOff]),
        ],
        other_penalty: 5,
        substitute: 11,
        set_plays: HUMANOID_SET_PLAYS,
    },
    Layout {
        version: ProtocolVersion::V20,
        number: 20,
        name: "v20",
        league: "Humanoid Soccer League, RoboCup 2026",
        player: &[PlayerField::Penalty, PlayerField::SecondsLeft, PlayerField::Cautions],
        has_division: true,
        standby: 0,
        penalties: &[
            (1, &[PenaltyReason::IllegalPosition, PenaltyReason::IllegalDefender]),
            (2, &[PenaltyReason::MotionInSet]),
            (3, &[PenaltyReason::MotionInStop]),
            (4, &[PenaltyReason::GameStuck, PenaltyReason::Stalling]),
            (5, &[PenaltyReason::Inactive, PenaltyReason::Fallen]),
            (6, &[PenaltyReason::PickUp]),
            (7, &[PenaltyReason::BallHolding]),
            (8, &[PenaltyReason::LeavingField]),
            (10, &[PenaltyReason::Pushing, PenaltyReason::Obstruction]),
            // A robot that is cautioned for another reason.
            (11, &[PenaltyReason::Manual]),
            (12, &[PenaltyReason::SentOff]),
        ],
        other_penalty: 6,
        substitute: 13,
        set_plays: HUMANOID_SET_PLAYS,
    },
];

const HUMANOID_SET_PLAYS: &[(u8, &[SetPlayKind])] = &[
    (1, &[SetPlayKind::PushingFreeKick]),
    (2, &[SetPlayKind::IndirectFreeKick]),
    (3, &[SetPlayKind::PenaltyKick]),
    (4, &[SetPlayKind::KickIn]),
    (5, &[SetPlayKind::GoalKick]),
    (6, &[SetPlayKind::CornerKick]),
];

impl ProtocolVersion {
    /// All versions, from the oldest.
    pub const ALL: [ProtocolVersion; 3] = [ProtocolVersion::V18, ProtocolVersion::V19, ProtocolVersion::V20];

    pub(super) const fn layout(self) -> &'static Layout {
        match self {
            ProtocolVersion::V18 => &LAYOUTS[0],
            ProtocolVersion::V19 => &LAYOUTS[1],
            ProtocolVersion::V20 => &LAYOUTS[2],
        }
    }

    /// The version for matches with these rules: 20 for the rules of the Humanoid Soccer League, 19 for those of its German Open of 2026,
    /// otherwise 18.
    pub fn of_rules(rules: &Rules) -> Self {
        match rules.name.as_str() {
            "hsl2026_german_open" => Self::V19,
            name if name.starts_with("hsl") => Self::V20,
            _ => Self::V18,
        }
    }

    /// The version with this number on the wire.
    pub fn of_number(number: u8) -> Option<Self> {
        LAYOUTS.iter().find(|layout| layout.number == number).map(|layout| layout.version)
    }

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        self.layout().name
    }

    /// The league and year of this version.
    pub const fn league(self) -> &'static str {
        self.layout().league
    }

    /// Its number on the wire.
    pub fn number(self) -> u8 {
        self.layout().number
    }

    /// The length of a control packet, bytes.
    pub fn packet_bytes(self) -> usize {
        HEAD_BYTES + 2 * (TEAM_HEAD_BYTES + MOST_PLAYERS * self.player_bytes())
    }

    pub(super) fn player_bytes(self) -> usize {
        self.layout().player.len()
    }

    /// The code of a penalty. Penalties that the league does not have become the operator's own decision.
    pub fn penalty_code(self, reason: PenaltyReason) -> u8 {
        if matches!(reason, PenaltyReason::ShootOut | PenaltyReason::Substitute) {
            return self.substitute_code();
        }
        code_of(self.layout().penalties, &reason).unwrap_or(self.layout().other_penalty)
    }

    /// The code of a substitute.
    pub fn substitute_code(self) -> u8 {
        self.layout().substitute
    }

    /// The penalty with this code; `None` for a robot without a penalty.
    pub fn penalty_reason(self, code: u8) -> Option<PenaltyReason> {
        if code == self.layout().substitute {
            return Some(PenaltyReason::Substitute);
        }
        (code != 0).then(|| named(self.layout().penalties, code).unwrap_or(PenaltyReason::Manual))
    }

    pub(super) fn state_code(self, state: GameState) -> u8 {
        match state {
            // A time-out is a phase, not a state.
            GameState::Initial | GameState::Timeout => 0,
            GameState::Standby => self.layout().standby,
            GameState::Ready => 1,
            GameState::Set => 2,
            GameState::Playing => 3,
            GameState::Finished => 4,
        }
    }

    pub(super) fn set_play_code(self, set_play: Option<SetPlayKind>) -> u8 {
        set_play.and_then(|kind| code_of(self.layout().set_plays, &kind)).unwrap_or(0)
    }

    /// The set play with this code; `None` if the code stands for none.
    pub(super) fn set_play(self, code: u8) -> Option<SetPlayKind> {
        named(self.layout().set_plays, code)
    }
}

/// The first code of a table that has this value.
fn code_of<T: PartialEq>(table: &[(u8, &[T])], value: &T) -> Option<u8> {
    table.iter().find(|(_, values)| values.contains(value)).map(|(code, _)| *code)
}

/// The first value with this code.
fn named<T: Copy>(table: &[(u8, &[T])], code: u8) -> Option<T> {
    table.iter().find(|(listed, _)| *listed == code).and_then(|(_, values)| values.first().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_penalty_means_the_same_in_every_version() {
        // A penalty that a version does not have becomes the operator's decision, or the most similar one.
        let is_known = |reason: &PenaltyReason| {
            use PenaltyReason::{Manual, MotionInStandby, MotionInStop, PickUp, SentOff};
            !matches!(reason, SentOff | MotionInStandby | MotionInStop | PickUp | Manual)
        };
        for reason in PenaltyReason::built_in().filter(is_known) {
            let [one, other, newest] =
                ProtocolVersion::ALL.map(|version| version.penalty_reason(version.penalty_code(reason)));
            assert!(
                one.is_some() && (one == other || reason == PenaltyReason::ShootOut),
                "{reason:?}: {one:?}, {other:?}"
            );
            assert_eq!(other, newest);
        }
        let newest = |reason| ProtocolVersion::V20.penalty_reason(ProtocolVersion::V20.penalty_code(reason));
        assert_eq!(newest(PenaltyReason::MotionInStop), Some(PenaltyReason::MotionInStop));
        assert_eq!(newest(PenaltyReason::PickUp), Some(PenaltyReason::PickUp));
        assert_eq!(ProtocolVersion::V18.penalty_reason(0), None);
        assert_eq!(ProtocolVersion::V18.penalty_code(PenaltyReason::PickUp), 7);
        let sent_off = |version: ProtocolVersion| version.penalty_reason(version.penalty_code(PenaltyReason::SentOff));
        assert_eq!(sent_off(ProtocolVersion::V18), Some(PenaltyReason::Manual));
        assert_eq!(sent_off(ProtocolVersion::V19), Some(PenaltyReason::SentOff));
    }
}

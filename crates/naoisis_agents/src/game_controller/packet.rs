//! Control packets: the messages of a GameController to robots, byte for byte as version 18 (Standard Platform League
//! of 2025, 118 bytes), 19 (Humanoid Soccer League, German Open 2026, 198 bytes) or 20 (RoboCup 2026, 158 bytes) of
//! `RoboCupGameControlData`. Little-endian, no padding.
//!
//! In memory a packet has the types of this library; the codes of the versions exist only on the wire. The differences between versions are
//! in a table, `LAYOUTS`.

use super::colours::JerseyColour;
use super::division::Division;
use naoisis_core::game::{GameState, PenaltyReason, Rules, SetPlayKind};

/// The number of robots per team that a packet has room for.
pub const MOST_PLAYERS: usize = 20;
/// The team number that stands for no team.
const NO_TEAM: u8 = 255;
/// The header of a packet for robots.
const FOR_ROBOTS: [u8; 4] = *b"RGme";
/// The header of a packet for monitors, which has no delays.
const FOR_MONITORS: [u8; 4] = *b"RGTD";
/// The number of bytes of a packet before the teams, and of a team before its players.
const HEAD_BYTES: usize = 18;
const TEAM_HEAD_BYTES: usize = 10;

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
struct Layout {
    version: ProtocolVersion,
    /// Its version number on the wire.
    number: u8,
    /// Its name on the command line.
    name: &'static str,
    league: &'static str,
    /// The bytes of a robot, in order.
    player: &'static [PlayerField],
    /// Whether the two bytes after the number of players are the division and whether play is stopped, instead of phase and type of the
    /// competition.
    has_division: bool,
    /// The code of `standby`.
    standby: u8,
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
enum PlayerField {
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

    const fn layout(self) -> &'static Layout {
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

    fn player_bytes(self) -> usize {
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

    fn state_code(self, state: GameState) -> u8 {
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

    fn set_play_code(self, set_play: Option<SetPlayKind>) -> u8 {
        set_play.and_then(|kind| code_of(self.layout().set_plays, &kind)).unwrap_or(0)
    }

    fn set_play_of(self, code: u8) -> Result<Option<SetPlayKind>, PacketError> {
        match named(self.layout().set_plays, code) {
            None if code != 0 => Err(PacketError::UnknownCode { field: "setPlay", code }),
            set_play => Ok(set_play),
        }
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

/// The phase of a match in a packet of a GameController.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[repr(u8)]
pub enum GamePhase {
    /// A half of the match.
    #[default]
    Normal = 0,
    /// A penalty shoot-out.
    ShootOut = 1,
    /// A half of the extra time.
    ExtraTime = 2,
    /// A time-out.
    Timeout = 3,
}

impl GamePhase {
    fn of_code(code: u8) -> Option<Self> {
        [Self::Normal, Self::ShootOut, Self::ExtraTime, Self::Timeout].into_iter().find(|phase| *phase as u8 == code)
    }
}

/// A message of a GameController.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ControlPacket {
    /// The version of the protocol.
    pub version: ProtocolVersion,
    /// Whether the packet is for monitors: the true state without delays.
    pub for_monitors: bool,
    /// The number of the packet; 255 is followed by 0.
    pub packet_number: u8,
    /// The number of robots of a team.
    pub players_per_team: u8,
    /// Whether the match must have a winner (18 only).
    pub is_knockout: bool,
    /// The division of the league (from 19 on).
    pub division: Division,
    /// Whether play is interrupted (from 19 on).
    pub is_stopped: bool,
    /// The phase of the match.
    pub phase: GamePhase,
    /// The state of the game. From version 19 on, `standby` is sent as `initial`; so is a time-out, with its phase.
    pub state: GameState,
    /// The current set play.
    pub set_play: Option<SetPlayKind>,
    /// Whether this is the first half.
    pub is_first_half: bool,
    /// The number of the team that takes the set play, if it is announced.
    pub kicking_team: Option<u8>,
    /// Time left in the half, s; negative when it is over.
    pub seconds_left: i16,
    /// The time left on the secondary clock, s.
    pub secondary_seconds_left: i16,
    /// The teams; first the one whose goal is on the left, at -x.
    pub teams: [TeamPacket; 2],
}

/// A team in a control packet.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct TeamPacket {
    /// The team's number in the league.
    pub number: u8,
    /// The colour of its field players.
    pub colour: JerseyColour,
    /// The colour of its goalkeeper.
    pub goalkeeper_colour: JerseyColour,
    /// The number of its goalkeeper; 0 if it has none, as when it shoots in a shoot-out.
    pub goalkeeper: u8,
    /// Its goals.
    pub score: u8,
    /// The shots that it has taken in a shoot-out, with the one under way.
    pub shots: u8,
    /// One bit per shot, set if it scored; the first shot has the lowest bit.
    pub shots_scored: u16,
    /// The number of messages that it may still send.
    pub message_budget: u16,
    /// Its robots, by number.
    pub players: [PlayerPacket; MOST_PLAYERS],
}

/// A robot in a control packet.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct PlayerPacket {
    /// The code of its penalty; 0 for none.
    pub penalty: u8,
    /// The time until its penalty ends, s.
    pub seconds_left: u8,
    /// The number of its warnings (19 only).
    pub warnings: u8,
    /// The number of its cautions (from 19 on).
    pub cautions: u8,
}

/// Why bytes are no control packet.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PacketError {
    /// The header is wrong.
    #[error("it does not begin with RGme")]
    Header,
    /// The version is not supported.
    #[error("it is of version {0}; expected 18, 19 or 20")]
    Version(u8),
    /// The length does not fit the version.
    #[error("it has {found} bytes; expected {expected}")]
    Length {
        /// The actual length.
        found: usize,
        /// The expected length.
        expected: usize,
    },
    /// A code does not exist.
    #[error("there is no {field} {code}")]
    UnknownCode {
        /// The name of the field in the league's C header.
        field: &'static str,
        /// The code.
        code: u8,
    },
}

naoisis_core::debug_as_displayed!(PacketError);

impl ControlPacket {
    /// The bytes of the packet.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.version.packet_bytes());
        bytes.extend(if self.for_monitors { FOR_MONITORS } else { FOR_ROBOTS });
        bytes.extend([self.version.number(), self.packet_number, self.players_per_team]);
        // 18: phase and type of the competition, where type 0 is a normal match. Later: the division as the type.
        bytes.extend(match self.version.layout().has_division {
            false => [u8::from(self.is_knockout), 0],
            true => [self.division.code(), u8::from(self.is_stopped)],
        });
        bytes.extend([
            self.phase as u8,
            self.version.state_code(self.state),
            self.version.set_play_code(self.set_play),
            u8::from(self.is_first_half),
            self.kicking_team.unwrap_or(NO_TEAM),
        ]);
        bytes.extend(self.seconds_left.to_le_bytes());
        bytes.extend(self.secondary_seconds_left.to_le_bytes());
        for team in &self.teams {
            let colours = [team.colour, team.goalkeeper_colour].map(|colour| colour as u8);
            bytes.extend([team.number, colours[0], colours[1], team.goalkeeper, team.score, team.shots]);
            bytes.extend(team.shots_scored.to_le_bytes());
            bytes.extend(team.message_budget.to_le_bytes());
            for player in &team.players {
                bytes.extend(self.version.layout().player.iter().map(|field| match field {
                    PlayerField::Penalty => player.penalty,
                    PlayerField::SecondsLeft => player.seconds_left,
                    PlayerField::Warnings => player.warnings,
                    PlayerField::Cautions => player.cautions,
                }));
            }
        }
        bytes
    }

    /// Reads a packet.
    ///
    /// # Errors
    /// If the bytes are not a control packet.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PacketError> {
        let for_monitors = match bytes.first_chunk::<4>() {
            Some(&FOR_ROBOTS) => false,
            Some(&FOR_MONITORS) => true,
            _ => return Err(PacketError::Header),
        };
        let number = *bytes.get(4).ok_or(PacketError::Header)?;
        let version = ProtocolVersion::of_number(number).ok_or(PacketError::Version(number))?;
        let (found, expected) = (bytes.len(), version.packet_bytes());
        if found != expected {
            return Err(PacketError::Length { found, expected });
        }
        let has_division = version.layout().has_division;
        let unknown = |field, code| PacketError::UnknownCode { field, code };
        let division = match has_division {
            false => Division::default(),
            true => Division::of_code(bytes[7]).ok_or_else(|| unknown("competitionType", bytes[7]))?,
        };
        let team = |start: usize| team_from(version, &bytes[start..]);
        let phase = GamePhase::of_code(bytes[9]).ok_or_else(|| unknown("gamePhase", bytes[9]))?;
        let state = match (phase, state_of(bytes[10])?) {
            (GamePhase::Timeout, GameState::Initial) => GameState::Timeout,
            (_, state) => state,
        };
        Ok(ControlPacket {
            version,
            for_monitors,
            packet_number: bytes[5],
            players_per_team: bytes[6],
            is_knockout: !has_division && bytes[7] == 1,
            division,
            is_stopped: has_division && bytes[8] == 1,
            phase,
            state,
            set_play: version.set_play_of(bytes[11])?,
            is_first_half: bytes[12] == 1,
            kicking_team: Some(bytes[13]).filter(|team| *team != NO_TEAM),
            seconds_left: i16::from_le_bytes([bytes[14], bytes[15]]),
            secondary_seconds_left: i16::from_le_bytes([bytes[16], bytes[17]]),
            teams: [team(HEAD_BYTES), team(HEAD_BYTES + (expected - HEAD_BYTES) / 2)],
        })
    }

    /// The packet without its number, clocks and message budgets, for comparing whether anything else changed.
    #[must_use]
    pub fn without_time(&self) -> Self {
        let mut packet = Self { packet_number: 0, seconds_left: 0, secondary_seconds_left: 0, ..self.clone() };
        for team in &mut packet.teams {
            team.message_budget = 0;
            team.players.iter_mut().for_each(|player| player.seconds_left = 0);
        }
        packet
    }
}

/// Reads a team from a packet of checked length.
fn team_from(version: ProtocolVersion, bytes: &[u8]) -> TeamPacket {
    let mut players = [PlayerPacket::default(); MOST_PLAYERS];
    for (player, bytes) in players.iter_mut().zip(bytes[TEAM_HEAD_BYTES..].chunks(version.player_bytes())) {
        for (field, byte) in version.layout().player.iter().zip(bytes) {
            *match field {
                PlayerField::Penalty => &mut player.penalty,
                PlayerField::SecondsLeft => &mut player.seconds_left,
                PlayerField::Warnings => &mut player.warnings,
                PlayerField::Cautions => &mut player.cautions,
            } = *byte;
        }
    }
    TeamPacket {
        number: bytes[0],
        colour: JerseyColour::of_code(bytes[1]),
        goalkeeper_colour: JerseyColour::of_code(bytes[2]),
        goalkeeper: bytes[3],
        score: bytes[4],
        shots: bytes[5],
        shots_scored: u16::from_le_bytes([bytes[6], bytes[7]]),
        message_budget: u16::from_le_bytes([bytes[8], bytes[9]]),
        players,
    }
}

fn state_of(code: u8) -> Result<GameState, PacketError> {
    match code {
        0 => Ok(GameState::Initial),
        5 => Ok(GameState::Standby),
        1 => Ok(GameState::Ready),
        2 => Ok(GameState::Set),
        3 => Ok(GameState::Playing),
        4 => Ok(GameState::Finished),
        _ => Err(PacketError::UnknownCode { field: "state", code }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::random::RandomStream;

    /// The bytes that a C compiler produces for the structure of version 18, filled like [`packet`].
    const GOLDEN_18: &str = concat!(
        "52476d6512c80701000003030105fdff2c010c010101030202015704022d0607000000000000000000000000000000000000",
        "0000000000000000000000000000000000000500000104000000ffff00000000000000000000000000000000000000000000",
        "000000000000000000000000000000000e00",
    );
    /// The bytes of version 19.
    const GOLDEN_19: &str = concat!(
        "52476d6513c80702010003060105fdff2c010c010101030202015704092d0000070701020000000000000000000000000000",
        "0000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000",
        "00000000000000000500000104000000ffff0000000000000000000000000000000000000000000000000000000000000000",
        "00000000000000000000000000000000000000000000000000000000000000000000000000000000000000000b000000",
    );

    /// The match of the golden packets.
    fn packet(version: ProtocolVersion) -> ControlPacket {
        let player = |penalty, seconds_left| PlayerPacket { penalty, seconds_left, ..PlayerPacket::default() };
        let mut teams = [TeamPacket::default(), TeamPacket::default()];
        teams[0] = TeamPacket {
            number: 12,
            colour: JerseyColour::Red,
            goalkeeper_colour: JerseyColour::Red,
            goalkeeper: 1,
            score: 3,
            shots: 2,
            shots_scored: 0x0102,
            message_budget: 1111,
            ..TeamPacket::default()
        };
        teams[1] = TeamPacket { number: 5, goalkeeper: 1, score: 4, message_budget: 65535, ..TeamPacket::default() };
        teams[0].players[0] = player(version.penalty_code(PenaltyReason::Pushing), 45);
        teams[0].players[1] =
            PlayerPacket { warnings: 1, cautions: 2, ..player(version.penalty_code(PenaltyReason::LeavingField), 7) };
        teams[1].players[19] = player(version.substitute_code(), 0);
        if version == ProtocolVersion::V18 {
            teams[0].players[1] = player(version.penalty_code(PenaltyReason::LeavingField), 7);
        }
        ControlPacket {
            version,
            for_monitors: false,
            packet_number: 200,
            players_per_team: 7,
            is_knockout: version == ProtocolVersion::V18,
            division: if version == ProtocolVersion::V18 { Division::default() } else { Division::Large },
            is_stopped: version != ProtocolVersion::V18,
            phase: GamePhase::Normal,
            state: GameState::Playing,
            set_play: Some(SetPlayKind::CornerKick),
            is_first_half: true,
            kicking_team: Some(5),
            seconds_left: -3,
            secondary_seconds_left: 300,
            teams,
        }
    }

    fn hexadecimal(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    #[test]
    fn packets_are_what_a_c_compiler_makes_of_the_published_structures() {
        for (version, golden, length) in
            [(ProtocolVersion::V18, GOLDEN_18, 118), (ProtocolVersion::V19, GOLDEN_19, 198)]
        {
            let packet = packet(version);
            assert_eq!(hexadecimal(&packet.to_bytes()), golden);
            assert_eq!((packet.to_bytes().len(), version.packet_bytes()), (length, length));
            assert_eq!(ControlPacket::from_bytes(&packet.to_bytes()), Ok(packet));
        }
    }

    #[test]
    fn version_20_has_three_bytes_for_a_robot_and_is_19_otherwise() {
        let mut packet = packet(ProtocolVersion::V20);
        packet.teams[0].players[1].warnings = 0;
        packet.phase = GamePhase::ExtraTime;
        let bytes = packet.to_bytes();
        assert_eq!((bytes.len(), bytes[4], bytes[9]), (158, 20, 2));
        let older = ControlPacket { version: ProtocolVersion::V19, ..packet.clone() }.to_bytes();
        assert_eq!(bytes[5..28], older[5..28]);
        // The second team begins after 10 + 20 x 3 bytes; its last robot is a substitute.
        assert_eq!(bytes[88..98], older[108..118]);
        assert_eq!((&bytes[28..34], bytes[155]), (&[10, 45, 0, 8, 7, 2][..], 13));
        assert_eq!(ControlPacket::from_bytes(&bytes), Ok(packet));
    }

    #[test]
    fn what_is_no_packet_is_told_from_one() {
        let bytes = packet(ProtocolVersion::V18).to_bytes();
        let with = |bytes: &[u8], at: usize, value: u8| {
            let mut bytes = bytes.to_vec();
            bytes[at] = value;
            ControlPacket::from_bytes(&bytes)
        };
        let changed = |at: usize, value: u8| with(&bytes, at, value);
        assert_eq!(changed(0, b'X'), Err(PacketError::Header));
        assert_eq!(changed(4, 17), Err(PacketError::Version(17)));
        assert_eq!(changed(4, 19), Err(PacketError::Length { found: 118, expected: 198 }));
        assert_eq!(changed(10, 9), Err(PacketError::UnknownCode { field: "state", code: 9 }));
        assert_eq!(changed(11, 6), Err(PacketError::UnknownCode { field: "setPlay", code: 6 }));
        let no_division = with(&packet(ProtocolVersion::V19).to_bytes(), 7, 3);
        assert_eq!(no_division, Err(PacketError::UnknownCode { field: "competitionType", code: 3 }));
        assert_eq!(ControlPacket::from_bytes(&bytes[..3]), Err(PacketError::Header));
        let mut random = RandomStream::for_match(1, "packets");
        for round in 0..20_000 {
            let mut bytes: Vec<u8> = (0..round % 210).map(|_| (random.uniform() * 256.0) as u8).collect();
            let header = [&b"RGme\x12"[..], b"RGTD\x13", b"RGme\x14"][round % 3];
            bytes.splice(..bytes.len().min(5), header.iter().copied());
            if let Ok(packet) = ControlPacket::from_bytes(&bytes) {
                assert_eq!(packet.to_bytes().len(), bytes.len());
            }
        }
    }

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
        let sent_off = |version: ProtocolVersion| version.penalty_reason(version.penalty_code(PenaltyReason::SentOff));
        assert_eq!(sent_off(ProtocolVersion::V18), Some(PenaltyReason::Manual));
        assert_eq!(sent_off(ProtocolVersion::V19), Some(PenaltyReason::SentOff));
    }
}

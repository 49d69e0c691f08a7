//! Control packets: the messages of a GameController to robots, byte for byte as version 18 (Standard Platform League
//! of 2025, 118 bytes), 19 (Humanoid Soccer League, German Open 2026, 198 bytes) or 20 (RoboCup 2026, 158 bytes) of
//! `RoboCupGameControlData`. Little-endian, no padding.
//!
//! In memory a packet has the types of this library; the codes of the [versions](ProtocolVersion) exist only on the wire.

use super::division::Division;
use super::version::{HEAD_BYTES, PlayerField, TEAM_HEAD_BYTES};
use naoisis_core::game::{GameState, SetPlayKind};
use naoisis_core::robot::jersey::Jersey;

pub use super::version::{MOST_PLAYERS, ProtocolVersion};

/// The team number that stands for no team.
const NO_TEAM: u8 = 255;
/// The header of a packet for robots.
const FOR_ROBOTS: [u8; 4] = *b"RGme";
/// The header of a packet for monitors, which has no delays.
const FOR_MONITORS: [u8; 4] = *b"RGTD";

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
    /// The colour of its field players; `team` is sent as blue.
    pub colour: Jersey,
    /// The colour of its goalkeeper.
    pub goalkeeper_colour: Jersey,
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
            let colours = [team.colour, team.goalkeeper_colour].map(|colour| colour.code().unwrap_or_default());
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
            set_play: set_play_of(version, bytes[11])?,
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
        colour: Jersey::of_code(bytes[1]),
        goalkeeper_colour: Jersey::of_code(bytes[2]),
        goalkeeper: bytes[3],
        score: bytes[4],
        shots: bytes[5],
        shots_scored: u16::from_le_bytes([bytes[6], bytes[7]]),
        message_budget: u16::from_le_bytes([bytes[8], bytes[9]]),
        players,
    }
}

fn set_play_of(version: ProtocolVersion, code: u8) -> Result<Option<SetPlayKind>, PacketError> {
    match version.set_play(code) {
        None if code != 0 => Err(PacketError::UnknownCode { field: "setPlay", code }),
        set_play => Ok(set_play),
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
    use naoisis_core::game::PenaltyReason;
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
            colour: Jersey::Red,
            goalkeeper_colour: Jersey::Red,
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
}

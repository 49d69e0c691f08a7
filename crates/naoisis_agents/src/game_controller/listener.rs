//! A real GameController that makes the decisions of the match: its operator whistles, penalises and restarts, and the match follows its
//! packets.
//!
//! The listener asks the GameController for the true state of the game, as a monitor does. It uses the control packets
//! for robots only while no true state arrives, because they may be delayed and do not say which team takes a free
//! kick. For robots with behaviours of their own the match sends status reports, as programs do for themselves. If the
//! listener is set up for it, monitors that ask the match receive the true positions.

use bevy::prelude::*;
use core::fmt;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

use super::complaints::Complaints;
use super::packet::{ControlPacket, GamePhase, MOST_PLAYERS, PacketError, ProtocolVersion};
use super::packet_series::MatchStatus;
use super::report::ReturnPacket;
use super::sockets::{CONTROL_PORT, NetworkError, REQUEST, REQUEST_PORT, bind, place};
use super::status_reports::{Reporter, status_of};
use super::truth::{Truth, true_report};
use crate::agents::LeagueNumbers;
use naoisis_core::ball::Ball;
use naoisis_core::behaviour::Remote;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::CycleEvents;
use naoisis_core::game::{GameState, OutsideReferee, PenaltyReason, Rules, Score};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::End;
use naoisis_core::robot::Roster;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::status::BodyStatus;

/// The time without a true state after which it is requested again, s.
const TRUTH_IS_OLD_S: f64 = 2.0;
/// The time without a packet after which another GameController is followed, s.
const SILENT_S: f64 = 5.0;
/// The greatest number of packets that are read in a cycle. Further ones wait.
const MOST_PACKETS: usize = 64;

/// The time between two reports of a robot, s.
const REPORT_PERIOD_S: f32 = 1.0;

/// Receives the packets of a GameController.
#[derive(Resource)]
pub struct Listener {
    socket: UdpSocket,
    /// The address at which it listens.
    address: IpAddr,
    port_offset: u16,
    /// The numbers of the teams; `None` until they are known.
    team_numbers: Option<PerTeam<u8>>,
    /// The time at which the true state was last received, s since the start.
    truth_at_s: Option<f64>,
    /// The address and version of the GameController that was last heard.
    controller: Option<(IpAddr, ProtocolVersion)>,
    /// The addresses from which the followed GameController sends to robots and to monitors, and the time when it was last heard, s since
    /// the start.
    followed: [Option<(SocketAddr, f64)>; 2],
    reporter: Reporter,
    /// Whether monitors that ask receive the true state.
    tells_monitors: bool,
    /// The sockets for monitors. They are opened when a GameController is heard, which then has the ports that it needs. `Some(None)` if no
    /// port is free.
    truth: Option<Option<Truth>>,
    complaints: Complaints,
}

impl fmt::Debug for Listener {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Listener").field("socket", &self.socket).finish_non_exhaustive()
    }
}

impl Listener {
    /// Listens at an address of this machine. The loopback address receives from this machine only; any other address
    /// listens on all interfaces, because broadcasts of a network do not arrive at a single one. Without `team_numbers`
    /// the team on the left in the first packet is blue.
    ///
    /// # Errors
    /// If the system refuses, for example because another program listens there.
    pub fn open(address: IpAddr, port_offset: u16, team_numbers: Option<PerTeam<u8>>) -> Result<Self, NetworkError> {
        let address = match address {
            address if address.is_loopback() => address,
            IpAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            IpAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        Ok(Self {
            socket: bind(place(address, CONTROL_PORT, port_offset))?,
            address,
            port_offset,
            team_numbers,
            truth_at_s: None,
            controller: None,
            followed: [None; 2],
            reporter: Reporter::default(),
            tells_monitors: false,
            truth: None,
            complaints: Complaints::default(),
        })
    }

    /// Adds a function that receives messages about the teams that are heard.
    #[must_use]
    pub fn with_notes(mut self, notes: impl Fn(&str) + Send + Sync + 'static) -> Self {
        self.complaints.notes = Some(Box::new(notes));
        self
    }

    /// The numbers of the teams, if they are known, and the port offset, for programs.
    pub(super) fn numbers_for_programs(&self) -> LeagueNumbers {
        LeagueNumbers { team_numbers: self.team_numbers, port_offset: self.port_offset }
    }

    /// Makes the true positions of robots and ball available to monitors. Any program that asks receives them, including programs that
    /// play; without this call no program can.
    #[must_use]
    pub fn with_truth_for_monitors(self) -> Self {
        Self { tells_monitors: true, ..self }
    }

    /// The newest directions of the GameController since the last call, if there are any; `before` are those of the last call.
    fn heard(
        &mut self,
        time_s: f64,
        robots: &[RobotId],
        rules: &Rules,
        before: &OutsideReferee,
    ) -> Option<OutsideReferee> {
        let mut said = None;
        let mut bytes = [0; 256];
        for _ in 0..MOST_PACKETS {
            let Ok((length, from)) = self.socket.recv_from(&mut bytes) else { break };
            let packet = match ControlPacket::from_bytes(&bytes[..length]) {
                Ok(packet) => packet,
                // Other programs may send to this port.
                Err(PacketError::Header) => continue,
                Err(error) => {
                    self.complaints.add(format!("a packet from {} is not understood: {error}", from.ip()));
                    continue;
                }
            };
            let Some(numbers) = self.numbers(&packet) else { continue };
            if !self.follows(&packet, from, time_s) {
                continue;
            }
            self.controller = Some((from.ip(), packet.version));
            let is_fresh = self.truth_at_s.is_some_and(|truth_at_s| time_s - truth_at_s < TRUTH_IS_OLD_S);
            if packet.for_monitors {
                self.truth_at_s = Some(time_s);
            } else if is_fresh {
                continue;
            } else {
                // It does not matter if nobody receives this.
                let _ = self.socket.send_to(&REQUEST, place(from.ip(), REQUEST_PORT, self.port_offset));
            }
            for robot in absent_substitutes(&packet, numbers, robots) {
                self.complaints.add(format!(
                    "the GameController lets {robot} play as a substitute, but the match has no such robot; expected one of \
                     `rules.substitutes`, which is {}",
                    rules.substitutes
                ));
            }
            said = directions(&packet, numbers, robots, rules, before.half).or(said);
        }
        said
    }

    /// Whether the packet is from the GameController that is followed: the first one that is heard, until it is silent. Another one is
    /// reported once.
    fn follows(&mut self, packet: &ControlPacket, from: SocketAddr, time_s: f64) -> bool {
        let followed = &mut self.followed[usize::from(packet.for_monitors)];
        let other_version =
            self.controller.filter(|(address, version)| *address == from.ip() && *version != packet.version);
        match *followed {
            Some((first, heard_s)) if time_s - heard_s < SILENT_S && (first != from || other_version.is_some()) => {
                let version = packet.version.number();
                let message =
                    format!("a second GameController, of version {version} at {from}, is not followed; {first} is");
                self.complaints.add(message);
                false
            }
            _ => {
                *followed = Some((from, time_s));
                true
            }
        }
    }

    /// The numbers of the teams, if the packet is of this match. Packets of another match are reported once.
    fn numbers(&mut self, packet: &ControlPacket) -> Option<PerTeam<u8>> {
        let there = numbers_in(packet);
        if there.blue == there.pink {
            self.complaints.add(format!("a GameController tells of two teams of the same number, {}", there.blue));
            return None;
        }
        let numbers = self.team_numbers.unwrap_or_else(|| {
            let version = packet.version.number();
            self.complaints.note(&format!(
                "a GameController of version {version} is heard: team {} is blue, {} pink",
                there.blue, there.pink
            ));
            there
        });
        self.team_numbers = Some(numbers);
        if there == numbers || there == (PerTeam { blue: numbers.pink, pink: numbers.blue }) {
            return Some(numbers);
        }
        self.complaints.add(format!(
            "a GameController tells of the teams {} and {}, which do not play here; expected {} and {}",
            there.blue, there.pink, numbers.blue, numbers.pink
        ));
        None
    }

    /// The sockets for monitors, if they are enabled and a GameController is heard. Reports once at which address
    /// monitors ask.
    fn truth(&mut self) -> Option<&mut Truth> {
        self.controller.filter(|_| self.tells_monitors)?;
        let open = || {
            let (truth, note) = match Truth::open(self.address, self.port_offset) {
                Ok((truth, requests)) => {
                    (Some(truth), format!("monitors that ask at {requests} receive the true state"))
                }
                Err(error) => (None, format!("monitors cannot ask for the truth: {error}")),
            };
            self.complaints.note(&note);
            truth
        };
        self.truth.get_or_insert_with(open).as_mut()
    }
}

pub(super) fn listen(
    clock: Res<CycleClock>,
    roster: Res<Roster>,
    rules: Res<Rules>,
    mut listener: ResMut<Listener>,
    mut outside: ResMut<OutsideReferee>,
    mut events: ResMut<CycleEvents>,
) {
    let robots: Vec<RobotId> = roster.iter().map(|(id, _)| id).collect();
    for robot in robots.iter().filter(|robot| usize::from(robot.number) > MOST_PLAYERS) {
        listener
            .complaints
            .add(format!("packets have no room for {robot}: their players have numbers up to {MOST_PLAYERS}"));
    }
    let said = listener.heard(clock.start_time_s(), &robots, &rules, &outside);
    listener.complaints.publish(&mut events);
    if let Some(said) = said {
        outside.set_if_neq(said);
    }
}

/// Sends the reports of robots with behaviours of their own.
pub(super) fn report(
    clock: Res<CycleClock>,
    mut listener: ResMut<Listener>,
    robots: Query<(&RobotId, &BodyStatus, Option<&Belief>), Without<Remote>>,
) {
    let is_time = clock.cycle.is_multiple_of(u64::from(clock.cycles_in(REPORT_PERIOD_S)).max(1));
    let listener = &mut *listener;
    let controller = listener.controller.map(|(address, _)| address).filter(IpAddr::is_loopback);
    let (Some(controller), Some(numbers), true) = (controller, listener.team_numbers, is_time) else { return };
    for (id, body, belief) in &robots {
        let report = status_of(*body, belief, clock.start_time_s());
        listener.reporter.send(*id, numbers[id.team], report, controller, listener.port_offset);
    }
}

/// Sends monitors the state of the game and the true positions.
pub(super) fn tell_the_truth(
    status: MatchStatus,
    mut listener: ResMut<Listener>,
    robots: Query<(&RobotId, &Pose, &Posture)>,
    ball: Query<&Pose, With<Ball>>,
) {
    let (Some((_, version)), Some(numbers)) = (listener.controller, listener.team_numbers) else { return };
    let Some(truth) = listener.truth() else { return };
    if !truth.has_monitors() {
        return;
    }
    let is_time = status.is_time();
    truth.tell_game(status.packet(version, true, numbers, None, PerTeam::default(), None), is_time);
    if is_time {
        let ball_m = ball.single().ok().map(|ball| ball.position);
        let report = |(id, pose, posture): (&RobotId, &Pose, &Posture)| {
            let report = true_report(*pose, *posture, ball_m, status.game.own_end(id.team), status.clock.end_time_s());
            ReturnPacket { player: id.number, team: numbers[id.team], report }
        };
        truth.tell_robots(robots.iter().sort_by_key::<&RobotId, _>(|id| **id).map(report));
    }
}

fn numbers_in(packet: &ControlPacket) -> PerTeam<u8> {
    let [left, right] = &packet.teams;
    PerTeam { blue: left.number, pink: right.number }
}

/// The directions in a packet for a match of `robots`; `None` if the packet is for other teams.
fn directions(
    packet: &ControlPacket,
    numbers: PerTeam<u8>,
    robots: &[RobotId],
    rules: &Rules,
    half_before: u32,
) -> Option<OutsideReferee> {
    let place = |team: Team| packet.teams.iter().position(|there| there.number == numbers[team]);
    let places = PerTeam { blue: place(Team::Blue)?, pink: place(Team::Pink)? };
    let penalty = |robot: &RobotId| {
        let player = packet.teams[places[robot.team]].players.get(usize::from(robot.number).checked_sub(1)?)?;
        let reason = packet.version.penalty_reason(player.penalty)?;
        Some((*robot, reason, f32::from(player.seconds_left)))
    };
    let score = |team: Team| u32::from(packet.teams[places[team]].score);
    Some(OutsideReferee {
        state: state(packet, rules),
        is_stopped: packet.is_stopped,
        half: half(packet, half_before),
        blue_end: if places.blue == 0 { End::NegativeX } else { End::PositiveX },
        score: Score { blue: score(Team::Blue), pink: score(Team::Pink) },
        kicking_team: Team::BOTH.into_iter().find(|team| packet.kicking_team == Some(numbers[*team])),
        set_play: packet.set_play,
        time_left_s: f32::from(packet.seconds_left),
        secondary_time_left_s: f32::from(packet.secondary_seconds_left),
        penalties: robots.iter().filter_map(penalty).collect(),
    })
}

/// The players that the match does not have, but that play in a packet in which robots of their team are substitutes.
fn absent_substitutes(packet: &ControlPacket, numbers: PerTeam<u8>, robots: &[RobotId]) -> Vec<RobotId> {
    let mut absent = Vec::new();
    for team in Team::BOTH {
        let Some(there) = packet.teams.iter().find(|there| there.number == numbers[team]) else { continue };
        let players = (1..).zip(&there.players).map(|(number, player)| (RobotId::new(team, number), player.penalty));
        let is_out = |penalty: u8| packet.version.penalty_reason(penalty) == Some(PenaltyReason::Substitute);
        if players.clone().any(|(robot, penalty)| is_out(penalty) && robots.contains(&robot)) {
            let plays = players.filter(|(robot, penalty)| *penalty == 0 && !robots.contains(robot));
            absent.extend(plays.map(|(robot, _)| robot));
        }
    }
    absent
}

/// The half in a packet, from 1; those of extra time are 3 and 4. A packet in a time-out does not say whether there is extra time: it is in
/// that of the `half_before`.
fn half(packet: &ControlPacket, half_before: u32) -> u32 {
    let is_extra = packet.phase == GamePhase::ExtraTime || (packet.phase == GamePhase::Timeout && half_before > 2);
    let before = if is_extra { 2 } else { 0 };
    before + if packet.is_first_half { 1 } else { 2 }
}

/// The state of the game in a packet. A GameController calls the end of each half and of each shot finished, but a match is finished only
/// when nothing can follow.
fn state(packet: &ControlPacket, rules: &Rules) -> GameState {
    match packet.state {
        GameState::Finished if !is_last(packet, rules) => GameState::Initial,
        state => state,
    }
}

/// Whether the match of a packet in `finished` is over. After the second half of a drawn match extra time or a shoot-out follows if it is a
/// knockout match. Only packets of version 18 tell that; of others the rules decide.
fn is_last(packet: &ControlPacket, rules: &Rules) -> bool {
    let [left, right] = &packet.teams;
    let lead = left.score.abs_diff(right.score);
    if packet.phase == GamePhase::ShootOut {
        let (leader, other) = if left.score > right.score { (left, right) } else { (right, left) };
        let shots = rules.shoot_out_shots.max(u32::from(leader.shots));
        return u32::from(lead) > shots.saturating_sub(u32::from(other.shots));
    }
    let needs_winner = match packet.version {
        ProtocolVersion::V18 => packet.is_knockout,
        _ => rules.shoot_out || rules.extra_time_halves > 0,
    };
    let goes_on = packet.is_first_half || (lead == 0 && needs_winner);
    !goes_on
}

#[cfg(test)]
mod tests {
    use super::super::division::Division;
    use super::super::packet::{PlayerPacket, TeamPacket};
    use super::*;

    fn packet() -> ControlPacket {
        let team = |number, score| TeamPacket { number, score, ..TeamPacket::default() };
        let mut teams = [team(12, 2), team(5, 1)];
        teams[1].players = [PlayerPacket::default(); MOST_PLAYERS];
        teams[1].players[1] = PlayerPacket { penalty: 9, seconds_left: 12, ..PlayerPacket::default() };
        ControlPacket {
            version: ProtocolVersion::V19,
            for_monitors: true,
            packet_number: 0,
            players_per_team: 3,
            is_knockout: false,
            division: Division::Small,
            is_stopped: false,
            phase: GamePhase::Normal,
            state: GameState::Finished,
            set_play: None,
            is_first_half: true,
            kicking_team: Some(5),
            seconds_left: -2,
            secondary_seconds_left: 0,
            teams,
        }
    }

    #[test]
    fn a_packet_is_read_from_the_side_of_the_match() {
        let robots = [RobotId::new(Team::Blue, 2), RobotId::new(Team::Pink, 2)];
        let (numbers, rules) = (PerTeam { blue: 5, pink: 12 }, Rules::default());
        let said = directions(&packet(), numbers, &robots, &rules, 1).unwrap();
        // Blue is named second, so it defends the other goal.
        assert_eq!((said.blue_end, said.score), (End::PositiveX, Score { blue: 1, pink: 2 }));
        assert_eq!(said.penalties, [(robots[0], PenaltyReason::Pushing, 12.0)]);
        assert_eq!((said.kicking_team, said.state, said.half), (Some(Team::Blue), GameState::Initial, 1));
        let of_half = |phase, before| {
            [true, false].map(|is_first_half| half(&ControlPacket { phase, is_first_half, ..packet() }, before))
        };
        assert_eq!(of_half(GamePhase::Normal, 4), [1, 2]);
        assert_eq!(of_half(GamePhase::ExtraTime, 2), [3, 4]);
        assert_eq!([2, 3].map(|before| of_half(GamePhase::Timeout, before)), [[1, 2], [3, 4]]);
        let second_half = ControlPacket { is_first_half: false, ..packet() };
        assert_eq!(directions(&second_half, numbers, &robots, &rules, 1).unwrap().state, GameState::Finished);
        assert_eq!(directions(&packet(), PerTeam { blue: 5, pink: 6 }, &robots, &rules, 1), None);
        assert_eq!(numbers_in(&packet()), PerTeam { blue: 12, pink: 5 });
    }

    #[test]
    fn a_substitute_that_the_match_does_not_have_is_noticed() {
        let (robots, numbers) =
            ([1, 2, 3].map(|number| RobotId::new(Team::Blue, number)), PerTeam { blue: 5, pink: 12 });
        let mut told = packet();
        let out = PlayerPacket { penalty: told.version.substitute_code(), ..PlayerPacket::default() };
        for team in &mut told.teams {
            team.players = [out; MOST_PLAYERS];
            team.players[..3].fill(PlayerPacket::default());
        }
        assert_eq!(absent_substitutes(&told, numbers, &robots), []);
        // Number 4 comes on for number 3.
        told.teams[1].players[2] = out;
        told.teams[1].players[3] = PlayerPacket::default();
        assert_eq!(absent_substitutes(&told, numbers, &robots), [RobotId::new(Team::Blue, 4)]);
    }

    #[test]
    fn a_match_is_finished_when_neither_extra_time_nor_a_shot_can_follow() {
        let rules = Rules { shoot_out_shots: 3, ..Rules::default() };
        let version = ProtocolVersion::V18;
        let of = |phase, is_first_half, is_knockout, of_teams: [(u8, u8); 2]| {
            let teams = of_teams.map(|(score, shots)| TeamPacket { score, shots, ..TeamPacket::default() });
            state(&ControlPacket { version, phase, is_first_half, is_knockout, teams, ..packet() }, &rules)
        };
        let (over, goes_on) = (GameState::Finished, GameState::Initial);
        for phase in [GamePhase::Normal, GamePhase::ExtraTime] {
            assert_eq!(of(phase, true, false, [(1, 0), (0, 0)]), goes_on);
            assert_eq!(of(phase, false, false, [(1, 0), (1, 0)]), over);
            assert_eq!(of(phase, false, true, [(1, 0), (1, 0)]), goes_on);
            assert_eq!(of(phase, false, true, [(1, 0), (2, 0)]), over);
        }
        let shots = |of_teams| of(GamePhase::ShootOut, false, true, of_teams);
        // Level, one shot each, and a lead that can be made up for.
        assert_eq!(shots([(2, 1), (1, 1)]), goes_on);
        assert_eq!(shots([(3, 2), (1, 2)]), over);
        assert_eq!(shots([(3, 3), (2, 2)]), goes_on);
        // Sudden death.
        assert_eq!(shots([(3, 4), (3, 4)]), goes_on);
        assert_eq!(shots([(4, 5), (3, 4)]), goes_on);
        assert_eq!(shots([(4, 5), (3, 5)]), over);
        // Later versions do not tell whether it is a knockout match.
        let drawn = ControlPacket { is_first_half: false, teams: Default::default(), ..packet() };
        assert_eq!(state(&drawn, &rules), over);
        assert_eq!(state(&drawn, &Rules { shoot_out: true, ..rules }), goes_on);
    }
}

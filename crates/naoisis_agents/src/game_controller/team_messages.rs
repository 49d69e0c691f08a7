//! Team messages over UDP, for programs that send them as on a field. Each team has one port. A message that arrives there is delivered to
//! the team-mates like any other message of the match, with its delays and losses, and counts as one message.
//!
//! On a field, a robot is identified by its address. Here all robots are on one machine, so each has [its own address](robot_address). Its
//! program binds this address, sends to [`HERE`], and receives from there the messages of its team-mates. A program that sends from another
//! address is known by its process, if the match has started it. A datagram belongs to the cycle that waits for the program when it
//! arrives; there is one per cycle. Datagrams that are lost are reported.

use bevy::prelude::*;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};

use super::complaints::Complaints;
use super::senders::{Sender, Senders};
use super::sockets::{HERE, NetworkError, bind, robot_address, robot_at};
use crate::agents::{AgentPlayer, LeagueNumbers};
use naoisis_core::behaviour::Remote;
use naoisis_core::communication::{Datagram, Inbox, Outbox};
use naoisis_core::events::{CommandKind, CycleEvents, MatchEvent, Refusal};
use naoisis_core::robot::Roster;
use naoisis_core::team::{PerTeam, RobotId, Team};

/// The port of team 0; the number of a team is added to it.
const FIRST_PORT: u16 = 10_000;
/// The broadcast address of this machine.
const BROADCAST: Ipv4Addr = Ipv4Addr::new(127, 255, 255, 255);
/// The greatest number of datagrams of a team that are read in a cycle. Further ones wait.
const MOST_DATAGRAMS: usize = 256;
/// The largest datagram of UDP, bytes.
const MOST_BYTES: usize = 65_507;

/// Carries the teams' messages over UDP.
#[derive(Resource, Debug)]
pub struct TeamMessages {
    sockets: PerTeam<UdpSocket>,
    /// Sockets that notice datagrams to the broadcast address of this machine, where the system has them.
    broadcasts: PerTeam<Option<UdpSocket>>,
    team_numbers: PerTeam<u8>,
    port_offset: u16,
    /// The programs that send from other addresses than those of their robots.
    senders: Senders,
    /// Messages about datagrams that are lost, as events and for the user.
    complaints: Complaints,
}

impl TeamMessages {
    /// Opens one socket per team.
    ///
    /// # Errors
    /// If a socket cannot be opened, for example because another program uses the port.
    pub fn open(team_numbers: PerTeam<u8>, port_offset: u16) -> Result<Self, NetworkError> {
        let open = |team| {
            let socket = bind(SocketAddrV4::new(HERE, port(team_numbers[team], port_offset)).into())?;
            share_with_programs(&socket);
            Ok(socket)
        };
        let sockets = PerTeam { blue: open(Team::Blue)?, pink: open(Team::Pink)? };
        let notice = |team| {
            let place = SocketAddrV4::new(BROADCAST, port(team_numbers[team], port_offset));
            bind(place.into()).ok().inspect(share_with_programs)
        };
        let broadcasts = PerTeam { blue: notice(Team::Blue), pink: notice(Team::Pink) };
        let (senders, complaints) = (Senders::default(), Complaints::default());
        Ok(Self { sockets, broadcasts, team_numbers, port_offset, senders, complaints })
    }

    /// Adds a function that receives messages about datagrams that are lost.
    #[must_use]
    pub fn with_notes(mut self, notes: impl Fn(&str) + Send + Sync + 'static) -> Self {
        self.complaints.notes = Some(Box::new(notes));
        self
    }

    /// The numbers of the teams and the port offset, for programs.
    pub(super) fn numbers_for_programs(&self) -> LeagueNumbers {
        LeagueNumbers { team_numbers: Some(self.team_numbers), port_offset: self.port_offset }
    }

    /// The datagrams that have arrived, with their senders, in the order of arrival. `programs` are the robots with the process groups of
    /// their programs.
    fn take(&mut self, programs: &[(RobotId, u32)]) -> Vec<(RobotId, Datagram)> {
        let mut bytes = [0; MOST_BYTES];
        let mut taken = Vec::new();
        for team in Team::BOTH {
            self.notice_broadcasts(team, &mut bytes);
            for _ in 0..MOST_DATAGRAMS {
                let Ok((length, from)) = self.sockets[team].recv_from(&mut bytes) else { break };
                let robot = sender(from, team, self.team_numbers[team]);
                if let Some(robot) = robot.or_else(|| self.stranger(from, team, programs)) {
                    taken.push((robot, Datagram(bytes[..length].to_vec())));
                }
            }
        }
        taken
    }

    /// Reports datagrams to the broadcast address: programs hear them past the match, without its delays and losses.
    fn notice_broadcasts(&mut self, team: Team, bytes: &mut [u8]) {
        let Some(socket) = &self.broadcasts[team] else { return };
        if (0..MOST_DATAGRAMS).map_while(|_| socket.recv_from(bytes).ok()).count() > 0 {
            let port = port(self.team_numbers[team], self.port_offset);
            self.complaints.add(format!(
                "datagrams to {BROADCAST}, port {port}, do not come to the match: only programs that listen at any address hear them; \
                 expected the address {HERE}"
            ));
        }
    }

    /// The robot of `team` whose program sent a datagram from another address than the robot's. A datagram of nobody is reported once.
    fn stranger(&mut self, from: SocketAddr, team: Team, programs: &[(RobotId, u32)]) -> Option<RobotId> {
        let number = self.team_numbers[team];
        let (ip, port) = (from.ip(), port(number, self.port_offset));
        let expected = format!("expected the address 127.1.{number}.N of robot N");
        let message = match self.senders.find(from, programs) {
            Sender::Robot(robot) if robot.team == team => return Some(robot),
            Sender::Robot(robot) => {
                format!("datagrams of {robot} to port {port} are lost: it is the port of team {number}")
            }
            Sender::Several(robots) => format!(
                "datagrams from {from} to port {port} are lost, because the programs of {} share this address; {expected}",
                in_words(&robots)
            ),
            Sender::Unknown => {
                format!("datagrams from {ip} to port {port} are lost, because they are from no robot; {expected}")
            }
        };
        self.complaints.add(message);
        None
    }

    /// Sends a robot the message of a team-mate. Ignores a program that is gone.
    fn send(&mut self, to: RobotId, datagram: &Datagram, programs: &[(RobotId, u32)]) {
        let number = self.team_numbers[to.team];
        let place = SocketAddrV4::new(robot_address(number, to.number), port(number, self.port_offset));
        // What is sent to an address at which nobody listens reaches a program that listens at any address.
        match self.senders.listeners(place.into(), programs).as_slice() {
            [] => {}
            [listener] if *listener == to => {}
            [_] => return,
            several => {
                let several = in_words(several);
                self.complaints.add(format!(
                    "messages to the programs of {several} are lost, because they share port {}; \
                     expected the address 127.1.{number}.N of robot N",
                    place.port()
                ));
                return;
            }
        }
        let _ = self.sockets[to.team].send_to(&datagram.0, place);
    }
}

/// Lets programs bind the port of `socket` at other addresses, even at all (`0.0.0.0`) if they set `SO_REUSEADDR`. Another match cannot, as
/// it binds without.
fn share_with_programs(socket: &UdpSocket) {
    // Without it, those programs are refused by the system.
    #[cfg(unix)]
    let _ = rustix::net::sockopt::set_socket_reuseaddr(socket, true);
    #[cfg(not(unix))]
    let _ = socket;
}

fn in_words(robots: &[RobotId]) -> String {
    robots.iter().map(RobotId::to_string).collect::<Vec<_>>().join(", ")
}

/// The robot that sent a datagram from `from` to the port of `team`; `None` for any other address.
fn sender(from: SocketAddr, team: Team, team_number: u8) -> Option<RobotId> {
    robot_at(from.ip()).filter(|(there, _)| *there == team_number).map(|(_, number)| RobotId::new(team, number))
}

fn port(team_number: u8, port_offset: u16) -> u16 {
    FIRST_PORT.saturating_add(u16::from(team_number)).saturating_add(port_offset)
}

/// The robots that programs play which the match has started, with the process groups of these programs.
type Programs<'w, 's> = Query<'w, 's, (&'static RobotId, &'static AgentPlayer)>;

fn process_groups(programs: &Programs) -> Vec<(RobotId, u32)> {
    programs.iter().filter_map(|(id, player)| Some((*id, player.process_group()?))).collect()
}

/// Sends the messages that arrived in this cycle to programs, before they are asked.
pub(super) fn hand_out(
    mut messages: ResMut<TeamMessages>,
    roster: Res<Roster>,
    inboxes: Query<&Inbox, With<Remote>>,
    programs: Programs,
) {
    let programs = process_groups(&programs);
    for (to, robot) in roster.iter() {
        let Ok(inbox) = inboxes.get(robot) else { continue };
        for datagram in inbox.0.iter().filter_map(|message| message.say.datagram.as_ref()) {
            messages.send(to, datagram, &programs);
        }
    }
}

/// Reads the datagrams that programs have sent before their answers, the first of each robot. If the command of a robot also has a message,
/// both are joined.
pub(super) fn take(
    mut messages: ResMut<TeamMessages>,
    roster: Res<Roster>,
    mut events: ResMut<CycleEvents>,
    mut outboxes: Query<&mut Outbox, With<Remote>>,
    programs: Programs,
) {
    let mut refused = Vec::new();
    for (robot, datagram) in messages.take(&process_groups(&programs)) {
        let Some(mut outbox) = roster.get(robot).and_then(|entity| outboxes.get_mut(entity).ok()) else {
            let address = robot_address(messages.team_numbers[robot.team], robot.number);
            let why = if roster.get(robot).is_some() { "no program plays it" } else { "it is not in the match" };
            messages.complaints.add(format!("datagrams from {address}, the address of {robot}, are lost: {why}"));
            continue;
        };
        let say = outbox.0.get_or_insert_default();
        if say.datagram.is_none() {
            say.datagram = Some(datagram);
        } else if !refused.contains(&robot) {
            refused.push(robot);
        }
    }
    messages.complaints.publish(&mut events);
    refused.sort();
    let event = |robot| MatchEvent::CommandRefused { robot, command: CommandKind::Say, reason: Refusal::NotAllowed };
    events.extend(refused.into_iter().map(event));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_is_known_by_its_address() {
        let from = |address: &str| sender(address.parse().unwrap(), Team::Pink, 12);
        assert_eq!(robot_address(12, 3).to_string(), "127.1.12.3");
        assert_eq!(from("127.1.12.3:10012"), Some(RobotId::new(Team::Pink, 3)));
        // Addresses of the other team, of no robot, and on a network.
        for address in ["127.1.5.3:10012", "127.0.0.1:10012", "10.1.12.3:10012", "[::1]:10012"] {
            assert_eq!(from(address), None, "{address}");
        }
        assert_eq!((port(12, 0), port(254, 55_000)), (10_012, 65_254));
    }
}

//! Team messages over UDP, for programs that send them as on a field. Each team has one port. A message that arrives there is delivered to
//! the team-mates like any other message of the match, with its delays and losses, and counts as one message.
//!
//! On a field, a robot is identified by its address. Here all robots are on one machine, so each has [its own address](robot_address). Its
//! program binds this address, sends to [`HERE`], and receives from there the messages of its team-mates. A datagram belongs to the cycle
//! that waits for the program when it arrives; there is one per cycle.

use bevy::prelude::*;
use std::net::{SocketAddr, SocketAddrV4, UdpSocket};

use super::sockets::{HERE, NetworkError, bind, robot_address, robot_at};
use naoisis_core::behaviour::Remote;
use naoisis_core::communication::{Datagram, Inbox, Outbox};
use naoisis_core::events::{CommandKind, CycleEvents, MatchEvent, Refusal};
use naoisis_core::robot::Roster;
use naoisis_core::team::{PerTeam, RobotId, Team};

/// The port of team 0; the number of a team is added to it.
const FIRST_PORT: u16 = 10_000;
/// The greatest number of datagrams of a team that are read in a cycle. Further ones wait.
const MOST_DATAGRAMS: usize = 256;
/// The largest datagram of UDP, bytes.
const MOST_BYTES: usize = 65_507;

/// Carries the teams' messages over UDP.
#[derive(Resource, Debug)]
pub struct TeamMessages {
    sockets: PerTeam<UdpSocket>,
    team_numbers: PerTeam<u8>,
    port_offset: u16,
}

impl TeamMessages {
    /// Opens one socket per team.
    ///
    /// # Errors
    /// If a socket cannot be opened, for example because another program uses the port.
    pub fn open(team_numbers: PerTeam<u8>, port_offset: u16) -> Result<Self, NetworkError> {
        let open = |team| bind(SocketAddrV4::new(HERE, port(team_numbers[team], port_offset)).into());
        let sockets = PerTeam { blue: open(Team::Blue)?, pink: open(Team::Pink)? };
        Ok(Self { sockets, team_numbers, port_offset })
    }

    /// The datagrams that have arrived, with their senders, in the order of arrival.
    fn take(&self) -> Vec<(RobotId, Datagram)> {
        let mut bytes = [0; MOST_BYTES];
        let mut taken = Vec::new();
        for team in Team::BOTH {
            for _ in 0..MOST_DATAGRAMS {
                let Ok((length, from)) = self.sockets[team].recv_from(&mut bytes) else { break };
                if let Some(robot) = sender(from, team, self.team_numbers[team]) {
                    taken.push((robot, Datagram(bytes[..length].to_vec())));
                }
            }
        }
        taken
    }

    /// Sends a robot the message of a team-mate. Ignores a program that is gone.
    fn send(&self, to: RobotId, datagram: &Datagram) {
        let number = self.team_numbers[to.team];
        let place = SocketAddrV4::new(robot_address(number, to.number), port(number, self.port_offset));
        let _ = self.sockets[to.team].send_to(&datagram.0, place);
    }
}

/// The robot that sent a datagram from `from` to the port of `team`; `None` for any other address.
fn sender(from: SocketAddr, team: Team, team_number: u8) -> Option<RobotId> {
    robot_at(from.ip()).filter(|(there, _)| *there == team_number).map(|(_, number)| RobotId::new(team, number))
}

fn port(team_number: u8, port_offset: u16) -> u16 {
    FIRST_PORT.saturating_add(u16::from(team_number)).saturating_add(port_offset)
}

/// Sends the messages that arrived in this cycle to programs, before they are asked.
pub(super) fn hand_out(messages: Res<TeamMessages>, roster: Res<Roster>, inboxes: Query<&Inbox, With<Remote>>) {
    for (to, robot) in roster.iter() {
        let Ok(inbox) = inboxes.get(robot) else { continue };
        for datagram in inbox.0.iter().filter_map(|message| message.say.datagram.as_ref()) {
            messages.send(to, datagram);
        }
    }
}

/// Reads the datagrams that programs have sent before their answers, the first of each robot. If the command of a robot also has a message,
/// both are joined.
pub(super) fn take(
    messages: Res<TeamMessages>,
    roster: Res<Roster>,
    mut events: ResMut<CycleEvents>,
    mut outboxes: Query<&mut Outbox, With<Remote>>,
) {
    let mut refused = Vec::new();
    for (robot, datagram) in messages.take() {
        let Some(mut outbox) = roster.get(robot).and_then(|entity| outboxes.get_mut(entity).ok()) else { continue };
        let say = outbox.0.get_or_insert_default();
        if say.datagram.is_none() {
            say.datagram = Some(datagram);
        } else if !refused.contains(&robot) {
            refused.push(robot);
        }
    }
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

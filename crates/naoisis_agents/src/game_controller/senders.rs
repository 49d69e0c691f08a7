//! Finds the robot whose program sent a datagram from an address that is not the robot's own, by the process that owns the socket.
//!
//! This works on Linux, and only for programs that the match has started. Elsewhere no such sender is found.

use std::collections::BTreeMap;
use std::fs;
use std::net::SocketAddr;

use naoisis_core::team::RobotId;

/// The robot that sent a datagram.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Sender {
    /// The program of this robot.
    Robot(RobotId),
    /// One of these, whose programs share an address and a port.
    Several(Vec<RobotId>),
    /// Another program.
    Unknown,
}

/// The sockets of programs, as far as they are known.
#[derive(Debug, Default)]
pub struct Senders {
    /// The robots whose programs own sockets, by the numbers of the sockets in the system.
    owners: BTreeMap<u64, Option<RobotId>>,
}

impl Senders {
    /// The robot whose program has sent a datagram from `from`; `programs` are the robots with the process groups of their programs.
    pub fn find(&mut self, from: SocketAddr, programs: &[(RobotId, u32)]) -> Sender {
        let sockets: Vec<u64> = sockets_at(from).into_iter().map(|socket| socket.number).collect();
        match self.owners(&sockets, programs).as_slice() {
            [] => Sender::Unknown,
            [robot] => Sender::Robot(*robot),
            robots => Sender::Several(robots.to_vec()),
        }
    }

    /// The robots whose programs listen at any address of the port of `to`. Empty if something listens at this very address, which then
    /// receives what is sent there.
    pub fn listeners(&mut self, to: SocketAddr, programs: &[(RobotId, u32)]) -> Vec<RobotId> {
        let sockets = sockets_at(to);
        if sockets.iter().any(|socket| !socket.at_any_address) {
            return Vec::new();
        }
        let sockets: Vec<u64> = sockets.into_iter().map(|socket| socket.number).collect();
        self.owners(&sockets, programs)
    }

    /// The robots whose programs own these sockets, in order.
    fn owners(&mut self, sockets: &[u64], programs: &[(RobotId, u32)]) -> Vec<RobotId> {
        if sockets.iter().any(|socket| !self.owners.contains_key(socket)) {
            let of_processes = owned_sockets(programs);
            self.owners.extend(sockets.iter().map(|socket| (*socket, of_processes.get(socket).copied())));
        }
        let mut robots: Vec<RobotId> = sockets.iter().filter_map(|socket| self.owners[socket]).collect();
        robots.sort();
        robots.dedup();
        robots
    }
}

/// A UDP socket of this machine.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Socket {
    /// Its number in the system.
    number: u64,
    /// Whether it is bound to a port only, not to an address.
    at_any_address: bool,
}

/// The sockets that are bound to an address and port.
fn sockets_at(place: SocketAddr) -> Vec<Socket> {
    let tables = ["/proc/net/udp", "/proc/net/udp6"].into_iter().filter_map(|table| fs::read_to_string(table).ok());
    tables.flat_map(|table| sockets_in(&table, place)).collect()
}

/// The sockets in a table of the system that are bound to an address and port.
fn sockets_in(table: &str, place: SocketAddr) -> Vec<Socket> {
    let rows = table.lines().skip(1).map(|row| row.split_ascii_whitespace().collect::<Vec<_>>());
    let socket = |row: Vec<&str>| {
        let (address, port) = row.get(1)?.split_once(':')?;
        let at_any_address = address.bytes().all(|digit| digit == b'0');
        // The end of an IPv6 address is the IPv4 address that it stands for.
        let is_this = match place {
            SocketAddr::V4(place) => address.ends_with(&format!("{:08X}", u32::from_ne_bytes(place.ip().octets()))),
            SocketAddr::V6(_) => false,
        };
        let is_there = u16::from_str_radix(port, 16) == Ok(place.port()) && (at_any_address || is_this);
        is_there.then_some(Socket { number: row.get(9)?.parse().ok()?, at_any_address })
    };
    rows.filter_map(socket).collect()
}

/// The sockets of all processes in the groups of programs.
fn owned_sockets(programs: &[(RobotId, u32)]) -> BTreeMap<u64, RobotId> {
    let mut owned = BTreeMap::new();
    for process in fs::read_dir("/proc").into_iter().flatten().flatten() {
        let Ok(status) = fs::read_to_string(process.path().join("stat")) else { continue };
        // The name of the program is in parentheses and may contain anything; state, parent and group follow.
        let group = status.rsplit_once(')').and_then(|(_, rest)| rest.split_ascii_whitespace().nth(2)?.parse().ok());
        let Some((robot, _)) = programs.iter().find(|(_, of_program)| Some(*of_program) == group) else { continue };
        for file in fs::read_dir(process.path().join("fd")).into_iter().flatten().flatten() {
            let target = fs::read_link(file.path()).ok();
            let socket =
                target.as_ref().and_then(|target| target.to_str()?.strip_prefix("socket:[")?.strip_suffix(']'));
            owned.extend(socket.and_then(|number| number.parse::<u64>().ok()).map(|number| (number, *robot)));
        }
    }
    owned
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref pointer drops
 1000: 00000000:2715 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 100 2 0 0
 1001: 0100007F:2715 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 101 2 0 0
 1002: 0200007F:2715 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 102 2 0 0
 1003: 00000000:2716 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 103 2 0 0
";

    #[test]
    #[cfg(target_endian = "little")]
    fn a_datagram_is_from_a_socket_at_its_address_or_at_any() {
        let at = |place: &str| {
            let sockets = sockets_in(TABLE, place.parse().unwrap());
            sockets.into_iter().map(|socket| (socket.number, socket.at_any_address)).collect::<Vec<_>>()
        };
        assert_eq!(at("127.0.0.1:10005"), [(100, true), (101, false)]);
        assert_eq!(at("127.0.0.1:10006"), [(103, true)]);
        assert_eq!(at("127.0.0.1:10007"), []);
    }
}

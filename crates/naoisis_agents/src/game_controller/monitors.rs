//! Monitors: who is told the truth. They ask for it at a port of the match, and are told at ports of their own.
//!
//! Whoever reaches the port can ask, a program that plays as well: it is open only in a match that is to tell monitors the truth.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};

use super::packet::ControlPacket;
use super::sockets::{CONTROL_PORT, FORWARD_PORT, NetworkError, REQUEST, bind, place, robot_at};

/// So many requests are taken in a cycle: who sends more waits.
const MOST_REQUESTS: usize = 256;
/// So many monitors are told.
const MOST_MONITORS: usize = 16;

/// Who has asked for the truth.
#[derive(Debug)]
pub(super) struct Monitors {
    requests: UdpSocket,
    port_offset: u16,
    hosts: Vec<IpAddr>,
    /// Hosts that are robots: they are not told the truth.
    robots: BTreeSet<IpAddr>,
}

impl Monitors {
    /// Hears requests at this address.
    ///
    /// # Errors
    /// When that cannot be done, such as where somebody else does.
    pub fn open(requests: SocketAddr, port_offset: u16) -> Result<Self, NetworkError> {
        Ok(Self { requests: bind(requests)?, port_offset, hosts: Vec::new(), robots: BTreeSet::new() })
    }

    /// Lets in who has asked. Whether somebody is there who is to be told.
    pub fn let_in(&mut self) -> bool {
        let mut bytes = [0; REQUEST.len() + 1];
        for _ in 0..MOST_REQUESTS {
            let Ok((length, from)) = self.requests.recv_from(&mut bytes) else { break };
            let host = from.ip();
            let is_robot = robot_at(host).is_some() || self.robots.contains(&host);
            let is_new = !is_robot && !self.hosts.contains(&host);
            if bytes[..length] == REQUEST && is_new && self.hosts.len() < MOST_MONITORS {
                self.hosts.push(host);
            }
        }
        !self.hosts.is_empty()
    }

    /// A robot is at this host: it is told the truth no more.
    pub fn shut_out(&mut self, host: IpAddr) {
        if self.robots.insert(host) {
            self.hosts.retain(|monitor| *monitor != host);
        }
    }

    /// Tells how the match is, but for hosts that hear no control packets. Nobody need be there.
    pub fn tell(&self, packet: &ControlPacket, hears: impl Fn(IpAddr) -> bool) {
        let bytes = packet.to_bytes();
        for host in self.hosts.iter().filter(|host| hears(**host)) {
            let _ = self.requests.send_to(&bytes, place(*host, CONTROL_PORT, self.port_offset));
        }
    }

    /// Passes on a report of the robot at this address. Nobody need be there.
    pub fn forward(&self, robot: Ipv4Addr, report: &[u8]) {
        let forwarded = [&robot.octets()[..], report].concat();
        for host in &self.hosts {
            let _ = self.requests.send_to(&forwarded, place(*host, FORWARD_PORT, self.port_offset));
        }
    }
}

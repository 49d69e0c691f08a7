//! Monitors: programs that receive the true state. They request it at a port of the match, and receive it at ports of
//! their own.
//!
//! Any program that reaches the port can request it, also one that plays. The port is open only if the settings allow
//! monitors.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};

use super::packet::ControlPacket;
use super::sockets::{CONTROL_PORT, FORWARD_PORT, NetworkError, REQUEST, bind, place, robot_at};

/// The greatest number of requests that are read in a cycle. Further ones wait.
const MOST_REQUESTS: usize = 256;
/// The greatest number of monitors that receive packets.
const MOST_MONITORS: usize = 16;

/// The hosts that have requested the true state.
#[derive(Debug)]
pub(super) struct Monitors {
    requests: UdpSocket,
    port_offset: u16,
    hosts: Vec<IpAddr>,
    /// Hosts of robots, which do not receive the true state.
    robots: BTreeSet<IpAddr>,
}

impl Monitors {
    /// Listens for requests at an address.
    ///
    /// # Errors
    /// If the system refuses, for example because another program listens there.
    pub fn open(requests: SocketAddr, port_offset: u16) -> Result<Self, NetworkError> {
        Ok(Self { requests: bind(requests)?, port_offset, hosts: Vec::new(), robots: BTreeSet::new() })
    }

    /// Reads requests. Returns whether there is a monitor.
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

    /// Stops sending to `host`, because it is a robot.
    pub fn shut_out(&mut self, host: IpAddr) {
        if self.robots.insert(host) {
            self.hosts.retain(|monitor| *monitor != host);
        }
    }

    /// Sends the state of the game, except to hosts for which `hears` returns true. Ignores monitors that are gone.
    pub fn tell(&self, packet: &ControlPacket, hears: impl Fn(IpAddr) -> bool) {
        let bytes = packet.to_bytes();
        for host in self.hosts.iter().filter(|host| hears(**host)) {
            let _ = self.requests.send_to(&bytes, place(*host, CONTROL_PORT, self.port_offset));
        }
    }

    /// Forwards a report of the robot at address `robot`. Ignores monitors that are gone.
    pub fn forward(&self, robot: Ipv4Addr, report: &[u8]) {
        let forwarded = [&robot.octets()[..], report].concat();
        for host in &self.hosts {
            let _ = self.requests.send_to(&forwarded, place(*host, FORWARD_PORT, self.port_offset));
        }
    }
}

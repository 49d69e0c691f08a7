//! The sockets of a GameController: packets to robots and monitors, reports from robots, requests from monitors.
//!
//! Whoever is on this machine gets a packet before it is asked for its next decision, and what it has reported is there when its
//! decision is: with programs in lock-step on one machine, a match with a GameController is the same however slow they are.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

use super::packet::ControlPacket;
use super::report::{REPORT_BYTES, ReturnPacket};

/// Where control packets go.
pub(super) const CONTROL_PORT: u16 = 3838;
/// Where robots send their reports.
pub(super) const REPORT_PORT: u16 = 3939;
/// Where monitors ask for the truth.
pub(super) const REQUEST_PORT: u16 = 3636;
/// Where monitors are sent the robots' reports.
const FORWARD_PORT: u16 = 3940;
/// What a monitor sends.
pub(super) const REQUEST: [u8; 5] = *b"RGTr\0";
/// So many packets are taken in a cycle: who sends more waits.
const MOST_PACKETS: usize = 256;
/// So many monitors are told.
const MOST_MONITORS: usize = 16;

/// Where a GameController sends, and what is added to its ports.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NetworkSettings {
    /// Where control packets go: a robot's address, or one at which all are reached.
    pub address: IpAddr,
    /// What is added to every port, so that several matches can be played on one machine.
    pub port_offset: u16,
}

impl Default for NetworkSettings {
    fn default() -> Self {
        Self { address: Ipv4Addr::LOCALHOST.into(), port_offset: 0 }
    }
}

impl NetworkSettings {
    /// Where control packets go.
    pub fn control(&self) -> SocketAddr {
        self.at(self.address, CONTROL_PORT)
    }

    /// Where robots are heard: on the network only if the packets go there.
    pub fn reports(&self) -> SocketAddr {
        self.at(self.here(), REPORT_PORT)
    }

    /// Where monitors are heard.
    pub fn requests(&self) -> SocketAddr {
        self.at(self.here(), REQUEST_PORT)
    }

    fn here(&self) -> IpAddr {
        match self.address {
            IpAddr::V4(address) if address.is_loopback() => Ipv4Addr::LOCALHOST.into(),
            IpAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            IpAddr::V6(address) if address.is_loopback() => Ipv6Addr::LOCALHOST.into(),
            IpAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        }
    }

    fn at(&self, address: IpAddr, port: u16) -> SocketAddr {
        SocketAddr::new(address, port.saturating_add(self.port_offset))
    }
}

/// A socket that cannot be opened.
#[derive(Debug, thiserror::Error)]
#[error("{address}: {error}")]
pub struct NetworkError {
    /// The address that was asked for.
    pub address: SocketAddr,
    /// What the system says.
    pub error: io::Error,
}

/// The sockets of a GameController.
#[derive(Debug)]
pub struct Network {
    settings: NetworkSettings,
    reports: UdpSocket,
    requests: UdpSocket,
    monitors: Vec<IpAddr>,
    /// Hosts that have reported, and so are robots: robots are not told the truth.
    robots: Vec<IpAddr>,
}

impl Network {
    /// Opens the sockets.
    ///
    /// # Errors
    /// When one cannot be opened, such as where another GameController is.
    pub fn open(settings: NetworkSettings) -> Result<Self, NetworkError> {
        let (reports, requests) = (bind(settings.reports())?, bind(settings.requests())?);
        let is_broadcast = reports.set_broadcast(true);
        is_broadcast.map_err(|error| NetworkError { address: settings.control(), error })?;
        Ok(Self { settings, reports, requests, monitors: Vec::new(), robots: Vec::new() })
    }

    /// Sends a packet to the robots, or to the monitors. Nobody need be there.
    pub fn send(&self, packet: &ControlPacket) {
        let bytes = packet.to_bytes();
        if packet.for_monitors {
            for monitor in &self.monitors {
                let _ = self.requests.send_to(&bytes, self.settings.at(*monitor, CONTROL_PORT));
            }
        } else {
            let _ = self.reports.send_to(&bytes, self.settings.control());
        }
    }

    /// The reports that have come, at this time, s since the start. Monitors get them, too.
    pub fn take_reports(&mut self, time_s: f64) -> Vec<ReturnPacket> {
        let mut taken = Vec::new();
        // One byte more than a report has, to know what is longer.
        let mut bytes = [0; REPORT_BYTES + 1];
        for _ in 0..MOST_PACKETS {
            let Ok((length, from)) = self.reports.recv_from(&mut bytes) else { break };
            let Ok(packet) = ReturnPacket::from_bytes(&bytes[..length], time_s) else { continue };
            taken.push(packet);
            let host = from.ip();
            if !self.robots.contains(&host) && !host.is_loopback() {
                self.robots.push(host);
                self.monitors.retain(|monitor| *monitor != host);
            }
            if let IpAddr::V4(host) = host {
                let forwarded = [&host.octets()[..], &bytes[..length]].concat();
                for monitor in &self.monitors {
                    let _ = self.requests.send_to(&forwarded, self.settings.at(*monitor, FORWARD_PORT));
                }
            }
        }
        taken
    }

    /// Lets monitors in that have asked. Whether somebody is there who is to be told the truth.
    pub fn has_monitors(&mut self) -> bool {
        let mut bytes = [0; REQUEST.len() + 1];
        for _ in 0..MOST_PACKETS {
            let Ok((length, from)) = self.requests.recv_from(&mut bytes) else { break };
            let host = from.ip();
            let is_new = !self.monitors.contains(&host) && !self.robots.contains(&host);
            if bytes[..length] == REQUEST && is_new && self.monitors.len() < MOST_MONITORS {
                self.monitors.push(host);
            }
        }
        !self.monitors.is_empty()
    }
}

/// A socket that does not wait.
pub(super) fn bind(address: SocketAddr) -> Result<UdpSocket, NetworkError> {
    let socket = UdpSocket::bind(address).and_then(|socket| socket.set_nonblocking(true).map(|()| socket));
    socket.map_err(|error| NetworkError { address, error })
}

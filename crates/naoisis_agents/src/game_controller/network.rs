//! The sockets of a simulated GameController: packets to robots and monitors, reports from robots, requests from
//! monitors.
//!
//! A program on this machine receives a packet before it is asked for its next decision, and its report arrives before its decision. So a
//! match with a GameController and programs in lock-step on one machine does not depend on their speed.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

use super::monitors::Monitors;
use super::packet::ControlPacket;
use super::report::{REPORT_BYTES, ReturnPacket};
use super::sockets::{CONTROL_PORT, NetworkError, REPORT_PORT, REQUEST_PORT, bind, place};

/// The greatest number of packets that are read in a cycle. Further ones wait.
const MOST_PACKETS: usize = 256;

/// The addresses and ports of a simulated GameController.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NetworkSettings {
    /// The address to which control packets are sent: of one robot, or a broadcast address.
    pub address: IpAddr,
    /// Added to every port, so that several matches can be played on one machine.
    pub port_offset: u16,
    /// Whether monitors that ask receive the true state. Any program that asks receives it, including programs that play.
    pub tells_monitors: bool,
}

impl Default for NetworkSettings {
    fn default() -> Self {
        Self { address: Ipv4Addr::LOCALHOST.into(), port_offset: 0, tells_monitors: false }
    }
}

impl NetworkSettings {
    /// The address and port for control packets.
    pub fn control(&self) -> SocketAddr {
        place(self.address, CONTROL_PORT, self.port_offset)
    }

    /// The address and port for reports of robots. It is open to the network only if control packets go there.
    pub fn reports(&self) -> SocketAddr {
        place(self.here(), REPORT_PORT, self.port_offset)
    }

    /// The address and port for requests of monitors.
    pub fn requests(&self) -> SocketAddr {
        place(self.here(), REQUEST_PORT, self.port_offset)
    }

    fn here(&self) -> IpAddr {
        match self.address {
            IpAddr::V4(address) if address.is_loopback() => Ipv4Addr::LOCALHOST.into(),
            IpAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            IpAddr::V6(address) if address.is_loopback() => Ipv6Addr::LOCALHOST.into(),
            IpAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        }
    }
}

/// The sockets of a simulated GameController.
#[derive(Debug)]
pub struct Network {
    settings: NetworkSettings,
    reports: UdpSocket,
    /// The sockets for monitors; `None` if monitors are not allowed.
    monitors: Option<Monitors>,
}

impl Network {
    /// Opens the sockets.
    ///
    /// # Errors
    /// If a socket cannot be opened, for example because another GameController uses the port.
    pub fn open(settings: NetworkSettings) -> Result<Self, NetworkError> {
        let reports = bind(settings.reports())?;
        let open = || Monitors::open(settings.requests(), settings.port_offset);
        let monitors = settings.tells_monitors.then(open).transpose()?;
        let is_broadcast = reports.set_broadcast(true);
        is_broadcast.map_err(|error| NetworkError { address: settings.control(), error })?;
        Ok(Self { settings, reports, monitors })
    }

    /// Sends a packet to the robots, or to the monitors. Ignores receivers that are gone.
    pub fn send(&self, packet: &ControlPacket) {
        if packet.for_monitors {
            self.monitors.iter().for_each(|monitors| monitors.tell(packet, |_| true));
        } else {
            let _ = self.reports.send_to(&packet.to_bytes(), self.settings.control());
        }
    }

    /// Returns the reports that have arrived, and forwards them to monitors. `time_s` is the time since the start, s. A host that sends a
    /// report counts as a robot, as for a real GameController, and is no longer a monitor.
    pub fn take_reports(&mut self, time_s: f64) -> Vec<ReturnPacket> {
        let mut taken = Vec::new();
        // One byte more than a report has, to detect longer packets.
        let mut bytes = [0; REPORT_BYTES + 1];
        for _ in 0..MOST_PACKETS {
            let Ok((length, from)) = self.reports.recv_from(&mut bytes) else { break };
            self.monitors.iter_mut().for_each(|monitors| monitors.shut_out(from.ip()));
            let Ok(packet) = ReturnPacket::from_bytes(&bytes[..length], time_s) else { continue };
            taken.push(packet);
            if let (Some(monitors), IpAddr::V4(host)) = (&self.monitors, from.ip()) {
                monitors.forward(host, &bytes[..length]);
            }
        }
        taken
    }

    /// Reads requests of monitors. Returns whether there is a monitor.
    pub fn has_monitors(&mut self) -> bool {
        self.monitors.as_mut().is_some_and(Monitors::let_in)
    }
}

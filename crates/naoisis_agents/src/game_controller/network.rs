//! The sockets of a GameController: packets to robots and monitors, reports from robots, requests from monitors.
//!
//! Whoever is on this machine gets a packet before it is asked for its next decision, and what it has reported is there when its
//! decision is: with programs in lock-step on one machine, a match with a GameController is the same however slow they are.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

use super::monitors::Monitors;
use super::packet::ControlPacket;
use super::report::{REPORT_BYTES, ReturnPacket};
use super::sockets::{CONTROL_PORT, NetworkError, REPORT_PORT, REQUEST_PORT, bind, place};

/// So many packets are taken in a cycle: who sends more waits.
const MOST_PACKETS: usize = 256;

/// Where a GameController sends, and what is added to its ports.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NetworkSettings {
    /// Where control packets go: a robot's address, or one at which all are reached.
    pub address: IpAddr,
    /// What is added to every port, so that several matches can be played on one machine.
    pub port_offset: u16,
    /// Whether monitors that ask are told the truth. So is a program that plays, if it asks: without this nobody can.
    pub tells_monitors: bool,
}

impl Default for NetworkSettings {
    fn default() -> Self {
        Self { address: Ipv4Addr::LOCALHOST.into(), port_offset: 0, tells_monitors: false }
    }
}

impl NetworkSettings {
    /// Where control packets go.
    pub fn control(&self) -> SocketAddr {
        place(self.address, CONTROL_PORT, self.port_offset)
    }

    /// Where robots are heard: on the network only if the packets go there.
    pub fn reports(&self) -> SocketAddr {
        place(self.here(), REPORT_PORT, self.port_offset)
    }

    /// Where monitors are heard.
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

/// The sockets of a GameController.
#[derive(Debug)]
pub struct Network {
    settings: NetworkSettings,
    reports: UdpSocket,
    /// None where nobody is told the truth.
    monitors: Option<Monitors>,
}

impl Network {
    /// Opens the sockets.
    ///
    /// # Errors
    /// When one cannot be opened, such as where another GameController is.
    pub fn open(settings: NetworkSettings) -> Result<Self, NetworkError> {
        let reports = bind(settings.reports())?;
        let open = || Monitors::open(settings.requests(), settings.port_offset);
        let monitors = settings.tells_monitors.then(open).transpose()?;
        let is_broadcast = reports.set_broadcast(true);
        is_broadcast.map_err(|error| NetworkError { address: settings.control(), error })?;
        Ok(Self { settings, reports, monitors })
    }

    /// Sends a packet to the robots, or to the monitors. Nobody need be there.
    pub fn send(&self, packet: &ControlPacket) {
        if packet.for_monitors {
            self.monitors.iter().for_each(|monitors| monitors.tell(packet, |_| true));
        } else {
            let _ = self.reports.send_to(&packet.to_bytes(), self.settings.control());
        }
    }

    /// The reports that have come, at this time, s since the start. Monitors get them, too. Whoever sends something here is taken for a
    /// robot, as a real GameController takes it, and is no monitor any more.
    pub fn take_reports(&mut self, time_s: f64) -> Vec<ReturnPacket> {
        let mut taken = Vec::new();
        // One byte more than a report has, to know what is longer.
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

    /// Lets monitors in that have asked. Whether somebody is there who is to be told the truth.
    pub fn has_monitors(&mut self) -> bool {
        self.monitors.as_mut().is_some_and(Monitors::let_in)
    }
}

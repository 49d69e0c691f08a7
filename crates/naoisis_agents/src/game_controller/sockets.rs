//! The ports of the protocol, the addresses of robots on one machine, and non-blocking sockets.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};

/// The port of control packets.
pub(super) const CONTROL_PORT: u16 = 3838;
/// The port to which robots send their reports.
pub(super) const REPORT_PORT: u16 = 3939;
/// The port at which monitors request the true state.
pub(super) const REQUEST_PORT: u16 = 3636;
/// The port at which monitors receive the reports of robots.
pub(super) const FORWARD_PORT: u16 = 3940;
/// The request of a monitor.
pub(super) const REQUEST: [u8; 5] = *b"RGTr\0";
/// The address to which programs send their messages.
pub const HERE: Ipv4Addr = Ipv4Addr::LOCALHOST;

/// The error that a socket cannot be opened.
#[derive(thiserror::Error)]
#[error("{address}: {error}")]
pub struct NetworkError {
    /// The address.
    pub address: SocketAddr,
    /// The error of the system.
    pub error: io::Error,
}

naoisis_core::debug_as_displayed!(NetworkError);

/// A non-blocking socket.
pub(super) fn bind(address: SocketAddr) -> Result<UdpSocket, NetworkError> {
    let socket = UdpSocket::bind(address).and_then(|socket| socket.set_nonblocking(true).map(|()| socket));
    socket.map_err(|error| NetworkError { address, error })
}

/// The address and port of a service of the protocol; `port_offset` is added to all ports of a match.
pub(super) fn place(address: IpAddr, port: u16, port_offset: u16) -> SocketAddr {
    SocketAddr::new(address, port.saturating_add(port_offset))
}

/// The address of a robot on this machine: `127.1.TEAM.NUMBER`.
pub fn robot_address(team_number: u8, number: u8) -> Ipv4Addr {
    Ipv4Addr::new(127, 1, team_number, number)
}

/// The numbers of the team and of the robot with this address; `None` if it is not the address of a robot.
pub(super) fn robot_at(address: IpAddr) -> Option<(u8, u8)> {
    match address {
        IpAddr::V4(address) => match address.octets() {
            [127, 1, team_number, number] => Some((team_number, number)),
            _ => None,
        },
        IpAddr::V6(_) => None,
    }
}

//! The protocol's ports, the addresses of robots on one machine, and sockets that do not wait.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};

/// Where control packets go.
pub(super) const CONTROL_PORT: u16 = 3838;
/// Where robots send their reports.
pub(super) const REPORT_PORT: u16 = 3939;
/// Where monitors ask for the truth.
pub(super) const REQUEST_PORT: u16 = 3636;
/// Where monitors are sent the robots' reports.
pub(super) const FORWARD_PORT: u16 = 3940;
/// What a monitor sends.
pub(super) const REQUEST: [u8; 5] = *b"RGTr\0";
/// Where programs send their messages.
pub const HERE: Ipv4Addr = Ipv4Addr::LOCALHOST;

/// A socket that cannot be opened.
#[derive(Debug, thiserror::Error)]
#[error("{address}: {error}")]
pub struct NetworkError {
    /// The address that was asked for.
    pub address: SocketAddr,
    /// What the system says.
    pub error: io::Error,
}

/// A socket that does not wait.
pub(super) fn bind(address: SocketAddr) -> Result<UdpSocket, NetworkError> {
    let socket = UdpSocket::bind(address).and_then(|socket| socket.set_nonblocking(true).map(|()| socket));
    socket.map_err(|error| NetworkError { address, error })
}

/// The place of a port of the protocol at an address, of a match whose ports are all so much higher.
pub(super) fn place(address: IpAddr, port: u16, port_offset: u16) -> SocketAddr {
    SocketAddr::new(address, port.saturating_add(port_offset))
}

/// The address of a robot on this machine: `127.1.TEAM.NUMBER`.
pub fn robot_address(team_number: u8, number: u8) -> Ipv4Addr {
    Ipv4Addr::new(127, 1, team_number, number)
}

/// The numbers of the team and the robot whose address this is; none if it is no robot's.
pub(super) fn robot_at(address: IpAddr) -> Option<(u8, u8)> {
    match address {
        IpAddr::V4(address) => match address.octets() {
            [127, 1, team_number, number] => Some((team_number, number)),
            _ => None,
        },
        IpAddr::V6(_) => None,
    }
}

//! Sends the true state of a match to monitors while a real GameController makes its decisions. The GameController knows the game, but only
//! the match knows the true positions of robots and ball.
//!
//! Monitors receive the true state in the protocol that they know. They request it, and receive the state of the game as from a
//! GameController, and reports of robots as a GameController forwards them, with the true positions of the robot and the ball. It is sent
//! only if the settings allow it, because any program that asks receives it, including programs that play.

use bevy::math::Vec2;
use std::net::{IpAddr, SocketAddr, UdpSocket};

use super::monitors::Monitors;
use super::packet::ControlPacket;
use super::packet_series::PacketSeries;
use super::report::ReturnPacket;
use super::sockets::{NetworkError, REQUEST_PORT, place, robot_address};
use naoisis_core::communication::StatusReport;
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::End;
use naoisis_core::robot::posture::Posture;
use naoisis_sensing::belief::team_from_pitch;

/// The port at which monitors request the true state if a GameController on this machine uses the usual port.
const OTHER_REQUEST_PORT: u16 = REQUEST_PORT + 1;

/// Sends the true state to monitors.
#[derive(Debug)]
pub(super) struct Truth {
    monitors: Monitors,
    packets: PacketSeries,
    /// The address at which control packets are received; packets for monitors must not arrive there.
    listening: IpAddr,
}

impl Truth {
    /// Listens for requests of monitors. Also returns the address.
    ///
    /// # Errors
    /// If neither port is free.
    pub fn open(listening: IpAddr, port_offset: u16) -> Result<(Self, SocketAddr), NetworkError> {
        let at = |port| {
            let requests = place(listening, port, port_offset);
            Monitors::open(requests, port_offset).map(|monitors| (monitors, requests))
        };
        let (monitors, requests) = at(REQUEST_PORT).or_else(|_| at(OTHER_REQUEST_PORT))?;
        Ok((Self { monitors, packets: PacketSeries::default(), listening }, requests))
    }

    /// Reads requests of monitors. Returns whether there is a monitor.
    pub fn has_monitors(&mut self) -> bool {
        self.monitors.let_in()
    }

    /// Sends the state of the game if `is_time` or something has changed.
    pub fn tell_game(&mut self, packet: ControlPacket, is_time: bool) {
        if let Some(packet) = self.packets.next(packet, is_time) {
            let listening = self.listening;
            self.monitors.tell(&packet, |host| !is_heard_here(listening, host));
        }
    }

    /// Sends the positions of robots.
    pub fn tell_robots(&self, robots: impl IntoIterator<Item = ReturnPacket>) {
        for robot in robots {
            self.monitors.forward(robot_address(robot.team, robot.player), &robot.to_bytes());
        }
    }
}

/// Whether packets to the control port of `host` arrive at a listener at `listening`.
fn is_heard_here(listening: IpAddr, host: IpAddr) -> bool {
    match listening.is_unspecified() {
        // A listener at all addresses of this machine hears those to which one of its sockets can be bound.
        true => UdpSocket::bind((host, 0)).is_ok(),
        false => host == listening,
    }
}

/// The report that a robot would send at `time_s` if it knew the truth: its true pose and the true position of the ball, pitch frame.
pub(super) fn true_report(
    pose: Pose,
    posture: Posture,
    ball_m: Option<Vec2>,
    own_end: End,
    time_s: f64,
) -> StatusReport {
    StatusReport {
        time_s,
        fallen: !posture.is_upright(),
        pose: team_from_pitch(pose, own_end),
        ball_age_s: ball_m.map(|_| 0.0),
        ball_m: ball_m.map(|ball| pose.inverse_transform_point(ball)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::FRAC_PI_2;
    use naoisis_core::robot::posture::LyingOn;
    use std::net::Ipv4Addr;

    #[test]
    fn where_a_robot_is_is_said_as_its_team_sees_the_pitch() {
        let (pose, ball) = (Pose::new(1.0, 0.5, FRAC_PI_2), Some(Vec2::new(1.0, 2.5)));
        let report = |own_end| true_report(pose, Posture::Fallen { cycles: 3, on: LyingOn::Front }, ball, own_end, 2.0);
        let (blue, pink) = (report(End::NegativeX), report(End::PositiveX));
        assert_eq!((blue.pose, blue.fallen, blue.ball_age_s), (pose, true, Some(0.0)));
        assert!(pink.pose.position.distance(Vec2::new(-1.0, -0.5)) < 1e-6, "{pink:?}");
        assert!((pink.pose.heading + FRAC_PI_2).abs() < 1e-6, "{pink:?}");
        // The ball is two metres ahead for each of them.
        for report in [blue, pink] {
            assert!(report.ball_m.unwrap().distance(Vec2::new(2.0, 0.0)) < 1e-5, "{report:?}");
        }
        let without_ball = true_report(pose, Posture::Upright, None, End::NegativeX, 2.0);
        assert_eq!((without_ball.fallen, without_ball.ball_age_s, without_ball.ball_m), (false, None, None));
    }

    #[test]
    fn a_match_does_not_hear_what_it_says_itself() {
        let [here, other] = [Ipv4Addr::LOCALHOST, Ipv4Addr::new(127, 0, 0, 2)].map(IpAddr::from);
        assert!(is_heard_here(here, here) && !is_heard_here(here, other));
        let everywhere = Ipv4Addr::UNSPECIFIED.into();
        // An address that is reserved for documentation belongs to no machine.
        assert!(is_heard_here(everywhere, here) && !is_heard_here(everywhere, Ipv4Addr::new(198, 51, 100, 7).into()));
    }
}

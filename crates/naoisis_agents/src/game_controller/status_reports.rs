//! Status reports to a real GameController for robots with behaviours of their own, so that its operator sees which robots exist and what
//! they believe. Programs report for themselves.
//!
//! A GameController identifies a robot by its address, so each robot reports from [its own](robot_address). This works only with a
//! GameController on this machine. A GameController on another machine would take this machine for a robot, and stop sending it the true
//! state.

use std::net::{IpAddr, SocketAddr, UdpSocket};

use super::report::ReturnPacket;
use super::sockets::{REPORT_PORT, bind, place, robot_address};
use naoisis_core::communication::StatusReport;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::status::BodyStatus;

/// Sends reports, from one address per robot.
#[derive(Debug, Default)]
pub struct Reporter {
    sockets: Vec<(RobotId, UdpSocket)>,
}

impl Reporter {
    /// Sends a report of a robot to the GameController at an address of this machine. Ignores a GameController that is
    /// gone.
    pub fn send(
        &mut self,
        robot: RobotId,
        team_number: u8,
        report: StatusReport,
        controller: IpAddr,
        port_offset: u16,
    ) {
        let Some(socket) = self.socket(robot, team_number) else { return };
        let packet = ReturnPacket { player: robot.number, team: team_number, report };
        let _ = socket.send_to(&packet.to_bytes(), place(controller, REPORT_PORT, port_offset));
    }

    /// The socket of a robot; `None` if this machine has no such address.
    fn socket(&mut self, robot: RobotId, team_number: u8) -> Option<&UdpSocket> {
        let index = match self.sockets.iter().position(|(id, _)| *id == robot) {
            Some(index) => index,
            None => {
                let address = SocketAddr::new(robot_address(team_number, robot.number).into(), 0);
                self.sockets.push((robot, bind(address).ok()?));
                self.sockets.len() - 1
            }
        };
        self.sockets.get(index).map(|(_, socket)| socket)
    }
}

/// The status report of a robot.
pub fn status_of(body: BodyStatus, belief: Option<&Belief>, time_s: f64) -> StatusReport {
    let pose = belief.map(|belief| belief.pose).unwrap_or_default();
    let ball = belief.and_then(|belief| belief.ball);
    StatusReport {
        time_s,
        fallen: body == BodyStatus::Fallen,
        pose,
        ball_age_s: ball.map(|ball| ball.age_s),
        ball_m: ball.map(|ball| pose.inverse_transform_point(ball.position_m)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec2;
    use core::f32::consts::FRAC_PI_2;
    use naoisis_core::geometry::Pose;
    use naoisis_sensing::belief::BallBelief;

    #[test]
    fn a_ball_is_reported_as_the_robot_sees_it() {
        let ball = BallBelief { position_m: Vec2::new(1.0, 2.5), age_s: 0.5, ..BallBelief::default() };
        let belief = Belief { pose: Pose::new(1.0, 0.5, FRAC_PI_2), ball: Some(ball), ..Belief::default() };
        let report = status_of(BodyStatus::Fallen, Some(&belief), 3.0);
        assert!(report.ball_m.unwrap().distance(Vec2::new(2.0, 0.0)) < 1e-5, "{report:?}");
        assert_eq!((report.fallen, report.ball_age_s, report.pose), (true, Some(0.5), belief.pose));
        let nobody_knows = status_of(BodyStatus::Walking, None, 3.0);
        assert_eq!((nobody_knows.fallen, nobody_knows.ball_age_s), (false, None));
    }
}

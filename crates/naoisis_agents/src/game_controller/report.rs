//! Return packets: the status reports of robots to a GameController, version 4 of `RoboCupGameControlReturnData`, which
//! versions 18 to 20 of the protocol share. 32 bytes, little-endian; millimetres and radians.

use bevy::prelude::*;

use naoisis_core::communication::StatusReport;
use naoisis_core::geometry::{Pose, wrap_angle};

/// The length of a return packet, bytes.
pub const REPORT_BYTES: usize = 32;
/// The header of a return packet, with its version.
const HEADER: [u8; 5] = *b"RGrt\x04";
/// The age of a ball that was never seen, s.
const NEVER_SEEN_S: f32 = -1.0;
/// Millimetres in a metre.
const MM: f32 = 1000.0;

/// The status report of a robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ReturnPacket {
    /// The robot's number.
    pub player: u8,
    /// The number of its team.
    pub team: u8,
    /// The report.
    pub report: StatusReport,
}

/// The error that bytes are no return packet.
#[derive(Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected 32 bytes that begin with RGrt and version 4, fallen 0 or 1, and finite numbers")]
pub struct NotAReturnPacket;

naoisis_core::debug_as_displayed!(NotAReturnPacket);

impl ReturnPacket {
    /// The bytes of the packet.
    pub fn to_bytes(&self) -> [u8; REPORT_BYTES] {
        let StatusReport { fallen, pose, ball_age_s, ball_m, .. } = self.report;
        let ball = ball_m.unwrap_or_default() * MM;
        let numbers = [
            pose.position.x * MM,
            pose.position.y * MM,
            pose.heading,
            ball_age_s.unwrap_or(NEVER_SEEN_S),
            ball.x,
            ball.y,
        ];
        let mut bytes = [0; REPORT_BYTES];
        bytes[..5].copy_from_slice(&HEADER);
        bytes[5..8].copy_from_slice(&[self.player, self.team, u8::from(fallen)]);
        for (place, number) in bytes[8..].chunks_exact_mut(4).zip(numbers) {
            place.copy_from_slice(&number.to_le_bytes());
        }
        bytes
    }

    /// Reads a packet that arrives at `time_s`, s since the start.
    ///
    /// # Errors
    /// If the bytes are not a return packet.
    pub fn from_bytes(bytes: &[u8], time_s: f64) -> Result<Self, NotAReturnPacket> {
        let bytes: &[u8; REPORT_BYTES] = bytes.try_into().map_err(|_| NotAReturnPacket)?;
        let (numbers, _) = bytes[8..].as_chunks::<4>();
        let mut numbers = numbers.iter().map(|number| f32::from_le_bytes(*number));
        let [x, y, heading, age_s, ball_x, ball_y] = [(); 6].map(|()| numbers.next().unwrap_or(f32::NAN));
        let all_finite = [x, y, heading, age_s, ball_x, ball_y].iter().all(|number| number.is_finite());
        if bytes[..5] != HEADER || bytes[7] > 1 || !all_finite {
            return Err(NotAReturnPacket);
        }
        let is_seen = age_s >= 0.0;
        let report = StatusReport {
            time_s,
            fallen: bytes[7] == 1,
            pose: Pose::new(x / MM, y / MM, wrap_angle(heading)),
            ball_age_s: is_seen.then_some(age_s),
            ball_m: is_seen.then(|| Vec2::new(ball_x, ball_y) / MM),
        };
        Ok(Self { player: bytes[5], team: bytes[6], report })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bytes that a C compiler produces for the published structure with the values of the test.
    const GOLDEN: &str = "5247727404030c0100509ac400007a43db0fc93f0000803e0080bb44000097c2";

    #[test]
    fn a_report_is_what_a_c_compiler_makes_of_the_published_structure() {
        let report = StatusReport {
            time_s: 2.0,
            fallen: true,
            pose: Pose::new(-1.2345, 0.25, core::f32::consts::FRAC_PI_2),
            ball_age_s: Some(0.25),
            ball_m: Some(Vec2::new(1.5, -0.0755)),
        };
        let packet = ReturnPacket { player: 3, team: 12, report };
        let hexadecimal: String = packet.to_bytes().iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hexadecimal, GOLDEN);
        assert_eq!(ReturnPacket::from_bytes(&packet.to_bytes(), 2.0), Ok(packet));
    }

    #[test]
    fn a_ball_that_was_never_seen_is_nowhere_and_nonsense_is_no_report() {
        let packet = ReturnPacket { player: 1, team: 5, report: StatusReport::default() };
        let bytes = packet.to_bytes();
        let read = ReturnPacket::from_bytes(&bytes, 0.0).unwrap().report;
        assert_eq!((read.ball_age_s, read.ball_m), (None, None));
        assert_eq!(ReturnPacket::from_bytes(&bytes[1..], 0.0), Err(NotAReturnPacket));
        for (at, value) in [(0, b'X'), (4, 3), (7, 2), (11, 0x7f)] {
            let mut wrong = bytes;
            wrong[at] = value;
            // The last bytes are a number that is not finite.
            wrong[10] = if at == 11 { 0xff } else { wrong[10] };
            assert_eq!(ReturnPacket::from_bytes(&wrong, 0.0), Err(NotAReturnPacket), "{at}");
        }
    }
}

//! Crosstalk: pings of other robots that a sonar mistakes for echoes.

use super::echoes::{SonarSectors, is_near};
use super::sector::nearer;
use super::{SonarReading, SonarSettings, SonarSource};
use crate::appearance::scene::Scene;
use naoisis_core::geometry::{Pose, unrotate};
use naoisis_core::random::RandomStream;
use naoisis_core::team::RobotId;

/// Whether the left and the right sonar receive pings of another robot, which requires that each of the two robots is in a sector of the
/// other.
pub(super) fn hears_pings<'a>(
    settings: &SonarSettings,
    own_id: RobotId,
    own_pose: Pose,
    scene: &Scene,
    sonar_of: impl Fn(RobotId) -> Option<&'a SonarSettings>,
) -> [bool; 2] {
    let sectors = SonarSectors::of(settings, own_pose.forward());
    let mut hears = [false; 2];
    for robot in scene.robots.iter().filter(|robot| robot.id != own_id) {
        let offset = robot.pose.position - own_pose.position;
        let heard = sectors.contain(unrotate(sectors.forward, offset));
        if heard == [false; 2] {
            continue;
        }
        let Some(sender) = sonar_of(robot.id) else { continue };
        let reaches = sender.source == SonarSource::Echo && is_near(offset, 2.0 * sender.max_m);
        // Most robots have the same sonars.
        let is_alike = [sender.heading, sender.half_angle] == [settings.heading, settings.half_angle];
        let others = if is_alike { sectors } else { SonarSectors::of(sender, robot.forward) };
        if reaches && others.contain(unrotate(robot.forward, -offset)) != [false; 2] {
            hears = [hears[0] || heard[0], hears[1] || heard[1]];
        }
    }
    hears
}

/// Adds crosstalk to a reading: with some probability, a false echo anywhere in the range. The nearer of the false and the true echo
/// counts.
pub(super) fn with_crosstalk(
    settings: &SonarSettings,
    reading: SonarReading,
    [left, right]: [bool; 2],
    stream: &mut RandomStream,
) -> SonarReading {
    let mut listen = |measured: Option<f32>, hears: bool| {
        let false_echo = (hears && stream.chance(settings.crosstalk_probability))
            .then(|| settings.min_m + (settings.max_m - settings.min_m) * stream.uniform());
        nearer(measured, false_echo)
    };
    SonarReading { left: listen(reading.left, left), right: listen(reading.right, right), ..reading }
}

//! The head: two joints with limits and a speed.
//!
//! The paper's Table 1(b) prints the labels of yaw and pitch swapped: the NAO's head turns ±120° (yaw) and nods
//! from -35° (up) to +30° (down). Those are the defaults here.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::Roster;
use crate::cycle::{ActSystems, Cycle, CycleClock};
use crate::events::{CommandKind, CycleEvents, MatchEvent, Refusal};
use crate::geometry::{file_units, to_radians};
use crate::knowledge::Knowledge;
use crate::team::RobotId;

/// Turns the heads in [`ActSystems::Head`].
pub struct HeadPlugin;

impl Plugin for HeadPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<HeadAngles>()
            .register_type::<HeadCommand>()
            .register_type::<HeadLimits>()
            .add_systems(Cycle, turn_heads.in_set(ActSystems::Head));
    }
}

/// Measured joint angles of the head.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct HeadAngles {
    /// Counter-clockwise (to the left), radians.
    pub yaw: f32,
    /// Downwards, radians.
    pub pitch: f32,
}

/// The angles that the head moves towards, as fast as it can. Stays until it is changed.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct HeadCommand {
    /// Counter-clockwise (to the left), radians; beyond the limit it is clamped.
    pub yaw: f32,
    /// Downwards, radians; beyond the limit it is clamped.
    pub pitch: f32,
}

/// Limits of the head's joints.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct HeadLimits {
    /// Least and greatest yaw, radians (degrees in files). Default ±120° (paper, Table 1b, labels corrected).
    #[serde(rename = "yaw_deg", with = "file_units::degree_pair")]
    pub yaw: [f32; 2],
    /// Least and greatest pitch, radians (degrees in files). Default -35°..+30° (same table).
    #[serde(rename = "pitch_deg", with = "file_units::degree_pair")]
    pub pitch: [f32; 2],
    /// Speed of each joint, rad/s (degrees per second in files). Default 300: the NAO V3.2's joints reach 474
    /// (yaw) and 412 (pitch) unloaded.
    #[serde(rename = "max_degps", with = "file_units::degrees")]
    pub max_speed: f32,
}

impl Default for HeadLimits {
    fn default() -> Self {
        Self {
            yaw: [-120.0, 120.0].map(to_radians),
            pitch: [-35.0, 30.0].map(to_radians),
            max_speed: to_radians(300.0),
        }
    }
}

fn turn_heads(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<(&RobotId, &HeadLimits, &mut HeadCommand, &mut HeadAngles)>,
) {
    for entity in roster.entities() {
        let Ok((id, limits, mut command, mut angles)) = robots.get_mut(entity) else { continue };
        if let Some(reason) = Refusal::of_numbers([command.yaw, command.pitch]) {
            events.push(MatchEvent::CommandRefused { robot: *id, command: CommandKind::Head, reason });
            *command = HeadCommand { yaw: angles.yaw, pitch: angles.pitch };
        }
        *angles = turned(*angles, *command, limits, clock.period());
    }
}

/// Where the head is after a cycle of `period` seconds.
pub fn turned(angles: HeadAngles, command: HeadCommand, limits: &HeadLimits, period: f32) -> HeadAngles {
    let most = limits.max_speed * period;
    let towards = |from: f32, to: f32, [least, greatest]: [f32; 2]| {
        let to = to.max(least).min(greatest);
        if (to - from).abs() <= most { to } else { from + most.copysign(to - from) }
    };
    HeadAngles {
        yaw: towards(angles.yaw, command.yaw, limits.yaw),
        pitch: towards(angles.pitch, command.pitch, limits.pitch),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_head_moves_at_its_speed_and_stops_at_its_limits() {
        let limits = HeadLimits::default();
        let command = HeadCommand { yaw: 3.0, pitch: -1.0 };
        // 300 degrees per second for 1/30 s are 10 degrees.
        let once = turned(HeadAngles::default(), command, &limits, 1.0 / 30.0);
        assert_abs_diff_eq!(once.yaw, 10.0_f32.to_radians(), epsilon = 1e-6);
        let mut angles = once;
        for _ in 0..30 {
            angles = turned(angles, command, &limits, 1.0 / 30.0);
        }
        assert_eq!([angles.yaw, angles.pitch], [limits.yaw[1], limits.pitch[0]]);
    }
}

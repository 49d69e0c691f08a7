//! The head: two joints with limits and a speed.
//!
//! The paper's Table 1(b) has the labels of yaw and pitch swapped: the NAO's head turns ±120° (yaw) and from -35° (up) to +30°
//! (down) (pitch), which are the defaults here. The limits of the pitch may depend on the yaw ([`PitchAtYaw`]), where the shells
//! of head and trunk would collide.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tinyvec::ArrayVec;

use super::Roster;
use crate::cycle::{ActSystems, Cycle, CycleClock};
use crate::events::{CommandKind, CycleEvents, MatchEvent, Refusal};
use crate::geometry::file_units::{self, DegreeTriple};
use crate::geometry::to_radians;
use crate::knowledge::Knowledge;
use crate::team::RobotId;

/// Turns the heads in [`ActSystems::Head`].
pub struct HeadPlugin;

impl Plugin for HeadPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<HeadAngles>()
            .register_type::<HeadCommand>()
            .register_type::<LateHeadCommand>()
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

/// The target angles of the head, which turns towards them at its full speed. The command stays until it is changed.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct HeadCommand {
    /// Counter-clockwise (to the left), radians; clamped to the limits.
    pub yaw: f32,
    /// Downwards, radians; clamped to the limits.
    pub pitch: f32,
}

/// The command that the joints follow instead of the [`HeadCommand`] if commands are [delayed](super::latency).
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct LateHeadCommand(pub Option<HeadCommand>);

/// Limits of the head's joints.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct HeadLimits {
    /// Least and greatest yaw, radians (degrees in files). Default ±120° (paper, Table 1b, labels corrected).
    #[serde(rename = "yaw_deg", with = "file_units::degree_pair")]
    #[schemars(with = "[f32; 2]", inner(range(min = -180.0, max = 180.0)))]
    pub yaw: [f32; 2],
    /// Least and greatest pitch, radians (degrees in files). Default -35°..+30° (same table).
    #[serde(rename = "pitch_deg", with = "file_units::degree_pair")]
    #[schemars(with = "[f32; 2]", inner(range(min = -90.0, max = 90.0)))]
    pub pitch: [f32; 2],
    /// Narrower limits of the pitch at some yaws; empty by default.
    #[serde(rename = "pitch_at_yaw_deg")]
    pub pitch_at_yaw: PitchAtYaw,
    /// Speed of each joint, rad/s (degrees per second in files). Default 300: the NAO V3.2's joints reach 474
    /// (yaw) and 412 (pitch) unloaded.
    #[serde(rename = "max_degps", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 3600.0))]
    pub max_speed: f32,
}

impl Default for HeadLimits {
    fn default() -> Self {
        Self {
            yaw: [-120.0, 120.0].map(to_radians),
            pitch: [-35.0, 30.0].map(to_radians),
            pitch_at_yaw: PitchAtYaw::default(),
            max_speed: to_radians(300.0),
        }
    }
}

impl HeadLimits {
    /// Least and greatest pitch at `yaw`, radians.
    pub fn pitch_at(&self, yaw: f32) -> [f32; 2] {
        let [least, most] = self.pitch;
        match self.pitch_at_yaw.at(yaw) {
            Some([narrower_least, narrower_most]) => [least.max(narrower_least), most.min(narrower_most)],
            None => [least, most],
        }
    }

    /// Whether the head moves. A head with speed zero is fixed, independently of its limits.
    pub fn moves(&self) -> bool {
        self.max_speed > 0.0
    }

    /// The limits that the head reaches from `angles`: `angles` themselves if the head is fixed.
    #[must_use]
    pub fn reached_from(&self, angles: HeadAngles) -> HeadLimits {
        if self.moves() {
            return *self;
        }
        let HeadAngles { yaw, pitch } = angles;
        HeadLimits { yaw: [yaw; 2], pitch: [pitch; 2], pitch_at_yaw: PitchAtYaw::default(), ..*self }
    }

    /// `angles` clamped to the limits.
    pub fn nearest(&self, angles: HeadAngles) -> HeadAngles {
        let within = |angle: f32, [least, most]: [f32; 2]| angle.max(least).min(most);
        let yaw = within(angles.yaw, self.yaw);
        HeadAngles { yaw, pitch: within(angles.pitch, self.pitch_at(yaw)) }
    }
}

/// The limits of the pitch at one yaw.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(from = "DegreeTriple", into = "DegreeTriple")]
pub struct PitchLimit {
    /// Yaw of the head, radians.
    pub yaw: f32,
    /// Least and greatest pitch at that yaw, radians.
    pub pitch: [f32; 2],
}

impl From<DegreeTriple> for PitchLimit {
    fn from(DegreeTriple([yaw, least, most]): DegreeTriple) -> Self {
        Self { yaw, pitch: [least, most] }
    }
}

impl From<PitchLimit> for DegreeTriple {
    fn from(PitchLimit { yaw, pitch: [least, most] }: PitchLimit) -> Self {
        Self([yaw, least, most])
    }
}

/// The limits of the pitch at some yaws, from the right to the left: interpolated linearly between them and constant beyond the first and
/// the last. In files, a list of `[yaw, least pitch, greatest pitch]` in degrees.
#[derive(Clone, Copy, PartialEq, Debug, Default, Deref, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(try_from = "Vec<PitchLimit>", into = "Vec<PitchLimit>")]
pub struct PitchAtYaw(ArrayVec<[PitchLimit; PitchAtYaw::MOST]>);

impl TryFrom<Vec<PitchLimit>> for PitchAtYaw {
    type Error = String;

    fn try_from(limits: Vec<PitchLimit>) -> Result<Self, String> {
        let too_many = |_| format!("{} yaws; expected at most {}", limits.len(), Self::MOST);
        ArrayVec::try_from(limits.as_slice()).map(Self).map_err(too_many)
    }
}

impl From<PitchAtYaw> for Vec<PitchLimit> {
    fn from(limits: PitchAtYaw) -> Self {
        limits.0.to_vec()
    }
}

impl PitchAtYaw {
    /// The greatest number of yaws.
    pub const MOST: usize = 16;

    /// Least and greatest pitch at `yaw`, radians; `None` if the pitch does not depend on the yaw.
    fn at(&self, yaw: f32) -> Option<[f32; 2]> {
        let limits = self.0.as_slice();
        let above = limits.iter().position(|limit| limit.yaw >= yaw).unwrap_or(limits.len());
        let (first, last) = (limits.first()?, limits.last()?);
        let (Some(right), Some(left)) = (above.checked_sub(1).map(|index| limits[index]), limits.get(above)) else {
            return Some(if above == 0 { first.pitch } else { last.pitch });
        };
        let share = (yaw - right.yaw) / (left.yaw - right.yaw);
        Some([0, 1].map(|end| right.pitch[end] + share * (left.pitch[end] - right.pitch[end])))
    }
}

fn turn_heads(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<(&RobotId, &HeadLimits, Option<&LateHeadCommand>, &mut HeadCommand, &mut HeadAngles)>,
) {
    for entity in roster.entities() {
        let Ok((id, limits, late, mut command, mut angles)) = robots.get_mut(entity) else { continue };
        if let Some(reason) = Refusal::of_numbers([command.yaw, command.pitch]) {
            events.push(MatchEvent::CommandRefused { robot: *id, command: CommandKind::Head, reason });
            *command = HeadCommand { yaw: angles.yaw, pitch: angles.pitch };
        }
        let arrived = late.and_then(|late| late.0).unwrap_or(*command);
        *angles = turned(*angles, arrived, limits, clock.period());
    }
}

/// The angles of the head after a cycle of `period` seconds.
pub fn turned(angles: HeadAngles, command: HeadCommand, limits: &HeadLimits, period: f32) -> HeadAngles {
    let most = limits.max_speed * period;
    let towards = |from: f32, to: f32, [least, greatest]: [f32; 2]| {
        let to = to.max(least).min(greatest);
        if (to - from).abs() <= most { to } else { from + most.copysign(to - from) }
    };
    let yaw = towards(angles.yaw, command.yaw, limits.yaw);
    let [least, greatest] = limits.pitch_at(yaw);
    let pitch = towards(angles.pitch, command.pitch, [least, greatest]);
    // A head that turns to where the shells would meet is pushed up or down along the limits.
    let pitch = if limits.pitch_at_yaw.is_empty() { pitch } else { pitch.max(least).min(greatest) };
    HeadAngles { yaw, pitch }
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

    #[test]
    fn a_head_that_is_turned_aside_nods_less() {
        let limits: HeadLimits = serde_json::from_str(
            r#"{ "yaw_deg": [-119.5, 119.5], "pitch_deg": [-38.5, 29.5],
                 "pitch_at_yaw_deg": [[-60, -25, 17], [0, -38.5, 29.5], [60, -25, 17], [90, -19, 11]] }"#,
        )
        .unwrap();
        let degrees = |yaw: f32| limits.pitch_at(to_radians(yaw)).map(f32::to_degrees);
        // Half way between two yaws, half way between their limits; beyond the last, those of the last.
        for (yaw, expected) in
            [(0.0, [-38.5, 29.5]), (30.0, [-31.75, 23.25]), (75.0, [-22.0, 14.0]), (119.0, [-19.0, 11.0])]
        {
            for (end, expected) in degrees(yaw).into_iter().zip(expected) {
                assert_abs_diff_eq!(end, expected, epsilon = 1e-3);
            }
        }
        // Looking down as far as it goes and then aside, it comes up again.
        let mut angles = HeadAngles::default();
        for (yaw, pitch) in [(0.0, 29.5), (90.0, 11.0), (-60.0, 17.0)] {
            for _ in 0..60 {
                let command = HeadCommand { yaw: to_radians(yaw), pitch: 1.0 };
                angles = turned(angles, command, &limits, 1.0 / 30.0);
                let [least, most] = limits.pitch_at(angles.yaw);
                assert!((least..=most).contains(&angles.pitch), "{angles:?}");
            }
            assert_abs_diff_eq!(angles.pitch, to_radians(pitch), epsilon = 1e-4);
        }
        let again: HeadLimits = serde_json::from_str(&serde_json::to_string(&limits).unwrap()).unwrap();
        assert_eq!(again, limits);
    }
}

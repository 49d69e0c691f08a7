//! How robots move their limbs: steps, kicks and heads.
//!
//! The simulation leaves joints out, so the legs are for the eye only: they step as fast as the robot walks, such that the
//! foot on the ground does not slide. The head is where the simulation has it.

use bevy::math::ops;
use bevy::prelude::*;
use core::f32::consts::{PI, TAU};

use super::drive::DisplayFraction;
use super::figure::{Figure, Leg, SHANK, THIGH};
use crate::cycle::{Cycle, CycleClock, CycleSystems};
use crate::events::{CycleEvents, KickResult, MatchEvent};
use crate::geometry::{Pose, unrotate};
use crate::robot::head::HeadAngles;
use crate::robot::kick::{Foot, KickType};
use crate::robot::{RobotId, Roster, Velocity};

/// Pairs of steps a second.
const STEP_FREQUENCY: f32 = 1.6;
/// How high a foot is lifted in a step, m.
const STEP_LIFT: f32 = 0.02;
/// How long it takes to get into step, s.
const SETTLING_S: f32 = 0.15;
/// How long a leg takes to come back after a kick, s.
const KICK_S: f32 = 0.5;

/// Moves the limbs of the figures.
pub struct GaitPlugin;

impl Plugin for GaitPlugin {
    fn build(&self, app: &mut App) {
        app.add_observer(start_gait)
            .add_systems(Cycle, note_kicks.in_set(CycleSystems::Record))
            .add_systems(Update, (turn_heads, move_limbs));
    }
}

/// How a figure is moving.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default)]
struct Gait {
    /// The time of the match that is shown, s.
    time_s: f64,
    /// Forward speed that the steps have, m/s.
    speed: f32,
    /// How much the feet are lifted, 0 to 1.
    liveliness: f32,
    /// The last kick and when it was, s.
    kick: Option<(KickType, f64)>,
}

fn start_gait(added: On<Add, RobotId>, mut commands: Commands) {
    commands.entity(added.entity).insert(Gait::default());
}

fn note_kicks(events: Res<CycleEvents>, clock: Res<CycleClock>, roster: Res<Roster>, mut gaits: Query<&mut Gait>) {
    for event in events.iter() {
        let MatchEvent::Kick { robot, kick_type, result, reason, .. } = event else { continue };
        // A kick that found no ball is still a kick.
        if *result == KickResult::Missed && *reason != Some(crate::events::KickMiss::OutOfReach) {
            continue;
        }
        if let Some(mut gait) = roster.get(*robot).and_then(|robot| gaits.get_mut(robot).ok()) {
            gait.kick = Some((*kick_type, clock.start_time_s()));
        }
    }
}

fn turn_heads(robots: Query<(&HeadAngles, &Figure)>, mut transforms: Query<&mut Transform>) {
    for (angles, figure) in &robots {
        if let Ok(mut transform) = transforms.get_mut(figure.head) {
            transform.rotation = Quat::from_rotation_z(angles.yaw) * Quat::from_rotation_y(angles.pitch);
        }
    }
}

fn move_limbs(
    clock: Res<CycleClock>,
    fraction: Res<DisplayFraction>,
    mut robots: Query<(&RobotId, &Pose, &Velocity, &Figure, &mut Gait)>,
    mut transforms: Query<&mut Transform>,
) {
    let now_s = clock.start_time_s() + f64::from(fraction.0) * clock.period_s;
    for (id, pose, velocity, figure, mut gait) in &mut robots {
        gait.follow(*pose, *velocity, now_s);
        // Robots that started together need not step together.
        let phase = TAU * STEP_FREQUENCY * now_s as f32 + id.stable_number() as f32;
        let kick = gait.kick.map(|(kick_type, since_s)| (kick_type, (now_s - since_s) as f32));
        for (side, leg) in figure.legs.iter().enumerate() {
            let side_phase = phase + side as f32 * PI;
            let mut step = step(side_phase, gait.speed, gait.liveliness);
            let mut aside = 0.0;
            if let Some((kick_type, age_s)) = kick
                && (kick_type.foot() == Foot::Left) == (side == 0)
            {
                let (reach, swing) = kick_pose(kick_type, age_s);
                step += reach;
                aside = swing;
            }
            move_leg(leg, leg_angles(step), aside, &mut transforms);
            if let Ok(mut arm) = transforms.get_mut(figure.arms[side]) {
                let swing = 0.3 * ops::sin(side_phase) * (gait.speed / 0.2).clamp(-1.0, 1.0);
                arm.rotation = Quat::from_rotation_y(swing);
            }
        }
    }
}

impl Gait {
    /// Gets into step with what the robot does, smoothly.
    fn follow(&mut self, pose: Pose, velocity: Velocity, now_s: f64) {
        let elapsed_s = (now_s - self.time_s) as f32;
        self.time_s = now_s;
        if elapsed_s <= 0.0 {
            return;
        }
        let share = 1.0 - ops::exp(-elapsed_s / SETTLING_S);
        let in_robot = unrotate(pose.forward(), velocity.linear);
        let liveliness = (in_robot.length() / 0.08 + velocity.angular.abs() / 0.5).min(1.0);
        self.speed += share * (in_robot.x - self.speed);
        self.liveliness += share * (liveliness - self.liveliness);
    }
}

/// Where a foot is in its step, relative to where it stands: forward and up, m.
fn step(phase: f32, speed: f32, liveliness: f32) -> Vec2 {
    // On the ground from phase pi/2 to 3 pi/2, in which the foot goes back by twice the amplitude while the robot goes
    // forward by speed times half a period.
    let amplitude = speed / (4.0 * STEP_FREQUENCY);
    Vec2::new(amplitude * ops::sin(phase), STEP_LIFT * liveliness * ops::cos(phase).max(0.0))
}

/// How far the kicking foot still is from its place, forward and up in metres, and the leg's swing to the left in radians,
/// `age_s` after the ball was struck.
fn kick_pose(kick_type: KickType, age_s: f32) -> (Vec2, f32) {
    if !(0.0..KICK_S).contains(&age_s) {
        return (Vec2::ZERO, 0.0);
    }
    let left = 1.0 - age_s / KICK_S;
    let share = left * left * (3.0 - 2.0 * left);
    match kick_type {
        KickType::LeftStraight | KickType::RightStraight => (Vec2::new(0.11, 0.035) * share, 0.0),
        // The foot swings inwards.
        KickType::LeftSide => (Vec2::new(0.06, 0.025) * share, -0.3 * share),
        KickType::RightSide => (Vec2::new(0.06, 0.025) * share, 0.3 * share),
    }
}

/// Angles of hip and knee, radians: of the thigh forward from straight down, and of the shank backward from the thigh.
#[derive(Clone, Copy, PartialEq, Debug)]
struct LegAngles {
    hip: f32,
    knee: f32,
}

/// The angles with which the ankle is `step` (forward, up; m) from where it is when the leg is straight, as far as the leg
/// reaches.
fn leg_angles(step: Vec2) -> LegAngles {
    let target = Vec2::new(step.x, THIGH + SHANK - step.y);
    let distance = target.length().clamp((THIGH - SHANK).abs() + 1e-4, THIGH + SHANK);
    // The law of cosines in the triangle of hip, knee and ankle.
    let cosine =
        |a: f32, b: f32, opposite: f32| ((a * a + b * b - opposite * opposite) / (2.0 * a * b)).clamp(-1.0, 1.0);
    let at_hip = ops::acos(cosine(THIGH, distance, SHANK));
    let at_knee = ops::acos(cosine(THIGH, SHANK, distance));
    LegAngles { hip: ops::atan2(target.x, target.y) + at_hip, knee: PI - at_knee }
}

/// Bends a leg and keeps the foot level. `aside` swings it to the left, radians.
fn move_leg(leg: &Leg, angles: LegAngles, aside: f32, transforms: &mut Query<&mut Transform>) {
    let rotations = [
        // A rotation about y that is positive takes what hangs down backwards.
        (leg.thigh, Quat::from_rotation_x(aside) * Quat::from_rotation_y(-angles.hip)),
        (leg.shank, Quat::from_rotation_y(angles.knee)),
        (leg.foot, Quat::from_rotation_y(angles.hip - angles.knee)),
    ];
    for (part, rotation) in rotations {
        if let Ok(mut transform) = transforms.get_mut(part) {
            transform.rotation = rotation;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::figure::HIP;
    use super::*;

    /// The ankle relative to the hip, by the rotations that are shown.
    fn ankle(angles: LegAngles) -> Vec3 {
        let thigh = Quat::from_rotation_y(-angles.hip);
        thigh * (Vec3::NEG_Z * THIGH + Quat::from_rotation_y(angles.knee) * (Vec3::NEG_Z * SHANK))
    }

    #[test]
    fn the_foot_goes_where_it_should() {
        for step in [Vec2::ZERO, Vec2::new(0.0, 0.02), Vec2::new(0.05, 0.03), Vec2::new(-0.04, 0.02)] {
            let expected = Vec3::new(step.x, 0.0, step.y - THIGH - SHANK);
            let reached = ankle(leg_angles(step));
            assert!(reached.abs_diff_eq(expected, 1e-5), "{step}: {reached}");
        }
    }

    #[test]
    fn knees_bend_forward() {
        let angles = leg_angles(Vec2::new(0.0, 0.03));
        assert!(angles.hip > 0.0 && angles.knee > 0.0);
        const { assert!(HIP.z > THIGH + SHANK) };
    }

    #[test]
    fn the_foot_on_the_ground_does_not_slide_much() {
        // From pi/2 to 3 pi/2 the foot goes back by what the robot walks in half a period.
        let speed = 0.2;
        let back = step(PI / 2.0, speed, 1.0).x - step(3.0 * PI / 2.0, speed, 1.0).x;
        assert!((back - speed / (2.0 * STEP_FREQUENCY)).abs() < 1e-6);
        assert_eq!(step(PI, speed, 1.0).y, 0.0);
    }

    #[test]
    fn a_kick_is_over_after_a_while() {
        assert!(kick_pose(KickType::LeftStraight, 0.0).0.x > 0.1);
        assert_eq!(kick_pose(KickType::LeftStraight, 1.0), (Vec2::ZERO, 0.0));
        // The ball of a left side kick is on the right, at -y, and so is where the leg swings.
        assert!(kick_pose(KickType::LeftSide, 0.0).1 < 0.0);
    }
}

//! The poses of a robot's limbs while it stands, walks and kicks.
//!
//! The joints are at the places given by the robot's [body](naoisis_core::robot::body). The simulation has no joints except the head, so
//! the legs are for display only: they step at the robot's speed, so that the foot on the ground does not slide.

use bevy::math::{Affine3A, Mat3, Vec2, Vec3, ops};
use core::f32::consts::PI;

use naoisis_core::geometry::{Pose, unit};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::body::{Body, Legs};
use naoisis_core::robot::head::HeadAngles;

/// Pairs of steps per second.
pub const STEP_FREQUENCY: f32 = 1.6;
/// The height of a foot in a step, m.
const STEP_LIFT: f32 = 0.02;
/// The time that a leg takes to return after a kick, s.
pub const KICK_S: f32 = 0.5;
/// The duration of the first part of a swing, in which the foot is drawn back or extended to the front, s.
const BEGINNING_S: f32 = 0.2;
/// The duration of the last part, in which the foot moves forward or, after an extension, to the side, s.
const STRIKING_S: f32 = 0.1;
/// The duration of a swing before the foot meets the ball, s, if the kick takes that long.
pub const SWING_S: f32 = BEGINNING_S + STRIKING_S;

/// A rigid limb of a robot. Its frame has the axes of the robot frame while the robot stands straight.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Limb {
    /// The trunk, in the robot frame.
    Trunk,
    /// The head, about the neck.
    Head,
    /// The left arm, about the shoulder.
    LeftArm,
    /// The right arm, about the shoulder.
    RightArm,
    /// The left thigh, about the hip.
    LeftThigh,
    /// The right thigh, about the hip.
    RightThigh,
    /// The left shank, about the knee.
    LeftShank,
    /// The right shank, about the knee.
    RightShank,
    /// The left foot, about the ankle.
    LeftFoot,
    /// The right foot, about the ankle.
    RightFoot,
}

impl Limb {
    /// The number of limbs.
    pub const COUNT: usize = 10;

    /// Left and right arm.
    pub const ARMS: [Limb; 2] = [Limb::LeftArm, Limb::RightArm];
    /// Left and right thigh.
    pub const THIGHS: [Limb; 2] = [Limb::LeftThigh, Limb::RightThigh];
    /// Left and right shank.
    pub const SHANKS: [Limb; 2] = [Limb::LeftShank, Limb::RightShank];
    /// Left and right foot.
    pub const FEET: [Limb; 2] = [Limb::LeftFoot, Limb::RightFoot];
}

/// The angles of a leg, radians.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct LegAngles {
    /// The thigh, forward from straight down.
    pub hip: f32,
    /// The shank, backward from the thigh.
    pub knee: f32,
    /// The whole leg, from straight down to the left.
    pub aside: f32,
}

/// The joint angles of a robot.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct JointAngles {
    /// The head.
    pub head: HeadAngles,
    /// Left and right leg.
    pub legs: [LegAngles; 2],
    /// Left and right arm, backward from hanging down, radians.
    pub arms: [f32; 2],
}

impl JointAngles {
    /// The poses of the limbs, indexed by [`Limb`], for a robot with the pose `world_from_robot`. Missing limbs have the pose of the robot.
    pub fn world_from_limbs(&self, body: &Body, world_from_robot: Affine3A) -> [Affine3A; Limb::COUNT] {
        let mut limbs = [world_from_robot; Limb::COUNT];
        let about = |joint: Vec3, rotation: Mat3| Affine3A::from_mat3_translation(rotation, joint);
        let head = about_z(self.head.yaw) * about_y(self.head.pitch);
        limbs[Limb::Head as usize] = world_from_robot * about(body.neck_m, head);
        for side in 0..2 {
            if let Some(arms) = body.arms {
                let arm = about(on_side(arms.shoulder_m, side), about_y(self.arms[side]));
                limbs[Limb::ARMS[side] as usize] = world_from_robot * arm;
            }
            let Some(legs) = body.legs else { continue };
            let LegAngles { hip, knee, aside } = self.legs[side];
            // A positive rotation about y turns a hanging limb backwards.
            let thigh = about_x(aside) * about_y(-hip);
            let thigh = world_from_robot * about(on_side(legs.hip_m, side), thigh);
            let shank = thigh * about(Vec3::NEG_Z * legs.thigh_m, about_y(knee));
            // The foot stays level.
            let foot = shank * about(Vec3::NEG_Z * legs.shank_m, about_y(hip - knee));
            limbs[Limb::THIGHS[side] as usize] = thigh;
            limbs[Limb::SHANKS[side] as usize] = shank;
            limbs[Limb::FEET[side] as usize] = foot;
        }
        limbs
    }
}

/// The transform of a robot that stands at `pose`.
pub fn world_from_standing(pose: Pose) -> Affine3A {
    Affine3A::from_mat3_translation(about_z(pose.heading), pose.position.extend(0.0))
}

// These use trigonometric functions that are the same on every platform.

pub(super) fn about_x(angle: f32) -> Mat3 {
    let Vec2 { x: cos, y: sin } = unit(angle);
    Mat3::from_cols(Vec3::X, Vec3::new(0.0, cos, sin), Vec3::new(0.0, -sin, cos))
}

pub(super) fn about_y(angle: f32) -> Mat3 {
    let Vec2 { x: cos, y: sin } = unit(angle);
    Mat3::from_cols(Vec3::new(cos, 0.0, -sin), Vec3::Y, Vec3::new(sin, 0.0, cos))
}

pub(super) fn about_z(angle: f32) -> Mat3 {
    let Vec2 { x: cos, y: sin } = unit(angle);
    Mat3::from_cols(Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0), Vec3::Z)
}

/// A point of the left side (`side` 0), or its mirror image on the right (`side` 1).
pub fn on_side(left: Vec3, side: usize) -> Vec3 {
    if side == 0 { left } else { left * Vec3::new(1.0, -1.0, 1.0) }
}

/// The position of a foot in its step relative to standing, forward and up, m. `phase` is in radians, the forward `speed` in m/s, and
/// `liveliness` is from 0 to 1.
pub fn step(phase: f32, speed: f32, liveliness: f32) -> Vec2 {
    // The foot is on the ground from phase pi/2 to 3 pi/2, in which it goes back by twice the amplitude while the robot goes forward by
    // speed times half a period.
    let amplitude = speed / (4.0 * STEP_FREQUENCY);
    Vec2::new(amplitude * ops::sin(phase), STEP_LIFT * liveliness * ops::cos(phase).max(0.0))
}

/// The position of the kicking foot relative to standing, forward and up, m, and the leg's swing to the left, radians. `age_s` is the time
/// since the ball was struck, negative before, and `swing_s` the duration of the swing before the strike.
///
/// A straight kick draws the foot back first; a side kick extends it to the front and then moves it aside (paper, section 3.2).
pub fn kick_pose(kick_type: KickType, age_s: f32, swing_s: f32) -> (Vec2, f32) {
    const DRAWN_BACK_M: Vec2 = Vec2::new(-0.05, 0.03);
    let smooth = |share: f32| {
        let share = share.clamp(0.0, 1.0);
        share * share * (3.0 - 2.0 * share)
    };
    if !(-swing_s..KICK_S).contains(&age_s) {
        return (Vec2::ZERO, 0.0);
    }
    let begun = if age_s < 0.0 { smooth((age_s + swing_s) / BEGINNING_S) } else { 1.0 };
    let struck = smooth((age_s + STRIKING_S) / STRIKING_S);
    let left = if age_s < 0.0 { 1.0 } else { smooth(1.0 - age_s / KICK_S) };
    let aside = match kick_type {
        KickType::LeftStraight | KickType::RightStraight | KickType::Custom(_) => {
            return ((begun * DRAWN_BACK_M).lerp(Vec2::new(0.11, 0.035), struck) * left, 0.0);
        }
        // The foot swings inwards.
        KickType::LeftSide => -0.3,
        KickType::RightSide => 0.3,
    };
    (Vec2::new(0.08, 0.025) * begun * left, aside * struck * left)
}

/// Returns the angles that move a foot forward and up by `step`, m, as far as the leg reaches.
pub fn leg_angles(legs: &Legs, step: Vec2) -> LegAngles {
    let (thigh, shank) = (legs.thigh_m, legs.shank_m);
    // From the hip, forward and down.
    let target = Vec2::new(step.x, thigh + shank - step.y);
    let distance = target.length().clamp((thigh + shank) / 4.0, thigh + shank);
    // The law of cosines, with the ankle `distance` away from the hip.
    let cosine =
        |a: f32, b: f32, opposite: f32| ((a * a + b * b - opposite * opposite) / (2.0 * a * b)).clamp(-1.0, 1.0);
    let at_hip = ops::acos(cosine(thigh, distance, shank));
    let at_knee = ops::acos(cosine(thigh, shank, distance));
    LegAngles { hip: ops::atan2(target.x, target.y) + at_hip, knee: PI - at_knee, aside: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limbs(joints: &JointAngles) -> [Vec3; Limb::COUNT] {
        joints.world_from_limbs(&Body::default(), Affine3A::IDENTITY).map(|limb| limb.translation.into())
    }

    #[test]
    fn the_foot_goes_where_it_should() {
        for step in [Vec2::ZERO, Vec2::new(0.0, 0.02), Vec2::new(0.05, 0.03), Vec2::new(-0.04, 0.02)] {
            let joints = JointAngles { legs: [leg_angles(&Legs::default(), step); 2], ..JointAngles::default() };
            let expected = on_side(Legs::default().hip_m, 1) + Vec3::new(step.x, 0.0, step.y - 0.1 - 0.1029);
            let reached = limbs(&joints)[Limb::RightFoot as usize];
            // The arc cosine near 1 loses half of the digits.
            assert!(reached.abs_diff_eq(expected, 1e-4), "{step}: {reached}");
        }
    }

    #[test]
    fn soles_are_on_the_ground_and_level() {
        let standing = limbs(&JointAngles::default())[Limb::LeftFoot as usize];
        assert!((standing.z - Legs::default().ankle_m).abs() < 1e-6);
        let joints =
            JointAngles { legs: [leg_angles(&Legs::default(), Vec2::new(0.05, 0.03)); 2], ..JointAngles::default() };
        let foot = joints.world_from_limbs(&Body::default(), Affine3A::IDENTITY)[Limb::LeftFoot as usize];
        assert!(Vec3::from(foot.matrix3.z_axis).abs_diff_eq(Vec3::Z, 1e-5));
    }

    #[test]
    fn knees_bend_forward() {
        let angles = leg_angles(&Legs::default(), Vec2::new(0.0, 0.03));
        assert!(angles.hip > 0.0 && angles.knee > 0.0);
    }

    #[test]
    fn the_head_turns_about_the_neck() {
        let joints = JointAngles { head: HeadAngles { yaw: PI / 2.0, pitch: 0.0 }, ..JointAngles::default() };
        let head = joints.world_from_limbs(&Body::default(), Affine3A::IDENTITY)[Limb::Head as usize];
        assert!(head.transform_point3(Vec3::X).abs_diff_eq(Body::default().neck_m + Vec3::Y, 1e-6));
        let joints = JointAngles { head: HeadAngles { yaw: 0.0, pitch: PI / 2.0 }, ..JointAngles::default() };
        let head = joints.world_from_limbs(&Body::default(), Affine3A::IDENTITY)[Limb::Head as usize];
        assert!(head.transform_point3(Vec3::X).abs_diff_eq(Body::default().neck_m - Vec3::Z, 1e-6));
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
        assert!(kick_pose(KickType::LeftStraight, 0.0, SWING_S).0.x > 0.1);
        assert_eq!(kick_pose(KickType::LeftStraight, 1.0, SWING_S), (Vec2::ZERO, 0.0));
        // The ball of a left side kick is on the right, at -y, and so is where the leg swings.
        assert!(kick_pose(KickType::LeftSide, 0.0, SWING_S).1 < 0.0);
    }

    #[test]
    fn a_swing_begins_and_ends_where_the_foot_stands_and_has_no_jumps() {
        for kick_type in KickType::ALL {
            assert_eq!(kick_pose(kick_type, -SWING_S - 0.01, SWING_S), (Vec2::ZERO, 0.0));
            let poses: Vec<(Vec2, f32)> =
                (-31..=51).map(|step| kick_pose(kick_type, step as f32 / 100.0, SWING_S)).collect();
            for pair in poses.windows(2) {
                // The foot moves 16 cm in a tenth of a second: at most 1.5 times the mean in a hundredth.
                assert!(pair[0].0.distance(pair[1].0) < 0.025 && (pair[0].1 - pair[1].1).abs() < 0.05, "{pair:?}");
            }
        }
        assert!(kick_pose(KickType::RightStraight, -0.1, SWING_S).0.x < -0.04);
    }
}

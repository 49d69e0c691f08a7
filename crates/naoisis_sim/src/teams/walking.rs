//! Walking to a place: the step along a way, the time that it takes, and the last stretch to the ball.

use bevy::prelude::*;
use core::f32::consts::{FRAC_PI_2, PI};

use naoisis_core::geometry::{angle_of, unrotate};
use naoisis_core::robot::gait::Gait;
use naoisis_core::robot::motion::{MotionSettings, WalkCommand};
use naoisis_sensing::sensing::status::BodyStatus;

/// A robot whose speed to the side is less than this share of that ahead walks only ahead and back.
const LEAST_SIDEWAYS_SHARE: f32 = 0.15;
/// A robot that does not walk sideways has arrived within this distance, m: it cannot correct the rest on the spot.
const THERE_WITHOUT_SIDEWAYS_M: f32 = 0.02;

/// Returns the next step towards a place along `way` (m, team frame), turning to face `facing`.
pub fn step_towards(forward: Vec2, way: Vec2, facing: Vec2, motion: &MotionSettings, period: f32) -> WalkCommand {
    if let Some(gait) = &motion.gait {
        let [x, y, turn] = velocity_towards(forward, way, facing, gait, motion).to_array();
        return WalkCommand::new(x * period, y * period, turn * period);
    }
    let step = unrotate(forward, way.clamp_length_max(motion.max_linear_mps * period));
    let most_turn = motion.max_angular * period;
    let turn = angle_of(unrotate(forward, facing)).clamp(-most_turn, most_turn);
    WalkCommand { dx: step.x, dy: step.y, dtheta: turn }
}

/// The velocity (m/s, m/s, rad/s, robot frame) with which a robot with a gait goes along `way` and turns to `facing`. It brakes so that
/// it stops at the end, and faces ahead on a longer way if it arrives sooner so.
fn velocity_towards(forward: Vec2, way: Vec2, facing: Vec2, gait: &Gait, motion: &MotionSettings) -> Vec3 {
    /// The robot has arrived within this distance, m, and angle, radians: the rest is within the play of its joints.
    const THERE: (f32, f32) = (0.008, 0.035);

    let distance = way.length();
    if !walks_sideways(motion) && distance > THERE_WITHOUT_SIDEWAYS_M {
        return velocity_ahead(forward, way, gait, motion);
    }
    let goes = distance > THERE.0 && walks_sideways(motion);
    let facing = if goes && is_sooner_ahead(forward, way, facing, gait, motion) { way / distance } else { facing };
    let angle = angle_of(unrotate(forward, facing));
    let turn = if angle.abs() > THERE.1 { gait.braking_turn(angle.abs()).max(gait.least_angular) } else { 0.0 };
    let speed = if goes { gait.braking_speed(distance).max(gait.least_mps) } else { 0.0 };
    let towards = unrotate(forward, way.normalize_or_zero()) * speed;
    gait.reachable(towards.extend(turn.copysign(angle)), motion)
}

/// Returns whether the robot walks sideways fast enough for it to be useful.
pub fn walks_sideways(motion: &MotionSettings) -> bool {
    motion.gait.is_none_or(|gait| gait.sideways_mps >= LEAST_SIDEWAYS_SHARE * motion.max_linear_mps)
}

/// The velocity of a robot that goes along `way` without walking sideways: it turns, and then walks ahead; on a short way it walks
/// backwards instead of turning around.
fn velocity_ahead(forward: Vec2, way: Vec2, gait: &Gait, motion: &MotionSettings) -> Vec3 {
    /// The robot turns on the spot if its way is at a greater angle than this, radians.
    const TURNS_FIRST: f32 = 0.5;
    /// The longest way that the robot walks backwards, m.
    const BACKS_M: f32 = 0.3;

    let distance = way.length();
    let backs = distance < BACKS_M && way.dot(forward) < 0.0 && gait.backward_mps > gait.least_mps;
    let sign = if backs { -1.0 } else { 1.0 };
    let angle = angle_of(unrotate(forward, sign * way));
    let turn = gait.braking_turn(angle.abs()).max(gait.least_angular).copysign(angle);
    let share = (1.0 - angle.abs() / TURNS_FIRST).max(0.0);
    let speed = sign * share * gait.braking_speed(distance).max(gait.least_mps);
    gait.reachable(Vec3::new(speed, 0.0, turn), motion)
}

/// Whether a robot is sooner at the end of `way` if it turns, walks ahead, and turns to `facing` at the end than if it faces `facing` all
/// the time.
fn is_sooner_ahead(forward: Vec2, way: Vec2, facing: Vec2, gait: &Gait, motion: &MotionSettings) -> bool {
    let (ahead_s, way_s) = (ahead_s(forward, way, facing, motion), aside_s(way, facing, gait, motion));
    // The angle is computed only if it matters: the way alone may take longer.
    ahead_s < way_s || ahead_s < way_s + turn_s(forward, facing, motion)
}

/// The time to turn to `way`, walk along it ahead, and turn to `facing`, s.
fn ahead_s(forward: Vec2, way: Vec2, facing: Vec2, motion: &MotionSettings) -> f32 {
    let ahead = way.normalize_or(facing);
    way.length() / motion.max_linear_mps + turn_s(forward, ahead, motion) + turn_s(ahead, facing, motion)
}

/// The time to walk along `way` while facing `facing`, s.
fn aside_s(way: Vec2, facing: Vec2, gait: &Gait, motion: &MotionSettings) -> f32 {
    let ahead = way.normalize_or(facing);
    let speed_mps = gait.reachable((unrotate(facing, ahead) * motion.max_linear_mps).extend(0.0), motion).length();
    way.length() / speed_mps
}

fn turn_s(from: Vec2, to: Vec2, motion: &MotionSettings) -> f32 {
    about_angle_between(from, to) / motion.max_angular
}

/// The angle between two directions, radians, to 1e-5. Without branches, which would be mispredicted here: an exact arc tangent branches
/// on the octant.
fn about_angle_between(from: Vec2, to: Vec2) -> f32 {
    let (along, across) = (from.dot(to), from.perp_dot(to).abs());
    let (less, more) = (along.abs().min(across), along.abs().max(across));
    let slope = less / more.max(f32::MIN_POSITIVE);
    let square = slope * slope;
    // Coefficients of the arc tangent up to 1 (Abramowitz and Stegun, 4.4.47).
    let factors = [0.020_835_1, -0.085_133, 0.180_141, -0.330_299_5, 0.999_866];
    let angle = slope * factors.into_iter().fold(0.0, |sum, factor| sum * square + factor);
    let angle = if across > along.abs() { FRAC_PI_2 - angle } else { angle };
    if along < 0.0 { PI - angle } else { angle }
}

/// Returns the approximate time that a robot with a gait takes to go along `way` and to face `facing` at the end, s, by the sooner of the
/// two manners of [`step_towards`].
pub fn walking_time_s(forward: Vec2, way: Vec2, facing: Vec2, gait: &Gait, motion: &MotionSettings) -> f32 {
    let ahead_s = ahead_s(forward, way, facing, motion);
    if !walks_sideways(motion) {
        return ahead_s;
    }
    let way_s = aside_s(way, facing, gait, motion);
    if way_s >= ahead_s { ahead_s } else { ahead_s.min(way_s + turn_s(forward, facing, motion)) }
}

/// Returns a lower bound of the time to go along `way` and to face `facing` at the end, s: from the straight way and the chord of the
/// angle.
pub fn least_walking_time_s(forward: Vec2, way: Vec2, facing: Vec2, motion: &MotionSettings) -> f32 {
    /// A margin for rounding.
    const SURELY: f32 = 0.999;
    SURELY * (way.length() / motion.max_linear_mps + forward.distance(facing) / motion.max_angular)
}

/// Returns the velocity of the legs (m/s, m/s, rad/s) after a cycle of `period` seconds with `command`, which is within what the robot can
/// walk, from the velocity `before`, as a robot reckons it from its gait. Zero for a robot without a gait, and for one that does not walk.
pub fn reckoned_velocity(
    before: Vec3,
    command: &WalkCommand,
    body: BodyStatus,
    motion: &MotionSettings,
    period: f32,
) -> Vec3 {
    let before = match body {
        // Kicks in walking do not stop the robot.
        BodyStatus::Walking | BodyStatus::Kicking | BodyStatus::Recovering => before,
        BodyStatus::Standing => Vec3::ZERO,
        _ => return Vec3::ZERO,
    };
    let Some(gait) = &motion.gait else { return Vec3::ZERO };
    let wanted = gait.walked(Vec3::new(command.dx, command.dy, command.dtheta) / period);
    gait.velocity_after(before, wanted, period)
}

/// Returns the next place on the way to a kick from `position`, facing `facing`: around the ball without touching it, then straight ahead.
/// A kick that can be aimed does not need the place and the facing as exactly.
///
/// Also returns whether the last stretch has begun, on which the ball is no obstacle.
pub fn approach(own: Vec2, forward: Vec2, position: Vec2, facing: Vec2, can_be_aimed: bool) -> (Vec2, bool) {
    /// How fast the corridor behind the place widens, and the least cosine of the angle to `facing`.
    const EXACT: (f32, f32) = (0.3, 0.96);
    /// The same for a kick that can be aimed.
    const AIMED: (f32, f32) = (0.6, 0.9);

    let (slope, least_cosine) = if can_be_aimed { AIMED } else { EXACT };
    let offset = unrotate(facing, own - position);
    let behind = -offset.x;
    let in_corridor = behind > -0.02 && offset.y.abs() < 0.02 + slope * behind.clamp(0.0, 0.3);
    let aligned = facing.dot(forward) > least_cosine;
    if in_corridor && aligned && behind < 0.3 { (position, true) } else { (position - facing * 0.09, false) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::FRAC_PI_2;
    use naoisis_core::geometry::{Pose, unit};
    use naoisis_core::random::RandomStream;
    use naoisis_core::robot::gait::GaitState;
    use naoisis_core::robot::motion::after_step;

    #[test]
    fn steps_stay_within_the_limits_and_are_in_the_robots_frame() {
        let motion = MotionSettings::default();
        // Facing +y, to go along +x is to go to the right.
        let step = step_towards(Vec2::Y, Vec2::new(1.0, 0.0), Vec2::X, &motion, 1.0 / 30.0);
        assert_abs_diff_eq!(step.dx, 0.0, epsilon = 1e-7);
        assert_abs_diff_eq!(step.dy, -0.2 / 30.0, epsilon = 1e-7);
        assert_abs_diff_eq!(step.dtheta, -FRAC_PI_2 / 30.0, epsilon = 1e-7);
    }

    #[test]
    fn a_robot_with_a_gait_arrives_without_turning_back_and_faces_as_planned() {
        const PERIOD: f32 = 1.0 / 30.0;
        let motion = MotionSettings { gait: Some(Gait::default()), ..MotionSettings::default() };
        let gait = Gait::default();
        for index in 0..24 {
            let place = unit(0.26 * index as f32) * (0.05 + 0.1 * index as f32);
            let facing = unit(1.7 * index as f32);
            let (mut pose, mut state, mut nearest, mut seconds) =
                (Pose::default(), GaitState::default(), f32::MAX, 0.0);
            for cycle in 0..30 * 40 {
                let way = place - pose.position;
                let command = step_towards(pose.forward(), way, facing, &motion, PERIOD);
                let [step, _] = state.walk(command, &gait, &motion, PERIOD, &mut RandomStream::for_match(1, "test"));
                if step.is_null() && command.is_null() {
                    break;
                }
                pose = after_step(pose, step);
                nearest = nearest.min(way.length());
                // The step under way goes on after a new command, so the robot may move away a little.
                assert!(way.length() < nearest + 0.04, "walk {index} turns back at {pose:?}");
                seconds = cycle as f32 * PERIOD;
            }
            assert!(pose.position.distance(place) < 0.012, "walk {index} ends {} off", pose.position.distance(place));
            assert!(angle_of(unrotate(pose.forward(), facing)).abs() < 0.08, "walk {index} ends at {pose:?}");
            // Straight ahead at full speed, a turn at each end, and what starting and stopping take.
            let soonest_s = place.length() / 0.2 + 2.0 * PI / motion.max_angular;
            assert!(seconds < soonest_s + 3.0, "walk {index} takes {seconds} s");
        }
    }

    #[test]
    fn a_robot_that_cannot_walk_sideways_arrives_everywhere_ahead_and_back() {
        const PERIOD: f32 = 1.0 / 30.0;
        let gait = Gait { sideways_mps: 0.005, ..Gait::default() };
        let motion = MotionSettings { gait: Some(gait), ..MotionSettings::default() };
        assert!(!walks_sideways(&motion) && walks_sideways(&MotionSettings::default()));
        for index in 0..24 {
            let place = unit(0.26 * index as f32) * (0.1 + 0.1 * index as f32);
            let facing = unit(1.7 * index as f32);
            let (mut pose, mut state) = (Pose::default(), GaitState::default());
            for _ in 0..30 * 60 {
                let command = step_towards(pose.forward(), place - pose.position, facing, &motion, PERIOD);
                assert_eq!(command.dy, 0.0);
                let [step, _] = state.walk(command, &gait, &motion, PERIOD, &mut RandomStream::for_match(1, "test"));
                pose = after_step(pose, step);
            }
            assert!(pose.position.distance(place) < 0.05, "walk {index} ends {} off", pose.position.distance(place));
            assert!(angle_of(unrotate(pose.forward(), facing)).abs() < 0.1, "walk {index} ends at {pose:?}");
        }
    }

    #[test]
    fn angles_between_directions_are_as_they_should_be_and_walks_take_no_less_than_the_least() {
        let motion = MotionSettings::default();
        for index in 1..200 {
            let (forward, facing) = (unit(0.31 * index as f32), unit(1.7 * index as f32));
            let angle = angle_of(unrotate(forward, facing)).abs();
            assert_abs_diff_eq!(about_angle_between(forward, facing), angle, epsilon = 2e-5);
            let way = unit(0.7 * index as f32) * (0.02 * index as f32);
            let least_s = least_walking_time_s(forward, way, facing, &motion);
            assert!(walking_time_s(forward, way, facing, &Gait::default(), &motion) > least_s, "{index}");
        }
        assert_abs_diff_eq!(about_angle_between(Vec2::X, Vec2::X), 0.0, epsilon = 1e-6);
        assert_abs_diff_eq!(about_angle_between(Vec2::X, -Vec2::X), PI, epsilon = 1e-6);
        assert_eq!(about_angle_between(Vec2::ZERO, Vec2::X), 0.0);
    }

    #[test]
    fn the_last_stretch_begins_behind_the_ball_and_facing_it() {
        let place = Vec2::new(1.0, 0.0);
        let begins = |own: Vec2, forward: Vec2| approach(own, forward, place, Vec2::X, false).1;
        let begins_aimed = |own: Vec2, forward: Vec2| approach(own, forward, place, Vec2::X, true).1;
        assert!(begins(Vec2::new(0.85, 0.0), Vec2::X));
        assert!(begins(Vec2::new(0.85, 0.05), Vec2::X));
        assert!(!begins(Vec2::new(0.85, 0.15), Vec2::X), "too far aside");
        assert!(!begins(Vec2::new(0.85, 0.0), Vec2::Y), "not facing the ball");
        assert!(!begins(Vec2::new(0.85, 0.1), unit(0.4)) && begins_aimed(Vec2::new(0.85, 0.1), unit(0.4)));
        assert!(!begins_aimed(Vec2::new(0.85, 0.15), Vec2::X) && !begins_aimed(Vec2::new(0.85, 0.0), unit(0.5)));
        assert!(!begins(Vec2::new(1.1, 0.0), Vec2::X), "too near the ball");
        assert!(!begins(Vec2::new(0.5, 0.0), Vec2::X), "too far away");
    }
}

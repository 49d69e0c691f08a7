//! Walking to a place: past robots and posts, and around the ball without touching it.

use bevy::prelude::*;
use core::f32::consts::{FRAC_PI_2, PI};

use naoisis_core::geometry::{angle_of, unrotate};
use naoisis_core::robot::gait::Gait;
use naoisis_core::robot::motion::{MotionLimits, WalkCommand};

/// The distance from the ball at which a NAO can turn without touching it, m: the corner of its toes is 15 cm from its origin, and the
/// radius of the ball is 3 cm.
pub const BALL_CLEARANCE_M: f32 = 0.21;
/// The least distance of two robots' places, m: half the width of each torso, and a margin.
pub const ROBOT_CLEARANCE_M: f32 = 0.36;
/// The least distance from the centre of a post, m: half the width of the torso, the post's radius, and a margin.
pub const POST_CLEARANCE_M: f32 = 0.25;
/// The greatest distance at which obstacles count, m.
pub const OBSTACLE_RANGE_M: f32 = 1.5;
/// The greatest age of the place of a robot that is avoided, s.
pub const OBSTACLE_MEMORY_S: f32 = 4.0;
/// The greatest age of the reported place of a team-mate that is avoided, s.
pub const REPORTED_MEMORY_S: f32 = 2.0;
/// The radius at which an obstacle is passed, as a multiple of its own, so that the player returns to the straight way.
const PASSING_FACTOR: f32 = 1.02;
/// A robot whose speed to the side is less than this share of that ahead walks only ahead and back.
const LEAST_SIDEWAYS_SHARE: f32 = 0.15;
/// The greatest number of obstacles.
const MOST_OBSTACLES: usize = 24;

/// A circle that the robot's origin should not enter.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Obstacle {
    /// Centre, m, team frame.
    pub centre: Vec2,
    /// Radius, m.
    pub radius_m: f32,
}

/// The obstacles of a player.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Obstacles {
    circles: [Obstacle; MOST_OBSTACLES],
    count: usize,
}

impl Default for Obstacles {
    fn default() -> Self {
        Self { circles: [Obstacle::default(); MOST_OBSTACLES], count: 0 }
    }
}

impl Obstacles {
    /// Adds an obstacle; more than 24 are ignored.
    pub fn add(&mut self, centre: Vec2, radius_m: f32) {
        if let Some(circle) = self.circles.get_mut(self.count) {
            *circle = Obstacle { centre, radius_m };
            self.count += 1;
        }
    }

    /// All obstacles, in the order in which they were added.
    pub fn iter(&self) -> impl Iterator<Item = &Obstacle> {
        self.circles[..self.count].iter()
    }
}

/// The next step towards a place along `way` (m, team frame), turning to face `facing`.
pub fn step_towards(forward: Vec2, way: Vec2, facing: Vec2, limits: &MotionLimits, period: f32) -> WalkCommand {
    if let Some(gait) = &limits.gait {
        let [x, y, turn] = velocity_towards(forward, way, facing, gait, limits).to_array();
        return WalkCommand::new(x * period, y * period, turn * period);
    }
    let step = unrotate(forward, way.clamp_length_max(limits.max_linear_mps * period));
    let most_turn = limits.max_angular * period;
    let turn = angle_of(unrotate(forward, facing)).clamp(-most_turn, most_turn);
    WalkCommand { dx: step.x, dy: step.y, dtheta: turn }
}

/// The velocity (m/s, m/s, rad/s, robot frame) with which a robot with a gait goes along `way` and turns to `facing`. It brakes so that
/// it stops at the end, and faces ahead on a longer way if it arrives sooner so.
fn velocity_towards(forward: Vec2, way: Vec2, facing: Vec2, gait: &Gait, limits: &MotionLimits) -> Vec3 {
    /// The robot has arrived within this distance, m, and angle, radians: the rest is within the play of its joints.
    const THERE: (f32, f32) = (0.008, 0.035);

    let distance = way.length();
    if !walks_sideways(limits) && distance > THERE_WITHOUT_SIDEWAYS_M {
        return velocity_ahead(forward, way, gait, limits);
    }
    let goes = distance > THERE.0 && walks_sideways(limits);
    let facing = if goes && is_sooner_ahead(forward, way, facing, gait, limits) { way / distance } else { facing };
    let angle = angle_of(unrotate(forward, facing));
    let turn = if angle.abs() > THERE.1 { gait.braking_turn(angle.abs()).max(gait.least_angular) } else { 0.0 };
    let speed = if goes { gait.braking_speed(distance).max(gait.least_mps) } else { 0.0 };
    let towards = unrotate(forward, way.normalize_or_zero()) * speed;
    gait.reachable(towards.extend(turn.copysign(angle)), limits)
}

/// A robot that does not walk sideways has arrived within this distance, m: it cannot correct the rest on the spot.
const THERE_WITHOUT_SIDEWAYS_M: f32 = 0.02;

/// Whether the robot walks sideways fast enough for it to be useful.
pub fn walks_sideways(limits: &MotionLimits) -> bool {
    limits.gait.is_none_or(|gait| gait.sideways_mps >= LEAST_SIDEWAYS_SHARE * limits.max_linear_mps)
}

/// The velocity of a robot that goes along `way` without walking sideways: it turns, and then walks ahead; on a short way it walks
/// backwards instead of turning around.
fn velocity_ahead(forward: Vec2, way: Vec2, gait: &Gait, limits: &MotionLimits) -> Vec3 {
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
    gait.reachable(Vec3::new(speed, 0.0, turn), limits)
}

/// Whether a robot is sooner at the end of `way` if it turns, walks ahead, and turns to `facing` at the end than if it faces `facing` all
/// the time.
fn is_sooner_ahead(forward: Vec2, way: Vec2, facing: Vec2, gait: &Gait, limits: &MotionLimits) -> bool {
    let (ahead_s, way_s) = (ahead_s(forward, way, facing, limits), aside_s(way, facing, gait, limits));
    // The angle is computed only if it matters: the way alone may take longer.
    ahead_s < way_s || ahead_s < way_s + turn_s(forward, facing, limits)
}

/// The time to turn to `way`, walk along it ahead, and turn to `facing`, s.
fn ahead_s(forward: Vec2, way: Vec2, facing: Vec2, limits: &MotionLimits) -> f32 {
    let ahead = way.normalize_or(facing);
    way.length() / limits.max_linear_mps + turn_s(forward, ahead, limits) + turn_s(ahead, facing, limits)
}

/// The time to walk along `way` while facing `facing`, s.
fn aside_s(way: Vec2, facing: Vec2, gait: &Gait, limits: &MotionLimits) -> f32 {
    let ahead = way.normalize_or(facing);
    let speed_mps = gait.reachable((unrotate(facing, ahead) * limits.max_linear_mps).extend(0.0), limits).length();
    way.length() / speed_mps
}

fn turn_s(from: Vec2, to: Vec2, limits: &MotionLimits) -> f32 {
    about_angle_between(from, to) / limits.max_angular
}

/// The angle between two directions, radians, to 1e-5. Without branches, which would be mispredicted here: an exact arc tangent branches
/// on the octant.
fn about_angle_between(from: Vec2, to: Vec2) -> f32 {
    let (along, across) = (from.dot(to), from.perp_dot(to).abs());
    let (less, more) = (along.abs().min(across), along.abs().max(across));
    let slope = less / more.max(f32::MIN_POSITIVE);
    let square = slope * slope;
    // Of the arc tangent up to 1 (Abramowitz and Stegun, 4.4.47).
    let factors = [0.020_835_1, -0.085_133, 0.180_141, -0.330_299_5, 0.999_866];
    let angle = slope * factors.into_iter().fold(0.0, |sum, factor| sum * square + factor);
    let angle = if across > along.abs() { FRAC_PI_2 - angle } else { angle };
    if along < 0.0 { PI - angle } else { angle }
}

/// The approximate time that a robot with a gait takes to go along `way` and to face `facing` at the end, s, by the sooner of the two
/// manners of [`step_towards`].
pub fn walking_time_s(forward: Vec2, way: Vec2, facing: Vec2, gait: &Gait, limits: &MotionLimits) -> f32 {
    let ahead_s = ahead_s(forward, way, facing, limits);
    if !walks_sideways(limits) {
        return ahead_s;
    }
    let way_s = aside_s(way, facing, gait, limits);
    if way_s >= ahead_s { ahead_s } else { ahead_s.min(way_s + turn_s(forward, facing, limits)) }
}

/// A lower bound of the time to go along `way` and to face `facing` at the end, s: from the straight way and the chord of the angle.
pub fn least_walking_time_s(forward: Vec2, way: Vec2, facing: Vec2, limits: &MotionLimits) -> f32 {
    /// A margin for rounding.
    const SURELY: f32 = 0.999;
    SURELY * (way.length() / limits.max_linear_mps + forward.distance(facing) / limits.max_angular)
}

/// The way to go now to reach `to` past the obstacles: straight, or along the tangent of the first obstacle on the way.
///
/// An obstacle that contains `to` is shrunk so that it can be reached. A robot inside an obstacle leaves it sideways and outwards.
pub fn way_around(from: Vec2, to: Vec2, obstacles: &Obstacles) -> Vec2 {
    let way = to - from;
    let distance = way.length();
    if distance < 1e-4 {
        return Vec2::ZERO;
    }
    let first = obstacles
        .iter()
        .filter_map(|obstacle| {
            let radius = obstacle.radius_m.min(0.9 * obstacle.centre.distance(to));
            blocks(from, way / distance, distance, obstacle.centre, radius).then_some((obstacle.centre, radius))
        })
        .min_by(|(first, _), (second, _)| first.distance_squared(from).total_cmp(&second.distance_squared(from)));
    let Some((centre, radius)) = first else { return way };
    let clear = |way: Vec2, length: f32| {
        obstacles
            .iter()
            .filter(|other| other.centre != centre)
            .all(|other| !blocks(from, way.normalize_or_zero(), length, other.centre, 0.8 * other.radius_m))
    };
    // On the nearer side, unless it is blocked and the other one is not.
    let side = if way.perp_dot(centre - from) > 0.0 { -1.0 } else { 1.0 };
    let near = tangent(from, centre, radius, side);
    if clear(near, near.length()) {
        return near;
    }
    let far = tangent(from, centre, radius, -side);
    if clear(far, far.length()) { far } else { near }
}

/// Whether a straight way in `direction` over `distance` meets the circle.
fn blocks(from: Vec2, direction: Vec2, distance: f32, centre: Vec2, radius: f32) -> bool {
    let offset = centre - from;
    let along = direction.dot(offset);
    along > 0.0 && along - radius < distance && direction.perp_dot(offset).abs() < radius
}

/// The way to the point where the tangent touches the circle, on its right (`side` = -1) or left (+1); from inside, outwards and around.
fn tangent(from: Vec2, centre: Vec2, radius: f32, side: f32) -> Vec2 {
    let offset = centre - from;
    let distance_squared = offset.length_squared();
    let radius = radius * PASSING_FACTOR;
    if distance_squared <= radius * radius {
        let distance = distance_squared.sqrt().max(1e-3);
        let outwards = -offset / distance;
        let depth = (radius - distance) / radius;
        return (outwards * (2.0 * depth).min(1.0) + side * offset.perp() / distance).normalize_or_zero() * radius;
    }
    // The tangent's length is √(d² - r²); it is turned from the centre's direction by the angle of sine r / d.
    let length = (distance_squared - radius * radius).sqrt();
    let turned = Vec2::new(length, side * radius) / distance_squared.sqrt();
    turned.rotate(offset) * (length / distance_squared.sqrt())
}

/// The next place on the way to a kick from `position`, facing `facing`: around the ball without touching it, then straight ahead.
///
/// Also returns whether the last stretch has begun, on which the ball is no obstacle.
pub fn approach(own: Vec2, forward: Vec2, position: Vec2, facing: Vec2) -> (Vec2, bool) {
    let offset = unrotate(facing, own - position);
    let behind = -offset.x;
    let in_corridor = behind > -0.02 && offset.y.abs() < 0.02 + 0.3 * behind.clamp(0.0, 0.3);
    let aligned = facing.dot(forward) > 0.96;
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

    fn one_obstacle(x: f32, y: f32, radius: f32) -> Obstacles {
        let mut obstacles = Obstacles::default();
        obstacles.add(Vec2::new(x, y), radius);
        obstacles
    }

    #[test]
    fn a_free_way_is_straight() {
        let to = Vec2::new(2.0, 1.0);
        assert_eq!(way_around(Vec2::ZERO, to, &Obstacles::default()), to);
        assert_eq!(way_around(Vec2::ZERO, to, &one_obstacle(-0.5, -0.25, 0.3)), to);
        assert_eq!(way_around(Vec2::ZERO, to, &one_obstacle(1.0, 1.5, 0.3)), to);
        // Behind the place to reach.
        assert_eq!(way_around(Vec2::ZERO, to, &one_obstacle(3.0, 1.5, 0.3)), to);
    }

    #[test]
    fn an_obstacle_is_passed_along_its_tangent_on_the_nearer_side() {
        let obstacles = one_obstacle(1.0, 0.1, 0.5);
        let way = way_around(Vec2::ZERO, Vec2::new(3.0, 0.0), &obstacles);
        assert!(way.y < 0.0, "the centre is on the left: pass on the right");
        // A tangent is at a distance of the radius, and the 2 % more, from the centre.
        let distance = way.normalize().perp_dot(Vec2::new(1.0, 0.1)).abs();
        assert_abs_diff_eq!(distance, 0.51, epsilon = 1e-4);
    }

    #[test]
    fn a_way_that_is_walled_off_on_one_side_leads_around_the_other() {
        let mut obstacles = one_obstacle(1.0, 0.05, 0.3);
        obstacles.add(Vec2::new(0.8, -0.45), 0.3);
        assert!(way_around(Vec2::ZERO, Vec2::new(3.0, 0.0), &obstacles).y > 0.0);
    }

    #[test]
    fn a_walk_past_obstacles_arrives_and_keeps_its_distance() {
        let to = Vec2::new(3.0, 0.2);
        let mut obstacles = one_obstacle(1.0, 0.0, 0.36);
        obstacles.add(Vec2::new(2.0, 0.5), 0.36);
        let mut position = Vec2::ZERO;
        for _ in 0..600 {
            position += way_around(position, to, &obstacles).clamp_length_max(0.2 / 30.0);
            for obstacle in obstacles.iter() {
                assert!(position.distance(obstacle.centre) > 0.98 * obstacle.radius_m, "{position}");
            }
        }
        assert_abs_diff_eq!(position, to, epsilon = 1e-4);
    }

    #[test]
    fn a_robot_that_stands_too_near_moves_away() {
        let obstacles = one_obstacle(0.1, 0.0, 0.4);
        let way = way_around(Vec2::ZERO, Vec2::new(2.0, 0.0), &obstacles);
        assert!(way.x < 0.0 && way.y.abs() > 0.0, "{way}");
    }

    #[test]
    fn steps_stay_within_the_limits_and_are_in_the_robots_frame() {
        let limits = MotionLimits::default();
        // Facing +y, to go along +x is to go to the right.
        let step = step_towards(Vec2::Y, Vec2::new(1.0, 0.0), Vec2::X, &limits, 1.0 / 30.0);
        assert_abs_diff_eq!(step.dx, 0.0, epsilon = 1e-7);
        assert_abs_diff_eq!(step.dy, -0.2 / 30.0, epsilon = 1e-7);
        assert_abs_diff_eq!(step.dtheta, -FRAC_PI_2 / 30.0, epsilon = 1e-7);
    }

    #[test]
    fn a_robot_with_a_gait_arrives_without_turning_back_and_faces_as_planned() {
        const PERIOD: f32 = 1.0 / 30.0;
        let limits = MotionLimits { gait: Some(Gait::default()), ..MotionLimits::default() };
        let gait = Gait::default();
        for index in 0..24 {
            let place = unit(0.26 * index as f32) * (0.05 + 0.1 * index as f32);
            let facing = unit(1.7 * index as f32);
            let (mut pose, mut state, mut nearest, mut seconds) =
                (Pose::default(), GaitState::default(), f32::MAX, 0.0);
            for cycle in 0..30 * 40 {
                let way = place - pose.position;
                let command = step_towards(pose.forward(), way, facing, &limits, PERIOD);
                let [step, _] = state.walk(command, &gait, &limits, PERIOD, &mut RandomStream::for_match(1, "test"));
                if step.is_null() && command.is_null() {
                    break;
                }
                pose = after_step(pose, step);
                nearest = nearest.min(way.length());
                // What it takes for a step that goes on while it is told otherwise.
                assert!(way.length() < nearest + 0.04, "walk {index} turns back at {pose:?}");
                seconds = cycle as f32 * PERIOD;
            }
            assert!(pose.position.distance(place) < 0.012, "walk {index} ends {} off", pose.position.distance(place));
            assert!(angle_of(unrotate(pose.forward(), facing)).abs() < 0.08, "walk {index} ends at {pose:?}");
            // Straight ahead at full speed, a turn at each end, and what starting and stopping take.
            let soonest_s = place.length() / 0.2 + 2.0 * PI / limits.max_angular;
            assert!(seconds < soonest_s + 3.0, "walk {index} takes {seconds} s");
        }
    }

    #[test]
    fn a_robot_that_cannot_walk_sideways_arrives_everywhere_ahead_and_back() {
        const PERIOD: f32 = 1.0 / 30.0;
        let gait = Gait { sideways_mps: 0.005, ..Gait::default() };
        let limits = MotionLimits { gait: Some(gait), ..MotionLimits::default() };
        assert!(!walks_sideways(&limits) && walks_sideways(&MotionLimits::default()));
        for index in 0..24 {
            let place = unit(0.26 * index as f32) * (0.1 + 0.1 * index as f32);
            let facing = unit(1.7 * index as f32);
            let (mut pose, mut state) = (Pose::default(), GaitState::default());
            for _ in 0..30 * 60 {
                let command = step_towards(pose.forward(), place - pose.position, facing, &limits, PERIOD);
                assert_eq!(command.dy, 0.0);
                let [step, _] = state.walk(command, &gait, &limits, PERIOD, &mut RandomStream::for_match(1, "test"));
                pose = after_step(pose, step);
            }
            assert!(pose.position.distance(place) < 0.05, "walk {index} ends {} off", pose.position.distance(place));
            assert!(angle_of(unrotate(pose.forward(), facing)).abs() < 0.1, "walk {index} ends at {pose:?}");
        }
    }

    #[test]
    fn angles_between_directions_are_as_they_should_be_and_walks_take_no_less_than_the_least() {
        let limits = MotionLimits::default();
        for index in 1..200 {
            let (forward, facing) = (unit(0.31 * index as f32), unit(1.7 * index as f32));
            let angle = angle_of(unrotate(forward, facing)).abs();
            assert_abs_diff_eq!(about_angle_between(forward, facing), angle, epsilon = 2e-5);
            let way = unit(0.7 * index as f32) * (0.02 * index as f32);
            let least_s = least_walking_time_s(forward, way, facing, &limits);
            assert!(walking_time_s(forward, way, facing, &Gait::default(), &limits) > least_s, "{index}");
        }
        assert_abs_diff_eq!(about_angle_between(Vec2::X, Vec2::X), 0.0, epsilon = 1e-6);
        assert_abs_diff_eq!(about_angle_between(Vec2::X, -Vec2::X), PI, epsilon = 1e-6);
        assert_eq!(about_angle_between(Vec2::ZERO, Vec2::X), 0.0);
    }

    #[test]
    fn the_last_stretch_begins_behind_the_ball_and_facing_it() {
        let place = Vec2::new(1.0, 0.0);
        let begins = |own: Vec2, forward: Vec2| approach(own, forward, place, Vec2::X).1;
        assert!(begins(Vec2::new(0.85, 0.0), Vec2::X));
        assert!(begins(Vec2::new(0.85, 0.05), Vec2::X));
        assert!(!begins(Vec2::new(0.85, 0.15), Vec2::X), "too far aside");
        assert!(!begins(Vec2::new(0.85, 0.0), Vec2::Y), "not facing the ball");
        assert!(!begins(Vec2::new(1.1, 0.0), Vec2::X), "too near the ball");
        assert!(!begins(Vec2::new(0.5, 0.0), Vec2::X), "too far away");
    }
}

//! The ball's path in a cycle: it rolls by its law, and bounces off moving and static obstacles.
//!
//! The ball cannot tunnel through an obstacle: the time of the next contact is found by conservative advancement (Mirtich, 1996).
//! The distance between ball and obstacle and a bound on their closing speed give a time in which they cannot touch; advancing by
//! this time repeatedly converges to the contact.

use bevy::prelude::*;

use super::ball_obstacle::BallObstacle;
use crate::ball::RollingBall;

/// Distance at which ball and obstacle are in contact, m.
pub(super) const CONTACT_DISTANCE: f32 = 1e-4;
/// Least approach speed of a contact, m/s.
pub(super) const LEAST_APPROACH: f32 = 1e-5;
/// Greatest number of bounces in a cycle; a ball with more is wedged.
pub(super) const MOST_BOUNCES: usize = 24;
/// Number of consecutive bounces off the same obstacle from which the ball rolls along it.
const BOUNCES_TO_ROLL_ALONG: usize = 8;
/// Least speed at which such a ball separates from the obstacle, m/s, doubled with each further contact.
const LEAST_PARTING_SPEED: f32 = 0.002;
/// Greatest penetration of an obstacle in a step of the search for contacts, m.
pub(super) const DEEPEST_STEP: f32 = 5.0 * CONTACT_DISTANCE;
/// Greatest number of steps of one conservative advancement: a ball that grazes a turning robot at little more than the contact distance
/// advances only by about that distance in each step, and in a long cycle moves by some 20 cm.
const MOST_ADVANCES: usize = 2048;

/// A contact of the ball with an obstacle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BallContact {
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Approach speed, m/s.
    pub approach_speed: f32,
    /// The ball's speed before the contact, m/s.
    pub ball_speed: f32,
    /// The ball's centre, m.
    pub position: Vec2,
    /// The direction away from the obstacle; of a flying ball, its part along the ground.
    pub normal: Vec2,
}

/// Rolls the ball for `duration` seconds among the obstacles. Pushes every bounce to `contacts`, and every vertex of the path,
/// including its start and end, to `path`.
///
/// A ball that overlaps an obstacle at the start may stay where it is (a NAO kicks a ball that lies over its toes), but does not penetrate
/// deeper. Returns `None` if the ball is wedged between obstacles that close in on it.
pub(crate) fn roll_ball(
    ball: RollingBall,
    obstacles: &[BallObstacle],
    duration: f32,
    contacts: &mut Vec<BallContact>,
    path: &mut Vec<Vec2>,
) -> Option<RollingBall> {
    contacts.clear();
    path.clear();
    path.push(ball.position);
    let mut now = ball;
    let mut time = 0.0;
    for _ in 0..=MOST_BOUNCES {
        let next = obstacles
            .iter()
            .enumerate()
            .filter_map(|(index, obstacle)| Some((time_of_contact(&ball, &now, obstacle, time, duration)?, index)))
            .min_by(|((first, ..), _), ((second, ..), _)| first.total_cmp(second));
        let Some(((contact_time, normal), index)) = next else {
            let mut end = now.after(duration - time);
            for obstacle in obstacles {
                end.position += way_out(obstacle, &ball, end.position, 1.0);
            }
            path.push(end.position);
            return obstacles.iter().all(|obstacle| is_clear(obstacle, &ball, &end)).then_some(end);
        };
        now = now.after(contact_time - time);
        time = contact_time;
        now.position += way_out(&obstacles[index], &ball, now.position, time / duration);
        path.push(now.position);
        let surface = obstacles[index].velocity_at(now.position, time / duration, duration);
        let (foot_mps, direction) = obstacles[index].foot_at(normal);
        let approach_speed = foot_mps - (now.velocity - surface).dot(normal);
        contacts.push(BallContact {
            obstacle: index,
            approach_speed,
            ball_speed: now.velocity.length(),
            position: now.position,
            normal,
        });
        let bounce = (1.0 + obstacles[index].restitution(now.restitution)) * approach_speed;
        now.velocity += direction * bounce.max(approach_speed + least_parting_speed(contacts));
    }
    None
}

/// The least speed at which the ball separates from the obstacle that it has just touched.
///
/// With the restitution alone, a ball that rolls along a robot which turns towards it, or that a robot pushes, would have endlessly many
/// contacts in ever shorter intervals.
fn least_parting_speed(contacts: &[BallContact]) -> f32 {
    let Some(last) = contacts.last() else { return 0.0 };
    let in_a_row = contacts.iter().rev().take_while(|contact| contact.obstacle == last.obstacle).count();
    match in_a_row.checked_sub(BOUNCES_TO_ROLL_ALONG) {
        Some(beyond) => LEAST_PARTING_SPEED * (1_u32 << beyond) as f32,
        None => 0.0,
    }
}

/// The least distance of the ball from the obstacle: its radius, or less if it is already closer.
fn clearance_at_start(obstacle: &BallObstacle, ball: &RollingBall) -> f32 {
    obstacle.signed_distance(ball.position, 0.0).0.min(ball.radius)
}

/// The displacement out of an obstacle that the ball penetrates by less than a step of the search for contacts. Without this displacement
/// the ball would penetrate deeper in every cycle.
fn way_out(obstacle: &BallObstacle, start: &RollingBall, position: Vec2, share: f32) -> Vec2 {
    if !obstacle.is_near(position, start.radius) {
        return Vec2::ZERO;
    }
    let (distance, normal) = obstacle.signed_distance(position, share);
    let depth = clearance_at_start(obstacle, start) - distance;
    if (0.0..=DEEPEST_STEP).contains(&depth) { normal * depth } else { Vec2::ZERO }
}

/// Whether the ball at the `end` of the cycle keeps its least distance from the obstacle; the final check of the result.
fn is_clear(obstacle: &BallObstacle, start: &RollingBall, end: &RollingBall) -> bool {
    !obstacle.is_near(end.position, end.radius)
        || obstacle.signed_distance(end.position, 1.0).0 > clearance_at_start(obstacle, start) - DEEPEST_STEP
}

/// The time, from `start` on, at which the ball touches the obstacle while approaching it, and the normal at the contact.
fn time_of_contact(
    at_start_of_cycle: &RollingBall,
    ball: &RollingBall,
    obstacle: &BallObstacle,
    start: f32,
    duration: f32,
) -> Option<(f32, Vec2)> {
    let bound = ball.velocity.length() + obstacle.greatest_speed(duration);
    if bound == 0.0 || !obstacle.is_near(ball.position, ball.radius + bound * (duration - start) + CONTACT_DISTANCE) {
        return None;
    }
    let clearance = clearance_at_start(obstacle, at_start_of_cycle);
    let mut time = start;
    for _ in 0..MOST_ADVANCES {
        let now = ball.after(time - start);
        let share = time / duration;
        let (distance, normal) = obstacle.signed_distance(now.position, share);
        let gap = distance - clearance;
        let mut safe = gap / bound;
        if gap <= CONTACT_DISTANCE {
            let approach = -(now.velocity - obstacle.velocity_at(now.position, share, duration)).dot(normal);
            if approach > LEAST_APPROACH {
                return Some((time, normal));
            }
            // On a straight path past a static convex obstacle, a ball that has begun to separate never touches it again. A moving obstacle
            // may turn towards the ball, or catch up with it as it slows down.
            if !obstacle.is_moving() {
                return None;
            }
            safe = safe.max(DEEPEST_STEP / bound);
        }
        time += safe;
        if time >= duration {
            return None;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::super::ball_obstacle::SwingingFoot;
    use super::*;
    use crate::ball::Rolling;
    use crate::geometry::unit;
    use crate::geometry::{Pose, wrap_angle};
    use crate::robot::body::Body;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    fn ball(x: f32, y: f32, vx: f32, vy: f32) -> RollingBall {
        RollingBall {
            position: Vec2::new(x, y),
            velocity: Vec2::new(vx, vy),
            radius: 0.03,
            rolling: Rolling::ExponentialPerS(0.5),
            restitution: 0.4,
        }
    }

    fn roll(ball: RollingBall, obstacles: &[BallObstacle], duration: f32) -> (Option<RollingBall>, Vec<BallContact>) {
        let (mut contacts, mut path) = (Vec::new(), Vec::new());
        let end = roll_ball(ball, obstacles, duration, &mut contacts, &mut path);
        (end, contacts)
    }

    fn base(start: Pose, end: Pose) -> BallObstacle {
        BallObstacle::base(start, end, Body::default().base)
    }

    #[test]
    fn a_ball_at_30_mps_does_not_tunnel_through_anything_in_a_cycle_of_any_length() {
        let standing = Pose::new(1.0, 0.0, 0.3);
        let obstacles = [
            BallObstacle::Cylinder { centre: Vec2::new(1.0, 0.0), radius: 0.05 },
            BallObstacle::Bar { start: Vec2::new(1.0, -0.5), end: Vec2::new(1.0, 0.5), radius: 0.025 },
            base(standing, standing),
        ];
        for obstacle in obstacles {
            for duration in [0.001, 1.0 / 30.0, 0.1, 1.0] {
                let mut now = ball(0.0, 0.001, 30.0, 0.0);
                let mut bounced = false;
                let mut time = 0.0;
                while time < 1.0 {
                    let (end, contacts) = roll(now, &[obstacle], duration);
                    now = end.unwrap();
                    bounced |= !contacts.is_empty();
                    time += duration;
                }
                assert!(bounced, "{obstacle:?} in cycles of {duration} s");
                // A net stops it.
                assert!(now.velocity.x <= 0.0);
            }
        }
    }

    #[test]
    fn a_head_on_bounce_keeps_the_restitutions_share_of_the_speed() {
        // No drag: the ball meets the post of radius 5 cm at x = 1 - 0.05 - 0.03 = 0.92 after 0.92 s, and returns at 0.4 m/s.
        let mut rolling = ball(0.0, 0.0, 1.0, 0.0);
        rolling.rolling = Rolling::ConstantMps2(1e-9);
        let post = BallObstacle::Cylinder { centre: Vec2::new(1.0, 0.0), radius: 0.05 };
        let (end, contacts) = roll(rolling, &[post], 1.0);
        let end = end.unwrap();
        assert_abs_diff_eq!(end.velocity, Vec2::new(-0.4, 0.0), epsilon = 1e-4);
        assert_abs_diff_eq!(end.position.x, 0.92 - 0.4 * 0.08, epsilon = 1e-3);
        assert_abs_diff_eq!(contacts[0].approach_speed, 1.0, epsilon = 1e-4);
    }

    #[test]
    fn a_glancing_bounce_changes_only_the_speed_along_the_normal() {
        // Normal at the contact is (-cos 45°, -sin 45°): the ball comes along +x at a height of sin 45° (R + r).
        let height = 0.08 * core::f32::consts::FRAC_1_SQRT_2;
        let mut rolling = ball(0.0, -height, 1.0, 0.0);
        rolling.rolling = Rolling::ConstantMps2(1e-9);
        let post = BallObstacle::Cylinder { centre: Vec2::new(1.0, 0.0), radius: 0.05 };
        let (end, _) = roll(rolling, &[post], 1.2);
        // v - (1 + e)(v·n) n with v·n = -√½: (1 - 1.4/2, -1.4/2) = (0.3, -0.7).
        assert_abs_diff_eq!(end.unwrap().velocity, Vec2::new(0.3, -0.7), epsilon = 2e-3);
    }

    #[test]
    fn a_walking_robot_pushes_a_resting_ball_ahead() {
        // At 0.2 m/s the toes (11 cm ahead) reach the ball's near side (17 cm) after 0.3 s. It leaves at
        // 0.2 + 0.4 * 0.2 = 0.28 m/s.
        let walking = base(Pose::default(), Pose::new(0.07, 0.0, 0.0));
        let (end, contacts) = roll(ball(0.2, 0.0, 0.0, 0.0), &[walking], 0.35);
        let end = end.unwrap();
        assert_eq!(contacts.len(), 1);
        assert_abs_diff_eq!(contacts[0].approach_speed, 0.2, epsilon = 1e-4);
        // 0.28 m/s slowed for the remaining 0.05 s: 0.28 exp(-0.025) = 0.2731.
        assert_abs_diff_eq!(end.velocity, Vec2::new(0.2731, 0.0), epsilon = 1e-3);
    }

    #[test]
    fn a_swinging_foot_adds_its_speed_and_deflects_the_ball() {
        let BallObstacle::Base { start, end, base, .. } = base(Pose::default(), Pose::new(0.07, 0.0, 0.0)) else {
            unreachable!()
        };
        let touched = |foot: SwingingFoot, place: Vec2| {
            let walking = BallObstacle::Base { start, end, base, foot };
            let mut resting = ball(place.x, place.y, 0.0, 0.0);
            resting.rolling = Rolling::ConstantMps2(1e-9);
            roll(resting, &[walking], 0.35).0.unwrap().velocity
        };
        let foot = SwingingFoot { velocity: Vec2::new(0.3, 0.0), deflection: 0.5 };
        // The foot meets the ball at 0.2 + 0.3 m/s: it leaves at 1.4 times that, aside by the deflection.
        assert_abs_diff_eq!(touched(foot, Vec2::new(0.2, 0.0)), 0.7 * unit(0.5), epsilon = 1e-4);
        // A ball behind the robot is met by its heels, which do not swing.
        let back = SwingingFoot { velocity: Vec2::new(0.3, 0.0), ..foot };
        let obstacle = BallObstacle::Base { start, end, base, foot: back };
        assert_eq!(obstacle.foot_at(-Vec2::X), (0.0, -Vec2::X));
    }

    #[test]
    fn a_turning_robot_sweeps_the_ball_away() {
        // The right front corner of the base swings towards a ball beside it.
        let turning = base(Pose::default(), Pose::new(0.0, 0.0, -1.0));
        let (end, contacts) = roll(ball(0.09, -0.14, 0.0, 0.0), &[turning], 0.5);
        assert!(!contacts.is_empty());
        assert!(end.unwrap().velocity.y < -0.01);
    }

    #[test]
    fn a_ball_that_rolls_along_the_side_of_a_turning_robot_rolls_on() {
        // The left side of the base, 10 cm from the origin, swings after the ball as the ball rolls back along it.
        let turning = base(Pose::default(), Pose::new(-0.0066, 0.0007, -0.0524));
        for speed in [0.3, 0.5, 1.0, 1.5, 3.0] {
            let start = ball(0.02, 0.1302, -speed, 0.0);
            let (end, contacts) = roll(start, &[turning], 1.0 / 30.0);
            let end = end.unwrap_or_else(|| panic!("wedged at {speed} m/s after {} bounces", contacts.len()));
            // The ball loses little of its speed, and is pushed aside by about the 1.6 m/s² with which the side swings.
            assert!(end.velocity.x < -0.9 * speed, "{speed}: {}", end.velocity);
            assert!(turning.signed_distance(end.position, 1.0).0 > 0.0299, "{speed}");
        }
    }

    #[test]
    fn a_ball_over_the_toes_of_a_standing_robot_stays() {
        let standing = base(Pose::default(), Pose::default());
        let resting = ball(0.12, -0.05, 0.0, 0.0);
        let (end, contacts) = roll(resting, &[standing], 1.0);
        assert_eq!(end.unwrap().position, resting.position);
        assert!(contacts.is_empty());
    }

    #[test]
    fn a_ball_between_robots_that_close_in_is_wedged() {
        let left = base(Pose::default(), Pose::new(0.03, 0.0, 0.0));
        let right = base(Pose::new(0.29, 0.0, core::f32::consts::PI), Pose::new(0.25, 0.0, core::f32::consts::PI));
        // The gap of 7 cm around a ball of 6 cm closes by 7 cm.
        let (end, _) = roll(ball(0.145, 0.0, 0.0, 0.0), &[left, right], 0.1);
        assert_eq!(end, None);
    }

    /// A number in a range, often small or at its end.
    fn up_to(most: f32) -> impl Strategy<Value = f32> {
        prop_oneof![Just(most), 0.0..most, (-4.0f32..0.0).prop_map(move |power| most * 10.0_f32.powf(power))]
    }

    fn any_drag() -> impl Strategy<Value = Rolling> {
        prop_oneof![up_to(1000.0).prop_map(Rolling::ExponentialPerS), up_to(1000.0).prop_map(Rolling::ConstantMps2)]
    }

    fn any_pose(range: f32) -> impl Strategy<Value = Pose> {
        (-range..range, -range..range, -3.1f32..3.1).prop_map(|(x, y, heading)| Pose::new(x, y, heading))
    }

    /// A robot near the ball that walks, turns, or stands.
    fn any_base() -> impl Strategy<Value = BallObstacle> {
        (any_pose(0.4), up_to(5.0), -3.1f32..3.1, prop_oneof![Just(0.0), -0.1f32..0.1, -3.1f32..3.1]).prop_map(
            |(start, way, direction, turn)| {
                let position = start.position + unit(direction) * way;
                base(start, Pose { position, heading: wrap_angle(start.heading + turn) })
            },
        )
    }

    fn any_obstacle() -> impl Strategy<Value = BallObstacle> {
        prop_oneof![
            4 => any_base(),
            1 => (any_pose(0.5), 0.001f32..1.0)
                .prop_map(|(place, radius)| BallObstacle::Cylinder { centre: place.position, radius }),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

        #[test]
        fn whatever_the_ball_meets_it_gets_no_deeper_into_it(
            place in any_pose(0.4), speed in up_to(100.0), radius in 0.005f32..0.5, rolling in any_drag(),
            restitution in 0.0f32..=1.0, obstacles in proptest::collection::vec(any_obstacle(), 1..5),
            duration in 0.001f32..1.0,
        ) {
            let velocity = unit(place.heading) * speed;
            let start = RollingBall { position: place.position, velocity, radius, rolling, restitution };
            let (end, _) = roll(start, &obstacles, duration);
            let Some(end) = end else { return Ok(()) };
            prop_assert!(end.position.is_finite() && end.velocity.is_finite());
            for obstacle in &obstacles {
                let (before, after) = (obstacle.signed_distance(start.position, 0.0).0,
                    obstacle.signed_distance(end.position, 1.0).0);
                prop_assert!(after > before.min(radius) - 1e-3, "{before} {after} {obstacle:?}");
            }
        }

        #[test]
        fn a_robot_pushes_the_ball_ahead_through_grass_of_any_depth(
            drag in up_to(30.0), constant: bool, walking_speed in 0.01f32..1.0, y in -0.09f32..0.09,
            radius in 0.02f32..0.12, duration in 0.005f32..0.25,
        ) {
            let rolling = if constant { Rolling::ConstantMps2(drag) } else { Rolling::ExponentialPerS(drag) };
            let mut now = RollingBall { radius, rolling, ..ball(0.12 + radius, y, 0.0, 0.0) };
            let mut x = 0.0;
            for cycle in 0..20 {
                let (start, end) = (Pose::new(x, 0.0, 0.0), Pose::new(x + walking_speed * duration, 0.0, 0.0));
                let (rolled, contacts) = roll(now, &[base(start, end)], duration);
                let Some(rolled) = rolled else {
                    prop_assert!(false, "wedged in cycle {cycle} after {} bounces", contacts.len());
                    return Ok(());
                };
                now = rolled;
                x = end.position.x;
                let ahead = now.position.x - x;
                prop_assert!(ahead > 0.11 + radius - 2e-3, "{ahead} m ahead in cycle {cycle}");
            }
        }

        #[test]
        fn the_ball_never_gets_into_a_base(
            speed in 0.0f32..30.0, angle in -3.2f32..3.2, x in -1.0f32..1.0, y in -1.0f32..1.0,
            dx in -0.05f32..0.05, dy in -0.05f32..0.05, turn in -0.3f32..0.3, duration in 0.005f32..0.5,
        ) {
            let obstacle = base(Pose::default(), Pose::new(dx, dy, turn));
            let velocity = unit(angle) * speed;
            let start = ball(x, y, velocity.x, velocity.y);
            prop_assume!(obstacle.signed_distance(start.position, 0.0).0 > 0.03);
            let (end, _) = roll(start, &[obstacle], duration);
            let distance = obstacle.signed_distance(end.unwrap().position, 1.0).0;
            prop_assert!(distance > 0.03 - 1e-3, "{distance}");
        }
    }
}

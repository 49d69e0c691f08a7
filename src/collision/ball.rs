//! The ball's path through a cycle: it rolls by its law, and bounces off whatever it meets on the way, moving or not.
//!
//! The ball is never stepped through an obstacle: the time of the next contact is found by conservative advancement.
//! From the distance between ball and obstacle and a bound on their closing speed follows a time in which they cannot
//! meet; going ahead by that time again and again ends at the contact (Mirtich, 1996).

use bevy::prelude::*;

use super::footprints::distance_from_segment;
use crate::ball::RollingBall;
use crate::geometry::{Pose, wrap_angle};
use crate::robot::body::BodyBox;

/// At this distance ball and obstacle touch, m.
const CONTACT_DISTANCE: f32 = 1e-4;
/// Approaches slower than this are no contact, m/s.
const LEAST_APPROACH: f32 = 1e-5;
/// A ball that bounces more often than this within one cycle is wedged.
const MOST_BOUNCES: usize = 24;
/// From so many bounces in a row off the same obstacle on, the ball rolls along it rather than bounces.
const BOUNCES_TO_ROLL_ALONG: usize = 8;
/// It then parts from the obstacle by at least this much, m/s, and ever faster the longer it has not got away.
const LEAST_PARTING_SPEED: f32 = 0.002;
/// Most steps of one conservative advancement: a ball that grazes a turning robot at little more than the contact
/// distance goes ahead by as much at a time, and in a long cycle has some 20 cm to go.
const MOST_ADVANCES: usize = 2048;

/// What the ball can bounce off.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Obstacle {
    /// A post.
    Cylinder {
        /// Centre, m.
        centre: Vec2,
        /// Radius, m.
        radius: f32,
    },
    /// A bar that lies on the ground.
    Bar {
        /// One end of its axis, m.
        start: Vec2,
        /// The other end, m.
        end: Vec2,
        /// Radius, m.
        radius: f32,
    },
    /// The base of a robot that walks from one pose to another during the cycle.
    Base {
        /// At the start of the cycle.
        start: Pose,
        /// At its end.
        end: Pose,
        /// The base's box.
        base: BodyBox,
    },
}

impl Obstacle {
    fn pose_at(start: Pose, end: Pose, share: f32) -> Pose {
        if share >= 1.0 {
            return end;
        }
        Pose {
            position: start.position.lerp(end.position, share),
            heading: wrap_angle(start.heading + wrap_angle(end.heading - start.heading) * share),
        }
    }

    /// Distance of a point from the surface (negative inside) and the outward normal, at this share of the cycle.
    pub fn signed_distance(&self, point: Vec2, share: f32) -> (f32, Vec2) {
        match *self {
            Obstacle::Cylinder { centre, radius } => {
                let offset = point - centre;
                (offset.length() - radius, offset.normalize_or(Vec2::X))
            }
            Obstacle::Bar { start, end, radius } => {
                let (distance, normal) = distance_from_segment(start, end, point);
                (distance - radius, normal)
            }
            Obstacle::Base { start, end, base } => {
                base.footprint(Self::pose_at(start, end, share)).signed_distance(point)
            }
        }
    }

    /// Velocity of the obstacle's surface at a point, m/s, for a cycle of `duration` seconds.
    fn velocity_at(&self, point: Vec2, share: f32, duration: f32) -> Vec2 {
        let Obstacle::Base { start, end, .. } = *self else { return Vec2::ZERO };
        let angular = wrap_angle(end.heading - start.heading) / duration;
        let arm = point - start.position.lerp(end.position, share);
        (end.position - start.position) / duration + arm.perp() * angular
    }

    /// A bound on the speed of any point of the surface, m/s.
    fn greatest_speed(&self, duration: f32) -> f32 {
        let Obstacle::Base { start, end, base } = *self else { return 0.0 };
        let turn = wrap_angle(end.heading - start.heading).abs();
        (start.position.distance(end.position) + turn * base.reach()) / duration
    }

    fn is_turning(&self) -> bool {
        matches!(self, Obstacle::Base { start, end, .. } if start.heading != end.heading)
    }

    /// A circle that holds the obstacle during the whole cycle.
    fn bounds(&self) -> (Vec2, f32) {
        match *self {
            Obstacle::Cylinder { centre, radius } => (centre, radius),
            Obstacle::Bar { start, end, radius } => (start.midpoint(end), start.distance(end) / 2.0 + radius),
            Obstacle::Base { start, end, base } => {
                (start.position.midpoint(end.position), start.position.distance(end.position) / 2.0 + base.reach())
            }
        }
    }
}

/// A bounce.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct BallContact {
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Speed at which the two approached each other, m/s.
    pub approach_speed: f32,
    /// The ball's speed just before, m/s.
    pub ball_speed: f32,
    /// The ball's centre, m.
    pub position: Vec2,
}

/// Rolls the ball for `duration` seconds among the obstacles. Every bounce is pushed to `contacts`, every corner of
/// the path to `path`, its start and end included.
///
/// A ball that overlaps an obstacle at the start may stay where it is (a NAO kicks a ball that lies over its toes),
/// but gets no deeper. Returns none when the ball is wedged: it has nowhere to go from between obstacles that close
/// in on it.
pub fn roll_ball(
    ball: RollingBall,
    obstacles: &[Obstacle],
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
            .filter_map(|(index, obstacle)| {
                let clearance = clearance_at_start(obstacle, &ball);
                time_of_contact(&now, obstacle, clearance, time, duration).map(|contact| (contact, index))
            })
            .min_by(|((first, ..), _), ((second, ..), _)| first.total_cmp(second));
        let Some(((contact_time, normal), index)) = next else {
            let end = now.after(duration - time);
            path.push(end.position);
            return Some(end);
        };
        now = now.after(contact_time - time);
        time = contact_time;
        path.push(now.position);
        let surface = obstacles[index].velocity_at(now.position, time / duration, duration);
        let approach_speed = -(now.velocity - surface).dot(normal);
        contacts.push(BallContact {
            obstacle: index,
            approach_speed,
            ball_speed: now.velocity.length(),
            position: now.position,
        });
        let bounce = (1.0 + now.restitution) * approach_speed;
        now.velocity += normal * bounce.max(approach_speed + least_parting_speed(contacts));
    }
    None
}

/// How fast the ball parts at least from the obstacle that it has just met.
///
/// A ball that rolls along the side of a robot which turns towards it is met again and again, sooner each time: without
/// end, were it left to the restitution alone.
fn least_parting_speed(contacts: &[BallContact]) -> f32 {
    let Some(last) = contacts.last() else { return 0.0 };
    let in_a_row = contacts.iter().rev().take_while(|contact| contact.obstacle == last.obstacle).count();
    match in_a_row.checked_sub(BOUNCES_TO_ROLL_ALONG) {
        Some(beyond) => LEAST_PARTING_SPEED * ((1 + beyond) * (1 + beyond)) as f32,
        None => 0.0,
    }
}

/// How close the ball may come to the obstacle: its radius, or less where it already is closer.
fn clearance_at_start(obstacle: &Obstacle, ball: &RollingBall) -> f32 {
    obstacle.signed_distance(ball.position, 0.0).0.min(ball.radius)
}

/// When, from `start` on, the ball touches the obstacle while approaching it, and the normal there.
fn time_of_contact(
    ball: &RollingBall,
    obstacle: &Obstacle,
    clearance: f32,
    start: f32,
    duration: f32,
) -> Option<(f32, Vec2)> {
    let ball_speed = ball.velocity.length();
    let bound = ball_speed + obstacle.greatest_speed(duration);
    let (centre, radius) = obstacle.bounds();
    let reach = radius + ball.radius + bound * (duration - start) + CONTACT_DISTANCE;
    if bound == 0.0 || centre.distance_squared(ball.position) > reach * reach {
        return None;
    }
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
            // Straight past a convex obstacle that does not turn, what has begun to part never meets again.
            if !obstacle.is_turning() {
                return None;
            }
            safe = safe.max(10.0 * CONTACT_DISTANCE / bound);
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
    use super::*;
    use crate::ball::Rolling;
    use crate::geometry::unit;
    use crate::robot::body::BodyBounds;
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

    fn roll(ball: RollingBall, obstacles: &[Obstacle], duration: f32) -> (Option<RollingBall>, Vec<BallContact>) {
        let (mut contacts, mut path) = (Vec::new(), Vec::new());
        let end = roll_ball(ball, obstacles, duration, &mut contacts, &mut path);
        (end, contacts)
    }

    fn base(start: Pose, end: Pose) -> Obstacle {
        Obstacle::Base { start, end, base: BodyBounds::default().base }
    }

    #[test]
    fn a_ball_at_30_mps_does_not_tunnel_through_anything_in_a_cycle_of_any_length() {
        let standing = Pose::new(1.0, 0.0, 0.3);
        let obstacles = [
            Obstacle::Cylinder { centre: Vec2::new(1.0, 0.0), radius: 0.05 },
            Obstacle::Bar { start: Vec2::new(1.0, -0.5), end: Vec2::new(1.0, 0.5), radius: 0.025 },
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
                assert!(now.velocity.x < 0.0);
            }
        }
    }

    #[test]
    fn a_head_on_bounce_keeps_the_restitutions_share_of_the_speed() {
        // No drag: meets the post of radius 5 cm at x = 1 - 0.05 - 0.03 = 0.92 after 0.92 s, returns at 0.4 m/s.
        let mut rolling = ball(0.0, 0.0, 1.0, 0.0);
        rolling.rolling = Rolling::ConstantMps2(1e-9);
        let post = Obstacle::Cylinder { centre: Vec2::new(1.0, 0.0), radius: 0.05 };
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
        let post = Obstacle::Cylinder { centre: Vec2::new(1.0, 0.0), radius: 0.05 };
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
    fn a_turning_robot_sweeps_the_ball_away() {
        // The right front corner of the base swings towards a ball beside it.
        let turning = base(Pose::default(), Pose::new(0.0, 0.0, -1.0));
        let (end, contacts) = roll(ball(0.09, -0.14, 0.0, 0.0), &[turning], 0.5);
        assert!(!contacts.is_empty());
        assert!(end.unwrap().velocity.y < -0.01);
    }

    #[test]
    fn a_ball_that_rolls_along_the_side_of_a_turning_robot_rolls_on() {
        // The left side of the base, 10 cm from the origin, swings after the ball as that rolls back along it.
        let turning = base(Pose::default(), Pose::new(-0.0066, 0.0007, -0.0524));
        for speed in [0.3, 0.5, 1.0, 1.5, 3.0] {
            let start = ball(0.02, 0.1302, -speed, 0.0);
            let (end, contacts) = roll(start, &[turning], 1.0 / 30.0);
            let end = end.unwrap_or_else(|| panic!("wedged at {speed} m/s after {} bounces", contacts.len()));
            // It loses little of its speed, and is pushed aside by about the 1.6 m/s² at which the side swings.
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
        // Gap of 7 cm for a ball of 6 cm shuts by 7 cm.
        let (end, _) = roll(ball(0.145, 0.0, 0.0, 0.0), &[left, right], 0.1);
        assert_eq!(end, None);
    }

    proptest! {
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

//! Collisions of robots with each other and with posts, resolved for all robots together.
//!
//! A robot that collides is pushed back along the normal, and slides along the obstacle. Two robots that collide are pushed back in
//! proportion to their advance; a static robot keeps its position, and no robot is pushed faster than it can walk. The result does not
//! depend on the order of the robots.

use bevy::prelude::*;

use super::bodies::for_each_overlap;
pub use super::bodies::{Cylinder, RobotBody, Touched};
use crate::geometry::{Pose, wrap_angle};

/// Greatest displacement of any point of a torso in a substep, m: a quarter of its thickness.
const LONGEST_STEP: f32 = 0.02;
/// Greatest number of substeps in a cycle.
const MOST_STEPS: f32 = 256.0;
/// Number of rounds of pushing apart, after which overlapping robots are held back.
const PUSH_ROUNDS: usize = 8;
/// Gap between bodies that were pushed apart, m.
const GAP: f32 = 1e-5;

/// A contact of a robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RobotContact {
    /// Index of the robot; of two robots, the lower index.
    pub robot: usize,
    /// The other robot or the cylinder.
    pub touched: Touched,
    /// Unit vector from the robot to the other.
    pub normal: Vec2,
    /// Approximate point of contact, m.
    pub point: Vec2,
    /// Intended approach of the two bodies during the cycle, along the normal, m.
    pub approach: f32,
    /// Whether the robot intended to move.
    pub robot_moved: bool,
    /// Whether the other body intended to move.
    pub touched_moved: bool,
}

/// Buffers of [`resolve_robots`], kept between calls so that a steady match allocates nothing.
#[derive(Default, Debug)]
pub struct SeparationWorkspace {
    current: Vec<Pose>,
    wanted: Vec<Pose>,
    push: Vec<Vec2>,
    spent: Vec<bool>,
    held: Vec<bool>,
}

/// Moves all robots from their start towards their end, and writes back the poses that they reach. `contacts` gets every pair that touched
/// once, ordered by the indices.
///
/// Afterwards no two torsos overlap and none overlaps a cylinder, provided that none did at the start.
pub fn resolve_robots(
    robots: &mut [RobotBody],
    cylinders: &[Cylinder],
    workspace: &mut SeparationWorkspace,
    contacts: &mut Vec<RobotContact>,
) {
    contacts.clear();
    let farthest = robots.iter().map(longest_way).fold(0.0, f32::max);
    if farthest == 0.0 {
        return;
    }
    let steps = (farthest / LONGEST_STEP).ceil().clamp(1.0, MOST_STEPS);
    workspace.current.clear();
    workspace.current.extend(robots.iter().map(|robot| robot.start));
    for _ in 0..steps as usize {
        workspace.wanted.clear();
        workspace.wanted.extend(
            robots.iter().zip(&workspace.current).map(|(robot, current)| advanced(robot, *current, 1.0 / steps)),
        );
        push_apart(robots, cylinders, workspace, contacts, 1.0 / steps);
        hold_back(robots, cylinders, workspace);
        workspace.current.clone_from(&workspace.wanted);
    }
    for (robot, pose) in robots.iter_mut().zip(&workspace.current) {
        robot.end = *pose;
    }
    contacts.sort_by_key(|contact| (contact.robot, order_of(contact.touched)));
}

fn order_of(touched: Touched) -> (u8, usize) {
    match touched {
        Touched::Robot(index) => (0, index),
        Touched::Cylinder(index) => (1, index),
    }
}

/// Greatest displacement of any point of the torso, m.
fn longest_way(robot: &RobotBody) -> f32 {
    let turn = wrap_angle(robot.end.heading - robot.start.heading).abs();
    robot.start.position.distance(robot.end.position) + turn * robot.torso.reach()
}

/// Returns the pose `current` after `share` of the robot's whole step.
fn advanced(robot: &RobotBody, current: Pose, share: f32) -> Pose {
    if !robot.is_moving() {
        return current;
    }
    if share == 1.0 {
        return robot.end;
    }
    let turn = wrap_angle(robot.end.heading - robot.start.heading);
    Pose {
        position: current.position + (robot.end.position - robot.start.position) * share,
        heading: wrap_angle(current.heading + turn * share),
    }
}

/// Greatest displacement of a robot in `share` of the cycle, m.
fn most_way(robot: &RobotBody, share: f32) -> f32 {
    (robot.most_way.max(robot.start.position.distance(robot.end.position)) + GAP) * share
}

/// Pushes overlapping torsos apart, all together, in a few rounds. A robot that has reached its greatest displacement is `spent`, so that
/// only the other robot is pushed.
fn push_apart(
    robots: &[RobotBody],
    cylinders: &[Cylinder],
    workspace: &mut SeparationWorkspace,
    contacts: &mut Vec<RobotContact>,
    share: f32,
) {
    let SeparationWorkspace { current, wanted, push, spent, .. } = workspace;
    spent.clear();
    spent.resize(robots.len(), false);
    for _ in 0..PUSH_ROUNDS {
        push.clear();
        push.resize(robots.len(), Vec2::ZERO);
        let mut any = false;
        for_each_overlap(robots, cylinders, wanted, |robot, touched, overlap| {
            any = true;
            if !contacts.iter().any(|contact| contact.robot == robot && contact.touched == touched) {
                let torso = robots[robot].torso.footprint(wanted[robot]);
                let point = torso.centre + overlap.normal * torso.half_extents.min_element();
                let advance = |body: &RobotBody| (body.end.position - body.start.position).dot(overlap.normal);
                let other = match touched {
                    Touched::Robot(other) => Some(&robots[other]),
                    Touched::Cylinder(_) => None,
                };
                contacts.push(RobotContact {
                    robot,
                    touched,
                    normal: overlap.normal,
                    point,
                    approach: advance(&robots[robot]) - other.map_or(0.0, advance),
                    robot_moved: robots[robot].is_moving(),
                    touched_moved: other.is_some_and(RobotBody::is_moving),
                });
            }
            let distance = overlap.depth + GAP;
            match touched {
                Touched::Cylinder(_) => push[robot] -= overlap.normal * distance,
                Touched::Robot(other) => {
                    let (own, others) = match (spent[robot], spent[other]) {
                        (true, false) if robots[other].is_moving() => (0.0, 1.0),
                        (false, true) if robots[robot].is_moving() => (1.0, 0.0),
                        _ => shares(&robots[robot], &robots[other], overlap.normal, share),
                    };
                    push[robot] -= overlap.normal * (distance * own);
                    push[other] += overlap.normal * (distance * others);
                }
            }
        });
        if !any {
            return;
        }
        for (index, pose) in wanted.iter_mut().enumerate() {
            if !robots[index].is_moving() || push[index] == Vec2::ZERO {
                continue;
            }
            pose.position += push[index];
            let (from, most) = (current[index].position, most_way(&robots[index], share));
            if pose.position.distance_squared(from) > most * most {
                pose.position = from + (pose.position - from).clamp_length_max(most);
                spent[index] = true;
            }
        }
    }
}

/// The shares of an overlap by which two robots are pushed apart: in proportion to their advance towards each other; equal if
/// neither advanced (one turned into the other); zero for a static robot. They add up to 1 unless both are static.
fn shares(first: &RobotBody, second: &RobotBody, normal: Vec2, share: f32) -> (f32, f32) {
    match (first.is_moving(), second.is_moving()) {
        (false, false) => (0.0, 0.0),
        (true, false) => (1.0, 0.0),
        (false, true) => (0.0, 1.0),
        (true, true) => {
            let advance = ((first.end.position - first.start.position).dot(normal) * share).max(0.0);
            let other_advance = (-(second.end.position - second.start.position).dot(normal) * share).max(0.0);
            let sum = advance + other_advance;
            if sum > 1e-7 { (advance / sum, other_advance / sum) } else { (0.5, 0.5) }
        }
    }
}

/// Returns robots that still overlap to their poses in `current`, repeatedly until none overlaps.
fn hold_back(robots: &[RobotBody], cylinders: &[Cylinder], workspace: &mut SeparationWorkspace) {
    let SeparationWorkspace { current, wanted, held, .. } = workspace;
    held.clear();
    held.resize(robots.len(), false);
    while hold_overlapping(robots, cylinders, wanted, held) {
        for (index, pose) in wanted.iter_mut().enumerate() {
            if held[index] {
                *pose = current[index];
            }
        }
    }
}

/// Returns robots that are already `held` to their start, and then those that would overlap with them.
pub(crate) fn hold_back_from_end(robots: &mut [RobotBody], cylinders: &[Cylinder], held: &mut [bool]) {
    loop {
        for (robot, held) in robots.iter_mut().zip(held.iter()) {
            if *held {
                robot.end = robot.start;
            }
        }
        let poses: Vec<Pose> = robots.iter().map(|robot| robot.end).collect();
        if !hold_overlapping(robots, cylinders, &poses, held) {
            return;
        }
    }
}

/// Marks robots that overlap with another body at `poses` as held. Returns whether any of them was not held before.
fn hold_overlapping(robots: &[RobotBody], cylinders: &[Cylinder], poses: &[Pose], held: &mut [bool]) -> bool {
    let mut is_new = false;
    for_each_overlap(robots, cylinders, poses, |robot, touched, _| {
        let other = match touched {
            Touched::Robot(other) => Some(other),
            Touched::Cylinder(_) => None,
        };
        for index in [Some(robot), other].into_iter().flatten() {
            is_new |= !held[index];
            held[index] = true;
        }
    });
    is_new
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::unit;
    use crate::robot::body::Body;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::{FRAC_PI_2, PI};
    use proptest::prelude::*;

    fn robot(start: Pose, end: Pose) -> RobotBody {
        RobotBody { start, end, torso: Body::default().torso, most_way: 0.0 }
    }

    fn resolve(robots: &mut [RobotBody], cylinders: &[Cylinder]) -> Vec<RobotContact> {
        let mut contacts = Vec::new();
        resolve_robots(robots, cylinders, &mut SeparationWorkspace::default(), &mut contacts);
        contacts
    }

    #[test]
    fn equally_fast_robots_meet_in_the_middle() {
        // Fronts are 5 cm ahead: two robots 20 cm apart that want to walk 10 cm each meet after 5 cm each.
        let mut robots = [
            robot(Pose::new(0.0, 0.0, 0.0), Pose::new(0.1, 0.0, 0.0)),
            robot(Pose::new(0.2, 0.0, PI), Pose::new(0.1, 0.0, PI)),
        ];
        let contacts = resolve(&mut robots, &[]);
        assert_abs_diff_eq!(robots[0].end.position.x, 0.05, epsilon = 1e-4);
        assert_abs_diff_eq!(robots[1].end.position.x, 0.15, epsilon = 1e-4);
        assert_eq!((contacts.len(), contacts[0].touched), (1, Touched::Robot(1)));
    }

    #[test]
    fn each_gives_up_in_proportion_to_its_own_advance() {
        // Gap 2 cm, advances 3 cm and 1 cm: they overlap by 2 cm, of which the first gives up 1.5 and the other 0.5.
        let mut robots = [
            robot(Pose::new(0.0, 0.0, 0.0), Pose::new(0.015, 0.0, 0.0)),
            robot(Pose::new(0.11, 0.0, PI), Pose::new(0.105, 0.0, PI)),
        ];
        resolve(&mut robots, &[]);
        // Gap 1 cm, advances 1.5 cm and 0.5 cm: overlap 1 cm, given up 0.75 and 0.25 cm.
        assert_abs_diff_eq!(robots[0].end.position.x, 0.0075, epsilon = 1e-4);
        assert_abs_diff_eq!(robots[1].end.position.x, 0.1075, epsilon = 1e-4);
    }

    #[test]
    fn nobody_is_shoved_faster_than_it_walks() {
        // The first robot turns in place by 0.2 rad; the tip of its torso, 15 cm to the left, goes 3 cm ahead, towards the side of the
        // second, which walks 1 mm away from it, and could go 5 mm.
        let turning = robot(Pose::new(0.0, 0.0, 0.0), Pose::new(0.0, 0.0, -0.2));
        let walking = robot(Pose::new(0.11, 0.15, PI), Pose::new(0.11, 0.151, PI));
        for order in [[0, 1], [1, 0]] {
            let mut robots = order.map(|index| [turning, RobotBody { most_way: 0.005, ..walking }][index]);
            let contacts = resolve(&mut robots, &[]);
            assert_eq!(contacts.len(), 1);
            for body in robots {
                let (way, most) = (body.start.position.distance(body.end.position), body.most_way.max(0.001));
                assert!(way <= most + 2.0 * GAP, "{way}");
            }
        }
    }

    #[test]
    fn who_can_give_up_no_more_leaves_the_rest_to_the_other() {
        // Both turn towards each other by 0.1 rad, which brings their fronts together by 1.5 cm at the tips. The first cannot be pushed at
        // all, the second by 3 cm: it goes back by the whole overlap, and both have turned.
        let first = robot(Pose::new(0.0, 0.0, 0.0), Pose::new(0.0, 0.0, 0.1));
        let second = robot(Pose::new(0.101, 0.0, PI), Pose::new(0.101, 0.0, PI - 0.1));
        let mut robots = [first, RobotBody { most_way: 0.03, ..second }];
        resolve(&mut robots, &[]);
        assert_abs_diff_eq!(robots[0].end.position, Vec2::ZERO, epsilon = 2.0 * GAP);
        assert_abs_diff_eq!(robots[0].end.heading, 0.1, epsilon = 1e-6);
        assert!(robots[1].end.position.x > 0.102, "{:?}", robots[1].end);
        assert_abs_diff_eq!(robots[1].end.heading, PI - 0.1, epsilon = 1e-6);
    }

    #[test]
    fn a_static_robot_keeps_its_place_and_the_other_stops_in_front_of_it() {
        let standing = Pose::new(0.2, 0.0, FRAC_PI_2);
        let mut robots = [robot(Pose::new(0.0, 0.0, 0.0), Pose::new(0.15, 0.0, 0.0)), robot(standing, standing)];
        resolve(&mut robots, &[]);
        assert_eq!(robots[1].end, standing);
        // The standing robot faces +y, so its near side is 15 cm from its origin: 0.2 - 0.15 - 0.05 = 0.
        assert_abs_diff_eq!(robots[0].end.position.x, 0.0, epsilon = 1e-4);
    }

    #[test]
    fn a_robot_slides_along_a_post() {
        let post = Cylinder { centre: Vec2::new(0.2, 0.12), radius: 0.05 };
        let mut robots = [robot(Pose::new(0.0, 0.0, 0.0), Pose::new(0.3, 0.0, 0.0))];
        let contacts = resolve(&mut robots, &[post]);
        assert_eq!(contacts[0].touched, Touched::Cylinder(0));
        let torso = robots[0].torso.footprint(robots[0].end);
        assert!(torso.overlap_disc(post.centre, post.radius).is_none());
        assert!(robots[0].end.position.y < -0.001 || robots[0].end.position.x < 0.11);
    }

    #[test]
    fn a_fast_robot_does_not_jump_through_a_post() {
        let post = Cylinder { centre: Vec2::new(1.0, 0.0), radius: 0.05 };
        let mut robots = [robot(Pose::new(0.0, 0.0, 0.0), Pose::new(3.0, 0.0, 0.0))];
        resolve(&mut robots, &[post]);
        assert_abs_diff_eq!(robots[0].end.position.x, 0.9, epsilon = 1e-3);
    }

    proptest! {
        #[test]
        fn nobody_overlaps_and_the_order_does_not_matter(
            places in proptest::collection::vec((-0.6f32..0.6, -0.6f32..0.6, -3.1f32..3.1), 6),
            steps in proptest::collection::vec((-0.1f32..0.1, -0.1f32..0.1, -0.5f32..0.5), 6),
        ) {
            let cylinders = [Cylinder { centre: Vec2::new(0.1, 0.1), radius: 0.05 }];
            let mut robots: Vec<RobotBody> = Vec::new();
            for ((x, y, heading), (dx, dy, turn)) in places.into_iter().zip(steps) {
                let start = Pose::new(x, y, heading);
                let end = Pose { position: start.position + Vec2::new(dx, dy), heading: wrap_angle(heading + turn) };
                let candidate = robot(start, end);
                let free = robots.iter().all(|other| {
                    other.torso.footprint(other.start).overlap(&candidate.torso.footprint(start)).is_none()
                }) && candidate.torso.footprint(start).overlap_disc(cylinders[0].centre, cylinders[0].radius).is_none();
                if free {
                    robots.push(candidate);
                }
            }
            let mut reversed: Vec<RobotBody> = robots.iter().rev().copied().collect();
            let most: Vec<f32> = robots.iter().map(|robot| most_way(robot, 1.0)).collect();
            resolve(&mut robots, &cylinders);
            resolve(&mut reversed, &cylinders);
            for (index, body) in robots.iter().enumerate() {
                let way = body.start.position.distance(body.end.position);
                prop_assert!(way <= most[index] + 1e-6, "shoved by {way}");
                let torso = body.torso.footprint(body.end);
                prop_assert!(torso.overlap_disc(cylinders[0].centre, cylinders[0].radius).is_none());
                for other in &robots[index + 1..] {
                    prop_assert!(torso.overlap(&other.torso.footprint(other.end)).is_none());
                }
                let mirrored = reversed[reversed.len() - 1 - index].end;
                prop_assert!(body.end.position.distance(mirrored.position) < 1e-4, "{:?} {:?}", body.end, mirrored);
            }
        }

        #[test]
        fn a_collision_turned_by_an_angle_is_the_same_collision_turned(angle in -3.1f32..3.1) {
            let turned = |pose: Pose| Pose {
                position: unit(angle).rotate(pose.position),
                heading: wrap_angle(pose.heading + angle),
            };
            let (a, b) = (Pose::new(0.0, 0.0, 0.0), Pose::new(0.05, 0.02, 0.1));
            let (c, d) = (Pose::new(0.16, 0.03, 3.0), Pose::new(0.11, 0.03, 3.0));
            let mut plain = [robot(a, b), robot(c, d)];
            let mut other = [robot(turned(a), turned(b)), robot(turned(c), turned(d))];
            resolve(&mut plain, &[]);
            resolve(&mut other, &[]);
            for (plain, other) in plain.iter().zip(&other) {
                prop_assert!(turned(plain.end).position.distance(other.end.position) < 1e-4);
            }
        }
    }
}

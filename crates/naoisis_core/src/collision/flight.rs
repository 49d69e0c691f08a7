//! The flight of the ball in a cycle among robots, posts and goals.
//!
//! Obstacles are those of a rolling ball with a height: upright prisms, and the crossbars. The time of a contact is found by conservative
//! advancement, as in [`ball`](super::ball), in short straight steps.

use bevy::prelude::*;

use super::ball::{BallContact, CONTACT_DISTANCE, DEEPEST_STEP, LEAST_APPROACH, MOST_BOUNCES};
use super::ball_obstacle::{BallObstacle, NET_RESTITUTION};
use crate::ball::flight::{FlyingBall, LONGEST_STEP_S};
use crate::geometry::Pose;
use crate::pitch::{End, Pitch};
use crate::robot::body::{Body, BodyBox};

/// Greatest number of steps of one conservative advancement.
const MOST_ADVANCES: usize = 128;
/// Speed at which a ball that lies on an obstacle rolls off it, m/s.
const ROLL_OFF_MPS: f32 = 0.2;
/// Height of a foot, m; the leg begins above it.
const FOOT_HEIGHT_M: f32 = 0.06;
/// Half the width of a head, m.
const HEAD_HALF_WIDTH_M: f32 = 0.06;

/// An obstacle of a flying ball: an outline on the ground between two heights, with rounded edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid {
    /// The index with which contacts are reported.
    pub obstacle: usize,
    /// Outline seen from above.
    pub outline: BallObstacle,
    /// Lower and upper edge, m above the ground.
    pub z_m: [f32; 2],
    /// Distance by which the solid is enlarged in all directions, m. This rounds its edges.
    pub rounding_m: f32,
    /// Share of the approach speed that remains after a bounce; `None` for that of the ball.
    pub restitution: Option<f32>,
}

impl Solid {
    /// An upright prism.
    pub fn prism(obstacle: usize, outline: BallObstacle, z_m: [f32; 2]) -> Solid {
        Solid { obstacle, outline, z_m, rounding_m: 0.0, restitution: None }
    }

    /// Distance of a point from the surface (negative inside) and the outward normal, at `share` of the cycle.
    fn signed_distance(&self, point: Vec3, share: f32) -> (f32, Vec3) {
        let (beside, outward) = self.outline.signed_distance(point.truncate(), share);
        let [bottom, top] = self.z_m;
        let (above, upward) =
            if point.z - top > bottom - point.z { (point.z - top, Vec3::Z) } else { (bottom - point.z, Vec3::NEG_Z) };
        let outward = outward.extend(0.0);
        let (distance, normal) = if beside > 0.0 && above > 0.0 {
            let offset = outward * beside + upward * above;
            (offset.length(), offset.normalize_or(outward))
        } else if beside >= above {
            (beside, outward)
        } else {
            (above, upward)
        };
        (distance - self.rounding_m, normal)
    }

    /// The least distance of the ball's centre: its radius, or less if it is already closer at the start of the cycle.
    fn clearance(&self, start: &FlyingBall) -> f32 {
        self.signed_distance(start.centre(), 0.0).0.min(start.physics.radius_m)
    }

    /// Whether the solid comes within `reach` m of `centre`.
    fn is_near(&self, centre: Vec3, reach: f32) -> bool {
        let reach = reach + self.rounding_m;
        self.outline.is_near(centre.truncate(), reach)
            && centre.z - reach <= self.z_m[1]
            && centre.z + reach >= self.z_m[0]
    }

    /// The time from now on, at most `step` seconds, at which the approaching ball touches the solid, and the normal at the contact.
    fn contact(
        &self,
        start: &FlyingBall,
        now: &FlyingBall,
        time: f32,
        step: f32,
        duration: f32,
    ) -> Option<(f32, Vec3)> {
        let bound = now.velocity.length() + self.outline.greatest_speed(duration);
        if bound == 0.0 || !self.is_near(now.centre(), now.physics.radius_m + bound * step + CONTACT_DISTANCE) {
            return None;
        }
        let clearance = self.clearance(start);
        let mut ahead = 0.0;
        for _ in 0..MOST_ADVANCES {
            let centre = now.centre() + now.velocity * ahead;
            let share = (time + ahead) / duration;
            let (distance, normal) = self.signed_distance(centre, share);
            let gap = distance - clearance;
            let mut safe = gap / bound;
            if gap <= CONTACT_DISTANCE {
                let surface = self.outline.velocity_at(centre.truncate(), share, duration).extend(0.0);
                if -(now.velocity - surface).dot(normal) > LEAST_APPROACH {
                    return Some((ahead, normal));
                }
                safe = safe.max(DEEPEST_STEP / bound);
            }
            ahead += safe;
            if ahead >= step {
                return None;
            }
        }
        None
    }
}

/// Flies the ball for `duration` seconds among the obstacles. Pushes every bounce off them to `contacts`, and every vertex of its path to
/// `path` and `heights_m`.
///
/// A ball that overlaps an obstacle at the start does not penetrate deeper. A ball that cannot get out from between obstacles falls
/// straight down.
pub(super) fn fly_ball(
    start: FlyingBall,
    solids: &[Solid],
    duration: f32,
    contacts: &mut Vec<BallContact>,
    path: &mut Vec<Vec2>,
    heights_m: &mut Vec<f32>,
) -> FlyingBall {
    contacts.clear();
    path.clear();
    heights_m.clear();
    let mut now = start;
    let mut time = 0.0;
    path.push(now.position.truncate());
    heights_m.push(now.position.z);
    while time < duration {
        let step = LONGEST_STEP_S.min(duration - time);
        let first = solids
            .iter()
            .filter_map(|solid| Some((solid.contact(&start, &now, time, step, duration)?, solid)))
            .min_by(|((a, _), _), ((b, _), _)| a.total_cmp(b));
        match first {
            Some(((ahead, normal), solid)) if contacts.len() < MOST_BOUNCES => {
                now.advance(ahead);
                time += ahead;
                contacts.push(bounce(&mut now, solid, normal, time / duration, duration));
            }
            Some(_) => {
                now.velocity = Vec3::ZERO;
                break;
            }
            None => {
                now.advance(step);
                time += step;
            }
        }
        path.push(now.position.truncate());
        heights_m.push(now.position.z);
    }
    for solid in solids {
        let (distance, normal) = solid.signed_distance(now.centre(), 1.0);
        let depth = solid.clearance(&start) - distance;
        if (0.0..=DEEPEST_STEP).contains(&depth) {
            now.position += normal * depth;
        }
    }
    now.position.z = now.position.z.max(0.0);
    path.push(now.position.truncate());
    heights_m.push(now.position.z);
    now
}

/// Bounces the ball off an obstacle that it touches, and describes the contact.
fn bounce(now: &mut FlyingBall, solid: &Solid, normal: Vec3, share: f32, duration: f32) -> BallContact {
    let place = now.position.truncate();
    let surface = solid.outline.velocity_at(place, share, duration).extend(0.0);
    let approach_speed = -(now.velocity - surface).dot(normal);
    let ball_speed = now.velocity.length();
    let restitution = solid.restitution.unwrap_or(now.physics.restitution);
    now.velocity += normal * ((1.0 + restitution) * approach_speed);
    if normal.z > 0.9 && now.velocity.z < ROLL_OFF_MPS {
        // The ball lies on a shoulder or on a fallen robot, and rolls off.
        let (middle, _) = solid.outline.bounds();
        let outwards = (place - middle).normalize_or(Vec2::X);
        let missing_mps = (ROLL_OFF_MPS - now.velocity.truncate().dot(outwards)).max(0.0);
        now.velocity += (outwards * missing_mps).extend(0.0);
    }
    let normal = normal.truncate();
    BallContact { obstacle: solid.obstacle, approach_speed, ball_speed, position: place, normal }
}

/// The solids of a robot for a flying ball: feet, legs, torso and head of a standing robot, otherwise its low body.
pub(super) fn solids_of_robot(
    index: usize,
    body: &Body,
    [start, end]: [Pose; 2],
    is_low: bool,
) -> impl Iterator<Item = Solid> {
    let part = move |shape: BodyBox| Some(Solid::prism(index, BallObstacle::base(start, end, shape), shape.z_m));
    let Body { base, torso, height_m, .. } = *body;
    let parts = if is_low || body.legs.is_none() {
        [part(base), part(torso), None, None]
    } else {
        let foot = BodyBox { z_m: [base.z_m[0], base.z_m[1].min(FOOT_HEIGHT_M)], ..base };
        let legs = BodyBox { x_m: torso.x_m, z_m: [0.0, torso.z_m[0]], ..base };
        let middle = torso.centre_x();
        let head = BodyBox {
            x_m: [middle - HEAD_HALF_WIDTH_M, middle + HEAD_HALF_WIDTH_M],
            half_width_m: HEAD_HALF_WIDTH_M,
            z_m: [torso.z_m[1].min(height_m), height_m],
        };
        [part(foot), part(legs), part(torso), part(head)]
    };
    parts.into_iter().flatten()
}

/// The crossbars of the goals, and, if the goals' frames stop the ball, their nets: sides, rear and roof.
pub(super) fn solids_of_goals(obstacle: usize, pitch: &Pitch) -> Vec<Solid> {
    let goal = &pitch.goal;
    let radius = goal.bar_diameter_m / 2.0;
    let middle_of_bar_m = goal.height_m - radius;
    let mut solids = Vec::with_capacity(10);
    for end in [End::NegativeX, End::PositiveX] {
        let front = end.sign() * pitch.goal_post_x();
        let bar = BallObstacle::Bar {
            start: Vec2::new(front, -goal.width_m / 2.0),
            end: Vec2::new(front, goal.width_m / 2.0),
            radius: 0.0,
        };
        solids.push(Solid { obstacle, outline: bar, z_m: [middle_of_bar_m; 2], rounding_m: radius, restitution: None });
        if goal.ground_bars {
            let half_depth = goal.depth_m / 2.0;
            let place = Pose::new(front + end.sign() * half_depth, 0.0, 0.0);
            let roof = BodyBox {
                x_m: [-half_depth, half_depth],
                half_width_m: goal.width_m / 2.0,
                z_m: [middle_of_bar_m - radius, middle_of_bar_m + radius],
            };
            let outline = BallObstacle::base(place, place, roof);
            solids.push(Solid { restitution: Some(NET_RESTITUTION), ..Solid::prism(obstacle, outline, roof.z_m) });
        }
    }
    if goal.ground_bars {
        solids.extend(pitch.ground_bars().map(|bar| {
            let outline = BallObstacle::Bar { start: bar.start, end: bar.end, radius };
            let net = Solid::prism(obstacle, outline, [0.0, middle_of_bar_m]);
            Solid { restitution: Some(NET_RESTITUTION), ..net }
        }));
    }
    solids
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ball::BallPhysics;
    use crate::ball::flight::FlightPhysics;
    use crate::robot::posture::{LyingOn, Posture};
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    fn ball(position: [f32; 3], velocity: [f32; 3]) -> FlyingBall {
        let flight = FlightPhysics { drag_per_m: 0.0, ..FlightPhysics::default() };
        let physics = BallPhysics { flight, ..BallPhysics::default() };
        FlyingBall { position: position.into(), velocity: velocity.into(), physics }
    }

    /// The ball after `time` seconds in cycles of a thirtieth, and its contacts.
    fn fly(ball: FlyingBall, solids: &[Solid], time: f32) -> (FlyingBall, Vec<BallContact>) {
        let (mut now, mut all) = (ball, Vec::new());
        let (mut contacts, mut path, mut heights) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..(time * 30.0).round() as usize {
            now = fly_ball(now, solids, 1.0 / 30.0, &mut contacts, &mut path, &mut heights);
            assert_eq!(path.len(), heights.len());
            all.append(&mut contacts);
        }
        (now, all)
    }

    fn robot() -> Vec<Solid> {
        solids_of_robot(0, &Body::default(), [Pose::new(1.0, 0.0, core::f32::consts::PI); 2], false).collect()
    }

    #[test]
    fn a_ball_flies_over_the_toes_and_bounces_off_the_body() {
        // The toes reach to x = 0.89, the legs and the torso's front to 0.95, where the ball turns around.
        let (end, contacts) = fly(ball([0.0, 0.0, 0.1], [3.0, 0.0, 1.5]), &robot(), 0.5);
        assert_abs_diff_eq!(contacts[0].position.x, 0.95 - 0.03, epsilon = 0.002);
        assert!(end.velocity.x < 0.0);
        // On the ground the ball meets the toes.
        let (_, contacts) = fly(ball([0.0, 0.0, 0.0], [3.0, 0.0, 0.0]), &robot(), 0.5);
        assert_abs_diff_eq!(contacts[0].position.x, 0.89 - 0.03, epsilon = 0.002);
    }

    #[test]
    fn a_ball_that_is_high_enough_flies_over_a_robot() {
        // Above the robot, 1 m further on, the ball is 3 * 0.333 - 9.81 * 0.111 / 2 + 0.3 = 0.75 m high; the robot is 0.573 m high.
        let (end, contacts) = fly(ball([0.0, 0.0, 0.3], [3.0, 0.0, 3.0]), &robot(), 0.5);
        assert!(contacts.is_empty());
        assert_abs_diff_eq!(end.position.x, 1.5, epsilon = 1e-3);
    }

    #[test]
    fn the_crossbar_sends_a_ball_that_meets_its_middle_back() {
        let pitch = Pitch::default();
        let height = pitch.goal.height_m - pitch.goal.bar_diameter_m / 2.0 - 0.03;
        // Launched so that the ball is at its highest point when it meets the bar, 1 m further on after 0.2 s.
        let climb = 0.2 * 9.81;
        let start_height = height - climb * 0.2 / 2.0;
        let start = ball([pitch.goal_post_x() - 1.0, 0.0, start_height], [5.0, 0.0, climb]);
        let (end, contacts) = fly(start, &solids_of_goals(7, &pitch), 0.3);
        assert_eq!(contacts.len(), 1);
        assert_eq!(contacts[0].obstacle, 7);
        assert_abs_diff_eq!(end.velocity.x, -0.4 * 5.0, epsilon = 0.05);
    }

    #[test]
    fn the_net_catches_the_ball() {
        let mut pitch = Pitch::default();
        pitch.goal.ground_bars = true;
        let start = ball([2.5, 0.0, 0.2], [6.0, 0.0, 1.0]);
        let (end, contacts) = fly(start, &solids_of_goals(0, &pitch), 2.0);
        assert!(!contacts.is_empty());
        let rear = pitch.goal_post_x() + pitch.goal.depth_m;
        assert!(end.position.x < rear && end.position.x > pitch.goal_post_x(), "{}", end.position);
        // From above the ball stays on the net's roof or falls off it, but does not get into the goal.
        let (end, _) = fly(ball([3.2, 0.0, 1.5], [0.0; 3]), &solids_of_goals(0, &pitch), 3.0);
        assert!(
            end.position.z > 0.5 || end.position.x > rear || end.position.x < pitch.goal_post_x(),
            "{}",
            end.position
        );
    }

    #[test]
    fn a_ball_that_falls_on_a_robot_rolls_off() {
        let (end, contacts) = fly(ball([1.0, 0.02, 1.0], [0.0; 3]), &robot(), 5.0);
        assert!(!contacts.is_empty());
        assert!(!end.flight().is_airborne(), "{end:?}");
    }

    #[test]
    fn a_ball_on_a_long_body_or_a_net_rolls_off_slowly() {
        let tall = Body { height_m: 1.2, lying_height_m: 0.25, ..Body::default() };
        let lying = tall.in_posture(Posture::fallen(LyingOn::Back));
        let robot: Vec<Solid> = solids_of_robot(0, &lying, [Pose::default(); 2], true).collect();
        let mut pitch = Pitch::default();
        pitch.goal.ground_bars = true;
        let goals = solids_of_goals(0, &pitch);
        let on_roof = [pitch.goal_post_x() + 0.4 * pitch.goal.depth_m, 0.1, pitch.goal.height_m + 0.3];
        for (solids, place) in [(&robot, [0.1, 0.02, 0.8]), (&goals, on_roof)] {
            let mut now = ball(place, [0.0; 3]);
            let mut fastest_mps = 0.0_f32;
            for _ in 0..300 {
                now = fly_ball(now, solids, 1.0 / 30.0, &mut Vec::new(), &mut Vec::new(), &mut Vec::new());
                fastest_mps = fastest_mps.max(now.velocity.truncate().length());
            }
            assert!((0.1..0.5).contains(&fastest_mps), "{fastest_mps}");
            assert!(!now.flight().is_airborne(), "{now:?}");
        }
    }

    proptest! {
        #[test]
        fn a_flying_ball_gets_into_nothing(
            x in -1.5f32..1.5, y in -1.5f32..1.5, z in 0.0f32..1.0, vx in -10.0f32..10.0, vy in -10.0f32..10.0,
            vz in -10.0f32..10.0, walk in -0.05f32..0.05, turn in -0.3f32..0.3, duration in 0.005f32..0.2,
        ) {
            let poses = [Pose::default(), Pose::new(walk, 0.0, turn)];
            let solids: Vec<Solid> = solids_of_robot(0, &Body::default(), poses, false).collect();
            let start = ball([x, y, z], [vx, vy, vz]);
            let outside = |ball: &FlyingBall, share| solids.iter().map(|solid| solid.signed_distance(ball.centre(), share).0)
                .fold(f32::INFINITY, f32::min);
            prop_assume!(outside(&start, 0.0) > 0.03);
            let (mut contacts, mut path, mut heights) = (Vec::new(), Vec::new(), Vec::new());
            let end = fly_ball(start, &solids, duration, &mut contacts, &mut path, &mut heights);
            prop_assert!(end.position.is_finite() && end.velocity.is_finite() && end.position.z >= 0.0);
            prop_assert!(contacts.len() >= MOST_BOUNCES || outside(&end, 1.0) > 0.03 - 5e-3, "{} {end:?}", outside(&end, 1.0));
        }
    }
}

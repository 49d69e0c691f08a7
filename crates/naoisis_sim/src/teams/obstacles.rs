//! Robots and posts as circles that a player does not enter, and the way past them.

use bevy::prelude::*;

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

    /// Returns all obstacles, in the order in which they were added.
    pub fn iter(&self) -> impl Iterator<Item = &Obstacle> {
        self.circles[..self.count].iter()
    }
}

/// Returns the way to go now to reach `to` past the obstacles: straight, or along the tangent of the first obstacle on the way.
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

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

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
        // The obstacle is behind the place to reach.
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
}

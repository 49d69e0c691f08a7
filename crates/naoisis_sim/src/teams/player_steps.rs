//! The steps of a player to a place past the obstacles that it knows.

use bevy::prelude::*;

use super::obstacles::{
    OBSTACLE_MEMORY_S, OBSTACLE_RANGE_M, Obstacles, POST_CLEARANCE_M, REPORTED_MEMORY_S, ROBOT_CLEARANCE_M, way_around,
};
use super::player::Player;
use super::walking::step_towards;
use naoisis_core::geometry::{angle_of, unit, unrotate};
use naoisis_core::robot::motion::WalkCommand;
use naoisis_sensing::belief::RobotBelief;
use naoisis_sensing::sensing::status::BodyStatus;

impl<'a> Player<'a> {
    /// Returns the obstacles: robots, posts, and what else the sonars detect. The ball is not among them.
    pub fn obstacles(&self) -> Obstacles {
        let mut obstacles = Obstacles::default();
        let own = self.position();
        let near = |place: Vec2| place.distance_squared(own) < OBSTACLE_RANGE_M * OBSTACLE_RANGE_M;
        let robots = self.belief.opponents.iter().chain(&self.belief.team_mates);
        // Team-mates that reported their places walk on.
        let memory_s = |robot: &RobotBelief| if robot.id.is_some() { REPORTED_MEMORY_S } else { OBSTACLE_MEMORY_S };
        for robot in robots.filter(|robot| robot.age_s < memory_s(robot) && near(robot.position_m)) {
            obstacles.add(robot.position_m, ROBOT_CLEARANCE_M + 2.0 * self.wider_than_nao_m());
        }
        for post in self.goal_posts().into_iter().filter(|post| near(*post)) {
            obstacles.add(post, POST_CLEARANCE_M + self.wider_than_nao_m());
        }
        // Obstacles that are far away will be seen in time.
        for (_, offset) in self.echoes().filter(|(distance_m, _)| *distance_m < 0.45) {
            let place = own + offset;
            let known = obstacles.iter().any(|known| known.centre.distance_squared(place) < 0.4 * 0.4);
            if !known {
                obstacles.add(place, 0.3);
            }
        }
        obstacles
    }

    /// Returns the echoes of the sonars: each distance, m, and the offset from the player to the middle of what gave the echo, m, team
    /// frame.
    pub fn echoes(&self) -> impl Iterator<Item = (f32, Vec2)> + use<'a> {
        /// The middle of an object lies this far behind the surface that gives the echo, m.
        const ECHO_DEPTH_M: f32 = 0.05;
        let (forward, heading) = (self.forward, self.sonar_settings.heading);
        [(self.sonar.left, 1.0), (self.sonar.right, -1.0)].into_iter().filter_map(move |(distance_m, side)| {
            let distance_m = distance_m?;
            Some((distance_m, forward.rotate(unit(side * heading)) * (distance_m + ECHO_DEPTH_M)))
        })
    }

    /// Returns the step towards `place` past the obstacles, turning to `facing` (unit vector, team frame).
    pub fn walk_to(&self, place: Vec2, facing: Vec2, obstacles: &Obstacles) -> WalkCommand {
        let way = way_around(self.position(), place, obstacles);
        step_towards(self.forward, way, facing, self.motion, self.period)
    }

    /// Returns the step towards a place to stay at. A standing player that is near enough keeps standing, a walking one goes on until it
    /// has arrived: believed places are not exact, and a standing player need not follow their noise.
    pub fn go_and_stay(&self, place: Vec2, facing: Vec2, obstacles: &Obstacles) -> WalkCommand {
        /// A standing player stays within this distance, m, and angle, radians.
        const STAYS: (f32, f32) = (0.12, 0.35);
        /// A walking player goes on until it is within these.
        const THERE: (f32, f32) = (0.04, 0.1);

        /// The same for robots without a gait, which follow commands at once.
        const STAYS_EXACTLY: (f32, f32) = (0.04, 0.05);
        const THERE_EXACTLY: (f32, f32) = (0.01, 0.02);

        let (near_m, turned) = match (self.body == BodyStatus::Walking, &self.motion.gait) {
            (true, Some(_)) => THERE,
            (false, Some(_)) => STAYS,
            (true, None) => THERE_EXACTLY,
            (false, None) => STAYS_EXACTLY,
        };
        let is_there = place.distance_squared(self.position()) < near_m * near_m;
        if !is_there {
            return self.travel_to(place, facing, obstacles);
        }
        let off = angle_of(unrotate(self.forward, facing)).abs();
        if off < turned { WalkCommand::default() } else { self.walk_to(self.position(), facing, obstacles) }
    }

    /// Returns the step towards `place`: facing ahead if it is far away, otherwise turning to `facing`.
    pub fn travel_to(&self, place: Vec2, facing: Vec2, obstacles: &Obstacles) -> WalkCommand {
        let way = place - self.position();
        let facing = if way.length_squared() > 0.8 * 0.8 { way.normalize_or(facing) } else { facing };
        self.walk_to(place, facing, obstacles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::geometry::Pose;
    use naoisis_core::team::{RobotId, Team};

    #[test]
    fn obstacles_are_robots_posts_and_what_only_the_sonars_know() {
        let mut situation = PlayerFixture::new(Pose::new(2.0, 0.6, 0.0), Vec2::ZERO);
        let robot = |x, y, age_s| RobotBelief { id: None, position_m: Vec2::new(x, y), covariance: [0.0; 3], age_s };
        situation.belief.opponents = vec![robot(1.5, 0.6, 0.0), robot(-2.0, 0.0, 0.0), robot(2.2, 0.0, 5.0)];
        let count = |situation: &PlayerFixture| situation.player().obstacles().iter().count();
        // The opponent near by, and the post at (2.975, 0.7); the others are far away or long gone.
        assert_eq!(count(&situation), 2);
        situation.sonar.left = Some(0.3);
        assert_eq!(count(&situation), 3);
        // The robot that gave the echo is known.
        situation.belief.opponents.push(robot(2.33, 0.72, 0.0));
        assert_eq!(count(&situation), 3);
        // A team-mate that reported its place walks on.
        let told = |age_s| RobotBelief { id: Some(RobotId::new(Team::Blue, 3)), ..robot(1.4, -0.3, age_s) };
        situation.belief.team_mates = vec![told(0.5 * REPORTED_MEMORY_S)];
        assert_eq!(count(&situation), 4);
        situation.belief.team_mates = vec![told(1.5 * REPORTED_MEMORY_S)];
        assert_eq!(count(&situation), 3);
    }
}

//! Free places for robots and ball that the referee puts down.
//!
//! What is put down goes where it belongs, or, when something stands there, to the nearest of a fixed pattern of
//! places around. Robots are placed in the order of their ids, so the outcome depends on no other order.

use core::f32::consts::TAU;

use bevy::prelude::*;

use super::formation::formation;
use super::snapshot::{Disc, MatchSnapshot, RobotSnapshot};
use crate::geometry::{Pose, unit};
use crate::robot::body::{BodyBounds, Footprint};
use crate::team::Team;

/// Room that is left around whatever is placed, m.
const CLEARANCE: f32 = 0.02;
/// Distance between the rings of places that are tried, m.
const RING_DISTANCE: f32 = 0.05;
/// Rings that are tried: up to 5 m away.
const RINGS: u32 = 100;
/// Places on each ring.
const PLACES_ON_RING: u32 = 16;

/// What stands in the way of something that is placed.
#[derive(Clone, Debug, Default)]
pub struct Occupied {
    /// Torsos of robots, each grown by the clearance.
    torsos: Vec<Footprint>,
    /// Bases of robots, each grown by the clearance.
    bases: Vec<Footprint>,
    /// Posts.
    posts: Vec<Disc>,
    /// The ball, where robots may not be put onto it.
    ball: Option<Disc>,
}

impl Occupied {
    /// Only the posts and, if there is one, a ball at `ball`.
    pub fn by_posts(posts: &[Disc], ball: Option<Disc>) -> Self {
        Self { posts: posts.to_vec(), ball, ..Self::default() }
    }

    /// The posts, the ball, and all robots on the pitch but the one of index `but`.
    pub fn by_others(snapshot: &MatchSnapshot, but: Option<usize>) -> Self {
        let ball = snapshot.ball.map(|ball| Disc { centre: ball.position, radius: ball.radius });
        let mut occupied = Self::by_posts(snapshot.posts, ball);
        for (index, robot) in snapshot.robots.iter().enumerate() {
            if robot.is_present() && Some(index) != but {
                occupied.add_robot(robot.pose, &robot.bounds);
            }
        }
        occupied
    }

    /// The robots that wait beside the pitch.
    pub fn by_waiting(snapshot: &MatchSnapshot) -> Self {
        let mut occupied = Self::default();
        for robot in snapshot.robots.iter().filter(|robot| !robot.is_present()) {
            occupied.add_robot(robot.pose, &robot.bounds);
        }
        occupied
    }

    /// The ball lies there instead.
    pub fn set_ball(&mut self, ball: Disc) {
        self.ball = Some(ball);
    }

    /// Adds a robot.
    pub fn add_robot(&mut self, pose: Pose, bounds: &BodyBounds) {
        self.torsos.push(grown(bounds.torso.footprint(pose)));
        self.bases.push(grown(bounds.base.footprint(pose)));
    }

    /// Whether a robot can stand there.
    pub fn admits_robot(&self, pose: Pose, bounds: &BodyBounds) -> bool {
        let torso = bounds.torso.footprint(pose);
        let base = bounds.base.footprint(pose);
        self.torsos.iter().all(|other| other.overlap(&torso).is_none())
            && self.posts.iter().all(|post| torso.overlap_disc(post.centre, post.radius + CLEARANCE).is_none())
            && self.ball.is_none_or(|ball| base.overlap_disc(ball.centre, ball.radius + CLEARANCE).is_none())
    }

    /// Whether a ball can lie there.
    pub fn admits_ball(&self, centre: Vec2, radius: f32) -> bool {
        self.bases.iter().all(|base| base.overlap_disc(centre, radius).is_none())
            && self.posts.iter().all(|post| post.centre.distance(centre) > post.radius + radius + CLEARANCE)
    }

    /// The free pose nearest to the one wanted, with its heading; the wanted one where nothing is free for metres.
    pub fn free_pose(&self, wanted: Pose, bounds: &BodyBounds) -> Pose {
        places_around(wanted.position)
            .map(|position| Pose { position, ..wanted })
            .find(|pose| self.admits_robot(*pose, bounds))
            .unwrap_or(wanted)
    }

    /// The free place for the ball nearest to the one wanted; the wanted one where nothing is free for metres.
    pub fn free_ball_place(&self, wanted: Vec2, radius: f32) -> Vec2 {
        places_around(wanted).find(|place| self.admits_ball(*place, radius)).unwrap_or(wanted)
    }
}

fn grown(footprint: Footprint) -> Footprint {
    Footprint { half_extents: footprint.half_extents + CLEARANCE, ..footprint }
}

/// The place itself, then rings of places around it.
fn places_around(centre: Vec2) -> impl Iterator<Item = Vec2> {
    let rings = (1..=RINGS).flat_map(move |ring| {
        (0..PLACES_ON_RING)
            .map(move |place| centre + unit(TAU * place as f32 / PLACES_ON_RING as f32) * (ring as f32 * RING_DISTANCE))
    });
    core::iter::once(centre).chain(rings)
}

/// Where every robot that is not penalised stands for a kick-off of `kick_off_team`, or for a drop ball if there is
/// none; none for the others.
pub fn line_up(snapshot: &MatchSnapshot, kick_off_team: Option<Team>) -> impl Iterator<Item = Option<Pose>> {
    let ball = snapshot.ball.map(|ball| Disc { centre: Vec2::ZERO, radius: ball.radius });
    let mut occupied = Occupied::by_posts(snapshot.posts, ball);
    snapshot.robots.iter().map(move |robot| {
        robot.is_present().then(|| {
            let RobotSnapshot { id, bounds, .. } = robot;
            let own_end = snapshot.game.own_end(id.team);
            let team_size = snapshot.rules.team_size;
            let wanted = formation(snapshot.pitch, team_size, id.number, own_end, kick_off_team == Some(id.team));
            let pose = occupied.free_pose(wanted, bounds);
            occupied.add_robot(pose, bounds);
            pose
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_that_is_taken_is_left_for_the_nearest_free_one() {
        let bounds = BodyBounds::default();
        let mut occupied = Occupied::by_posts(&[Disc { centre: Vec2::new(1.0, 0.0), radius: 0.05 }], None);
        let wanted = Pose::new(0.0, 0.0, 0.0);
        assert_eq!(occupied.free_pose(wanted, &bounds), wanted);
        occupied.add_robot(wanted, &bounds);
        let pose = occupied.free_pose(wanted, &bounds);
        // Side by side in x: torsos are 8 cm thick, and 2 cm are left between them.
        assert!((0.1..0.2).contains(&pose.position.length()), "{pose:?}");
        assert!(occupied.admits_robot(pose, &bounds));
        assert!(!occupied.admits_robot(Pose::new(0.96, 0.0, 0.0), &bounds));
    }

    #[test]
    fn the_ball_is_not_put_into_a_robot() {
        let bounds = BodyBounds::default();
        let mut occupied = Occupied::default();
        occupied.add_robot(Pose::new(1.0, 1.6, 0.0), &bounds);
        let place = occupied.free_ball_place(Vec2::new(1.0, 1.6), 0.03);
        let distance = bounds.base.footprint(Pose::new(1.0, 1.6, 0.0)).signed_distance(place).0;
        assert!((0.03..0.3).contains(&distance), "{distance}");
    }
}

//! Free places for robots and ball.
//!
//! A robot or the ball is placed at the wanted position, or if that is occupied, at the nearest free one of a fixed pattern around it.
//! Robots are placed in the order of their ids. If the carpet is full, which the check of a scenario finds for all kick-offs, the position
//! is beside it: nothing is ever placed into another object.

use core::f32::consts::TAU;

use bevy::prelude::*;

use super::formation::start_pose;
use super::snapshot::{Disc, MatchSnapshot};
use crate::game::{Game, Rules};
use crate::geometry::{Pose, unit};
use crate::pitch::Pitch;
use crate::robot::body::{Body, Footprint};
use crate::team::{RobotId, Team};

/// Clearance around a placed robot or ball, m.
const CLEARANCE: f32 = 0.02;
/// Distance between the rings of positions that are tried, m.
const RING_DISTANCE: f32 = 0.05;
/// Number of rings that are tried: up to 5 m away.
const RINGS: u32 = 100;
/// Least number of positions on each ring.
const PLACES_ON_RING: u32 = 16;
/// Greatest distance between positions on a ring, m.
const PLACE_DISTANCE: f32 = 0.15;
/// Distance of the first position beside the carpet from its edge, m: no post on the carpet reaches so far.
const BESIDE_CARPET: f32 = 1.5;
/// Distance between positions beside the carpet that are tried, m: wider than most balls.
const BESIDE_DISTANCE: f32 = 0.4;
/// Number of positions beside the carpet that are tried, one behind the other: more than there are robots.
const PLACES_BESIDE: u32 = 4096;

/// The obstacles for placing a robot or the ball.
#[derive(Clone, Debug)]
pub struct Occupied {
    /// Half extents of the carpet, m.
    carpet: Vec2,
    /// Torsos of robots, each grown by the clearance.
    torsos: Vec<Footprint>,
    /// Bases of robots, each grown by the clearance.
    bases: Vec<Footprint>,
    /// Posts, of goals and extra ones.
    posts: Vec<Disc>,
    /// The ball, if robots may not be placed onto it.
    ball: Option<Disc>,
}

impl Occupied {
    /// The posts and, if there is one, a ball at `ball`.
    pub fn by_posts(pitch: &Pitch, posts: &[Disc], ball: Option<Disc>) -> Self {
        let carpet = pitch.carpet_half_extents();
        Self { carpet, torsos: Vec::new(), bases: Vec::new(), posts: posts.to_vec(), ball }
    }

    /// The posts, the ball, and all robots on the pitch except the one with the index `but`.
    pub(crate) fn by_others(snapshot: &MatchSnapshot, but: Option<usize>) -> Self {
        let ball = snapshot.ball.map(|ball| Disc { centre: ball.position, radius: ball.radius });
        let mut occupied = Self::by_posts(snapshot.pitch, snapshot.posts, ball);
        for (index, robot) in snapshot.robots.iter().enumerate() {
            if !robot.penalty.is_off_pitch() && Some(index) != but {
                occupied.add_robot(robot.pose, &robot.bounds);
            }
        }
        occupied
    }

    /// The posts, and the robots that wait beside the pitch.
    pub(crate) fn by_waiting(snapshot: &MatchSnapshot) -> Self {
        let mut occupied = Self::by_posts(snapshot.pitch, snapshot.posts, None);
        for robot in snapshot.robots.iter().filter(|robot| !robot.is_present()) {
            occupied.add_robot(robot.pose, &robot.bounds);
        }
        occupied
    }

    /// Adds a robot.
    pub fn add_robot(&mut self, pose: Pose, bounds: &Body) {
        self.torsos.push(grown(bounds.torso.footprint(pose)));
        self.bases.push(grown(bounds.base.footprint(pose)));
    }

    /// Whether `pose` is free for a robot.
    pub(crate) fn admits_robot(&self, pose: Pose, bounds: &Body) -> bool {
        let torso = bounds.torso.footprint(pose);
        let base = bounds.base.footprint(pose);
        self.torsos.iter().all(|other| other.overlap(&torso).is_none())
            && self.posts.iter().all(|post| torso.overlap_disc(post.centre, post.radius + CLEARANCE).is_none())
            && self.ball.is_none_or(|ball| {
                base.overlap_disc(ball.centre, ball.radius + CLEARANCE).is_none()
                    && torso.overlap_disc(ball.centre, ball.radius).is_none()
            })
    }

    /// Whether `centre` is free for a ball.
    fn admits_ball(&self, centre: Vec2, radius: f32) -> bool {
        self.bases.iter().all(|base| base.overlap_disc(centre, radius).is_none())
            && self.posts.iter().all(|post| post.centre.distance(centre) > post.radius + radius + CLEARANCE)
    }

    /// The free pose on the carpet nearest to the wanted one, with its heading. If nothing on the carpet is free for metres, a pose beside
    /// the carpet.
    pub fn free_pose(&self, wanted: Pose, bounds: &Body) -> Pose {
        self.free_pose_from(0, wanted, bounds).1
    }

    /// Like [`free_pose`](Self::free_pose), with the first `tried` positions known to be occupied. Also returns the index of the position.
    fn free_pose_from(&self, tried: usize, wanted: Pose, bounds: &Body) -> (usize, Pose) {
        let is_free = |position| self.admits_robot(Pose { position, ..wanted }, bounds);
        let (tried, position) = self.free_place_from(tried, wanted.position, is_free);
        (tried, Pose { position, ..wanted })
    }

    /// The wanted position for a ball if it overlaps nothing there: it may touch a robot. Otherwise the nearest free position.
    pub(crate) fn ball_place(&self, wanted: Vec2, radius: f32) -> Vec2 {
        if self.admits_ball(wanted, radius - CLEARANCE) { wanted } else { self.free_ball_place(wanted, radius) }
    }

    /// The free position on the carpet for the ball nearest to the wanted one. If nothing on the carpet is free for metres, a position
    /// beside the carpet.
    pub(crate) fn free_ball_place(&self, wanted: Vec2, radius: f32) -> Vec2 {
        self.free_place_from(0, wanted, |place| self.admits_ball(place, radius)).1
    }

    /// The first free position with an index of at least `tried`, and its index.
    fn free_place_from(&self, tried: usize, wanted: Vec2, is_free: impl Fn(Vec2) -> bool) -> (usize, Vec2) {
        let on_carpet = places_around(wanted).filter(|place| place.abs().cmple(self.carpet).all());
        let x = wanted.x.clamp(-self.carpet.x, self.carpet.x);
        let side = if wanted.y < 0.0 { -1.0 } else { 1.0 };
        let beside = (0..PLACES_BESIDE)
            .map(|place| Vec2::new(x, side * (self.carpet.y + BESIDE_CARPET + place as f32 * BESIDE_DISTANCE)));
        let mut places = on_carpet.chain(beside).enumerate().skip(tried);
        places.find(|(_, place)| is_free(*place)).unwrap_or((tried, wanted))
    }
}

fn grown(footprint: Footprint) -> Footprint {
    Footprint { half_extents: footprint.half_extents + CLEARANCE, ..footprint }
}

/// The position itself, then rings of positions around it.
fn places_around(centre: Vec2) -> impl Iterator<Item = Vec2> {
    let rings = (1..=RINGS).flat_map(move |ring| {
        let radius = ring as f32 * RING_DISTANCE;
        let places = PLACES_ON_RING.max((TAU * radius / PLACE_DISTANCE) as u32);
        (0..places).map(move |place| centre + unit(TAU * place as f32 / places as f32) * radius)
    });
    core::iter::once(centre).chain(rings)
}

/// The placing of robots for a kick-off, one after the other.
#[derive(Clone, Debug)]
pub struct LineUp<'a> {
    pitch: &'a Pitch,
    game: &'a Game,
    rules: &'a Rules,
    kick_off_team: Option<Team>,
    occupied: Occupied,
    /// The number of occupied positions around each position of the formation, for each body.
    tried: Vec<(Pose, Body, usize)>,
}

impl<'a> LineUp<'a> {
    /// A kick-off of `kick_off_team`, or a drop ball if there is none, with no robots placed yet.
    pub fn new(
        pitch: &'a Pitch,
        posts: &[Disc],
        ball: Option<Disc>,
        game: &'a Game,
        rules: &'a Rules,
        kick_off_team: Option<Team>,
    ) -> Self {
        let occupied = Occupied::by_posts(pitch, posts, ball);
        Self { pitch, game, rules, kick_off_team, occupied, tried: Vec::new() }
    }

    /// Keeps the place of a robot that waits beside the pitch free.
    pub fn keep_free(&mut self, pose: Pose, bounds: &Body) {
        self.occupied.add_robot(pose, bounds);
    }

    /// Places a robot at the free position nearest to its own.
    pub fn put_down(&mut self, id: RobotId, bounds: &Body) -> Pose {
        let wanted = self.place_of(id);
        // Jersey numbers beyond those of a formation share its positions: a position that was occupied for one need not be tried for the
        // next.
        let known = self.tried.iter().position(|(place, body, _)| *place == wanted && body == bounds);
        let known = known.unwrap_or_else(|| {
            self.tried.push((wanted, *bounds, 0));
            self.tried.len() - 1
        });
        let (tried, pose) = self.occupied.free_pose_from(self.tried[known].2, wanted, bounds);
        self.tried[known].2 = tried;
        self.occupied.add_robot(pose, bounds);
        pose
    }

    /// The pose at which a robot is placed if it is free: its position in the formation, or where it walks in from.
    pub fn place_of(&self, id: RobotId) -> Pose {
        let kicks_off = self.kick_off_team == Some(id.team);
        let (number, own_end) = (self.game.role_number(id), self.game.own_end(id.team));
        start_pose(self.pitch, self.rules, number, own_end, kicks_off)
    }

    /// The position of a ball of `radius`, m: the free position nearest to the centre mark.
    pub fn ball_place(&self, radius: f32) -> Vec2 {
        self.occupied.free_ball_place(Vec2::ZERO, radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::game::KickOffProcedure;
    use proptest::prelude::*;

    #[test]
    fn a_place_that_is_taken_is_left_for_the_nearest_free_one() {
        let bounds = Body::default();
        let posts = [Disc { centre: Vec2::new(1.0, 0.0), radius: 0.05 }];
        let mut occupied = Occupied::by_posts(&Pitch::default(), &posts, None);
        let wanted = Pose::new(0.0, 0.0, 0.0);
        assert_eq!(occupied.free_pose(wanted, &bounds), wanted);
        occupied.add_robot(wanted, &bounds);
        let pose = occupied.free_pose(wanted, &bounds);
        // Side by side in x: torsos are 8 cm thick, and 2 cm remain between them.
        assert!((0.1..0.2).contains(&pose.position.length()), "{pose:?}");
        assert!(occupied.admits_robot(pose, &bounds));
        assert!(!occupied.admits_robot(Pose::new(0.96, 0.0, 0.0), &bounds));
    }

    #[test]
    fn a_ball_beside_the_feet_is_not_below_a_shoulder_either() {
        let ball = Disc { centre: Vec2::new(0.0, 0.25), radius: 0.12 };
        let occupied = Occupied::by_posts(&Pitch::default(), &[], Some(ball));
        // The base ends at 10 cm, the torso at 15 cm, and the ball at 13 cm.
        assert!(!occupied.admits_robot(Pose::default(), &Body::default()));
    }

    #[test]
    fn the_ball_is_not_put_into_a_robot() {
        let bounds = Body::default();
        let mut occupied = Occupied::by_posts(&Pitch::default(), &[], None);
        occupied.add_robot(Pose::new(1.0, 1.6, 0.0), &bounds);
        let place = occupied.free_ball_place(Vec2::new(1.0, 1.6), 0.03);
        let distance = bounds.base.footprint(Pose::new(1.0, 1.6, 0.0)).signed_distance(place).0;
        assert!((0.03..0.3).contains(&distance), "{distance}");
    }

    #[test]
    fn on_a_full_carpet_things_are_put_beside_it_and_never_into_anything() {
        let (bounds, pitch) = (Body::default(), Pitch::default());
        let wall = [Disc { centre: Vec2::ZERO, radius: 6.0 }];
        let mut occupied = Occupied::by_posts(&Pitch { border_m: 0.2, ..pitch }, &wall, None);
        for _ in 0..30 {
            let pose = occupied.free_pose(Pose::new(0.0, -0.5, 1.0), &bounds);
            assert!(occupied.admits_robot(pose, &bounds) && pose.position.y < -5.9, "{pose:?}");
            occupied.add_robot(pose, &bounds);
        }
        let ball = occupied.free_ball_place(Vec2::ZERO, 0.03);
        assert!(occupied.admits_ball(ball, 0.03), "{ball}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

        #[test]
        fn robots_that_are_put_down_stand_free_and_on_the_carpet_while_there_is_room(
            posts in proptest::collection::vec((-1.2f32..1.2, -0.95f32..0.95, 0.005f32..0.3), 0..4),
            team_size in 1u8..=11, walk_in: bool, kick_off_team in proptest::option::of(proptest::sample::select(Team::BOTH.to_vec())),
        ) {
            let (bounds, game) = (Body::default(), Game::default());
            let pitch = Pitch { length_m: 2.0, width_m: 1.5, border_m: 0.4, ..Pitch::default() };
            let posts: Vec<Disc> =
                posts.into_iter().map(|(x, y, radius)| Disc { centre: Vec2::new(x, y), radius }).collect();
            let ball = Disc { centre: Vec2::ZERO, radius: 0.03 };
            let kick_off = if walk_in { KickOffProcedure::ReadyAndSet } else { KickOffProcedure::Placed };
            let rules = Rules { team_size, walk_in, kick_off, ..Rules::default() };
            let mut line_up = LineUp::new(&pitch, &posts, Some(ball), &game, &rules, kick_off_team);
            for id in Team::BOTH.into_iter().flat_map(|team| (1..=team_size).map(move |number| RobotId::new(team, number))) {
                let free = line_up.occupied.clone();
                let pose = line_up.put_down(id, &bounds);
                prop_assert!(free.admits_robot(pose, &bounds), "{id} at {pose:?}");
                prop_assert!(pose.position.abs().cmple(pitch.carpet_half_extents()).all(), "{id} at {pose:?}");
            }
        }
    }
}

//! Occlusion: which points the bodies of other robots and posts hide from a camera.

use bevy::math::Vec3A;
use bevy::prelude::*;

use crate::appearance::scene::Scene;
use naoisis_core::camera_model::CameraView;
use naoisis_core::geometry::{Pose, unrotate};
use naoisis_core::pitch::Post;
use naoisis_core::robot::body::BodyBox;

/// The bodies and posts that may be in view of a robot, in its frame. Refilled for each robot, to reuse the memory.
#[derive(Default, Debug)]
pub struct Occluders {
    robots: Vec<OccludingRobot>,
    posts: Vec<OccludingPost>,
}

/// Another robot. Its boxes are axis-aligned in its own frame.
#[derive(Debug)]
struct OccludingRobot {
    /// Index in [`Scene::robots`].
    index: usize,
    position: Vec2,
    forward: Vec2,
    reach: f32,
    boxes: [Bounds; 2],
}

#[derive(Debug)]
struct OccludingPost {
    /// Index in [`Scene::posts`].
    index: usize,
    position: Vec2,
    radius: f32,
    height: f32,
}

/// The object that is looked at, which does not hide itself.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Target {
    /// The robot with this index in [`Scene::robots`].
    Robot(usize),
    /// The post with this index in [`Scene::posts`].
    Post(usize),
    /// An object that hides nothing.
    Other,
    /// An object that nothing hides.
    Unobstructed,
}

impl Occluders {
    /// Collects the occluders in view of the camera `views` of the robot at `own_pose`, whose index in the scene is `own_index` if it has a
    /// body. An object out of view cannot hide an object in view.
    pub fn gather(&mut self, scene: &Scene, own_index: Option<usize>, own_pose: Pose, views: &[CameraView]) {
        let own_forward = own_pose.forward();
        let in_view = |position: Vec2, reach: f32, height: f32| {
            let middle = height / 2.0;
            let radius = Vec2::new(reach, middle).length();
            views.iter().any(|view| view.may_see(position.extend(middle), radius))
        };
        self.robots.clear();
        for (index, robot) in scene.robots.iter().enumerate() {
            let position = unrotate(own_forward, robot.pose.position - own_pose.position);
            let [torso, base] = robot.boxes;
            if Some(index) != own_index && in_view(position, robot.reach, torso.z_m[1].max(base.z_m[1])) {
                let forward = unrotate(own_forward, robot.forward);
                let boxes = [Bounds::of(torso), Bounds::of(base)];
                self.robots.push(OccludingRobot { index, position, forward, reach: robot.reach, boxes });
            }
        }
        self.posts.clear();
        for (index, post) in scene.posts.iter().enumerate() {
            let position = unrotate(own_forward, post.position - own_pose.position);
            let Post { radius, height, .. } = post.post;
            if in_view(position, radius, height) {
                self.posts.push(OccludingPost { index, position, radius, height });
            }
        }
    }

    /// Returns `target`, or [`Target::Unobstructed`] if no occluder is near the line of sight to any point within `radius` m of `place`. In
    /// that case the occluders need not be checked for every point.
    pub fn judge(&self, target: Target, lens: Vec3, place: Vec2, radius: f32) -> Target {
        let sight = Sight::new(lens, place);
        let is_obstructed =
            self.robots.iter().any(|robot| {
                target != Target::Robot(robot.index) && sight.passes(robot.position, robot.reach + radius)
            }) || self
                .posts
                .iter()
                .any(|post| target != Target::Post(post.index) && sight.passes(post.position, post.radius + radius));
        if is_obstructed { target } else { Target::Unobstructed }
    }

    /// Whether an occluder other than the target is between the lens and a point of the target at `place`, `height_m` above the ground
    /// (robot frame, m).
    pub fn hide(&self, lens: &Vec3, place: Vec2, height_m: f32, target: Target) -> bool {
        if target == Target::Unobstructed {
            return false;
        }
        let lens = *lens;
        let sight = Sight::new(lens, place);
        let direction = sight.direction.extend(height_m - lens.z);
        self.robots.iter().any(|robot| robot.hides(&sight, lens, direction, target))
            || self.posts.iter().any(|post| post.hides(&sight, lens, direction, target))
    }

    /// The first occluder that hides a point: see [`hide`](Self::hide).
    pub fn hider(&self, lens: &Vec3, place: Vec2, height_m: f32, target: Target) -> Option<Target> {
        if target == Target::Unobstructed {
            return None;
        }
        let lens = *lens;
        let sight = Sight::new(lens, place);
        let direction = sight.direction.extend(height_m - lens.z);
        let robot = self.robots.iter().find(|robot| robot.hides(&sight, lens, direction, target));
        let post = || self.posts.iter().find(|post| post.hides(&sight, lens, direction, target));
        robot.map(|robot| Target::Robot(robot.index)).or_else(|| post().map(|post| Target::Post(post.index)))
    }
}

/// A line of sight, seen from above.
struct Sight {
    lens: Vec2,
    direction: Vec2,
    length_squared: f32,
}

impl Sight {
    fn new(lens: Vec3, place: Vec2) -> Self {
        let direction = place - lens.truncate();
        Self { lens: lens.truncate(), direction, length_squared: direction.length_squared() }
    }

    /// Whether the line of sight passes within about `reach` m of `place`. A fast rejection of occluders that are far from it.
    fn passes(&self, place: Vec2, reach: f32) -> bool {
        let offset = place - self.lens;
        let reach_squared = reach * reach * self.length_squared;
        let across = self.direction.perp_dot(offset);
        if across * across > reach_squared {
            return false;
        }
        let along = self.direction.dot(offset);
        let beyond = (along - self.length_squared).max(-along);
        beyond <= 0.0 || beyond * beyond <= reach_squared
    }
}

impl OccludingRobot {
    #[inline(always)]
    fn hides(&self, sight: &Sight, lens: Vec3, direction: Vec3, target: Target) -> bool {
        target != Target::Robot(self.index)
            && sight.passes(self.position, self.reach)
            && self.is_in_the_way(lens, direction)
    }

    #[inline]
    fn is_in_the_way(&self, lens: Vec3, sight: Vec3) -> bool {
        let origin = unrotate(self.forward, lens.truncate() - self.position);
        let along = unrotate(self.forward, sight.truncate());
        let origin = Vec3A::new(origin.x, origin.y, lens.z);
        // If the line of sight does not move along an axis, the inverse is limited to the greatest number.
        let inverse = Vec3A::new(along.x, along.y, sight.z).recip().clamp(Vec3A::MIN, Vec3A::MAX);
        let [torso, base] = &self.boxes;
        torso.are_in_the_way(origin, inverse) || base.are_in_the_way(origin, inverse)
    }
}

/// An axis-aligned box, given by two of its corners.
#[derive(Debug)]
struct Bounds {
    least: Vec3A,
    greatest: Vec3A,
}

impl Bounds {
    fn of(body: BodyBox) -> Self {
        Self {
            least: Vec3A::new(body.x_m[0], -body.half_width_m, body.z_m[0]),
            greatest: Vec3A::new(body.x_m[1], body.half_width_m, body.z_m[1]),
        }
    }

    /// Whether the line of sight with this inverse direction meets the box: the intervals between the three pairs of faces overlap (Kay and
    /// Kajiya, 1986).
    #[inline(always)]
    fn are_in_the_way(&self, lens: Vec3A, inverse: Vec3A) -> bool {
        let (one, other) = ((self.least - lens) * inverse, (self.greatest - lens) * inverse);
        let (enter, leave) = (one.min(other), one.max(other));
        enter.max_element().max(0.0) <= leave.min_element().min(1.0)
    }
}

impl OccludingPost {
    #[inline(always)]
    fn hides(&self, sight: &Sight, lens: Vec3, direction: Vec3, target: Target) -> bool {
        target != Target::Post(self.index)
            && sight.passes(self.position, self.radius)
            && self.is_in_the_way(lens, direction)
    }

    /// Whether the line of sight passes through the upright cylinder: while it is within the circle, it is not above the top.
    fn is_in_the_way(&self, lens: Vec3, sight: Vec3) -> bool {
        let offset = lens.truncate() - self.position;
        let direction = sight.truncate();
        // |offset + t direction| = radius
        let a = direction.length_squared();
        let half_b = offset.dot(direction);
        let discriminant = half_b * half_b - a * (offset.length_squared() - self.radius * self.radius);
        if a == 0.0 || discriminant < 0.0 {
            return false;
        }
        let root = discriminant.sqrt();
        let (enter, leave) = (((-half_b - root) / a).max(0.0), ((-half_b + root) / a).min(1.0));
        enter <= leave && (lens.z + enter * sight.z).min(lens.z + leave * sight.z) <= self.height
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::scene::{ScenePost, SceneRobot};
    use crate::sensing::camera::CameraSettings;
    use naoisis_core::camera_model::{CameraIntrinsics, CameraMount, CameraName};
    use naoisis_core::random::RandomStream;
    use naoisis_core::robot::body::Body;
    use naoisis_core::robot::head::HeadAngles;
    use naoisis_core::robot::posture::{LyingOn, Posture};
    use naoisis_core::team::{RobotId, Team};

    const LENS: Vec3 = Vec3::new(0.0539, 0.0, 0.5372);

    fn robot(team: Team, x: f32, y: f32, heading: f32) -> SceneRobot {
        SceneRobot::standing(RobotId::new(team, 1), Pose::new(x, y, heading), Body::default())
    }

    /// Cameras at the lens that see everything around, 60° to each side and up and down.
    fn all_around() -> [CameraView; 4] {
        let intrinsics = CameraIntrinsics::pinhole(Vec2::splat(346.4), 100.0);
        [0.0, 0.5, 1.0, 1.5].map(|pan: f32| {
            let mount = CameraMount::new(CameraName::TOP, LENS, 0.0).panned(pan * core::f32::consts::PI);
            CameraView::new(intrinsics, &mount, LENS, HeadAngles::default())
        })
    }

    fn around(others: &[SceneRobot], posts: &[ScenePost]) -> Occluders {
        let mut scene = Scene { robots: vec![robot(Team::Blue, 0.0, 0.0, 0.0)], ..default() };
        scene.robots.extend_from_slice(others);
        scene.posts.extend_from_slice(posts);
        let mut occluders = Occluders::default();
        occluders.gather(&scene, Some(0), Pose::default(), &all_around());
        occluders
    }

    impl Occluders {
        fn hide_point(&self, point: Vec3, target: Target) -> bool {
            self.hide(&LENS, point.truncate(), point.z, target)
        }
    }

    #[test]
    fn a_body_hides_what_is_just_behind_its_edge_and_no_more() {
        // A robot at 1 m that faces this one: its torso reaches to y = ±0.15 and its front is at x = 0.95. On the way to
        // a point on the ground at x = 3, the sight is at the height of the torso (below 0.46) from
        // t = (0.5372 - 0.46) / 0.5372 = 0.1437 on, x = 0.477, and below its lower edge 0.25 from t = 0.5346,
        // x = 1.629, on: in between is the whole torso, of which the edge at x = 0.95..1.03 is the outline.
        let occluders = around(&[robot(Team::Pink, 1.0, 0.0, core::f32::consts::PI)], &[]);
        // The outermost sight touches the near corner (0.95, 0.15): slope 0.15 / (0.95 - 0.0539) = 0.16739; at x = 3
        // that is y = 0.49315.
        for side in [-1.0, 1.0] {
            assert!(occluders.hide_point(Vec3::new(3.0, side * 0.492, 0.0), Target::Other));
            assert!(!occluders.hide_point(Vec3::new(3.0, side * 0.494, 0.0), Target::Other));
        }
        // Neither points in front of it nor the robot itself are hidden.
        assert!(!occluders.hide_point(Vec3::new(0.8, 0.0, 0.0), Target::Other));
        assert!(!occluders.hide_point(Vec3::new(1.0, 0.0, 0.3), Target::Robot(1)));
        // Above its shoulders the sight is free: at x = 0.95 it must be above 0.46, which the sight to a point at
        // x = 3 is if its height z satisfies 0.5372 + (z - 0.5372) 0.3042 > 0.46 at x = 0.95 and, lower, at 1.03
        // (0.3313): z > 0.3042.
        assert!(!occluders.hide_point(Vec3::new(3.0, 0.0, 0.306), Target::Other));
        assert!(occluders.hide_point(Vec3::new(3.0, 0.0, 0.302), Target::Other));
    }

    #[test]
    fn a_body_turned_sideways_is_narrower() {
        let occluders = around(&[robot(Team::Pink, 1.0, 0.0, core::f32::consts::FRAC_PI_2)], &[]);
        // Facing +y, the torso reaches from y = -0.03 to 0.05 and from x = 0.85 to 1.15, the feet to y = 0.11 and from
        // x = 0.9 to 1.1. The sight to the ground at x = 2 comes below their upper edge, 0.25, after 1 - 0.25 / 0.5372 =
        // 0.53462 of its way, x = 1.0943: it meets them if y < 0.11 / 0.53462 = 0.20575.
        assert!(occluders.hide_point(Vec3::new(2.0, 0.2052, 0.0), Target::Other));
        assert!(!occluders.hide_point(Vec3::new(2.0, 0.2063, 0.0), Target::Other));
        // To the right, the corner (0.85, -0.03): slope 0.03 / 0.7961 = 0.03768; at x = 2 y = -0.07334.
        assert!(occluders.hide_point(Vec3::new(2.0, -0.0730, 0.2), Target::Other));
        assert!(!occluders.hide_point(Vec3::new(2.0, -0.0737, 0.2), Target::Other));
    }

    #[test]
    fn a_post_hides_what_is_behind_its_cylinder() {
        let post =
            |height| ScenePost { position: Vec2::new(1.0539, 0.0), post: Post { radius: 0.05, height, colour: None } };
        let tall = around(&[], &[post(0.8)]);
        // At 1 m from the lens a radius of 5 cm hides ±asin(0.05): at x = 2.0539, 2 m away, ±0.100125 m.
        for side in [-1.0, 1.0] {
            assert!(tall.hide_point(Vec3::new(2.0539, side * 0.0999, 0.0), Target::Other));
            assert!(!tall.hide_point(Vec3::new(2.0539, side * 0.1003, 0.0), Target::Other));
        }
        assert!(!tall.hide_point(Vec3::new(1.0539, 0.0, 0.3), Target::Post(0)));
        assert!(!tall.hide_point(Vec3::new(0.9, 0.0, 0.0), Target::Other));
        // The sight to the ground at 2 m leaves the cylinder at 1.05 m, at z = 0.5372 * 0.475 = 0.2552.
        let sight = Vec3::new(2.0539, 0.0, 0.0);
        assert!(around(&[], &[post(0.256)]).hide_point(sight, Target::Other));
        assert!(!around(&[], &[post(0.254)]).hide_point(sight, Target::Other));
    }

    #[test]
    fn what_is_not_in_view_hides_nothing_that_is() {
        let mut stream = RandomStream::new(11, RobotId::new(Team::Blue, 1), "test");
        let mut within = |least: f32, greatest: f32| least + stream.uniform() * (greatest - least);
        let (mut hidden, mut left_out) = (0, 0);
        for _ in 0..300 {
            let others: Vec<_> = (0..6)
                .map(|index| {
                    let upright = robot(Team::Pink, within(-2.0, 2.0), within(-2.0, 2.0), within(-3.0, 3.0));
                    if index == 0 {
                        upright.in_posture(Posture::Fallen { cycles: 9, on: LyingOn::Front })
                    } else {
                        upright
                    }
                })
                .collect();
            let post = Post { radius: 0.05, height: 0.8, colour: None };
            let posts = [(); 4].map(|()| ScenePost { position: Vec2::new(within(-2.0, 2.0), within(-2.0, 2.0)), post });
            let everything = around(&others, &posts);
            let mut scene =
                Scene { robots: vec![robot(Team::Blue, 0.0, 0.0, 0.0)], posts: posts.to_vec(), ..default() };
            scene.robots.extend(others);
            let views = CameraSettings::default()
                .views(&Body::default(), HeadAngles { yaw: within(-2.0, 2.0), pitch: within(-0.6, 0.5) });
            let mut in_view = Occluders::default();
            in_view.gather(&scene, Some(0), Pose::default(), &views);
            left_out += everything.robots.len() - in_view.robots.len();
            for _ in 0..100 {
                let point = Vec3::new(within(-4.0, 4.0), within(-4.0, 4.0), within(0.0, 1.0));
                for view in views.iter().filter(|view| view.pixel_in_image(point).is_some()) {
                    let hide =
                        |occluders: &Occluders| occluders.hide(&view.lens, point.truncate(), point.z, Target::Other);
                    assert_eq!(hide(&in_view), hide(&everything), "{point} {view:?}");
                    hidden += usize::from(hide(&everything));
                }
            }
        }
        assert!(hidden > 300 && left_out > 600, "{hidden} {left_out}");
    }
}

//! How good the image vision is: what it finds in rendered images of random scenes, against what is there.
//!
//! ```
//! use naoisis::random::RandomStream;
//! use naoisis::sensing::vision::image::accuracy::{self, Conditions};
//!
//! let mut stream = RandomStream::for_match(1, "accuracy");
//! let table = accuracy::measure(20, Conditions::default(), &mut || stream.uniform());
//! assert!(table.ball.found_share() > 0.5);
//! println!("{table}");
//! ```

use bevy::math::{Vec2, Vec3, ops};
use core::fmt;
use std::time::Instant;

use super::{Findings, ImageVision, Known};
use crate::appearance::Label;
use crate::appearance::field::goal_label;
use crate::appearance::posing::STEP_FREQUENCY;
use crate::appearance::robot::{RobotDesign, labels};
use crate::appearance::scene::{Scene, SceneBall, ScenePost, SceneRobot};
use crate::appearance::stride::Stride;
use crate::appearance::view::View;
use crate::geometry::{Pose, to_radians};
use crate::pitch::Pitch;
use crate::robot::body::Body;
use crate::robot::head::HeadAngles;
use crate::sensing::camera::CameraSettings;
use crate::sensing::camera::image::{Image, Layers};
use crate::sensing::camera::software::{Detail, PreparedScene, Renderer};
use crate::sensing::vision::LandmarkKind;
use crate::team::{RobotId, Team};

/// A thing counts as visible with at least so many of its pixels in an image.
pub const LEAST_PIXELS: usize = 30;

/// Distances are judged up to here, m.
pub const NEAR_M: f32 = 2.0;

/// What is looked at.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Conditions {
    /// How the robots look.
    pub design: RobotDesign,
    /// The ball's radius, m.
    pub ball_radius: f32,
    /// Whether bodies cast shadows.
    pub shadows: bool,
    /// Whether pixels integrate the light over all of their area.
    pub antialiasing: bool,
}

impl Default for Conditions {
    fn default() -> Self {
        Self { design: RobotDesign::Simple, ball_radius: 0.03, shadows: false, antialiasing: true }
    }
}

/// What came of one class of things.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct ClassAccuracy {
    /// Images in which one was visible, each thing counted for itself.
    pub visible: usize,
    /// How many of those were found, near where they are.
    pub found: usize,
    /// Things found where there are none, in all images.
    pub false_detections: usize,
    /// Of those found up to [`NEAR_M`]: error of the distance as a share of it, in ascending order.
    pub near_errors: Vec<f32>,
    /// Of those found further away.
    pub far_errors: Vec<f32>,
    /// Of all that were found: error of the direction, radians, in ascending order.
    pub bearing_errors: Vec<f32>,
}

impl ClassAccuracy {
    /// Share of the visible ones that were found; one if there were none.
    pub fn found_share(&self) -> f32 {
        if self.visible == 0 { 1.0 } else { self.found as f32 / self.visible as f32 }
    }

    /// The median error of the distance up to [`NEAR_M`], as a share of it.
    pub fn near_median(&self) -> f32 {
        quantile(&self.near_errors, 0.5)
    }

    fn judge(&mut self, seen: &[Vec2], visible: &[(Vec2, usize)], all: &[Vec2]) {
        for (truth, pixels) in visible {
            if *pixels < LEAST_PIXELS {
                continue;
            }
            self.visible += 1;
            let nearest = seen.iter().map(|place| (place.distance(*truth), *place)).min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((apart, place)) = nearest else { continue };
            let distance = truth.length();
            if apart < tolerance(distance) {
                self.found += 1;
                let error = (place.length() - distance).abs() / distance;
                self.bearing_errors.push(ops::atan2(truth.perp_dot(place).abs(), truth.dot(place)));
                if distance <= NEAR_M { self.near_errors.push(error) } else { self.far_errors.push(error) }
            }
        }
        let is_false = |place: &&Vec2| all.iter().all(|truth| truth.distance(**place) >= tolerance(truth.length()));
        self.false_detections += seen.iter().filter(is_false).count();
    }
}

/// What is found this far from where it is was found, m: 20 cm and a quarter of the distance.
fn tolerance(distance: f32) -> f32 {
    0.2 + 0.25 * distance
}

fn quantile(sorted: &[f32], share: f32) -> f32 {
    sorted.get((share * (sorted.len() as f32 - 1.0)).round() as usize).copied().unwrap_or(0.0)
}

/// What came of all.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Accuracy {
    /// Images that were looked at.
    pub images: usize,
    /// How long looking at them took, drawing aside, s of wall-clock time: it differs from run to run.
    pub looking_s: f64,
    /// The ball.
    pub ball: ClassAccuracy,
    /// Goal posts.
    pub goal_posts: ClassAccuracy,
    /// Robots.
    pub robots: ClassAccuracy,
    /// Penalty crosses of which all is seen.
    pub penalty_crosses: ClassAccuracy,
}

impl fmt::Display for Accuracy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            formatter,
            "{} images, {:.0} a second on one core; visible: at least {LEAST_PIXELS} pixels (of a robot: of its waistband; of a \
             cross: all of it)",
            self.images,
            self.images as f64 / self.looking_s.max(1e-9)
        )?;
        writeln!(
            formatter,
            "{:<16}{:>8}{:>8}{:>8}{:>15}{:>13}{:>11}{:>13}{:>15}",
            "",
            "visible",
            "found",
            "share",
            "false in 100",
            "median <2 m",
            "90 % <2 m",
            "median >2 m",
            "median bearing"
        )?;
        for (name, class) in [
            ("ball", &self.ball),
            ("goal posts", &self.goal_posts),
            ("robots", &self.robots),
            ("penalty crosses", &self.penalty_crosses),
        ] {
            writeln!(
                formatter,
                "{:<16}{:>8}{:>8}{:>6.1} %{:>15.2}{:>11.1} %{:>9.1} %{:>11.1} %{:>11.2} deg",
                name,
                class.visible,
                class.found,
                100.0 * class.found_share(),
                100.0 * class.false_detections as f32 / self.images.max(1) as f32,
                100.0 * class.near_median(),
                100.0 * quantile(&class.near_errors, 0.9),
                100.0 * quantile(&class.far_errors, 0.5),
                quantile(&class.bearing_errors, 0.5).to_degrees(),
            )?;
        }
        Ok(())
    }
}

/// Looks at both cameras' images of random scenes. `uniform` draws from [0, 1).
pub fn measure(scenes: usize, conditions: Conditions, uniform: &mut dyn FnMut() -> f32) -> Accuracy {
    let mut accuracy = Accuracy::default();
    let mut prepared = PreparedScene::default();
    let mut renderer = Renderer::default();
    let mut vision = ImageVision::default();
    let mut findings = Findings::default();
    let mut image = Image::default();
    let settings = CameraSettings::default();
    for _ in 0..scenes {
        let (scene, head) = random_scene(conditions, uniform);
        let known = Known::new(&scene.pitch, conditions.ball_radius);
        prepared.prepare(&scene, Detail { design: conditions.design, ..Detail::default() });
        let own = scene.robots[0];
        for (side, camera) in settings.views(head).named() {
            let mut view = View::of_robot(camera, own.world_from_robot(), own.id);
            view.shadows = conditions.shadows;
            view.antialiasing = conditions.antialiasing;
            renderer.draw(&prepared, &view, Layers::ALL, &mut image);
            let started = Instant::now();
            vision.recognise(&image, side, camera, &known, &mut findings);
            accuracy.looking_s += started.elapsed().as_secs_f64();
            accuracy.images += 1;
            accuracy.judge(&scene, &image, &view, &findings);
        }
    }
    let Accuracy { ball, goal_posts, robots, penalty_crosses, .. } = &mut accuracy;
    for class in [ball, goal_posts, robots, penalty_crosses] {
        class.near_errors.sort_unstable_by(f32::total_cmp);
        class.far_errors.sort_unstable_by(f32::total_cmp);
        class.bearing_errors.sort_unstable_by(f32::total_cmp);
    }
    accuracy
}

impl Accuracy {
    /// Compares what was found in an image with what is there.
    fn judge(&mut self, scene: &Scene, image: &Image, view: &View, findings: &Findings) {
        let own = scene.robots[0].pose;
        let in_robot = |place: Vec2| own.inverse_transform_point(place);
        let pixels = Pixels::new(image, view);

        let ball: Vec<Vec2> = scene.ball.iter().map(|ball| in_robot(ball.position)).collect();
        let visible: Vec<_> = ball.iter().map(|place| (*place, pixels.of(Label::Ball).count())).collect();
        let seen: Vec<Vec2> = findings.ball.iter().map(|(_, ball)| ball.position_m).collect();
        self.ball.judge(&seen, &visible, &ball);

        for colour in [scene.pitch.goal.negative_x_colour, scene.pitch.goal.positive_x_colour] {
            let posts = scene.posts.iter().filter(|post| post.post.colour == Some(colour));
            let visible: Vec<_> = posts
                .map(|ScenePost { position, post }| {
                    let is_its = |point: &Vec3| point.truncate().distance(*position) < post.radius + 0.03;
                    (in_robot(*position), pixels.of(goal_label(colour)).filter(is_its).count())
                })
                .collect();
            let all: Vec<Vec2> = visible.iter().map(|(place, _)| *place).collect();
            let of_colour = findings.goal_posts.iter().filter(|(_, post)| post.colour == colour);
            let seen: Vec<Vec2> = of_colour.map(|(_, post)| post.position_m).collect();
            self.goal_posts.judge(&seen, &visible, &all);
        }

        for team in Team::BOTH {
            let [_, band] = labels(team);
            let others = scene.robots[1..].iter().filter(|robot| robot.id.team == team);
            let visible: Vec<_> = others
                .map(|robot| {
                    let place = robot.pose.position;
                    let is_its = |point: &Vec3| point.truncate().distance(place) < 0.13;
                    (in_robot(place), pixels.of(band).filter(is_its).count())
                })
                .collect();
            let all: Vec<Vec2> = visible.iter().map(|(place, _)| *place).collect();
            let of_team = findings.robots.iter().filter(|(_, robot)| robot.team == team);
            let seen: Vec<Vec2> = of_team.map(|(_, robot)| robot.position_m).collect();
            self.robots.judge(&seen, &visible, &all);
        }

        let size = scene.pitch.penalty_mark_size_m;
        let [one, other, _] = scene.pitch.marks();
        let all = [one, other].map(in_robot);
        let [long, wide] = [0.5 * size, 0.5 * scene.pitch.line_width_m.min(size)];
        let whole = [one, other].into_iter().filter_map(|cross| {
            // What two bars cover, which share a square.
            let area = |x: f32, y: f32| {
                area_in_image(view, [(x, y), (-x, y), (-x, -y), (x, -y)].map(|c| cross + Vec2::from(c)))
            };
            let expected = area(long, wide)? + area(wide, long)? - area(wide, wide)?;
            let is_its = |point: &Vec3| point.truncate().distance(cross) < size;
            let count = pixels.of(Label::Line).filter(is_its).count();
            (count as f32 > 0.9 * expected).then(|| (in_robot(cross), count))
        });
        let visible: Vec<_> = whole.collect();
        let of_kind = findings.landmarks.iter().filter(|mark| mark.kind == LandmarkKind::PenaltyCross);
        let seen: Vec<Vec2> = of_kind.map(|mark| mark.position_m).collect();
        self.penalty_crosses.judge(&seen, &visible, &all);
    }
}

/// The area of a quadrilateral on the ground in an image, pixels²; none unless all of it is in the image.
fn area_in_image(view: &View, corners: [Vec2; 4]) -> Option<f32> {
    let is_inside = |pixel: &Vec2| pixel.cmpge(Vec2::ONE).all() && pixel.cmple(view.intrinsics.size - 1.0).all();
    let pixel = |corner: Vec2| view.project(corner.extend(0.0)).filter(is_inside);
    let [a, b, c, d] = [pixel(corners[0])?, pixel(corners[1])?, pixel(corners[2])?, pixel(corners[3])?];
    Some((c - a).perp_dot(d - b).abs() / 2.0)
}

/// The points that an image's pixels show, with their labels.
struct Pixels(Vec<(Label, Vec3)>);

impl Pixels {
    fn new(image: &Image, view: &View) -> Self {
        let mut points = Vec::new();
        for v in 0..image.height {
            for u in 0..image.width {
                let (Some(label), Some(depth)) = (image.label(u, v), image.depth(u, v)) else { continue };
                if label == Label::Line || !label.is_ground() && label != Label::Sky {
                    points.push((label, view.eye + depth * view.ray(Vec2::new(u as f32 + 0.5, v as f32 + 0.5))));
                }
            }
        }
        Self(points)
    }

    fn of(&self, label: Label) -> impl Iterator<Item = Vec3> + '_ {
        self.0.iter().filter(move |(other, _)| *other == label).map(|(_, point)| *point)
    }
}

/// A robot anywhere that looks anywhere, five others, and the ball more or less ahead.
fn random_scene(conditions: Conditions, uniform: &mut dyn FnMut() -> f32) -> (Scene, HeadAngles) {
    let mut scene = Scene::empty(Pitch::default());
    let mut between = |least: f32, most: f32| least + (most - least) * uniform();
    let head = HeadAngles { yaw: to_radians(between(-60.0, 60.0)), pitch: to_radians(between(-10.0, 25.0)) };
    let pose = Pose::new(between(-2.8, 2.8), between(-1.8, 1.8), to_radians(between(-180.0, 180.0)));
    let bearing = pose.heading + head.yaw + to_radians(between(-28.0, 28.0));
    let ball = pose.position + between(0.15, 3.5) * Vec2::new(ops::cos(bearing), ops::sin(bearing));
    scene.ball = Some(SceneBall { position: ball, radius: conditions.ball_radius });
    let own = RobotId::new(Team::Blue, 1);
    scene.robots.push(SceneRobot { head, ..SceneRobot::standing(own, pose, Body::default()) });
    for index in 0..5u8 {
        let id = RobotId::new(if index % 2 == 0 { Team::Pink } else { Team::Blue }, 2 + index);
        let heading = to_radians(between(-180.0, 180.0));
        let phase = between(0.0, core::f32::consts::TAU);
        let (speed, head_yaw) = (between(0.0, 0.2), between(-1.0, 1.0));
        let is_free = |place: Vec2| {
            let apart = |other: &SceneRobot| place.distance(other.pose.position);
            scene.robots.iter().all(|other| apart(other) > 0.35)
                && scene.posts.iter().all(|post| place.distance(post.position) > 0.25)
                && place.distance(ball) > 0.17
        };
        let place = (0..100).map(|_| Vec2::new(between(-2.9, 2.9), between(-1.9, 1.9))).find(|place| is_free(*place));
        let Some(place) = place else { continue };
        let time_s = f64::from(phase / core::f32::consts::TAU / STEP_FREQUENCY);
        scene.robots.push(SceneRobot {
            head: HeadAngles { yaw: head_yaw, pitch: 0.0 },
            stride: Stride { time_s, speed, liveliness: 1.0, kick: None },
            ..SceneRobot::standing(id, Pose { position: place, heading }, Body::default())
        });
    }
    (scene, head)
}

//! Comparison of the detections of a look with the true objects.

use bevy::math::Vec2;

use super::class::{LEAST_PIXELS, There, tolerance_m};
use super::{Accuracy, Shown};
use crate::appearance::Label;
use crate::appearance::field::goal_label;
use crate::appearance::robot::labels;
use crate::appearance::scene::Scene;
use crate::sensing::vision::{LandmarkKind, LandmarkPercept, Percepts};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::LineSegment;
use naoisis_core::team::Team;

/// The greatest distance of a segment's ends from its line: m, plus a share of their distance.
const ON_LINE: [f32; 2] = [0.05, 0.05];
/// The greatest distance by which a segment may extend beyond the end of the line, m.
const BEYOND_M: f32 = 0.3;

impl Accuracy {
    /// Compares the detections of a look with the labels of its images and with the exact geometric vision.
    pub(super) fn judge(&mut self, scene: &Scene, images: &[Shown], in_view: &Percepts, seen: &Percepts) {
        let own = scene.robots[0].pose;
        let most = |count: &dyn Fn(&Shown) -> usize| images.iter().map(count).max().unwrap_or(0);

        let all: Vec<Vec2> = scene.ball.iter().map(|ball| own.inverse_transform_point(ball.position)).collect();
        let is_visible = most(&|image| image.count(Label::Ball, |_| true)) >= LEAST_PIXELS;
        let is_in_view = in_view.ball.is_some();
        let there: Vec<There> = all.iter().map(|&place| There { place, is_visible, is_in_view }).collect();
        let balls: Vec<Vec2> = seen.ball.iter().map(|ball| ball.position_m).collect();
        self.ball.judge(&balls, &there, &all);

        let mut colours = vec![scene.pitch.goal.negative_x_colour, scene.pitch.goal.positive_x_colour];
        colours.dedup();
        for colour in colours {
            let of_colour = |percepts: &Percepts| {
                let posts = percepts.goal_posts.iter().filter(|post| post.colour == colour);
                posts.map(|post| post.position_m).collect::<Vec<Vec2>>()
            };
            let posts = scene.posts.iter().filter(|post| post.post.colour == Some(colour));
            let there: Vec<There> = posts
                .map(|post| {
                    let place = own.inverse_transform_point(post.position);
                    let is_its = |place: Vec2| place.distance(post.position) < post.post.radius + 0.03;
                    let count = most(&|image| image.count(goal_label(colour), |point| is_its(point.truncate())));
                    There { place, is_visible: count >= LEAST_PIXELS, is_in_view: is_among(&of_colour(in_view), place) }
                })
                .collect();
            let all: Vec<Vec2> = there.iter().map(|post| post.place).collect();
            self.goal_posts.judge(&of_colour(seen), &there, &all);
        }

        for team in Team::BOTH {
            let [_, band] = labels(team);
            let of_team = |percepts: &Percepts| {
                let robots = percepts.robots.iter().filter(|robot| robot.team == team);
                robots.map(|robot| robot.position_m).collect::<Vec<Vec2>>()
            };
            let others = scene.robots[1..].iter().filter(|robot| robot.id.team == team);
            let there: Vec<There> = others
                .map(|robot| {
                    let place = own.inverse_transform_point(robot.pose.position);
                    let reach = robot.body.waistband.half_size_m.length() + 0.03;
                    let is_its = |place: Vec2| place.distance(robot.pose.position) < reach;
                    let count = most(&|image| image.count(band, |point| is_its(point.truncate())));
                    There { place, is_visible: count >= LEAST_PIXELS, is_in_view: is_among(&of_team(in_view), place) }
                })
                .collect();
            let all: Vec<Vec2> = there.iter().map(|robot| robot.place).collect();
            self.robots.judge(&of_team(seen), &there, &all);
        }

        self.judge_crosses(scene, images, in_view, seen);
        self.judge_lines(scene, in_view, seen);
        // For the other classes, the exact geometric vision decides which objects are in view.
        for (kind_of, class) in [
            ((|kind| matches!(kind, LandmarkKind::Junction { .. })) as fn(LandmarkKind) -> bool, &mut self.junctions),
            (|kind| kind == LandmarkKind::CentreCircle, &mut self.centre_circle),
            (|kind| kind == LandmarkKind::CornerArc, &mut self.corner_arcs),
        ] {
            let mut kinds: Vec<LandmarkKind> = Vec::new();
            for mark in in_view.landmarks.iter().chain(&seen.landmarks).filter(|mark| kind_of(mark.kind)) {
                if !kinds.contains(&mark.kind) {
                    kinds.push(mark.kind);
                }
            }
            for kind in kinds {
                let there = places(in_view, kind);
                let all = all_of(scene, own, kind);
                let there: Vec<There> =
                    there.into_iter().map(|place| There { place, is_visible: true, is_in_view: true }).collect();
                class.judge(&places(seen, kind), &there, &all);
            }
        }
    }

    fn judge_crosses(&mut self, scene: &Scene, images: &[Shown], in_view: &Percepts, seen: &Percepts) {
        let own = scene.robots[0].pose;
        let kind = LandmarkKind::PenaltyCross;
        let size = scene.pitch.penalty_mark_size_m;
        let [long, wide] = [0.5 * size, 0.5 * scene.pitch.line_width_m.min(size)];
        let there: Vec<There> = scene
            .markings
            .penalty_crosses
            .iter()
            .map(|&cross| {
                // Nearly all of the two bars, which share a square, must be visible.
                let is_whole = images.iter().any(|image| {
                    let area = |x: f32, y: f32| {
                        area_in_image(image, [(x, y), (-x, y), (-x, -y), (x, -y)].map(|c| cross + Vec2::from(c)))
                    };
                    let expected = (|| Some(area(long, wide)? + area(wide, long)? - area(wide, wide)?))();
                    let is_its = |place: Vec2| place.distance(cross) < size;
                    let count = image.count(Label::Line, |point| is_its(point.truncate()));
                    count >= LEAST_PIXELS && expected.is_some_and(|expected| count as f32 > 0.9 * expected)
                });
                let place = own.inverse_transform_point(cross);
                There { place, is_visible: is_whole, is_in_view: is_among(&places(in_view, kind), place) }
            })
            .collect();
        let all: Vec<Vec2> = there.iter().map(|cross| cross.place).collect();
        self.penalty_crosses.judge(&places(seen, kind), &there, &all);
    }

    /// Compares lines. A line is detected if there are segments on it.
    fn judge_lines(&mut self, scene: &Scene, in_view: &Percepts, seen: &Percepts) {
        let own = scene.robots[0].pose;
        let seen: Vec<[Vec2; 2]> = stretches(seen).collect();
        for line in stretches(in_view) {
            let place = nearest_of(line, Vec2::ZERO);
            let on_it = seen.iter().filter(|stretch| is_on(stretch, line));
            // The nearest point of the straight line through the segment.
            let passes = on_it.map(|stretch| {
                let along = (stretch[1] - stretch[0]).normalize_or(Vec2::X);
                stretch[0] + along * along.dot(place - stretch[0])
            });
            let found = passes.min_by(|one, other| one.distance(place).total_cmp(&other.distance(place)));
            let there = There { place, is_visible: true, is_in_view: true };
            self.lines.judge(&found.into_iter().collect::<Vec<Vec2>>(), &[there], &[place]);
        }
        let lines: Vec<[Vec2; 2]> = scene
            .markings
            .lines
            .iter()
            .map(|LineSegment { start, end }| [*start, *end].map(|end| own.inverse_transform_point(end)))
            .collect();
        let are_false = seen.iter().filter(|stretch| !lines.iter().any(|line| is_on(stretch, *line)));
        self.lines.false_detections += are_false.count();
    }
}

/// The line segments among the percepts, m, robot frame.
fn stretches(percepts: &Percepts) -> impl Iterator<Item = [Vec2; 2]> {
    percepts.landmarks.iter().filter_map(|mark| match mark.kind {
        LandmarkKind::Line { end_position_m, .. } => Some([mark.position_m, end_position_m]),
        _ => None,
    })
}

/// Whether a segment lies on a line.
fn is_on(stretch: &[Vec2; 2], [start, end]: [Vec2; 2]) -> bool {
    let along = (end - start).normalize_or(Vec2::X);
    let length = start.distance(end);
    let is_near = |place: &Vec2| along.perp_dot(*place - start).abs() < ON_LINE[0] + ON_LINE[1] * place.length();
    let [first, second] = stretch.map(|place| along.dot(place - start));
    let overlaps = first.min(second) < length + BEYOND_M && first.max(second) > -BEYOND_M;
    overlaps && stretch.iter().all(is_near)
}

/// The point of a segment nearest to `place`.
fn nearest_of([start, end]: [Vec2; 2], place: Vec2) -> Vec2 {
    let way = end - start;
    start + way * (way.dot(place - start) / way.length_squared().max(1e-6)).clamp(0.0, 1.0)
}

/// The measured positions of landmarks of a kind, m, robot frame.
fn places(percepts: &Percepts, kind: LandmarkKind) -> Vec<Vec2> {
    let of_kind = percepts.landmarks.iter().filter(|mark: &&LandmarkPercept| mark.kind == kind);
    of_kind.map(|mark| mark.position_m).collect()
}

/// The true positions of landmarks of a kind, m, robot frame.
fn all_of(scene: &Scene, own: Pose, kind: LandmarkKind) -> Vec<Vec2> {
    let in_pitch: Vec<Vec2> = match kind {
        LandmarkKind::Junction { shape } => {
            let of_shape = scene.markings.junctions.iter().filter(|junction| junction.shape == shape);
            of_shape.map(|junction| junction.position).collect()
        }
        LandmarkKind::CentreCircle => vec![Vec2::ZERO],
        LandmarkKind::CornerArc => scene.markings.corner_arcs.iter().map(|arc| arc.corner).collect(),
        _ => Vec::new(),
    };
    in_pitch.into_iter().map(|place| own.inverse_transform_point(place)).collect()
}

/// Whether `place` is near one of the others.
fn is_among(others: &[Vec2], place: Vec2) -> bool {
    others.iter().any(|other| other.distance(place) < 0.5 * tolerance_m(place.length()))
}

/// The area of a quadrilateral on the ground in an image, pixels²; `None` unless the whole quadrilateral is in the image.
fn area_in_image(shown: &Shown, corners: [Vec2; 4]) -> Option<f32> {
    let intrinsics = &shown.intrinsics;
    let is_inside = |pixel: &Vec2| pixel.cmpge(Vec2::ONE).all() && pixel.cmple(intrinsics.size - 1.0).all();
    let pixel = |corner: Vec2| {
        let in_camera = shown.view.to_camera(corner.extend(0.0));
        let is_ahead = in_camera.z > 1e-3;
        is_ahead.then(|| intrinsics.pixel(in_camera.truncate() / in_camera.z)).filter(is_inside)
    };
    let [a, b, c, d] = [pixel(corners[0])?, pixel(corners[1])?, pixel(corners[2])?, pixel(corners[3])?];
    Some((c - a).perp_dot(d - b).abs() / 2.0)
}

//! Geometric vision of the markings: line segments, junctions, penalty crosses, the centre circle and corner arcs.

use bevy::prelude::*;

use super::ahead::{LandmarksAhead, MarkAhead, StretchAhead, keep};
use super::noise::Falloff;
use super::observer::{Observer, are_enough};
use super::occlusion::Target;
use super::{ClassNoise, LandmarkKind, LandmarkPercept};
use naoisis_core::camera_model::ViewSide;
use naoisis_core::pitch::{CornerArc, LineSegment, Markings};

/// The shortest line segment that is recognised, pixels.
const SHORTEST_LINE_PX: f32 = 10.0;

/// The sample points of a line segment, as shares of its length.
const LINE_SAMPLES: [f32; 3] = [0.5, 1.0 / 6.0, 5.0 / 6.0];

/// The least number of visible sample points, of three, with which a line segment is in view.
const LINE_POINTS_NEEDED: usize = 2;

/// The greatest number of sample points of a circle or arc.
const MOST_POINTS: usize = 8;

/// The least number of visible sample points with which the centre circle (of eight) or an arc (of five) is in view.
const CIRCLE_POINTS_NEEDED: usize = 3;

impl Observer<'_> {
    pub(super) fn see_landmarks(
        &mut self,
        landmarks: &mut Vec<LandmarkPercept>,
        markings: &Markings,
        ahead: &mut LandmarksAhead,
    ) {
        let noise = self.noise;
        self.see_lines(landmarks, &markings.lines, &mut ahead.stretches, &noise.lines);
        let junctions = markings.junctions.iter().map(|junction| {
            let kind = LandmarkKind::Junction { shape: junction.shape };
            (junction.position, kind)
        });
        self.see_marks(landmarks, junctions, &mut ahead.marks, &noise.junctions);
        let crosses = markings.penalty_crosses.into_iter().map(|cross| (cross, LandmarkKind::PenaltyCross));
        self.see_marks(landmarks, crosses, &mut ahead.marks, &noise.penalty_crosses);
        landmarks.extend(self.see_round(
            Vec2::ZERO,
            &markings.centre_circle,
            LandmarkKind::CentreCircle,
            &noise.centre_circle,
        ));
        for CornerArc { corner, points } in &markings.corner_arcs {
            landmarks.extend(self.see_round(*corner, points, LandmarkKind::CornerArc, &noise.junctions));
        }
    }

    /// The ends of a line (robot frame, m), if a part of it may be in view.
    #[inline]
    fn ends_of(&self, line: LineSegment) -> Option<[Vec2; 2]> {
        let ends = [self.in_robot_frame(line.start), self.in_robot_frame(line.end)];
        let view_side = self.side_of(ends[0]);
        (view_side == ViewSide::Inside || view_side != self.side_of(ends[1])).then_some(ends)
    }

    /// The part of a segment (robot frame, m) that is in the image of a camera.
    pub(super) fn part_in_view(&self, camera: usize, [start, end]: [Vec2; 2]) -> Option<[Vec2; 2]> {
        let [from, to] = self.actual[camera].visible_part(start.extend(0.0), end.extend(0.0))?;
        Some([start.lerp(end, from), start.lerp(end, to)])
    }

    /// Adds the line segments in view of the cameras.
    fn see_lines(
        &mut self,
        landmarks: &mut Vec<LandmarkPercept>,
        lines: &[LineSegment],
        ahead: &mut Vec<StretchAhead>,
        class: &ClassNoise,
    ) {
        let cameras = 0..self.actual.len();
        let ends_of = |observer: &Self, line: &LineSegment| {
            observer.ends_of(*line).and_then(|ends| within_distance(ends, class.max_distance_m))
        };
        let Some(falloff) = &class.falloff else {
            for line in lines {
                let Some(ends) = ends_of(self, line) else { continue };
                for camera in cameras.clone() {
                    let part = self.part_in_view(camera, ends);
                    landmarks.extend(part.and_then(|ends| self.see_stretch(camera, ends, class)));
                }
            }
            return;
        };
        ahead.clear();
        for ends in lines.iter().filter_map(|line| ends_of(self, line)) {
            let odds = falloff.odds_against(nearest_point(ends).length());
            ahead.extend(cameras.clone().map(|camera| StretchAhead { camera, ends, odds }));
        }
        keep(ahead, |stretch| {
            let least = stretch.odds;
            stretch.odds = Falloff::draw_threshold(class.miss_probability, self.recognition);
            least <= stretch.odds
        });
        for &StretchAhead { camera, ends, odds } in &*ahead {
            let Some(ends) = self.part_in_view(camera, ends) else { continue };
            let farthest_squared = ends[0].length_squared().max(ends[1].length_squared());
            let reach_m = (falloff.odds_against(farthest_squared.sqrt()) > odds).then(|| falloff.distance_of(odds));
            if let Some(ends) = within_distance(ends, reach_m) {
                landmarks.extend(self.see_stretch(camera, ends, class));
            }
        }
    }

    fn see_stretch(&mut self, camera: usize, [start, end]: [Vec2; 2], class: &ClassNoise) -> Option<LandmarkPercept> {
        let view = &self.actual[camera];
        let (start, end) = (start.extend(0.0), end.extend(0.0));
        let (start_pixel, end_pixel) = (view.project(start)?, view.project(end)?);
        if start_pixel.distance_squared(end_pixel) < SHORTEST_LINE_PX * SHORTEST_LINE_PX {
            return None;
        }
        let [middle, first, last] = LINE_SAMPLES;
        let points = [start.lerp(end, middle), start.lerp(end, first), start.lerp(end, last)];
        if class.falloff.is_none() && self.stream.chance(class.miss_probability) {
            return None;
        }
        // All sample points are in the image, as both ends are.
        if !are_enough(&points, LINE_POINTS_NEEDED, |point| !self.is_hidden(camera, point, Target::Other)) {
            return None;
        }
        let start_pixel = self.measured_in_image(camera, start_pixel, class.pixel_sd);
        let end_pixel = self.measured_in_image(camera, end_pixel, class.pixel_sd);
        // The left end comes first: an image does not tell which end is the start in the pitch's list.
        let (pixel, end_pixel) =
            if start_pixel.x <= end_pixel.x { (start_pixel, end_pixel) } else { (end_pixel, start_pixel) };
        let kind = LandmarkKind::Line { end_pixel, end_position_m: self.place_on_ground(camera, end_pixel)? };
        Some(LandmarkPercept::new(self.names[camera], kind, pixel, self.place_on_ground(camera, pixel)?))
    }

    /// Adds the marks of a class in view of the cameras.
    fn see_marks(
        &mut self,
        landmarks: &mut Vec<LandmarkPercept>,
        marks: impl Iterator<Item = (Vec2, LandmarkKind)>,
        ahead: &mut Vec<MarkAhead>,
        class: &ClassNoise,
    ) {
        let Some(falloff) = &class.falloff else {
            for (position, kind) in marks {
                let Some(place) = self.may_see_mark(position, class) else { continue };
                if !self.stream.chance(class.miss_probability) {
                    landmarks.extend(self.see_mark(kind, place, class));
                }
            }
            return;
        };
        ahead.clear();
        for (position, kind) in marks {
            ahead.extend(self.may_see_mark(position, class).map(|place| MarkAhead { kind, place }));
        }
        keep(ahead, |mark| {
            falloff.odds_against(mark.place.length())
                <= Falloff::draw_threshold(class.miss_probability, self.recognition)
        });
        for &MarkAhead { kind, place } in &*ahead {
            landmarks.extend(self.see_mark(kind, place, class));
        }
    }

    /// The position of a mark (robot frame, m), if the mark may be in view and is near enough.
    fn may_see_mark(&self, position: Vec2, class: &ClassNoise) -> Option<Vec2> {
        let place = self.in_robot_frame(position);
        (!class.is_too_far(place) && self.side_of(place) == ViewSide::Inside).then_some(place)
    }

    /// The percept of a mark at `place` (robot frame, m), if it is visible to a camera.
    fn see_mark(&mut self, kind: LandmarkKind, place: Vec2, class: &ClassNoise) -> Option<LandmarkPercept> {
        let place = place.extend(0.0);
        let camera = self.best_camera(|observer, camera| {
            let pixel = observer.visible_pixel(camera, place, Target::Other)?;
            Some(observer.actual[camera].offset_from_centre_squared(pixel))
        })?;
        let pixel = self.measured_pixel_in_image(camera, place, class.pixel_sd)?;
        self.landmark(camera, kind, pixel)
    }

    /// The percept of the centre circle, or of an arc about a corner, by sample points on it.
    fn see_round(
        &mut self,
        centre: Vec2,
        points: &[Vec2],
        kind: LandmarkKind,
        class: &ClassNoise,
    ) -> Option<LandmarkPercept> {
        let radius = points[0].distance(centre);
        let centre = self.in_robot_frame(centre);
        if class.is_too_far(centre) {
            return None;
        }
        self.may_detect(class, centre)?;
        let centre = centre.extend(0.0);
        let mut places = [Vec3::ZERO; MOST_POINTS];
        let places = &mut places[..points.len().min(MOST_POINTS)];
        for (place, point) in places.iter_mut().zip(points) {
            *place = self.in_robot_frame(*point).extend(0.0);
        }
        let camera = self.best_camera(|observer, camera| {
            let is_seen = observer.actual[camera].may_see(centre, radius)
                && observer.sees_enough(camera, places, Target::Other, CIRCLE_POINTS_NEEDED);
            is_seen.then(|| observer.offset_in_image(camera, centre))
        })?;
        let pixel = self.measured_pixel(camera, centre, class.pixel_sd)?;
        self.landmark(camera, kind, pixel)
    }

    fn landmark(&self, camera: usize, kind: LandmarkKind, pixel: Vec2) -> Option<LandmarkPercept> {
        let position_m = self.place_on_ground(camera, pixel)?;
        Some(LandmarkPercept::new(self.names[camera], kind, pixel, position_m))
    }

    fn offset_in_image(&self, camera: usize, point: Vec3) -> f32 {
        let view = &self.actual[camera];
        view.offset_from_centre_squared(view.project_anywhere(point))
    }
}

/// The point of a segment nearest to the origin.
fn nearest_point([start, end]: [Vec2; 2]) -> Vec2 {
    let along = end - start;
    let share = -start.dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    start + share.clamp(0.0, 1.0) * along
}

/// The part of a segment within a distance of the origin.
fn within_distance([start, end]: [Vec2; 2], distance: Option<f32>) -> Option<[Vec2; 2]> {
    let Some(distance) = distance else { return Some([start, end]) };
    let radius_squared = distance * distance;
    if start.length_squared() <= radius_squared && end.length_squared() <= radius_squared {
        return Some([start, end]);
    }
    // |start + t along| = distance
    let along = end - start;
    let a = along.length_squared();
    let half_b = start.dot(along);
    let discriminant = half_b * half_b - a * (start.length_squared() - radius_squared);
    if a == 0.0 || discriminant <= 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let (from, to) = (((-half_b - root) / a).max(0.0), ((-half_b + root) / a).min(1.0));
    (from < to).then(|| [start + from * along, start + to * along])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_seen_as_far_as_the_greatest_distance() {
        let ends = [Vec2::new(3.0, -6.0), Vec2::new(3.0, 1.0)];
        assert_eq!(within_distance(ends, None), Some(ends));
        // At x = 3, 5 m are reached at y = -4.
        let [start, end] = within_distance(ends, Some(5.0)).unwrap();
        assert!(start.distance(Vec2::new(3.0, -4.0)) < 1e-5 && end == ends[1]);
        assert_eq!(within_distance(ends, Some(2.9)), None);
        assert!(nearest_point(ends).distance(Vec2::new(3.0, 0.0)) < 1e-5);
        assert_eq!(nearest_point([Vec2::new(3.0, 1.0), Vec2::new(3.0, 4.0)]), Vec2::new(3.0, 1.0));
        assert_eq!(within_distance([Vec2::new(6.0, 0.0), Vec2::new(9.0, 0.0)], Some(5.0)), None);
    }
}

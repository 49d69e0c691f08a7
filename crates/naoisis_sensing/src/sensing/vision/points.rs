//! Points along lines and along the edge of the carpet, for robots that localise by points.

use bevy::prelude::*;

use super::noise::ClassNoise;
use super::observer::Observer;
use super::occlusion::Target;
use super::{GroundPoint, LandmarkKind, Percepts};
use crate::appearance::scene::Scene;

/// The distance between neighbouring points in the image, pixels.
const SPACING_PX: f32 = 20.0;

/// The greatest number of points of a segment.
const MOST_POINTS: usize = 64;

impl Observer<'_> {
    /// Adds points along the lines that were detected, and along the edges of the carpet in view. Their error is that of the ends of lines.
    pub(super) fn add_points(&mut self, percepts: &mut Percepts, scene: &Scene) {
        let Percepts { landmarks, line_points, border_points, .. } = percepts;
        let class = &self.noise.lines;
        for landmark in landmarks.iter() {
            let LandmarkKind::Line { end_pixel, .. } = landmark.kind else { continue };
            let Some(camera) = self.names.iter().position(|name| *name == landmark.camera) else { continue };
            let on_ground = |pixel: Vec2| self.actual[camera].ground_point(pixel);
            if let (Some(start), Some(end)) = (on_ground(landmark.pixel), on_ground(end_pixel)) {
                self.add_points_along(line_points, camera, [start, end], class);
            }
        }
        let half = scene.pitch.carpet_half_extents();
        let corners = [half, half * Vec2::new(-1.0, 1.0), -half, half * Vec2::new(1.0, -1.0)]
            .map(|corner| self.in_robot_frame(corner));
        for camera in 0..self.actual.len() {
            for side in 0..corners.len() {
                let edge = [corners[side], corners[(side + 1) % corners.len()]];
                if let Some(part) = self.part_in_view(camera, edge) {
                    self.add_points_along(border_points, camera, part, class);
                }
            }
        }
    }

    /// Adds points of a segment (robot frame, m), at about equal distances in the image of a camera, unless they are hidden.
    fn add_points_along(
        &mut self,
        points: &mut Vec<GroundPoint>,
        camera: usize,
        [start, end]: [Vec2; 2],
        class: &ClassNoise,
    ) {
        let view = &self.actual[camera];
        let (start, end) = (start.extend(0.0), end.extend(0.0));
        let (Some(start_pixel), Some(end_pixel)) = (view.project(start), view.project(end)) else { return };
        let depths = [start, end].map(|point| view.camera_from_robot(point).z);
        let count = ((start_pixel.distance(end_pixel) / SPACING_PX) as usize).clamp(1, MOST_POINTS);
        for index in 0..count {
            let share = on_segment((index as f32 + 0.5) / count as f32, depths);
            let point = start.lerp(end, share);
            let Some(pixel) = self.visible_pixel(camera, point, Target::Other) else { continue };
            let pixel = self.measured_in_image(camera, pixel, class.pixel_sd);
            if let Some(position_m) = self.place_on_ground(camera, pixel) {
                points.push(GroundPoint { camera: self.names[camera], pixel, position_m });
            }
        }
    }
}

/// The share of a segment at which the point is that appears at `share` of its length in an image. `depths` are those of its ends, m.
fn on_segment(share: f32, [at_start, at_end]: [f32; 2]) -> f32 {
    share * at_start / (share * at_start + (1.0 - share) * at_end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_middle_of_a_segment_in_the_image_is_nearer_to_the_farther_end_on_the_ground() {
        // Ends at the slopes 1 / 1 and 1 / 3: the middle at 2 / 3 is the slope of a point at the depth 1.5, a quarter of the way.
        assert_abs_diff_eq!(on_segment(0.5, [1.0, 3.0]), 0.25);
        assert_eq!(on_segment(0.5, [2.0, 2.0]), 0.5);
        assert_eq!((on_segment(0.0, [1.0, 3.0]), on_segment(1.0, [1.0, 3.0])), (0.0, 1.0));
    }
}

//! Measurement of the positions of objects: pixel errors, and the positions that follow from the pixels.

use bevy::prelude::*;

use super::observer::Observer;
use super::occlusion::Target;
use naoisis_core::camera_model::CameraMounts;

/// The greatest measured distance of an object on a pitch, m.
const GREATEST_DISTANCE_M: f32 = 20.0;

/// The part of an upright object from which its position is measured, best first.
#[derive(Clone, Copy, PartialEq, PartialOrd, Debug)]
pub(super) enum Cue {
    /// Its foot.
    Foot,
    /// A point at this height above the ground, m.
    Height(f32),
    /// Its width in the image, at this height, m.
    Width(f32),
}

impl Observer<'_> {
    /// The camera and the cue by which a target that stands at `place` is best located; `None` if no camera has a cue. The foot is the cue
    /// if a camera sees it; of several such cameras, the one that has it nearest to the middle of its image is chosen.
    pub(super) fn best_cue(
        &self,
        place: Vec2,
        target: Target,
        cue: impl Fn(&Self, usize) -> Option<Cue>,
    ) -> Option<(usize, Cue)> {
        let foot = place.extend(0.0);
        let mut best: Option<(usize, Cue)> = None;
        let mut have_foot = [false; CameraMounts::MOST];
        for (index, has_foot) in have_foot.iter_mut().enumerate().take(self.actual.len()) {
            if let Some(cue) = cue(self, index) {
                *has_foot = cue == Cue::Foot;
                if best.is_none_or(|(_, least)| cue < least) {
                    best = Some((index, cue));
                }
            }
        }
        best?;
        let by_foot = self.best_camera(|observer, index| {
            let view = &observer.actual[index];
            let sees_foot = have_foot[index] || observer.is_visible(index, foot, target);
            sees_foot.then(|| view.offset_from_centre_squared(view.project_anywhere(foot)))
        });
        by_foot.map(|index| (index, Cue::Foot)).or(best)
    }

    /// The measured pixel of a point (robot frame, m).
    pub(super) fn measured_pixel(&mut self, camera: usize, point: Vec3, pixel_sd: f32) -> Option<Vec2> {
        let pixel = self.actual[camera].project(point)?;
        Some(pixel + self.pixel_error(pixel_sd))
    }

    fn pixel_error(&mut self, pixel_sd: f32) -> Vec2 {
        Vec2::new(self.stream.gaussian(pixel_sd), self.stream.gaussian(pixel_sd))
    }

    /// The measured pixel of a point in view; noise does not move it out of the image.
    pub(super) fn measured_pixel_in_image(&mut self, camera: usize, point: Vec3, pixel_sd: f32) -> Option<Vec2> {
        let pixel = self.actual[camera].project(point)?;
        Some(self.measured_in_image(camera, pixel, pixel_sd))
    }

    /// A pixel of the image with its error; noise does not move it out of the image.
    pub(super) fn measured_in_image(&mut self, camera: usize, pixel: Vec2, pixel_sd: f32) -> Vec2 {
        let pixel = pixel + self.pixel_error(pixel_sd);
        self.actual[camera].clamp_to_image(pixel)
    }

    /// The position on the ground that the robot computes from a pixel, m, robot frame.
    pub(super) fn place_on_ground(&self, camera: usize, pixel: Vec2) -> Option<Vec2> {
        on_pitch(self.believed[camera].ground_point(pixel))
    }

    /// The measured pixel of the foot of an object at `place`, and the object's measured position, by `cue`. If the cue is not the foot,
    /// the pixel follows from the measured position, and may be outside the image.
    pub(super) fn measured_standing_point(
        &mut self,
        camera: usize,
        place: Vec2,
        radius: f32,
        cue: Cue,
        pixel_sd: f32,
    ) -> Option<(Vec2, Vec2)> {
        let position = match cue {
            Cue::Foot => {
                let pixel = self.measured_pixel_in_image(camera, place.extend(0.0), pixel_sd)?;
                return Some((pixel, self.place_on_ground(camera, pixel)?));
            }
            Cue::Height(height) => {
                let pixel = self.measured_pixel(camera, place.extend(height), pixel_sd)?;
                self.believed[camera].point_at_height(pixel, height)
            }
            Cue::Width(height) => {
                let point = place.extend(height);
                let pixel = self.measured_pixel(camera, point, pixel_sd)?;
                // At depth z a diameter d is f d / z wide; each of the two edges has its own error.
                let scale = 2.0 * radius * self.actual[camera].intrinsics.focal.x;
                let width = scale / self.actual[camera].camera_from_robot(point).z
                    + self.stream.gaussian(core::f32::consts::SQRT_2 * pixel_sd);
                let view = &self.believed[camera];
                Some((view.lens + scale / width.max(1.0) * view.ray(pixel)).truncate())
            }
        };
        let position = on_pitch(position)?;
        Some((self.believed[camera].project_anywhere(position.extend(0.0)), position))
    }
}

/// Filters out positions that are too far away to be on a pitch.
pub(super) fn on_pitch(place: Option<Vec2>) -> Option<Vec2> {
    place.filter(|place| place.length_squared() <= GREATEST_DISTANCE_M * GREATEST_DISTANCE_M)
}

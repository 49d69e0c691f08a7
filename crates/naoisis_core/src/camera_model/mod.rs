//! The camera model: the pose of each lens, and the projection between points, pixels and the ground.
//!
//! Pure geometry in the robot frame, computed once per camera and cycle ([`CameraViews`]). The vision, the renderers and the overlays all
//! use this model.
//!
//! A robot has as many cameras as its model says ([`CameraMounts`]). A lens turns with the head about the neck. Cameras are pinholes with
//! square pixels and the principal point at the image's centre, or have a calibration ([`CameraCalibration`]), whose [`Distortion`] applies
//! both to images and to all projections here. Of the NAO, Table 1(a) of the paper gives the lens positions at zero head angles; its top
//! camera looks along the head's x axis, its bottom camera [`BOTTOM_TILT`] further down: at 320 x 240 and 58° along the diagonal, the focal
//! length is 200 px / tan 29° = 360.81 px.

use bevy::prelude::*;
use core::ops::Deref;
use tinyvec::ArrayVec;

#[cfg(test)]
mod tests;

use crate::geometry::unit;
use crate::robot::head::HeadAngles;

mod distortion;
mod intrinsics;
mod mount;
mod seen_ground;

pub use distortion::Distortion;
pub use intrinsics::{CameraCalibration, CameraIntrinsics, Pinhole};
pub use mount::{CameraMount, CameraMounts, CameraName, NotACameraName};

/// Tilt of a NAO's bottom camera, radians: 40° below the top camera (paper, section 3.1).
pub const BOTTOM_TILT: f32 = 0.698_131_7;

/// Cosine and sine of [`BOTTOM_TILT`].
const BOTTOM_TILT_UNIT: Vec2 = Vec2::new(0.766_044_44, 0.642_787_6);

/// Least distance of a point from the plane of the lens for a projection, m.
const NEAR_PLANE_M: f32 = 1e-3;

/// The views of all cameras of a robot at one instant, in the order of its model.
#[derive(Clone, Debug, Default)]
pub struct CameraViews {
    views: ArrayVec<[CameraView; CameraMounts::MOST]>,
    names: ArrayVec<[CameraName; CameraMounts::MOST]>,
}

impl CameraViews {
    /// Sets the views of the cameras at `mounts` in a head with the angles `head`, which turns about `neck`, m, robot frame. `intrinsics`
    /// returns those of each camera.
    pub fn set(
        &mut self,
        mounts: &CameraMounts,
        intrinsics: impl Fn(&CameraMount) -> CameraIntrinsics,
        neck: Vec3,
        head: HeadAngles,
    ) {
        let (yaw, pitch) = (unit(head.yaw), unit(head.pitch));
        self.views.clear();
        self.names.clear();
        for mount in mounts.iter() {
            self.views.push(CameraView::from_units(intrinsics(mount), mount, neck, yaw, pitch));
            self.names.push(mount.name);
        }
    }

    /// Sets the views of the same cameras as in `others`, with the head at the angles `head`.
    pub fn set_as(&mut self, others: &CameraViews, mounts: &CameraMounts, neck: Vec3, head: HeadAngles) {
        let (yaw, pitch) = (unit(head.yaw), unit(head.pitch));
        self.views.clear();
        let cameras = others.views.iter().zip(mounts.iter());
        self.views
            .extend(cameras.map(|(other, mount)| CameraView::from_units(other.intrinsics, mount, neck, yaw, pitch)));
        self.names.clone_from(&others.names);
    }

    /// The names of the cameras.
    pub fn names(&self) -> &[CameraName] {
        &self.names
    }

    /// Names and views.
    pub fn named(&self) -> impl Iterator<Item = (CameraName, &CameraView)> {
        self.names.iter().copied().zip(self.iter())
    }
}

impl Deref for CameraViews {
    type Target = [CameraView];

    fn deref(&self) -> &[CameraView] {
        &self.views
    }
}

/// The side of a camera's view on which a point is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ViewSide {
    /// To the left of the view.
    Left,
    /// The point may be in view.
    Inside,
    /// To the right of the view.
    Right,
}

/// One camera at one instant: its intrinsics and its pose in the robot frame.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct CameraView {
    /// The intrinsics.
    pub intrinsics: CameraIntrinsics,
    /// The lens, m, robot frame.
    pub lens: Vec3,
    /// The direction of the image's u axis, unit vector, robot frame.
    pub right: Vec3,
    /// The direction of the image's v axis, unit vector, robot frame.
    pub down: Vec3,
    /// The direction in which the camera looks, unit vector, robot frame.
    pub forward: Vec3,
}

impl CameraView {
    /// The view of a camera in a head at angles `head`, which turns about `neck`, m, robot frame.
    pub fn new(intrinsics: CameraIntrinsics, mount: &CameraMount, neck: Vec3, head: HeadAngles) -> Self {
        Self::from_units(intrinsics, mount, neck, unit(head.yaw), unit(head.pitch))
    }

    /// The view from the unit vectors at the head's yaw and pitch. The head's rotation is Rz(yaw) Ry(pitch).
    fn from_units(intrinsics: CameraIntrinsics, mount: &CameraMount, neck: Vec3, yaw: Vec2, pitch: Vec2) -> Self {
        let offset = mount.lens_m - neck;
        let lens_ahead = offset.x * pitch.x + offset.z * pitch.y;
        let lens_up = offset.z * pitch.x - offset.x * pitch.y;
        let lens =
            neck + Vec3::new(yaw.x * lens_ahead - yaw.y * offset.y, yaw.y * lens_ahead + yaw.x * offset.y, lens_up);
        if mount.pan() != 0.0 {
            return Self::panned(intrinsics, lens, mount, yaw, pitch);
        }
        let gaze = pitch.rotate(mount.tilt_unit());
        Self {
            intrinsics,
            lens,
            right: Vec3::new(yaw.y, -yaw.x, 0.0),
            down: Vec3::new(-yaw.x * gaze.y, -yaw.y * gaze.y, -gaze.x),
            forward: Vec3::new(yaw.x * gaze.x, yaw.y * gaze.x, -gaze.y),
        }
    }

    /// The view of a camera that is panned in the head: its rotation in the head is Rz(pan) Ry(tilt).
    fn panned(intrinsics: CameraIntrinsics, lens: Vec3, mount: &CameraMount, yaw: Vec2, pitch: Vec2) -> Self {
        let (pan, tilt) = (unit(mount.pan()), mount.tilt_unit());
        // From the head's frame to the robot's: Rz(yaw) Ry(pitch).
        let turned = |v: Vec3| {
            let (ahead, up) = (pitch.x * v.x + pitch.y * v.z, pitch.x * v.z - pitch.y * v.x);
            Vec3::new(yaw.x * ahead - yaw.y * v.y, yaw.y * ahead + yaw.x * v.y, up)
        };
        Self {
            intrinsics,
            lens,
            right: turned(Vec3::new(pan.y, -pan.x, 0.0)),
            down: turned(Vec3::new(-pan.x * tilt.y, -pan.y * tilt.y, -tilt.x)),
            forward: turned(Vec3::new(pan.x * tilt.x, pan.y * tilt.x, -tilt.y)),
        }
    }

    /// The rotation from the camera's axes (right, down, forward) to the robot frame.
    pub fn robot_from_camera(&self) -> Mat3 {
        Mat3::from_cols(self.right, self.down, self.forward)
    }

    /// A point of the robot frame in the camera's frame: to the right, down and ahead of the lens, m.
    #[inline]
    pub fn camera_from_robot(&self, point: Vec3) -> Vec3 {
        let offset = point - self.lens;
        Vec3::new(self.right.dot(offset), self.down.dot(offset), self.forward.dot(offset))
    }

    /// The pixel of a point in front of the lens (robot frame, m), inside the image or not.
    #[inline]
    pub fn project(&self, point: Vec3) -> Option<Vec2> {
        let in_camera = self.camera_from_robot(point);
        (in_camera.z >= NEAR_PLANE_M).then(|| self.pixel_of(in_camera))
    }

    /// Like [`CameraView::project`], but also for points behind the lens: these are treated as if they were just in front of it, far
    /// outside the image on the correct side.
    pub fn project_anywhere(&self, point: Vec3) -> Vec2 {
        let in_camera = self.camera_from_robot(point);
        self.pixel_of(Vec3 { z: in_camera.z.max(NEAR_PLANE_M), ..in_camera })
    }

    /// Whether a part of the ball with `radius`, m, around `centre`, robot frame, may be in the image. Conservative.
    #[inline]
    pub fn may_see(&self, centre: Vec3, radius: f32) -> bool {
        let in_camera = self.camera_from_robot(centre);
        let (focal, half_size) = (self.intrinsics.focal, self.intrinsics.half_size());
        // The distance to each side plane of the frustum is (f |x| - c z) / sqrt(f² + c²); f + c is more than the root.
        in_camera.z >= -radius
            && focal.x * in_camera.x.abs() <= half_size.x * in_camera.z + (focal.x + half_size.x) * radius
            && focal.y * in_camera.y.abs() <= half_size.y * in_camera.z + (focal.y + half_size.y) * radius
    }

    /// Whether the whole ball with `radius`, m, around `centre`, robot frame, is certainly in the image. Conservative.
    #[inline]
    pub fn surely_sees(&self, centre: Vec3, radius: f32) -> bool {
        let in_camera = self.camera_from_robot(centre);
        let CameraIntrinsics { focal, centre, size, distortion, .. } = self.intrinsics;
        // As in `may_see`, but inwards, to the nearer edge of the image.
        let half_size = centre.min(size - centre);
        distortion.is_none()
            && in_camera.z >= NEAR_PLANE_M + radius
            && focal.x * in_camera.x.abs() <= half_size.x * in_camera.z - (focal.x + half_size.x) * radius
            && focal.y * in_camera.y.abs() <= half_size.y * in_camera.z - (focal.y + half_size.y) * radius
    }

    /// The pixel of a point of the robot frame, m, if it is in the image.
    #[inline(always)]
    pub fn pixel_in_image(&self, point: Vec3) -> Option<Vec2> {
        let offset = point - self.lens;
        let ahead = self.forward.dot(offset);
        // Most points are not in view, which is decided without a division.
        let beside = self.right.dot(offset) * self.intrinsics.focal.x;
        if ahead < NEAR_PLANE_M || beside.abs() > (self.intrinsics.half_size().x + 1.0) * ahead {
            return None;
        }
        Some(self.pixel_of(Vec3::new(self.right.dot(offset), self.down.dot(offset), ahead)))
            .filter(|&pixel| self.contains(pixel))
    }

    /// The side of the view on which `place`, robot frame, m, certainly is, for every height between the ground and twice the height
    /// of the lens and every pitch of the head: [`ViewSide::Inside`] if it may be in view. A segment with both ends on one side is
    /// not in view. Conservative by some centimetres, so that it holds for both cameras of the head.
    #[inline]
    pub fn side_of(&self, place: Vec2) -> ViewSide {
        let offset = place - self.lens.truncate();
        let left = -self.right.truncate().dot(offset);
        // Greatest possible distance ahead of the lens along its axis: the distance ahead on the ground, and the height.
        let ahead = self.right.truncate().perp_dot(offset).abs() + self.lens.z + 0.1;
        let half_width = (self.intrinsics.half_size().x + 1.0) * ahead;
        if left * self.intrinsics.focal.x > half_width {
            ViewSide::Left
        } else if -left * self.intrinsics.focal.x > half_width {
            ViewSide::Right
        } else {
            ViewSide::Inside
        }
    }

    /// Whether a pixel is in the image: [0, width) x [0, height).
    #[inline]
    pub fn contains(&self, pixel: Vec2) -> bool {
        let size = self.intrinsics.size;
        pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < size.x && pixel.y < size.y
    }

    /// The direction in which a pixel looks, robot frame, with a unit component along [`CameraView::forward`].
    #[inline]
    pub fn ray(&self, pixel: Vec2) -> Vec3 {
        let slope = self.intrinsics.slope(pixel);
        self.forward + slope.x * self.right + slope.y * self.down
    }

    /// The point on the plane `height` m above the ground at which a pixel looks: x and y in the robot frame, m. `None` if the ray is
    /// parallel to the plane or leads away from it.
    #[inline]
    pub fn point_at_height(&self, pixel: Vec2, height: f32) -> Option<Vec2> {
        let ray = self.ray(pixel);
        let distance = (height - self.lens.z) / ray.z;
        (distance.is_finite() && distance > 0.0).then(|| self.lens.truncate() + distance * ray.truncate())
    }

    /// The point on the ground at which a pixel looks: x and y in the robot frame, m. `None` above the horizon.
    pub fn ground_point(&self, pixel: Vec2) -> Option<Vec2> {
        self.point_at_height(pixel, 0.0)
    }

    /// The part of the segment from `start` to `end` (robot frame, m) that is in the image, as shares of its length from its start. `None`
    /// if it is outside.
    pub fn visible_part(&self, start: Vec3, end: Vec3) -> Option<[f32; 2]> {
        let (start, end) = (self.camera_from_robot(start), self.camera_from_robot(end));
        let CameraIntrinsics { focal, centre, size, distortion, .. } = self.intrinsics;
        let [centre, far_corner] = if distortion.is_none() {
            [centre, size - centre]
        } else {
            // The edges are curved: the segment is first clipped to a pinhole's image that contains them.
            [self.intrinsics.half_size(); 2]
        };
        let mut part = [0.0f32, 1.0];
        // A plane of the view's frustum, by its signed "inside" distance at both ends (Liang and Barsky, 1984).
        let mut cut = |at_start: f32, at_end: f32| {
            if at_start < 0.0 && at_end < 0.0 {
                return false;
            }
            if at_start < 0.0 {
                part[0] = part[0].max(at_start / (at_start - at_end));
            } else if at_end < 0.0 {
                part[1] = part[1].min(at_start / (at_start - at_end));
            }
            true
        };
        // Most lines that are in front of the camera are above or below the image.
        let is_in_view = cut(start.z - NEAR_PLANE_M, end.z - NEAR_PLANE_M)
            && cut(focal.y * start.y + centre.y * start.z, focal.y * end.y + centre.y * end.z)
            && cut(far_corner.y * start.z - focal.y * start.y, far_corner.y * end.z - focal.y * end.y)
            && cut(focal.x * start.x + centre.x * start.z, focal.x * end.x + centre.x * end.z)
            && cut(far_corner.x * start.z - focal.x * start.x, far_corner.x * end.z - focal.x * end.x);
        if !is_in_view || part[0] >= part[1] {
            return None;
        }
        if distortion.is_none() { Some(part) } else { self.inner_part(part, |share| start.lerp(end, share)) }
    }

    /// The part of a segment between the shares `from` and `to` that is in an image with curved edges. `point` returns the point at a share
    /// of the segment, camera frame, m.
    fn inner_part(&self, [from, to]: [f32; 2], point: impl Fn(f32) -> Vec3) -> Option<[f32; 2]> {
        /// Number of pieces in which the first and last point in the image are searched.
        const PIECES: u32 = 16;

        let is_inside = |share: f32| self.contains(self.pixel_of(point(share)));
        let shares = || (0..=PIECES).map(|piece| from + (to - from) * piece as f32 / PIECES as f32);
        let (first, last) = (shares().find(|share| is_inside(*share))?, shares().rfind(|share| is_inside(*share))?);
        // Bisection between a share outside and one inside.
        let edge = |outside: f32, inside: f32| {
            (0..12).fold([outside, inside], |[outside, inside], _| {
                let middle = f32::midpoint(outside, inside);
                if is_inside(middle) { [outside, middle] } else { [middle, inside] }
            })[1]
        };
        let step = (to - from) / PIECES as f32;
        let part = [
            if first > from { edge((first - step).max(from), first) } else { first },
            if last < to { edge((last + step).min(to), last) } else { last },
        ];
        (part[0] < part[1]).then_some(part)
    }

    /// Returns `pixel`, moved into the image if it is outside.
    pub fn clamp_to_image(&self, pixel: Vec2) -> Vec2 {
        // The right and lower edges are not part of the image.
        pixel.clamp(Vec2::ZERO, self.intrinsics.size - Vec2::splat(1e-3))
    }

    /// The distance of a pixel from the image's centre, squared, pixels².
    pub fn offset_from_centre_squared(&self, pixel: Vec2) -> f32 {
        pixel.distance_squared(self.intrinsics.centre)
    }

    #[inline]
    fn pixel_of(&self, in_camera: Vec3) -> Vec2 {
        let CameraIntrinsics { focal, centre, distortion, .. } = self.intrinsics;
        if distortion.is_none() {
            return centre + in_camera.truncate() * (focal / in_camera.z);
        }
        self.intrinsics.pixel(in_camera.truncate() / in_camera.z)
    }
}

//! The intrinsics of a camera: focal lengths, principal point, size of the image, and distortion.

use bevy::math::ops;
use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::distortion::Distortion;

/// The greatest size of the image of a [drawn](CameraIntrinsics::drawn) pinhole, as a multiple of the camera's image size.
const WIDEST: f32 = 2.0;
/// The same for a fisheye lens, whose pinhole has a shorter focal length if that is not enough.
const WIDEST_FISHEYE: f32 = 3.0;
/// Number of points per side of an image by which its outline is approximated.
const OUTLINE_STEPS: u32 = 8;

/// The intrinsics of a camera: without distortion those of a pinhole.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct CameraIntrinsics {
    /// Focal lengths along u and v, pixels.
    pub focal: Vec2,
    /// The principal point [u, v], pixels.
    pub centre: Vec2,
    /// Width and height of the image, pixels.
    pub size: Vec2,
    /// The distortion of the lens.
    pub distortion: Distortion,
    /// Half the size of the smallest image of a pinhole camera, centred at the principal point, that contains everything in this camera's
    /// image, pixels.
    half_size: Vec2,
}

/// A camera with square pixels, without distortion, and with the principal point in the middle of its image: what renderers draw.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Pinhole {
    /// Focal length, pixels.
    pub focal_length: f32,
    /// The principal point [u, v], pixels.
    pub centre: Vec2,
    /// Width and height of the image, pixels.
    pub size: Vec2,
}

impl CameraIntrinsics {
    /// The pinhole with an image of `size`, pixels, and `diagonal_fov` along its diagonal, radians.
    pub fn new(size: Vec2, diagonal_fov: f32) -> Self {
        Self::pinhole(size, size.length() / 2.0 / ops::tan(diagonal_fov / 2.0))
    }

    /// The camera with an image of `size`, pixels, and this lens. A fisheye lens has `diagonal_fov` along the diagonal of the image, radians;
    /// other distortions widen or narrow that of a pinhole.
    pub fn with_lens(size: Vec2, diagonal_fov: f32, distortion: Distortion) -> Self {
        if !distortion.is_fisheye() {
            return Self::new(size, diagonal_fov).with_distortion(distortion);
        }
        let corner = distortion.distorted(Vec2::X * ops::tan(diagonal_fov / 2.0)).x;
        let focal_length = size.length() / 2.0 / corner;
        Self::calibrated(size, Vec2::splat(focal_length), size / 2.0, distortion)
    }

    /// The pinhole with an image of `size` and this focal length, pixels.
    pub fn pinhole(size: Vec2, focal_length: f32) -> Self {
        let centre = size / 2.0;
        let focal = Vec2::splat(focal_length);
        Self { focal, centre, size, distortion: Distortion::NONE, half_size: centre }
    }

    /// The camera with these focal lengths and this principal point, pixels.
    pub fn calibrated(size: Vec2, focal: Vec2, centre: Vec2, distortion: Distortion) -> Self {
        let mut intrinsics = Self { focal, centre, size, distortion, half_size: centre.max(size - centre) };
        if !distortion.is_none() {
            let outline = intrinsics.outline();
            intrinsics.half_size =
                outline.map(|pixel| (focal * intrinsics.slope(pixel)).abs()).fold(Vec2::ZERO, Vec2::max);
        }
        intrinsics
    }

    /// This camera with the distortion of a lens.
    #[must_use]
    pub fn with_distortion(self, distortion: Distortion) -> Self {
        if distortion.is_none() { self } else { Self::calibrated(self.size, self.focal, self.centre, distortion) }
    }

    /// Whether the camera is a pinhole with square pixels and the principal point in the middle.
    pub fn is_pinhole(&self) -> bool {
        self.distortion.is_none() && self.focal.x == self.focal.y && self.centre == self.size / 2.0
    }

    /// Half the size of the smallest image of a pinhole camera, centred at the principal point, that contains everything in this camera's
    /// image, pixels.
    #[inline]
    pub fn half_size(&self) -> Vec2 {
        self.half_size
    }

    /// The greatest slopes from the axis in the image, to the side and up or down.
    pub fn half_slopes(&self) -> Vec2 {
        self.half_size / self.focal
    }

    /// The pixel of a ray with this slope: to the right and down, per unit ahead.
    #[inline]
    pub fn pixel(&self, slope: Vec2) -> Vec2 {
        self.centre + self.focal * self.distortion.distorted(slope)
    }

    /// The slope of the ray of a pixel.
    #[inline]
    pub fn slope(&self, pixel: Vec2) -> Vec2 {
        self.distortion.undistorted((pixel - self.centre) / self.focal)
    }

    /// The pinhole camera to be drawn, whose image contains everything in this camera's image, so that the latter can be made from the
    /// former.
    pub fn drawn(&self) -> Pinhole {
        let (focal_length, size) = (self.focal.max_element(), self.size);
        if self.is_pinhole() {
            return Pinhole { focal_length, centre: self.centre, size };
        }
        let widest = if self.distortion.is_fisheye() { WIDEST_FISHEYE } else { WIDEST };
        let focal_length = if self.distortion.is_fisheye() {
            focal_length.min((widest * size / 2.0 / self.half_slopes()).min_element())
        } else {
            focal_length
        };
        let beside = (self.half_slopes() * focal_length).min(widest * size / 2.0) - size / 2.0;
        let beside = beside.ceil().max(Vec2::ZERO);
        Pinhole { focal_length, centre: size / 2.0 + beside, size: size + 2.0 * beside }
    }

    /// The position of a pixel in the image of the [drawn](Self::drawn) camera.
    pub fn in_drawn(&self, pixel: Vec2) -> Vec2 {
        if self.is_pinhole() {
            return pixel;
        }
        let Pinhole { focal_length, centre, .. } = self.drawn();
        centre + focal_length * self.slope(pixel)
    }

    /// Pixels along the edges of the image: its corners and, if the edges are curved, points between them.
    pub fn outline(&self) -> impl Iterator<Item = Vec2> + use<> {
        let size = self.size;
        let steps = if self.distortion.is_none() { 1 } else { OUTLINE_STEPS };
        let corners = [Vec2::ZERO, size.with_y(0.0), size, size.with_x(0.0)];
        (0..4).flat_map(move |side| {
            (0..steps).map(move |step| corners[side].lerp(corners[(side + 1) % 4], step as f32 / steps as f32))
        })
    }
}

/// A calibration of a camera, in the conventions of OpenCV and ROS: the middle of the top-left pixel is at (0, 0).
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraCalibration {
    /// Focal length along the width of the image, pixels.
    #[schemars(range(min = 1.0, max = 100_000.0), extend("unit" = "pixels"))]
    pub fx: f32,
    /// Focal length along the height of the image, pixels.
    #[schemars(range(min = 1.0, max = 100_000.0), extend("unit" = "pixels"))]
    pub fy: f32,
    /// The principal point along the width, pixels.
    #[schemars(range(min = -4096.0, max = 8192.0), extend("unit" = "pixels"))]
    pub cx: f32,
    /// The principal point along the height, pixels.
    #[schemars(range(min = -4096.0, max = 8192.0), extend("unit" = "pixels"))]
    pub cy: f32,
    /// The distortion of the lens.
    #[serde(default)]
    pub distortion: Distortion,
    /// Width and height of the images with which the camera was calibrated, pixels; by default those of the camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(range(min = 1, max = 4096)), extend("unit" = "pixels"))]
    pub size: Option<[u32; 2]>,
}

impl CameraCalibration {
    /// The intrinsics for images of `size`, pixels, scaled if the camera was calibrated with images of another size. `usual` is that size
    /// if the calibration does not state it.
    pub fn intrinsics(&self, size: [u32; 2], usual: [u32; 2]) -> CameraIntrinsics {
        let in_floats = |[width, height]: [u32; 2]| Vec2::new(width as f32, height as f32);
        let size = in_floats(size);
        let scale = size / in_floats(self.size.unwrap_or(usual));
        let focal = Vec2::new(self.fx, self.fy) * scale;
        // Here, pixels are counted from the outer corner of the image.
        let centre = (Vec2::new(self.cx, self.cy) + 0.5) * scale;
        CameraIntrinsics::calibrated(size, focal, centre, self.distortion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const CALIBRATION: CameraCalibration =
        CameraCalibration { fx: 600.0, fy: 610.0, cx: 330.5, cy: 246.5, distortion: Distortion::NONE, size: None };

    #[test]
    fn pixels_are_counted_from_the_outer_corner() {
        let intrinsics = CALIBRATION.intrinsics([640, 480], [640, 480]);
        // A slope of 0.1 to the right is 60 pixels; the middle of a pixel is half a pixel from its corner.
        assert_abs_diff_eq!(intrinsics.pixel(Vec2::new(0.1, -0.1)), Vec2::new(391.0, 186.0), epsilon = 1e-3);
        assert_abs_diff_eq!(intrinsics.slope(Vec2::new(391.0, 186.0)), Vec2::new(0.1, -0.1), epsilon = 1e-6);
        assert!(!intrinsics.is_pinhole() && CameraIntrinsics::new(Vec2::new(640.0, 480.0), 1.0).is_pinhole());
    }

    #[test]
    fn smaller_images_have_scaled_intrinsics() {
        let calibration = CameraCalibration { size: Some([1280, 960]), ..CALIBRATION };
        let half = calibration.intrinsics([640, 480], [9, 9]);
        assert_eq!((half.focal, half.centre), (Vec2::new(300.0, 305.0), Vec2::new(165.5, 123.5)));
    }

    #[test]
    fn a_pinhole_of_its_half_size_has_all_that_it_shows() {
        let size = Vec2::new(640.0, 480.0);
        for k1 in [-0.3, 0.0, 0.2] {
            let lens = Distortion::new([k1, 0.0, 0.0], [0.001, 0.0]);
            let camera = CameraIntrinsics::calibrated(size, Vec2::new(600.0, 610.0), Vec2::new(330.0, 250.0), lens);
            let reach = camera.half_size() / camera.focal + 1e-3;
            for (x, y) in (0..=64).flat_map(|x| (0..=48).map(move |y| (10.0 * x as f32, 10.0 * y as f32))) {
                let slope = camera.slope(Vec2::new(x, y)).abs();
                assert!(slope.cmple(reach).all(), "{k1}: {slope} {reach}");
            }
        }
    }
}

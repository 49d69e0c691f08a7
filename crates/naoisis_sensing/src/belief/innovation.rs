//! Measurements and their innovations, for the pose and for the error of the cameras.

use bevy::prelude::*;

use super::covariance::inverse;

/// A measurement compared with its expectation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Measured {
    /// Measured minus expected, m.
    pub(super) difference: Vec2,
    /// H: the derivatives of the expectation with respect to x, y and heading of the pose, two rows.
    pub(super) rows: [Vec3; 2],
    /// P Hᵀ, column by column.
    pub(super) cross: [Vec3; 2],
    /// Covariance of the difference, m².
    pub(super) spread: Mat2,
    /// The covariance of the cameras' error with the measurement, column by column, if that error is estimated.
    pub(super) camera_cross: Option<[Vec4; 2]>,
}

impl Measured {
    /// The squared Mahalanobis distance between measurement and expectation.
    pub(super) fn distance_squared(&self) -> f32 {
        self.difference.dot(inverse(self.spread) * self.difference)
    }

    /// The innovation for the pose, and for the cameras.
    pub(super) fn innovation(&self) -> Innovation {
        let Measured { difference, cross, spread, .. } = *self;
        let information = inverse(spread);
        let [x, y] = [information.x_axis, information.y_axis];
        let camera = self.camera_cross.map(|cross| CameraShare {
            gain: [cross[0] * x.x + cross[1] * x.y, cross[0] * y.x + cross[1] * y.y],
            cross,
        });
        Innovation {
            difference,
            gain: [cross[0] * x.x + cross[1] * x.y, cross[0] * y.x + cross[1] * y.y],
            cross,
            camera,
            distance_squared: difference.dot(information * difference),
        }
    }
}

/// The part of an innovation for the error of the cameras.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct CameraShare {
    /// The gain's columns, radians per metre.
    pub(super) gain: [Vec4; 2],
    /// The covariance of the error with the measurement, column by column.
    pub(super) cross: [Vec4; 2],
}

/// The innovation of a sighting of a landmark.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Innovation {
    /// Measured minus expected position, m, robot frame.
    pub(super) difference: Vec2,
    /// The columns of the gain: the change for a metre of difference along x and along y.
    pub(super) gain: [Vec3; 2],
    /// P Hᵀ, column by column.
    pub(super) cross: [Vec3; 2],
    /// The part for the error of the cameras, if it is estimated.
    pub(super) camera: Option<CameraShare>,
    /// The squared Mahalanobis distance between measurement and expectation.
    pub distance_squared: f32,
}

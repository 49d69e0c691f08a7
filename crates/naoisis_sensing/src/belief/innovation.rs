//! What a measurement says about a pose, and about the cameras that made it.

use bevy::prelude::*;

use super::covariance::inverse;

/// A measurement beside what was expected of it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Measured {
    /// Measured minus expected, m.
    pub(super) difference: Vec2,
    /// H: what x, y and heading of the pose change of what is expected, a row for each of the two.
    pub(super) rows: [Vec3; 2],
    /// P Hᵀ, column by column.
    pub(super) cross: [Vec3; 2],
    /// Covariance of the difference, m².
    pub(super) spread: Mat2,
    /// The covariance of the cameras' error with what is measured, column by column, if that error is estimated, too.
    pub(super) camera_cross: Option<[Vec4; 2]>,
}

impl Measured {
    /// The squared Mahalanobis distance between measurement and expectation.
    pub(super) fn distance_squared(&self) -> f32 {
        self.difference.dot(inverse(self.spread) * self.difference)
    }

    /// What it says about the pose, and about the cameras.
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

/// What a measurement says about the error of the cameras.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct CameraShare {
    /// The gain's columns, radians per metre.
    pub(super) gain: [Vec4; 2],
    /// The covariance of the error with what is measured, column by column.
    pub(super) cross: [Vec4; 2],
}

/// What seeing a landmark says about a pose.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Innovation {
    /// Measured minus expected place, m, robot frame.
    pub(super) difference: Vec2,
    /// The gain's columns: what a metre of difference along x and along y changes.
    pub(super) gain: [Vec3; 2],
    /// P Hᵀ, column by column.
    pub(super) cross: [Vec3; 2],
    /// What it says about the error of the cameras, if that is estimated, too.
    pub(super) camera: Option<CameraShare>,
    /// The squared Mahalanobis distance between measurement and expectation.
    pub distance_squared: f32,
}

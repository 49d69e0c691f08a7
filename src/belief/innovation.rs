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
}

impl Measured {
    /// What it says about the pose alone.
    pub(super) fn innovation(&self) -> Innovation {
        Innovation::new(self.difference, self.cross, self.spread)
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
    /// The inverse of the covariance of the difference, m⁻².
    information: Mat2,
    /// What it says about the error of the cameras, if that is estimated, too.
    pub(super) camera: Option<CameraShare>,
    /// The squared Mahalanobis distance between measurement and expectation.
    pub distance_squared: f32,
}

impl Innovation {
    /// Of a measurement with this difference from what was expected, covariance with the pose (column by column), and
    /// covariance.
    pub(super) fn new(difference: Vec2, cross: [Vec3; 2], spread: Mat2) -> Self {
        let inverse = inverse(spread);
        let gain = [
            cross[0] * inverse.x_axis.x + cross[1] * inverse.x_axis.y,
            cross[0] * inverse.y_axis.x + cross[1] * inverse.y_axis.y,
        ];
        let distance_squared = difference.dot(inverse * difference);
        Self { difference, gain, cross, information: inverse, camera: None, distance_squared }
    }

    /// The same of a measurement that has this covariance with the error of the cameras, column by column.
    pub(super) fn with_camera(self, cross: [Vec4; 2]) -> Self {
        let information = self.information;
        let gain = [
            cross[0] * information.x_axis.x + cross[1] * information.x_axis.y,
            cross[0] * information.y_axis.x + cross[1] * information.y_axis.y,
        ];
        Self { camera: Some(CameraShare { gain, cross }), ..self }
    }
}

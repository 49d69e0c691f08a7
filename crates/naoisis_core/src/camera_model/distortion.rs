//! The distortion of lenses.

use bevy::prelude::*;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The least slope of the polynomial from undistorted to distorted slopes. Where it rises less, it is continued as a straight line: it was
/// fitted to the image, and far outside might lead back into it.
const LEAST_RISE: f32 = 0.1;
/// The greatest slope of a ray from the axis that a camera may have: that of 85°.
const STEEPEST: f32 = 11.4;
/// The greatest coefficient.
const GREATEST: f32 = 20.0;

/// The distortion of a lens, radial and tangential, in the model of OpenCV and ROS (`plumb_bob`).
///
/// A point at the slope (x, y) from the axis of a pinhole camera, r² = x² + y², appears at the slope
/// x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²), y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y. A negative k1 is
/// a barrel distortion, with which straight lines bend outwards. Files have the numbers in OpenCV's order: `[k1, k2]`,
/// `[k1, k2, p1, p2]` or `[k1, k2, p1, p2, k3]`.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(try_from = "Vec<f32>", into = "Vec<f32>")]
pub struct Distortion {
    /// k1, k2 and k3.
    radial: [f32; 3],
    /// p1 and p2.
    tangential: [f32; 2],
    /// The slope up to which the polynomial holds, and the radially distorted slope there.
    limit: [f32; 2],
    /// Whether all coefficients are 0. Stored, as it is needed for every projected point.
    is_none: bool,
}

impl Distortion {
    /// The lens of a pinhole camera.
    pub const NONE: Distortion =
        Distortion { radial: [0.0; 3], tangential: [0.0; 2], limit: [f32::INFINITY; 2], is_none: true };

    /// The distortion with these coefficients: radial k1, k2 and k3, tangential p1 and p2.
    pub fn new(radial: [f32; 3], tangential: [f32; 2]) -> Self {
        let is_none = radial == [0.0; 3] && tangential == [0.0; 2];
        let mut distortion = Self { radial, tangential, is_none, ..Self::NONE };
        if radial == [0.0; 3] {
            return distortion;
        }
        // The first slope, in steps of 0.01, at which the polynomial rises less than `LEAST_RISE`.
        let steps = (1..=(100.0 * STEEPEST) as u32).map(|step| step as f32 / 100.0);
        if let Some(limit) = steps.into_iter().find(|slope| distortion.rise(*slope) < LEAST_RISE) {
            let limit = limit - 0.01;
            distortion.limit = [limit, distortion.polynomial(limit)];
        }
        distortion
    }

    /// Whether there is no distortion, as in a pinhole camera.
    pub fn is_none(&self) -> bool {
        self.is_none
    }

    /// k1, k2, p1, p2 and k3.
    pub fn coefficients(&self) -> [f32; 5] {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        [k1, k2, p1, p2, k3]
    }

    /// The slope up to which the polynomial is used; beyond, it is continued as a straight line.
    pub fn holds_up_to(&self) -> f32 {
        self.limit[0]
    }

    /// Returns the distorted slope of a point that a pinhole camera shows at `slope`.
    pub fn distorted(&self, slope: Vec2) -> Vec2 {
        let away = slope.length();
        if away <= self.limit[0] {
            return slope * self.factor(away * away) + self.aside(slope);
        }
        slope * (self.radially_distorted(away) / away) + self.aside(slope * (self.limit[0] / away))
    }

    /// Returns the slope in a pinhole camera of a point that appears at `slope`: the inverse of [`distorted`](Self::distorted).
    pub fn undistorted(&self, slope: Vec2) -> Vec2 {
        if self.is_none() {
            return slope;
        }
        let mut undistorted = self.radially_undistorted(slope);
        if self.tangential != [0.0; 2] {
            // The tangential part is small and hardly changes with the slope.
            for _ in 0..8 {
                let away = undistorted.length();
                let within = if away > self.limit[0] { undistorted * (self.limit[0] / away) } else { undistorted };
                undistorted = self.radially_undistorted(slope - self.aside(within));
            }
        }
        undistorted
    }

    fn factor(&self, squared: f32) -> f32 {
        let [k1, k2, k3] = self.radial;
        1.0 + squared * (k1 + squared * (k2 + squared * k3))
    }

    fn polynomial(&self, slope: f32) -> f32 {
        slope * self.factor(slope * slope)
    }

    /// The derivative of the polynomial.
    fn rise(&self, slope: f32) -> f32 {
        let [k1, k2, k3] = self.radial;
        let squared = slope * slope;
        1.0 + squared * (3.0 * k1 + squared * (5.0 * k2 + squared * 7.0 * k3))
    }

    fn radially_distorted(&self, slope: f32) -> f32 {
        let [limit, at_limit] = self.limit;
        if slope <= limit { self.polynomial(slope) } else { at_limit + LEAST_RISE * (slope - limit) }
    }

    fn radially_undistorted(&self, slope: Vec2) -> Vec2 {
        let away = slope.length();
        if away < 1e-6 || self.radial == [0.0; 3] {
            return slope;
        }
        let [limit, at_limit] = self.limit;
        if away >= at_limit {
            return slope * ((limit + (away - at_limit) / LEAST_RISE) / away);
        }
        // Newton's method within bounds, as the polynomial rises up to the limit.
        let (mut least, mut most) = (0.0, limit.min(away / LEAST_RISE));
        let mut undistorted = away.min(most);
        for _ in 0..20 {
            let off = self.polynomial(undistorted) - away;
            if off.abs() <= 1e-7 * away {
                break;
            }
            if off > 0.0 {
                most = undistorted;
            } else {
                least = undistorted;
            }
            let next = undistorted - off / self.rise(undistorted).max(LEAST_RISE);
            undistorted = if next > least && next < most { next } else { f32::midpoint(least, most) };
        }
        slope * (undistorted / away)
    }

    /// The tangential part.
    fn aside(&self, slope: Vec2) -> Vec2 {
        let [p1, p2] = self.tangential;
        let (Vec2 { x, y }, squared) = (slope, slope.length_squared());
        Vec2::new(2.0 * p1 * x * y + p2 * (squared + 2.0 * x * x), p1 * (squared + 2.0 * y * y) + 2.0 * p2 * x * y)
    }
}

impl Default for Distortion {
    fn default() -> Self {
        Self::NONE
    }
}

impl TryFrom<Vec<f32>> for Distortion {
    type Error = String;

    fn try_from(numbers: Vec<f32>) -> Result<Self, String> {
        if let Some(number) = numbers.iter().find(|number| number.is_nan() || number.abs() > GREATEST) {
            return Err(format!("a distortion of {number}; expected numbers from -{GREATEST} to {GREATEST}"));
        }
        match *numbers.as_slice() {
            [] => Ok(Self::NONE),
            [k1, k2] => Ok(Self::new([k1, k2, 0.0], [0.0; 2])),
            [k1, k2, p1, p2] => Ok(Self::new([k1, k2, 0.0], [p1, p2])),
            [k1, k2, p1, p2, k3] => Ok(Self::new([k1, k2, k3], [p1, p2])),
            _ => Err(format!(
                "{} numbers of distortion; expected [k1, k2], [k1, k2, p1, p2] or [k1, k2, p1, p2, k3]",
                numbers.len()
            )),
        }
    }
}

impl From<Distortion> for Vec<f32> {
    fn from(distortion: Distortion) -> Self {
        let all = distortion.coefficients();
        let count = if distortion.tangential == [0.0; 2] && distortion.radial[2] == 0.0 {
            2
        } else if distortion.radial[2] == 0.0 {
            4
        } else {
            5
        };
        all[..count].to_vec()
    }
}

impl JsonSchema for Distortion {
    fn schema_name() -> Cow<'static, str> {
        "Distortion".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The distortion of a lens in the order of OpenCV: [k1, k2], [k1, k2, p1, p2] or [k1, k2, p1, p2, k3].",
            "type": "array",
            "items": { "type": "number", "minimum": -GREATEST, "maximum": GREATEST },
            "maxItems": 5,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn slopes_are_those_of_opencv() {
        // x (1 + 0.1 r² - 0.2 r⁴) and so on at x = 0.4, y = -0.3, r² = 0.25: the factor is 1.0125;
        // 2 p1 x y + p2 (r² + 2 x²) = -0.00024 + 0.00114; p1 (r² + 2 y²) + 2 p2 x y = 0.00043 - 0.00048.
        let lens = Distortion::new([0.1, -0.2, 0.0], [0.001, 0.002]);
        assert_abs_diff_eq!(lens.distorted(Vec2::new(0.4, -0.3)), Vec2::new(0.4059, -0.3038), epsilon = 1e-6);
        assert_eq!(Distortion::NONE.distorted(Vec2::new(3.0, 2.0)), Vec2::new(3.0, 2.0));
    }

    #[test]
    fn the_inverse_leads_back() {
        let lenses = [
            Distortion::new([0.1, -0.2, 0.0], [0.001, 0.002]),
            Distortion::new([-0.35, 0.12, -0.02], [0.0, -0.003]),
            Distortion::new([-0.3, 0.05, 0.0], [0.0; 2]),
            Distortion::new([0.2, 0.0, 0.0], [0.0; 2]),
            Distortion::new([0.0; 3], [0.01, -0.01]),
        ];
        for lens in lenses {
            for (x, y) in (-12..=12).flat_map(|x| (-12..=12).map(move |y| (0.1 * x as f32, 0.1 * y as f32))) {
                let slope = Vec2::new(x, y);
                let again = lens.undistorted(lens.distorted(slope));
                assert!(again.distance(slope) < 2e-4 * (1.0 + slope.length()), "{lens:?}: {slope} {again}");
            }
        }
    }

    #[test]
    fn what_is_far_outside_does_not_come_back_into_the_image() {
        // The bare polynomial of a barrel is 0 at a slope of 1.8 again.
        let barrel = Distortion::new([-0.3, 0.0, 0.0], [0.0; 2]);
        assert_abs_diff_eq!(barrel.holds_up_to(), 1.0, epsilon = 0.02);
        let mut before = 0.0;
        for step in 1..400 {
            let now = barrel.distorted(Vec2::X * 0.05 * step as f32).x;
            assert!(now > before, "{step}");
            before = now;
        }
    }

    #[test]
    fn files_have_them_in_the_order_of_opencv() {
        let read = |text: &str| serde_json::from_str::<Distortion>(text);
        for (text, coefficients) in [
            ("[-0.3,0.05]", [-0.3, 0.05, 0.0, 0.0, 0.0]),
            ("[0.1,-0.2,0.001,0.002]", [0.1, -0.2, 0.001, 0.002, 0.0]),
            ("[0.1,-0.2,0.001,0.002,0.5]", [0.1, -0.2, 0.001, 0.002, 0.5]),
        ] {
            let distortion = read(text).unwrap();
            assert_eq!(distortion.coefficients(), coefficients);
            assert_eq!(serde_json::to_string(&distortion).unwrap(), text);
        }
        assert_eq!(read("[0.0,0.0]").unwrap(), Distortion::NONE);
        assert!(read("[1.0]").unwrap_err().to_string().contains("expected [k1, k2]"));
        assert!(read("[99.0,0.0]").unwrap_err().to_string().contains("from -20 to 20"));
    }
}

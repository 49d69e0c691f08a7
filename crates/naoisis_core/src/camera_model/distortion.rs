//! The distortion of lenses.

use bevy::math::ops;
use bevy::prelude::*;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The least slope of the polynomial from undistorted to distorted slopes. Where it rises less, it is continued as a straight line: it was
/// fitted to the image, and far outside might lead back into it.
const LEAST_RISE: f32 = 0.1;
/// The greatest slope of a ray from the axis that a camera may have: that of 85°.
const STEEPEST: f32 = 11.4;
/// The greatest angle of a ray from the axis for which a fisheye lens is computed, radians: 89.9°.
const WIDEST: f32 = 1.569;
/// The greatest coefficient.
const GREATEST: f32 = 20.0;

/// The distortion of a lens, in one of two models of OpenCV and ROS.
///
/// **Radial and tangential** (`plumb_bob`): a point at the slope (x, y) from the axis of a pinhole camera, r² = x² + y², appears at the slope
/// x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²), y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y. A negative k1 is
/// a barrel distortion, with which straight lines bend outwards. Files have the numbers in OpenCV's order: `[k1, k2]`,
/// `[k1, k2, p1, p2]` or `[k1, k2, p1, p2, k3]`.
///
/// **Fisheye** (`equidistant`): a point at the angle θ from the axis appears at the slope θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸) in the same
/// direction. Files have an object: `{ "fisheye": [k1, k2, k3, k4] }`, with as many coefficients as there are. Images reach up to 85° from
/// the axis.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(try_from = "Coefficients", into = "Coefficients")]
pub struct Distortion {
    /// The coefficients of the powers 2, 4, 6 and 8.
    radial: [f32; 4],
    /// p1 and p2.
    tangential: [f32; 2],
    /// Whether the polynomial is one of angles and not of slopes.
    is_fisheye: bool,
    /// The slope or angle up to which the polynomial holds, and the radially distorted slope there.
    limit: [f32; 2],
    /// Whether there is no distortion. Stored, as it is needed for every projected point.
    is_none: bool,
}

/// The form of a distortion in files.
#[derive(Serialize, Deserialize)]
#[serde(untagged, expecting = "a distortion is a list of numbers, or an object with `fisheye` and such a list")]
enum Coefficients {
    PlumbBob(Vec<f32>),
    Fisheye(Fisheye),
}

/// The coefficients of a fisheye lens.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Fisheye {
    fisheye: Vec<f32>,
}

impl Distortion {
    /// The lens of a pinhole camera.
    pub const NONE: Distortion = Distortion {
        radial: [0.0; 4],
        tangential: [0.0; 2],
        is_fisheye: false,
        limit: [f32::INFINITY; 2],
        is_none: true,
    };

    /// The distortion with these coefficients: radial k1, k2 and k3, tangential p1 and p2.
    pub fn new([k1, k2, k3]: [f32; 3], tangential: [f32; 2]) -> Self {
        let radial = [k1, k2, k3, 0.0];
        let is_none = radial == [0.0; 4] && tangential == [0.0; 2];
        let distortion = Self { radial, tangential, is_none, ..Self::NONE };
        // In steps of 0.01.
        if radial == [0.0; 4] { distortion } else { distortion.limited(0.01, (100.0 * STEEPEST) as u32) }
    }

    /// The fisheye lens with the coefficients k1 to k4.
    pub fn fisheye(radial: [f32; 4]) -> Self {
        const STEP: f32 = 0.001;
        let lens = Self { radial, is_fisheye: true, is_none: false, ..Self::NONE };
        let lens = lens.limited(STEP, (WIDEST / STEP) as u32);
        if lens.limit[0] < WIDEST { lens } else { Self { limit: [WIDEST, lens.polynomial(WIDEST)], ..lens } }
    }

    /// Limits the polynomial to where it rises enough, found in steps of this size.
    fn limited(self, step: f32, count: u32) -> Self {
        let mut steps = (1..=count).map(|index| index as f32 * step);
        let Some(limit) = steps.find(|place| self.rise(*place) < LEAST_RISE) else { return self };
        let limit = limit - step;
        Self { limit: [limit, self.polynomial(limit)], ..self }
    }

    /// Whether there is no distortion, as in a pinhole camera.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.is_none
    }

    /// Whether this is a fisheye lens.
    pub fn is_fisheye(&self) -> bool {
        self.is_fisheye
    }

    /// The name of the model in ROS: `plumb_bob` or `equidistant`.
    pub fn model(&self) -> &'static str {
        if self.is_fisheye { "equidistant" } else { "plumb_bob" }
    }

    /// The coefficients in the order of OpenCV and ROS: k1, k2, p1, p2 and k3, or k1 to k4 of a fisheye lens.
    pub fn coefficients(&self) -> Vec<f32> {
        let ([k1, k2, k3, _], [p1, p2]) = (self.radial, self.tangential);
        if self.is_fisheye { self.radial.to_vec() } else { vec![k1, k2, p1, p2, k3] }
    }

    /// The slope up to which the polynomial is used; beyond, it is continued as a straight line.
    pub fn holds_up_to(&self) -> f32 {
        if self.is_fisheye { ops::tan(self.limit[0]).min(1.01 * STEEPEST) } else { self.limit[0] }
    }

    /// Returns the distorted slope of a point that a pinhole camera shows at `slope`.
    pub fn distorted(&self, slope: Vec2) -> Vec2 {
        let away = slope.length();
        if self.is_fisheye {
            // Near the axis angle and slope are equal.
            return if away < 1e-6 { slope } else { slope * (self.radially_distorted(ops::atan(away)) / away) };
        }
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
        if self.is_fisheye {
            let away = slope.length();
            let angle = self.radially_undistorted(away).min(WIDEST);
            return if away < 1e-6 { slope } else { slope * (ops::tan(angle) / away) };
        }
        let mut undistorted = self.plane_undistorted(slope);
        if self.tangential != [0.0; 2] {
            // The tangential part is small and hardly changes with the slope.
            for _ in 0..8 {
                let away = undistorted.length();
                let within = if away > self.limit[0] { undistorted * (self.limit[0] / away) } else { undistorted };
                undistorted = self.plane_undistorted(slope - self.aside(within));
            }
        }
        undistorted
    }

    fn factor(&self, squared: f32) -> f32 {
        let [k1, k2, k3, k4] = self.radial;
        if k4 == 0.0 {
            return 1.0 + squared * (k1 + squared * (k2 + squared * k3));
        }
        1.0 + squared * (k1 + squared * (k2 + squared * (k3 + squared * k4)))
    }

    fn polynomial(&self, slope: f32) -> f32 {
        slope * self.factor(slope * slope)
    }

    /// The derivative of the polynomial.
    fn rise(&self, slope: f32) -> f32 {
        let [k1, k2, k3, k4] = self.radial;
        let squared = slope * slope;
        if k4 == 0.0 {
            return 1.0 + squared * (3.0 * k1 + squared * (5.0 * k2 + squared * 7.0 * k3));
        }
        1.0 + squared * (3.0 * k1 + squared * (5.0 * k2 + squared * (7.0 * k3 + squared * 9.0 * k4)))
    }

    fn radially_distorted(&self, slope: f32) -> f32 {
        let [limit, at_limit] = self.limit;
        if slope <= limit { self.polynomial(slope) } else { at_limit + LEAST_RISE * (slope - limit) }
    }

    /// The slope in a pinhole camera of a radially distorted slope.
    fn plane_undistorted(&self, slope: Vec2) -> Vec2 {
        let away = slope.length();
        if away < 1e-6 || self.radial == [0.0; 4] {
            return slope;
        }
        slope * (self.radially_undistorted(away) / away)
    }

    /// The slope or angle that is distorted to `away`.
    fn radially_undistorted(&self, away: f32) -> f32 {
        let [limit, at_limit] = self.limit;
        if away >= at_limit {
            return limit + (away - at_limit) / LEAST_RISE;
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
        undistorted
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

impl TryFrom<Coefficients> for Distortion {
    type Error = String;

    fn try_from(coefficients: Coefficients) -> Result<Self, String> {
        let (Coefficients::PlumbBob(numbers) | Coefficients::Fisheye(Fisheye { fisheye: numbers })) = &coefficients;
        if let Some(number) = numbers.iter().find(|number| number.is_nan() || number.abs() > GREATEST) {
            return Err(format!("a distortion of {number}; expected numbers from -{GREATEST} to {GREATEST}"));
        }
        let count = numbers.len();
        match (&coefficients, numbers.as_slice()) {
            (Coefficients::PlumbBob(_), []) => Ok(Self::NONE),
            (Coefficients::PlumbBob(_), &[k1, k2]) => Ok(Self::new([k1, k2, 0.0], [0.0; 2])),
            (Coefficients::PlumbBob(_), &[k1, k2, p1, p2]) => Ok(Self::new([k1, k2, 0.0], [p1, p2])),
            (Coefficients::PlumbBob(_), &[k1, k2, p1, p2, k3]) => Ok(Self::new([k1, k2, k3], [p1, p2])),
            (Coefficients::PlumbBob(_), _) => Err(format!(
                "{count} numbers of distortion; expected [k1, k2], [k1, k2, p1, p2] or [k1, k2, p1, p2, k3]"
            )),
            (Coefficients::Fisheye(_), _) if count > 4 => {
                Err(format!("{count} numbers of a fisheye lens; expected at most four, [k1, k2, k3, k4]"))
            }
            (Coefficients::Fisheye(_), _) => {
                let mut radial = [0.0; 4];
                radial[..count].copy_from_slice(numbers);
                Ok(Self::fisheye(radial))
            }
        }
    }
}

impl From<Distortion> for Coefficients {
    fn from(distortion: Distortion) -> Self {
        let mut all = distortion.coefficients();
        if distortion.is_fisheye {
            return Coefficients::Fisheye(Fisheye { fisheye: all });
        }
        let count = if distortion.tangential == [0.0; 2] && distortion.radial[2] == 0.0 {
            2
        } else if distortion.radial[2] == 0.0 {
            4
        } else {
            5
        };
        all.truncate(count);
        Coefficients::PlumbBob(all)
    }
}

impl JsonSchema for Distortion {
    fn schema_name() -> Cow<'static, str> {
        "Distortion".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let numbers = |most: u32| {
            json_schema!({
                "type": "array",
                "items": { "type": "number", "minimum": -GREATEST, "maximum": GREATEST },
                "maxItems": most,
            })
        };
        json_schema!({
            "description": "The distortion of a lens in the order of OpenCV: [k1, k2], [k1, k2, p1, p2] or [k1, k2, p1, p2, k3]; or a fisheye lens, { \"fisheye\": [k1, k2, k3, k4] }.",
            "anyOf": [
                numbers(5),
                { "type": "object", "properties": { "fisheye": numbers(4) }, "required": ["fisheye"], "additionalProperties": false },
            ],
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
            Distortion::fisheye([0.0; 4]),
            Distortion::fisheye([-0.03, 0.01, -0.005, 0.001]),
            Distortion::fisheye([-0.2, 0.0, 0.0, 0.0]),
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
    fn a_fisheye_lens_shows_angles() {
        let lens = Distortion::fisheye([0.0; 4]);
        // 60° to the left: tan 60° = 1.732, and pi / 3 in the image.
        let slope = lens.distorted(Vec2::new(-3.0_f32.sqrt(), 0.0));
        assert_abs_diff_eq!(slope, Vec2::new(-core::f32::consts::FRAC_PI_3, 0.0), epsilon = 1e-6);
        // k1 = 0.1 at 0.5 rad: 0.5 (1 + 0.025).
        let lens = Distortion::fisheye([0.1, 0.0, 0.0, 0.0]);
        assert_abs_diff_eq!(lens.distorted(Vec2::Y * ops::tan(0.5)).y, 0.5125, epsilon = 1e-6);
        assert_eq!((lens.model(), lens.holds_up_to()), ("equidistant", 1.01 * STEEPEST));
        // It no longer rises at 1 / sqrt(3 · 0.5) = 0.82 rad, nearly.
        let bent = Distortion::fisheye([-0.5, 0.0, 0.0, 0.0]);
        assert_abs_diff_eq!(bent.holds_up_to(), ops::tan(0.775), epsilon = 0.01);
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
        let fisheye = read(r#"{"fisheye":[-0.03,0.01]}"#).unwrap();
        assert_eq!(fisheye, Distortion::fisheye([-0.03, 0.01, 0.0, 0.0]));
        assert_eq!(serde_json::to_string(&fisheye).unwrap(), r#"{"fisheye":[-0.03,0.01,0.0,0.0]}"#);
        assert_eq!(ron::from_str::<Distortion>("(fisheye: [-0.03, 0.01])").unwrap(), fisheye);
        assert!(read(r#"{"fisheye":[0,0,0,0,0]}"#).unwrap_err().to_string().contains("at most four"));
        assert_eq!(read("[0.0,0.0]").unwrap(), Distortion::NONE);
        assert!(read("[1.0]").unwrap_err().to_string().contains("expected [k1, k2]"));
        assert!(read("[99.0,0.0]").unwrap_err().to_string().contains("from -20 to 20"));
    }
}

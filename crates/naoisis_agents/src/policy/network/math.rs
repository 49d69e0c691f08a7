//! Functions of one number that give the same bits on every platform.
//!
//! Only `+`, `-`, `*`, `/`, comparisons and operations on bits are used, each rounded as IEEE 754 asks, so neither the
//! system's mathematical library nor the processor's instructions change a result. The polynomials are those of the
//! Cephes library for single precision.

/// The number e to the power of `x`: infinite from about 88.73 on, 0 below about -103.97, NaN for NaN.
pub(in crate::policy) fn exp(x: f32) -> f32 {
    /// Adding this number rounds to an integer, which then stands in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let x = x.clamp(-104.0, 89.0);
    let rounded = x * std::f32::consts::LOG2_E + ROUND;
    let power = (rounded.to_bits() as i32).wrapping_sub(ROUND.to_bits() as i32);
    let whole = rounded - ROUND;
    // x = whole * ln 2 + rest, with ln 2 in two parts of which the first is short, so that its product is exact.
    let rest = (x - whole * 0.693_359_4) - whole * -2.121_944_4e-4;
    let mut sum = 1.987_569_1e-4;
    for coefficient in [1.398_2e-3, 8.333_452e-3, 4.166_579_6e-2, 0.166_666_65, 0.5] {
        sum = sum * rest + coefficient;
    }
    let fraction = sum * (rest * rest) + rest + 1.0;
    // Two steps, because neither 2^128 nor 2^-150 is a normal number; only the second one can round.
    let half = power >> 1;
    fraction * power_of_two(half) * power_of_two(power.wrapping_sub(half))
}

/// Two to the power of `exponent`, which lies between -126 and 127.
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits((exponent.wrapping_add(127) << 23) as u32)
}

/// The natural logarithm of `x`: -∞ for 0, NaN for negative numbers and NaN.
pub(super) fn log(x: f32) -> f32 {
    /// A power of two that makes normal numbers of those that are not.
    const SCALE: f32 = 33_554_432.0;
    match x {
        0.0 => f32::NEG_INFINITY,
        x if x < 0.0 => f32::NAN,
        x if x < f32::MIN_POSITIVE => ln(x * SCALE) - 25.0 * core::f32::consts::LN_2,
        x => ln(x),
    }
}

/// The natural logarithm of `x`, a positive normal number, ∞ or NaN.
pub(super) fn ln(x: f32) -> f32 {
    const COEFFICIENTS: [f32; 8] = [
        -0.115_146_1, 0.116_769_984, -0.124_201_41, 0.142_493_23, -0.166_680_58, 0.200_007_14, -0.249_999_94,
        0.333_333_3,
    ];
    if !x.is_finite() {
        return x;
    }
    let bits = x.to_bits();
    let mut power = (bits >> 23) as i32 - 126;
    let mut mantissa = f32::from_bits((bits & 0x007f_ffff) | 0x3f00_0000);
    if mantissa < std::f32::consts::FRAC_1_SQRT_2 {
        power -= 1;
        mantissa += mantissa;
    }
    let rest = mantissa - 1.0;
    let square = rest * rest;
    let mut sum = 7.037_683_6e-2;
    for coefficient in COEFFICIENTS {
        sum = sum * rest + coefficient;
    }
    let power = power as f32;
    let correction = sum * rest * square + power * -2.121_944_4e-4 - 0.5 * square;
    rest + correction + power * 0.693_359_4
}

/// The hyperbolic tangent of `x`, exactly odd, between -1 and 1, NaN for NaN.
pub(super) fn tanh(x: f32) -> f32 {
    let size = x.abs();
    let square = size * size;
    let mut sum = -5.704_988_7e-3;
    for coefficient in [2.063_908_8e-2, -5.373_971_6e-2, 0.133_314_42, -0.333_332_8] {
        sum = sum * square + coefficient;
    }
    let near = sum * square * size + size;
    let far = 1.0 - 2.0 / (exp(size + size) + 1.0);
    let positive = if size < 0.625 { near } else { far };
    positive.copysign(x)
}

/// The inverse hyperbolic sine of `x`, exactly odd. Its absolute error is a few units of the last place of 1 near 0.
pub(super) fn asinh(x: f32) -> f32 {
    let size = x.abs();
    // Below, the cubic term of the series is less than half of the last place.
    if size < 4e-4 {
        return x;
    }
    // From 1e6 on, the 1 is far below the last place of the square, which would overflow later, as would the sum.
    let logarithm = if size > 1e6 { ln(size) + core::f32::consts::LN_2 } else { ln(size + (size * size + 1.0).sqrt()) };
    logarithm.copysign(x)
}

/// The logistic function of `x`, 1 / (1 + e^-x), without overflow on either side.
pub(super) fn sigmoid(x: f32) -> f32 {
    let power = exp(-x.abs());
    let upper = if x < 0.0 { power } else { 1.0 };
    upper / (1.0 + power)
}

/// The logarithm of 1 + e^`x`, a smooth form of the larger of `x` and 0.
pub(super) fn softplus(x: f32) -> f32 {
    let power = exp(-x.abs());
    let one_more = 1.0 + power;
    // The factor undoes the rounding of the sum, which matters where the power is small.
    let logarithm = if one_more == 1.0 { power } else { ln(one_more) * (power / (one_more - 1.0)) };
    if x > 0.0 { x + logarithm } else { logarithm }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// How many 32-bit numbers lie between `value` and `reference`, in units of the spacing at the reference.
    fn ulps(value: f32, reference: f64) -> f64 {
        let near = reference as f32;
        let spacing = f64::from(f32::from_bits(near.abs().to_bits() + 1)) - f64::from(near.abs());
        (f64::from(value) - reference).abs() / spacing
    }

    /// Numbers from `low` to `high`, both evenly spaced and, near 0, of every size.
    fn samples(low: f32, high: f32) -> impl Iterator<Item = f32> {
        let even = (0..400_000).map(move |i| low + (high - low) * (i as f32 / 400_000.0));
        let small = (1..0x4300_0000_u32).step_by(4001).map(f32::from_bits).flat_map(|x| [x, -x]);
        even.chain(small.filter(move |x| (low..high).contains(x)))
    }

    fn worst(low: f32, high: f32, own: fn(f32) -> f32, reference: fn(f64) -> f64) -> f64 {
        samples(low, high).map(|x| ulps(own(x), reference(f64::from(x)))).fold(0.0, f64::max)
    }

    #[test]
    fn the_logarithm_of_any_number_is_that_of_the_standard() {
        assert_eq!([log(0.0), log(-0.0)], [f32::NEG_INFINITY; 2]);
        assert!([-1.0, -1e-40, -3e38, f32::NEG_INFINITY, f32::NAN].into_iter().all(|x| log(x).is_nan()));
        assert_eq!([log(f32::INFINITY), log(1.0), asinh(f32::INFINITY)], [f32::INFINITY, 0.0, f32::INFINITY]);
        for x in [1e-45_f32, 1e-40, 1.2e-38, 1e-20, 0.3, 0.99, 3e38] {
            assert!(ulps(log(x), f64::from(x).ln()) < 2.0, "{x}: {}", log(x));
        }
        assert!((asinh(3e38) - 89.29).abs() < 0.01 && asinh(-3e38) == -asinh(3e38));
    }

    #[test]
    fn every_function_is_within_three_ulps() {
        let found = [
            ("exp", worst(-103.9, 88.7, exp, f64::exp)),
            ("tanh", worst(-20.0, 20.0, tanh, f64::tanh)),
            ("ln", worst(1.0, 3e38, ln, f64::ln)),
            ("ln near 1", worst(1.0, 4.0, ln, f64::ln)),
            ("sigmoid", worst(-80.0, 80.0, sigmoid, |x| 1.0 / (1.0 + (-x).exp()))),
            ("softplus", worst(-80.0, 80.0, softplus, |x| x.max(0.0) + (-x.abs()).exp().ln_1p())),
        ];
        println!("{found:?}");
        for (name, error) in found {
            assert!(error <= 3.0, "{name} is off by {error} ulps");
        }
    }

    #[test]
    fn the_ends_saturate_and_nan_stays() {
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(f32::INFINITY), f32::INFINITY);
        assert_eq!(exp(88.8), f32::INFINITY);
        assert!(exp(88.72).is_finite());
        assert_eq!(exp(f32::NEG_INFINITY), 0.0);
        assert_eq!(exp(-104.5), 0.0);
        assert!(exp(-103.0) > 0.0);
        assert_eq!(tanh(f32::INFINITY), 1.0);
        assert_eq!(tanh(-50.0), -1.0);
        assert_eq!(sigmoid(f32::NEG_INFINITY), 0.0);
        assert_eq!(sigmoid(f32::INFINITY), 1.0);
        assert_eq!(softplus(f32::INFINITY), f32::INFINITY);
        assert_eq!(softplus(f32::NEG_INFINITY), 0.0);
        for function in [exp, ln, tanh, sigmoid, softplus, asinh] {
            assert!(function(f32::NAN).is_nan());
        }
    }

    proptest! {
        #[test]
        fn tanh_is_odd_bounded_and_monotone(x in -12.0_f32..12.0, step in 1e-5_f32..1.0) {
            prop_assert_eq!(tanh(-x), -tanh(x));
            prop_assert!(tanh(x).abs() <= 1.0);
            prop_assert!(tanh(x + step) >= tanh(x));
        }

        #[test]
        fn logistic_function_and_its_mirror_sum_to_one(x in -30.0_f32..30.0) {
            let reference = f64::from(x).asinh();
            prop_assert!((f64::from(asinh(x)) - reference).abs() < 2e-7 * (1.0 + reference.abs()), "{x}");
            prop_assert!((sigmoid(x) + sigmoid(-x) - 1.0).abs() < 2e-7);
        }
    }
}

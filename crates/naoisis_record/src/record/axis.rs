//! Ticks of axes: their values and labels.

use bevy::math::ops;

/// Returns the smallest of 1, 2 and 5 times powers of ten that is not below `least`.
pub fn round_step(least: f64) -> f64 {
    let least = least.max(1e-9);
    let power = 10_f64.powi((ops::log10(least as f32)).floor() as i32);
    // Start one power lower, since the logarithm was rounded.
    [0.5, 1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|step| *step >= 0.999 * least)
        .unwrap_or(10.0 * power)
}

/// Returns the multiples of `step` between two values, from the smallest, with a tolerance for rounding.
pub fn ticks([from, to]: [f64; 2], step: f64) -> impl Iterator<Item = f64> {
    let first = (from.min(to) / step - 1e-3).ceil() as i64;
    let last = (from.max(to) / step + 1e-3).floor() as i64;
    (first..=last).map(move |index| index as f64 * step)
}

/// Writes `value` with the decimal places of `step`.
pub fn number(value: f64, step: f64) -> String {
    let digits = (0..9).find(|digits| {
        let scaled = step * 10_f64.powi(*digits);
        (scaled - scaled.round()).abs() < 1e-3 * scaled
    });
    let text = format!("{value:.*}", digits.unwrap_or(3) as usize);
    // There is no negative zero on an axis, and a minus sign is longer than a hyphen.
    let bare = text.trim_start_matches('-');
    if bare.chars().all(|letter| matches!(letter, '0' | '.')) { bare.to_owned() } else { text.replace('-', "\u{2212}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_one_two_or_five_times_a_power_of_ten() {
        for (least, step) in [(0.03, 0.05), (0.1, 0.1), (0.11, 0.2), (3.0, 5.0), (7.0, 10.0), (1000.0, 1000.0)] {
            assert!((round_step(least) / step - 1.0).abs() < 1e-6, "{least}: {}", round_step(least));
        }
    }

    #[test]
    fn ticks_are_multiples_of_the_step_ends_included() {
        let ticks = |range, step| ticks(range, step).collect::<Vec<f64>>();
        assert_eq!(ticks([0.0, 1.0], 0.25), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(ticks([1.2, -1.2], 0.5), [-1.0, -0.5, 0.0, 0.5, 1.0]);
        assert_eq!(ticks([-0.3_f32, 0.3].map(f64::from), f64::from(0.1_f32)).len(), 7);
        assert!(ticks([0.1, 0.4], 0.5).is_empty());
    }

    #[test]
    fn numbers_have_the_digits_of_their_step() {
        assert_eq!(number(-0.5, 0.5), "\u{2212}0.5");
        assert_eq!(number(2.0, 1.0), "2");
        assert_eq!(number(-0.0, 0.05), "0.00");
        assert_eq!(number(30.0, 10.0), "30");
        assert_eq!(number(0.3, f64::from(0.1_f32)), "0.3");
    }
}

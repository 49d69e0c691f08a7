//! Means and shares with their confidence intervals.

use serde::Serialize;

use crate::random::RandomStream;

/// The quantile of the standard normal distribution for a two-sided confidence of 95 %.
const Z_95: f64 = 1.959_963_984_540_054;

/// A value and the interval in which the truth lies with 95 % confidence.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Estimate {
    /// An exact value.
    pub fn exactly(value: f64) -> Self {
        Self { value, low: value, high: value }
    }

    /// Half the width of the interval.
    pub fn margin(&self) -> f64 {
        (self.high - self.low) / 2.0
    }

    /// The estimate of a share: the ends of the interval are clamped to 0..1.
    pub fn of_share(self) -> Self {
        Self { low: self.low.max(0.0), high: self.high.min(1.0), ..self }
    }
}

/// The share of successes, with Wilson's score interval; `None` without trials.
pub fn share(successes: usize, trials: usize) -> Option<Estimate> {
    if trials == 0 {
        return None;
    }
    // Wilson 1927: (p + z²/2n ± z sqrt(p (1 - p)/n + z²/4n²)) / (1 + z²/n)
    let (n, z2) = (trials as f64, Z_95 * Z_95);
    let p = successes as f64 / n;
    let centre = p + z2 / (2.0 * n);
    let spread = Z_95 * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z2 / n;
    Some(Estimate { value: p, low: ((centre - spread) / scale).max(0.0), high: ((centre + spread) / scale).min(1.0) })
}

/// The mean, with Student's interval; `None` without values. The interval of a single value is infinite.
pub fn mean(values: &[f64]) -> Option<Estimate> {
    if values.is_empty() {
        return None;
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let margin = match values.len() {
        1 => f64::INFINITY,
        _ => {
            let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0);
            student_quantile_95(n - 1.0) * (variance / n).sqrt()
        }
    };
    Some(Estimate { value: mean, low: mean - margin, high: mean + margin })
}

/// A statistic of values in independent groups, with the interval of the jackknife (Tukey 1958); `None` if the statistic has no value. With
/// a single group the interval is infinite.
pub fn jackknife<T: Copy>(groups: &[Vec<T>], statistic: impl Fn(&[T]) -> Option<f64>) -> Option<Estimate> {
    let without = |left_out: Option<usize>| {
        let kept = groups.iter().enumerate().filter(|(index, _)| Some(*index) != left_out);
        statistic(&kept.flat_map(|(_, group)| group.iter().copied()).collect::<Vec<T>>())
    };
    let value = without(None)?;
    let partial: Vec<f64> = (0..groups.len()).filter_map(|index| without(Some(index))).collect();
    let n = partial.len() as f64;
    if partial.len() < 2 {
        return Some(Estimate { value, low: f64::NEG_INFINITY, high: f64::INFINITY });
    }
    let mean = partial.iter().sum::<f64>() / n;
    let squares: f64 = partial.iter().map(|partial| (partial - mean) * (partial - mean)).sum();
    let margin = student_quantile_95(n - 1.0) * (squares * (n - 1.0) / n).sqrt();
    Some(Estimate { value, low: value - margin, high: value + margin })
}

/// The number of samples of [`bootstrap`].
const RESAMPLES: usize = 1000;

/// Statistics of values in groups, each with the interval between the 2.5 % and 97.5 % quantiles of 1000 samples, in which the values of
/// each group are drawn with replacement (stratified bootstrap, Efron 1979); `None` if the statistics have no value. If no group has two
/// values, the intervals are infinite. The random numbers are always the same.
pub fn bootstrap<T: Copy>(
    groups: &[Vec<T>],
    statistics: impl Fn(&[Vec<T>]) -> Option<Vec<f64>>,
) -> Option<Vec<Estimate>> {
    let values = statistics(groups)?;
    if groups.iter().all(|group| group.len() < 2) {
        let unknown = |value| Estimate { value, low: f64::NEG_INFINITY, high: f64::INFINITY };
        return Some(values.into_iter().map(unknown).collect());
    }
    let mut stream = RandomStream::for_match(0, "bootstrap");
    let mut drawn: Vec<Vec<T>> = groups.to_vec();
    let mut samples: Vec<Vec<f64>> = vec![Vec::with_capacity(RESAMPLES); values.len()];
    for _ in 0..RESAMPLES {
        for (drawn, group) in drawn.iter_mut().zip(groups) {
            for value in drawn.iter_mut() {
                let index = (stream.uniform() * group.len() as f32) as usize;
                *value = group[index.min(group.len() - 1)];
            }
        }
        for (sample, value) in samples.iter_mut().zip(statistics(&drawn).into_iter().flatten()) {
            sample.push(value);
        }
    }
    let interval = |(value, sample): (f64, Vec<f64>)| Estimate {
        value,
        low: quantile(sample.clone(), 0.025).unwrap_or(value),
        high: quantile(sample, 0.975).unwrap_or(value),
    };
    Some(values.into_iter().zip(samples).map(interval).collect())
}

/// The interquartile mean: the mean without the lowest and the highest quarter of the values, each rounded down to whole values; `None`
/// without values.
pub fn interquartile_mean(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let quarter = values.len() / 4;
    let middle = &values[quarter..values.len() - quarter];
    (!middle.is_empty()).then(|| middle.iter().sum::<f64>() / middle.len() as f64)
}

/// The median: the middle value, or the mean of the two middle values if their number is even. `None` without values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    let upper = *values.get(middle)?;
    Some(if values.len() % 2 == 1 { upper } else { (values[middle - 1] + upper) / 2.0 })
}

/// The quantile of the values at `share` (0 to 1), by nearest rank; `None` without values.
pub fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let rank = ((values.len() as f64 * share).ceil() as usize).clamp(1, values.len().max(1));
    values.get(rank - 1).copied()
}

/// Returns `value` with `digits` decimal places at most. Zero has no minus sign.
pub fn rounded(value: f64, digits: u32) -> f64 {
    let unit = (0..digits).fold(1.0, |unit, _| 10.0 * unit);
    (value * unit).round() / unit + 0.0
}

/// Student's two-sided quantile for 95 %: exact for 1 and 2 degrees of freedom, else by Fisher's expansion (Abramowitz
/// and Stegun, 26.7.5), which is good to 0.2 % from 3 on.
fn student_quantile_95(degrees: f64) -> f64 {
    let z = Z_95;
    if degrees < 1.5 {
        return 12.706_204_736;
    }
    if degrees < 2.5 {
        return 4.302_652_73;
    }
    let z2 = z * z;
    let [z3, z5] = [z2 * z, z2 * z2 * z];
    let [z7, z9] = [z5 * z2, z5 * z2 * z2];
    z + (z3 + z) / (4.0 * degrees)
        + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * degrees * degrees)
        + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * degrees * degrees * degrees)
        + (79.0 * z9 + 776.0 * z7 + 1482.0 * z5 - 1920.0 * z3 - 945.0 * z)
            / (92_160.0 * degrees * degrees * degrees * degrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn rounded_numbers_have_few_digits_and_zero_has_no_sign() {
        let values = [(1.2345, 2), (-0.004, 2), (-0.0, 0), (-0.6, 0), (2.5, 0)];
        let texts = values.map(|(value, digits)| format!("{:+}", rounded(value, digits)));
        assert_eq!(texts, ["+1.23", "+0", "+0", "-1", "+3"]);
    }

    #[test]
    fn the_jackknife_of_a_mean_is_students_interval() {
        let values = [2.0, 3.0, 5.0, 4.0, 9.0, 1.0];
        let groups = values.map(|value| vec![value]).to_vec();
        let estimate = jackknife(&groups, |values| Some(values.iter().sum::<f64>() / values.len() as f64)).unwrap();
        let expected = mean(&values).unwrap();
        assert!((estimate.low - expected.low).abs() < 1e-9 && (estimate.high - expected.high).abs() < 1e-9);
        assert_eq!(jackknife::<f64>(&[], |_| None), None);
    }

    #[test]
    fn the_bootstrap_of_a_mean_is_about_students_interval_and_groups_stay_apart() {
        let of_all = |groups: &[Vec<f64>]| Some(vec![mean(&groups.concat())?.value]);
        let values: Vec<f64> = (0..200).map(|index| f64::from(index % 20)).collect();
        let [estimate] = bootstrap(core::slice::from_ref(&values), of_all).unwrap()[..] else { panic!() };
        let student = mean(&values).unwrap();
        assert_eq!(estimate.value, student.value);
        assert_abs_diff_eq!(estimate.margin(), student.margin(), epsilon = 0.1 * student.margin());
        // Two groups of equal values have no spread, although the values of both together have.
        let groups = [vec![1.0; 5], vec![3.0; 5]];
        assert_eq!(bootstrap(&groups, of_all), Some(vec![Estimate::exactly(2.0)]));
        assert_eq!(bootstrap(&[vec![2.0]], of_all).unwrap()[0].high, f64::INFINITY);
        assert_eq!(bootstrap(&[vec![2.0]], |_| None), None);
    }

    #[test]
    fn the_interquartile_mean_leaves_out_the_outer_quarters() {
        assert_eq!(interquartile_mean(vec![100.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -50.0]), Some(3.5));
        assert_eq!(interquartile_mean(vec![1.0, 2.0, 9.0]), Some(4.0));
        assert_eq!(interquartile_mean(Vec::new()), None);
    }

    #[test]
    fn shares_have_wilsons_interval() {
        // 8 of 10: (0.8 + 0.19207 ± 1.96 sqrt(0.016 + 0.0096036)) / 1.384146 = 0.4902 .. 0.9433
        let estimate = share(8, 10).unwrap();
        assert_abs_diff_eq!(estimate.low, 0.4902, epsilon = 1e-4);
        assert_abs_diff_eq!(estimate.high, 0.9433, epsilon = 1e-4);
        assert_eq!(share(0, 5).unwrap().low, 0.0);
        assert_eq!(share(5, 5).unwrap().high, 1.0);
        assert_eq!(share(0, 0), None);
    }

    #[test]
    fn means_have_students_interval() {
        // 1, 2, 3, 4, 5: mean 3, standard deviation sqrt(2.5), t(4) = 2.776: 2.776 sqrt(2.5 / 5) = 1.963
        let estimate = mean(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert_abs_diff_eq!(estimate.value, 3.0, epsilon = 1e-12);
        assert_abs_diff_eq!(estimate.margin(), 1.963, epsilon = 0.002);
        assert_eq!(mean(&[]), None);
        assert_eq!(mean(&[2.0]).unwrap().margin(), f64::INFINITY);
    }

    #[test]
    fn the_interval_of_a_mean_share_stays_between_0_and_1() {
        let estimate = mean(&[0.1, 0.9]).unwrap();
        assert!(estimate.low < 0.0 && estimate.high > 1.0);
        assert_eq!(estimate.of_share(), Estimate { value: 0.5, low: 0.0, high: 1.0 });
    }

    #[test]
    fn students_quantiles_are_those_of_the_tables() {
        for (degrees, quantile) in
            [(1.0, 12.706), (2.0, 4.3027), (3.0, 3.1824), (4.0, 2.7764), (10.0, 2.2281), (99.0, 1.9842)]
        {
            assert!((student_quantile_95(degrees) / quantile - 1.0).abs() < 0.002, "{degrees}");
        }
    }

    #[test]
    fn quantiles_are_values_of_the_sample() {
        let values = (1..=10).map(f64::from).rev().collect::<Vec<_>>();
        for (share, value) in [(0.0, 1.0), (0.05, 1.0), (0.9, 9.0), (0.91, 10.0), (1.0, 10.0)] {
            assert_eq!(quantile(values.clone(), share), Some(value));
        }
        assert_eq!(quantile(Vec::new(), 0.5), None);
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(Vec::new()), None);
    }
}

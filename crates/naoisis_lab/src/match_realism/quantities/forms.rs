//! Constructors of quantities: means, ratios and quantiles over all matches.

use crate::match_realism::estimates::Quantity;
use crate::match_realism::measures::{FieldMeasures, MatchMeasures};
use naoisis_core::statistics::quantile;

/// Returns a number of a match, or `None` if it was not measured.
pub(super) type Number = fn(&MatchMeasures) -> Option<f64>;
/// Returns values of a match. Their quantiles are computed over all matches.
pub(super) type Sample = fn(&FieldMeasures) -> &[f64];

/// Makes a number of a match from a number of its robots and ball.
pub(super) fn field(number: impl Fn(&FieldMeasures) -> f64) -> impl Fn(&MatchMeasures) -> Option<f64> {
    move |one| one.field.as_ref().map(&number)
}

/// Creates a mean over the matches that have the number.
pub(super) fn mean(words: [&'static str; 4], number: impl Fn(&MatchMeasures) -> Option<f64> + 'static) -> Quantity {
    Quantity::new(words, move |matches| {
        let numbers: Vec<f64> = matches.iter().filter_map(|one| number(one)).collect();
        (!numbers.is_empty()).then(|| numbers.iter().sum::<f64>() / numbers.len() as f64)
    })
}

/// Creates the ratio of the sums of `part` and `whole` over the matches that have both, times `scale`.
pub(super) fn ratio(
    words: [&'static str; 4],
    part: impl Fn(&MatchMeasures) -> Option<f64> + 'static,
    whole: impl Fn(&MatchMeasures) -> Option<f64> + 'static,
    scale: f64,
) -> Quantity {
    Quantity::new(words, move |matches| {
        let parts: Vec<[f64; 2]> = matches.iter().filter_map(|one| Some([part(one)?, whole(one)?])).collect();
        let [part, whole] = [0, 1].map(|index| parts.iter().map(|parts| parts[index]).sum::<f64>());
        (whole > 0.0).then(|| scale * part / whole)
    })
}

/// Creates a quantile of the values of all matches.
pub(super) fn quantile_of(words: [&'static str; 4], sample: Sample, share: f64) -> Quantity {
    Quantity::new(words, move |matches| {
        let values =
            matches.iter().filter_map(|one| one.field.as_ref()).flat_map(|field| sample(field).iter().copied());
        quantile(values.collect(), share)
    })
}

/// Creates the mean of the values of all matches.
pub(super) fn mean_of(words: [&'static str; 4], sample: Sample) -> Quantity {
    ratio(
        words,
        move |one| one.field.as_ref().map(|field| sample(field).iter().sum()),
        move |one| one.field.as_ref().map(|field| sample(field).len() as f64),
        1.0,
    )
}

//! Ratings of teams by the matches of all pairs, with the model of Bradley and Terry (1952): two teams with the strengths `a` and `b` win
//! against each other with the probabilities `a / (a + b)` and `b / (a + b)`, and a draw is half a win of each.

use naoisis_core::statistics::{Estimate, bootstrap};

/// The most iterations of the maximum-likelihood estimate, and the relative change of a strength at which it ends.
const ITERATIONS: usize = 1000;
const END_CHANGE: f64 = 1e-6;

/// The ratings of `teams` teams in Elo points, with 95 % intervals of a bootstrap within each pair. Their mean is 0, and a team with 400 points
/// more than another scores 10 times as much. Each pair has the scores of its first team: 1 for a win, 0.5 for a draw, 0 for a loss. `None` if
/// a pair has no matches.
pub(super) fn ratings(teams: usize, pairs: &[([usize; 2], Vec<f64>)]) -> Option<Vec<Estimate>> {
    if pairs.is_empty() || pairs.iter().any(|(_, scores)| scores.is_empty()) {
        return None;
    }
    let scores: Vec<Vec<f64>> = pairs.iter().map(|(_, scores)| scores.clone()).collect();
    bootstrap(&scores, |scores| {
        let pairs = pairs.iter().zip(scores);
        let results: Vec<_> = pairs.map(|((teams, _), scores)| (*teams, scores.iter().sum(), scores.len())).collect();
        Some(elo_points(teams, &results))
    })
}

/// The ratings by the sum of the scores of each pair's first team and the number of matches. One draw is added to each pair, so that a team
/// without wins has a rating.
fn elo_points(teams: usize, results: &[([usize; 2], f64, usize)]) -> Vec<f64> {
    let mut strengths = vec![1.0_f64; teams];
    for _ in 0..ITERATIONS {
        let [mut won, mut expected] = [vec![0.0; teams], vec![0.0; teams]];
        for ([first, second], score, matches) in results {
            let matches = *matches as f64 + 1.0;
            won[*first] += score + 0.5;
            won[*second] += matches - (score + 0.5);
            let each = matches / (strengths[*first] + strengths[*second]);
            expected[*first] += each;
            expected[*second] += each;
        }
        let next: Vec<f64> = won.iter().zip(&expected).map(|(won, expected)| won / expected).collect();
        let change = next.iter().zip(&strengths).map(|(next, now)| (next / now - 1.0).abs()).fold(0.0, f64::max);
        strengths = next;
        if change < END_CHANGE {
            break;
        }
    }
    let points: Vec<f64> = strengths.iter().map(|strength| 400.0 * strength.log10()).collect();
    let mean = points.iter().sum::<f64>() / teams as f64;
    points.iter().map(|points| points - mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_team_that_scores_ten_times_as_much_has_400_points_more() {
        // With the draw that is added, 1000 of 1100.
        let scores = [vec![1.0; 999], vec![0.5; 1], vec![0.0; 99]].concat();
        let [first, second] = ratings(2, &[([0, 1], scores)]).unwrap()[..] else { panic!() };
        assert!((first.value - 200.0).abs() < 0.1 && (second.value + 200.0).abs() < 0.1, "{first:?}");
        assert!(first.low < 200.0 && first.high > 200.0 && first.margin() < 25.0, "{first:?}");
    }

    #[test]
    fn a_team_that_beats_the_winner_of_a_pair_is_rated_above_both() {
        let pairs = [([0, 1], vec![1.0, 1.0, 0.0]), ([0, 2], vec![0.0, 0.0, 0.5]), ([1, 2], vec![0.0, 0.5, 0.5])];
        let ratings: Vec<f64> = ratings(3, &pairs).unwrap().iter().map(|rating| rating.value).collect();
        assert!(ratings[2] > ratings[0] && ratings[0] > ratings[1], "{ratings:?}");
        assert!(ratings.iter().sum::<f64>().abs() < 1e-9);
        assert_eq!(super::ratings(2, &[([0, 1], Vec::new())]), None);
    }
}

//! Teams against each other: each beats the one before.

use naoisis::batch::pairs::{PairTable, Pairing, Pairs};
use naoisis::batch::{Batch, MatchRow, run_batch};
use naoisis::prelude::*;
use std::sync::atomic::AtomicBool;

use crate::support::headless_app;

/// Plays every two of the teams against each other on the paper's pitch, in both colours, so many times with seeds from 1 on.
fn played(teams: &[&str], times: usize, duration_s: Option<f32>) -> PairTable {
    played_in("paper", "paper", teams, times, duration_s)
}

/// The same in a league, as real as this.
fn played_in(league: &str, realism: &str, teams: &[&str], times: usize, duration_s: Option<f32>) -> PairTable {
    let pairs = Pairs::of(teams.iter().map(|team| (*team).to_owned()).collect());
    let pairings: Vec<_> = pairs.pairings().collect();
    let scenario = |pairing: &Pairing| {
        let [blue, pink] = pairs.names(*pairing);
        let teams = format!(r#""teams": {{ "blue": "{blue}", "pink": "{pink}" }}"#);
        let json = format!(r#"{{ "league": "{league}", "realism": "{realism}", {teams} }}"#);
        Scenario { duration_s, ..Scenario::from_json(&json).unwrap() }
    };
    let variants: Vec<Scenario> = pairings.iter().map(scenario).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let batch = Batch { variants, matches: times, first_seed: 1, threads };
    let mut rows: Vec<MatchRow> = Vec::new();
    run_batch(&batch, 0, headless_app, &AtomicBool::new(false), |row| rows.push(row));
    pairs.table(rows.iter().map(|row| (row, pairings[row.variant])))
}

#[test]
fn both_teams_of_a_pair_see_the_same_matches() {
    let table = played(&["roles", "chasers"], 2, Some(20.0));
    let (one, other) = (table.summary("roles", "chasers").unwrap(), table.summary("chasers", "roles").unwrap());
    assert_eq!((one.matches, one.failed), (4, 0));
    assert_eq!(one.goals, other.goals_against);
    assert_eq!(table.summary("roles", "passers"), None);
}

/// 200 whole matches of each pair, which take minutes even in a release build.
#[test]
#[cfg_attr(debug_assertions, ignore = "1200 whole matches: .ci/statistics")]
fn passers_beat_roles_and_roles_beat_chasers_with_95_percent_confidence() {
    for realism in ["paper", "ideal", "realistic"] {
        for [better, other] in [["passers", "roles"], ["roles", "chasers"]] {
            let table = played_in("paper", realism, &[better, other], 100, None);
            let summary = table.summary(better, other).unwrap();
            assert_eq!((summary.matches, summary.failed), (200, 0));
            // Without noise every seed plays the same match.
            let wins_all =
                summary.repeated && summary.losses.unwrap().value == 0.0 && summary.draws.unwrap().value == 0.0;
            assert!(wins_all || summary.is_first_better() == Some(true), "{realism}: {table}");
        }
    }
}

/// What holds for NAOs holds for other robots, on other pitches: more matches are won than lost.
#[test]
#[cfg_attr(debug_assertions, ignore = "48 matches: .ci/statistics")]
fn passers_win_more_than_roles_in_the_leagues_of_larger_robots() {
    for league in ["hsl2026_middle", "hsl2026_large"] {
        let table = played_in(league, "realistic", &["passers", "roles"], 12, Some(300.0));
        let summary = table.summary("passers", "roles").unwrap();
        assert_eq!((summary.matches, summary.failed), (24, 0));
        assert!(summary.wins.unwrap().value > summary.losses.unwrap().value, "{league}: {table}");
    }
}

//! One counter of a match: every report has the same numbers.

use naoisis::batch::{self, MatchRow};
use naoisis::expectations::{self, Watch};
use naoisis::interface::gather::{CurrentRecord, gather_start};
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;
use naoisis::record::match_summary::MatchSummary;
use naoisis::record::mistakes::{MistakeFinder, MistakeKind};
use naoisis::record::summary_rows::team_rows;
use naoisis::scenario::Expectation;

use crate::support::headless_app;

/// Matches of four leagues with kick-offs, throw-ins, free kicks and penalties, for so many seconds.
const MATCHES: [(&str, u64, f32); 4] =
    [("match3v3", 3, 120.0), ("spl2010", 1, 90.0), ("spl2025", 2, 60.0), ("hsl2026_middle", 3, 90.0)];

/// The reports of a match that is played once, cycle by cycle.
struct Reports {
    summary: MatchSummary,
    found: MistakeFinder,
    watch: Watch,
    expected: Vec<Expectation>,
    restarts: usize,
}

fn reports(scenario: &Scenario) -> Reports {
    let quantities = [
        "goals", "own_goals", "kicks", "passes_completed", "shots", "shots_on_target", "saves", "penalties", "falls",
        "possession_percent", "ball_given_away",
    ];
    let expected: Vec<Expectation> = ["blue", "pink"]
        .iter()
        .flat_map(|team| quantities.map(|quantity| format!("{team}.{quantity} >= 0").parse().unwrap()))
        .collect();
    let mut app = headless_app();
    app.add_plugins(RecordPlugin);
    app.start_match(scenario).unwrap();
    gather_start(app.world_mut());
    let mut watch = Watch::begin(app.world_mut(), &expected);
    let (mut summary, mut found) = (MatchSummary::new(scenario), MistakeFinder::new(scenario));
    let mut restarts = 0;
    loop {
        let record = &app.world().resource::<CurrentRecord>().record;
        summary.look(record);
        found.look(record);
        restarts += record
            .events
            .iter()
            .filter(|event| {
                matches!(event, MatchEvent::FreeKick { .. } | MatchEvent::ThrowIn { .. } | MatchEvent::KickOff { .. })
            })
            .count();
        if app.game().state == GameState::Finished || scenario.last_cycle().is_some_and(|last| app.cycle() >= last) {
            break;
        }
        app.run_cycles(1);
        watch.observe(app.world_mut(), &expected);
    }
    Reports { summary, found, watch, expected, restarts }
}

impl Reports {
    /// What was found for an expectation, as it is printed.
    fn expectation(&self, team: Team, quantity: &str) -> f64 {
        let verdicts = expectations::judge(&self.watch, &self.expected);
        let words = format!("{team}.{quantity} >= 0: it was ");
        let found = verdicts.iter().find_map(|verdict| verdict.to_string().strip_prefix(&words).map(str::to_owned));
        found.unwrap_or_else(|| panic!("{words}: {verdicts:?}")).parse().unwrap()
    }

    /// The cell of a team in the summary.
    fn cell(&self, team: Team, words: &str) -> String {
        let row = team_rows(&self.summary).into_iter().find(|row| row[0] == words);
        row.unwrap_or_else(|| panic!("no row {words}"))[1 + team as usize].clone()
    }
}

#[test]
fn every_report_has_the_same_numbers() {
    let mut sums = [0; 5];
    for (name, seed, duration_s) in MATCHES {
        let scenario = Scenario { seed, duration_s: Some(duration_s), ..Scenario::named(name).unwrap() };
        let row: MatchRow = batch::play(headless_app, &scenario);
        let reports = reports(&scenario);
        let counts = &reports.summary.counts;
        assert_eq!(counts.outs, row.outs, "{name}");
        assert!((counts.duration_s - row.duration_s).abs() < 1e-9, "{name}");
        for team in Team::BOTH {
            let own = counts.team(team);
            let place = format!("{name} {team}");
            let of_row = [row.goals, row.own_goals, row.kicks, row.kept, row.given_away, row.penalties];
            let of_summary = [
                counts.goals[team],
                counts.own_goals[team],
                own.kicks,
                own.passes_completed,
                own.passes - own.passes_completed,
                own.penalty_count(),
            ];
            assert_eq!(of_row.map(|counts| counts[team]), of_summary, "{place}");
            let quantities = ["goals", "own_goals", "kicks", "passes_completed", "ball_given_away", "penalties"];
            assert_eq!(quantities.map(|quantity| reports.expectation(team, quantity)), of_summary.map(f64::from));
            let given_away = reports
                .found
                .mistakes()
                .iter()
                .filter(|mistake| mistake.kind == MistakeKind::BallGivenAway && mistake.robot.team == team)
                .count();
            assert_eq!(given_away as u32, row.given_away[team], "{place}");
            for (quantity, counted) in [
                ("falls", own.falls),
                ("shots", own.shots),
                ("shots_on_target", own.shots_on_target),
                ("saves", own.saves),
            ] {
                assert_eq!(reports.expectation(team, quantity), f64::from(counted), "{place} {quantity}");
            }
            let words = format!("{} of {} (", row.kept[team], row.kept[team] + row.given_away[team]);
            let cell = reports.cell(team, "passes completed");
            assert!(cell.starts_with(&words) || cell == "0" && own.passes == 0, "{place}: {cell}");
            let possession = counts.possession(team);
            let of_team = row.blue_possession.map(|blue| if team == Team::Blue { blue } else { 1.0 - blue });
            assert!((possession.unwrap() - of_team.unwrap()).abs() < 1e-4, "{place}");
            assert!((reports.expectation(team, "possession_percent") - 100.0 * possession.unwrap()).abs() < 1e-3);
            assert_eq!(reports.cell(team, "possession"), format!("{:.0} %", 100.0 * possession.unwrap()), "{place}");
            let rounded = |value: Option<f64>| value.map(|value| (value * 1e4).round() / 1e4);
            assert_eq!(rounded(counts.median_pose_error_m(team)), row.belief_error_m[team], "{place}");
            assert_eq!(rounded(own.pose_errors.over_half_m()), row.belief_over_half_m[team], "{place}");
            assert_eq!(rounded(own.pose_errors.over_1_m()), row.belief_over_1_m[team], "{place}");
            let found = [own.kicks, own.passes, own.shots, own.penalty_count(), reports.restarts as u32];
            sums.iter_mut().zip(found).for_each(|(sum, found)| *sum += found);
        }
    }
    // Something was counted of each.
    assert!(sums.iter().all(|sum| *sum > 0), "{sums:?}");
}

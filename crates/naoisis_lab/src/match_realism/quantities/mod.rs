//! The quantities by which matches are compared.

mod decided;
mod forms;
mod played;

use super::estimates::Quantity;
use super::measures::MatchMeasures;

/// Returns the quantities, in the order in which they are printed. Each kind of kick in `matches` has its own.
pub fn quantities(matches: &[MatchMeasures]) -> Vec<Quantity> {
    let mut quantities = decided::goals();
    quantities.extend(decided::falls());
    quantities.extend(decided::possession_and_time());
    quantities.extend(decided::penalties());
    quantities.extend(decided::set_plays());
    quantities.extend(played::kicks(matches));
    quantities.extend(played::around_the_ball());
    quantities.extend(played::walking_and_knowing());
    quantities
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::match_realism::measures::FieldMeasures;
    use naoisis_core::events::FallCause;
    use naoisis_core::team::PerTeam;

    #[test]
    fn every_quantity_has_a_key_of_its_own_and_a_definition() {
        let quantities = quantities(&[]);
        let mut keys: Vec<&str> = quantities.iter().map(|quantity| quantity.key.as_str()).collect();
        keys.sort_unstable();
        assert!(keys.windows(2).all(|pair| pair[0] != pair[1]), "{keys:?}");
        for quantity in &quantities {
            assert!(!quantity.key.is_empty() && !quantity.name.is_empty(), "{}", quantity.key);
            assert!(!quantity.definition.is_empty() && !quantity.definition.contains('\n'), "{}", quantity.key);
        }
    }

    fn value(key: &str, matches: &[MatchMeasures]) -> Option<f64> {
        let quantity = quantities(matches).into_iter().find(|quantity| quantity.key == key).unwrap();
        quantity.estimate(&matches.iter().collect::<Vec<_>>()).map(|estimate| estimate.value)
    }

    #[test]
    fn values_are_of_all_matches_together() {
        let one = |blue, pink, falls, walked_m| MatchMeasures {
            goals: PerTeam { blue, pink },
            goals_in_first_half: blue,
            field: Some(FieldMeasures {
                falls: [(FallCause::Walking, falls), (FallCause::GettingUp, 4)].into(),
                walked_m,
                kick_ways_m: vec![f64::from(blue), 9.0],
                stuck_robots: blue,
                stuck_stops: pink,
                passes: pink + 1,
                passes_completed: blue,
                possession: PerTeam { blue: Some(0.25), pink: Some(0.75) },
                kicks: [("side".to_owned(), 3), ("straight".to_owned(), 1)].into(),
                ..FieldMeasures::default()
            }),
            ..MatchMeasures::default()
        };
        let matches = [one(1, 3, 2, 100.0), one(0, 0, 0, 300.0)];
        for (key, expected) in [
            ("goals", 2.0),
            ("draws", 50.0),
            ("goalless", 50.0),
            ("both_score", 50.0),
            ("goal_difference", 1.0),
            ("goals_first_half", 25.0),
            ("falls_per_km", 5.0),
            ("falls_walking", 5.0),
            ("falls_kick", 0.0),
            ("falls_getting_up", 20.0),
            ("kick_way_95", 9.0),
            ("possession_larger", 75.0),
            ("kicks.side", 75.0),
            ("stuck_robots", 0.5),
            ("stuck_stops", 1.5),
            ("passes_completed", 20.0),
            ("penalties", 0.0),
        ] {
            assert_eq!(value(key, &matches), Some(expected), "{key}");
        }
        assert!((value("goals_sd", &matches).unwrap() - 8.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_was_not_measured_has_no_value() {
        let of_a_log = [MatchMeasures { play_s: 600.0, ..MatchMeasures::default() }];
        for key in ["falls_per_km", "kicks", "messages", "ball_seen", "kick_way_50", "playing", "outs", "ball_rolls"] {
            assert_eq!(value(key, &of_a_log), None, "{key}");
        }
        assert_eq!(value("goals", &of_a_log), Some(0.0));
    }
}

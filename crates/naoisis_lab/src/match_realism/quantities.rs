//! The quantities that matches are compared by.

use std::collections::BTreeSet;

use super::estimates::Quantity;
use super::measures::{FieldMeasures, MatchMeasures, NextTouch, PenaltyGroup};
use naoisis_core::events::FallCause;
use naoisis_core::game::SetPlayKind;
use naoisis_core::statistics::quantile;
use naoisis_core::team::{PerTeam, Team};

/// A number of a match. `None` if it was not measured.
type Number = fn(&MatchMeasures) -> Option<f64>;
/// Values of a match of which all matches together have quantiles.
type Sample = fn(&FieldMeasures) -> &[f64];

/// Returns the quantities, in the order in which they are printed. Kicks have one for each kind in `matches`.
pub fn quantities(matches: &[MatchMeasures]) -> Vec<Quantity> {
    let mut quantities = goals();
    quantities.extend(falls());
    quantities.extend(possession_and_time());
    quantities.extend(penalties());
    quantities.extend(set_plays());
    quantities.extend(kicks(matches));
    quantities.extend(around_the_ball());
    quantities.extend(walking_and_knowing());
    quantities
}

/// A number of a match, of what is known of robots and ball.
fn field(number: impl Fn(&FieldMeasures) -> f64) -> impl Fn(&MatchMeasures) -> Option<f64> {
    move |one| one.field.as_ref().map(&number)
}

/// The mean over the matches that have the number.
fn mean(words: [&'static str; 4], number: impl Fn(&MatchMeasures) -> Option<f64> + 'static) -> Quantity {
    Quantity::new(words, move |matches| {
        let numbers: Vec<f64> = matches.iter().filter_map(|one| number(one)).collect();
        (!numbers.is_empty()).then(|| numbers.iter().sum::<f64>() / numbers.len() as f64)
    })
}

/// What all matches have of `part`, divided by what they have of `whole`, times `scale`.
fn ratio(
    words: [&'static str; 4],
    part: impl Fn(&MatchMeasures) -> Option<f64> + 'static,
    whole: impl Fn(&MatchMeasures) -> Option<f64> + 'static,
    scale: f64,
) -> Quantity {
    Quantity::new(words, move |matches| {
        let sum = |number: &dyn Fn(&MatchMeasures) -> Option<f64>| -> f64 {
            matches.iter().filter_map(|one| number(one)).sum()
        };
        let whole = sum(&whole);
        (whole > 0.0).then(|| scale * sum(&part) / whole)
    })
}

/// A quantile of the values of all matches.
fn quantile_of(words: [&'static str; 4], sample: Sample, share: f64) -> Quantity {
    Quantity::new(words, move |matches| {
        let values =
            matches.iter().filter_map(|one| one.field.as_ref()).flat_map(|field| sample(field).iter().copied());
        quantile(values.collect(), share)
    })
}

/// The mean of the values of all matches.
fn mean_of(words: [&'static str; 4], sample: Sample) -> Quantity {
    ratio(
        words,
        move |one| one.field.as_ref().map(|field| sample(field).iter().sum()),
        move |one| one.field.as_ref().map(|field| sample(field).len() as f64),
        1.0,
    )
}

fn goals() -> Vec<Quantity> {
    let all: Number = |one| Some(f64::from(one.all_goals()));
    vec![
        mean(["goals", "goals a match", "", "goals of both teams in regular time"], all),
        Quantity::new(
            [
                "goals_sd",
                "goals, standard deviation",
                "",
                "standard deviation of the goals of both teams over the matches",
            ],
            move |matches| {
                let goals: Vec<f64> = matches.iter().filter_map(|one| all(one)).collect();
                let mean = goals.iter().sum::<f64>() / goals.len() as f64;
                let squares: f64 = goals.iter().map(|goals| (goals - mean) * (goals - mean)).sum();
                (goals.len() > 1).then(|| (squares / (goals.len() - 1) as f64).sqrt())
            },
        ),
        Quantity::share_of_matches(["goalless", "matches without a goal", "share of matches that end 0:0"], |one| {
            one.all_goals() == 0
        }),
        Quantity::share_of_matches(
            ["draws", "draws", "share of matches with as many goals of both teams, 0:0 included"],
            |one| one.goals.blue == one.goals.pink,
        ),
        Quantity::share_of_matches(
            ["both_score", "both teams score", "share of matches in which each team scores"],
            |one| one.goals.blue.min(one.goals.pink) > 0,
        ),
        mean(
            ["goal_difference", "goal difference", "", "mean of the absolute difference of the teams' goals"],
            |one| Some(f64::from(one.goals.blue.abs_diff(one.goals.pink))),
        ),
        ratio(
            ["goals_first_half", "goals in the first half", "%", "share of all goals that fall in the first half"],
            |one| Some(f64::from(one.goals_in_first_half)),
            all,
            100.0,
        ),
    ]
}

fn falls() -> Vec<Quantity> {
    fn of_cause(words: [&'static str; 4], cause: FallCause) -> Quantity {
        let falls = field(move |field| f64::from(field.falls.get(&cause).copied().unwrap_or_default()));
        ratio(words, falls, field(|field| field.walked_m), 1000.0)
    }
    vec![
        ratio(
            [
                "falls_per_km",
                "falls a km walked",
                "",
                "falls in play, by what upright robots walked in play, steps under 10 cm left out",
            ],
            field(|field| f64::from(field.all_falls())),
            field(|field| field.walked_m),
            1000.0,
        ),
        of_cause(
            ["falls_walking", "  in walking", "", "the same, of falls by loss of balance in walking"],
            FallCause::Walking,
        ),
        of_cause(["falls_collision", "  in collisions", "", "the same, of falls in collisions"], FallCause::Collision),
        of_cause(["falls_kick", "  in kicks", "", "the same, of falls in kicks"], FallCause::Kick),
        of_cause(
            ["falls_getting_up", "  in getting up", "", "the same, of attempts to get up that failed"],
            FallCause::GettingUp,
        ),
        ratio(
            [
                "falls_per_min",
                "falls a robot and minute",
                "",
                "falls in play, by the time of robots in play without a penalty",
            ],
            field(|field| f64::from(field.all_falls())),
            field(|field| field.robot_play_s),
            60.0,
        ),
        ratio(
            ["lying", "lying", "%", "share of the robots' time in play in which they lie or get up"],
            field(|field| field.lying_s),
            field(|field| field.robot_play_s),
            100.0,
        ),
        mean_of(
            [
                "getting_up",
                "fallen until upright",
                "s",
                "mean time from a fall until the robot stands again, failed attempts included",
            ],
            |field| &field.get_up_s,
        ),
    ]
}

fn possession_and_time() -> Vec<Quantity> {
    vec![
        ratio(
            [
                "ball_way",
                "ball's way : robots' way",
                "",
                "way of the ball in play, by what upright robots walked (see falls a km)",
            ],
            field(|field| field.ball_way_m),
            field(|field| field.walked_m),
            1.0,
        ),
        Quantity::new(
            [
                "possession_stronger",
                "possession of the stronger team",
                "%",
                "mean possession of the team with the better goal difference over all matches (of blue if they are level)",
            ],
            |matches| {
                let difference = |one: &&MatchMeasures| i64::from(one.goals.blue) - i64::from(one.goals.pink);
                let stronger = if matches.iter().map(difference).sum::<i64>() < 0 { Team::Pink } else { Team::Blue };
                let of_match = |one: &&MatchMeasures| one.field.as_ref()?.possession[stronger];
                let shares: Vec<f64> = matches.iter().filter_map(of_match).collect();
                (!shares.is_empty()).then(|| 100.0 * shares.iter().sum::<f64>() / shares.len() as f64)
            },
        ),
        ratio(
            ["playing", "time in `playing`", "%", "share of `playing` in the time of `ready`, `set` and `playing`"],
            |one| Some(one.play_s),
            |one| Some(one.game_s),
            100.0,
        ),
        ratio(
            [
                "active",
                "active robots",
                "%",
                "share of the robots' time in `ready`, `set` and `playing` without a penalty",
            ],
            |one| Some(one.active_s),
            |one| Some(one.robot_s),
            100.0,
        ),
        mean(["messages", "messages a team", "", "team messages that a team sends in a match"], |one| {
            one.messages.map(|PerTeam { blue, pink }| f64::from(blue + pink) / 2.0)
        }),
    ]
}

fn penalties() -> Vec<Quantity> {
    let mut rows = vec![mean(
        ["penalties", "penalties a match", "", "penalties of both teams, those of a shoot-out left out"],
        |one| Some(f64::from(one.penalties.values().sum::<u32>())),
    )];
    rows.extend(PenaltyGroup::ALL.map(|group| {
        let [key, name] = group.words();
        let count = move |one: &MatchMeasures| Some(f64::from(one.penalties.get(&group).copied().unwrap_or_default()));
        let definition = format!("the same, of those for: {name}");
        mean(["", "", "", ""], count).named(format!("penalties.{key}"), format!("  {name}"), definition)
    }));
    rows
}

fn set_plays() -> Vec<Quantity> {
    use SetPlayKind::{CornerKick, GoalKick, IndirectFreeKick, KickIn, PenaltyKick, PushingFreeKick};
    let all = |one: &MatchMeasures| Some(f64::from(one.set_plays.values().sum::<u32>()));
    let mut rows = vec![mean(["set_plays", "set plays a match", "", "set plays of both teams without kick-offs"], all)];
    let kinds = [
        ("kick_in", KickIn),
        ("goal_kick", GoalKick),
        ("corner_kick", CornerKick),
        ("pushing_free_kick", PushingFreeKick),
        ("indirect_free_kick", IndirectFreeKick),
        ("penalty_kick", PenaltyKick),
    ];
    rows.extend(kinds.map(|(key, kind)| {
        let count = move |one: &MatchMeasures| Some(f64::from(one.set_plays.get(&kind).copied().unwrap_or_default()));
        let name = kind.words().to_lowercase();
        let definition = format!("the same, of this kind: {name}");
        mean(["", "", "", ""], count).named(format!("set_plays.{key}"), format!("  {name}"), definition)
    }));
    rows.push(mean(
        ["outs", "balls out", "", "balls that leave the pitch, goals left out"],
        field(|field| f64::from(field.outs)),
    ));
    rows
}

fn kicks(matches: &[MatchMeasures]) -> Vec<Quantity> {
    let mut rows = vec![
        mean(
            ["kicks", "kicks a match", "", "kicks of both teams that strike the ball"],
            field(|field| f64::from(field.all_kicks())),
        ),
        mean(
            ["kicks_missed", "  missed", "", "kicks that swing and miss the ball"],
            field(|field| f64::from(field.kicks_missed)),
        ),
    ];
    let kinds: BTreeSet<&String> =
        matches.iter().filter_map(|one| one.field.as_ref()).flat_map(|field| field.kicks.keys()).collect();
    rows.extend(kinds.into_iter().map(|kind| {
        let of_kind = kind.clone();
        let count = field(move |field| f64::from(field.kicks.get(&of_kind).copied().unwrap_or_default()));
        let share = ratio(["", "", "%", ""], count, field(|field| f64::from(field.all_kicks())), 100.0);
        let definition = format!("share of the kicks that strike the ball, of this kind: {kind}");
        share.named(format!("kicks.{kind}"), format!("  {}", kind.replace('_', " ")), definition)
    }));
    let ways: Sample = |field| &field.kick_ways_m;
    let definition = "how far from the kick's place the ball is when it is touched next, out, or play is stopped";
    rows.extend([
        quantile_of(["kick_way_5", "way of a kick, 5 %", "m", definition], ways, 0.05),
        quantile_of(["kick_way_50", "way of a kick, median", "m", definition], ways, 0.5),
        quantile_of(["kick_way_95", "way of a kick, 95 %", "m", definition], ways, 0.95),
    ]);
    let ends = [
        (NextTouch::Mate, "mate", "next touch by a team-mate"),
        (NextTouch::Opponent, "opponent", "  by an opponent"),
        (NextTouch::Kicker, "kicker", "  by the kicker"),
        (NextTouch::Out, "out", "  none: out"),
        (NextTouch::Goal, "goal", "  none: goal"),
        (NextTouch::Stopped, "stopped", "  none: play stopped"),
    ];
    rows.extend(ends.map(|(end, key, name)| {
        let count = field(move |field| f64::from(field.next_touches.get(&end).copied().unwrap_or_default()));
        let all = field(|field| f64::from(field.next_touches.values().sum::<u32>()));
        let definition = format!("share of the kicks that strike the ball, by what happens next: {}", name.trim());
        ratio(["", "", "%", ""], count, all, 100.0).named(format!("next_touch.{key}"), name.to_owned(), definition)
    }));
    rows
}

fn around_the_ball() -> Vec<Quantity> {
    let of_play =
        |words, part: fn(&FieldMeasures) -> f64, scale| ratio(words, field(part), |one| Some(one.play_s), scale);
    let before: Sample = |field| &field.near_before_kick_s;
    let before_kick = "how long the kicker has been within 0.5 m of the ball, or since its last kick";
    let first: Sample = |field| &field.first_touch_s;
    let first_touch = "time from the start of `playing` until a robot touches the ball";
    vec![
        quantile_of(["before_kick_50", "at the ball before a kick, median", "s", before_kick], before, 0.5),
        quantile_of(["before_kick_95", "at the ball before a kick, 95 %", "s", before_kick], before, 0.95),
        of_play(
            [
                "near_ball",
                "robots within 1 m of the ball",
                "",
                "mean number of upright robots within 1 m of the ball, in play",
            ],
            |field| field.robots_near_ball_s,
            1.0,
        ),
        of_play(
            [
                "four_near_ball",
                "four or more of them",
                "%",
                "share of the time in play with four robots or more within 1 m of the ball",
            ],
            |field| field.four_near_ball_s,
            100.0,
        ),
        of_play(
            [
                "left_alone",
                "four near, nobody plays it",
                "%",
                "share of the time in play in which the ball has rested untouched for 2 s with four robots or more within 1 m",
            ],
            |field| field.left_alone_s,
            100.0,
        ),
        of_play(
            [
                "contested",
                "both teams at the ball",
                "%",
                "share of the time in play with robots of both teams within 0.5 m of the ball",
            ],
            |field| field.contested_s,
            100.0,
        ),
        of_play(
            ["ball_rolls", "ball rolls", "%", "share of the time in play in which the ball is faster than 0.05 m/s"],
            |field| field.ball_rolls_s,
            100.0,
        ),
        of_play(
            [
                "ball_at_side",
                "ball at a side line",
                "%",
                "share of the time in play with the ball within 0.5 m of a side line",
            ],
            |field| field.ball_at_side_s,
            100.0,
        ),
        quantile_of(["first_touch_50", "`playing` to first touch, median", "s", first_touch], first, 0.5),
        quantile_of(["first_touch_95", "`playing` to first touch, 95 %", "s", first_touch], first, 0.95),
        mean(
            ["contacts_mates", "contacts of team-mates", "", "contacts of two robots of a team in play, a match"],
            field(|field| f64::from(field.contacts_of_mates)),
        ),
        mean(
            ["contacts_opponents", "contacts of opponents", "", "contacts of robots of both teams in play, a match"],
            field(|field| f64::from(field.contacts_of_opponents)),
        ),
    ]
}

fn walking_and_knowing() -> Vec<Quantity> {
    let percent = |words, share: fn(&FieldMeasures) -> Option<f64>| {
        mean(words, move |one| one.field.as_ref().and_then(share).map(|share| 100.0 * share))
    };
    vec![
        mean(
            ["walked", "way of a field player", "m", "mean distance of a field player in play, by its true speed"],
            |one| one.field.as_ref()?.field_player_distance_m,
        ),
        ratio(
            ["standing", "standing still", "%", "share of the upright field players' time in play below 0.02 m/s"],
            field(|field| field.standing_s),
            field(|field| field.field_player_s),
            100.0,
        ),
        percent(
            [
                "ball_seen",
                "robot sees the ball",
                "%",
                "share of the robots' time in play in which they recognise the ball",
            ],
            |field| field.ball_seen,
        ),
        ratio(
            ["ball_seen_3_m", "  within 3 m of it", "%", "the same, of robots within 3 m of the ball"],
            field(|field| field.seen_within_3_m_s),
            field(|field| field.near_3_m_s),
            100.0,
        ),
        percent(
            [
                "pose_off_half_m",
                "own place off by 0.5 m",
                "%",
                "share of the robots' time in play with a pose error over 0.5 m",
            ],
            |field| field.pose_over_half_m,
        ),
        percent(
            [
                "pose_off_1_m",
                "own place off by 1 m",
                "%",
                "share of the robots' time in play with a pose error over 1 m",
            ],
            |field| field.pose_over_1_m,
        ),
        mean_of(
            [
                "ball_unknown",
                "ball unknown until seen again",
                "s",
                "mean time in play in which no robot of a team sees the ball, of those over 1 s",
            ],
            |field| &field.ball_unknown_s,
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

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
                falls: [(FallCause::Walking, falls)].into(),
                walked_m,
                kick_ways_m: vec![f64::from(blue), 9.0],
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
            ("kick_way_95", 9.0),
            ("possession_stronger", 75.0),
            ("kicks.side", 75.0),
            ("penalties", 0.0),
        ] {
            assert_eq!(value(key, &matches), Some(expected), "{key}");
        }
        assert!((value("goals_sd", &matches).unwrap() - 8.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_was_not_measured_has_no_value() {
        let of_a_log = [MatchMeasures::default()];
        for key in ["falls_per_km", "kicks", "messages", "ball_seen", "kick_way_50", "playing", "outs"] {
            assert_eq!(value(key, &of_a_log), None, "{key}");
        }
        assert_eq!(value("goals", &of_a_log), Some(0.0));
    }
}

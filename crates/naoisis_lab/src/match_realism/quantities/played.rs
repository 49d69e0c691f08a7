//! Quantities of kicks, of the situation around the ball, and of the robots' walking and knowledge.

use std::collections::BTreeSet;

use super::forms::{Sample, field, mean, mean_of, quantile_of, ratio};
use crate::match_realism::estimates::Quantity;
use crate::match_realism::measures::{FieldMeasures, MatchMeasures, NextTouch};

pub(super) fn kicks(matches: &[MatchMeasures]) -> Vec<Quantity> {
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
    rows.push(ratio(
        ["passes_completed", "passes completed", "%", "share of the passes that a team-mate gets, as in summaries"],
        field(|field| f64::from(field.passes_completed)),
        field(|field| f64::from(field.passes)),
        100.0,
    ));
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

pub(super) fn around_the_ball() -> Vec<Quantity> {
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

pub(super) fn walking_and_knowing() -> Vec<Quantity> {
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

//! Quantities of goals, falls, time, penalties and set plays.

use super::forms::{Number, field, mean, mean_of, ratio};
use crate::match_realism::estimates::Quantity;
use crate::match_realism::measures::{MatchMeasures, PenaltyGroup};
use naoisis_core::events::FallCause;
use naoisis_core::game::SetPlayKind;
use naoisis_core::team::PerTeam;

pub(super) fn goals() -> Vec<Quantity> {
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

pub(super) fn falls() -> Vec<Quantity> {
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
                "falls of upright robots in play, by what these walked in play, steps under 10 cm left out",
            ],
            field(|field| f64::from(field.all_falls())),
            field(|field| field.walked_m),
            1000.0,
        ),
        of_cause(
            ["falls_walking", "  in walking", "", "the same, of falls by loss of balance in walking"],
            FallCause::Walking,
        ),
        of_cause(
            ["falls_collision", "  in collisions", "", "the same, of falls when a contact with a robot begins"],
            FallCause::Collision,
        ),
        of_cause(
            ["falls_contact", "  in lasting contact", "", "the same, of falls in contact with a robot that lasts"],
            FallCause::Contact,
        ),
        of_cause(
            ["falls_tripping", "  over lying robots", "", "the same, of falls over a robot that lies"],
            FallCause::Tripping,
        ),
        of_cause(["falls_kick", "  in kicks", "", "the same, of falls in kicks"], FallCause::Kick),
        of_cause(
            [
                "falls_getting_up",
                "failed to get up, a km",
                "",
                "the same, of attempts to get up that failed: these are no falls of upright robots",
            ],
            FallCause::GettingUp,
        ),
        ratio(
            [
                "falls_per_min",
                "falls a robot and minute",
                "",
                "falls of upright robots in play, by the time of robots in play without a penalty",
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
                "getting_up_front",
                "fallen until upright, front",
                "s",
                "mean time from a fall on the front until the robot stands, retries included",
            ],
            |field| &field.get_up_front_s,
        ),
        mean_of(
            [
                "getting_up_back",
                "fallen until upright, back",
                "s",
                "mean time from a fall on the back until the robot stands, retries included",
            ],
            |field| &field.get_up_back_s,
        ),
    ]
}

pub(super) fn possession_and_time() -> Vec<Quantity> {
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
        mean(
            [
                "possession_larger",
                "possession, larger of both",
                "%",
                "mean possession of the team that has the ball for longer",
            ],
            |one| {
                let PerTeam { blue, pink } = one.field.as_ref()?.possession;
                Some(100.0 * blue?.max(pink?))
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
        mean(
            [
                "messages",
                "messages a team",
                "",
                "team messages that a team sends in `ready`, `set` and `playing`, a match",
            ],
            |one| one.messages.map(|PerTeam { blue, pink }| f64::from(blue + pink) / 2.0),
        ),
    ]
}

pub(super) fn penalties() -> Vec<Quantity> {
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

pub(super) fn set_plays() -> Vec<Quantity> {
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
    rows.extend([
        mean(
            ["outs", "balls out", "", "balls that leave the pitch, goals left out"],
            field(|field| f64::from(field.outs)),
        ),
        mean(
            [
                "stuck_robots",
                "robots taken from a stuck ball",
                "",
                "robots that are removed as the game is stuck, penalised or not",
            ],
            field(|field| f64::from(field.stuck_robots)),
        ),
        mean(
            ["stuck_stops", "stops as the game is stuck", "", "stops of play as nobody plays the ball"],
            field(|field| f64::from(field.stuck_stops)),
        ),
    ]);
    rows
}

//! The first entry of a log: the parameters of the match.

use core::time::Duration;
use serde_json::{Value, json};

use super::dialect::Dialect;
use naoisis_agents::game_controller::{Division, TeamColours};
use naoisis_core::game::{PenaltyReason, Rules};
use naoisis_core::pitch::End;
use naoisis_core::team::{PerTeam, Team};
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::scenario::Scenario;

/// Returns the parameters of the match.
pub(super) fn parameters(
    scenario: &Scenario,
    record: &CycleRecord,
    colours: PerTeam<TeamColours>,
    dialect: Dialect,
) -> Value {
    let rules = &scenario.rules;
    let penalty = |name: &&'static str| {
        let is_none = matches!(*name, "noPenalty" | "substitute");
        let duration_s = match *name {
            "noPenalty" | "substitute" => 0.0,
            "motionInSet" => rules.motion_in_set_s.unwrap_or(rules.penalty_s),
            _ => rules.penalty_s,
        };
        let is_uncounted = rules.uncounted.iter().any(|reason| dialect.penalty(*reason)[1] == *name);
        let value = json!({ "duration": time(duration_s), "incremental": !is_none && !is_uncounted });
        ((*name).to_owned(), value)
    };
    let set_play = |name: &&'static str| {
        let [duration_s, ready_s] = match *name {
            "noSetPlay" => [0.0, 0.0],
            "kickOff" => [rules.kick_off_free_s.unwrap_or(10.0), rules.ready_s],
            "penaltyKick" => [rules.penalty_kick_s, rules.penalty_kick_ready_s],
            _ => [rules.free_kick_s, 0.0],
        };
        ((*name).to_owned(), json!({ "duration": time(duration_s), "readyDuration": time(ready_s) }))
    };
    let plays = |robot: &&RobotRecord| robot.penalised.is_none_or(|it| it.reason != PenaltyReason::Substitute);
    let players = |team: Team| record.robots.iter().filter(plays).filter(move |robot| robot.id.team == team);
    let largest = Team::BOTH.map(|team| players(team).count());
    let mut competition = json!({
        "name": scenario.league.as_deref().unwrap_or(&scenario.name),
        "playersPerTeam": largest[0].max(largest[1]),
        "penalties": dialect.penalties().iter().map(penalty).collect::<serde_json::Map<_, _>>(),
        "penaltyDurationIncrement": time(rules.penalty_increase_s),
        "setPlays": dialect.set_plays().iter().map(set_play).collect::<serde_json::Map<_, _>>(),
        "halfDuration": time(rules.half_s),
        "halfTimeBreakDuration": time(0.0),
        "timeoutDuration": time(rules.timeout_s),
        "timeoutsPerTeam": rules.timeouts,
        "refereeTimeoutDuration": time(rules.referee_timeout_s),
        "messagesPerTeam": message_budget(rules),
        "messagesPerTeamPerExtraMinute": 0,
        "mercyRuleScoreDifference": 10,
        "penaltyShots": 3,
        "suddenDeathPenaltyShots": 3,
        "penaltyShotDuration": time(rules.shoot_out_s),
    });
    let own = parameters_of(dialect, scenario);
    if let (Some(competition), Value::Object(own)) = (competition.as_object_mut(), own) {
        competition.extend(own);
    }
    let team = |team: Team| {
        let TeamColours { players, goalkeeper } = colours[team];
        json!({ "number": number_of(team), "fieldPlayerColor": players, "goalkeeperColor": goalkeeper })
    };
    let mut game = json!({
        "teams": { "home": team(Team::Blue), "away": team(Team::Pink) },
        "kickOffSide": "home",
        "sideMapping": sides(record.game.blue_end),
        "test": { "noDelay": true, "penaltyShootout": false },
    });
    if dialect == Dialect::StandardPlatform {
        game["long"] = json!(!rules.clock_runs_in_stoppages);
        game["test"]["unpenalize"] = json!(false);
    }
    json!({ "competition": competition, "game": game })
}

/// Returns the parameters of the competition that depend on the dialect.
fn parameters_of(dialect: Dialect, scenario: &Scenario) -> Value {
    let rules = &scenario.rules;
    match dialect {
        Dialect::StandardPlatform => json!({
            "challengeMode": null,
            "playersPerTeamFallbackMode": null,
            "delayAfterGoal": time(0.0),
            "delayAfterPlaying": time(0.0),
            "delayAfterReady": time(rules.standby_s),
            "hideKickingSide": false,
        }),
        Dialect::Humanoid => json!({
            "division": match Division::on(&scenario.field) {
                Division::Small => "small",
                Division::Middle => "middle",
                Division::Large => "large",
            },
            "extraHalfDuration": (rules.extra_time_halves > 0).then(|| time(rules.extra_half_s)),
            "delayAfterPlaying": null,
        }),
    }
}

/// Returns a duration as logs have it.
fn time(time_s: f32) -> Value {
    json!(Duration::from_secs_f32(time_s.max(0.0)))
}

pub(super) fn message_budget(rules: &Rules) -> u32 {
    rules.message_budget.unwrap_or(u16::MAX.into())
}

pub(super) fn sides(blue_end: End) -> &'static str {
    if blue_end == End::NegativeX { "homeDefendsLeftGoal" } else { "homeDefendsRightGoal" }
}

/// Returns the team's number in the log.
pub(super) fn number_of(team: Team) -> u8 {
    team as u8 + 1
}

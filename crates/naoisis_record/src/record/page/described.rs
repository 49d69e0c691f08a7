//! Describes the match, its events and its end for the page, in words and JSON objects.

use serde_json::{Value, json};

use crate::record::event_words::event_words;
use crate::record::match_summary::{CELLS_ALONG, MatchSummary};
use crate::record::recorder::MatchEnd;
use crate::record::summary_rows::{ROBOT_COLUMNS, maps, robot_rows, team_rows};
use naoisis_core::events::MatchEvent;
use naoisis_core::geometry::to_degrees;
use naoisis_core::team::{RobotId, Team};
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;

/// Returns the JSON of the first block: the pitch, the robots and the teams of the match, and the `fields` of its records, if they have only
/// some.
pub(super) fn match_of(scenario: &Scenario, robots: &[RobotId], fields: &Fields) -> Value {
    let teams = scenario.teams.as_ref().map(|teams| Team::BOTH.map(|team| teams.name(team).to_owned()));
    let robots: Vec<Value> = robots.iter().map(|id| robot_of(scenario, *id)).collect();
    json!({
        "match": 1,
        "name": scenario.name,
        "description": scenario.description,
        "seed": scenario.seed,
        "realism": scenario.realism_in_words(),
        "cycle_s": scenario.cycle_s,
        "pitch": scenario.field,
        "posts": scenario.posts,
        "ball_radius_m": scenario.ball.unwrap_or_default().radius_m,
        "ball_look": scenario.ball.unwrap_or_default().look,
        "teams": teams,
        "fields": fields.names(),
        "robots": robots,
    })
}

/// Describes a robot: its body, its look and its cameras.
fn robot_of(scenario: &Scenario, id: RobotId) -> Value {
    let spec = scenario.robot(id);
    let settings = scenario.settings_of(&spec);
    let mut body = json!(settings.body);
    body["look"] = json!(settings.body.look.fields());
    let common = &settings.cameras;
    let cameras: Vec<Value> = common
        .mounts
        .iter()
        .map(|mount| {
            json!({
                "name": mount.name,
                "lens_m": mount.lens_m,
                "tilt_deg": to_degrees(mount.tilt()),
                "pan_deg": to_degrees(mount.pan()),
                "diagonal_fov_deg": to_degrees(mount.diagonal_fov.unwrap_or(common.diagonal_fov)),
                "size": mount.size.unwrap_or([common.width, common.height]),
            })
        })
        .collect();
    let model = spec.model.as_ref().unwrap_or(&scenario.model);
    json!({ "id": id, "model": model, "body": body, "cameras": cameras })
}

/// Describes an event: its cycle, kind, sentence, robot or team, place, and the referee's reasons. Returns `None` for events that happen
/// all the time.
pub(super) fn event_of(cycle: u64, time_s: f64, event: &MatchEvent) -> Option<Value> {
    let (sentence, why) = event_words(time_s, event)?;
    let value = serde_json::to_value(event).unwrap_or_default();
    let about = ["robot", "team", "last_touch"].iter().find_map(|field| value[field].as_str()).unwrap_or_default();
    let place = if value["position_m"].is_null() { &value["evidence"]["position_m"] } else { &value["position_m"] };
    Some(json!([cycle, event.kind(), sentence, about, place, why]))
}

/// Returns the JSON of the last block: the end of the match, and the counts. A match that was recorded with some `fields` only has no tables.
pub(super) fn end_of(end: &MatchEnd, summary: &MatchSummary, fields: &Fields) -> Value {
    let maps = maps(summary).map(|(words, map, _)| {
        let tenths: Vec<u32> = map.time_s.iter().map(|time_s| (10.0 * time_s).round() as u32).collect();
        (words, tenths)
    });
    json!({
        "end": end.reason,
        "score": end.score,
        "how": end.result.and_then(|result| result.how()),
        "teams": if fields.is_all() { team_rows(summary) } else { Vec::new() },
        "robot_columns": ROBOT_COLUMNS,
        "robots": if fields.is_all() { robot_rows(summary) } else { Vec::new() },
        "heat": { "columns": CELLS_ALONG, "rows": summary.ball.rows, "maps": maps },
    })
}

//! Hints about valid models and scenarios that may not be what the user meant.

use bevy::math::Vec2;

use super::report;
use naoisis_core::kick_geometry::KickGeometry;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::Team;
use naoisis_sensing::sensing::camera::ball_in_view::{nearest_ball_seen_m, sees_ball};
use naoisis_sim::scenario::{Realism, RobotModel, RobotSettings, Scenario, ScenarioFile};

/// Returns hints about a model: what its cameras cannot see, and figures that its file lacks.
pub(super) fn of_model(model: &RobotModel) -> Vec<String> {
    let blindness = model.scenario().ok().and_then(|scenario| blindness_in(&scenario));
    [blindness, naos_measures(model), errors_left_open(model)].into_iter().flatten().collect()
}

/// Returns hints about a scenario: settings that do not apply to all robots, and figures that the files of its models lack although its
/// realism needs them.
pub(super) fn of_scenario(file: &ScenarioFile) -> Vec<String> {
    let mut notes = file.notes();
    let Scenario { model, robots, teams, realism, .. } = &file.scenario;
    if realism.parts().all(|(_, word)| word != Realism::Realistic) {
        return notes;
    }
    let of_teams = teams.iter().flat_map(|teams| Team::BOTH.map(|team| teams.robots[team].model.as_ref()));
    let of_robots = robots.iter().map(|robot| robot.model.as_ref());
    let mut models: Vec<&String> = of_teams.chain(of_robots).flatten().chain([model]).collect();
    models.sort();
    models.dedup();
    // Only models from files are checked, because the built-in ones are known.
    let files = models.into_iter().filter(|model| RobotModel::named(model).is_none());
    for model in files.filter_map(|model| RobotModel::find(model).ok()) {
        notes.extend(errors_left_open(&model).map(|words| format!("{}: {words}", model.name)));
    }
    notes
}

/// Prints notes to standard error.
pub(super) fn tell(notes: &[String]) {
    notes.iter().for_each(|words| report::note(&format!("note: {words}")));
}

/// Greatest number of figures that a note names.
const MOST_NAMED: usize = 8;

/// Returns a list of paths, shortened to the first ones if there are many.
fn some_of(paths: &[String]) -> Option<String> {
    let (named, others) = paths.split_at(paths.len().min(MOST_NAMED));
    if named.is_empty() {
        return None;
    }
    let others = if others.is_empty() { String::new() } else { format!(" and {} more", others.len()) };
    Some(format!("{}{others}", named.join(", ")))
}

/// Returns a note about figures of a model without a source.
pub(super) fn unsourced(model: &RobotModel) -> Option<String> {
    some_of(&model.without_source()).map(|paths| format!("`sources` has no source for: {paths}"))
}

/// Returns a note about figures that a custom model takes from the NAO.
fn naos_measures(model: &RobotModel) -> Option<String> {
    some_of(&model.measures_of_nao())
        .map(|paths| format!("the file leaves these out, so the NAO's figures are used: {paths}"))
}

/// Returns a note about a model that lacks figures for `realistic`.
fn errors_left_open(model: &RobotModel) -> Option<String> {
    let paths = some_of(&model.without_errors())?;
    Some(format!(
        "the file leaves these out, so a `realistic` match uses the paper's figures instead of a real robot's: {paths}"
    ))
}

/// Returns a note if the robot's cameras cannot see a ball that it could kick.
fn blindness_in(scenario: &Scenario) -> Option<String> {
    let Scenario { settings: RobotSettings { body, cameras, head, kicks, .. }, ball, .. } = scenario;
    if cameras.mounts.as_slice().is_empty() {
        return Some("it has no cameras: it sees no ball".to_owned());
    }
    let head = head.reached_from(HeadAngles::default());
    let radius_m = ball.unwrap_or_default().radius_m;
    // The best place of the ball, and the farthest one.
    let places = |region: KickGeometry| [region.best_m, Vec2::new(region.x_m[1], region.best_m.y)];
    let mut places = kicks.types().filter_map(|kick| kicks.geometry(kick)).flat_map(places).peekable();
    if places.peek().is_none() {
        return Some("it has no kicks: built-in teams push the ball".to_owned());
    }
    if places.any(|place| sees_ball(cameras, body, &head, place, radius_m)) {
        return None;
    }
    let nearest = match nearest_ball_seen_m(cameras, body, &head, radius_m) {
        Some(distance_m) => format!("the nearest ball that it can see straight ahead is {distance_m:.2} m away"),
        None => "it cannot see any ball straight ahead".to_owned(),
    };
    Some(format!(
        "its cameras cannot see a ball that it could kick: {nearest}; built-in teams kick at its last known position, other players may not"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::MODELS;

    #[test]
    fn who_sees_no_ball_at_its_feet_is_pointed_out() {
        for preset in MODELS {
            let scenario = RobotModel::named(preset.name).unwrap().scenario().unwrap();
            assert_eq!(blindness_in(&scenario), None, "{}", preset.name);
        }
        let words = |own: &str| {
            let text = format!(r#"{{ "model": {{ "preset": "booster_k1", {own} }}, "realism": "realistic" }}"#);
            blindness_in(&Scenario::from_json(&text).unwrap())
        };
        let level = words(r#""head": { "pitch_deg": [0, 0] }"#).unwrap();
        assert!(level.contains("the nearest ball that it can see straight ahead is 0.7"), "{level}");
        let up = words(r#""head": { "pitch_deg": [-80, -80] }"#).unwrap();
        assert!(up.contains("it cannot see any ball straight ahead"), "{up}");
        let fixed = words(r#""head": { "max_degps": 0 }, "cameras": { "mounts": [{ "name": "head", "position_m": [0.06, 0, 0.84] }] }"#).unwrap();
        assert!(fixed.contains("the nearest ball that it can see straight ahead is"), "{fixed}");
        let blind = words(r#""cameras": { "mounts": [] }"#).unwrap();
        assert!(blind.contains("it has no cameras"), "{blind}");
    }
}

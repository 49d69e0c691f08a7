//! Three localisation filters compared on the same seeds: their accuracy in a match, and whether they recover from a
//! kidnapping, in which the robot is carried elsewhere without notice.
//!
//! Run with `cargo run --release --no-default-features --example localisation`.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::math::{Vec2, ops};
use bevy::prelude::*;
use naoisis::belief::team_from_pitch;
use naoisis::game::Penalty;
use naoisis::geometry::{to_degrees, wrap_angle};
use naoisis::prelude::*;
use naoisis::statistics::median;

/// The numbers of matches and of kidnappings for each filter.
const MATCHES: u64 = 4;
const KIDNAPPINGS: u64 = 100;
/// The greatest errors with which a robot counts as localised: m, degrees.
const FOUND: [f32; 2] = [0.3, 15.0];
/// The time limit for recovering; the robot must then stay localised for a second, s.
const TIME_S: usize = 10;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    if common::view(
        r#"{ "localisation": "particles", "teams": { "blue": "roles", "pink": "chasers" } }"#,
        |_| {},
        |_| {},
    )? {
        return Ok(());
    }
    println!("filter      median error         found after {TIME_S} s   time to find, median");
    for localisation in ["kalman", "unscented", "particles"] {
        let [place, heading] = errors_in_matches(localisation);
        let times: Vec<f64> = (1..=KIDNAPPINGS).filter_map(|seed| time_to_find_itself(localisation, seed)).collect();
        let found = times.len();
        let time = median(times).unwrap_or(f64::NAN);
        println!(
            "{localisation:10}  {place:.3} m, {heading:.2} deg   {found:3} of {KIDNAPPINGS}           {time:.1} s"
        );
    }
    Ok(())
}

/// Starts a match of a scenario.
fn match_of(json: &str) -> App {
    let scenario = Scenario::from_json(json).unwrap_or_else(|error| panic!("{error}"));
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app.start_match(&scenario).unwrap_or_else(|fault| panic!("{fault}"));
    app
}

/// The errors of a robot's belief: m, degrees.
fn error(app: &App, id: RobotId) -> Option<[f32; 2]> {
    let truth = team_from_pitch(app.robot_pose(id)?, app.game().own_end(id.team));
    let belief = app.robot::<Belief>(id)?.pose;
    Some([truth.position.distance(belief.position), to_degrees(wrap_angle(truth.heading - belief.heading).abs())])
}

/// The median errors of all robots over whole matches with noisy sensors.
fn errors_in_matches(localisation: &str) -> [f64; 2] {
    let (mut places, mut headings) = (Vec::new(), Vec::new());
    for seed in 1..=MATCHES {
        let mut app = match_of(&format!(
            r#"{{ "seed": {seed}, "localisation": "{localisation}", "teams": {{ "blue": "roles", "pink": "chasers" }} }}"#
        ));
        while !app.is_finished() {
            app.run_cycles(30);
            let players = Team::BOTH.into_iter().flat_map(|team| (1..=3).map(move |number| RobotId::new(team, number)));
            for id in players.filter(|id| !app.robot::<Penalty>(*id).is_some_and(Penalty::is_active)) {
                let Some([place, heading]) = error(&app, id) else { continue };
                places.push(f64::from(place));
                headings.push(f64::from(heading));
            }
        }
    }
    [median(places).unwrap_or_default(), median(headings).unwrap_or_default()]
}

/// Carries a playing robot elsewhere. Returns the time until it is localised again, s, if it is in time.
fn time_to_find_itself(localisation: &str, seed: u64) -> Option<f64> {
    let robot = RobotId::new(Team::Blue, 2);
    let mut app = match_of(&format!(
        r#"{{ "seed": {seed}, "rules": "free", "localisation": "{localisation}", "ball": {{ "position_m": [0.5, 0.3] }},
             "robots": [{{ "number": 2, "pose": [-1, 0, 0], "behaviour": "striker" }}] }}"#
    ));
    app.run_cycles(60);
    let angle = seed as f32 * 2.399_963;
    let place = Vec2::new(2.3 * ops::sin(angle * 1.7), 1.5 * ops::cos(angle));
    let pose = Pose { position: place, heading: wrap_angle(3.0 * angle) };
    app.world_mut().commands().queue(Intervention::PlaceRobot { robot, pose });
    app.world_mut().flush();
    app.run_cycles(1);
    let carried = app.cycle();
    // A lucky moment does not count: the robot must stay localised for a second.
    let mut known_for = 0;
    let found = |app: &App| {
        let knows = error(app, robot).is_some_and(|error| error[0] < FOUND[0] && error[1] < FOUND[1]);
        known_for = if knows { known_for + 1 } else { 0 };
        known_for == 30
    };
    app.run_until((TIME_S + 1) * 30, found).then(|| (app.cycle() - carried) as f64 / 30.0 - 1.0)
}

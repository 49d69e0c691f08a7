//! Random numbers of behaviours: they follow from the seed and the robot, and are saved with a match.

use bevy::prelude::*;
use naoisis::prelude::*;
use naoisis::simulation::Snapshot;

use crate::support::{blue, headless_app};

#[derive(Component, Default)]
#[require(BehaviourRandom)]
struct Gambler;

/// Draws a number in each cycle, and turns the head by it.
fn gamble(mut robots: Query<(&mut BehaviourRandom, &mut HeadCommand), With<Gambler>>) {
    for (mut random, mut head) in &mut robots {
        head.yaw = random.uniform();
    }
}

fn casino(seed: u64) -> App {
    let mut app = headless_app();
    app.add_behaviour::<Gambler, _>("gambler", gamble);
    let scenario = r#"{ "rules": "free", "robots": [
        { "number": 1, "behaviour": "gambler" }, { "number": 2, "pose": [1, 0, 0], "behaviour": "gambler" }] }"#;
    let scenario = Scenario::from_json(scenario).unwrap();
    app.start_match(&Scenario { seed, ..scenario }).unwrap();
    app
}

/// What a robot draws in the next cycles.
fn draws(app: &mut App, number: u8) -> Vec<f32> {
    let draw = |app: &mut App| app.run_cycles(1).robot::<HeadCommand>(blue(number)).unwrap().yaw;
    (0..5).map(|_| draw(app)).collect()
}

#[test]
fn a_behaviour_draws_by_the_seed_and_the_robot() {
    let first = draws(&mut casino(1), 1);
    assert_eq!(draws(&mut casino(1), 1), first);
    assert_ne!(draws(&mut casino(2), 1), first);
    assert_ne!(draws(&mut casino(1), 2), first);
    assert!(first.windows(2).all(|pair| pair[0] != pair[1]), "{first:?}");
}

#[test]
fn the_draws_of_a_saved_match_go_on_or_are_those_of_another_seed() {
    let mut app = casino(1);
    app.run_cycles(10);
    let saved = Snapshot::take(app.world_mut()).unwrap();
    let next = draws(&mut app, 1);
    saved.restore(app.world_mut()).unwrap();
    assert_eq!(draws(&mut app, 1), next);
    saved.restore_with_chance(app.world_mut(), 7).unwrap();
    assert_ne!(draws(&mut app, 1), next);
}

#[test]
fn a_behaviour_may_not_draw_from_the_streams_of_its_sensors() {
    use naoisis::random::RandomStreams;

    fn foresee(mut robots: Query<(&mut RandomStreams, &mut HeadCommand), With<Gambler>>) {
        for (mut streams, mut head) in &mut robots {
            head.yaw = streams.vision.uniform();
        }
    }
    let refusal = headless_app().try_add_behaviour::<Gambler, _>("seer", foresee).err().unwrap().to_string();
    assert!(refusal.contains("RandomStreams`, which is ground truth"), "{refusal}");
    assert!(refusal.contains("draws from the `BehaviourRandom`"), "{refusal}");
}

//! Matches that are saved and go on later.

use bevy::prelude::*;
use naoisis::prelude::*;
use naoisis::simulation::{Snapshot, SnapshotError};
use proptest::prelude::*;

use crate::support::{blue, headless_app, match_of};

fn state(app: &mut App) -> Vec<u8> {
    Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap()
}

fn noisy_match(name: &str, seed: u64) -> App {
    let mut scenario = Scenario::named(name).unwrap();
    scenario.seed = seed;
    scenario.messages.loss = 0.3;
    scenario.messages.jitter_cycles = 5;
    scenario.settings.kicks.direction_sd = 0.05;
    scenario.settings.motion.error_sd.dx_m = 0.001;
    let mut app = headless_app();
    app.start_match(&scenario).unwrap();
    app
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..default() })]

    #[test]
    fn a_saved_match_goes_on_bit_for_bit(seed in prop_oneof![Just(u64::MAX), any::<u64>()], before in 0..400_usize, after in 1..200_usize) {
        let mut app = noisy_match(if seed % 2 == 0 { "match3v3" } else { "match7v7" }, seed);
        app.run_cycles(before);
        let saved = state(&mut app);
        let ending = state(app.run_cycles(after));

        // In the same world, and in another that has played something else.
        let snapshot = Snapshot::from_bytes(&saved, app.world()).unwrap();
        snapshot.restore(app.world_mut()).unwrap();
        prop_assert!(state(&mut app) == saved);
        prop_assert!(state(app.run_cycles(after)) == ending);

        let mut other = noisy_match("match3v3", 77);
        other.run_cycles(20);
        Snapshot::from_bytes(&saved, other.world()).unwrap().restore(other.world_mut()).unwrap();
        prop_assert!(state(other.run_cycles(after)) == ending);
    }

    #[test]
    fn a_match_with_any_seed_and_any_counts_is_saved_and_restored(
        seed in any::<u64>(), score in any::<[u32; 2]>(), left in prop_oneof![Just(u32::MAX), any::<u32>()],
    ) {
        let scenario = format!(
            r#"{{ "seed": {seed}, "ball": {{ "position_m": [2.5, 0], "velocity_mps": [2, 0] }},
                 "rules": {{ "preset": "extended", "half_s": 300, "message_budget": {left} }},
                 "interventions": [{{ "at_s": 0, "do": {{ "set_score": {{ "blue": {}, "pink": {} }} }} }}],
                 "robots": [{{ "number": 1 }}, {{ "team": "pink", "number": 1, "pose": [-1, 0, 0] }}] }}"#,
            score[0], score[1]
        );
        let mut app = match_of(&scenario);
        app.run_cycles(60);
        // A goal was scored: the largest count stays where it is.
        prop_assert_eq!(app.world().resource::<naoisis::game::Game>().score.blue, score[0].saturating_add(1));
        let saved = state(&mut app);
        let ending = state(app.run_cycles(60));
        let mut other = headless_app();
        Snapshot::from_bytes(&saved, other.world()).unwrap().restore(other.world_mut()).unwrap();
        prop_assert!(state(other.run_cycles(60)) == ending);
    }
}

#[derive(Component, Default, Reflect)]
#[reflect(Component)]
struct Steps(u32);

#[derive(Component, Default)]
#[require(Steps)]
struct Walker;

fn walk(mut robots: Query<(&mut WalkCommand, &mut Steps), With<Walker>>) {
    for (mut command, mut steps) in &mut robots {
        steps.0 += 1;
        command.dx = 0.001 * steps.0 as f32;
    }
}

fn walkers() -> App {
    let mut app = headless_app();
    app.register_type::<Steps>().add_behaviour::<Walker, _>("walker", walk);
    app
}

#[test]
fn a_users_behaviour_and_its_memory_are_saved() {
    let mut app = walkers();
    let scenario = Scenario::from_json(r#"{ "rules": "free", "robots": [{ "behaviour": "walker" }] }"#).unwrap();
    app.start_match(&scenario).unwrap().run_cycles(4);
    let saved = Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();

    let mut other = walkers();
    Snapshot::from_bytes(&saved, other.world()).unwrap().restore(other.world_mut()).unwrap();
    other.run_cycles(1);
    assert_eq!(other.robot::<Steps>(blue(1)).unwrap().0, 5);
    assert_eq!(other.robot_pose(blue(1)), app.run_cycles(1).robot_pose(blue(1)));

    // Who has no such behaviour is told so.
    let mut without = headless_app();
    without.register_type::<Steps>();
    let snapshot = Snapshot::from_bytes(&saved, without.world()).unwrap();
    assert!(matches!(snapshot.restore(without.world_mut()), Err(SnapshotError::NoBehaviour(name)) if name == "walker"));
    let unknown_type = Snapshot::from_bytes(&saved, headless_app().world()).err().unwrap();
    assert!(unknown_type.to_string().contains("Steps"), "{unknown_type}");
}

#[test]
fn a_memory_that_cannot_be_saved_is_named() {
    #[derive(Component, Default)]
    struct Forgotten(#[expect(dead_code, reason = "it only has to be there")] u32);
    #[derive(Component, Default)]
    #[require(Forgotten)]
    struct Dreamer;

    let mut app = headless_app();
    app.add_behaviour::<Dreamer, _>("dreamer", |_: Query<&Forgotten, With<Dreamer>>| {});
    app.start_match(&Scenario::from_json(r#"{ "robots": [{ "behaviour": "dreamer" }] }"#).unwrap()).unwrap();
    let error = Snapshot::take(app.world_mut()).err().unwrap().to_string();
    assert!(error.contains("Forgotten") && error.contains("register_type"), "{error}");
}

#[test]
fn a_file_that_is_no_snapshot_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut app = noisy_match("match3v3", 1);
    let path = folder.path().join("match.naoisis");
    Snapshot::take(app.world_mut()).unwrap().save(&path, app.world()).unwrap();
    assert!(Snapshot::load(&path, app.world()).is_ok());
    let whole = std::fs::read(&path).unwrap();
    for wrong in [&b""[..], b"{}", b"hello", &whole[..whole.len() / 2], &[&whole[..], b"more"].concat()] {
        std::fs::write(&path, wrong).unwrap();
        let error = Snapshot::load(&path, app.world()).err().unwrap();
        assert!(matches!(error, SnapshotError::NotASnapshot { .. }), "{error}");
    }
    #[cfg(unix)]
    {
        let endless = folder.path().join("endless.naoisis");
        std::os::unix::fs::symlink("/dev/zero", &endless).unwrap();
        let error = Snapshot::load(&endless, app.world()).err().unwrap();
        assert!(error.to_string().ends_with("endless.naoisis: this is no ordinary file"), "{error}");
    }
    let missing = Snapshot::load(&folder.path().join("nowhere.naoisis"), app.world()).err().unwrap();
    assert!(matches!(missing, SnapshotError::Io { .. }), "{missing}");
}

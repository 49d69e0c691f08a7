//! Learned policies in ONNX as players.

use bevy::prelude::*;
use naoisis::policy::network::{Network, Tensor};
use naoisis::policy::{LoadedPolicy, PolicyPlugin, PolicyState};
use naoisis::prelude::*;
use naoisis::robot::Roster;
use naoisis::simulation::Snapshot;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

use crate::support::{blue, headless_app, naoisis, text};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/policies");
const SCORE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/policies/score_empty_goal.onnx");

#[test]
fn networks_answer_as_in_onnx_runtime() {
    for name in ["mlp_59_32_32_6_tanh", "gru_policy"] {
        let network = Network::read(&fs::read(format!("{FOLDER}/{name}.onnx")).unwrap()).unwrap();
        let cases: Value = serde_json::from_slice(&fs::read(format!("{FOLDER}/{name}.json")).unwrap()).unwrap();
        let numbers = |values: &Value| -> Vec<f32> { serde_json::from_value(values.clone()).unwrap() };
        for case in cases["cases"].as_array().unwrap() {
            let inputs = network.inputs().iter().map(|port| {
                let shape = port.shape.iter().map(|length| length.unwrap_or(1)).collect();
                Tensor { shape, values: numbers(&case["inputs"][&port.name]) }
            });
            let outputs = network.run(&inputs.collect::<Vec<_>>()).unwrap();
            for (port, output) in network.outputs().iter().zip(outputs) {
                let expected = numbers(&case["outputs"][&port.name]);
                assert_eq!(output.values.len(), expected.len());
                let worst = output.values.iter().zip(&expected).map(|(ours, theirs)| (ours - theirs).abs());
                assert!(worst.fold(0.0, f32::max) < 1e-5, "{name}");
            }
        }
    }
    let error = Network::read(&fs::read(format!("{FOLDER}/unsupported_erf.onnx")).unwrap()).unwrap_err().to_string();
    assert!(error.contains("n2_Erf") && error.contains("Erf") && error.contains("Gemm"), "{error}");
}

/// The match of a robot with this behaviour before an empty goal.
fn before_the_goal(behaviour: &Value, seed: u64) -> Scenario {
    let scenario = json!({
        "seed": seed, "rules": { "preset": "free", "goals": true }, "ball": { "position_m": [1.6, 0.3] },
        "robots": [{ "number": 1, "pose": [0.2, -0.2, 20], "behaviour": behaviour }],
    });
    Scenario::from_json(&scenario.to_string()).unwrap()
}

#[test]
fn a_learned_policy_scores_in_the_challenge_for_which_it_was_made() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["challenge", "ScoreEmptyGoal", "--policy", SCORE, "--episodes", "40", "--out", "results.json"];
    let output = naoisis(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let results: Value = serde_json::from_slice(&fs::read(folder.path().join("results.json")).unwrap()).unwrap();
    let successes = results["results"][0]["episodes"].as_array().unwrap().iter();
    let successes = successes.filter(|episode| episode["is_success"] == true).count();
    // Its success rate is 90 %: fewer than 29 of 40 have a probability of 0.1 %.
    assert!(successes >= 29, "{successes} of 40");
    let verified = naoisis(folder.path(), &["challenge", "--verify", "results.json"]);
    assert!(verified.status.success(), "{}", text(&verified.stdout));
}

/// The result of a player in a challenge.
fn result(folder: &Path, task: &[&str], player: [&str; 2]) -> Value {
    let output = naoisis(folder, &[&["challenge"], task, &player, &["--out", "results.json", "--force"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let results: Value = serde_json::from_slice(&fs::read(folder.join("results.json")).unwrap()).unwrap();
    results["results"][0].clone()
}

#[test]
fn a_clone_of_the_passers_scores_into_an_empty_goal_and_is_the_policy_of_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let task = ["ScoreEmptyGoal", "--realism", "realistic", "--episodes", "20"];
    let episodes = |player| result(folder.path(), &task, player)["episodes"].as_array().unwrap().clone();
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/policies/passers_clone.onnx");
    let [built_in, of_file] = [["--behaviour", "passers_clone"], ["--policy", file]].map(episodes);
    assert_eq!(built_in, of_file);
    let successes = built_in.iter().filter(|episode| episode["is_success"] == true).count();
    // Its success rate is 92 %: fewer than 14 of 20 have a probability of 0.1 %.
    assert!(successes >= 14, "{successes} of 20");
}

#[test]
fn a_match_with_a_policy_is_saved_with_its_state_and_repeats_itself() {
    // A policy that follows other robots keeps them, too.
    let folder = tempfile::tempdir().unwrap();
    let following = folder.path().join("following.onnx");
    fs::copy(SCORE.replace("score_empty_goal", "passers_clone"), &following).unwrap();
    let layout = fs::read_to_string(SCORE.replace("score_empty_goal.onnx", "passers_clone.json")).unwrap();
    let mut layout: Value = serde_json::from_str(&layout).unwrap();
    layout["extras"] = json!({ "tracked": true });
    fs::write(folder.path().join("following.json"), layout.to_string()).unwrap();
    let following = json!({ "policy": following.to_str().unwrap() });
    for behaviour in [json!({ "policy": SCORE }), json!("learned"), json!("passers_clone"), following] {
        a_match_of_a_policy_repeats_itself(&behaviour);
    }
}

fn a_match_of_a_policy_repeats_itself(behaviour: &Value) {
    let scenario = before_the_goal(behaviour, 5);
    let mut app = headless_app();
    app.add_plugins(PolicyPlugin);
    app.start_match(&scenario).unwrap().run_cycles(61);
    let saved = Snapshot::take(app.world_mut()).unwrap();
    let pose = |app: &mut App| app.run_cycles(100).robot_pose(blue(1)).unwrap();
    let expected = pose(&mut app);
    assert!(expected.position.distance(Vec2::new(0.2, -0.2)) > 0.02, "{expected:?}");
    saved.restore(app.world_mut()).unwrap();
    assert_eq!(pose(&mut app), expected);
    let mut again = headless_app();
    again.add_plugins(PolicyPlugin);
    again.start_match(&scenario).unwrap().run_cycles(61);
    assert_eq!(pose(&mut again), expected);
}

#[test]
fn what_is_wrong_with_a_policy_is_said_before_the_match() {
    let folder = tempfile::tempdir().unwrap();
    let start = |behaviour: Value| {
        let mut app = headless_app();
        app.add_plugins(PolicyPlugin);
        app.start_match(&before_the_goal(&behaviour, 1)).err().map(|fault| fault.to_string()).unwrap_or_default()
    };
    let network = folder.path().join("p.onnx");
    let policy = json!({ "policy": network.to_str().unwrap() });
    assert!(start(policy.clone()).contains("p.onnx: No such file"), "{}", start(policy.clone()));
    fs::copy(format!("{FOLDER}/gru_policy.onnx"), &network).unwrap();
    assert!(start(policy.clone()).contains("a policy needs its layout"), "{}", start(policy.clone()));
    let with_layout = |layout: Value| {
        fs::write(folder.path().join("p.json"), layout.to_string()).unwrap();
        start(policy.clone())
    };
    let state = json!([{ "input": "h_in", "output": "h_out" }]);
    for (layout, expected) in [
        (json!({ "observation": "truth", "action": "discrete" }), "players know no `truth`"),
        (json!({ "observation": "belief", "action": "discrete" }), "several inputs"),
        (
            json!({ "observation": "belief", "action": "discrete", "state": [{ "input": "h", "output": "h_out" }] }),
            "no input `h`",
        ),
        (
            json!({ "observation": "belief", "action": "discrete", "state": state, "cycles_per_step": 0 }),
            "expected 1 to 1000",
        ),
        (json!({ "observation": "belief", "action": "walks" }), "unknown variant `walks`"),
        (
            json!({ "observation": "belief", "action": "velocities", "state": state }),
            "numbers; expected 20 scores or 4 choices of its `action`",
        ),
        (
            json!({ "observation": "belief", "action": "discrete", "state": state, "extras": { "words": 1 } }),
            "`extras.words`: an action `discrete` is one choice",
        ),
        (json!({ "observation": "belief", "action": "discrete", "extras": { "sets": 1 } }), "unknown field `sets`"),
        (
            json!({ "observation": "belief", "action": "discrete", "opponents": 1 }),
            "one of `team_mates` and `opponents`",
        ),
    ] {
        let error = with_layout(layout);
        assert!(error.contains(expected), "{error}");
    }
    fs::write(&network, b"not a network").unwrap();
    assert!(start(policy.clone()).contains("p.onnx: "), "{}", start(policy));
    // Without the plugin nobody plays policies.
    let fault = headless_app().start_match(&before_the_goal(&json!({ "policy": SCORE }), 1)).err().unwrap().to_string();
    assert!(fault.contains("plays no learned policies"), "{fault}");
    assert!(LoadedPolicy::read(Path::new(SCORE)).unwrap().to_string().contains("the observation `belief`"));
}

#[test]
fn the_team_that_learned_plays_in_matches_of_any_size() {
    let folder = tempfile::tempdir().unwrap();
    for scenario in ["match3v3", "match7v7", "hsl2026_small"] {
        let arguments = ["run", scenario, "--blue", "learned", "--pink", "learned", "--duration", "3"];
        let output = naoisis(folder.path(), &arguments);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(output.status.success() && !said.contains("lost"), "{said}");
    }
}

#[test]
fn the_observation_of_a_policy_is_that_of_its_layout() {
    let scenario = json!({
        "rules": "free", "ball": { "position_m": [1.0, 0.0] },
        "robots": [
            { "number": 1, "pose": [0.0, 0.0, 0], "behaviour": "learned" },
            { "team": "pink", "number": 1, "pose": [1.6, 0.2, 180], "behaviour": "idle" },
        ],
    });
    let mut app = headless_app();
    app.add_plugins(PolicyPlugin);
    app.start_match(&Scenario::from_json(&scenario.to_string()).unwrap()).unwrap().run_cycles(30);
    let robot = app.world().resource::<Roster>().get(blue(1)).unwrap();
    let state = format!("{:?}", app.world().get::<PolicyState>(robot).unwrap());
    for expected in
        [r#""ball.known": 1.0"#, r#""opponent1.known": 1.0"#, r#""opponent3.x": 0.0"#, r#""team_mate2.known": 0.0"#]
    {
        assert!(state.contains(expected), "{expected} in {state}");
    }
}

#[test]
fn a_policy_for_another_number_of_robots_is_lost_with_words() {
    let folder = tempfile::tempdir().unwrap();
    let team = format!("policy:{SCORE}");
    let output = naoisis(folder.path(), &["run", "match3v3", "--blue", &team, "--duration", "1"]);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert!(said.contains("the policy reads 38 numbers"), "{said}");
}

//! Tasks for whatever learns, from the command line.

use crate::programs::path_of;
use crate::support::{naoisis, text};
use serde_json::Value;
use std::fs;

#[test]
fn a_challenge_tells_how_often_it_succeeds() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["challenge", "ScoreEmptyGoal", "--behaviour", "striker", "--episodes", "6", "--out", "rates.json"];
    let output = naoisis(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let words = text(&output.stdout);
    assert!(words.contains("ScoreEmptyGoal-v0, realism paper: A robot before an empty goal"), "{words}");
    let rates: Value = serde_json::from_slice(&fs::read(folder.path().join("rates.json")).unwrap()).unwrap();
    let result = &rates["results"][0];
    assert_eq!((&result["player"], &result["realism"]), (&"striker".into(), &"paper".into()));
    let rate = &result["rate"];
    assert_eq!(rate["episodes"], 6);
    assert!(rate["successes"].as_u64().unwrap() >= 5 && rate["mean_time_s"].as_f64().unwrap() > 3.0, "{rate}");
    assert_eq!(result["episodes"].as_array().unwrap().len(), 6);
    // Nothing is written over unasked.
    let again = naoisis(folder.path(), &arguments);
    assert_eq!(again.status.code(), Some(2));
}

#[test]
fn a_challenge_that_cannot_be_played_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, words) in [
        (&["ScoreGoal"][..], "there is no challenge `ScoreGoal`; expected one of FindBall"),
        (&["TwoOnTwo", "--behaviour", "nobody"], "nobody"),
        (&["TwoOnTwo", "--team", "nobody"], "there is no team `nobody`; expected one of chasers"),
        (&["TwoOnTwo", "--team", "roles", "--behaviour", "striker"], "cannot be used with"),
        (&["TwoOnTwo", "--episodes", "0"], "0 is not in 1..=1000000"),
        (&["TwoOnTwo", "--realism", "true"], "expected one of paper, ideal, realistic"),
        (&["TwoOnTwo", "--robot", "naq"], "there is no model `naq`"),
        (&["TwoOnTwo", "--team", "exec:"], "names no program"),
        (&["TwoOnTwo", "--behaviour", "random", "--scenario", "new.json"], "decides outside of the match"),
        (&["all", "--scenario", "new.json"], "expected one task"),
        (&["TwoOnTwo", "--scenario", "new.json"], "--scenario: expected one player"),
        (&["--verify", "results.json", "--realism", "ideal"], "cannot be used with"),
        (&["GoToBall", "--seed", "18446744073709551615", "--episodes", "2"], "--seed: 2 episodes have seeds beyond"),
        (&["all", "--watch", "3"], "--watch: expected one task"),
        (&["TwoOnTwo", "--behaviour", "random", "--watch", "3"], "decides outside of the match"),
        #[cfg(unix)]
        (
            &["FindBall", "--team", "exec:true", "--episodes", "1"],
            "the program of blue1 was lost in the episode of seed 1",
        ),
    ] {
        let output = naoisis(folder.path(), &[&["challenge"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("panicked"));
    }
}

#[test]
fn policies_of_one_method_have_a_common_score() {
    let folder = tempfile::tempdir().unwrap();
    let policy = |name: &str| format!("{}/assets/policies/{name}.onnx", env!("CARGO_MANIFEST_DIR"));
    let [one, other] = ["score_empty_goal", "striker"].map(policy);
    let played = ["challenge", "ScoreEmptyGoal", "--episodes", "2", "--policy", &one, "--policy", &other];
    let output = naoisis(folder.path(), &[&played[..], &["--out", "method.json"]].concat());
    let words = text(&output.stdout);
    assert!(output.status.success() && words.contains("\n2 policies: mean "), "{words}");
    let table = naoisis(folder.path(), &["leaderboard", ".", "--html", "table.html"]);
    let words = text(&table.stdout);
    assert!(table.status.success() && words.contains("\nmethod.json, 2 policies: mean "), "{words}");
    assert!(words.contains("2498560, large") && words.contains("3227648, large"), "{words}");
    assert!(fs::read_to_string(folder.path().join("table.html")).unwrap().contains("<p>method.json, 2 policies"));
    // Interactions that a file claims are those of the policies' layouts.
    let results = fs::read_to_string(folder.path().join("method.json")).unwrap().replacen("2498560", "900000", 1);
    fs::write(folder.path().join("method.json"), results).unwrap();
    let verified = naoisis(folder.path(), &["challenge", "--verify", "method.json"]);
    let words = text(&verified.stdout);
    let expected = "interactions: 900000 in the file, 2498560 in the layout";
    assert!(!verified.status.success() && words.contains(expected), "{words}");
    assert!(words.contains("striker.onnx: the same in 2 episodes"), "{words}");
}

#[test]
fn results_are_verified_and_make_a_table_without_those_that_are_changed() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| naoisis(folder.path(), arguments);
    let players = ["--behaviour", "chaser", "--behaviour", "open loop of chaser", "--behaviour", "idle"];
    let played = ["challenge", "FindBall", "--realism", "ideal", "--episodes", "4", "--record", "--out", "good.json"];
    let output = run(&[&played[..], &players].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = run(&["challenge", "--verify", "good.json"]);
    assert!(output.status.success());
    assert!(text(&output.stdout).contains("FindBall-v2, ideal, open loop of chaser: the same in 4 episodes"));

    let mut results: Value = serde_json::from_slice(&fs::read(folder.path().join("good.json")).unwrap()).unwrap();
    results["results"][1]["episodes"][2]["end_state"] = "0123456789abcdef".into();
    fs::write(folder.path().join("changed.json"), results.to_string()).unwrap();
    let output = run(&["challenge", "--verify", "changed.json"]);
    assert_eq!(output.status.code(), Some(1));
    let words = text(&output.stdout);
    assert!(words.contains("open loop of chaser: differs at episode 3 (seed 1000000003): "), "{words}");
    // Another player's result is another one from the first steps on.
    let mut results: Value = serde_json::from_slice(&fs::read(folder.path().join("good.json")).unwrap()).unwrap();
    results["results"][0]["episodes"] = results["results"][2]["episodes"].clone();
    results["results"][0]["rate"] = results["results"][2]["rate"].clone();
    fs::write(folder.path().join("another.txt"), results.to_string()).unwrap();
    let output = run(&["challenge", "--verify", "another.txt"]);
    let words = text(&output.stdout);
    assert!(words.contains("with robots or ball elsewhere from 0."), "{words}");

    fs::write(folder.path().join("torn.json"), "{\"results\": [").unwrap();
    fs::write(folder.path().join("empty.json"), "{\"results\": []}").unwrap();
    let output = run(&["leaderboard", ".", "--verify", "--json", "table.txt", "--html", "table.html"]);
    assert_eq!(output.status.code(), Some(1));
    let errors = text(&output.stderr);
    assert!(errors.contains("left out: ./changed.json: it is not confirmed"), "{errors}");
    assert!(errors.contains("left out: ./torn.json: this is no file of results"), "{errors}");
    assert!(errors.contains("left out: ./empty.json: there are no results in it"), "{errors}");
    let table: Value = serde_json::from_slice(&fs::read(folder.path().join("table.txt")).unwrap()).unwrap();
    let players: Vec<&Value> = table.as_array().unwrap().iter().map(|row| &row["player"]).collect();
    assert_eq!((players.len(), players[0]), (3, &"chaser".into()));
    assert!(fs::read_to_string(folder.path().join("table.html")).unwrap().contains("<td>chaser</td>"));
}

#[test]
fn files_that_a_command_reads_are_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| naoisis(folder.path(), arguments);
    for file in ["striker.onnx", "striker.json"] {
        let policy = format!("{}/assets/policies/{file}", env!("CARGO_MANIFEST_DIR"));
        fs::copy(policy, folder.path().join(file)).unwrap();
    }
    let played = ["challenge", "ScoreEmptyGoal", "--policy", "striker.onnx", "--episodes", "1", "--force"];
    for output in [["--out", "striker.json"], ["--out", "striker.onnx"], ["--scenario", "striker.json"]] {
        let output = run(&[&played[..], &output].concat());
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stderr).contains("which the command reads"), "{}", text(&output.stderr));
    }
    let team = ["run", "match3v3", "--blue", "policy:striker.onnx", "--trace", "striker.onnx", "--force"];
    assert!(text(&run(&team).stderr).contains("which the command reads"));
    let output = run(&[&played[..], &["--out", "result.json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = run(&["leaderboard", ".", "--json", "result.json", "--force"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("which the command reads"), "{}", text(&output.stderr));
    // An episode that is written into another folder finds the policy.
    fs::create_dir(folder.path().join("episodes")).unwrap();
    let output = run(&[&played[..], &["--scenario", "episodes/one.json"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let output = run(&["run", "episodes/one.json", "--duration", "0.5"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    fs::create_dir(folder.path().join("empty")).unwrap();
    let output = run(&["leaderboard", "empty"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("no files of results"), "{}", text(&output.stderr));
}

#[test]
fn a_player_with_nothing_to_play_back_does_not_end_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let players = ["--behaviour", "open loop of idle", "--behaviour", "idle"];
    let task = ["challenge", "InterceptBall", "--episodes", "2", "--out", "results.json"];
    let output = naoisis(folder.path(), &[&task[..], &players].concat());
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("nothing to play back"), "{}", text(&output.stderr));
    let results: Value = serde_json::from_slice(&fs::read(folder.path().join("results.json")).unwrap()).unwrap();
    assert_eq!((results["results"].as_array().unwrap().len(), &results["results"][0]["player"]), (1, &"idle".into()));
}

#[test]
fn an_episode_is_a_scenario_that_goes_the_same_way() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = naoisis(folder.path(), arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let task = ["challenge", "ScoreEmptyGoal", "--behaviour", "striker", "--seed", "3"];
    run(&[&task[..], &["--episodes", "1", "--out", "one.json"]].concat());
    run(&[&task[..], &["--scenario", "episode.json"]].concat());
    let result: Value = serde_json::from_slice(&fs::read(folder.path().join("one.json")).unwrap()).unwrap();
    let time_s = result["results"][0]["rate"]["mean_time_s"].as_f64().unwrap();
    let episode: Value = serde_json::from_slice(&fs::read(folder.path().join("episode.json")).unwrap()).unwrap();
    assert!(episode["name"].as_str().unwrap().starts_with("ScoreEmptyGoal, seed 3: a success after "), "{episode}");
    // It ends when the task does.
    assert!((episode["duration_s"].as_f64().unwrap() - time_s).abs() < 0.001, "{episode}");
    let within = format!("blue.goals >= 1 within {} s", time_s + 0.02);
    run(&["run", "episode.json", "--expect", &within]);
    let earlier = format!("blue.goals >= 1 within {} s", time_s - 0.1);
    let output = naoisis(folder.path(), &["run", "episode.json", "--expect", &earlier]);
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn programs_of_results_are_started_only_if_they_may_be() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| naoisis(folder.path(), arguments);
    let played = run(&["challenge", "GoToBall", "--behaviour", "idle", "--episodes", "1", "--out", "idle.json"]);
    assert!(played.status.success());
    let results = fs::read_to_string(folder.path().join("idle.json")).unwrap();
    let changed = results.replace("\"player\": \"idle\"", "\"player\": \"exec:touch started\"");
    assert_ne!(results, changed);
    fs::write(folder.path().join("idle.json"), changed).unwrap();
    for command in [["leaderboard", ".", "--verify"], ["challenge", "--verify", "idle.json"]] {
        let output = run(&command);
        assert!(!output.status.success() && text(&output.stderr).contains("allow it with --programs"), "{command:?}");
    }
    assert!(!folder.path().join("started").exists());
    assert!(!run(&["challenge", "--verify", "idle.json", "--programs"]).status.success());
    assert!(folder.path().join("started").exists());
}

#[test]
fn the_episodes_of_a_program_are_verified_by_its_commands_where_the_program_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| naoisis(folder.path(), arguments);
    for file in ["naoisis_agent.py", "dribblers.py"] {
        fs::copy(path_of(&format!("clients/python/{file}")), folder.path().join(file)).unwrap();
    }
    let team = ["--team", "exec:python3 dribblers.py", "--realism", "realistic", "--episodes", "3", "--seed", "5"];
    let played = run(&[&["challenge", "TwoOnTwo"][..], &team, &["--out", "team.json"]].concat());
    assert!(played.status.success(), "{}", text(&played.stderr));
    let again = run(&["challenge", "--verify", "team.json", "--programs"]);
    assert!(text(&again.stdout).ends_with("the same in 3 episodes\n"), "{}", text(&again.stderr));
    fs::remove_file(folder.path().join("dribblers.py")).unwrap();
    let verify = || run(&["challenge", "--verify", "team.json"]);
    let verified = verify();
    assert!(
        text(&verified.stdout).ends_with("the same in 3 episodes, by the recorded commands\n"),
        "{}",
        text(&verified.stderr)
    );
    assert!(!run(&["challenge", "--verify", "team.json", "--programs"]).status.success(), "the program is gone");

    // The commands of another episode, and none that can be read.
    let results: Value = serde_json::from_str(&fs::read_to_string(folder.path().join("team.json")).unwrap()).unwrap();
    let episodes = &results["results"][0]["episodes"];
    for (commands, words) in
        [(episodes[0]["commands"].clone(), "differs at episode 2"), ("AAAA".into(), "cannot be read")]
    {
        let mut changed = results.clone();
        changed["results"][0]["episodes"][1]["commands"] = commands;
        fs::write(folder.path().join("team.json"), changed.to_string()).unwrap();
        let output = verify();
        assert!(!output.status.success() && (text(&output.stdout) + &text(&output.stderr)).contains(words), "{words}");
    }
}

#[test]
fn what_is_wrong_with_the_last_player_is_said_before_the_first_plays() {
    let folder = tempfile::tempdir().unwrap();
    for (player, words) in
        [(["--behaviour", "strikr"], "there is no behaviour `strikr`"), (["--policy", "nothing.onnx"], "nothing.onnx")]
    {
        let first = if player[0] == "--policy" { ["--policy", "learned"] } else { ["--behaviour", "chaser"] };
        let output = naoisis(folder.path(), &[&["challenge", "GoToBall"][..], &first, &player].concat());
        let (errors, printed) = (text(&output.stderr), text(&output.stdout));
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(words) && !printed.contains("succeed"), "{errors}{printed}");
    }
    let output =
        naoisis(folder.path(), &["challenge", "GoToBall", "--behaviour", "idle", "--out", "nowhere/idle.json"]);
    assert!(output.status.code() == Some(2) && text(&output.stderr).contains("there is no folder nowhere"));
}

//! Demonstrations as data sets, by the command line.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::{naoisis, text};

/// All files of a folder with their contents, by their paths in it.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else {
                found.push((entry.strip_prefix(folder).unwrap().to_owned(), fs::read(&entry).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn demonstrations_are_a_data_set_the_same_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let written = |task: &str, player: [&str; 2], out: &str, threads: &str| {
        let words =
            [&["episodes", task], &player[..], &["--episodes", "2", "--out", out, "--threads", threads]].concat();
        naoisis(folder, &words)
    };
    for (out, threads) in [("one", "1"), ("two", "2")] {
        let output = written("ScoreEmptyGoal", ["--behaviour", "striker"], out, threads);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(
            text(&output.stdout).contains("ScoreEmptyGoal/striker-paper-v0: episodes of one robot each: 2,"),
            "{}",
            text(&output.stdout)
        );
    }
    let [one, two] = ["one", "two"].map(|out| files(&folder.join(out)));
    assert!(one == two && one.len() == 5, "{:?}", one.iter().map(|(path, _)| path).collect::<Vec<_>>());
    let metadata = fs::read(folder.join("one/naoisis/ScoreEmptyGoal/striker-paper-v0/data/metadata.json")).unwrap();
    let metadata: Value = serde_json::from_slice(&metadata).unwrap();
    let space: Value = serde_json::from_str(metadata["observation_space"].as_str().unwrap()).unwrap();
    let names = metadata["naoisis"]["observation_names"].as_array().unwrap();
    assert_eq!((&metadata["total_episodes"], space["low"].as_array().unwrap().len()), (&Value::from(2), names.len()));
    // Robots of a team are episodes of their own, and a data set is not written over.
    assert!(
        text(&written("TwoOnTwo", ["--team", "roles"], "one", "2").stdout).contains("episodes of one robot each: 4,")
    );
    let again = written("TwoOnTwo", ["--team", "roles"], "one", "2");
    assert!(again.status.code() == Some(2) && text(&again.stderr).contains("exists already; --force replaces it"));
    let data = folder.join("one/naoisis/TwoOnTwo/roles-paper-v0/data");
    let agent = |index: usize| {
        let metadata = fs::read(data.join(format!("{index}/metadata.json"))).unwrap();
        serde_json::from_slice::<Value>(&metadata).unwrap()["agent"].clone()
    };
    assert_eq!([0, 1, 2, 3].map(agent), ["blue1", "blue2", "blue1", "blue2"]);
    let replaced = ["episodes", "TwoOnTwo", "--team", "roles", "--episodes", "1", "--out", "one", "--force"];
    assert!(naoisis(folder, &replaced).status.success() && !data.join("2").exists());
    // What is not as by default is in the name.
    let others = ["--observation", "truth", "--seed", "7"];
    assert!(
        text(&naoisis(folder, &[&replaced[..8], &others].concat()).stdout).contains("roles-paper-truth-seed7-v0: ")
    );
}

#[test]
fn players_that_demonstrate_nothing_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (player, words) in [
        (["--behaviour", "random"], "`random` decides outside of the match"),
        (["--behaviour", "nobody"], "there is no behaviour `nobody`"),
        (["--team", "exec:false"], "the program of blue"),
    ] {
        let words_of = [&["episodes", "FindBall"], &player[..], &["--episodes", "1", "--out", "sets"]].concat();
        let output = naoisis(folder.path(), &words_of);
        assert!(
            !output.status.success() && text(&output.stderr).contains(words),
            "{player:?}: {}",
            text(&output.stderr)
        );
    }
}

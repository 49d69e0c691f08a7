//! Tasks for whatever learns, from the command line.

use crate::support::{naoisis, text};
use serde_json::Value;
use std::fs;

#[test]
fn a_challenge_tells_how_often_it_succeeds() {
    let folder = tempfile::tempdir().unwrap();
    let arguments =
        ["challenge", "ScoreEmptyGoal", "--behaviour", "striker", "--episodes", "6", "--json", "rates.json"];
    let output = naoisis(folder.path(), &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let words = text(&output.stdout);
    assert!(words.contains("ScoreEmptyGoal-v0: A robot before an empty goal"), "{words}");
    let rates: Value = serde_json::from_slice(&fs::read(folder.path().join("rates.json")).unwrap()).unwrap();
    let rate = &rates["success_rates"]["striker"];
    assert_eq!(rate["episodes"], 6);
    assert!(rate["successes"].as_u64().unwrap() >= 5 && rate["mean_time_s"].as_f64().unwrap() > 3.0, "{rate}");
    assert_eq!(rates["episodes"]["striker"].as_array().unwrap().len(), 6);
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
    ] {
        let output = naoisis(folder.path(), &[&["challenge"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(words), "{}", text(&output.stderr));
        assert!(!text(&output.stderr).contains("panicked"));
    }
}

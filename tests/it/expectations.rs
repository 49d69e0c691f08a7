//! What is expected of matches: on the command line, in scenarios, and for other tools.

use std::fs;

use crate::support::{naoisis, text};

/// Blue kicks once; nobody scores.
const KICK: &str = r#"{ "duration_s": 3, "ball": { "position_m": [0.15, -0.05] }, EXPECT
    "robots": [{ "team": "blue", "number": 1, "behaviour": { "script": [
        { "from_s": 1.0, "kick": { "type": "right_straight", "speed": 0.5 } },
        { "from_s": 0.0, "until_s": 0.5, "head_deg": [0.0, 20.0] } ] } }] }"#;

#[test]
fn what_does_not_hold_is_said_with_what_was_and_the_exit_status_is_1() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("kick.json"), KICK.replace("EXPECT", "")).unwrap();
    let run = |expectations: &[&str]| {
        let options = expectations.iter().flat_map(|expectation| ["--expect", expectation]);
        let arguments: Vec<&str> = ["run", "kick.json"].into_iter().chain(options).collect();
        let output = naoisis(folder.path(), &arguments);
        (output.status.code().unwrap(), text(&output.stdout) + &text(&output.stderr))
    };
    let (status, said) = run(&[
        "blue.kicks == 1",
        "blue1.kicks == 0 within 0.9 s",
        "blue1.kicks == 1 within 2 s",
        "blue.goals == 0",
        "blue.possession_percent == 100",
        "blue1.ball_seen_percent >= 80",
        "blue1.path_m < 0.01",
        "blue1.kicks >= 1 in 100 % of 3",
    ]);
    assert_eq!(status, 0, "{said}");
    assert_eq!(said.matches("  ok   ").count(), 8, "{said}");
    let (status, said) =
        run(&["blue.kicks >= 1", "pink.goals >= 1", "blue1.pose_error_m < 1", "blue.goals > 0 in 50% of 2"]);
    assert_eq!(status, 1);
    for line in [
        "  ok     blue.kicks >= 1: it was 1",
        "  wrong  pink.goals >= 1: it was 0",
        "  wrong  blue1.pose_error_m < 1: there was nothing to measure",
        "  wrong  blue.goals > 0 in 50 % of 2: it was so in 0 % (0 of 2)",
    ] {
        assert!(said.contains(line), "{said}");
    }
    let (status, said) = run(&["blue.gaols >= 1"]);
    assert!(status == 2 && said.contains("did you mean `goals`?"), "{said}");
    let (status, said) = run(&["pink3.kicks >= 1"]);
    assert!(status == 2 && said.contains("there is no robot `pink3` in the match"), "{said}");
}

#[test]
fn scenarios_expect_things_of_themselves_and_a_check_plays_them() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, expect: &str| {
        fs::write(folder.path().join(name), KICK.replace("EXPECT", &format!("\"expect\": {expect},"))).unwrap();
    };
    write("good.json", r#"["blue.kicks >= 1 within 2 s", "blue.goals == 0 in 100 % of 2"]"#);
    write("bad.json", r#"["blue.goals >= 1"]"#);
    write("wrong.json", r#"["blue.kicks >= 1", "blue.kicks"]"#);
    write("absent.json", r#"["blue7.kicks >= 1"]"#);
    let check = |arguments: &[&str]| {
        let output = naoisis(folder.path(), &[&["check"], arguments].concat());
        (output.status.code().unwrap(), text(&output.stdout) + &text(&output.stderr))
    };
    assert_eq!(check(&["good.json", "bad.json"]).0, 0);
    let (status, said) = check(&["--play", "good.json"]);
    assert!(
        status == 0 && said.contains("ok     blue.goals == 0 in 100 % of 2: it was so in 100 % (2 of 2)"),
        "{said}"
    );
    let (status, said) = check(&["--play", "good.json", "bad.json", "--junit", "tests.xml"]);
    assert!(status == 1 && said.contains("wrong  blue.goals >= 1: it was 0"), "{said}");
    let junit = fs::read_to_string(folder.path().join("tests.xml")).unwrap();
    assert!(junit.contains("<testsuites name=\"naoisis\" tests=\"3\" failures=\"1\" errors=\"0\">"), "{junit}");
    assert!(junit.contains("<testsuite name=\"bad.json\" tests=\"1\" failures=\"1\" errors=\"0\">"), "{junit}");
    // The report alone names files that are wrong or missing.
    for (wrong, words) in
        [("wrong.json", "it compares nothing"), ("absent.json", "there is no robot `blue7`"), ("no.json", "no.json")]
    {
        assert_eq!(check(&["--play", wrong, "good.json", "--junit", "tests.xml"]).0, 2);
        let junit = fs::read_to_string(folder.path().join("tests.xml")).unwrap();
        assert!(junit.contains("tests=\"3\" failures=\"0\" errors=\"1\""), "{junit}");
        assert!(junit.lines().any(|line| line.contains("<error message") && line.contains(words)), "{junit}");
    }
    let (status, said) = check(&["wrong.json"]);
    assert!(status == 2 && said.contains("wrong.json:1:"), "{said}");
    assert!(said.contains("it compares nothing"), "{said}");
    let (status, said) = check(&["absent.json"]);
    assert!(status == 2 && said.contains("there is no robot `blue7` in the match"), "{said}");
}

//! What if: moments of matches that were saved or traced, played on with other chance.

use crate::support::{naoisis, text};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Fifteen seconds of a noisy match, traced, and saved after ten.
fn played(folder: &Path) {
    let output = naoisis(
        folder,
        &[
            "run", "match3v3", "--realism", "realistic", "--duration", "15", "--seed", "4", "--trace", "m.jsonl",
            "--save", "m.naoisis", "--save-at", "10", "--quiet",
        ],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
}

fn outcomes(folder: &Path, arguments: &[&str]) -> Value {
    let output = naoisis(folder, &[&["whatif"], arguments, &["--json", "out.json", "--force"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    serde_json::from_slice(&fs::read(folder.join("out.json")).unwrap()).unwrap()
}

#[test]
fn a_saved_moment_and_the_same_moment_of_a_trace_have_the_same_futures() {
    let folder = tempfile::tempdir().unwrap();
    played(folder.path());
    // Long enough for chance to tell: at that moment the ball lies.
    let few = ["--times", "3", "--until", "20"];
    let saved = outcomes(folder.path(), &[&["m.naoisis"], &few[..]].concat());
    let traced = outcomes(folder.path(), &[&["m.jsonl@10"], &few[..]].concat());
    assert_eq!(saved["branches"], traced["branches"]);
    assert_eq!(saved["outcomes"]["times"], 3);
    assert_eq!(saved["time_s"].as_f64().unwrap().round(), 10.0);
    // Another choice of the referee's, or of the noise, is another future; and so is another setting.
    let other = outcomes(folder.path(), &[&["m.naoisis", "--seed", "9"], &few[..]].concat());
    assert_ne!(saved["branches"], other["branches"]);
    let slow = outcomes(folder.path(), &[&["m.naoisis", "--set", "motion.max_linear_mps=0.05"], &few[..]].concat());
    assert_ne!(saved["branches"], slow["branches"]);
    let words = naoisis(folder.path(), &[&["whatif", "m.naoisis"], &few[..]].concat());
    assert!(text(&words.stdout).contains("neither scores") && text(&words.stdout).contains("realism realistic"));
}

#[test]
fn what_cannot_change_in_the_middle_of_a_match_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    played(folder.path());
    for setting in [
        "model=booster_k1", "realism=ideal", "league=spl2025", "seed=3", "ball.radius_m=0.1",
        "teams.blue.model=nao_v6", "teams.blue=chasers",
    ] {
        let output = naoisis(folder.path(), &["whatif", "m.naoisis", "--times", "1", "--until", "1", "--set", setting]);
        let (path, _) = setting.split_once('=').unwrap();
        let words = format!("--set {setting}: `{path}` cannot change in the middle of a match; expected `head`");
        assert!(output.status.code() == Some(2) && text(&output.stderr).contains(&words), "{}", text(&output.stderr));
    }
    // A team's own speed can, and its body cannot.
    let few = ["--times", "2", "--until", "20"];
    let before = outcomes(folder.path(), &[&["m.naoisis"], &few[..]].concat());
    let slow =
        outcomes(folder.path(), &[&["m.naoisis", "--set", "teams.blue.motion.max_linear_mps=0.05"], &few[..]].concat());
    assert_ne!(before["branches"], slow["branches"]);
}

#[test]
fn what_is_no_moment_is_refused_with_what_would_be() {
    let folder = tempfile::tempdir().unwrap();
    played(folder.path());
    for (moment, words) in [
        ("m.jsonl@16", "the trace ends at 15.0 s; there is no moment at 16 s"),
        ("m.jsonl@-1", "no moment at -1 s"),
        ("m.jsonl", "expected a saved match"),
        ("n.naoisis", "n.naoisis"),
        ("n.jsonl@1", "n.jsonl"),
    ] {
        let output = naoisis(folder.path(), &["whatif", moment, "--times", "1"]);
        assert_eq!(output.status.code(), Some(2), "{moment}");
        assert!(text(&output.stderr).contains(words), "{moment}: {}", text(&output.stderr));
    }
    // A trace that was tampered with does not come out the same.
    let trace = fs::read_to_string(folder.path().join("m.jsonl")).unwrap();
    fs::write(folder.path().join("other.jsonl"), trace.replacen("\"seed\":4", "\"seed\":5", 2)).unwrap();
    let output = naoisis(folder.path(), &["whatif", "other.jsonl@12", "--times", "1"]);
    assert!(text(&output.stderr).contains("the match is another one"), "{}", text(&output.stderr));
    // Nothing is written over without being told to.
    fs::write(folder.path().join("there.json"), "mine").unwrap();
    let output = naoisis(folder.path(), &["whatif", "m.naoisis", "--times", "1", "--json", "there.json"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(fs::read_to_string(folder.path().join("there.json")).unwrap(), "mine");
}

/// A program with a memory: it walks the farther to the side, the longer it has played, and believes where it is.
#[cfg(unix)]
const REMEMBERING: &str = r#"
from naoisis_agent import Agent
agent = Agent(belief=True)
for cycles, turn in enumerate(agent.turns()):
    assert turn["belief"]["pose"] is not None
    agent.answer(turn, {"walk": [0.003, 0.00002 * cycles, 0]})
"#;

#[test]
#[cfg(unix)]
fn a_match_of_programs_is_played_again_up_to_the_moment() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("remembering.py"), REMEMBERING).unwrap();
    let clients = Path::new(env!("CARGO_MANIFEST_DIR")).join("clients/python");
    let program = format!("exec:env PYTHONPATH={} python3 remembering.py", clients.display());
    let common = ["run", "match3v3", "--realism", "realistic", "--quiet", "--agent-timeout", "60", "--blue", &program];
    let files = ["--duration", "4", "--trace", "m.jsonl", "--save", "m.naoisis", "--save-at", "3"];
    let output = naoisis(folder, &[&common[..], &files].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let few = ["--times", "3", "--until", "6", "--agent-timeout", "60"];
    let one = outcomes(folder, &[&["m.jsonl@3", "--threads", "1"], &few[..]].concat());
    assert_eq!((one["time_s"].as_f64().unwrap().round(), &one["outcomes"]["times"]), (3.0, &Value::from(3)));
    let three = outcomes(folder, &[&["m.jsonl@3", "--threads", "3"], &few[..]].concat());
    assert_eq!(one["branches"], three["branches"]);
    // A saved match does not have what programs remember, but others may begin there.
    let refused = naoisis(folder, &[&["whatif", "m.naoisis"], &few[..]].concat());
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("expected a trace of the match"), "{}", text(&refused.stderr));
    let afresh = outcomes(folder, &[&["m.naoisis", "--blue", &program], &few[..]].concat());
    assert_eq!(afresh["time_s"], one["time_s"]);
    assert_ne!(afresh["branches"], one["branches"]);
    assert_eq!(outcomes(folder, &[&["m.naoisis", "--blue", "roles"], &few[..]].concat())["outcomes"]["times"], 3);
}

/// A program that answers differently each time, and ends when the file `end` is there.
#[cfg(unix)]
const RANDOM: &str = r#"
import os, random, sys
from naoisis_agent import Agent
agent = Agent()
for turn in agent.turns():
    if os.path.exists("end"):
        sys.exit(1)
    agent.answer(turn, {
        "walk": [random.uniform(0, 0.006), random.uniform(-0.002, 0.002), random.uniform(-2, 2)], "head_deg": [random.uniform(-60, 60), 10],
        **({"kick": {"type": "left_straight", "speed": random.random()}} if random.random() < 0.05 else {}),
        "say": {"ball_m": [random.uniform(-3, 3), random.uniform(-2, 2)]},
    })
"#;

#[test]
#[cfg(unix)]
fn programs_that_answer_differently_are_forked_where_the_trace_was_and_their_losses_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("random_walk.py"), RANDOM).unwrap();
    let clients = Path::new(env!("CARGO_MANIFEST_DIR")).join("clients/python");
    let program = format!("exec:env PYTHONPATH={} python3 random_walk.py", clients.display());
    let common = ["run", "match3v3", "--realism", "realistic", "--quiet", "--agent-timeout", "60", "--blue", &program];
    let output =
        naoisis(folder, &[&common[..], &["--duration", "40", "--trace", "m.jsonl", "--save", "m.naoisis"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let few = ["--times", "2", "--until", "1", "--agent-timeout", "60"];
    // Commands of programs are as precise as a trace, so nothing has led elsewhere after many kicks and falls.
    let forked = outcomes(folder, &[&["m.jsonl@39"], &few[..]].concat());
    assert_eq!(forked["outcomes"]["times"], 2);
    // Others may go on for them there, too.
    let others = outcomes(folder, &[&["m.jsonl@39", "--blue", "roles"], &few[..]].concat());
    assert_eq!(others["outcomes"]["times"], 2);
    fs::write(folder.join("end"), "").unwrap();
    let lost = naoisis(folder, &[&["whatif", "m.jsonl@3"], &few[..]].concat());
    let said = text(&lost.stderr);
    assert!(lost.status.code() == Some(2) && said.contains("lost its program at 0.0"), "{said}");
    let begun = naoisis(folder, &[&["whatif", "m.naoisis", "--blue", &program], &few[..]].concat());
    let said = text(&begun.stderr);
    assert!(said.contains("programs were lost in 2 of 2 repetitions; the first one, of blue1"), "{said}");
}

//! Programs that say what they think: it is in the trace, and measured.

use serde_json::json;
use std::fs;
use std::process::Command;

use crate::programs::{lines, path_of};
use crate::support::text;

/// Knows where it is by its steps from where it stood at the start, says what it thinks, and asks for a dive that its robot cannot do.
const THINKING: &str = r#"
import math, sys
from naoisis_agent import Agent
agent = Agent(name="thinking", fields=["odometry", "percepts.ball"])
x, y, heading = agent.welcome["pose"]
print("I stand at", round(x, 3), round(y, 3), round(heading, 3), file=sys.stderr)
for turn in agent.turns():
    for refused in turn.get("refused", []):
        if turn["cycle"] == 2: print("refused:", refused["command"], refused["reason"], file=sys.stderr)
    dx, dy, turned = turn["perception"]["odometry"]
    turn_rad = math.radians(heading)
    pose = [x + dx * math.cos(turn_rad) - dy * math.sin(turn_rad),
            y + dx * math.sin(turn_rad) + dy * math.cos(turn_rad), heading + turned]
    answer = {"command": {"walk": [0.004, 0.0, 0.5], "posture": {"dive": "left"}}}
    if turn["cycle"] != 20:
        answer.update({
            "belief": {"pose": pose, "pose_covariance": [0.01, 0, 0.01, 0, 0, 0.01],
                       "ball": {"position_m": [0.0, 0.0], "position_covariance": [0.01, 0, 0.01]}},
            "intention": "walk", "values": {"speed": 0.12},
            "reasons": {"options": [{"name": "walk", "value": 2}, {"name": "wait", "why": "no"}], "chosen": 0},
            "drawings": [{"frame": "robot", "ink": "sky", "circle": {"centre_m": [0, 0], "radius_m": 0.5}},
                         {"text": {"position_m": [1, 1], "words": "here"}}]})
    agent.answer(turn, answer)
"#;

#[test]
fn what_a_program_thinks_is_in_the_trace_and_measured_like_the_built_in_beliefs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("thinking.py"), THINKING).unwrap();
    let scenario = r#"{ "realism": "ideal", "rules": "free", "duration_s": 2, "ball": { "position_m": [0, 0] }, "robots": [
        { "team": "pink", "number": 2, "pose": [1.5, 0.5, 150], "behaviour": { "program": ["python3", "thinking.py"] } },
        { "team": "blue", "number": 1, "pose": [-1.5, 0.5, 0], "behaviour": "chaser" } ] }"#;
    fs::write(folder.path().join("match.json"), scenario).unwrap();
    let program = format!("PYTHONPATH={}", path_of("clients/python").display());
    let words = [
        "run", "match.json", "--agent-timeout", "60", "--trace", "t.jsonl", "--trace-fields",
        "robots,robots.reasons,events",
    ];
    let measures = ["--beliefs", "b.csv", "--mistakes", "m.json", "--expect", "pink2.pose_error_m < 0.02"];
    let output = Command::new("env")
        .arg(program)
        .arg(env!("CARGO_BIN_EXE_naoisis"))
        .args(words)
        .args(measures)
        .current_dir(folder.path())
        .output()
        .unwrap();
    let (said, report) = (text(&output.stderr), text(&output.stdout));
    assert!(output.status.success(), "{said}{report}");
    // In the frame of its team, which defends +x.
    assert!(said.contains("[pink2] I stand at -1.5 -0.5 -30.0"), "{said}");
    assert!(said.contains("[pink2] refused: posture not_allowed"), "{said}");
    assert!(report.contains("refused commands of pink2: 60 x posture: not allowed"), "{report}");
    let lines = lines(&folder.path().join("t.jsonl"));
    let robot = |cycle: usize| {
        lines[1 + cycle]["robots"].as_array().unwrap().iter().find(|robot| robot["id"] == "pink2").unwrap()
    };
    let told = robot(30);
    assert_eq!((&told["intention"], &told["values"]), (&json!("walk"), &json!({ "speed": 0.12 })));
    assert_eq!((&told["reasons"]["chosen"], &told["reasons"]["options"][0]["name"]), (&json!(0), &json!("walk")));
    assert_eq!(told["drawings"][0]["ink"], "sky");
    assert_eq!(
        told["drawings"][1],
        json!({ "frame": "team", "ink": "white", "text": { "position_m": [1.0, 1.0], "words": "here" } })
    );
    // A belief holds for the cycle in which it is told.
    assert!(told["belief"]["ball"].is_object() && robot(20)["belief"].is_null() && robot(20)["intention"].is_null());
    let table = fs::read_to_string(folder.path().join("b.csv")).unwrap();
    assert!(["pink2", "blue1"].iter().all(|id| table.contains(&format!(",{id},"))), "{table}");
}

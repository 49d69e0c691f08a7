//! The schema of the messages is true of what is said: by matches, and by the clients in each language.

use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{naoisis, text};
use naoisis::scenario::{FileKind, LIBRARY, Scenario};

/// Lets a program play, and writes down all that is said.
const LISTENING: &str = r#"
import os, subprocess, sys, threading
log = open(os.environ["NAOISIS_ROBOT"] + ".log", "w")
lock = threading.Lock()
program = subprocess.Popen(sys.argv[1:], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
def pass_on(lines, to, mark):
    for line in lines:
        with lock:
            log.write(mark + line.decode())
        to.write(line)
        to.flush()
    to.close()
thread = threading.Thread(target=pass_on, args=(program.stdout, sys.stdout.buffer, "<"))
thread.start()
pass_on(sys.stdin.buffer, program.stdin, ">")
thread.join()
"#;

/// Asks for everything that there is to ask for, and commands everything.
const CURIOUS: &str = r#"
import json, sys
def say(message): print(json.dumps(message), flush=True)
say({"hello": {"protocol": 1, "name": "curious", "images": ["top", "bottom"], "belief": True, "encoding": "json"}})
for line in sys.stdin:
    message = json.loads(line)
    if "cycle" in message:
        say({"cycle": message["cycle"], "command": {"walk": [0.0, 0.0, 1.0], "head_deg": [0, 10],
            "kick": {"type": "left_side"}, "posture": {"dive": "left"} if message["cycle"] % 2 else "get_up",
            "say": {"pose": [0, 1, 2], "ball_m": [1, 0], "robots_m": [[0, 0]], "intention": "see", "payload": "x",
                "datagram": "aGVsbG8="}}})
"#;

/// What of a value is not as a schema says, the first found: enough of JSON Schema for schemas that are made from types.
fn fault(schema: &Value, value: &Value, document: &Value) -> Option<String> {
    let Some(schema) = schema.as_object() else {
        return (*schema == Value::Bool(false)).then(|| format!("nothing may be where {value} is"));
    };
    let all = |values: &Value, condition: &dyn Fn(&Value) -> bool| values.as_array().unwrap().iter().all(condition);
    for (keyword, wanted) in schema {
        let is_wrong = match keyword.as_str() {
            "$ref" => {
                let target = document.pointer(wanted.as_str().unwrap().strip_prefix('#').unwrap()).unwrap();
                if let Some(fault) = fault(target, value, document) {
                    return Some(fault);
                }
                false
            }
            "anyOf" => all(wanted, &|option| fault(option, value, document).is_some()),
            "oneOf" => {
                wanted.as_array().unwrap().iter().filter(|option| fault(option, value, document).is_none()).count() != 1
            }
            "const" => value != wanted,
            "enum" => all(wanted, &|word| word != value),
            "type" => {
                let is = |kind: &str| match kind {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    "integer" => value.is_i64() || value.is_u64(),
                    "number" => value.is_number(),
                    other => panic!("a type {other}"),
                };
                match wanted.as_array() {
                    Some(kinds) => !kinds.iter().any(|kind| is(kind.as_str().unwrap())),
                    None => !is(wanted.as_str().unwrap()),
                }
            }
            "required" => value.is_object() && !all(wanted, &|name| value.get(name.as_str().unwrap()).is_some()),
            "properties" => {
                for (name, schema) in wanted.as_object().unwrap() {
                    if let Some(fault) = value.get(name).and_then(|value| fault(schema, value, document)) {
                        return Some(format!("{name}: {fault}"));
                    }
                }
                false
            }
            "additionalProperties" => {
                let known = |name: &String| schema.get("properties").is_some_and(|known| known.get(name).is_some());
                let others = value.as_object().into_iter().flatten().filter(|(name, _)| !known(name));
                for (name, value) in others {
                    if let Some(fault) = fault(wanted, value, document) {
                        return Some(format!("{name}: {fault}"));
                    }
                }
                false
            }
            "items" => {
                value.as_array().is_some_and(|items| items.iter().any(|item| fault(wanted, item, document).is_some()))
            }
            "minItems" => value.as_array().is_some_and(|items| (items.len() as u64) < wanted.as_u64().unwrap()),
            "maxItems" => value.as_array().is_some_and(|items| (items.len() as u64) > wanted.as_u64().unwrap()),
            "allOf" => {
                if let Some(fault) = wanted.as_array().unwrap().iter().find_map(|part| fault(part, value, document)) {
                    return Some(fault);
                }
                false
            }
            "exclusiveMinimum" => value.as_f64().is_some_and(|number| number <= wanted.as_f64().unwrap()),
            "minimum" => value.as_f64().is_some_and(|number| number < wanted.as_f64().unwrap()),
            "maximum" => value.as_f64().is_some_and(|number| number > wanted.as_f64().unwrap()),
            "$schema"
            | "$id"
            | "$defs"
            | "definitions"
            | "unit"
            | "examples"
            | "deprecated"
            | "title"
            | "description"
            | "default"
            | "format"
            | "pattern"
            | "unevaluatedProperties" => false,
            other => panic!("the keyword {other}"),
        };
        if is_wrong {
            return Some(format!(
                "{} is not {keyword} {wanted}",
                value.to_string().chars().take(200).collect::<String>()
            ));
        }
    }
    None
}

fn printed_schema(folder: &Path) -> Value {
    let output = naoisis(folder, &["schema"]);
    assert!(output.status.success());
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
#[cfg(unix)]
fn messages_from_any_source_are_as_the_schema_says() {
    let folder = tempfile::tempdir().unwrap();
    let schema = printed_schema(folder.path());
    let here = |name: &str| folder.path().join(name);
    fs::write(here("listening.py"), LISTENING).unwrap();
    fs::write(here("curious.py"), CURIOUS).unwrap();
    let client = |path: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("clients").join(path).display().to_string();
    let mut compiler = Command::new("c++");
    compiler.args(["-std=c++17", "-o"]).arg(here("dribblers")).arg(client("cpp/dribblers.cpp"));
    assert!(compiler.status().unwrap().success());
    let programs = [
        "python3 curious.py".to_owned(),
        format!("python3 {}", client("python/dribblers.py")),
        format!("node {}", client("javascript/dribblers.js")),
        "./dribblers".to_owned(),
    ];
    for program in programs {
        let team = format!("exec:python3 listening.py {program}");
        let seconds = if program.contains("curious") { "1" } else { "4" };
        let output = naoisis(
            folder.path(),
            &["run", "match3v3", "--duration", seconds, "--agent-timeout", "60", "--blue", &team],
        );
        assert!(output.status.success() && output.stderr.is_empty(), "{program}: {}", text(&output.stderr));
        let log = fs::read_to_string(here("blue2.log")).unwrap();
        let mut schema = schema.clone();
        if log.lines().any(|line| line.starts_with('<') && line.contains(r#""fields":[""#)) {
            // Of a perception it gets what it has named.
            let parts = schema["from_match"]["$defs"].as_object_mut().unwrap().iter_mut();
            for (_, part) in parts.filter(|(name, _)| *name != "Turn") {
                part.as_object_mut().unwrap().remove("required");
            }
        }
        let mut kinds = [0; 2];
        for line in log.lines() {
            let (direction, message) = line.split_at(1);
            let from_match = direction == ">";
            kinds[usize::from(from_match)] += 1;
            let schema = &schema[if from_match { "from_match" } else { "from_program" }];
            let message: Value = serde_json::from_str(message).unwrap();
            assert_eq!(fault(schema, &message, schema), None, "{program}: {message}");
        }
        if program.contains("curious") {
            // Each part of what team-mates say has come.
            let heard = log.lines().filter(|line| line.starts_with('>')).find(|line| line.contains(r#""datagram""#));
            let parts =
                ["pose", "ball_m", "robots_m", "intention", "payload", "datagram"].map(|part| format!("\"{part}\":"));
            assert!(heard.is_some_and(|line| parts.iter().all(|part| line.contains(part))), "{heard:?}");
        }
        // As many of each, but for the end.
        assert!(kinds[0] > 25 && kinds[1] == kinds[0] + 1, "{program}: {kinds:?}");
    }
}

#[test]
fn what_may_not_be_said_is_not_as_the_schema_says() {
    let folder = tempfile::tempdir().unwrap();
    let schema = &printed_schema(folder.path())["from_program"];
    let is_right = |text: &str| fault(schema, &serde_json::from_str(text).unwrap(), schema).is_none();
    assert!(is_right(r#"{"cycle": 1}"#));
    for wrong in [
        r#"{"cycle": -1}"#,
        r#"{"cycle": 1, "comand": {}}"#,
        r#"{"cycle": 1, "command": {"walk": [0, 0]}}"#,
        r#"{"cycle": 1, "command": {"kick": {"type": 3}}}"#,
        r#"{"cycle": 1, "command": {"kick": {"type": "visual", "direction_deg": "left"}}}"#,
        r#"{"cycle": 1, "command": {"say": {"datagram": [104, 105]}}}"#,
        r#"{"hello": {}}"#,
        r#"{"hello": {"protocol": 1, "images": [7]}}"#,
        r#"{}"#,
    ] {
        assert!(!is_right(wrong), "{wrong}");
    }
    // What is said of a type in the code is said in the schema.
    let walk = &schema["$defs"]["RobotCommand"]["properties"]["walk"];
    assert!(walk["description"].as_str().unwrap().contains("[dx m, dy m, dtheta deg]"), "{walk}");
}

/// The schemas of files are in `assets/schema`, for editors. After a change of the types,
/// `NAOISIS_WRITE_SCHEMA=1 cargo test --no-default-features --test it schemas_of_files` writes them again.
#[test]
fn schemas_of_files_are_those_that_editors_read() {
    for kind in FileKind::ALL {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("assets/schema/{}.json", kind.name()));
        let schema = format!("{:#}\n", kind.schema());
        if std::env::var_os("NAOISIS_WRITE_SCHEMA").is_some() {
            fs::write(&path, &schema).unwrap();
        }
        assert!(
            fs::read_to_string(&path).is_ok_and(|recorded| recorded == schema),
            "{} is not up to date; NAOISIS_WRITE_SCHEMA=1 cargo test --no-default-features --test it schemas_of_files writes it again",
            path.display()
        );
    }
}

#[test]
fn scenarios_are_as_their_schema_says_whole_and_as_files() {
    let schema = FileKind::Scenario.schema();
    for entry in LIBRARY {
        let whole = Scenario::named(entry.name).unwrap().resolved_json().unwrap();
        assert_eq!(fault(&schema, &serde_json::from_str(&whole).unwrap(), &schema), None, "{}", entry.name);
        if let Ok(file) = serde_json::from_str::<Value>(entry.text) {
            assert_eq!(fault(&schema, &file, &schema), None, "{}", entry.name);
        }
    }
    let file = |text: &str| fault(&schema, &serde_json::from_str(text).unwrap(), &schema);
    for right in [
        r#"{ "$schema": "scenario.json", "league": "spl2025", "rules": "free", "realism": { "vision": "ideal" } }"#,
        r#"{ "vision": { "noise": { "preset": "none", "ball": { "pixel_sd": 1 } } }, "model": { "preset": "nao", "head": {} } }"#,
        r#"{ "teams": { "blue": "roles", "pink": { "team": "roles", "model": "nao_v6", "motion": { "max_linear_mps": 1 } } } }"#,
        r#"{ "robots": [{ "behaviour": { "script": [{ "kick": { "type": "left_side" } }] }, "kicks": { "own": { "flap": {} } } }] }"#,
    ] {
        assert_eq!(file(right), None, "{right}");
    }
    for wrong in [
        r#"{ "sede": 1 }"#,
        r#"{ "motion": { "max_linear_mps": 6 } }"#,
        r#"{ "sonar": { "noise": { "gaussian": { "sd_m": -1 } } } }"#,
        r#"{ "league": "spl2026" }"#,
        r#"{ "robots": [{ "number": 0 }] }"#,
        r#"{ "robots": [{ "kicks": { "own": { "flap": { "speed_sd": 11 } } } }] }"#,
        r#"{ "posts": [{ "radius_m": 0 }] }"#,
    ] {
        assert!(file(wrong).is_some(), "{wrong}");
    }
}

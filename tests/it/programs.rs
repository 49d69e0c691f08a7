//! Programs as players: whatever they do, the match goes on, and what they did is in the trace.

use bevy::prelude::*;
use naoisis::agents::server::Address;
use naoisis::agents::{self, AgentSettings, AgentsPlugin, Server};
use naoisis::prelude::*;
use serde_json::{Value, json};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::support::{naoisis, text};

/// Plays, as the whole of a program in Python, until it is time for its misdeed, which is its first argument.
const MISBEHAVING: &str = r#"
import json, os, sys, time
misdeed = sys.argv[1]
def say(text):
    sys.stdout.write(text)
    sys.stdout.flush()
if misdeed == "never says hello": time.sleep(1000)
if misdeed == "says something else": print("Loading my model ...", flush=True)
hello = {"protocol": 2 if misdeed == "another protocol" else 1}
if misdeed == "wants images": hello["images"] = ["top"]
if misdeed == "wants another robot": hello["robot"] = "pink9"
if misdeed == "wants to know where it is": hello["fields"] = ["percepts.ball", "pose"]
say(json.dumps({"hello": hello}) + "\n")
for line in sys.stdin:
    message = json.loads(line)
    if "refused" in message:
        print("I was refused:", message["refused"]["reason"], file=sys.stderr)
        break
    cycle = message.get("cycle")
    if cycle == 5:
        if misdeed == "leaves": sys.exit(0)
        if misdeed == "crashes": sys.exit(7)
        if misdeed == "crashes and leaves a child": os.fork() == 0 and time.sleep(1000); os._exit(7)
        if misdeed == "hangs up": os.close(1); time.sleep(1000)
        if misdeed == "is killed": os.kill(os.getpid(), 9)
        if misdeed == "sleeps": time.sleep(1000)
        if misdeed == "half a line": say('{"cycle": 5, "com'); sys.exit(0)
        if misdeed == "another cycle": cycle = 4
        if misdeed == "no number": say('{"cycle": 5, "command": {"walk": [NaN, 0, 0]}}\n')
        if misdeed == "too large a number": say('{"cycle": 5, "command": {"head_deg": [1e99, 0]}}\n')
        if misdeed == "an unknown word": say('{"cycle": 5, "command": {"wlak": [0, 0, 0]}}\n')
        if misdeed == "no text": sys.stdout.buffer.write(b'\xff\xfe\n'); sys.stdout.flush()
        if misdeed == "nested": say("[" * 20000 + "\n")
        if misdeed == "long": say('{"cycle": 5, "command": {"say": {"payload": "' + "x" * 70000 + '"}}}\n')
        if misdeed == "answers twice": say('{"cycle": 5}\n{"cycle": 5}\n')
    if cycle is not None:
        say(json.dumps({"cycle": cycle, "command": {"walk": [0.005, 0, 0]}}) + "\n")
"#;

fn path_of(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The lines of a trace.
fn lines(trace: &Path) -> Vec<Value> {
    fs::read_to_string(trace).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The robots that were lost, and why.
fn lost(trace: &Path) -> Vec<(u64, String, String)> {
    let lines = lines(trace);
    let events = |line: &Value| line["events"].as_array().cloned().unwrap_or_default();
    let word = |value: &Value| value.as_str().unwrap().to_owned();
    lines
        .iter()
        .flat_map(|line| events(line).into_iter().map(|event| (line["cycle"].as_u64().unwrap(), event)))
        .filter(|(_, event)| event["kind"] == "agent_lost")
        .map(|(cycle, event)| (cycle, word(&event["robot"]), word(&event["reason"])))
        .collect()
}

#[test]
fn whatever_a_program_does_the_match_goes_on_and_the_trace_tells() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("misbehaving.py"), MISBEHAVING).unwrap();
    let trace = folder.path().join("match.jsonl");
    for (misdeed, cycle, reason) in [
        ("never says hello", 1, "timed_out"),
        ("says something else", 1, "malformed"),
        ("another protocol", 1, "refused"),
        ("wants images", 1, "refused"),
        ("wants another robot", 1, "refused"),
        ("wants to know where it is", 1, "refused"),
        ("leaves", 5, "closed"),
        ("crashes", 5, "crashed"),
        // The child has its standard output.
        ("crashes and leaves a child", 5, "crashed"),
        ("hangs up", 5, "closed"),
        ("is killed", 5, "crashed"),
        ("sleeps", 5, "timed_out"),
        ("half a line", 5, "closed"),
        ("another cycle", 5, "wrong_cycle"),
        ("no number", 5, "malformed"),
        ("too large a number", 5, "malformed"),
        ("an unknown word", 5, "malformed"),
        ("no text", 5, "malformed"),
        ("nested", 5, "malformed"),
        ("long", 5, "too_long"),
        ("answers twice", 6, "wrong_cycle"),
    ] {
        let scenario = format!(
            r#"{{ "duration_s": 0.5, "cameras": {{ "render": "off" }}, "robots": [
                {{ "number": 1, "behaviour": {{ "program": ["python3", "misbehaving.py", "{misdeed}"] }} }},
                {{ "number": 2, "pose": [-1, 0, 0], "behaviour": {{ "program": ["python3", "misbehaving.py", ""] }} }} ] }}"#
        );
        fs::write(folder.path().join("scenario.json"), scenario).unwrap();
        // As slow as the machine may be where the others are not late, and quick where that is all there is to see.
        let patience = if reason == "timed_out" { "1" } else { "60" };
        let start = if misdeed == "never says hello" { "1" } else { "60" };
        let arguments =
            ["run", "scenario.json", "--force", "--agent-timeout", patience, "--agent-start-timeout", start, "--trace"];
        let output = naoisis(folder.path(), &[&arguments[..], &["match.jsonl"]].concat());
        let said = text(&output.stderr);
        assert!(output.status.success(), "{misdeed}: {said}");
        assert_eq!(lost(&trace), [(cycle, "blue1".to_owned(), reason.to_owned())], "{misdeed}: {said}");
        assert!(said.contains("blue1 lost its program"), "{misdeed}: {said}");
        assert!(text(&output.stdout).contains("programs lost: blue 1, pink 0"), "{misdeed}");
        // The other one has played to the end.
        let last = lines(&trace).into_iter().rev().find(|line| line["type"] == "cycle").unwrap();
        assert!(last["robots"][1]["pose"][0].as_f64().unwrap() > -0.95, "{misdeed}: {last}");
    }
}

#[test]
fn who_plays_may_open_standard_input_and_output_by_their_paths() {
    let folder = tempfile::tempdir().unwrap();
    let program = MISBEHAVING
        .replace("for line in sys.stdin:", "for line in open('/dev/stdin'):")
        .replace("    sys.stdout.", "    out.")
        .replace("misdeed = sys.argv[1]", "misdeed, out = '', open('/dev/stdout', 'w')");
    assert!(program.contains("in open('/dev/stdin')") && program.contains("out.write(text)"), "{program}");
    fs::write(folder.path().join("by_paths.py"), program).unwrap();
    let team = "exec:python3 by_paths.py";
    let expected = ["--expect", "blue.programs_lost == 0", "--expect", "blue2.path_m > 0.05"];
    let run = ["run", "match3v3", "--duration", "1", "--agent-timeout", "60", "--blue", team];
    let output = naoisis(folder.path(), &[&run[..], &expected].concat());
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
    let one = ["run", "match3v3", "--duration", "1", "--blue", "exec:python3 none.py", "--expect"];
    let output = naoisis(folder.path(), &[&one[..], &["blue.programs_lost == 3"]].concat());
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
}

#[test]
fn programs_that_answer_the_same_way_play_the_same_match() {
    let folder = tempfile::tempdir().unwrap();
    let team = format!("exec:python3 {}", path_of("clients/python/dribblers.py").display());
    let play = |trace: &str| {
        let output = naoisis(
            folder.path(),
            &["run", "match3v3", "--duration", "10", "--blue", &team, "--agent-timeout", "60", "--trace", trace],
        );
        assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
        fs::read(folder.path().join(trace)).unwrap()
    };
    assert!(play("one.jsonl") == play("other.jsonl"));
    let trace = lines(&folder.path().join("one.jsonl"));
    let robot =
        |line: &Value, id: &str| line["robots"].as_array().unwrap().iter().find(|robot| robot["id"] == id).cloned();
    let wanted = |line: &Value| robot(line, "blue1").and_then(|robot| robot["command"].as_object().cloned());
    assert!(trace[2..trace.len() - 1].iter().filter_map(wanted).any(|command| command.contains_key("walk")));
    assert!(trace[0]["scenario"]["robots"][0]["behaviour"]["program"].is_array());
}

#[test]
fn a_program_that_does_not_exist_is_a_mistake_of_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, said) in [
        (["run", "match3v3", "--blue", "exec:no_such_program"], "there is no program `no_such_program`"),
        (["run", "match3v3", "--pink", "exec: "], "names no program"),
        (["run", "match3v3", "--pink", "no_such_team"], "there is no team `no_such_team`"),
        (["run", "kick_right_straight", "--blue", "roles"], "places its robots itself"),
        (["run", "match3v3", "--agent-timeout", "-1"], "expected a number of seconds"),
    ] {
        let output = naoisis(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(said), "{arguments:?}: {}", text(&output.stderr));
    }
}

#[test]
fn what_a_program_says_to_standard_error_is_shown_with_its_robot() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("misbehaving.py"), MISBEHAVING).unwrap();
    let team = "exec:python3 misbehaving.py 'wants images'";
    let output = naoisis(folder.path(), &["run", "match3v3", "--duration", "0.1", "--cameras", "off", "--pink", team]);
    let said = text(&output.stderr);
    assert!(said.contains("[pink2] I was refused: it wants camera images, but none are rendered"), "{said}");
}

/// Holds a pipe open for as long as it lives, beside a child that does so, too, and never answers.
const CLINGING: &str = r#"
import os, signal, sys, time
pipe = open("pipe", "w")
signal.signal(signal.SIGINT, signal.SIG_IGN)
signal.signal(signal.SIGTERM, signal.SIG_IGN)
os.fork()
pipe.write("x")
pipe.flush()
time.sleep(1000)
"#;

#[test]
fn no_program_outlives_the_match_however_it_ends() {
    for (signal, start_timeout) in [("KILL", "0"), ("INT", "3"), ("", "3")] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("clinging.py"), CLINGING).unwrap();
        let pipe = folder.path().join("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let mut command = Command::new(env!("CARGO_BIN_EXE_naoisis"));
        command.current_dir(folder.path()).args(["run", "match3v3", "--duration", "0.1"]);
        command.args(["--agent-start-timeout", start_timeout, "--blue", "exec:python3 clinging.py"]);
        let mut playing = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let mut pipe = fs::File::open(pipe).unwrap();
        pipe.read_exact(&mut [0]).unwrap();
        if !signal.is_empty() {
            let id = playing.id().to_string();
            assert!(Command::new("kill").args(["-s", signal, &id]).status().unwrap().success());
        }
        playing.wait().unwrap();
        // The end comes when the last of them is gone.
        pipe.read_to_end(&mut Vec::new()).unwrap();
    }
}

#[test]
fn programs_play_in_batches_and_against_other_teams() {
    let folder = tempfile::tempdir().unwrap();
    let team = format!("exec:python3 {}", path_of("clients/python/dribblers.py").display());
    let pairs = format!("{team},chasers");
    let arguments =
        ["batch", "match3v3", "--matches", "2", "--duration", "2", "--agent-timeout", "60", "--pairs", &pairs];
    let output = naoisis(folder.path(), &arguments);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("2 of 2 matches"), "{}", text(&output.stdout));
}

#[test]
fn whoever_connects_plays_the_match_of_whoever_is_started() {
    let folder = tempfile::tempdir().unwrap();
    let play = |team: &str, listen: &[&str], trace: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_naoisis"));
        command.current_dir(folder.path()).args(if listen.is_empty() { &["run"] } else { &["serve"] }).args(listen);
        command.args(["match3v3", "--duration", "3", "--agent-timeout", "60", "--pink", team, "--trace", trace]);
        let mut match_ = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(match_.stderr.take().unwrap()).lines();
        let mut programs = Vec::new();
        if !listen.is_empty() {
            let first = said.next().unwrap().unwrap();
            let address = first.strip_prefix("listening at ").unwrap().split(';').next().unwrap().to_owned();
            assert!(first.ends_with("waiting for pink1, pink2, pink3"), "{first}");
            let connecting = format!(
                "import sys; sys.path.insert(0, {:?}); import naoisis_agent, dribblers; \
                 naoisis_agent.play(dribblers.decide, address={address:?}, robot=sys.argv[1], token=sys.argv[2])",
                path_of("clients/python")
            );
            let connect = |robot: &str, token: &str| {
                let mut program = Command::new("python3");
                program.current_dir(folder.path()).args(["-c", &connecting, robot, token]).stderr(Stdio::null());
                program.spawn().unwrap()
            };
            let token = listen.get(3).copied().unwrap_or_default();
            if !token.is_empty() {
                assert!(!connect("pink1", "another").wait().unwrap().success());
                assert!(said.next().unwrap().unwrap().contains("was refused: its token is wrong"));
            }
            programs.extend(["pink3", "pink1", "pink2"].map(|robot| connect(robot, token)));
        }
        let rest: Vec<String> = said.map(Result::unwrap).filter(|line| !line.contains("is played by")).collect();
        assert!(match_.wait().unwrap().success() && rest.is_empty(), "{rest:?}");
        assert!(programs.into_iter().all(|mut program| program.wait().unwrap().success()));
        let lines = fs::read_to_string(folder.path().join(trace)).unwrap();
        // The header says what plays.
        lines.lines().skip(1).collect::<Vec<_>>().join("\n")
    };
    let team = format!("exec:python3 {}", path_of("clients/python/dribblers.py").display());
    let started = play(&team, &[], "started.jsonl");
    assert!(play("remote", &["--listen", "tcp:127.0.0.1:0"], "tcp.jsonl") == started);
    assert!(play("remote", &["--listen", "unix:socket"], "unix.jsonl") == started);
    assert!(play("remote", &["--listen", "tcp:127.0.0.1:0", "--token", "secret"], "token.jsonl") == started);
    assert!(!folder.path().join("socket").exists());
}

#[test]
fn a_check_walks_a_program_through_a_match() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("misbehaving.py"), MISBEHAVING).unwrap();
    let good = format!("exec:python3 {}", path_of("clients/python/dribblers.py").display());
    let check = |team: &str| naoisis(folder.path(), &["check", team, "--agent-timeout", "60"]);
    let output = check(&good);
    assert!(output.status.success(), "{}", text(&output.stdout));
    assert!(text(&output.stdout).contains("sends a hello              ok: dribblers, protocol 1"));
    for (misdeed, said) in [
        ("another protocol", "sends a hello              wrong: it uses protocol 2; expected 1"),
        ("crashes", "answers in every cycle     wrong: in cycle 5: it ended with status 7"),
    ] {
        let output = check(&format!("exec:python3 misbehaving.py '{misdeed}'"));
        assert_eq!(output.status.code(), Some(2));
        assert!(text(&output.stdout).contains(said), "{}", text(&output.stdout));
    }
    // A program for another robot is tested with it.
    let kicking =
        "from naoisis_agent import play\nplay(lambda _: {'kick': {'type': 'visual', 'speed': 1.0}}, fields=['body'])";
    fs::write(folder.path().join("kicking.py"), kicking).unwrap();
    let team = format!("exec:env PYTHONPATH={} python3 kicking.py", path_of("clients/python").display());
    let check_in = |words: &[&str]| {
        let output = naoisis(folder.path(), &[&["check", &team, "--agent-timeout", "60"], words].concat());
        (output.status.code(), text(&output.stdout) + &text(&output.stderr))
    };
    for words in [&["--scenario", "hsl2026_middle"][..], &["--set", "league=hsl2026_middle"]] {
        let (_, said) = check_in(words);
        assert!(said.contains("answers in every cycle     ok"), "{words:?}: {said}");
    }
    for (words, why) in [
        (&[][..], "there is no kick `visual`"),
        (&["--scenario", "hsl2026_midle"], "hsl2026_middle"),
        (&["--set", "nothing=1"], "nothing"),
    ] {
        let (status, said) = check_in(words);
        assert!(status == Some(2) && said.contains(why), "{words:?}: {said}");
    }
}

/// MessagePack has numbers in single precision as they are, JSON the shortest that means the same.
fn in_single_precision(value: Value) -> Value {
    match value {
        Value::Number(number) => json!(number.as_f64().unwrap() as f32),
        Value::Array(values) => values.into_iter().map(in_single_precision).collect(),
        Value::Object(fields) => fields
            .into_iter()
            .map(|(name, value)| (name, in_single_precision(value)))
            .collect::<serde_json::Map<_, _>>()
            .into(),
        other => other,
    }
}

/// Plays a robot over a socket in either encoding, with these fields of perceptions or all. What it was told in each cycle;
/// images as their lengths.
fn play_over(stream: UnixStream, encoding: &str, fields: &[&str]) -> Vec<Value> {
    let mut reader = BufReader::new(stream.try_clone().unwrap());
    let mut writer = stream;
    let hello = json!({ "protocol": 1, "encoding": encoding, "images": ["top"], "belief": true, "fields": fields });
    writeln!(writer, "{}", json!({ "hello": hello })).unwrap();
    let mut turns: Vec<Value> = Vec::new();
    loop {
        let mut message = if encoding == "json" {
            let mut line = String::new();
            reader.read_line(&mut line).unwrap();
            serde_json::from_str::<Value>(&line).unwrap()
        } else {
            let mut length = [0; 4];
            reader.read_exact(&mut length).unwrap();
            let mut bytes = vec![0; u32::from_be_bytes(length) as usize];
            reader.read_exact(&mut bytes).unwrap();
            // A `Value` has no bytes.
            let place = bytes.windows(4).position(|window| window == [0xc6, 0x00, 0x03, 0x84]);
            if let Some(place) = place {
                bytes.splice(place..place + 5 + 3 * 320 * 240, *b"\xce\x00\x03\x84\x00");
            }
            rmp_serde::from_slice(&bytes).unwrap()
        };
        if message.get("end").is_some() {
            return turns;
        }
        let cycle = message["cycle"].clone();
        if cycle.is_null() {
            assert_eq!(message["welcome"]["robot"], "blue1");
            continue;
        }
        let rgb = &mut message["images"]["top"]["rgb"];
        // Four letters for three bytes.
        if let Some(text) = rgb.as_str() {
            *rgb = json!(text.len() / 4 * 3);
        }
        turns.push(in_single_precision(message));
        let answer = json!({ "cycle": cycle, "command": { "walk": [0.006, 0, 1.5], "head_deg": [10, 5] } });
        if encoding == "json" {
            writeln!(writer, "{answer}").unwrap();
        } else {
            let bytes = rmp_serde::to_vec_named(&answer).unwrap();
            writer.write_all(&(bytes.len() as u32).to_be_bytes()).unwrap();
            writer.write_all(&bytes).unwrap();
        }
    }
}

/// A match with so many remote robots, and where programs connect to it. Nobody is given up for silence.
fn served_match(folder: &Path, robots: u8) -> (App, Server, PathBuf) {
    let path = folder.join("socket");
    let server = Server::listen(&Address::Unix(path.clone())).unwrap();
    let robots: Vec<Value> = (1..=robots)
        .map(|number| json!({ "number": number, "pose": [-1, number, 0], "behaviour": "remote" }))
        .collect();
    let mut app = App::new();
    app.add_plugins((NaoisisPlugins, AgentsPlugin));
    app.insert_resource(AgentSettings { answer_timeout: None, ..default() });
    app.start_match(&Scenario::from_json(&json!({ "robots": robots }).to_string()).unwrap()).unwrap();
    (app, server, path)
}

/// A program that has connected and said this.
fn connected(path: &Path, said: &str) -> UnixStream {
    let mut stream = UnixStream::connect(path).unwrap();
    stream.write_all(said.as_bytes()).unwrap();
    stream
}

/// All that a program is told until the end.
fn told(mut stream: UnixStream) -> String {
    let mut told = String::new();
    stream.read_to_string(&mut told).unwrap();
    told
}

#[test]
fn who_connects_and_says_nothing_keeps_nobody_waiting() {
    let folder = tempfile::tempdir().unwrap();
    let (mut app, mut server, path) = served_match(folder.path(), 1);
    let silent: Vec<UnixStream> =
        ["", "{\"hello\": "].iter().cycle().take(40).map(|said| connected(&path, said)).collect();
    let wrong = connected(&path, "Hello!\n");
    let program = connected(&path, "{\"hello\": {\"name\": \"quick\", \"protocol\": 1}}\n");
    let mut notes = Vec::new();
    server.let_in(app.world_mut(), || false, |note| notes.push(note.to_owned()));
    assert!(notes[0].starts_with("a program was refused: it sent `Hello!`"), "{notes:?}");
    assert_eq!(notes[1..], ["blue1 is played by `quick`"]);
    // Everybody else is told why it does not play.
    let told_wrong = told(wrong);
    assert!(told_wrong.contains("refused") && told_wrong.contains("expected a hello at first"), "{told_wrong}");
    for late in silent {
        let told = told(late);
        assert!(told.contains("refused") && told.contains("are taken"), "{told}");
    }
    drop(program);
}

#[test]
fn a_robot_whose_program_hangs_up_before_the_match_is_free_again() {
    let folder = tempfile::tempdir().unwrap();
    let (mut app, mut server, path) = served_match(folder.path(), 2);
    let hello = |robot: &str| format!("{{\"hello\": {{\"name\": \"x\", \"protocol\": 1, \"robot\": \"{robot}\"}}}}\n");
    let programs = std::thread::spawn(move || {
        let welcomed = |robot: &str| {
            let mut program = BufReader::new(connected(&path, &hello(robot)));
            let mut line = String::new();
            program.read_line(&mut line).unwrap();
            assert!(line.contains("welcome"), "{line}");
            program
        };
        drop(welcomed("blue1"));
        [welcomed("blue1"), welcomed("blue2")]
    });
    let mut notes = Vec::new();
    server.let_in(app.world_mut(), || false, |note| notes.push(note.to_owned()));
    let _programs = programs.join().unwrap();
    let expected = ["blue1 is played by `x`", "blue1 is free again: its program closed the connection"];
    assert_eq!(notes, [&expected[..], &["blue1 is played by `x`", "blue2 is played by `x`"]].concat());
}

#[test]
fn both_encodings_say_the_same_with_beliefs_and_images() {
    let scenario = Scenario::from_json(
        r#"{ "robots": [{ "number": 1, "pose": [-1, 0, 0], "behaviour": "remote" },
                        { "number": 2, "pose": [-2, 1, 0], "behaviour": "chaser" }] }"#,
    )
    .unwrap();
    let play = |encoding: &'static str, fields: &'static [&str]| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let mut server = Server::listen(&Address::Unix(path.clone())).unwrap();
        let program = std::thread::spawn(move || play_over(UnixStream::connect(path).unwrap(), encoding, fields));
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, AgentsPlugin));
        app.start_match(&scenario).unwrap();
        server.let_in(app.world_mut(), || false, |_| {});
        app.run_cycles(20);
        let pose = app.robot_pose(RobotId::new(Team::Blue, 1)).unwrap();
        agents::dismiss(app.world_mut(), "end");
        (program.join().unwrap(), pose)
    };
    let (json, message_pack) = (play("json", &[]), play("msgpack", &[]));
    assert_eq!(json.0.len(), 20);
    assert_eq!(json.0, message_pack.0);
    assert_eq!(json.1, message_pack.1);
    assert!(json.1.position.x > -0.95);
    let first = &json.0[0];
    assert_eq!(first["time_s"], 0.0);
    assert_eq!(first["images"]["top"]["rgb"], 230_400.0);
    assert!((first["belief"]["pose"][0].as_f64().unwrap() + 1.0).abs() < 0.1, "{}", first["belief"]);
    assert!(first["perception"].get("pose").is_none());
    // Who names fields gets these, as they are where all are sent, and the same match.
    let fields = &["body", "game.state", "game.own_end", "percepts.goal_posts.colour", "percepts.ball"];
    let (json_parts, message_pack_parts) = (play("json", fields), play("msgpack", fields));
    assert_eq!((&json_parts, &json_parts.1), (&message_pack_parts, &json.1));
    let parts_of = |turn: &Value| {
        let mut turn = turn.clone();
        let perception = turn["perception"].as_object_mut().unwrap();
        perception.retain(|name, _| ["body", "game", "percepts"].contains(&name.as_str()));
        let keep = |part: &mut Value, names: &[&str]| {
            part.as_object_mut().unwrap().retain(|name, _| names.contains(&name.as_str()));
        };
        keep(&mut perception["game"], &["state", "own_end", "time_s"]);
        keep(&mut perception["percepts"], &["goal_posts", "ball", "time_s"]);
        for post in perception["percepts"]["goal_posts"].as_array_mut().unwrap() {
            keep(post, &["colour"]);
        }
        turn
    };
    let expected: Vec<Value> = json.0.iter().map(parts_of).collect();
    assert_eq!(json_parts.0, expected);
    assert!(expected.iter().any(|turn| turn["perception"]["percepts"]["goal_posts"][0]["colour"].is_string()));
}

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
        "run",
        "match.json",
        "--agent-timeout",
        "60",
        "--trace",
        "t.jsonl",
        "--trace-fields",
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

/// Hears of the game at the ports of its match, and ends with an error if it has not.
const LISTENING_TO_THE_GAME: &str = r#"
import os, socket, sys
from naoisis_agent import play
offset, team = int(os.environ["NAOISIS_PORT_OFFSET"]), int(os.environ["NAOISIS_TEAM_NUMBER"])
robot = int(os.environ["NAOISIS_ROBOT"][-1])
game = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
game.bind(("127.0.0.1", 3838 + offset))
messages = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
messages.bind((f"127.1.{team}.{robot}", 10000 + team + offset))
for each in (game, messages): each.setblocking(False)
print("team", team, "at", offset, file=sys.stderr)
cycles, heard = 0, 0
def decide(perception):
    global cycles, heard
    cycles += 1
    try: heard += game.recv(1024).startswith(b"RGme")
    except BlockingIOError: pass
    assert cycles < 28 or heard
    messages.sendto(b"hello", ("127.0.0.1", 10000 + team + offset))
    return {}
play(decide, name="listening", fields=["game.state"])
"#;

#[test]
fn each_match_of_many_has_ports_of_its_own_and_tells_its_programs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("listening.py"), LISTENING_TO_THE_GAME).unwrap();
    let scenario = r#"{ "duration_s": 1, "rules": "naoisis", "robots": [
        { "number": 3, "pose": [-1, 0, 0], "behaviour": { "program": ["python3", "listening.py"] } } ],
        "expect": ["blue.programs_lost == 0 in 100 % of 3"] }"#;
    fs::write(folder.path().join("match.json"), scenario).unwrap();
    let first = 20_000 + (std::process::id() % 9_000) as u16;
    let first = first.to_string();
    let network = [
        "--game-controller",
        "v18",
        "--team-messages",
        "--team-numbers",
        "5,12",
        "--game-controller-port-offset",
        &first,
    ];
    let play = |words: &[&str]| {
        let path = format!("PYTHONPATH={}", path_of("clients/python").display());
        let mut command = Command::new("env");
        command.arg(path).arg(env!("CARGO_BIN_EXE_naoisis")).args(words).args(network).args(["--agent-timeout", "60"]);
        let output = command.current_dir(folder.path()).output().unwrap();
        let (said, report) = (text(&output.stderr), text(&output.stdout));
        assert!(output.status.success(), "{said}{report}");
        (said, report)
    };
    let (said, _) = play(&["run", "match.json", "--expect", "blue.programs_lost == 0 in 100 % of 3"]);
    let told: Vec<&str> = said.lines().filter(|line| line.contains("team 5 at ")).collect();
    assert!(
        told.len() == 4 && told[0].ends_with(&first) && told[1..].iter().all(|line| !line.ends_with(&first)),
        "{said}"
    );
    let (_, report) = play(&["check", "--play", "match.json"]);
    assert!(report.contains("100 % (3 of 3)"), "{report}");
    let rows = |threads: &str, csv: &str| {
        play(&["batch", "match.json", "--matches", "4", "--threads", threads, "--csv", csv]);
        fs::read_to_string(folder.path().join(csv)).unwrap()
    };
    let rows_of_one = rows("1", "one.csv");
    assert!(
        rows_of_one.lines().skip(1).all(|row| row.contains(",,paper,")) && rows_of_one == rows("3", "three.csv"),
        "{rows_of_one}"
    );
    let refused = |words: &[&str], why: &str| {
        let output = naoisis(folder.path(), words);
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(text(&output.stderr).contains(why), "{words:?}: {}", text(&output.stderr));
    };
    let expect = ["--expect", "blue.goals >= 0 in 1 % of 2"];
    refused(&[&["run", "match.json", "--listen-game-controller"], &expect[..]].concat(), "decides about one match");
    refused(&["batch", "match.json", "--matches", "2", "--listen-game-controller"], "decides about one match");
    refused(&["batch", "match.json", "--matches", "2", "--team-messages", "--threads", "99"], "--threads");
    refused(&["check", "match.json", "--team-messages"], "--play");
}

#[test]
fn a_program_that_was_lost_may_come_back_and_one_too_many_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let (mut app, mut server, path) = served_match(folder.path(), 1);
    const HELLO: &str = "{\"hello\": {\"name\": \"x\", \"protocol\": 1}}\n";
    let first = connected(&path, HELLO);
    server.let_in(app.world_mut(), || false, |_| {});
    let mut look = |app: &mut App| {
        let mut notes = Vec::new();
        server.look(app.world_mut(), |note| notes.push(note.to_owned()));
        notes
    };
    let one_too_many = connected(&path, HELLO);
    let notes = look(&mut app);
    assert_eq!(notes, ["a program was refused: all remote robots of the match are taken"]);
    assert!(told(one_too_many).contains("are taken"));
    drop(first);
    app.run_cycles(1);
    let lost = app.events().iter().any(|event| matches!(event, MatchEvent::AgentLost { .. }));
    assert!(lost, "{:?}", app.events());
    // The built-in estimator would begin at the true pose, which nobody may learn then.
    let believing = connected(&path, &HELLO.replace("\"protocol\"", "\"belief\": true, \"protocol\""));
    let notes = look(&mut app);
    assert!(notes[0].contains("no estimator has run for its robot"), "{notes:?}");
    assert!(told(believing).contains("in the middle of a match"));
    let again = connected(&path, HELLO);
    assert_eq!(look(&mut app), ["blue1 is played by `x`"]);
    let program = std::thread::spawn(move || {
        let mut lines = BufReader::new(again.try_clone().unwrap()).lines();
        let welcome = lines.next().unwrap().unwrap();
        let turn: Value = serde_json::from_str(&lines.next().unwrap().unwrap()).unwrap();
        // Numbers as some languages write them, and an empty line.
        (&again).write_all(format!("\n{{\"cycle\": {}.0}}\n", turn["cycle"]).as_bytes()).unwrap();
        (welcome, turn["cycle"].as_u64())
    });
    app.run_cycles(1);
    assert!(app.events().iter().all(|event| !matches!(event, MatchEvent::AgentLost { .. })));
    let (welcome, cycle) = program.join().unwrap();
    // In the middle of a match nobody tells it where it stands.
    assert!(!welcome.contains("\"pose\""), "{welcome}");
    assert_eq!(cycle, Some(2));
}

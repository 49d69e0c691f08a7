//! Programs that connect to a match: over TCP and Unix sockets, in both encodings, late, twice, or not at all.

use bevy::prelude::*;
use naoisis::agents::server::Address;
use naoisis::agents::{self, AgentSettings, AgentsPlugin, Server};
use naoisis::behaviour::AskAhead;
use naoisis::prelude::*;
use serde_json::{Value, json};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::programs::path_of;

#[test]
fn programs_that_connect_play_in_the_match_that_was_started() {
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
                "import sys; sys.path.insert(0, {:?}); import dribblers; \
                 dribblers.main(address={address:?}, robot=sys.argv[1], token=sys.argv[2])",
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

#[test]
fn a_window_stays_alive_while_a_program_thinks() {
    let folder = tempfile::tempdir().unwrap();
    let (mut app, mut server, path) = served_match(folder.path(), 1);
    let hello = "{\"hello\": {\"name\": \"slow\", \"protocol\": 1, \"belief\": true}}\n";
    let mut program = BufReader::new(connected(&path, hello));
    server.let_in(app.world_mut(), || false, |_| {});
    let mut line = String::new();
    program.read_line(&mut line).unwrap();
    assert!(line.contains("welcome"), "{line}");
    let AskAhead(ask_ahead) = *app.world().resource::<AskAhead>();
    for cycle in 1..4 {
        for _ in 0..3 {
            assert_eq!(ask_ahead(app.world_mut()), Ok(Some(RobotId::new(Team::Blue, 1))));
            assert_eq!(app.cycle(), cycle);
        }
        // The program was asked once.
        line.clear();
        program.read_line(&mut line).unwrap();
        let asked: Value = serde_json::from_str(&line).unwrap();
        assert_eq!(asked["cycle"], cycle);
        let answer = json!({ "cycle": cycle, "command": { "walk": [0.005, 0.0, 0.0] } });
        writeln!(program.get_mut(), "{answer}").unwrap();
        while ask_ahead(app.world_mut()) != Ok(None) {}
        app.run_cycles(1);
        assert_eq!(app.cycle(), cycle);
    }
    assert!(app.robot_pose(RobotId::new(Team::Blue, 1)).unwrap().position.x > -0.99);
}

//! A match that is watched while it is played, as Lichtblick and Foxglove do.
#![expect(clippy::unwrap_used, reason = "a failed test may panic")]

mod client;

use client::{Received, Viewer};
use serde_json::{Value, json};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Plays a match with a live view in a folder. Returns the program and the address of the view.
fn play(folder: &Path, arguments: &[&str]) -> (Child, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_naoisis"));
    command.current_dir(folder).args(["run", "match3v3", "--quiet", "--live", "127.0.0.1:0"]).args(arguments);
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    said.read_line(&mut line).unwrap();
    let address = line.trim().strip_prefix("live view at ws://").unwrap_or_else(|| panic!("{line}")).to_owned();
    (child, address)
}

fn cycle(data: &[u8]) -> u64 {
    serde_json::from_slice::<Value>(data).unwrap()["cycle"].as_u64().unwrap()
}

#[test]
fn a_viewer_sees_the_match_and_may_pause_it_and_its_trace_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let common = ["--duration", "12", "--trace"];
    let (mut child, address) = play(folder.path(), &[&common[..], &["watched.jsonl", "--pace", "2"]].concat());
    let mut viewer = Viewer::connect(&address);
    let topics = ["/trace", "/pitch", "/tf", "/tf_static", "/ball", "/game", "/blue1/belief", "/pink3/percepts"];
    viewer.await_topics(&topics, &["/naoisis/pause", "/naoisis/step", "/naoisis/speed"]);
    assert_eq!((&viewer.info["name"], viewer.topics["/tf"].1.as_str()), (&json!("naoisis"), "protobuf"));
    viewer.subscribe(&["/trace", "/pitch", "/game"]);
    // Each viewer gets the messages that are sent only once, whenever it comes.
    let mut seen = Vec::new();
    while !["/trace", "/pitch", "/game"].iter().all(|topic| seen.contains(&(*topic).to_owned())) {
        let Received::Message(topic, ..) = viewer.receive() else { panic!("the match ends after {seen:?}") };
        seen.push(topic);
    }
    assert_eq!(viewer.call("/naoisis/pause", &json!({})).0, Ok(()));
    // Messages that were under way come first.
    let mut cycles = Vec::new();
    for _ in 0..20 {
        let (answer, mut before) = viewer.call("/naoisis/step", &json!({ "cycles": 1 }));
        assert_eq!(answer, Ok(()));
        before.retain(|message| matches!(message, Received::Message(topic, ..) if topic == "/trace"));
        while before.is_empty() {
            before.extend(
                Some(viewer.receive()).filter(|it| matches!(it, Received::Message(topic, ..) if topic == "/trace")),
            );
        }
        cycles.extend(before.iter().filter_map(|message| match message {
            Received::Message(_, _, data) => Some(cycle(data)),
            _ => None,
        }));
    }
    let last = &cycles[cycles.len() - 5..];
    assert!(last.windows(2).all(|pair| pair[1] == pair[0] + 1), "step by step: {cycles:?}");
    for (service, request, words) in [
        ("/naoisis/speed", json!({ "times_real_time": 0 }), "expected 0.001 to 1000000"),
        ("/naoisis/speed", json!({}), "missing field `times_real_time`"),
        ("/naoisis/step", json!({ "cycle": 1 }), "unknown field `cycle`"),
    ] {
        let refused = viewer.call(service, &request).0.unwrap_err();
        assert!(refused.contains(words), "{refused}");
    }
    assert_eq!(viewer.call("/naoisis/speed", &json!({ "times_real_time": 20 })).0, Ok(()));
    assert_eq!(viewer.call("/naoisis/pause", &json!({ "paused": false })).0, Ok(()));
    let (mut times, mut end) = (Vec::new(), 0);
    loop {
        match viewer.receive() {
            Received::Message(topic, time_ns, data) if topic == "/trace" => {
                times.push(time_ns);
                end = cycle(&data);
            }
            Received::End => break,
            _ => {}
        }
    }
    assert!(times.is_sorted());
    assert_eq!(end, 360, "the last cycle is seen");
    assert!(child.wait().unwrap().success());

    let alone = Command::new(env!("CARGO_BIN_EXE_naoisis"))
        .current_dir(folder.path())
        .args(["run", "match3v3", "--quiet"])
        .args(common)
        .arg("alone.jsonl")
        .status();
    assert!(alone.unwrap().success());
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(read("watched.jsonl") == read("alone.jsonl"));
}

#[test]
fn the_match_waits_for_no_viewer() {
    let folder = tempfile::tempdir().unwrap();
    let (mut child, address) = play(folder.path(), &["--duration", "60", "--pace", "30"]);
    let mut viewer = Viewer::connect(&address);
    viewer.await_topics(&["/trace", "/tf", "/game"], &[]);
    let topics: Vec<String> = viewer.topics.keys().cloned().collect();
    viewer.subscribe(&topics.iter().map(String::as_str).collect::<Vec<_>>());
    // The viewer reads nothing of it.
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_match_goes_on_when_the_viewer_that_paused_it_leaves() {
    let folder = tempfile::tempdir().unwrap();
    let (mut child, address) = play(folder.path(), &["--duration", "60", "--pace", "10"]);
    let mut viewer = Viewer::connect(&address);
    viewer.await_topics(&["/trace"], &["/naoisis/pause"]);
    assert_eq!(viewer.call("/naoisis/pause", &json!({})).0, Ok(()));
    drop(viewer);
    assert!(child.wait().unwrap().success());
}

#[test]
fn an_address_that_is_taken_is_told() {
    let taken = std::net::TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let output = Command::new(env!("CARGO_BIN_EXE_naoisis"))
        .args(["run", "match3v3", "--duration", "1", "--live", &address])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains(&format!("--live: {address}: ")), "{said}");
}

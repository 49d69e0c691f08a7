//! Matches as MCAP files: the trace in them, their channels, and the layout that shows them.

use mcap::MessageStream;
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;
use naoisis::record::mcap::McapRecorder;
use naoisis::record::read::{Ending, TraceReader};
use naoisis::record::recorder::{self, EndReason};
use naoisis::sensing::jobs::SensingThreads;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::support::{headless_app, naoisis, text};

fn run(folder: &Path, line: &str) -> String {
    let output = naoisis(folder, &line.split(' ').collect::<Vec<_>>());
    assert!(output.status.success(), "{line}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Writes the file of a match with images, so many seconds long, whose images are drawn by so many threads.
fn record(path: &Path, seconds: f64, threads: usize) {
    let mut scenario = Scenario::named("match3v3").unwrap();
    let mut settings = serde_json::to_value(&scenario).unwrap();
    settings["cameras"] = serde_json::json!({ "render": "software", "width": 32, "height": 24 });
    scenario = Scenario::from_json(&settings.to_string()).unwrap();
    let mut app = headless_app();
    app.add_plugins(RecordPlugin).insert_resource(SensingThreads(threads));
    app.start_match(&scenario).unwrap();
    recorder::start(app.world_mut(), vec![Box::new(McapRecorder::create(path).unwrap())]);
    app.run_cycles((seconds * 30.0) as usize);
    for said in recorder::finish(app.world_mut(), EndReason::Duration) {
        assert!(said.unwrap().unwrap().contains("mcap"));
    }
}

#[test]
fn a_trace_is_the_same_after_it_was_in_an_mcap_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let read = |name: &str| fs::read(folder.join(name)).unwrap();
    run(folder, "run match3v3 --duration 4 --quiet --trace t.jsonl --mcap m.mcap --log mcap=l.mcap");
    assert!(read("m.mcap") == read("l.mcap"));
    run(folder, "convert m.mcap back.jsonl");
    assert!(read("back.jsonl") == read("t.jsonl"));
    run(
        folder,
        "run match3v3 --duration 4 --quiet --trace thin.jsonl --trace-every 7 --trace-fields ball,robots.reasons,events",
    );
    run(folder, "convert thin.jsonl thin.mcap");
    run(folder, "convert thin.mcap again.jsonl");
    assert!(read("again.jsonl") == read("thin.jsonl"));
    assert!(text(&read("thin.jsonl")).contains("\"reasons\":{"));
    assert_eq!(run(folder, "replay m.mcap"), run(folder, "replay t.jsonl"));
    assert!(read("m.mcap").len() * 3 < read("t.jsonl").len(), "{} bytes", read("m.mcap").len());
    run(folder, "whatif m.mcap@2.5 --times 1 --until 1 --quiet");
    for (line, said) in [
        ("run match3v3 --mcap m.mcap", "error: --mcap: m.mcap: the file exists already"),
        ("run match3v3 --mcap m.mp4", "error: --mcap: m.mp4: expected a name that ends in .mcap"),
        ("convert t.jsonl m.mcap", "error: FILE: m.mcap: the file exists already"),
    ] {
        let output = naoisis(folder, &line.split(' ').collect::<Vec<_>>());
        let words = text(&output.stderr);
        assert!(output.status.code() == Some(2) && words.starts_with(said), "{line}: {words}");
    }
}

#[test]
fn a_file_is_the_same_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let [one, three] = ["one.mcap", "three.mcap"].map(|name| folder.path().join(name));
    record(&one, 0.5, 1);
    record(&three, 0.5, 3);
    assert!(fs::read(one).unwrap() == fs::read(three).unwrap());
}

/// The cycles that are read of a file, and how it ends.
fn cycles(path: &Path) -> Result<(usize, Ending), String> {
    let mut reader = TraceReader::open(path).map_err(|error| error.to_string())?;
    let mut cycles = 0;
    while reader.next_cycle().map_err(|error| error.to_string())?.is_some() {
        cycles += 1;
    }
    Ok((cycles, reader.ending()))
}

#[test]
fn a_file_that_is_cut_off_is_read_as_far_as_it_goes_and_a_damaged_one_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("match.mcap");
    record(&path, 3.0, 1);
    let whole = fs::read(&path).unwrap();
    assert_eq!(cycles(&path), Ok((91, Ending::Proper(EndReason::Duration))));
    let mut before = 0;
    for tenths in 2..10 {
        fs::write(&path, &whole[..whole.len() * tenths / 10]).unwrap();
        let (read, ending) = cycles(&path).unwrap();
        // A chunk has about a sixth of this match.
        assert!(ending == Ending::BrokenOff && read >= before && read + 20 >= 90 * tenths / 10, "{tenths}: {read}");
        before = read;
    }
    for at in [20, 3000, whole.len() / 2] {
        let mut damaged = whole.clone();
        damaged[at..at + 8].fill(0xff);
        fs::write(&path, damaged).unwrap();
        let said = cycles(&path).expect_err("a damaged file");
        // The place is a byte of the file, or a line and a column of the trace in it.
        let has_place = said.contains("byte ") || said.contains("expected a cycle of a trace");
        assert!(said.starts_with(path.to_str().unwrap()) && has_place, "{at}: {said}");
    }
    fs::write(&path, &whole[..40]).unwrap();
    assert!(cycles(&path).unwrap_err().contains("the file has no whole line"));
}

#[test]
fn a_file_of_others_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.mcap");
    let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    writer.add_channel(0, "/imu", "json", &BTreeMap::new()).unwrap();
    writer.finish().unwrap();
    let said = cycles(&path).unwrap_err();
    assert!(said.contains("it has the channel `/imu` before any trace: it was not written by naoisis"), "{said}");
}

/// The last message of each JSON channel, and nothing for others, by topic.
fn channels(path: &Path) -> BTreeMap<String, Value> {
    let bytes = fs::read(path).unwrap();
    let mut channels = BTreeMap::new();
    for message in MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap_or_else(|| panic!("{}: no schema", message.channel.topic));
        let is_json = message.channel.message_encoding == "json";
        assert_eq!(schema.encoding, if is_json { "jsonschema" } else { "protobuf" });
        assert!(schema.name.starts_with(if is_json { "naoisis." } else { "foxglove." }), "{}", schema.name);
        let value = if is_json { serde_json::from_slice(&message.data).unwrap() } else { Value::Null };
        channels.insert(message.channel.topic.clone(), value);
    }
    channels
}

/// The topics, and paths into messages, that a part of a layout names.
fn named(value: &Value, paths: &mut Vec<String>) {
    match value {
        Value::String(word) if word.starts_with('/') => paths.push(word.clone()),
        Value::Array(values) => values.iter().for_each(|value| named(value, paths)),
        Value::Object(fields) => {
            paths.extend(fields.keys().filter(|key| key.starts_with('/')).cloned());
            fields.values().for_each(|value| named(value, paths));
        }
        _ => {}
    }
}

#[test]
fn the_layout_shows_what_is_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("match.mcap");
    record(&path, 20.0, 1);
    let channels = channels(&path);
    let layout = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/lichtblick.json")).unwrap();
    let layout: Value = serde_json::from_str(&layout).unwrap();
    let mut paths = Vec::new();
    named(&layout, &mut paths);
    assert!(paths.len() > 30);
    for path in paths {
        let (topic, fields) = path.split_once('.').unwrap_or((&path, ""));
        let message = channels.get(topic).unwrap_or_else(|| panic!("{topic} is in the layout and not in the file"));
        let pointer = fields.replace(['.', '['], "/").replace(']', "");
        assert!(fields.is_empty() || message.pointer(&format!("/{pointer}")).is_some(), "{path}: {message}");
    }
    // The guide describes each channel, with the robot and the camera as examples.
    let guide = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/guide/mcap.md")).unwrap();
    for topic in channels.keys() {
        let general = topic.split('/').skip(1).map(|word| match word {
            "top" | "bottom" => "CAMERA",
            word if word.starts_with("blue") || word.starts_with("pink") => "ROBOT",
            word => word,
        });
        let general = format!("| `/{}` |", general.collect::<Vec<_>>().join("/"));
        assert!(guide.contains(&general), "{general}");
    }
}

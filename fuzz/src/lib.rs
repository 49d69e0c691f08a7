//! What reads bytes that anybody may have written. Each function takes any bytes and returns: a panic, an endless loop or
//! exhausted memory is a bug. The fuzz targets of this folder call these functions, and so does the test `mutated`.

use bevy::prelude::*;
use naoisis::agents::connection::{Connection, Stream};
use naoisis::agents::protocol::{Answer, Encoding, HelloMessage};
use naoisis::cycle::try_run_cycle;
use naoisis::game_controller::{ControlPacket, ReturnPacket};
use naoisis::prelude::*;
use naoisis::record::read::TraceReader;
use naoisis::record::trace::TraceRecorder;
use naoisis::record::{RecordPlugin, recorder};
use naoisis::scenario::{Format, ScenarioFile};
use naoisis::simulation::Snapshot;
use std::cell::RefCell;
use std::fs;
use std::io::{self, Cursor, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::{Arc, Mutex};

/// A function that reads bytes, and bytes that it should read without an error.
#[derive(Clone, Copy)]
pub struct Target {
    /// The name of the function.
    pub name: &'static str,
    /// The function.
    pub read: fn(&[u8]),
    /// Its seeds, from the repository's folder `assets`.
    pub seeds: fn(&Path) -> Vec<Vec<u8>>,
}

/// All targets.
pub const TARGETS: &[Target] = &[
    Target { name: "scenario_text", read: scenario_text, seeds: scenario_seeds },
    Target { name: "trace", read: trace, seeds: trace_seeds },
    Target { name: "saved_match", read: saved_match, seeds: saved_seeds },
    Target { name: "wire_message", read: wire_message, seeds: wire_seeds },
    Target { name: "game_controller_packet", read: game_controller_packet, seeds: packet_seeds },
];

/// Reads a scenario, or a robot's model, in both formats.
pub fn scenario_text(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    for format in [Format::Ron, Format::Json] {
        drop(ScenarioFile::from_text(&text, format, "fuzzed"));
    }
}

fn scenario_seeds(assets: &Path) -> Vec<Vec<u8>> {
    let files =
        ["scenarios", "robots"].into_iter().filter_map(|folder| fs::read_dir(assets.join(folder)).ok()).flatten();
    let mut paths: Vec<_> = files.filter_map(|file| Some(file.ok()?.path())).collect();
    paths.sort();
    paths.into_iter().filter_map(|path| fs::read(path).ok()).collect()
}

/// Reads a trace to its end, or to the first line that is wrong.
pub fn trace(bytes: &[u8]) {
    if let Ok(mut reader) = TraceReader::new(Path::new("fuzzed.jsonl"), Cursor::new(bytes.to_vec())) {
        while let Ok(Some(_)) = reader.next_cycle() {}
    }
}

/// Bytes that several threads write to.
#[derive(Clone, Default)]
struct Written(Arc<Mutex<Vec<u8>>>);

impl Write for Written {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn trace_seeds(_: &Path) -> Vec<Vec<u8>> {
    let mut app = match_app();
    app.add_plugins(RecordPlugin);
    let written = Written::default();
    recorder::start(app.world_mut(), vec![Box::new(TraceRecorder::plain("trace", written.clone()))]);
    app.run_cycles(5);
    drop(app);
    let bytes = written.0.lock().map(|bytes| bytes.clone());
    vec![bytes.unwrap_or_default()]
}

/// An app in which two robots play.
fn match_app() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins));
    let scenario = r#"{ "teams": { "blue": "chasers", "pink": "roles" }, "rules": { "team_size": 1 } }"#;
    let scenario = Scenario::from_json(scenario).unwrap_or_default();
    assert!(app.start_match(&scenario).is_ok(), "the match of the seeds starts");
    app
}

/// Reads a saved match, and plays a cycle of it if it is one.
pub fn saved_match(bytes: &[u8]) {
    thread_local! {
        static APP: RefCell<App> = RefCell::new(match_app());
    }
    APP.with_borrow_mut(|app| {
        let snapshot = Snapshot::from_bytes(bytes, app.world());
        if snapshot.is_ok_and(|snapshot| snapshot.restore(app.world_mut()).is_ok()) {
            drop(try_run_cycle(app.world_mut()));
        }
    });
}

fn saved_seeds(_: &Path) -> Vec<Vec<u8>> {
    let mut app = match_app();
    app.run_cycles(40);
    let snapshot = Snapshot::take(app.world_mut()).ok();
    snapshot.and_then(|snapshot| snapshot.to_bytes(app.world()).ok()).into_iter().collect()
}

/// Receives what a program sends: a first byte that chooses the encoding, then messages as they come out of the socket.
pub fn wire_message(bytes: &[u8]) {
    let Some((&first, sent)) = bytes.split_first() else { return };
    let Ok(stream) = connected_to_a_program_that_sends(&sent[..sent.len().min(MOST_SENT)]) else { return };
    let mut connection = Connection::new(stream, 1000, None);
    connection.set_encoding(if first % 2 == 0 { Encoding::Json } else { Encoding::Msgpack });
    if first % 4 >= 2 {
        drop(connection.receive::<HelloMessage>(None));
    }
    // A command is checked before a robot gets it.
    while let Ok(answer) = connection.receive::<Answer>(None) {
        drop(answer.command.checked());
    }
}

/// What the buffers of a socket take without a reader, bytes.
const MOST_SENT: usize = 16_000;

fn connected_to_a_program_that_sends(bytes: &[u8]) -> io::Result<Stream> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let mut program = TcpStream::connect(listener.local_addr()?)?;
    program.write_all(bytes)?;
    Ok(Stream::Tcp(listener.accept()?.0))
}

fn wire_seeds(_: &Path) -> Vec<Vec<u8>> {
    let answer = r#"{"cycle":5,"command":{"walk":[0.006,0,3.0],"head_deg":[20,10],"kick":{"type":"left_side","speed":1},"posture":{"dive":"left"},"say":{"pose":[1,2,30],"ball_m":[1,0],"robots_m":[[1,2]],"intention":"pass","payload":"x"}}}"#;
    let hello = r#"{"hello":{"protocol":1,"name":"fuzzed","encoding":"json"}}"#;
    // {"cycle": 5, "command": {"walk": [1, 0, 0]}} after its length.
    let packed = b"\x01\x00\x00\x00\x1c\x82\xa5cycle\x05\xa7command\x81\xa4walk\x93\x01\x00\x00";
    vec![
        format!("\x00{answer}\n{answer}\n").into_bytes(),
        format!("\x02{hello}\n{answer}\n").into_bytes(),
        packed.to_vec(),
    ]
}

/// Reads what may come from a `GameController` or from a robot, and writes again what it is.
pub fn game_controller_packet(bytes: &[u8]) {
    if let Ok(packet) = ControlPacket::from_bytes(bytes) {
        // Codes that have no meaning here become one that has.
        let written = packet.to_bytes();
        assert!(ControlPacket::from_bytes(&written).is_ok_and(|again| again.to_bytes() == written), "{packet:?}");
    }
    _ = ReturnPacket::from_bytes(bytes, 1.0);
}

fn packet_seeds(_: &Path) -> Vec<Vec<u8>> {
    use naoisis::game_controller::ProtocolVersion;
    let mut seeds: Vec<Vec<u8>> = ProtocolVersion::ALL
        .into_iter()
        .map(|version| {
            let mut bytes = vec![0; version.packet_bytes()];
            bytes[..5].copy_from_slice(&[b'R', b'G', b'm', b'e', version.number()]);
            bytes
        })
        .collect();
    let mut report = vec![0; 32];
    report[..5].copy_from_slice(b"RGrt\x04");
    seeds.push(report);
    seeds
}

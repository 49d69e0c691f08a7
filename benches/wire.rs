//! What it costs that programs play: matches of three against three as so many times real time, the clients' small team in
//! compiled and in interpreted languages, in JSON and in MessagePack and with camera images, and how soon six programs are ready.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints its figures and may panic")]

use bevy::prelude::*;
use naoisis::agents::{self, AgentsPlugin};
use naoisis::prelude::*;
use naoisis::scenario::BehaviourSpec;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

mod common;
use common::fastest;

/// Cycles over which a factor is taken, and how often: ten simulated seconds.
const CYCLES: usize = 300;
const ROUNDS: usize = 12;
/// The same with camera images: two simulated seconds.
const IMAGE_CYCLES: usize = 60;

fn client(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("clients").join(path).display().to_string()
}

/// The team of the Python client in either encoding, told all that there is or what it looks at, or with nothing but an image a
/// cycle.
const IN_PYTHON: &str = r#"
import sys
sys.path.insert(0, sys.argv[1])
import dribblers
from naoisis_agent import play
if sys.argv[2] == "images":
    play(lambda perception: {}, images=["top"], encoding=sys.argv[3], fields=["body"])
else:
    dribblers.main(encoding=sys.argv[3], fields=dribblers.FIELDS if sys.argv[2] == "fields" else [])
"#;

/// The team of the C++ client, told all that there is.
const ALL_IN_CPP: &str = r#"
#define main told_what_it_looks_at
#include "dribblers.cpp"
#undef main
int main() { play({}); }
"#;

/// A program in C++, compiled.
fn compiled(folder: &Path, source: &str) -> Option<String> {
    let (file, program) = (folder.join("source.cpp"), folder.join(format!("program{}", source.len())));
    std::fs::write(&file, source).ok()?;
    let mut compiler = Command::new("c++");
    compiler.args(["-std=c++17", "-O2", "-I", &client("cpp"), "-o"]).arg(&program).arg(&file);
    compiler.status().ok().filter(|status| status.success()).map(|_| program.display().to_string())
}

/// A match in which this program plays the first robots, so many of them.
fn match_with(program: &str, robots: usize) -> App {
    let mut app = App::new();
    app.add_plugins((NaoisisPlugins, AgentsPlugin));
    let mut scenario = naoisis::simulation::resolved(app.world(), &Scenario::named("match3v3").unwrap());
    let words: Vec<String> = program.split(' ').map(str::to_owned).collect();
    for robot in scenario.robots.iter_mut().take(robots) {
        robot.behaviour = BehaviourSpec::Program(words.clone());
    }
    app.start_match(&scenario).unwrap();
    app
}

/// How many times real time it is played.
fn factor(app: &mut App, cycles: usize) -> f64 {
    let simulated_s = cycles as f64 * app.world().resource::<CycleClock>().period_s;
    let took_s = fastest(ROUNDS, || {
        app.run_cycles(cycles);
    });
    simulated_s / took_s
}

fn report(name: &str, program: &str, robots: usize, cycles: usize) {
    let mut app = match_with(program, robots);
    let started = Instant::now();
    agents::start_programs(app.world_mut()).unwrap();
    let start_s = started.elapsed().as_secs_f64();
    println!("{name}: {:.0} times real time, ready after {start_s:.2} s", factor(&mut app, cycles));
    agents::dismiss(app.world_mut(), "end");
}

fn main() {
    let folder: PathBuf = tempfile::tempdir().unwrap().keep();
    println!("no program: {:.0} times real time", factor(&mut match_with("", 0), CYCLES));
    if let Some(program) = compiled(&folder, "#include \"dribblers.cpp\"\n") {
        report("six programs in C++", &program, 6, CYCLES);
        report("one program in C++", &program, 1, CYCLES);
    }
    if let Some(program) = compiled(&folder, ALL_IN_CPP) {
        report("six programs in C++, told all", &program, 6, CYCLES);
    }
    let script = folder.join("in_python.py");
    std::fs::write(&script, IN_PYTHON).unwrap();
    let python = format!("python3 {} {}", script.display(), client("python"));
    for encoding in ["json", "msgpack"] {
        // MessagePack is quick where the package msgpack is.
        report(&format!("six programs in Python, {encoding}"), &format!("{python} fields {encoding}"), 6, CYCLES);
        report(
            &format!("six programs in Python, told all, {encoding}"),
            &format!("{python} all {encoding}"),
            6,
            CYCLES,
        );
    }
    report("one program in Python, json", &format!("{python} fields json"), 1, CYCLES);
    for encoding in ["json", "msgpack"] {
        let name = format!("six programs in Python, each an image a cycle, {encoding}");
        report(&name, &format!("{python} images {encoding}"), 6, IMAGE_CYCLES);
    }
    let _ = std::fs::remove_dir_all(folder);
}

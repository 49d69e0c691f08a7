//! Programs as players: whatever they do, the match goes on, and what they did is in the trace.

use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::game_controller::port_offsets;
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

pub(crate) fn path_of(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The lines of a trace.
pub(crate) fn lines(trace: &Path) -> Vec<Value> {
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
fn a_match_whose_programs_are_all_lost_has_failed() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("misbehaving.py"), MISBEHAVING).unwrap();
    let team = "exec:python3 misbehaving.py leaves";
    let arguments = ["run", "match3v3", "--duration", "0.5", "--agent-start-timeout", "60", "--blue", team];
    let output = naoisis(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("every robot that a program played has lost it"), "{}", text(&output.stderr));
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
    // It may stand, and it is told the ports of its match.
    let standing = "import os\nfrom naoisis_agent import play\nos.environ['NAOISIS_PORT_OFFSET']\nplay(lambda _: {})";
    fs::write(folder.path().join("standing.py"), standing).unwrap();
    let team = format!("exec:env PYTHONPATH={} python3 standing.py", path_of("clients/python").display());
    let offset = port_offsets(1).to_string();
    let network = ["--game-controller", "--team-messages", "--game-controller-port-offset", &offset];
    let output = naoisis(folder.path(), &[&["check", &team, "--agent-timeout", "60"], &network[..]].concat());
    assert!(
        output.status.success() && text(&output.stdout).contains("ok: none, its robot stood"),
        "{}",
        text(&output.stdout)
    );
    for (words, why) in [
        (&["--blue", "roles"][..], "--blue: a program plays as the blue team"),
        (&[][..], "there is no kick `visual`"),
        (&["--scenario", "hsl2026_midle"], "hsl2026_middle"),
        (&["--set", "nothing=1"], "nothing"),
    ] {
        let (status, said) = check_in(words);
        assert!(status == Some(2) && said.contains(why), "{words:?}: {said}");
    }
}

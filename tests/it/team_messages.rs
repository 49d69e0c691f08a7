//! Messages of programs over UDP, and the ports of many matches.

use bevy::prelude::*;
use naoisis::agents::{self, RobotCommand};
use naoisis::communication::{Datagram, Inbox, MessageStatistics, TeamMessage};
use naoisis::cycle::perceive;
use naoisis::events::{CommandKind, CycleEvents, MatchEvent, Refusal};
use naoisis::game_controller::{self, TeamMessages};
use naoisis::prelude::*;
use naoisis::team::PerTeam;
use std::collections::BTreeSet;
use std::fs;
use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;

use crate::game_controller::{free_ports, port_offsets};
use crate::programs::path_of;
use crate::support::{blue, headless_app, naoisis, text};

/// Tells its team-mates what they have told it last, and prints what it hears.
const TALKING: &str = r#"
import os, sys
from naoisis_agent import play
from team_messages import TeamMessages
robot = int(os.environ["NAOISIS_ROBOT"][-1])
messages = TeamMessages()
last = b""
def decide(perception):
    global last
    for message in messages.received():
        print(message.decode(), file=sys.stderr)
        last = message[:40]
    messages.send(b"%d heard %s" % (robot, last))
play(decide, name="talking")
"#;

/// Sends from a socket that is bound to no address, or, with a port, to it at any address, and prints what it hears.
const UNBOUND: &str = r#"
import os, socket, sys
from naoisis_agent import play
robot, offset = os.environ["NAOISIS_ROBOT"], int(os.environ["NAOISIS_PORT_OFFSET"])
port = 10000 + int(os.environ["NAOISIS_TEAM_NUMBER"]) + offset
messages = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
if robot in sys.argv[1:]:
    messages.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    messages.bind(("", port))
messages.setblocking(False)
messages.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
there = "127.255.255.255" if "all" in sys.argv else "127.0.0.1"
def decide(perception):
    messages.sendto(robot.encode(), (there, port))
    try: print("heard", messages.recv(1024).decode(), file=sys.stderr)
    except BlockingIOError: pass
play(decide, fields=["body"])
"#;

/// A socket at a robot's own address.
fn robot_socket(team_number: u8, number: u8, offset: u16) -> UdpSocket {
    let port = 10_000 + u16::from(team_number) + offset;
    let socket = UdpSocket::bind((game_controller::robot_address(team_number, number), port)).unwrap();
    socket.set_nonblocking(true).unwrap();
    socket
}

#[test]
fn what_programs_say_over_udp_is_a_message_of_the_match() {
    let (offset, _control) = free_ports();
    let mut app = headless_app();
    let scenario = r#"{ "rules": "free", "messages": { "delay_cycles": 2 }, "robots": [
        { "team": "blue", "number": 1, "behaviour": "remote" },
        { "team": "blue", "number": 2, "pose": [1, 1, 0], "behaviour": "remote" },
        { "team": "blue", "number": 3, "pose": [1, -1, 0], "behaviour": "idle" },
        { "team": "pink", "number": 1, "pose": [2, 0, 0], "behaviour": "remote" } ] }"#;
    app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
    game_controller::carry(app.world_mut(), TeamMessages::open(PerTeam { blue: 5, pink: 12 }, offset).unwrap());
    let [sender, team_mate, opponent] =
        [(5, 1), (5, 2), (12, 1)].map(|(team, number)| robot_socket(team, number, offset));
    let here = (game_controller::HERE, 10_005 + offset);
    let heard = |socket: &UdpSocket| {
        let mut bytes = [0; 2048];
        let received = core::iter::from_fn(|| socket.recv(&mut bytes).ok().map(|length| bytes[..length].to_vec()));
        received.collect::<Vec<_>>()
    };
    let refusals = |app: &App| {
        let events = app.world().resource::<CycleEvents>().iter();
        events.filter(|event| matches!(event, MatchEvent::CommandRefused { .. })).cloned().collect::<Vec<_>>()
    };
    let refusal = |reason| MatchEvent::CommandRefused { robot: blue(1), command: CommandKind::Say, reason };
    perceive(app.world_mut());
    // Said on the pipe, too: one message.
    let say = TeamMessage { intention: Some("pass".into()), ..default() };
    agents::command(app.world_mut(), blue(1), RobotCommand { say: Some(say), ..default() }).unwrap();
    sender.send_to(b"mine", here).unwrap();
    // A robot with a behaviour, and somebody who is no robot, have nothing to say here.
    robot_socket(5, 3, offset).send_to(b"idle", here).unwrap();
    robot_socket(5, 9, offset).send_to(b"not there", here).unwrap();
    UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap().send_to(b"nobody", here).unwrap();
    app.run_cycles(1);
    assert_eq!(refusals(&app), []);
    for words in [
        "are from no robot",
        "from 127.1.5.3, the address of blue3, are lost: no program plays it",
        "from 127.1.5.9, the address of blue9, are lost: it is not in the match",
    ] {
        let is_told =
            |event: &MatchEvent| matches!(event, MatchEvent::GameController { message } if message.contains(words));
        assert!(app.world().resource::<CycleEvents>().iter().any(is_told), "{words}");
    }
    perceive(app.world_mut());
    assert_eq!(heard(&team_mate).len(), 0);
    app.run_cycles(1);
    perceive(app.world_mut());
    assert_eq!(heard(&team_mate), [b"mine"]);
    assert_eq!((heard(&opponent).len(), heard(&sender).len()), (0, 0));
    let received = &app.robot::<Inbox>(blue(3)).unwrap().0[0].say;
    assert_eq!(
        (received.intention.as_deref(), received.datagram.as_ref()),
        (Some("pass"), Some(&Datagram(b"mine".to_vec())))
    );
    // One a cycle, and none that is too long.
    sender.send_to(b"one", here).unwrap();
    sender.send_to(b"two", here).unwrap();
    app.run_cycles(1);
    assert_eq!(refusals(&app), [refusal(Refusal::NotAllowed)]);
    sender.send_to(&[0; 129], here).unwrap();
    app.run_cycles(1);
    assert_eq!(refusals(&app), [refusal(Refusal::TooLarge)]);
    app.run_cycles(3);
    assert_eq!(heard(&team_mate), [b"one"]);
    assert_eq!(app.world().resource::<MessageStatistics>().blue.sent, 2);
}

#[test]
fn programs_that_talk_over_udp_play_the_same_match_each_time() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("talking.py"), TALKING).unwrap();
    let clients = Path::new(env!("CARGO_MANIFEST_DIR")).join("clients/python");
    let (offset, _control) = free_ports();
    let offset = offset.to_string();
    let play = |trace: &str| {
        let program = format!("exec:env PYTHONPATH={} python3 talking.py", clients.display());
        let common = ["run", "match3v3", "--duration", "2", "--agent-timeout", "60", "--set", "messages.loss=0.3"];
        let messages = ["--team-messages", "--team-numbers", "5,12", "--game-controller-port-offset", &offset];
        let rest = ["--trace", trace, "--blue", &program];
        let output = naoisis(folder.path(), &[&common[..], &messages, &rest].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains("[blue2] 1 heard "), "{}", text(&output.stderr));
        fs::read(folder.path().join(trace)).unwrap()
    };
    assert!(play("one.jsonl") == play("other.jsonl"));
}

#[test]
#[cfg(target_os = "linux")]
fn datagrams_of_programs_at_any_address_arrive_or_are_told_to_be_lost() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("unbound.py"), UNBOUND).unwrap();
    let clients = Path::new(env!("CARGO_MANIFEST_DIR")).join("clients/python");
    let (offset, _control) = free_ports();
    let offset = offset.to_string();
    let play = |bound: &str| {
        let program = format!("exec:env PYTHONPATH={} python3 unbound.py {bound}", clients.display());
        let common =
            ["run", "match3v3", "--duration", "1", "--agent-timeout", "60", "--quiet", "--trace", "t.jsonl", "--force"];
        let messages = ["--team-messages", "--team-numbers", "5,12", "--game-controller-port-offset", &offset];
        let output = naoisis(folder.path(), &[&common[..], &messages, &["--blue", &program]].concat());
        let (said, trace) = (text(&output.stderr), fs::read_to_string(folder.path().join("t.jsonl")).unwrap());
        assert!(output.status.success(), "{said}");
        let mut sent = BTreeSet::new();
        for line in trace.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap()) {
            let robots = line["robots"].as_array().into_iter().flatten();
            let heard = robots.flat_map(|robot| robot["inbox"].as_array().cloned().unwrap_or_default());
            let datagrams =
                heard.filter(|message| message["datagram"].is_string() || message["say"]["datagram"].is_string());
            sent.extend(datagrams.map(|message| message["from"].as_str().unwrap().to_owned()));
        }
        (sent, said, trace)
    };
    // Each by its process; the one that listens hears its team-mates.
    let (sent, said, trace) = play("blue2");
    assert!(sent.len() == 3 && !trace.contains("game_controller"), "{sent:?} {said}");
    let heard: Vec<&str> = said.lines().filter_map(|line| line.split("heard ").nth(1)).collect();
    assert!(heard.len() > 10 && heard.iter().all(|from| ["blue1", "blue3"].contains(from)), "{said}");
    // To all addresses, the match is not heard.
    let (sent, said, _) = play("blue2 to all");
    assert!(sent.is_empty() && said.contains("do not come to the match: only programs that listen"), "{said}");
    // Those that share an address cannot be told apart.
    let (sent, said, trace) = play("blue1 blue3");
    assert_eq!(sent.into_iter().collect::<Vec<_>>(), ["blue2"], "{said}");
    for told in [&said, &trace] {
        assert!(
            told.contains(
                "are lost, because the programs of blue1, blue3 share this address; expected the address 127.1.5.N"
            ),
            "{said}"
        );
    }
}

/// Number 3 hears of the game at the ports of its match, and ends with an error if it has not.
const LISTENING_TO_THE_GAME: &str = r#"
import os, socket, sys
from naoisis_agent import play
offset, team = int(os.environ["NAOISIS_PORT_OFFSET"]), int(os.environ["NAOISIS_TEAM_NUMBER"])
robot = int(os.environ["NAOISIS_ROBOT"][-1])
game = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
if robot == 3: game.bind(("127.0.0.1", 3838 + offset))
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
    assert cycles < 28 or heard or robot != 3
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
    // One for the match itself and one for each of three that are played at the same time.
    let first = port_offsets(4).to_string();
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
        let mut command = std::process::Command::new("env");
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
    // Forked matches, and those of pairs of teams.
    let places = |said: &str| -> BTreeSet<String> {
        said.lines().filter_map(|line| line.split("] team ").nth(1)?.split(" at ").nth(1)).map(str::to_owned).collect()
    };
    play(&["run", "match.json", "--trace", "match.jsonl"]);
    let (said, report) = play(&["whatif", "match.jsonl@0.5", "--times", "3", "--until", "1"]);
    assert!(places(&said).len() == 4 && report.contains("3 times"), "{said}{report}");
    let pair = "exec:python3 listening.py,chasers";
    let (said, report) =
        play(&["batch", "match3v3", "--duration", "1", "--pairs", pair, "--matches", "2", "--threads", "2"]);
    assert!(places(&said).len() == 2 && !said.contains("lost") && report.contains("2 of 2 matches"), "{said}{report}");
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

//! The clients in other languages: the small team that each comes with plays the same match, and so does the same team as a
//! behaviour.

use bevy::prelude::*;
use naoisis::agents::{self, AgentSettings, AgentsPlugin, RobotCommand, Server};
use naoisis::game::GameState;
use naoisis::interface::gather::{CurrentRecord, gather_start};
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;
use naoisis::robot::posture::PostureCommand;
use naoisis::sensing::status::BodyStatus;
use naoisis::simulation::give_belief;
use serde_json::{Map, Value, json};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::{begin_trace, headless_app, naoisis, text};

/// Long enough for kicks.
const DURATION_S: &str = "40";

fn client(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("clients").join(path).display().to_string()
}

/// What is true and commanded in each cycle of a match in which a program plays in blue.
fn match_of(program: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let team = format!("exec:{program}");
    let output = naoisis(
        folder.path(),
        &["run", "match3v3", "--duration", DURATION_S, "--blue", &team, "--agent-timeout", "60", "--trace", "t.jsonl"],
    );
    assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    // The header says what plays, the end what became of it.
    let trace = fs::read_to_string(folder.path().join("t.jsonl")).unwrap();
    let lines: Vec<String> = trace.lines().map(str::to_owned).collect();
    lines[1..lines.len() - 1].to_vec()
}

/// The team of the clients, as a behaviour, with commands as precise as those of programs.
#[derive(Component, Default)]
struct Dribbler;

/// How far the robots of the match walk in a cycle, m, as the clients compute it.
const STEP_M: f64 = 0.006;

fn rounded(number: f64) -> f64 {
    (1e6 * number + 0.5).floor() / 1e6
}

/// A place of the team's frame in the frame of the robot, m.
fn in_robot_frame(place: [f64; 2], pose: [f64; 3]) -> [f64; 2] {
    let [x, y] = [place[0] - pose[0], place[1] - pose[1]];
    let (sin, cos) = (pose[2] * (core::f64::consts::PI / 180.0)).sin_cos();
    [rounded(cos * x + sin * y), rounded(cos * y - sin * x)]
}

fn turn_towards([x, y]: [f64; 2]) -> f64 {
    (if x > 0.1 { 30.0 * y / x } else { 1e9 * y }).clamp(-3.0, 3.0)
}

/// Decides as the clients do in `match3v3`, where nobody walks in and kicks have no regions.
fn decide(status: &GameStatus, body: BodyStatus, belief: &Belief) -> Value {
    if status.penalised || status.state != GameState::Playing {
        return json!({});
    }
    if body == BodyStatus::Fallen {
        return json!({ "posture": "get_up" });
    }
    // The numbers as other languages read them: what is written of them, in double precision.
    let belief: Value = serde_json::from_str(&serde_json::to_string(belief).unwrap()).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let pose = [0, 1, 2].map(|index| number(&belief["pose"][index]));
    if belief["ball"].is_null() || number(&belief["ball"]["age_s"]) > 2.0 {
        return json!({ "walk": [0.0, 0.0, 3.0], "head_deg": [0.0, if pose[2] > 0.0 { 30.0 } else { 0.0 }] });
    }
    let place = [0, 1].map(|index| number(&belief["ball"]["position_m"][index]));
    let (ball, goal) = (in_robot_frame(place, pose), in_robot_frame([3.0, 0.0], pose));
    let mut command = json!({
        "head_deg": [0.0, if ball[0] < 0.5 { 40.0 } else { 0.0 }],
        "say": { "intention": "dribble", "payload": if ball[0] < 1.0 { "near" } else { "far" } },
    });
    let is_near = 0.0 < ball[0] && ball[0] < 0.5 && ball[1].abs() < 0.25;
    if is_near && !(goal[0] > 0.0 && goal[1].abs() < 0.15 * goal[0]) {
        let side = if goal[1] > 0.0 { -1.0 } else { 1.0 };
        let turn = 0.3 * turn_towards(ball) - side * 28.0 * STEP_M / ball[0].max(0.1);
        command["walk"] = json!([0.1 * (ball[0] - 0.17), side * STEP_M / 2.0, turn].map(rounded));
    } else if is_near && ball[0] < 0.17 && ball[1].abs() < 0.08 {
        let foot = if ball[1] > 0.0 { "left_straight" } else { "right_straight" };
        command["kick"] = json!({ "type": foot, "speed": 1.0 });
    } else if is_near {
        command["walk"] = json!([0.1 * (ball[0] - 0.8 * 0.17), 0.05 * ball[1], 0.3 * turn_towards(ball)].map(rounded));
    } else {
        command["walk"] = json!([STEP_M, 0.0, rounded(turn_towards(ball))]);
    }
    command
}

fn dribble(
    mut robots: Query<
        (
            (&GameStatus, &BodyStatus, &Belief),
            (&mut WalkCommand, &mut HeadCommand, &mut KickCommand, &mut PostureCommand, &mut Outbox),
        ),
        With<Dribbler>,
    >,
) {
    for ((status, body, belief), (mut walk, mut head, mut kick, mut posture, mut outbox)) in &mut robots {
        let command = RobotCommand::from_value(&decide(status, *body, belief)).unwrap().rounded();
        if let Some(wanted) = command.walk {
            *walk = wanted;
        }
        if let Some(wanted) = command.head {
            *head = wanted;
        }
        (kick.0, posture.0, outbox.0) = (command.kick, command.posture, command.say);
    }
}

#[test]
fn the_team_of_each_client_plays_the_same_match_and_so_does_the_behaviour() {
    let folder = tempfile::tempdir().unwrap();
    let cpp = folder.path().join("dribblers");
    let mut compiler = Command::new("c++");
    compiler.args(["-std=c++17", "-O1", "-Wall", "-Wextra", "-Werror", "-o"]).arg(&cpp);
    assert!(compiler.arg(client("cpp/dribblers.cpp")).status().unwrap().success());
    let python = match_of(&format!("python3 {}", client("python/dribblers.py")));
    assert!(python.iter().any(|line| line.contains("\"kind\":\"kick\"")), "nobody kicks");
    assert!(python == match_of(&cpp.display().to_string()), "C++");
    // Not every machine has it.
    if Command::new("node").arg("--version").output().is_ok() {
        assert!(python == match_of(&format!("node {}", client("javascript/dribblers.js"))), "JavaScript");
    }

    let mut app = headless_app();
    app.add_behaviour::<Dribbler, _>("dribbler", dribble).add_team("dribblers", "They dribble.", |_, _| "dribbler");
    let mut scenario = Scenario::named("match3v3").unwrap();
    scenario.teams.as_mut().unwrap().blue = "dribblers".to_owned();
    app.start_match(&scenario).unwrap();
    // The programs ask for beliefs.
    for number in 1..=3 {
        give_belief(app.world_mut(), RobotId::new(Team::Blue, number));
    }
    let trace = begin_trace(&mut app);
    app.run_cycles(python.len() - 1);
    let trace = text(&trace.written());
    for (behaviour, program) in trace.lines().skip(1).zip(&python) {
        assert_eq!(behaviour, program);
    }
    assert_eq!(trace.lines().count(), 1 + python.len());
}

/// The client's own MessagePack, whatever is installed, and a team in either encoding.
const BY_MESSAGE_PACK: &str = r#"
import json, sys
sys.modules["msgpack"] = None
sys.path.insert(0, sys.argv[1])
import naoisis_message_pack
if sys.argv[2] == "unpack":
    for line in sys.stdin:
        value = naoisis_message_pack.unpack(bytes.fromhex(line))
        print(json.dumps([value, naoisis_message_pack.pack(value).hex()]))
else:
    from naoisis_agent import play
    def decide(perception):
        ball = perception["percepts"]["ball"]
        if ball is None:
            return {"walk": [0.0, 0.0, 3.0], "head_deg": [0.0, 15.0]}
        x, y = ball["position_m"]
        turn = 3.0 if y > 0.1 * x else -3.0 if y < -0.1 * x else 0.0
        return {"walk": [0.006, 0.0, turn], "say": {"intention": "dribble", "payload": "near" if x < 1.0 else "far"}}
    play(decide, encoding=sys.argv[2], images=sys.argv[3:])
"#;

#[test]
fn the_python_client_reads_and_writes_message_pack() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("packing.py"), BY_MESSAGE_PACK).unwrap();
    let text_of = |length: usize| Value::from("é".repeat(length));
    let values = [
        json!({ "none": null, "yes": true, "no": false, "double": -0.1, "empty": [{}, [], ""] }),
        json!([0, 127, 128, 255, 256, 65_535, 65_536, u64::MAX, -1, -32, -33, -128, -129, -40_000, i64::MIN]),
        json!([text_of(15), text_of(16), text_of(200), text_of(40_000)]),
        json!([vec![1; 15], vec![1; 16], vec![1; 70_000]]),
        (0..40).map(|number| (number.to_string(), json!([number, number]))).collect::<Map<_, _>>().into(),
    ];
    let hexadecimal = |bytes: Vec<u8>| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let packed = values.each_ref().map(|value| hexadecimal(rmp_serde::to_vec_named(value).unwrap()) + "\n");
    let mut python = Command::new("python3");
    python.current_dir(folder.path()).args(["packing.py", &client("python"), "unpack"]);
    fs::write(folder.path().join("packed"), packed.concat()).unwrap();
    let output = python.stdin(fs::File::open(folder.path().join("packed")).unwrap()).output().unwrap();
    let unpacked: Vec<Value> = text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(unpacked.len(), values.len());
    for (value, line) in values.iter().zip(&unpacked) {
        assert_eq!(&line[0], value);
        let bytes: Vec<u8> = line[1].as_str().unwrap().as_bytes().chunks(2).map(from_hexadecimal).collect();
        assert_eq!(&rmp_serde::from_slice::<Value>(&bytes).unwrap(), value);
    }
}

fn from_hexadecimal(byte: &[u8]) -> u8 {
    u8::from_str_radix(core::str::from_utf8(byte).unwrap(), 16).unwrap()
}

#[test]
fn a_python_team_plays_the_same_match_in_message_pack() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("packing.py");
    fs::write(&program, BY_MESSAGE_PACK).unwrap();
    let team = |encoding: &str| format!("python3 {} {} {encoding}", program.display(), client("python"));
    assert!(match_of(&team("msgpack")) == match_of(&team("json")));
    // Who is refused is told why in words that it understands.
    let team = format!("exec:{} top", team("msgpack"));
    let output = naoisis(
        folder.path(),
        &["run", "match3v3", "--duration", "0.1", "--cameras", "off", "--agent-start-timeout", "60", "--blue", &team],
    );
    assert!(text(&output.stderr).contains("Refused: it wants camera images, but none"), "{}", text(&output.stderr));
}

/// A program that kicks in each cycle.
const KICKING: &str = r#"
import sys
sys.path.insert(0, sys.argv[1])
from naoisis_agent import Agent

agent = Agent(name="kicking")
told = set()
for turn in agent.turns():
    told |= {f"{refused['command']}: {refused['reason']}" for refused in turn.get("refused", [])}
    agent.answer(turn, {"kick": {"type": "left_straight", "speed": 1.0}})
print("told", sorted(told), file=sys.stderr)
"#;

#[test]
fn a_program_is_told_that_its_robot_did_not_kick_and_the_terminal_counts_the_misses() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("kicking.py");
    fs::write(&program, KICKING).unwrap();
    let team = format!("exec:python3 {} {}", program.display(), client("python"));
    let output =
        naoisis(folder.path(), &["run", "match3v3", "--duration", "2", "--agent-start-timeout", "60", "--blue", &team]);
    assert!(text(&output.stderr).contains("told ['kick: not_allowed']"), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    for miss in ["x left_straight: busy", "x left_straight: out of reach"] {
        assert!(said.lines().any(|line| line.starts_with("missed kicks of blue3") && line.ends_with(miss)), "{said}");
    }
}

/// A program that asks for everything that the header offers, over a socket.
const CURIOUS: &str = r#"
#include "naoisis_agent.hpp"
#include <limits>
using naoisis::Json;

int main(int, char** arguments) {
    naoisis::Hello hello;
    hello.name = "curious";
    hello.address = arguments[1];
    hello.robot = "blue2";
    hello.token = "secret";
    hello.belief = true;
    hello.images = {"top"};
    hello.fields = {"body"};
    naoisis::Agent agent(hello);
    std::cerr << agent.robot() << ' ' << agent.welcome()["pose"].dump() << ' ' << Json(1L).dump() << '\n';
    while (const Json* turn = agent.next()) {
        if ((*turn)["cycle"].number() == 2) {
            std::cerr << "refused " << (*turn)["refused"][0]["command"].text() << ", "
                      << (*turn)["images"]["top"]["width"].number() << '\n';
        }
        try {
            agent.answer(Json::object({{"walk", {0.0, std::numeric_limits<double>::quiet_NaN(), 0.0}}}));
        } catch (const std::runtime_error& error) {
            if ((*turn)["cycle"].number() == 1) std::cerr << error.what() << '\n';
        }
        const Json posture = Json::object({{"dive", "left"}});
        const Json pose = (*turn)["belief"]["pose"];
        const Json belief = Json::object({{"pose", {pose[0].number(), pose[1].number() + 0.5, 0.0}}});
        agent.answer(Json::object({{"command", Json::object({{"posture", posture}})}, {"belief", belief}, {"intention", "dive"}}));
    }
    std::cerr << agent.end()["reason"].text() << '\n';
}
"#;

#[test]
fn the_header_for_cpp_has_the_whole_protocol_over_sockets() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("curious.cpp"), CURIOUS).unwrap();
    let mut compiler = Command::new("c++");
    compiler.args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-I", &client("cpp"), "curious.cpp", "-o", "curious"]);
    assert!(compiler.current_dir(folder.path()).status().unwrap().success());
    let socket = format!("unix:{}", folder.path().join("socket").display());
    for address in ["tcp:127.0.0.1:0", &socket] {
        let mut server = Server::listen(&address.parse().unwrap()).unwrap();
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, RecordPlugin, AgentsPlugin));
        app.insert_resource(AgentSettings { answer_timeout: None, token: Some("secret".to_owned()), ..default() });
        let scenario = r#"{ "robots": [{ "number": 2, "pose": [-1, 0.5, 0], "behaviour": "remote" }] }"#;
        app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
        let program = Command::new("./curious")
            .arg(server.address().to_string())
            .current_dir(folder.path())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        server.let_in(app.world_mut(), || false, |_| {});
        gather_start(app.world_mut());
        app.run_cycles(5);
        let record = app.world().resource::<CurrentRecord>().record.robots[0].clone();
        let believed = record.belief.unwrap().pose.position;
        assert!((believed.y - 1.0).abs() < 0.2, "{believed}");
        assert_eq!(record.intention.as_deref(), Some("dive"));
        agents::dismiss(app.world_mut(), "enough");
        let said = text(&program.wait_with_output().unwrap().stderr);
        assert_eq!(said, "blue2 [-1,0.5,0] 1\na number to send is not finite\nrefused posture, 320\nenough\n");
    }
}

#[test]
fn the_teams_of_the_clients_kick_in_leagues_with_white_goals_and_robots_that_aim() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = json!({
        "league": "hsl2026_middle", "rules": "free", "duration_s": 40, "ball": { "position_m": [4.0, 0.3] },
        "robots": [{ "number": 1, "pose": [3, 0, 0], "behaviour": { "program": ["python3", client("python/dribblers.py")] } }],
    });
    fs::write(folder.path().join("kick.json"), scenario.to_string()).unwrap();
    let output = naoisis(folder.path(), &["run", "kick.json", "--agent-timeout", "60", "--expect", "blue.kicks >= 1"]);
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
}

#[test]
fn a_team_of_a_client_that_waits_for_a_kick_off_is_not_removed_as_inactive() {
    let folder = tempfile::tempdir().unwrap();
    let team = format!("exec:python3 {}", client("python/dribblers.py"));
    let trace = ["--trace", "waiting.jsonl", "--trace-fields", "events"];
    let arguments = ["run", "hsl2026_small", "--duration", "60", "--agent-timeout", "60", "--quiet", "--blue", &team];
    let output = naoisis(folder.path(), &[&arguments[..], &trace].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let trace = fs::read_to_string(folder.path().join("waiting.jsonl")).unwrap();
    assert!(trace.contains("\"state\":\"playing\"") && !trace.contains("\"reason\":\"inactive\""));
}

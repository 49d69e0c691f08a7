//! The packets that a match sends in the place of the league's GameController, and a team that plays by them alone.

use bevy::prelude::*;
use naoisis::communication::StatusReport;
use naoisis::game::{GameState, PenaltyReason};
use naoisis::game_controller::{
    self, ControlPacket, Division, GameController, GameControllerSettings, NetworkSettings, PortOffsets,
    ProtocolVersion, ReturnPacket, TeamColours,
};
use naoisis::prelude::*;
use naoisis::robot::jersey::Jersey;
use naoisis::team::PerTeam;
use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use crate::support::{blue, headless_app, naoisis, text};

/// Returns the first of `count` successive [`PortOffsets`] that no other test uses.
///
/// No port at one of them is a port at another. A match uses ports 3636 to 3940, and 10,005 and 10,012 for its teams. The
/// highest, 32,012, is below those that systems give to sockets that ask for any.
pub(crate) fn port_offsets(count: usize) -> u16 {
    /// More than all tests of this crate use.
    const MOST: usize = 25;
    static FIRST: OnceLock<u16> = OnceLock::new();
    static TAKEN: AtomicUsize = AtomicUsize::new(0);
    let first = *FIRST.get_or_init(|| {
        let is_free = |port: u16| UdpSocket::bind((Ipv4Addr::LOCALHOST, port)).is_ok();
        let all_free = |first: &u16| {
            let mut offsets = PortOffsets::new(*first).all().take(MOST);
            offsets
                .all(|offset| [3636, 3838, 3939, 3940, 10_005, 10_012].into_iter().all(|port| is_free(port + offset)))
        };
        let start = (std::process::id() % 1000) as u16;
        (0..1000).map(|each| 1 + (start + 7 * each) % 1000).find(all_free).expect("free ports")
    });
    let taken = TAKEN.fetch_add(count, Ordering::Relaxed);
    assert!(taken + count <= MOST, "more port offsets than there are");
    PortOffsets::new(first).all().nth(taken).unwrap()
}

/// Returns a port offset that no other test uses, and a socket that receives its control packets.
pub(crate) fn free_ports() -> (u16, UdpSocket) {
    let offset = port_offsets(1);
    let control = UdpSocket::bind((Ipv4Addr::LOCALHOST, 3838 + offset)).expect("a free port");
    control.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    (offset, control)
}

pub(crate) fn settings(version: ProtocolVersion, port_offset: u16) -> GameControllerSettings {
    let network = NetworkSettings { port_offset, ..default() };
    GameControllerSettings {
        version,
        network,
        team_numbers: PerTeam { blue: 5, pink: 12 },
        at_once: false,
        colours: None,
    }
}

/// The same, and monitors that ask are told the truth.
fn told_to_monitors(settings: GameControllerSettings) -> GameControllerSettings {
    let network = NetworkSettings { tells_monitors: true, ..settings.network };
    GameControllerSettings { network, ..settings }
}

/// A match of which a GameController tells.
pub(crate) fn told_match(scenario: &str, settings: GameControllerSettings) -> App {
    let mut app = headless_app();
    app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
    game_controller::start(app.world_mut(), GameController::open(settings).unwrap());
    app
}

/// The packets that have come.
pub(crate) fn packets(socket: &UdpSocket) -> Vec<ControlPacket> {
    socket.set_nonblocking(true).unwrap();
    let mut bytes = [0; 1024];
    core::iter::from_fn(|| {
        socket.recv(&mut bytes).ok().map(|length| ControlPacket::from_bytes(&bytes[..length]).unwrap())
    })
    .collect()
}

#[test]
fn robots_are_told_twice_a_second() {
    let (offset, control) = free_ports();
    let scenario = r#"{ "rules": "naoisis", "teams": { "blue": "chasers", "pink": "chasers" }, "messages": { "max_text_bytes": 512 },
        "interventions": [ { "at_s": 2.1, "do": { "penalise": { "robot": "blue2", "reason": "pushing" } } } ] }"#;
    let mut app = told_match(scenario, settings(ProtocolVersion::V20, offset));
    app.run_cycles(3 * 30);
    let told = packets(&control);
    // At the beginning, and every half second: the penalty 0.4 s late.
    let code = ProtocolVersion::V20.penalty_code(PenaltyReason::Pushing);
    let codes: Vec<u8> = told.iter().map(|packet| packet.teams[0].players[1].penalty).collect();
    assert_eq!(codes, [0, 0, 0, 0, 0, code, code]);
}

#[test]
fn packets_tell_the_jerseys_that_robots_wear_unless_others_are_chosen() {
    let (offset, control) = free_ports();
    let scenario = |blue: &str| {
        format!(
            r#"{{ "rules": "spl2025", "robots": [
                {{ "team": "blue", "number": 1, "pose": [-2, 0, 0], "body": {{ "jersey": "purple" }} }},
                {{ "team": "blue", "number": 2, "pose": [-1, 0, 0]{blue} }},
                {{ "team": "pink", "number": 1, "pose": [1, 0, 180], "body": {{ "jersey": "team" }} }} ] }}"#
        )
    };
    // Of the packet's bytes: the number and the two colours of each team.
    let bytes_of = |blue: &str, colours| {
        let settings = GameControllerSettings { colours, ..settings(ProtocolVersion::V20, offset) };
        let _app = told_match(&scenario(blue), settings);
        let mut bytes = [0; 256];
        let length = control.recv(&mut bytes).unwrap();
        let of_team = |start: usize| [bytes[start], bytes[start + 1], bytes[start + 2]];
        [of_team(18), of_team(18 + (length - 18) / 2)]
    };
    assert_eq!(bytes_of(r#", "body": { "jersey": "black" }"#, None), [[5, 3, 7], [12, 1, 1]]);
    // Without a jersey, blue.
    assert_eq!(bytes_of("", None), [[5, 0, 7], [12, 1, 1]]);
    let chosen = TeamColours { players: Jersey::White, goalkeeper: Jersey::Grey };
    let colours = Some(PerTeam { blue: chosen, pink: TeamColours { players: Jersey::Green, ..chosen } });
    assert_eq!(bytes_of("", colours), [[5, 4, 9], [12, 5, 9]]);
}

#[test]
fn robots_are_told_of_the_end_of_the_match() {
    let (offset, control) = free_ports();
    let scenario = r#"{ "rules": { "preset": "naoisis", "half_s": 1.1, "halves": 1 }, "teams": { "blue": "chasers", "pink": "chasers" } }"#;
    let mut app = told_match(scenario, settings(ProtocolVersion::V20, offset));
    while !app.is_finished() {
        app.run_cycles(1);
    }
    // As for five seconds after it, in case that one is lost.
    let finished = packets(&control).iter().rev().take_while(|packet| packet.state == GameState::Finished).count();
    assert_eq!(finished, 11);
}

#[test]
fn robots_are_told_of_each_change_where_that_is_asked_for() {
    let (offset, control) = free_ports();
    let scenario = r#"{ "rules": "naoisis", "teams": { "blue": "chasers", "pink": "chasers" },
        "interventions": [ { "at_s": 2.1, "do": { "penalise": { "robot": "blue2", "reason": "pushing" } } } ] }"#;
    let settings = GameControllerSettings { at_once: true, ..settings(ProtocolVersion::V19, offset) };
    let mut app = told_match(scenario, settings);
    app.run_cycles(60);
    let told = packets(&control);
    // The beginning, that play begins, and every half second.
    assert_eq!(told.iter().filter(|packet| packet.state == GameState::Initial).count(), 1);
    assert_eq!(told.iter().filter(|packet| packet.state == GameState::Playing).count(), 1 + 4);
    assert!(told.iter().enumerate().all(|(number, packet)| usize::from(packet.packet_number) == number));
    assert_eq!(told.last().map(|packet| packet.seconds_left), Some(598));
    app.run_cycles(4);
    let told = packets(&control);
    let codes: Vec<u8> = told.iter().map(|packet| packet.teams[0].players[1].penalty).collect();
    assert_eq!(codes, [ProtocolVersion::V19.penalty_code(PenaltyReason::Pushing)]);
}

/// Sockets at an address of this machine that do not wait: one that asks, and those where monitors are told of the game and of robots.
pub(crate) fn monitor(address: Ipv4Addr, offset: u16) -> [UdpSocket; 3] {
    [0, 3838 + offset, 3940 + offset].map(|port| {
        let socket = UdpSocket::bind((address, port)).unwrap();
        socket.set_nonblocking(true).unwrap();
        socket
    })
}

#[test]
fn what_robots_report_is_on_them_and_monitors_that_are_no_robots_are_told_the_truth() {
    let (offset, control) = free_ports();
    let scenario = r#"{ "rules": { "preset": "spl2025", "standby_s": 1.0, "ready_s": 1.0, "set_s": 1.0 },
        "robots": [ { "team": "blue", "number": 1, "behaviour": "idle" }, { "team": "pink", "number": 1, "pose": [1, 0, 180] } ] }"#;
    let settings = GameControllerSettings { at_once: true, ..told_to_monitors(settings(ProtocolVersion::V18, offset)) };
    let mut app = told_match(scenario, settings);
    let robot = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let [asking, game, forwarded] = monitor(Ipv4Addr::new(127, 0, 0, 2), offset);
    for socket in [&robot, &asking] {
        socket.send_to(b"RGTr\0", (Ipv4Addr::LOCALHOST, 3636 + offset)).unwrap();
    }
    app.run_cycles(1);
    let report = StatusReport { fallen: true, pose: Pose::new(-1.0, 0.5, 0.25), ..default() };
    let packet = ReturnPacket { player: 1, team: 5, report }.to_bytes();
    for bytes in [&packet[..], &packet[1..], b"nonsense"] {
        robot.send_to(bytes, (Ipv4Addr::LOCALHOST, 3939 + offset)).unwrap();
    }
    app.run_cycles(1);
    let reported = app.robot::<StatusReport>(blue(1)).unwrap();
    assert_eq!((reported.pose, reported.fallen, reported.ball_m), (report.pose, true, None));
    assert!(reported.time_s > 0.0);
    let mut bytes = [0; 64];
    let length = forwarded.recv(&mut bytes).unwrap();
    assert_eq!(bytes[..length], [&[127, 0, 0, 1][..], &packet].concat());
    // Who asks is told, but who has reported is a robot, and is told the truth no more, even if it asks again.
    assert!(packets(&control).iter().any(|packet| packet.for_monitors));
    robot.send_to(b"RGTr\0", (Ipv4Addr::LOCALHOST, 3636 + offset)).unwrap();
    // Play begins after standby, ready and set; robots are told 15 s later.
    app.run_cycles(5 * 30);
    let (truth, told) = (packets(&game), packets(&control));
    let has_played = |packets: &[ControlPacket]| packets.iter().any(|packet| packet.state == GameState::Playing);
    assert!(truth.iter().all(|packet| packet.for_monitors) && told.iter().all(|packet| !packet.for_monitors));
    assert!(has_played(&truth) && !has_played(&told) && !told.is_empty());
}

#[test]
fn a_kick_off_is_told_as_a_gamecontroller_tells_it() {
    let (offset, control) = free_ports();
    let scenario = r#"{ "field": "hsl2026_middle",
        "rules": { "preset": "spl2025", "standby_s": 0.0, "ready_s": 1.0, "set_s": 2.0, "status_delay_s": 0.0 },
        "robots": [ { "team": "blue", "number": 1, "behaviour": "idle" }, { "team": "pink", "number": 1, "pose": [1, 0, 180] } ] }"#;
    let mut app = told_match(scenario, settings(ProtocolVersion::V19, offset));
    app.run_cycles(14 * 30);
    let told = packets(&control);
    assert!(told.iter().all(|packet| packet.division == Division::Middle));
    let seconds = |state| {
        let told = told.iter().filter(|packet| packet.state == state);
        told.map(|packet| (packet.kicking_team, packet.secondary_seconds_left)).collect::<Vec<_>>()
    };
    // Nobody is told when the whistle comes.
    let in_set = seconds(GameState::Set);
    assert!(in_set.len() >= 4 && in_set.iter().all(|told| *told == (Some(5), 0)), "{in_set:?}");
    // The ball is the team's own for ten seconds, and then nobody's.
    let in_play = seconds(GameState::Playing);
    let over = in_play.iter().position(|told| *told == (None, 0)).unwrap();
    let (kick_off, rest) = in_play.split_at(over);
    assert_eq!((kick_off.first(), kick_off.last()), (Some(&(Some(5), 10)), Some(&(Some(5), 1))));
    assert!(
        kick_off.is_sorted_by_key(|(_, seconds)| -seconds) && rest.iter().all(|told| *told == (None, 0)),
        "{in_play:?}"
    );
}

#[test]
#[cfg(target_os = "linux")]
fn a_team_that_is_told_of_the_game_over_udp_plays_as_one_that_is_told_by_the_match() {
    let folder = tempfile::tempdir().unwrap();
    let client = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("clients/python").join(name);
    let (offset, control) = free_ports();
    drop(control);
    let offset = offset.to_string();
    let play = |arguments: &[&str], program: String, trace: &str| {
        let common = ["run", "match3v3", "--duration", "8", "--agent-timeout", "60", "--trace", trace, "--blue"];
        let output = naoisis(folder.path(), &[&common[..], &[&program], arguments].concat());
        assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
        let trace = std::fs::read_to_string(folder.path().join(trace)).unwrap();
        let lines: Vec<serde_json::Value> = trace.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        lines[1..lines.len() - 1].to_vec()
    };
    let told = play(
        &[
            "--game-controller",
            "v18",
            // To the cycle, as the match tells.
            "--game-controller-at-once",
            "--team-numbers",
            "5,12",
            "--game-controller-port-offset",
            &offset,
            "--game-controller-address",
            "127.255.255.255",
        ],
        format!("exec:python3 {} 5 {offset}", client("controlled_dribblers.py").display()),
        "told.jsonl",
    );
    let by_match = play(&[], format!("exec:python3 {}", client("dribblers.py").display()), "match.jsonl");
    let mut reports = 0;
    for (mut line, expected) in told.into_iter().zip(&by_match) {
        for robot in line["robots"].as_array_mut().unwrap() {
            reports += usize::from(robot.as_object_mut().unwrap().remove("reported").is_some());
        }
        assert_eq!(&line, expected);
    }
    assert_eq!(reports, 3 * (by_match.len() - 1));
}

#[test]
fn a_port_in_use_is_a_mistake_of_the_command_line_and_so_are_numbers_that_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let (offset, _control) = free_ports();
    let _other = UdpSocket::bind((Ipv4Addr::LOCALHOST, 3939 + offset)).unwrap();
    let offset = offset.to_string();
    for (arguments, said) in [
        (
            &["--game-controller", "v18", "--game-controller-port-offset", &offset][..],
            "expected a free port, as with --game-controller-port-offset",
        ),
        (&["--game-controller", "v17"], "v18"),
        (&["--game-controller", "v18", "--team-numbers", "5"], "two different numbers"),
        (&["--game-controller", "v18", "--team-numbers", "5,5"], "two different numbers"),
        (&["--game-controller", "v18", "--game-controller-address", "here"], "invalid"),
        (&["--team-numbers", "5,12"], "--game-controller"),
        (&["--truth-for-monitors"], "--game-controller"),
        (&["--team-messages", "--truth-for-monitors"], "--game-controller"),
        (&["--pace", "0"], "multiple of real time"),
    ] {
        let output = naoisis(folder.path(), &[&["run", "match3v3", "--duration", "1"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(text(&output.stderr).contains(said), "{arguments:?}: {}", text(&output.stderr));
    }
}

#[test]
fn a_brief_stop_is_told_in_a_burst_and_the_clocks_stand_in_it() {
    let (offset, control) = free_ports();
    // The ball rolls over the side line, and the kick-in begins with a stop of three seconds.
    let scenario = r#"{ "league": "hsl2026_middle", "rules": { "preset": "naoisis", "ball_out": true, "ball_out_restart": "free_kick", "free_kick_stop_s": 3 },
        "ball": { "position_m": [1, 4.2], "velocity_mps": [0, 1.5] },
        "robots": [ { "team": "blue", "number": 2, "pose": [-3, 1, 0], "behaviour": "idle" } ] }"#;
    let mut app = told_match(scenario, settings(ProtocolVersion::V20, offset));
    // The time of each packet with its number of cycles since the stop began, and the seconds that are left.
    let (mut since_stop, mut told) = (None, Vec::new());
    for _ in 0..5 * 30 {
        app.run_cycles(1);
        let is_stopped = app.game().stop.is_some();
        since_stop = is_stopped.then(|| since_stop.map_or(0, |cycles| cycles + 1));
        told.extend(packets(&control).into_iter().map(|packet| (since_stop, packet.is_stopped, packet.seconds_left)));
    }
    let in_stop: Vec<_> = told.iter().filter(|(.., is_stopped, _)| *is_stopped).collect();
    let seconds: Vec<i16> = in_stop.iter().map(|(.., seconds)| *seconds).collect();
    assert!(seconds.windows(2).all(|pair| pair[0] == pair[1]), "{seconds:?}");
    // At once and five times at 200 ms, in addition to those at every half second.
    let cycles: Vec<_> = in_stop.iter().filter_map(|(since_stop, ..)| *since_stop).collect();
    assert!((0..=5).all(|number| cycles.contains(&(number * 6))), "{cycles:?}");
    assert!(cycles.len() <= 6 + 6, "{cycles:?}");
    assert!(told.first().is_some_and(|(.., is_stopped, _)| !is_stopped));
    assert!(told.last().is_some_and(|(.., is_stopped, _)| !is_stopped), "play goes on");
}

//! A match that a GameController of the league decides: it is heard over UDP.

use bevy::prelude::*;
use naoisis::events::MatchEvent;
use naoisis::game::{Game, GameState, Penalty, PenaltyReason};
use naoisis::game_controller::packet::TeamPacket;
use naoisis::game_controller::{self, ControlPacket, Division, GamePhase, Listener, ProtocolVersion, ReturnPacket};
use naoisis::prelude::*;
use std::net::{Ipv4Addr, UdpSocket};
use std::sync::mpsc;
use std::time::Duration;

use crate::game_controller::{free_ports, monitor, packets, settings, told_match};
use crate::support::{blue, headless_app, pink};

/// A team in a packet.
fn team(number: u8) -> TeamPacket {
    TeamPacket { number, ..TeamPacket::default() }
}

/// What a GameController says of a match before it begins.
fn said(version: ProtocolVersion) -> ControlPacket {
    ControlPacket {
        version,
        for_monitors: false,
        packet_number: 0,
        players_per_team: 7,
        is_knockout: false,
        division: Division::Small,
        is_stopped: false,
        phase: GamePhase::Normal,
        state: GameState::Initial,
        set_play: None,
        is_first_half: true,
        kicking_team: Some(12),
        seconds_left: 600,
        secondary_seconds_left: 0,
        teams: [team(5), team(12)],
    }
}

#[test]
fn a_real_gamecontroller_decides_about_the_match() {
    let (offset, control) = free_ports();
    drop(control);
    let mut app = headless_app();
    let scenario = r#"{ "rules": "spl2025", "teams": { "blue": "roles", "pink": "chasers" } }"#;
    app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
    let listener = Listener::open(Ipv4Addr::LOCALHOST.into(), offset, None).unwrap();
    let (sender, notes) = mpsc::channel();
    let listener = listener.with_notes(move |note| drop(sender.send(note.to_owned()))).with_truth_for_monitors();
    game_controller::listen_to(app.world_mut(), listener);
    let reports = UdpSocket::bind((Ipv4Addr::LOCALHOST, 3939 + offset)).unwrap();
    reports.set_nonblocking(true).unwrap();
    let mut packet = said(ProtocolVersion::V18);
    let operator = UdpSocket::bind((Ipv4Addr::LOCALHOST, 3636 + offset)).unwrap();
    operator.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let say = |packet: &ControlPacket| {
        operator.send_to(&packet.to_bytes(), (Ipv4Addr::LOCALHOST, 3838 + offset)).unwrap();
    };
    // Robots stand until somebody says something, and then still, in `initial`.
    let place = |app: &App| app.robot_pose(blue(2)).unwrap();
    let start = place(&app);
    app.run_cycles(60);
    say(&packet);
    app.run_cycles(60);
    assert_eq!((app.game().state, place(&app)), (GameState::Initial, start));
    assert_eq!(notes.try_recv().unwrap(), "a GameController of version 18 is heard: team 5 is blue, 12 pink");
    // The GameController has the port for monitors itself.
    let note = format!("monitors that ask at 127.0.0.1:{} receive the true state", 3637 + offset);
    assert_eq!(notes.try_recv().unwrap(), note);
    // Each robot reports from an address of its own, twice in two seconds.
    let mut bytes = [0; 64];
    let reported = core::iter::from_fn(|| {
        let (length, from) = reports.recv_from(&mut bytes).ok()?;
        Some((from.ip(), ReturnPacket::from_bytes(&bytes[..length], 0.0).unwrap()))
    });
    let reported: Vec<_> = reported.collect();
    let of_blue2 = reported.iter().filter(|(from, _)| *from == game_controller::robot_address(5, 2));
    let of_blue2: Vec<_> = of_blue2.map(|(_, packet)| packet).collect();
    assert_eq!((reported.len(), of_blue2.len()), (2 * 14, 2));
    assert!(of_blue2.iter().all(|packet| (packet.player, packet.team) == (2, 5)));
    assert!(of_blue2[1].report.pose.position.distance(start.position) < 0.5, "{of_blue2:?}, {start:?}");
    // What another match says is none of its business, and it says so once.
    let stranger = ControlPacket { state: GameState::Playing, teams: [team(5), team(6)], ..packet.clone() };
    for _ in 0..2 {
        say(&stranger);
        app.run_cycles(1);
    }
    assert_eq!(app.game().state, GameState::Initial);
    assert!(notes.try_recv().unwrap().contains("the teams 5 and 6, which do not play here; expected 5 and 12"));
    assert!(notes.try_recv().is_err());
    // The listener has asked for the truth.
    let mut request = [0; 8];
    let (length, _) = operator.recv_from(&mut request).unwrap();
    assert_eq!(&request[..length], b"RGTr\0");
    for (state, cycles) in [(GameState::Ready, 300), (GameState::Set, 60), (GameState::Playing, 1)] {
        packet.state = state;
        say(&packet);
        app.run_cycles(cycles);
        assert_eq!(app.game().state, state);
    }
    assert_ne!(place(&app), start);
    assert_eq!(app.game().kick_off(), Some(Team::Pink));
    // The truth comes before what robots are told, and a goal, a penalty and the end are what is said.
    let told = packet.clone();
    packet.for_monitors = true;
    packet.teams[0].score = 1;
    packet.teams[1].players[2].penalty = ProtocolVersion::V18.penalty_code(PenaltyReason::LeavingField);
    say(&packet);
    say(&told);
    app.run_cycles(10);
    assert_eq!(app.game().score.blue, 1);
    assert!(app.robot::<Penalty>(pink(3)).unwrap().is_active());
    packet.teams[1].players[2].penalty = 0;
    packet.is_first_half = false;
    packet.state = GameState::Finished;
    say(&packet);
    app.run_cycles(1);
    assert!(app.is_finished() && !app.robot::<Penalty>(pink(3)).unwrap().is_active());
}

/// A match of two robots that stand, about which decides who is heard.
fn decided_match(listener: Listener) -> App {
    let mut app = headless_app();
    let scenario = r#"{ "rules": "spl2025", "ball": { "position_m": [0, -0.5] }, "robots": [
        { "team": "blue", "number": 2, "pose": [-1, 0.5, 0], "behaviour": "idle" },
        { "team": "pink", "number": 3, "pose": [1, -0.5, 180], "behaviour": "idle" } ] }"#;
    app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
    game_controller::listen_to(app.world_mut(), listener);
    app
}

#[test]
fn what_is_wrong_with_a_gamecontroller_is_said_once_in_the_trace() {
    let (offset, control) = free_ports();
    drop(control);
    let mut app = decided_match(Listener::open(Ipv4Addr::LOCALHOST.into(), offset, None).unwrap());
    let [first, second] = [(); 2].map(|()| UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap());
    let send = |socket: &UdpSocket, bytes: &[u8]| {
        socket.send_to(bytes, (Ipv4Addr::LOCALHOST, 3838 + offset)).unwrap();
    };
    let (mut good, mut other) = (said(ProtocolVersion::V20), said(ProtocolVersion::V20));
    good.for_monitors = false;
    (other.for_monitors, other.teams[0].score) = (false, 9);
    let mut same_numbers = good.clone();
    same_numbers.teams[0].number = same_numbers.teams[1].number;
    let mut unknown = good.to_bytes();
    unknown[4] = 17;
    let mut messages = Vec::new();
    for _ in 0..3 {
        for (socket, bytes) in [
            (&first, &good.to_bytes()),
            (&first, &unknown),
            (&second, &other.to_bytes()),
            (&first, &same_numbers.to_bytes()),
        ] {
            send(socket, bytes);
        }
        app.run_cycles(1);
        messages.extend(app.events().iter().filter_map(|event| match event {
            MatchEvent::GameController { message } => Some(message.clone()),
            _ => None,
        }));
        send(&first, &good.to_bytes());
        app.run_cycles(1);
        let more = app.events().iter().filter(|event| matches!(event, MatchEvent::GameController { .. })).count();
        assert_eq!(more, 0);
    }
    let score = app.world().resource::<Game>().score;
    assert!(![score.blue, score.pink].contains(&9), "{score:?}");
    let said: Vec<bool> = ["expected 18, 19 or 20", "second GameController", "same number"]
        .iter()
        .map(|what| messages.iter().filter(|message| message.contains(what)).count() == 1)
        .collect();
    assert!(said == [true; 3] && messages.len() == 3, "{messages:?}");
}

/// Hears a GameController at this address, and tells monitors the truth.
fn truthful_listener(address: Ipv4Addr, offset: u16) -> Listener {
    Listener::open(address.into(), offset, None).unwrap().with_truth_for_monitors()
}

#[test]
fn monitors_are_told_where_robots_are_while_a_real_gamecontroller_decides() {
    let (offset, control) = free_ports();
    drop(control);
    let mut app = decided_match(truthful_listener(Ipv4Addr::LOCALHOST, offset));
    let [asking, game, robots] = monitor(Ipv4Addr::new(127, 0, 0, 2), offset);
    let robot = game_controller::robot_address(5, 2);
    let [cheating, cheats_game, cheats_robots] = monitor(robot, offset);
    let operator = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let mut packet = said(ProtocolVersion::V19);
    packet.teams[1].score = 2;
    operator.send_to(&packet.to_bytes(), (Ipv4Addr::LOCALHOST, 3838 + offset)).unwrap();
    app.run_cycles(1);
    for socket in [&asking, &cheating] {
        socket.send_to(b"RGTr\0", (Ipv4Addr::LOCALHOST, 3636 + offset)).unwrap();
    }
    app.run_cycles(29);
    // As a GameController tells monitors of a game: when they come, and twice a second.
    let told = packets(&game);
    assert!(told.iter().all(|packet| packet.for_monitors && packet.version == ProtocolVersion::V19), "{told:?}");
    let told: Vec<_> = told.iter().map(|told| (told.packet_number, told.state, told.teams[1].score)).collect();
    assert_eq!(told, [0, 1, 2].map(|number| (number, GameState::Initial, 2)));
    // The address of each robot, and a report with the pose in its team's frame, mm and rad, and the ball in its own.
    let mut bytes = [0; 64];
    let reports: Vec<Vec<u8>> =
        core::iter::from_fn(|| robots.recv(&mut bytes).ok().map(|length| bytes[..length].to_vec())).collect();
    let expected = |address: [u8; 4], numbers: [f32; 6]| {
        let head = [address[3], address[2], 0];
        let numbers = numbers.iter().flat_map(|number| number.to_le_bytes());
        address.into_iter().chain(*b"RGrt\x04").chain(head).chain(numbers).collect::<Vec<u8>>()
    };
    let near = |report: &[u8], expected: &[u8]| {
        let number = |bytes: &[u8], at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        report.len() == 36
            && report[..12] == expected[..12]
            && (12..36).step_by(4).all(|at| (number(report, at) - number(expected, at)).abs() < 1e-3)
    };
    let blue = expected([127, 1, 5, 2], [-1000.0, 500.0, 0.0, 0.0, 1000.0, -1000.0]);
    let pink = expected([127, 1, 12, 3], [-1000.0, 500.0, 0.0, 0.0, 1000.0, 0.0]);
    assert_eq!(reports.len(), 2 * 2);
    assert!(reports.iter().zip([&blue, &pink, &blue, &pink]).all(|(one, other)| near(one, other)), "{reports:?}");
    // A robot is told nothing.
    assert!(packets(&cheats_game).is_empty() && cheats_robots.recv(&mut bytes).is_err());
}

#[test]
fn a_gamecontroller_that_broadcasts_is_heard_and_the_match_does_not_hear_itself() {
    let (offset, control) = free_ports();
    drop(control);
    // The address of a network's interface, which need not be known.
    let mut app = decided_match(truthful_listener(Ipv4Addr::new(198, 51, 100, 7), offset));
    let operator = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    operator.set_broadcast(true).unwrap();
    let say = |state| {
        let packet = ControlPacket { state, ..said(ProtocolVersion::V18) };
        operator.send_to(&packet.to_bytes(), (Ipv4Addr::new(127, 255, 255, 255), 3838 + offset)).unwrap();
    };
    say(GameState::Ready);
    app.run_cycles(1);
    assert_eq!(app.game().state, GameState::Ready);
    // Who asks from here would have the truth sent to the match, which would take it for its GameController's.
    operator.send_to(b"RGTr\0", (Ipv4Addr::LOCALHOST, 3636 + offset)).unwrap();
    app.run_cycles(30);
    say(GameState::Set);
    app.run_cycles(1);
    assert_eq!(app.game().state, GameState::Set);
}

#[test]
fn a_real_gamecontroller_stops_a_match_briefly() {
    let (offset, control) = free_ports();
    drop(control);
    let mut app = headless_app();
    let scenario = r#"{ "rules": "hsl2026", "robots": [
        { "team": "blue", "number": 2, "pose": [-1, 0.5, 0], "behaviour": { "script": [ { "until_s": 60, "walk": [0.004, 0, 0] } ] } },
        { "team": "pink", "number": 3, "pose": [1, -0.5, 180], "behaviour": "idle" } ] }"#;
    app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
    game_controller::listen_to(app.world_mut(), Listener::open(Ipv4Addr::LOCALHOST.into(), offset, None).unwrap());
    let operator = UdpSocket::bind((Ipv4Addr::LOCALHOST, 3636 + offset)).unwrap();
    let say = |app: &mut App, is_stopped| {
        let packet = ControlPacket { state: GameState::Playing, is_stopped, ..said(ProtocolVersion::V20) };
        operator.send_to(&packet.to_bytes(), (Ipv4Addr::LOCALHOST, 3838 + offset)).unwrap();
        app.run_cycles(2);
        app.robot::<GameStatus>(blue(2)).unwrap().stopped
    };
    let place = |app: &App| app.robot_pose(blue(2)).unwrap().position;
    assert!(!say(&mut app, false));
    assert!(say(&mut app, true), "the robot is told");
    // Its behaviour walks on. A real GameController decides what that means: nobody is penalised here.
    app.run_cycles(60);
    assert!(app.game().stop.is_some() && !app.robot::<Penalty>(blue(2)).unwrap().is_active());
    assert!(!say(&mut app, false));
    assert!(app.game().stop.is_none());
    let before = place(&app);
    app.run_cycles(60);
    assert!(place(&app).x > before.x + 0.05, "it walks on");
}

#[test]
fn without_being_asked_for_no_truth_leaves_a_match() {
    // A match that tells, and one that listens: a request at either port is not answered with what is for monitors.
    let scenario = r#"{ "rules": "spl2025", "teams": { "blue": "chasers", "pink": "chasers" } }"#;
    let (offset, control) = free_ports();
    let told = told_match(scenario, settings(ProtocolVersion::V18, offset));
    let (listening_offset, listening_control) = free_ports();
    drop(listening_control);
    let listening = decided_match(Listener::open(Ipv4Addr::LOCALHOST.into(), listening_offset, None).unwrap());
    let operator = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let packet = said(ProtocolVersion::V18).to_bytes();
    operator.send_to(&packet, (Ipv4Addr::LOCALHOST, 3838 + listening_offset)).unwrap();
    for (mut app, offset) in [(told, offset), (listening, listening_offset)] {
        let [asking, game, robots] = monitor(Ipv4Addr::new(127, 0, 0, 2), offset);
        for _ in 0..3 {
            app.run_cycles(10);
            for port in [3636, 3637] {
                // Nobody is there, which some systems say.
                let _ = asking.send_to(b"RGTr\0", (Ipv4Addr::LOCALHOST, port + offset));
            }
        }
        assert_eq!((packets(&game), robots.recv(&mut [0; 64]).is_err()), (vec![], true));
        // The ports are not even taken.
        for port in [3636, 3637] {
            UdpSocket::bind((Ipv4Addr::LOCALHOST, port + offset)).unwrap();
        }
    }
    assert!(packets(&control).iter().all(|packet| !packet.for_monitors));
}

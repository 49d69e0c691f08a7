//! A stand-in for the brain of Booster's demo: a node that reads and writes the same topics with the same types, over DDS, and closes the loop as the
//! brain does. It walks a robot to the ball by its detections, aims and starts the visual kick, and scores.
//!
//! It speaks DDS and plays in real time, so `.ci/booster` runs it, in a network namespace.
#![expect(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a failed test may panic, and computes what a program would"
)]

use bevy::prelude::*;
use core::time::Duration;
use rustdds::no_key::{DataReader, DataWriter};
use rustdds::policy::{History, Reliability};
use rustdds::{
    CDRDeserializerAdapter, CDRSerializerAdapter, DomainParticipant, DomainParticipantBuilder, Publisher, QosPolicies,
    QosPolicyBuilder, Subscriber, TopicKind,
};
use serde::de::DeserializeOwned;
use serde_json::json;
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Instant;

use naoisis_agents::agents::AgentsPlugin;
use naoisis_booster::messages::{
    CameraInfo, Clock, DetectedObject, Detections, Kick, LineSegments, LowState, Message, Odometer, Pose, RawBytesMsg,
    RpcReqMsg,
};
use naoisis_booster::player::BoosterPlugin;
use naoisis_core::cycle::run_cycle;
use naoisis_core::game::Game;
use naoisis_core::team::Team;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

const PERIOD: Duration = Duration::from_millis(20);

struct Node {
    participant: DomainParticipant,
    publisher: Publisher,
    subscriber: Subscriber,
    qos: QosPolicies,
}

type Reader<T> = DataReader<T, CDRDeserializerAdapter<T>>;
type Writer<T> = DataWriter<T, CDRSerializerAdapter<T>>;

impl Node {
    fn new() -> Self {
        let participant = DomainParticipantBuilder::new(0).with_only_networks([Ipv4Addr::LOCALHOST]).build().unwrap();
        let qos = QosPolicyBuilder::new()
            .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::from_millis(100) })
            .history(History::KeepLast { depth: 10 })
            .build();
        let publisher = participant.create_publisher(&qos).unwrap();
        let subscriber = participant.create_subscriber(&qos).unwrap();
        Self { participant, publisher, subscriber, qos }
    }

    fn topic<T: Message>(&self, name: &str) -> rustdds::Topic {
        self.participant.create_topic(name.to_owned(), T::TYPE.to_owned(), &self.qos, TopicKind::NoKey).unwrap()
    }

    fn reader<T: Message + DeserializeOwned>(&self, name: &str) -> Reader<T> {
        self.subscriber.create_datareader_no_key(&self.topic::<T>(name), None).unwrap()
    }

    fn writer<T: Message>(&self, name: &str) -> Writer<T> {
        self.publisher.create_datawriter_no_key(&self.topic::<T>(name), None).unwrap()
    }
}

/// The messages that have arrived since the last call: the newest and their number.
fn newest<T: Message + DeserializeOwned>(reader: &mut Reader<T>) -> (Option<T>, usize) {
    let (mut newest, mut count) = (None, 0);
    while let Ok(Some(sample)) = reader.take_next_sample() {
        (newest, count) = (Some(sample.into_value()), count + 1);
    }
    (newest, count)
}

fn request(requests: &Writer<RpcReqMsg>, api: i64, body: &serde_json::Value) {
    let header = json!({ "api_id": api }).to_string();
    requests.write(RpcReqMsg { uuid: api.to_string(), header, body: body.to_string() }, None).unwrap();
}

/// What the robot sees of one kind, by distance and direction.
fn seen<'a>(detections: &'a Detections, label: &'a str) -> impl Iterator<Item = (f32, f32)> + 'a {
    let polar = |object: &DetectedObject| {
        let [x, y] = [object.position_projection[0], object.position_projection[1]];
        (x.hypot(y), y.atan2(x))
    };
    detections.detected_objects.iter().filter(move |object| object.label == label).map(polar)
}

/// Plays until the end. Returns how many messages of each topic arrived.
fn think(is_over: &AtomicBool) -> Vec<(&'static str, usize)> {
    let node = Node::new();
    let requests = node.writer::<RpcReqMsg>("rt/LocoApiTopicReq");
    let kicks = node.writer::<Kick>("rt/kick_ball");
    let mut detections = node.reader::<Detections>("rt/booster_soccer/detection");
    let mut lines = node.reader::<LineSegments>("rt/booster_soccer/line_segments");
    let mut odometer = node.reader::<Odometer>("rt/odometer_state");
    let mut low_state = node.reader::<LowState>("rt/low_state");
    let mut head_pose = node.reader::<Pose>("rt/head_pose");
    let mut recovery = node.reader::<RawBytesMsg>("rt/fall_down_recovery_state");
    let mut camera = node.reader::<CameraInfo>("rt/camera/robot0_rgbd_camera/rgb/camera_info");
    let mut clock = node.reader::<Clock>("rt/clock");
    let mut counts = vec![
        ("detection", 0),
        ("line_segments", 0),
        ("odometer_state", 0),
        ("low_state", 0),
        ("head_pose", 0),
        ("fall_down_recovery_state", 0),
        ("camera_info", 0),
        ("clock", 0),
    ];
    let (mut kicking, mut gets_up) = (false, false);
    while !is_over.load(Ordering::Relaxed) {
        let ((seen_now, seen_count), (state, state_count)) = (newest(&mut detections), newest(&mut recovery));
        let others = [
            seen_count,
            newest(&mut lines).1,
            newest(&mut odometer).1,
            newest(&mut low_state).1,
            newest(&mut head_pose).1,
            state_count,
            newest(&mut camera).1,
            newest(&mut clock).1,
        ];
        for ((_, count), new) in counts.iter_mut().zip(others) {
            *count += new;
        }
        // As the brain: a robot that lies in damping mode gets up.
        let lies = state.is_some_and(|state| state.msg[0] == 2 && state.msg[2] == 1);
        if lies && !gets_up {
            request(&requests, 2008, &json!({}));
        }
        gets_up = lies;
        if let Some(detections) = seen_now {
            request(&requests, 2004, &json!({ "pitch": 0.4, "yaw": 0.0 }));
            match seen(&detections, "Ball").next() {
                Some((range, yaw)) if range < 1.0 || kicking => {
                    let posts: Vec<f32> = seen(&detections, "Goalpost").map(|(_, yaw)| yaw).collect();
                    let goal = if posts.len() == 2 { (posts[0] + posts[1]) / 2.0 } else { 0.0 };
                    let (x, y, dir) = (f64::from(range * yaw.cos()), f64::from(range * yaw.sin()), f64::from(goal));
                    if posts.len() == 2 {
                        kicks.write(Kick { x, y, dir, power: 6.0, ..default() }, None).unwrap();
                    }
                    if !kicking {
                        request(&requests, 2038, &json!({ "start": true }));
                    }
                    kicking = true;
                }
                Some((_, yaw)) => request(&requests, 2001, &json!({ "vx": 0.6, "vy": 0.0, "vyaw": 1.5 * yaw })),
                None if !kicking => request(&requests, 2001, &json!({ "vx": 0.0, "vy": 0.0, "vyaw": 0.0 })),
                None => {}
            }
        }
        thread::sleep(Duration::from_millis(5));
    }
    counts
}

#[test]
#[ignore = "speaks DDS, in real time: .ci/booster runs it in a network namespace"]
fn a_node_with_the_topics_of_the_demo_scores() {
    let mut app = App::new();
    app.add_plugins((NaoisisPlugins, AgentsPlugin, BoosterPlugin));
    app.finish();
    app.cleanup();
    let scenario = include_str!("../../../tests/booster/empty_goal.json");
    app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
    let is_over = Arc::new(AtomicBool::new(false));
    let told = is_over.clone();
    let brain = thread::spawn(move || think(&told));
    let (mut cycles, mut next) = (0, None);
    let mut goals = 0;
    while goals == 0 && cycles < 3000 {
        run_cycle(app.world_mut());
        // Real time begins when the program has come, in the first cycle.
        let now = Instant::now();
        let due = next.unwrap_or(now) + PERIOD;
        thread::sleep(due.saturating_duration_since(now));
        (cycles, next) = (cycles + 1, Some(due));
        goals = app.world().resource::<Game>().score[Team::Blue];
    }
    is_over.store(true, Ordering::Relaxed);
    let counts = brain.join().unwrap();
    assert!(goals == 1, "no goal in {cycles} cycles; received: {counts:?}");
    for (topic, count) in counts {
        // A few may be lost at the beginning, before the reader is known, and at the end.
        assert!(count + 60 > cycles && count <= cycles + 1, "{topic}: {count} messages in {cycles} cycles");
    }
}

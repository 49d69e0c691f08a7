//! The participant on DDS: the services and topics of all robots that Booster programs play.
//!
//! A thread answers requests as they come. What the match publishes never waits: a message for which a reader has no room is dropped.

use bevy::prelude::*;
use core::fmt;
use futures::channel::oneshot;
use futures::future::{Either, join, join_all, select};
use futures::{FutureExt, StreamExt, executor};
use rustdds::no_key::{DataReader, DataWriter};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{
    CDRDeserializerAdapter, CDRSerializerAdapter, DataReaderStatus, DomainParticipant, DomainParticipantBuilder,
    Publisher, QosPolicies, QosPolicyBuilder, Subscriber, TopicKind,
};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use crate::firmware::{Firmware, status};
use crate::messages::{
    BatteryState, ButtonEventMsg, CameraInfo, Clock, Detections, FallDownState, Image, Kick, LineSegments, LowState,
    Message, Odometer, Pose, RawBytesMsg, RemoteControllerState, RobotStatesMsg, RpcReqMsg, RpcRespMsg,
};
use crate::reach::Reach;
use crate::vision::Vision;

/// The DDS participant of a match cannot be created.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("the match cannot speak DDS: {0}")]
pub struct ParticipantError(String);

impl fmt::Debug for ParticipantError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

fn failed(error: impl fmt::Display) -> ParticipantError {
    ParticipantError(error.to_string())
}

/// A robot and its clients, as both threads know them.
#[derive(Debug, Default)]
pub struct Shared {
    /// The robot's own software.
    pub firmware: Firmware,
    /// Its vision service.
    pub vision: Vision,
    /// The number of programs that may send requests now.
    pub clients: i32,
}

/// Locks a robot; what a thread left half done when it panicked is used as it is.
pub fn lock(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A topic that the match writes, under all its names.
pub struct Writer<T: Message>(Vec<DataWriter<T, CDRSerializerAdapter<T>>>);

impl<T: Message + Clone> Writer<T> {
    /// Publishes a message. It is dropped if a reader has no room for it.
    pub fn write(&self, message: T) {
        for writer in &self.0 {
            let _dropped = writer.write(message.clone(), None);
        }
    }
}

type Reader<T> = DataReader<T, CDRDeserializerAdapter<T>>;

/// A robot that a Booster program plays.
pub struct RobotEndpoints {
    /// What both threads know.
    pub shared: Arc<Mutex<Shared>>,
    /// Whether a program has played it.
    pub is_played: bool,
    /// What it publishes.
    pub topics: Topics,
}

/// What a robot publishes.
pub struct Topics {
    pub odometer: Writer<Odometer>,
    pub low_state: Writer<LowState>,
    pub fall_down: Writer<FallDownState>,
    pub recovery: Writer<RawBytesMsg>,
    pub battery: Writer<BatteryState>,
    pub states: Writer<RobotStatesMsg>,
    pub head_pose: Writer<Pose>,
    pub detections: Writer<Detections>,
    pub lines: Writer<LineSegments>,
    pub camera_info: Writer<CameraInfo>,
    pub image: Writer<Image>,
    pub depth: Writer<Image>,
    pub buttons: Writer<ButtonEventMsg>,
    pub remote: Writer<RemoteControllerState>,
}

/// Whether a match of this process has a participant. Robots of two matches would have the same names.
static IS_OPEN: AtomicBool = AtomicBool::new(false);

/// The only participant of this process, from its opening until it is dropped.
struct Key;

impl Key {
    fn take() -> Result<Self, ParticipantError> {
        let is_free = !IS_OPEN.swap(true, Ordering::AcqRel);
        is_free
            .then_some(Key)
            .ok_or_else(|| ParticipantError("another match of this process has Booster programs".to_owned()))
    }
}

impl Drop for Key {
    fn drop(&mut self) {
        IS_OPEN.store(false, Ordering::Release);
    }
}

/// The services and topics of all robots.
pub struct Participant {
    /// The robots, in the order of their names.
    pub robots: Vec<RobotEndpoints>,
    /// The time of the match.
    pub clock: Writer<Clock>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    /// Dropped after what it has made: readers and writers live no longer than their participant.
    _participant: DomainParticipant,
    _key: Key,
}

impl Participant {
    /// Opens the participant for these robots. A single one has the plain names of topics. Of several, each has the names with `/robot0`, `/robot1` and so
    /// on at their ends, as in the simulation of Booster's demo, and topics of the SDK also those with `robot0/` at their beginnings, as in the SDK.
    ///
    /// # Errors
    /// If the system allows no participant, or no thread.
    pub fn open(reach: Reach, robots: Vec<Firmware>) -> Result<Self, ParticipantError> {
        let key = Key::take()?;
        let mut builder = DomainParticipantBuilder::new(reach.domain);
        if !reach.network {
            builder = builder.with_only_networks([Ipv4Addr::LOCALHOST]);
        }
        let desk = Desk::new(builder.build().map_err(failed)?)?;
        let clock = desk.writer(&["rt/clock".to_owned()])?;
        // Programs of several robots aim on one topic, or by the SDK on a topic of their robot's.
        let mut kicks = vec![(desk.reader("rt/kick_ball")?, None)];
        let alone = robots.len() == 1;
        let (mut endpoints, mut services) = (Vec::new(), Vec::new());
        for (index, firmware) in robots.into_iter().enumerate() {
            let shared = Arc::new(Mutex::new(Shared { firmware, ..Shared::default() }));
            let name = format!("robot{index}");
            let (suffix, prefix) = if alone { Default::default() } else { (format!("/{name}"), format!("{name}/")) };
            services.extend([
                desk.service("LocoApiTopic", &suffix, &shared, |shared, api, body| shared.firmware.request(api, body))?,
                desk.service("VisionApiTopic", &suffix, &shared, |shared, api, body| shared.vision.request(api, body))?,
            ]);
            if !alone {
                kicks.push((desk.reader(&format!("rt/{prefix}kick_ball"))?, Some(shared.clone())));
            }
            endpoints.push(RobotEndpoints { shared, is_played: false, topics: desk.topics(&name, &suffix, &prefix)? });
        }
        let (stop, stopped) = oneshot::channel();
        let serve = move || executor::block_on(serve(services, kicks, stopped));
        let thread = thread::Builder::new().name("booster".to_owned()).spawn(serve).map_err(failed)?;
        Ok(Self {
            robots: endpoints,
            clock,
            stop: Some(stop),
            thread: Some(thread),
            _participant: desk.participant,
            _key: key,
        })
    }
}

impl Drop for Participant {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            // A panic there has been reported by the thread.
            let _ = thread.join();
        }
    }
}

/// Makes readers and writers of a participant.
struct Desk {
    participant: DomainParticipant,
    publisher: Publisher,
    subscriber: Subscriber,
    qos: QosPolicies,
    /// What answers have besides: they are kept for readers that come later, as the maker's writers keep theirs. The crate `booster_sdk` asks for
    /// it, and DDS connects no reader with a writer that offers less than it asks for.
    lasting: QosPolicies,
}

impl Desk {
    fn new(participant: DomainParticipant) -> Result<Self, ParticipantError> {
        let qos = QosPolicyBuilder::new()
            .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::ZERO })
            .history(History::KeepLast { depth: 10 })
            .build();
        let publisher = participant.create_publisher(&qos).map_err(failed)?;
        let subscriber = participant.create_subscriber(&qos).map_err(failed)?;
        let lasting = QosPolicyBuilder::new().durability(Durability::TransientLocal).build();
        Ok(Self { participant, publisher, subscriber, qos, lasting })
    }

    fn topic<T: Message>(&self, name: &str) -> Result<rustdds::Topic, ParticipantError> {
        let created = self.participant.create_topic(name.to_owned(), T::TYPE.to_owned(), &self.qos, TopicKind::NoKey);
        created.map_err(failed)
    }

    fn writer<T: Message>(&self, names: &[String]) -> Result<Writer<T>, ParticipantError> {
        self.writer_with(names, None)
    }

    fn writer_with<T: Message>(
        &self,
        names: &[String],
        qos: Option<&QosPolicies>,
    ) -> Result<Writer<T>, ParticipantError> {
        let writer = |name| {
            let topic = self.topic::<T>(name)?;
            self.publisher.create_datawriter_no_key(&topic, qos.cloned()).map_err(failed)
        };
        names.iter().map(|name| writer(name)).collect::<Result<_, _>>().map(Writer)
    }

    fn reader<T: Message + DeserializeOwned>(&self, name: &str) -> Result<Reader<T>, ParticipantError> {
        let topic = self.topic::<T>(name)?;
        self.subscriber.create_datareader_no_key(&topic, None).map_err(failed)
    }

    fn service(
        &self,
        name: &str,
        suffix: &str,
        shared: &Arc<Mutex<Shared>>,
        handle: Handle,
    ) -> Result<Service, ParticipantError> {
        Ok(Service {
            shared: shared.clone(),
            handle,
            requests: self.reader(&format!("rt/{name}{suffix}Req"))?,
            answers: self.writer_with(&[format!("rt/{name}{suffix}Resp")], Some(&self.lasting))?,
        })
    }

    fn topics(&self, robot: &str, suffix: &str, prefix: &str) -> Result<Topics, ParticipantError> {
        let of_demo = |name: &str| vec![format!("rt/{name}{suffix}")];
        let of_both = |name: &str| {
            let mut names = vec![format!("rt/{name}{suffix}"), format!("rt/{prefix}{name}")];
            names.dedup();
            names
        };
        let camera = |name: &str| vec![format!("rt/camera/{robot}_rgbd_camera/rgb/{name}")];
        Ok(Topics {
            odometer: self.writer(&of_both("odometer_state"))?,
            low_state: self.writer(&of_both("low_state"))?,
            fall_down: self.writer(&of_both("fall_down"))?,
            recovery: self.writer(&of_demo("fall_down_recovery_state"))?,
            battery: self.writer(&of_both("battery_state"))?,
            states: self.writer(&of_both("robot_states"))?,
            head_pose: self.writer(&of_demo("head_pose"))?,
            detections: self.writer(&of_demo("booster_soccer/detection"))?,
            lines: self.writer(&of_demo("booster_soccer/line_segments"))?,
            camera_info: self.writer(&camera("camera_info"))?,
            image: self.writer(&camera("image_raw"))?,
            depth: self.writer(&[format!("rt/camera/{robot}_rgbd_camera/depth/image_raw")])?,
            buttons: self.writer(&of_both("button_event"))?,
            remote: self.writer(&of_both("remote_controller_state"))?,
        })
    }
}

/// Answers a request, by the number of its API and its body, with a code and a body.
type Handle = fn(&mut Shared, i64, &str) -> (i64, String);

/// A service of one robot.
struct Service {
    shared: Arc<Mutex<Shared>>,
    handle: Handle,
    requests: Reader<RpcReqMsg>,
    answers: Writer<RpcRespMsg>,
}

/// The robot of each participant that sends requests.
type Programs = Mutex<BTreeMap<[u8; 12], Arc<Mutex<Shared>>>>;

/// The directions of visual kicks, and the robot that they are for; `None` if it depends on who sends them.
type Kicks = (Reader<Kick>, Option<Arc<Mutex<Shared>>>);

/// Answers requests until `stopped`.
async fn serve(services: Vec<Service>, kicks: Vec<Kicks>, stopped: oneshot::Receiver<()>) {
    let programs = Programs::default();
    let kicks = kicks.into_iter().map(|(kicks, robot)| hear_kicks(kicks, robot, &programs));
    let all = join(join_all(services.into_iter().map(|service| service.run(&programs))), join_all(kicks));
    // Either ends only with the match.
    match select(Box::pin(all), stopped).await {
        Either::Left(_) | Either::Right(_) => {}
    }
}

/// The id of the participant of a reader or writer: the beginning of its own.
fn participant_of(endpoint: rustdds::GUID) -> [u8; 12] {
    endpoint.to_bytes().first_chunk().copied().unwrap_or_default()
}

impl Service {
    async fn run(self, programs: &Programs) {
        let Service { shared, handle, requests, answers } = self;
        let mut requests = requests.async_sample_stream();
        let mut events = requests.async_event_stream();
        loop {
            futures::select! {
                request = requests.next().fuse() => match request {
                    Some(Ok(request)) => {
                        let from = participant_of(request.sample_info().writer_guid());
                        programs.lock().unwrap_or_else(PoisonError::into_inner).insert(from, shared.clone());
                        if let Some(answer) = answer(&mut lock(&shared), handle, request.into_value()) {
                            answers.write(answer);
                        }
                    }
                    Some(Err(error)) => warn!("a request of a Booster program cannot be read: {error}"),
                    None => return,
                },
                event = events.next().fuse() => match event {
                    Some(DataReaderStatus::SubscriptionMatched { current, .. }) => {
                        let mut shared = lock(&shared);
                        shared.clients += current.count_change();
                    }
                    Some(_) => {}
                    None => return,
                },
            }
        }
    }
}

/// The answer to a request, unless its header says that none is expected.
fn answer(shared: &mut Shared, handle: Handle, request: RpcReqMsg) -> Option<RpcRespMsg> {
    let header = serde_json::from_str::<Value>(&request.header).unwrap_or_default();
    let (code, body) = match header.get("api_id").and_then(Value::as_i64) {
        Some(api) => handle(shared, api, &request.body),
        None => (status::BAD_REQUEST, String::new()),
    };
    let is_expected = header.get("expect_response").and_then(Value::as_bool).unwrap_or(true);
    is_expected.then(|| RpcRespMsg { uuid: request.uuid, header: json!({ "status": code }).to_string(), body })
}

/// Passes on the directions of visual kicks, to `robot` or else to that of the program which sent them.
async fn hear_kicks(kicks: Reader<Kick>, robot: Option<Arc<Mutex<Shared>>>, programs: &Programs) {
    let mut kicks = kicks.async_sample_stream();
    while let Some(kick) = kicks.next().await {
        let Ok(kick) = kick else { continue };
        let from = participant_of(kick.sample_info().writer_guid());
        let sender = || programs.lock().unwrap_or_else(PoisonError::into_inner).get(&from).cloned();
        if let Some(robot) = robot.clone().or_else(sender) {
            let Kick { dir, power, .. } = *kick.value();
            lock(&robot).firmware.aim(dir as f32, power as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_request_has_one_answer_unless_none_is_expected() {
        let mut robot = Shared::default();
        let loco: Handle = |shared, api, body| shared.firmware.request(api, body);
        let mut answer = |header: &str| {
            let request = RpcReqMsg { uuid: "7".to_owned(), header: header.to_owned(), body: String::new() };
            answer(&mut robot, loco, request).map(|answer| (answer.uuid, answer.header, answer.body))
        };
        let of = |header: &str, body: &str| Some(("7".to_owned(), header.to_owned(), body.to_owned()));
        assert_eq!(answer(r#"{"api_id":2017}"#), of(r#"{"status":0}"#, r#"{"mode":2}"#));
        assert_eq!(answer(r#"{"api_id":2017,"expect_response":false}"#), None);
        assert_eq!(answer("no JSON"), of(r#"{"status":400}"#, ""));
    }
}

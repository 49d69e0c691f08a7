//! Robots that Booster programs play. Their behaviour is registered like any other, so that the information barrier holds for it: a program is
//! told only what its robot perceives.

use bevy::prelude::*;
use core::time::Duration;
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

use crate::buttons;
use crate::firmware::Firmware;
use crate::messages::{Clock, RemoteControllerState, Time};
use crate::participant::{Participant, ParticipantError, RobotEndpoints, lock};
use crate::reach::Reach;
use crate::topics::{self, Sizes};
use naoisis_agents::agents::{AgentSettings, PlayedElsewhere};
use naoisis_core::behaviour::{BehaviourApp, DecideSystems, Remote};
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::events::{AgentLoss, CycleEvents, MatchEvent};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::{HeadAngles, HeadCommand};
use naoisis_core::robot::kick::{KickCommand, KickSettings};
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::robot::posture::PostureCommand;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::buttons::ButtonReadings;
use naoisis_sensing::sensing::camera::{CameraImages, CameraSettings};
use naoisis_sensing::sensing::imu::ImuReading;
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::interface::vocabulary::RobotCommand;
use naoisis_sim::scenario::{RobotModel, Scenario};
use naoisis_sim::simulation::resolved;

/// The name of the behaviour, and of a team of such robots.
pub const BOOSTER: &str = "booster";
/// The time between two looks whether programs have come.
const LOOK: Duration = Duration::from_millis(2);

/// Lets programs that are written for Booster's SDK play: adds the behaviour and the team `booster`.
/// The resource [`Reach`] says whom the match speaks to.
pub struct BoosterPlugin;

impl Plugin for BoosterPlugin {
    fn build(&self, app: &mut App) {
        let is_played = |players: Query<(), With<BoosterPlayer>>| !players.is_empty();
        app.register_type::<BoosterPlayer>()
            .register_type::<MatchParticipant>()
            .register_type::<Reach>()
            .init_resource::<MatchParticipant>()
            .init_resource::<Reach>()
            .add_behaviour::<BoosterPlayer, _>(BOOSTER, play)
            .add_team(BOOSTER, "programs written for Booster's SDK, which connect over DDS; in real time", |_, _| {
                BOOSTER
            })
            // It adds events, as what asks other programs does: in any order.
            .add_systems(Cycle, attend.run_if(is_played).in_set(DecideSystems::Ask).ambiguous_with_all());
    }
}

/// Marks a robot that a Booster program plays.
#[derive(Component, Clone, Copy, Debug, Default, Reflect)]
#[require(Remote, PlayedElsewhere)]
#[reflect(Component, @Knowledge::Belief)]
pub struct BoosterPlayer;

/// The participant of the match, which opens when its first cycle with such a robot begins.
#[derive(Resource, Default, Reflect)]
#[reflect(@Knowledge::Belief, from_reflect = false)]
struct MatchParticipant {
    /// The robots for which it was opened, by their places in the participant.
    #[reflect(ignore)]
    robots: Vec<RobotId>,
    #[reflect(ignore)]
    sizes: Option<Sizes>,
    /// `None` before the first cycle, and if it cannot be opened.
    #[reflect(ignore)]
    participant: Option<Mutex<Participant>>,
}

impl MatchParticipant {
    fn robot<'a>(&self, participant: &'a mut Participant, id: RobotId) -> Option<&'a mut RobotEndpoints> {
        let place = self.robots.iter().position(|robot| *robot == id)?;
        participant.robots.get_mut(place)
    }
}

/// The robots that Booster programs play, in the order of their names `robot0`, `robot1` and so on: substitutes last, so that the names of the
/// others do not depend on them.
pub fn booster_robots(world: &mut World) -> Vec<RobotId> {
    let mut players = world.query_filtered::<&RobotId, With<BoosterPlayer>>();
    let mut ids: Vec<RobotId> = players.iter(world).copied().collect();
    let scenario = resolved(world, world.resource::<Scenario>());
    ids.sort_by_key(|id| (scenario.robot(*id).substitute, *id));
    ids
}

/// Opens the participant, waits for the programs, and notices those that leave.
fn attend(world: &mut World) {
    let mut players = world.query_filtered::<&RobotId, With<BoosterPlayer>>();
    let ids: Vec<RobotId> = players.iter(world).copied().collect();
    let mut lost: Vec<(RobotId, AgentLoss, String)> = Vec::new();
    let known = &world.resource::<MatchParticipant>().robots;
    if known.len() != ids.len() || !ids.iter().all(|id| known.contains(id)) {
        let ids = booster_robots(world);
        let settings = world.resource::<AgentSettings>().clone();
        let participant = open(world, &ids);
        let mut of_match = world.resource_mut::<MatchParticipant>();
        of_match.robots = ids;
        match participant {
            Ok((mut participant, sizes)) => {
                wait_for_programs(&mut participant, &settings);
                let absent = of_match.robots.iter().zip(&participant.robots).filter(|(_, robot)| !robot.is_played);
                lost.extend(absent.map(|(id, _)| (*id, AgentLoss::TimedOut, "no Booster program has come".to_owned())));
                (of_match.participant, of_match.sizes) = (Some(Mutex::new(participant)), Some(sizes));
            }
            Err(error) => {
                lost.extend(of_match.robots.iter().map(|id| (*id, AgentLoss::Refused, error.to_string())));
            }
        }
    }
    let of_match = &mut *world.resource_mut::<MatchParticipant>();
    if let Some(Ok(participant)) = of_match.participant.as_mut().map(Mutex::get_mut) {
        for (id, robot) in of_match.robots.iter().zip(&mut participant.robots) {
            let mut shared = lock(&robot.shared);
            let is_here = shared.clients > 0;
            if robot.is_played && !is_here {
                shared.firmware.stop();
                lost.push((*id, AgentLoss::Closed, "its Booster program has gone; it may come back".to_owned()));
            }
            robot.is_played = is_here;
        }
    }
    let event = |(robot, reason, message)| MatchEvent::AgentLost { robot, reason, message };
    world.resource_mut::<CycleEvents>().extend(lost.into_iter().map(event));
}

fn open(world: &mut World, ids: &[RobotId]) -> Result<(Participant, Sizes), ParticipantError> {
    // The participant of another match in this app leaves first.
    world.resource_mut::<MatchParticipant>().participant = None;
    let scenario = world.resource::<Scenario>();
    let firmware = |id: &RobotId| {
        let model = scenario.robot(*id).model.unwrap_or_else(|| scenario.model.clone());
        Firmware { name: id.to_string(), model: RobotModel::name_of(&model), ..default() }
    };
    let sizes = Sizes {
        ball_radius_m: scenario.ball.unwrap_or_default().radius_m,
        goal_height_m: scenario.field.goal.height_m,
    };
    let participant = Participant::open(*world.resource::<Reach>(), ids.iter().map(firmware).collect())?;
    Ok((participant, sizes))
}

/// Waits until every robot has a program, or the time for a start is over.
fn wait_for_programs(participant: &mut Participant, settings: &AgentSettings) {
    let deadline = settings.start_timeout.map(|time| Instant::now() + time);
    let is_over = || {
        deadline.is_some_and(|deadline| deadline <= Instant::now())
            || settings.break_off.as_ref().is_some_and(|break_off| (break_off.0)())
    };
    loop {
        for robot in &mut participant.robots {
            robot.is_played = lock(&robot.shared).clients > 0;
        }
        if participant.robots.iter().all(|robot| robot.is_played) || is_over() {
            return;
        }
        thread::sleep(LOOK);
    }
}

/// Tells the programs what their robots perceive, and does what they want.
fn play(
    clock: Res<CycleClock>,
    of_match: Res<MatchParticipant>,
    mut robots: Query<
        (
            &RobotId,
            (&Odometry, &HeadAngles, &BodyStatus, &Percepts, Option<&CameraImages>),
            (Option<&ImuReading>, Option<&ButtonReadings>),
            (&Body, &CameraSettings, &KickSettings),
            (&mut WalkCommand, &mut HeadCommand, &mut KickCommand, &mut PostureCommand),
        ),
        With<BoosterPlayer>,
    >,
) {
    let (Some(participant), Some(sizes)) = (&of_match.participant, of_match.sizes) else { return };
    let Ok(mut participant) = participant.lock() else { return };
    participant.clock.write(Clock { clock: Time::of(clock.start_time_s()) });
    for (id, (odometry, head, status, percepts, images), (imu, buttons), (body, cameras, kicks), commands) in
        &mut robots
    {
        let Some(robot) = of_match.robot(&mut participant, *id) else { continue };
        let mut shared = lock(&robot.shared);
        let firmware = &mut shared.firmware;
        let before = core::mem::replace(&mut firmware.odometry, odometry.0);
        (firmware.head_angles, firmware.body, firmware.imu) = (*head, *status, imu.copied());
        let buttons = buttons.cloned().unwrap_or_default();
        let buttons_before = core::mem::replace(&mut firmware.buttons, buttons);
        let RobotCommand { walk, head, kick, posture, .. } =
            firmware.command(percepts.ball.map(|ball| ball.position_m), kicks, &clock);
        let mut remote = buttons::remote_controller(&buttons_before, &firmware.buttons);
        // An event in a cycle without a message waits for the next message.
        if remote.event == 0 {
            remote.event = firmware.remote_event;
        }
        let messages = topics::due(clock.start_time_s(), clock.end_time_s());
        firmware.remote_event = if messages == 0 { remote.event } else { 0 };
        let firmware = firmware.clone();
        drop(shared);
        let (mut walk_command, mut head_command, mut kick_command, mut posture_command) = commands;
        walk_command.set_if_neq(walk.unwrap_or_default());
        if let Some(head) = head {
            head_command.set_if_neq(head);
        }
        (kick_command.0, posture_command.0) = (kick, posture);
        buttons::button_events(&buttons_before, &firmware.buttons)
            .into_iter()
            .for_each(|event| robot.topics.buttons.write(event));
        let turn_radps = topics::turn_radps(before, odometry.0, clock.period());
        publish_body(robot, &firmware, remote, turn_radps, body, messages);
        publish_view(robot, &firmware, percepts, images, (body, cameras, sizes), &clock);
    }
}

/// Publishes the state of the body, 50 times in a second of the match.
fn publish_body(
    robot: &RobotEndpoints,
    firmware: &Firmware,
    mut remote: RemoteControllerState,
    turn_radps: f32,
    body: &Body,
    messages: u64,
) {
    for _ in 0..messages {
        robot.topics.odometer.write(topics::odometer(firmware));
        robot.topics.low_state.write(topics::low_state(firmware, turn_radps));
        robot.topics.fall_down.write(topics::fall_down(firmware));
        robot.topics.recovery.write(topics::recovery(firmware));
        robot.topics.head_pose.write(topics::head_pose(body, firmware.head_angles));
        robot.topics.states.write(topics::robot_states(firmware));
        robot.topics.battery.write(topics::battery());
        robot.topics.remote.write(remote.clone());
        remote.event = 0;
    }
}

/// Publishes what the robot sees.
fn publish_view(
    robot: &RobotEndpoints,
    firmware: &Firmware,
    percepts: &Percepts,
    images: Option<&CameraImages>,
    (body, cameras, sizes): (&Body, &CameraSettings, Sizes),
    clock: &CycleClock,
) {
    let Some(camera) = cameras.mounts.names().next() else { return };
    let Some(view) = cameras.view(camera, body, firmware.head_angles) else { return };
    let detections = topics::detections(percepts, &view, body, sizes);
    {
        let mut shared = lock(&robot.shared);
        shared.vision.seen.clone_from(&detections.detected_objects);
        shared.vision.size = view.intrinsics.size;
    }
    robot.topics.detections.write(detections);
    robot.topics.lines.write(topics::line_segments(percepts));
    robot.topics.camera_info.write(topics::camera_info(&view.intrinsics, percepts.time_s));
    let new = images.filter(|images| images.arrived == Some(clock.cycle));
    if let Some((images, taken)) = new.and_then(|images| images.cycle.map(|taken| (images, taken))) {
        let time_s = CycleClock { cycle: taken, ..*clock }.start_time_s();
        robot.topics.image.write(topics::image(images.of(camera), time_s));
        if let Some(depth) = topics::depth_image(images.of(camera), time_s) {
            robot.topics.depth.write(depth);
        }
    }
}

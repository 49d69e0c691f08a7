//! A program that plays a robot: its connection, its process if it has one, and the conversation with it.

use bevy::prelude::*;
use core::time::Duration;
use std::collections::BTreeMap;
use std::time::Instant;

use serde_json::Value;

use super::connection::Connection;
use super::loss::Loss;
use super::message::malformed;
use super::process::{self, Process};
use super::protocol::{
    Answer, EXAMPLE_HELLO, Hello, HelloMessage, ImageMessage, Message, PROTOCOL, Perceive, PerceptionParts,
    RefusedCommand, Welcome,
};
use super::settings::AgentSettings;
use naoisis_core::camera_model::CameraName;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::AgentLoss;
use naoisis_core::game::Score;
use naoisis_core::geometry::Pose;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::camera::CameraImages;
use naoisis_sim::interface::command::read_value;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::interface::vocabulary::Perception;
use naoisis_sim::scenario::Scenario;

/// The time that a program has to end after its match.
pub(super) const FAREWELL: Duration = Duration::from_secs(1);

/// Marks a robot that a program plays. `None` if the program is lost.
#[derive(Component, Debug)]
pub struct AgentPlayer(pub(super) Option<Agent>);

impl AgentPlayer {
    /// The hello of the program, if it plays.
    pub fn hello(&self) -> Option<&Hello> {
        self.0.as_ref()?.hello.as_ref()
    }

    /// Whether the program was started and its hello was not received yet.
    pub(super) fn waits_to_be_greeted(&self) -> bool {
        self.0.as_ref().is_some_and(|agent| agent.hello.is_none())
    }

    /// Whether a program plays the robot, or the program may still come.
    pub fn has_program(&self) -> bool {
        self.0.is_some()
    }

    /// The process group of the program, if the match has started it and it plays.
    pub fn process_group(&self) -> Option<u32> {
        Some(self.0.as_ref()?.process.as_ref()?.group())
    }
}

/// A program that plays a robot.
#[derive(Debug)]
pub struct Agent {
    connection: Connection,
    /// Dropped last: this ends the process.
    process: Option<Process>,
    /// The hello of the program, once it has been received.
    hello: Option<Hello>,
    /// The parts of perceptions that the program wants.
    fields: Fields,
    /// The commands that were refused in the last cycle.
    pub(super) refused: Vec<RefusedCommand>,
    /// The time at which the hello or the answer is due.
    deadline: Option<Instant>,
    /// Whether the program was asked and its answer was not received yet.
    pub(super) is_asked: bool,
}

impl Agent {
    /// A program whose hello is due at `deadline`.
    pub(super) fn new(connection: Connection, process: Option<Process>, deadline: Option<Instant>) -> Self {
        Self {
            connection,
            process,
            hello: None,
            fields: Fields::default(),
            refused: Vec::new(),
            deadline,
            is_asked: false,
        }
    }

    /// Whether the program owes its hello or an answer, has not sent it, and may still do so. Waits up to 20 ms for it.
    pub(super) fn is_silent(&mut self) -> bool {
        (self.hello.is_none() || self.is_asked) && !self.is_late() && !self.connection.is_ready_soon()
    }

    /// Whether the program has said hello, has closed the connection, or is too late.
    pub(super) fn has_spoken(&mut self) -> bool {
        self.connection.is_ready() || self.is_late()
    }

    fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| deadline <= Instant::now())
    }

    /// Whether the program has closed the connection.
    pub(super) fn has_hung_up(&mut self) -> bool {
        self.connection.has_hung_up()
    }

    /// Receives the hello of the program. If the program sends anything else, it is told the fault.
    pub(super) fn hello(&mut self) -> Result<Hello, Loss> {
        let said = self.connection.receive::<Value>(self.deadline).and_then(|said| {
            // The version is checked first, as another version may have other fields.
            match said.pointer("/hello/protocol").and_then(Value::as_u64) {
                Some(protocol) if protocol != u64::from(PROTOCOL) => {
                    Err(self.refuse(format!("it uses protocol {protocol}; expected {PROTOCOL}")))
                }
                _ => read_value::<HelloMessage>(&said)
                    .map_err(|error| malformed(&error.to_string(), said.to_string().as_bytes())),
            }
        });
        let hello = said.map_err(|mut loss| {
            loss.message = match loss.reason {
                AgentLoss::Malformed => format!("{}; expected a hello at first, such as {EXAMPLE_HELLO}", loss.message),
                AgentLoss::TimedOut => "it did not send a hello in time".to_owned(),
                _ => loss.message,
            };
            if loss.reason == AgentLoss::Malformed {
                let _ = self.refuse(loss.message.clone());
            }
            self.with_exit_status(loss)
        })?;
        self.connection.set_encoding(hello.hello.encoding);
        Ok(hello.hello)
    }

    /// Lets the program play a robot, which stands at `pose` in the team frame if it may know. Refuses the program if it asks for something that does not exist.
    pub(super) fn welcome(
        &mut self,
        hello: &Hello,
        (robot, pose): (RobotId, Option<Pose>),
        scenario: &Scenario,
        renders_images: bool,
    ) -> Result<(), Loss> {
        let mounts = scenario.settings_of(&scenario.robot(robot)).cameras.mounts;
        let unknown = hello.images.iter().find(|camera| mounts.get(**camera).is_none());
        let refusal = if hello.robot.is_some_and(|wanted| wanted != robot) {
            Some(format!("it wants to play another robot; expected `{robot}`, the value of NAOISIS_ROBOT, or none"))
        } else if !hello.images.is_empty() && !renders_images {
            Some("it wants camera images, but none are rendered; expected a match with --cameras software".to_owned())
        } else if let Some(camera) = unknown {
            let names: Vec<String> = mounts.names().map(|name| format!("`{name}`")).collect();
            Some(format!("the robot has no camera `{camera}`; expected one of {}", names.join(", ")))
        } else {
            None
        };
        if let Some(reason) = refusal {
            return Err(self.refuse(reason));
        }
        self.fields = match Fields::of_perception(&hello.fields) {
            Ok(fields) => fields,
            Err(error) => return Err(self.refuse(error.to_string())),
        };
        self.hello = Some(hello.clone());
        let welcome = Message::Welcome(Box::new(Welcome::of(scenario, robot, pose)));
        self.connection.send(&welcome, self.deadline).map_err(|loss| self.with_exit_status(loss))
    }

    /// Tells the program why it may not play.
    pub(super) fn refuse(&mut self, reason: String) -> Loss {
        // A program that does not listen notices the end of the connection.
        let _ = self.connection.send(&Message::Refused { reason: &reason, protocol: PROTOCOL }, self.deadline);
        Loss::new(AgentLoss::Refused, reason)
    }

    /// Sends the program the perception of its robot.
    pub(super) fn ask(
        &mut self,
        clock: &CycleClock,
        perception: &Perception,
        belief: Option<&Belief>,
        images: Option<&CameraImages>,
        settings: &AgentSettings,
    ) -> Result<(), Loss> {
        self.deadline = settings.answer_timeout.map(|time| Instant::now() + time);
        self.is_asked = true;
        let message = Perceive {
            cycle: clock.cycle,
            time_s: clock.start_time_s(),
            perception: PerceptionParts { perception, fields: &self.fields },
            refused: &self.refused,
            belief: belief.filter(|_| self.wants_belief()),
            images: self.images_of(clock, images),
        };
        self.connection.send(&message, self.deadline).map_err(|loss| self.with_exit_status(loss))
    }

    /// Whether the program wants the belief of the built-in estimator.
    pub(super) fn wants_belief(&self) -> bool {
        self.hello.as_ref().is_some_and(|hello| hello.belief)
    }

    /// The images that the program wants and that arrived in this cycle.
    fn images_of<'a>(
        &self,
        clock: &CycleClock,
        images: Option<&'a CameraImages>,
    ) -> BTreeMap<CameraName, ImageMessage<'a>> {
        let wanted = self.hello.as_ref().map_or(&[][..], |hello| &hello.images);
        let new = images.filter(|images| !wanted.is_empty() && images.arrived == Some(clock.cycle));
        let Some((images, taken)) = new.and_then(|images| images.cycle.map(|taken| (images, taken))) else {
            return BTreeMap::new();
        };
        let time_s = CycleClock { cycle: taken, ..*clock }.start_time_s();
        wanted.iter().map(|camera| (*camera, ImageMessage::of(images.of(*camera), time_s))).collect()
    }

    /// Receives the answer of the program for this cycle.
    pub(super) fn answer(&mut self, cycle: u64) -> Result<Answer, Loss> {
        self.is_asked = false;
        let answer = self.connection.receive::<Answer>(self.deadline).map_err(|loss| self.with_exit_status(loss))?;
        if answer.cycle != cycle {
            let message = format!("it answered for cycle {}; expected {cycle}", answer.cycle);
            return Err(Loss::new(AgentLoss::WrongCycle, message));
        }
        answer.checked().map_err(|error| Loss::new(AgentLoss::Malformed, error.to_string()))
    }

    /// Adds to a loss the exit status of the process, if it is known.
    fn with_exit_status(&mut self, loss: Loss) -> Loss {
        let (AgentLoss::Closed, Some(process)) = (loss.reason, &mut self.process) else { return loss };
        match process.exit_status(Instant::now() + FAREWELL) {
            Some(status) if status.success() => Loss::new(AgentLoss::Closed, "it ended before the match did"),
            Some(status) => Loss::new(AgentLoss::Crashed, process::ending(status)),
            None => Loss::new(AgentLoss::Closed, "it has closed its standard output"),
        }
    }

    /// Tells the program that the match is over.
    pub(super) fn say_goodbye(&mut self, reason: &str, score: Score) {
        let _ = self.connection.send(&Message::End { reason, score }, Some(Instant::now() + FAREWELL));
    }

    /// Waits until the program ends by itself. Returns whether it did before the deadline.
    pub(super) fn wait_for_end(mut self, deadline: Instant) -> bool {
        self.connection.wait_for_end(Some(deadline));
        self.process.as_mut().is_none_or(|process| process.exit_status(deadline).is_some())
    }
}

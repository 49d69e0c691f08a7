//! Robots that are controlled from outside the match: by a loop of your own, a program, or a policy.
//!
//! Such a robot has the behaviour `"remote"`. In each cycle its controller receives a [`Perception`], which is the robot of a trace without
//! the parts that a robot cannot know, and returns a [`RobotCommand`], which is the `"command"` of a trace. A loop of your own stops each
//! cycle between its halves, and thus runs in lock-step with the match:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::agents::{self, RobotCommand};
//! use naoisis::cycle::perceive;
//! use naoisis::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins(NaoisisPlugins);
//! app.start_match(&Scenario::from_json(
//!     r#"{ "rules": "free", "ball": { "position_m": [1.0, 0.2] },
//!          "robots": [{ "team": "blue", "number": 1, "behaviour": "remote" }] }"#,
//! )?)?;
//! let robot = agents::remote_robots(app.world())[0];
//! for _ in 0..30 {
//!     perceive(app.world_mut());
//!     let perception = agents::perception(app.world_mut(), robot)?;
//!     let ball = perception.percepts.ball.map(|ball| ball.position_m);
//!     let turn_deg = ball.map_or(0.0, |ball| ball.y.signum());
//!     let command = RobotCommand::from_json(format!(r#"{{ "walk": [0.006, 0.0, {turn_deg}] }}"#).as_bytes())?;
//!     agents::command(app.world_mut(), robot, command)?;
//!     run_cycle(app.world_mut());
//! }
//! assert!(app.robot_pose(robot).unwrap().position.x > 0.15);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```
//!
//! With the `AgentsPlugin`, programs in any language can play: a robot whose behaviour is `{ "program": [...] }`, or
//! whose team is `exec:COMMAND`, has a process of its own, which receives the perceptions of the robot and answers with
//! commands ([`protocol`]). The match waits for every answer, so programs that answer the same way play the same match.

pub mod connection;
mod loss;
mod message;
#[cfg(unix)]
mod pipes;
mod player;
mod plugin;
#[cfg(unix)]
mod process;
pub mod protocol;
mod remote;
mod replayed;
pub mod schema;
pub mod server;
mod settings;
mod start;

pub use naoisis_sim::interface::command::CommandError;
pub use naoisis_sim::interface::vocabulary::{Perception, RobotCommand};
pub use player::AgentPlayer;
pub use plugin::{AgentsPlugin, dismiss};
pub use remote::{
    AgentError, PlayedElsewhere, belief, believe, command, perception, remote_robots, robots_played_elsewhere,
    with_remote_robots,
};
pub(crate) use remote::{Commander, give_command};
pub use replayed::ReplayedCommands;
pub use server::Server;
pub use settings::{AgentSettings, BreakOff, ErrorLines, LeagueNumbers};
pub use start::{ProgramStartError, start_programs};

/// A stub for other systems than Unix, where programs cannot be started.
#[cfg(not(unix))]
mod process {
    use std::path::Path;
    use std::process::ExitStatus;
    use std::time::Instant;

    use super::connection::Stream;
    use super::settings::ErrorLines;
    use naoisis_core::team::RobotId;

    #[derive(Debug)]
    pub struct Process;

    impl Process {
        pub fn start(
            _: &[String],
            _: Option<&Path>,
            _: RobotId,
            _: Vec<(&'static str, String)>,
            _: Option<ErrorLines>,
        ) -> Result<(Self, Stream), String> {
            Err("programs can be started on Unix only".to_owned())
        }

        pub fn group(&self) -> u32 {
            0
        }

        pub fn exit_status(&mut self, _: Instant) -> Option<ExitStatus> {
            None
        }
    }

    pub fn ending(status: ExitStatus) -> String {
        format!("it ended: {status}")
    }
}

//! Arguments of the command line about programs that play.

use bevy::app::App;
use clap::Args;
use core::time::Duration;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::report;
use super::teams::TeamArguments;
use naoisis_agents::agents::AgentSettings;
use naoisis_agents::game_controller::MatchNetwork;
use naoisis_core::team::PerTeam;

/// Arguments about programs that play.
#[derive(Args, Debug, Clone, Default)]
pub struct AgentArguments {
    /// Programs that play: the longest time for an answer, s of real time; 0 for no limit [default: 5]
    #[arg(long, value_name = "S", value_parser = duration, allow_negative_numbers = true)]
    pub agent_timeout: Option<Duration>,
    /// The longest time until a program says hello, s; 0 for no limit [default: 30]
    #[arg(long, value_name = "S", value_parser = duration, allow_negative_numbers = true)]
    pub agent_start_timeout: Option<Duration>,
    /// The longest message of a program, bytes [default: 65536]
    #[arg(long, value_name = "BYTES", value_parser = clap::value_parser!(u32).range(64..=16 << 20))]
    pub agent_limit: Option<u32>,
}

fn duration(word: &str) -> Result<Duration, String> {
    let seconds = word.parse::<f64>().ok().filter(|seconds| (0.0..=1e6).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| "expected a number of seconds, or 0 for any time".to_owned())
}

impl AgentArguments {
    /// Returns the settings for programs in the match of a scenario file. Programs named in the file run in its folder, those of the
    /// command line in the current folder.
    pub fn settings(&self, scenario: &str, teams: &TeamArguments) -> AgentSettings {
        let default = AgentSettings::default();
        let any_time_for_zero = |time: Option<Duration>, default: Option<Duration>| match time {
            Some(time) => (!time.is_zero()).then_some(time),
            None => default,
        };
        let folder = folder_of(scenario);
        AgentSettings {
            answer_timeout: any_time_for_zero(self.agent_timeout, default.answer_timeout),
            start_timeout: any_time_for_zero(self.agent_start_timeout, default.start_timeout),
            longest_message: self.agent_limit.map_or(default.longest_message, |bytes| bytes as usize),
            token: None,
            folders: PerTeam::new(|team| folder.clone().filter(|_| teams.of(team).is_none())),
            error_lines: Some(Arc::new(|robot, line| report::note(&format!("[{robot}] {line}")))),
            break_off: None,
        }
    }
}

/// Returns `app` with the settings for programs and, if there is one, the network of the match.
pub fn connected(mut app: App, settings: &AgentSettings, network: Option<&MatchNetwork>) -> App {
    app.insert_resource(settings.clone());
    if let Some(network) = network {
        app.insert_resource(network.clone());
    }
    app
}

/// Returns the folder of a scenario file; `None` for a built-in scenario.
fn folder_of(scenario: &str) -> Option<PathBuf> {
    let path = Path::new(scenario);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.filter(|_| path.is_file()).map(Path::to_owned)
}

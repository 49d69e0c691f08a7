//! How the command line tells of a match in the league's own protocol.

use bevy::prelude::*;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use std::net::{IpAddr, Ipv4Addr};

use super::report;
use naoisis_agents::game_controller::{
    self, GameController, GameControllerSettings, Listener, NetworkSettings, ProtocolVersion, TeamMessages,
};
use naoisis_core::team::PerTeam;

/// The teams' numbers if none are given.
const TEAM_NUMBERS: PerTeam<u8> = PerTeam { blue: 1, pink: 2 };
/// The largest port offset: the highest port of the protocol, a team's own, is 10255.
const LARGEST_OFFSET: i64 = 55_000;

/// Reads the name of a protocol version.
fn protocol_versions() -> impl TypedValueParser<Value = ProtocolVersion> {
    let values = ProtocolVersion::ALL.map(|version| PossibleValue::new(version.name()).help(version.league()));
    PossibleValuesParser::new(values).map(|name| {
        let mut versions = ProtocolVersion::ALL.into_iter();
        versions.find(|version| version.name() == name).unwrap_or(ProtocolVersion::V19)
    })
}

/// Arguments about the GameController.
#[derive(Args, Debug, Clone, PartialEq, Eq, Default)]
#[command(group = ArgGroup::new("numbered").multiple(true))]
pub struct GameControllerArguments {
    /// Tell robots of the game as the league's GameController does: control packets to UDP port 3838, twice a simulated second
    /// and at each change; reports from robots at 3939
    #[arg(long, value_parser = protocol_versions(), value_name = "v18|v19", groups = ["protocol", "numbered"])]
    pub game_controller: Option<ProtocolVersion>,
    /// Let a real GameController decide about the match, which it is heard by at UDP port 3838 of this address: its operator
    /// whistles, penalises and restarts. Real time, unless --pace says otherwise [default: 127.0.0.1]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1", groups = ["protocol", "numbered"])]
    pub listen_game_controller: Option<IpAddr>,
    /// Where its packets go [default: 127.0.0.1]; 127.255.255.255 reaches every program on this machine, a network's
    /// broadcast address every robot in it
    #[arg(long, value_name = "ADDRESS", requires = "game_controller")]
    pub game_controller_address: Option<IpAddr>,
    /// Tell monitors the truth that ask for it at UDP port 3636, as they ask a GameController: the game at once and, with
    /// --listen-game-controller, where robots and ball are. Who asks sees the truth, programs that play included; without this
    /// nobody does
    #[arg(long, requires = "protocol")]
    pub truth_for_monitors: bool,
    /// Carry team messages over UDP for programs that want them, at 127.0.0.1 and port 10000 + the team's number; a robot's program
    /// sends from 127.1.TEAM.NUMBER and hears its team-mates there
    #[arg(long, group = "numbered")]
    pub team_messages: bool,
    /// Add this to every port of it, to play several matches on one machine
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(..=LARGEST_OFFSET), requires = "numbered")]
    pub game_controller_port_offset: Option<u16>,
    /// The numbers of the teams in the league, blue first [default: 1,2, or those that are heard]
    #[arg(long, value_name = "BLUE,PINK", value_parser = team_numbers, requires = "numbered")]
    pub team_numbers: Option<PerTeam<u8>>,
}

impl GameControllerArguments {
    /// Lets the GameController tell of the match in `world`, or decide about it, if it is to.
    pub fn start(&self, world: &mut World) -> Result<(), String> {
        let port_offset = self.game_controller_port_offset.unwrap_or(0);
        if let Some(address) = self.listen_game_controller {
            let listener = Listener::open(address, port_offset, self.team_numbers);
            let listener =
                listener.map_err(|error| format!("--listen-game-controller: {error}"))?.with_notes(report::note);
            let listener = if self.truth_for_monitors { listener.with_truth_for_monitors() } else { listener };
            report::note(&format!("hearing a GameController at {address}; robots stand until it says something"));
            game_controller::listen_to(world, listener);
        }
        if let Some(version) = self.game_controller {
            let address = self.game_controller_address.unwrap_or(Ipv4Addr::LOCALHOST.into());
            let network = NetworkSettings { address, port_offset, tells_monitors: self.truth_for_monitors };
            let team_numbers = self.team_numbers.unwrap_or(TEAM_NUMBERS);
            let controller = GameController::open(GameControllerSettings { version, network, team_numbers });
            let controller = controller.map_err(|error| format!("--game-controller: {error}"))?;
            if self.truth_for_monitors {
                report::note(&format!("monitors are told the truth that ask for it at {}", network.requests()));
            }
            game_controller::start(world, controller);
        }
        if self.team_messages {
            let messages = TeamMessages::open(self.team_numbers.unwrap_or(TEAM_NUMBERS), port_offset);
            game_controller::carry(world, messages.map_err(|error| format!("--team-messages: {error}"))?);
        }
        Ok(())
    }

    /// How many times real time the match is to be played if nothing else is said; none for as fast as it goes.
    pub fn pace(&self) -> Option<f64> {
        self.listen_game_controller.map(|_| 1.0)
    }
}

fn team_numbers(word: &str) -> Result<PerTeam<u8>, String> {
    let numbers = word.split_once(',').and_then(|(blue, pink)| Some((blue.parse().ok()?, pink.parse().ok()?)));
    match numbers {
        Some((blue, pink)) if blue != pink && blue != u8::MAX && pink != u8::MAX => Ok(PerTeam { blue, pink }),
        _ => Err("expected two different numbers from 0 to 254, blue first, such as 5,12".to_owned()),
    }
}

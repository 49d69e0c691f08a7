//! Arguments of the command line about the protocol of the league's GameController.

use bevy::prelude::*;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use std::net::{IpAddr, Ipv4Addr};

use super::report;
use naoisis_agents::game_controller::{
    self, GameController, GameControllerSettings, Listener, NetworkSettings, ProtocolVersion, TeamMessages,
};
use naoisis_core::game::Rules;
use naoisis_core::team::PerTeam;

/// The default numbers of the teams.
const TEAM_NUMBERS: PerTeam<u8> = PerTeam { blue: 1, pink: 2 };
/// The largest port offset. The highest port of the protocol, that of a team, is 10255.
const LARGEST_OFFSET: i64 = 55_000;

/// Returns a parser for the name of a protocol version.
fn protocol_versions() -> impl TypedValueParser<Value = ProtocolVersion> {
    let values = ProtocolVersion::ALL.map(|version| PossibleValue::new(version.name()).help(version.league()));
    PossibleValuesParser::new(values).map(|name| {
        let mut versions = ProtocolVersion::ALL.into_iter();
        versions.find(|version| version.name() == name).unwrap_or(ProtocolVersion::V20)
    })
}

/// Arguments about the GameController.
#[derive(Args, Debug, Clone, PartialEq, Eq, Default)]
#[command(group = ArgGroup::new("numbered").multiple(true))]
pub struct GameControllerArguments {
    /// Send the state of the game as the league's GameController does: control packets to UDP port 3838, twice a
    /// simulated second; robots report to port 3939 [default version: that of the rules]
    #[arg(long, value_parser = protocol_versions(), value_name = "v18|v19|v20", groups = ["protocol", "numbered"])]
    pub game_controller: Option<Option<ProtocolVersion>>,
    /// Send each change at once, too, and not only twice a simulated second
    #[arg(long, requires = "game_controller")]
    pub game_controller_at_once: bool,
    /// Follow a real GameController, whose packets are received at UDP port 3838 of this address: its operator
    /// whistles, penalises and restarts. Plays in real time unless --pace is given [default: 127.0.0.1]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1", groups = ["protocol", "numbered"])]
    pub listen_game_controller: Option<IpAddr>,
    /// Address for control packets [default: 127.0.0.1]; 127.255.255.255 reaches every program on this machine, the
    /// broadcast address of a network every robot in it
    #[arg(long, value_name = "ADDRESS", requires = "game_controller")]
    pub game_controller_address: Option<IpAddr>,
    /// Send the true state to monitors that request it at UDP port 3636, as from a GameController: the game without
    /// delays and, with --listen-game-controller, the positions of robots and ball. Any program that requests it
    /// receives it, programs that play included; without this option no program does
    #[arg(long, requires = "protocol")]
    pub truth_for_monitors: bool,
    /// Carry team messages over UDP, at 127.0.0.1 and port 10000 + the number of the team; the program of a robot sends
    /// from 127.1.TEAM.NUMBER and receives messages of team-mates there
    #[arg(long, group = "numbered")]
    pub team_messages: bool,
    /// Add this to every port, to play several matches on one machine
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(..=LARGEST_OFFSET), requires = "numbered")]
    pub game_controller_port_offset: Option<u16>,
    /// Numbers of the teams in the league, blue first [default: 1,2, or those of the GameController that is heard]
    #[arg(long, value_name = "BLUE,PINK", value_parser = team_numbers, requires = "numbered")]
    pub team_numbers: Option<PerTeam<u8>>,
}

impl GameControllerArguments {
    /// Starts the GameController of the arguments in `world`, or the listener to a real one.
    pub fn start(&self, world: &mut World) -> Result<(), String> {
        let port_offset = self.game_controller_port_offset.unwrap_or(0);
        if let Some(address) = self.listen_game_controller {
            let listener = Listener::open(address, port_offset, self.team_numbers);
            let listener =
                listener.map_err(|error| format!("--listen-game-controller: {error}"))?.with_notes(report::note);
            let listener = if self.truth_for_monitors { listener.with_truth_for_monitors() } else { listener };
            report::note(&format!("listening for a GameController at {address}; robots stand until its first packet"));
            game_controller::listen_to(world, listener);
        }
        if let Some(version) = self.game_controller {
            let address = self.game_controller_address.unwrap_or(Ipv4Addr::LOCALHOST.into());
            let network = NetworkSettings { address, port_offset, tells_monitors: self.truth_for_monitors };
            let team_numbers = self.team_numbers.unwrap_or(TEAM_NUMBERS);
            let version = version.unwrap_or_else(|| ProtocolVersion::of_rules(world.resource::<Rules>()));
            let at_once = self.game_controller_at_once;
            let controller = GameController::open(GameControllerSettings { version, network, team_numbers, at_once });
            let controller =
                controller.map_err(|error| format!("--game-controller: {error}"))?.with_notes(report::note);
            if self.truth_for_monitors {
                report::note(&format!("monitors that ask at {} receive the true state", network.requests()));
            }
            game_controller::start(world, controller);
        }
        if self.team_messages {
            let messages = TeamMessages::open(self.team_numbers.unwrap_or(TEAM_NUMBERS), port_offset);
            game_controller::carry(world, messages.map_err(|error| format!("--team-messages: {error}"))?);
        }
        Ok(())
    }

    /// Returns the default speed as a multiple of real time; `None` for as fast as possible.
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

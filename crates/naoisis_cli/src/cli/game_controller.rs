//! Arguments of the command line about the protocol of the league's GameController.

use bevy::prelude::*;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use std::io::ErrorKind;
use std::net::{IpAddr, Ipv4Addr};

use super::report;
use naoisis_agents::game_controller::{
    self, LARGEST_OFFSET, Listener, MatchNetwork, NetworkError, NetworkSettings, ProtocolVersion, TeamColours,
};
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::PerTeam;
use naoisis_sim::scenario::wording::one_of;

/// The default numbers of the teams.
const TEAM_NUMBERS: PerTeam<u8> = PerTeam { blue: 1, pink: 2 };

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
    /// Add this to every port, to play several matches on one machine. If a command plays several matches, each adds
    /// 1000 more than another that is played at the same time
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(..=i64::from(LARGEST_OFFSET)), requires = "numbered")]
    pub game_controller_port_offset: Option<u16>,
    /// Colours of the jerseys that control packets tell, blue's first, each with the goalkeeper's if it differs: black/yellow,white
    /// [default: what the robots wear]
    #[arg(long, value_name = "BLUE,PINK", value_parser = team_colours, requires = "game_controller")]
    pub team_colours: Option<PerTeam<TeamColours>>,
    /// Numbers of the teams in the league, blue first [default: 1,2, or those of the GameController that is heard]
    #[arg(long, value_name = "BLUE,PINK", value_parser = team_numbers, requires = "numbered")]
    pub team_numbers: Option<PerTeam<u8>>,
}

impl GameControllerArguments {
    /// Starts the GameController of the arguments in `world`, or the listener to a real one.
    pub fn start(&self, world: &mut World) -> Result<(), String> {
        let port_offset = self.game_controller_port_offset.unwrap_or(0);
        // A port that is in use may be free with another offset.
        let cannot = |option: &str, error: NetworkError| match error.error.kind() {
            ErrorKind::AddrInUse => {
                format!("{option}: {error}; expected a free port, as with --game-controller-port-offset 1000")
            }
            _ => format!("{option}: {error}"),
        };
        if let Some(address) = self.listen_game_controller {
            let listener = Listener::open(address, port_offset, self.team_numbers);
            let listener =
                listener.map_err(|error| cannot("--listen-game-controller", error))?.with_notes(report::note);
            let listener = if self.truth_for_monitors { listener.with_truth_for_monitors() } else { listener };
            report::note(&format!("listening for a GameController at {address}; robots stand until its first packet"));
            game_controller::listen_to(world, listener);
        }
        let network = MatchNetwork { notes: Some(report::note), ..self.network() };
        let started = network.start_game_controller(world, port_offset);
        started.map_err(|error| cannot("--game-controller", error))?;
        if self.game_controller.is_some() && self.truth_for_monitors {
            let settings = NetworkSettings { address: network.address, port_offset, tells_monitors: true };
            report::note(&format!("monitors that ask at {} receive the true state", settings.requests()));
        }
        network.carry_team_messages(world, port_offset).map_err(|error| cannot("--team-messages", error))
    }

    /// Returns the network of each match, if several are played, with ports of their own; `threads` are played at the same time. `None`
    /// if the arguments ask for none.
    pub fn of_many(&self, threads: usize) -> Result<Option<MatchNetwork>, String> {
        if self.listen_game_controller.is_some() {
            return Err("--listen-game-controller: a GameController decides about one match; expected a command that plays no other".to_owned());
        }
        let network = self.network();
        // The match of `run` itself has the first ports.
        let most = network.offsets.all().count().saturating_sub(1);
        if self.game_controller.is_none() && !self.team_messages {
            Ok(None)
        } else if threads > most {
            Err(format!("there are ports for {most} matches at the same time; expected at most as many --threads"))
        } else {
            Ok(Some(network))
        }
    }

    fn network(&self) -> MatchNetwork {
        let first_offset = self.game_controller_port_offset.unwrap_or(0);
        MatchNetwork {
            game_controller: self.game_controller,
            at_once: self.game_controller_at_once,
            address: self.game_controller_address.unwrap_or(Ipv4Addr::LOCALHOST.into()),
            tells_monitors: self.truth_for_monitors,
            carries_team_messages: self.team_messages,
            colours: self.team_colours,
            ..MatchNetwork::new(self.team_numbers.unwrap_or(TEAM_NUMBERS), first_offset)
        }
    }

    /// Returns the default speed as a multiple of real time; `None` for as fast as possible.
    pub fn pace(&self) -> Option<f64> {
        self.listen_game_controller.map(|_| 1.0)
    }
}

fn team_colours(words: &str) -> Result<PerTeam<TeamColours>, String> {
    let colour = |word: &str| Jersey::COLOURS.into_iter().find(|(name, _)| *name == word).map(|(_, colour)| colour);
    let team = |words: &str| {
        let (players, goalkeeper) = words.split_once('/').unwrap_or((words, words));
        Some(TeamColours { players: colour(players)?, goalkeeper: colour(goalkeeper)? })
    };
    let both = words.split_once(',').and_then(|(blue, pink)| Some(PerTeam { blue: team(blue)?, pink: team(pink)? }));
    both.filter(|colours| colours.blue.players != colours.pink.players).ok_or_else(|| {
        let names = one_of(Jersey::COLOURS.into_iter().map(|(name, _)| name));
        format!("expected two different colours, such as black,white or black/yellow,white; each is {names}")
    })
}

fn team_numbers(word: &str) -> Result<PerTeam<u8>, String> {
    let numbers = word.split_once(',').and_then(|(blue, pink)| Some((blue.parse().ok()?, pink.parse().ok()?)));
    match numbers {
        Some((blue, pink)) if blue != pink && blue != u8::MAX && pink != u8::MAX => Ok(PerTeam { blue, pink }),
        _ => Err("expected two different numbers from 0 to 254, blue first, such as 5,12".to_owned()),
    }
}

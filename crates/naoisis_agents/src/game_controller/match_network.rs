//! The network of matches that are played one after another or side by side: each match has UDP ports of its own.

use bevy::prelude::*;
use std::collections::BTreeSet;
use std::io;
use std::net::{IpAddr, Ipv4Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::colours::TeamColours;
use super::packet::ProtocolVersion;
use super::sockets::NetworkError;
use super::team_messages::TeamMessages;
use super::{GameController, GameControllerSettings, NetworkSettings, carry, start};
use naoisis_core::game::Rules;
use naoisis_core::team::PerTeam;

/// The distance between the port offsets of two matches. The ports of matches at such distances are all different.
pub const OFFSET_STEP: u16 = 1000;
/// The largest port offset. The highest port of the protocol, that of a team, is 10255.
pub const LARGEST_OFFSET: u16 = 55_000;

/// What matches send and carry over UDP. As a resource, it is for [`open_network`].
#[derive(Resource, Clone, Debug)]
pub struct MatchNetwork {
    /// The protocol of the simulated GameController: `Some(None)` is that of the rules; `None` is no GameController.
    pub game_controller: Option<Option<ProtocolVersion>>,
    /// Whether changes are also sent at once.
    pub at_once: bool,
    /// The address to which control packets are sent.
    pub address: IpAddr,
    /// Whether monitors that ask receive the true state.
    pub tells_monitors: bool,
    /// Whether team messages are carried.
    pub carries_team_messages: bool,
    /// The numbers of the teams in the league.
    pub team_numbers: PerTeam<u8>,
    /// The colours of jerseys that packets tell; `None` for those that the robots wear.
    pub colours: Option<PerTeam<TeamColours>>,
    /// The port offsets of the matches.
    pub offsets: PortOffsets,
    /// Receives messages about faults, if there is one.
    pub notes: Option<fn(&str)>,
}

impl MatchNetwork {
    /// A network that sends and carries nothing yet, with port offsets from `first_offset` on.
    pub fn new(team_numbers: PerTeam<u8>, first_offset: u16) -> Self {
        Self {
            game_controller: None,
            at_once: false,
            address: Ipv4Addr::LOCALHOST.into(),
            tells_monitors: false,
            carries_team_messages: false,
            team_numbers,
            colours: None,
            offsets: PortOffsets::new(first_offset),
            notes: None,
        }
    }

    /// Starts the simulated GameController of the match in `world`, if there is to be one.
    ///
    /// # Errors
    /// If a socket cannot be opened, for example because another GameController uses the port.
    pub fn start_game_controller(&self, world: &mut World, port_offset: u16) -> Result<(), NetworkError> {
        if let Some(controller) = self.controller(world, port_offset)? {
            start(world, controller);
        }
        Ok(())
    }

    /// Carries the team messages of the match in `world`, if they are to be carried.
    ///
    /// # Errors
    /// If a socket cannot be opened, for example because another program uses the port.
    pub fn carry_team_messages(&self, world: &mut World, port_offset: u16) -> Result<(), NetworkError> {
        if let Some(messages) = self.messages(port_offset)? {
            carry(world, messages);
        }
        Ok(())
    }

    fn controller(&self, world: &World, port_offset: u16) -> Result<Option<GameController>, NetworkError> {
        let Some(version) = self.game_controller else { return Ok(None) };
        let network = NetworkSettings { address: self.address, port_offset, tells_monitors: self.tells_monitors };
        let of_rules = || world.get_resource::<Rules>().map_or(ProtocolVersion::V20, ProtocolVersion::of_rules);
        let version = version.unwrap_or_else(of_rules);
        let (team_numbers, at_once, colours) = (self.team_numbers, self.at_once, self.colours);
        let settings = GameControllerSettings { version, network, team_numbers, at_once, colours };
        let controller = GameController::open(settings)?;
        Ok(Some(if let Some(notes) = self.notes { controller.with_notes(notes) } else { controller }))
    }

    fn messages(&self, port_offset: u16) -> Result<Option<TeamMessages>, NetworkError> {
        if !self.carries_team_messages {
            return Ok(None);
        }
        let messages = TeamMessages::open(self.team_numbers, port_offset)?;
        Ok(Some(if let Some(notes) = self.notes { messages.with_notes(notes) } else { messages }))
    }

    /// Opens the network of the match in `world` at the first port offset that is free.
    fn open(&self, world: &mut World) -> Result<(), NetworkError> {
        let port_offset = self.offsets.first;
        let place = NetworkSettings { address: self.address, port_offset, tells_monitors: false }.reports();
        let mut last = NetworkError { address: place, error: io::ErrorKind::AddrInUse.into() };
        for offset in self.offsets.all() {
            let Some(lease) = self.offsets.lease(offset) else { continue };
            let opened = self.controller(world, offset).and_then(|controller| Ok((controller, self.messages(offset)?)));
            match opened {
                Ok((controller, messages)) => {
                    controller.into_iter().for_each(|controller| start(world, controller));
                    messages.into_iter().for_each(|messages| carry(world, messages));
                    world.insert_resource(lease);
                    return Ok(());
                }
                // Another match has these ports.
                Err(error) if error.error.kind() == io::ErrorKind::AddrInUse => last = error,
                Err(error) => return Err(error),
            }
        }
        Err(last)
    }
}

/// Opens the network of the match in `world`, if it has a [`MatchNetwork`], at ports that no other match uses. Call it
/// before programs are started: they learn the ports from their environment.
///
/// # Errors
/// If a socket cannot be opened, or no ports are free.
pub fn open_network(world: &mut World) -> Result<(), NetworkError> {
    match world.get_resource::<MatchNetwork>().cloned() {
        Some(network) => network.open(world),
        None => Ok(()),
    }
}

/// The port offsets of the matches of one process. Clones share them.
#[derive(Clone, Debug, Default)]
pub struct PortOffsets {
    first: u16,
    leased: Arc<Mutex<BTreeSet<u16>>>,
}

impl PortOffsets {
    /// Port offsets from `first` on.
    pub fn new(first: u16) -> Self {
        Self { first, leased: Arc::default() }
    }

    /// The offsets, in the order in which they are tried.
    pub fn all(&self) -> impl Iterator<Item = u16> + use<> {
        (self.first..=LARGEST_OFFSET).step_by(usize::from(OFFSET_STEP))
    }

    /// Takes an offset until the lease is dropped; `None` if it is taken.
    fn lease(&self, offset: u16) -> Option<PortLease> {
        let leased = self.leased().insert(offset);
        leased.then(|| PortLease { offsets: self.clone(), offset })
    }

    fn leased(&self) -> MutexGuard<'_, BTreeSet<u16>> {
        self.leased.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The port offset of a match, which no other match takes meanwhile.
#[derive(Resource, Debug)]
struct PortLease {
    offsets: PortOffsets,
    offset: u16,
}

impl Drop for PortLease {
    fn drop(&mut self) {
        self.offsets.leased().remove(&self.offset);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agents::LeagueNumbers;

    #[test]
    fn matches_at_the_same_time_have_ports_of_their_own_and_later_ones_take_them_again() {
        // A network that opens no sockets takes offsets, too.
        let network = MatchNetwork::new(PerTeam { blue: 5, pink: 12 }, 3);
        let begin = || {
            let mut world = World::new();
            world.insert_resource(network.clone());
            open_network(&mut world).unwrap();
            let offset = world.resource::<PortLease>().offset;
            (world, offset)
        };
        let (first, second) = (begin(), begin());
        assert_eq!((first.1, second.1), (3, 1003));
        drop(first);
        assert_eq!(begin().1, 3);
        assert_eq!(network.offsets.all().last(), Some(54_003));
    }

    #[test]
    fn ports_that_another_program_uses_are_left_to_it() {
        let network =
            MatchNetwork { carries_team_messages: true, ..MatchNetwork::new(PerTeam { blue: 5, pink: 12 }, 41_234) };
        let _other = TeamMessages::open(network.team_numbers, 41_234).unwrap();
        let mut world = World::new();
        world.insert_resource(network);
        open_network(&mut world).unwrap();
        let numbers = world.resource::<LeagueNumbers>();
        assert_eq!((numbers.port_offset, numbers.team_numbers), (42_234, Some(PerTeam { blue: 5, pink: 12 })));
    }

    #[test]
    fn the_ports_of_two_matches_are_different() {
        let ports = |offset: u16| {
            let fixed = [3636, 3637, 3838, 3939, 3940].map(|port: u16| port + offset);
            (0..=254).map(move |team| 10_000 + team + offset).chain(fixed)
        };
        let all: Vec<u16> = PortOffsets::new(0).all().flat_map(ports).collect();
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
    }
}

//! The protocol of the league's GameController: robots receive the state of the game as from a real GameController, over UDP, in simulated
//! time.
//!
//! A [`GameController`] that is [started](start) in a world sends [control packets](packet) twice per simulated second, like the real one:
//! robots hear of a change up to half a second later, and of a brief stop at once. If [`at_once`](GameControllerSettings::at_once) is set, it also sends each change (of
//! more than a clock or a message budget) at once. It receives the [reports](report) of robots. These are on the robots as
//! [`StatusReport`](naoisis_core::communication::StatusReport), in traces, and in the window. With
//! [`tells_monitors`](NetworkSettings::tells_monitors), monitors that ask receive the true state without delay, and which team takes a free
//! kick.
//!
//! A [`Listener`] ([`listen_to`]) does the reverse: the match follows a real GameController, whose operator decides. Monitors that ask the
//! match then receive the true positions of robots and ball, if the [listener](Listener::with_truth_for_monitors) is set up for it. Any
//! program that asks receives them, including programs that play; without that setting no true state leaves a match.
//!
//! [`TeamMessages`] ([`carry`]) lets programs send messages to their team-mates over UDP, as on a field. A match with
//! none of these opens no socket, and runs no system of this module. Many matches of one process have ports of their own
//! with a [`MatchNetwork`].

use bevy::prelude::*;

mod colours;
mod complaints;
mod division;
mod listener;
mod match_network;
mod monitors;
mod network;
pub mod packet;
mod packet_series;
mod packet_source;
pub mod report;
mod senders;
mod sockets;
mod status_reports;
mod team_messages;
mod truth;
mod version;

pub use colours::TeamColours;
pub use division::Division;
pub use listener::Listener;
pub use match_network::{LARGEST_OFFSET, MatchNetwork, PortOffsets, open_network};
pub use network::NetworkSettings;
pub use packet::{ControlPacket, GamePhase, ProtocolVersion};
pub use packet_source::{EndedPart, PacketSource};
pub use report::ReturnPacket;
pub use sockets::{HERE, NetworkError, robot_address};
pub use team_messages::TeamMessages;

use complaints::Complaints;
use network::Network;
use packet_series::{MatchStatus, PACKETS_AFTER_END, PacketSeries};

use crate::agents::LeagueNumbers;
use naoisis_core::communication::deliver_messages;
use naoisis_core::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use naoisis_core::events::CycleEvents;
use naoisis_core::game::{OutsideReferee, ShootOut};
use naoisis_core::robot::Roster;
use naoisis_core::team::{PerTeam, RobotId, Team};

/// The settings of a simulated GameController.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct GameControllerSettings {
    /// The version of the protocol.
    pub version: ProtocolVersion,
    /// Addresses and ports.
    pub network: NetworkSettings,
    /// The numbers of the teams in the league.
    pub team_numbers: PerTeam<u8>,
    /// Whether changes are also sent at once, and not only twice per simulated second, as by a real GameController.
    pub at_once: bool,
    /// The colours of jerseys that packets tell; `None` for those that the robots wear.
    pub colours: Option<PerTeam<TeamColours>>,
}

/// A simulated GameController, which sends the state of the match to robots.
#[derive(Resource, Debug)]
pub struct GameController {
    settings: GameControllerSettings,
    network: Network,
    /// The packets for robots, and those for monitors.
    packets: [PacketSeries; 2],
    /// Messages about the GameController, as events and for the user.
    complaints: Complaints,
    /// The shoot-out after the last cycle, with its scored shots.
    shoot_out: Option<ShootOut>,
    shots_scored: PerTeam<u16>,
    /// How the last half or shot ended, as robots and monitors know it.
    ended: [EndedPart; 2],
}

impl GameController {
    /// Opens the sockets.
    ///
    /// # Errors
    /// If a socket cannot be opened, for example because another GameController uses the port.
    pub fn open(settings: GameControllerSettings) -> Result<Self, NetworkError> {
        Ok(Self {
            settings,
            network: Network::open(settings.network)?,
            packets: Default::default(),
            complaints: Complaints::default(),
            shoot_out: None,
            shots_scored: PerTeam::default(),
            ended: Default::default(),
        })
    }

    /// Adds a function that receives messages about faults.
    #[must_use]
    pub fn with_notes(mut self, notes: impl Fn(&str) + Send + Sync + 'static) -> Self {
        self.complaints.notes = Some(Box::new(notes));
        self
    }

    /// Sends the state of the match to robots and monitors if `is_time` or something has changed.
    fn send_state(&mut self, status: &MatchStatus, is_time: bool) {
        packet_source::note_shots(&mut self.shots_scored, self.shoot_out.as_ref(), status.game.shoot_out.as_ref());
        self.shoot_out = status.game.shoot_out;
        self.send(status, false, is_time);
        if self.network.has_monitors() {
            self.send(status, true, is_time);
        }
    }

    /// Sends a packet if `is_time` or something has changed.
    fn send(&mut self, status: &MatchStatus, for_monitors: bool, is_time: bool) {
        let GameControllerSettings { version, team_numbers, at_once, colours, .. } = self.settings;
        if !is_time && !at_once {
            return;
        }
        let ended = &mut self.ended[usize::from(for_monitors)];
        let packet = status.packet(version, for_monitors, team_numbers, colours, self.shots_scored, Some(ended));
        if let Some(packet) = self.packets[usize::from(for_monitors)].next(packet, is_time) {
            self.network.send(&packet);
        }
    }
}

/// Starts sending the state of the match in `world`, from its current state on.
pub fn start(world: &mut World, mut controller: GameController) {
    for (robot, _) in world.get_resource::<Roster>().iter().flat_map(|roster| roster.iter()) {
        if usize::from(robot.number) > packet::MOST_PLAYERS {
            let most = packet::MOST_PLAYERS;
            controller
                .complaints
                .add(format!("packets have no room for {robot}: their players have numbers up to {most}"));
        }
    }
    if !world.contains_resource::<GameController>() {
        world.get_resource_or_init::<Schedules>().add_systems(
            Cycle,
            (
                send_changes.in_set(CycleSystems::Communicate),
                take_reports.in_set(CycleSystems::Act),
                send_state.in_set(CycleSystems::Last),
            ),
        );
    }
    let (team_numbers, port_offset) = (controller.settings.team_numbers, controller.settings.network.port_offset);
    world.insert_resource(LeagueNumbers { team_numbers: Some(team_numbers), port_offset });
    world.insert_resource(controller);
    // This fails only if there is no match.
    let _ = world.run_system_cached(send_state);
}

/// Makes the match in `world` follow a real GameController from now on. Robots stand until its first packet arrives.
pub fn listen_to(world: &mut World, listener: Listener) {
    if !world.contains_resource::<Listener>() {
        world.get_resource_or_init::<Schedules>().add_systems(
            Cycle,
            (
                listener::listen.in_set(CycleSystems::Communicate),
                (listener::report, listener::tell_the_truth).chain().in_set(CycleSystems::Last),
            ),
        );
    }
    world.insert_resource(listener.numbers_for_programs());
    world.insert_resource(listener);
    world.insert_resource(OutsideReferee { half: 1, ..default() });
}

/// Carries team messages over UDP in `world` from now on.
pub fn carry(world: &mut World, messages: TeamMessages) {
    if !world.contains_resource::<TeamMessages>() {
        world.get_resource_or_init::<Schedules>().add_systems(
            Cycle,
            (
                team_messages::hand_out.in_set(CycleSystems::Communicate).after(deliver_messages),
                team_messages::take.in_set(CycleSystems::Act).before(ActSystems::Say),
            ),
        );
    }
    world.insert_resource(messages.numbers_for_programs());
    world.insert_resource(messages);
}

/// Sends changes since the last cycle: a match may begin at the start of a cycle.
fn send_changes(status: MatchStatus, mut controller: ResMut<GameController>, mut events: ResMut<CycleEvents>) {
    controller.complaints.publish(&mut events);
    controller.send_state(&status, false);
}

fn take_reports(
    mut commands: Commands,
    clock: Res<CycleClock>,
    roster: Res<Roster>,
    mut controller: ResMut<GameController>,
) {
    let numbers = controller.settings.team_numbers;
    for packet in controller.network.take_reports(clock.start_time_s()) {
        let team = Team::BOTH.into_iter().find(|team| numbers[*team] == packet.team);
        let robot = team.and_then(|team| roster.get(RobotId::new(team, packet.player)));
        if let Some(robot) = robot {
            commands.entity(robot).insert(packet.report);
        }
    }
}

/// Sends the state after the cycle.
fn send_state(status: MatchStatus, mut controller: ResMut<GameController>) {
    let is_time = status.is_time();
    controller.send_state(&status, is_time);
    if status.is_just_over() {
        (0..PACKETS_AFTER_END).for_each(|_| controller.send_state(&status, true));
    }
}

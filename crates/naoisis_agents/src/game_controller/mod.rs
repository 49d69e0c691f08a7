//! The league's GameController: a match tells robots of the game in the protocol that they know from real ones, over UDP, in
//! simulated time.
//!
//! A [`GameController`] that is [started](start) in a world sends [control packets](packet) twice a simulated second and at each
//! change of more than a clock, and takes the robots' [reports](report), which are on the robots as
//! [`StatusReport`](naoisis_core::communication::StatusReport), in traces, and in the window. Where the
//! [settings](NetworkSettings::tells_monitors) say so, monitors that ask are told the truth: at once, and whose a free kick is.
//!
//! With a [`Listener`] ([`listen_to`]) it is the other way round: a real GameController is heard, and whoever operates it decides
//! about the match. Monitors that ask the match are then told where its robots and the ball are, if the
//! [listener](Listener::with_truth_for_monitors) is to tell them. Whoever asks is told, programs that play
//! included: unasked for, no truth leaves a match.
//! With [`TeamMessages`] ([`carry`]) programs talk to their team-mates as on a field, too. A match with none of these opens no
//! socket, and runs no system of this module.

use bevy::prelude::*;

mod division;
mod listener;
mod monitors;
mod network;
pub mod packet;
mod portrait;
pub mod report;
mod sockets;
mod status_reports;
mod team_messages;
mod telling;
mod truth;

pub use division::Division;
pub use listener::Listener;
pub use network::NetworkSettings;
pub use packet::{ControlPacket, ProtocolVersion};
pub use portrait::Portrayed;
pub use report::ReturnPacket;
pub use sockets::{HERE, NetworkError, robot_address};
pub use team_messages::TeamMessages;

use network::Network;
use telling::{PacketSeries, ToldMatch};

use naoisis_core::communication::deliver_messages;
use naoisis_core::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use naoisis_core::game::{OutsideReferee, ShootOut};
use naoisis_core::robot::Roster;
use naoisis_core::team::{PerTeam, RobotId, Team};

/// How a match is told of.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct GameControllerSettings {
    /// In which version of the protocol.
    pub version: ProtocolVersion,
    /// Where to, and at which ports.
    pub network: NetworkSettings,
    /// The teams' numbers in the league.
    pub team_numbers: PerTeam<u8>,
}

/// Tells robots of the match.
#[derive(Resource, Debug)]
pub struct GameController {
    settings: GameControllerSettings,
    network: Network,
    /// What the robots are told, and what monitors are.
    packets: [PacketSeries; 2],
    /// The shoot-out after the last cycle, and its shots that have scored.
    shoot_out: Option<ShootOut>,
    shots_scored: PerTeam<u16>,
}

impl GameController {
    /// Opens the sockets.
    ///
    /// # Errors
    /// When one cannot be opened, such as where another GameController is.
    pub fn open(settings: GameControllerSettings) -> Result<Self, NetworkError> {
        Ok(Self {
            settings,
            network: Network::open(settings.network)?,
            packets: Default::default(),
            shoot_out: None,
            shots_scored: PerTeam::default(),
        })
    }

    /// Tells robots and monitors how the match is, if it is time or something has changed.
    fn tell(&mut self, told: &ToldMatch, is_time: bool) {
        portrait::note_shots(&mut self.shots_scored, self.shoot_out.as_ref(), told.game.shoot_out.as_ref());
        self.shoot_out = told.game.shoot_out;
        self.send(told, false, is_time);
        if self.network.has_monitors() {
            self.send(told, true, is_time);
        }
    }

    /// Sends a packet, if it is time or it says something new.
    fn send(&mut self, told: &ToldMatch, for_monitors: bool, is_time: bool) {
        let GameControllerSettings { version, team_numbers, .. } = self.settings;
        let packet = told.packet(version, for_monitors, team_numbers, self.shots_scored);
        if let Some(packet) = self.packets[usize::from(for_monitors)].next(packet, is_time) {
            self.network.send(&packet);
        }
    }
}

/// Lets a GameController tell of the match in `world` from now on, its beginning first.
pub fn start(world: &mut World, controller: GameController) {
    if !world.contains_resource::<GameController>() {
        world.get_resource_or_init::<Schedules>().add_systems(
            Cycle,
            (
                tell_changes.in_set(CycleSystems::Communicate),
                take_reports.in_set(CycleSystems::Act),
                tell.in_set(CycleSystems::Last),
            ),
        );
    }
    world.insert_resource(controller);
    // It fails only where there is no match.
    let _ = world.run_system_cached(tell);
}

/// Lets the GameController that is heard decide about the match in `world`, from now on. Until it says something, robots stand.
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
    world.insert_resource(listener);
    world.insert_resource(OutsideReferee { half: 1, ..default() });
}

/// Carries what teams in `world` say, from now on.
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
    world.insert_resource(messages);
}

/// What has changed since the last cycle: a match begins at the beginning of one.
fn tell_changes(told: ToldMatch, mut controller: ResMut<GameController>) {
    controller.tell(&told, false);
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

/// How the match is after the cycle.
fn tell(told: ToldMatch, mut controller: ResMut<GameController>) {
    let is_time = told.is_time();
    controller.tell(&told, is_time);
}

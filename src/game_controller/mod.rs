//! The league's GameController: a match tells robots of the game in the protocol that they know from real ones, over UDP, in
//! simulated time.
//!
//! With a [`GameController`] in the world the [`GameControllerPlugin`] sends [control packets](packet) twice a simulated second
//! and at each change of more than a clock, and takes the robots' [reports](report), which are on the robots as
//! [`StatusReport`], in traces, and in the window. Monitors that ask are told the truth: at once, and whose a free kick is.
//!
//! With a [`Listener`] it is the other way round: a real GameController is heard, and whoever operates it decides about the match.
//! With [`TeamMessages`] programs talk to their team-mates as on a field, too. A match with none of these opens no socket.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

mod listener;
mod network;
pub mod packet;
mod portrait;
pub mod report;
mod status_reports;
mod team_messages;

pub use listener::{Listener, listen_to};
pub use network::{NetworkError, NetworkSettings};
pub use packet::{ControlPacket, ProtocolVersion};
pub use portrait::Portrayed;
pub use report::ReturnPacket;
pub use team_messages::{HERE, TeamMessages, robot_address};

use network::Network;

use crate::communication::{StatusReport, deliver_messages};
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::game::{Game, Penalty, Rules, ShootOut};
use crate::referee::RefereeMemory;
use crate::robot::Roster;
use crate::team::{PerTeam, RobotId, Team};

/// Between two packets if nothing changes, s.
const PERIOD_S: f32 = 0.5;

/// Lets a [`GameController`] tell of the match, if there is one, a [`Listener`] hear who decides about it, and [`TeamMessages`]
/// carry what teams say.
pub struct GameControllerPlugin;

impl Plugin for GameControllerPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<StatusReport>()
            .add_systems(Cycle, listener::listen.in_set(CycleSystems::Communicate).run_if(resource_exists::<Listener>))
            .add_systems(Cycle, listener::report.in_set(CycleSystems::Last).run_if(resource_exists::<Listener>));
        app.add_systems(
            Cycle,
            (
                tell_changes.in_set(CycleSystems::Communicate),
                take_reports.in_set(CycleSystems::Act),
                tell.in_set(CycleSystems::Last),
            )
                .run_if(resource_exists::<GameController>),
        );
        app.add_systems(
            Cycle,
            (
                team_messages::hand_out.in_set(CycleSystems::Communicate).after(deliver_messages),
                team_messages::take.in_set(CycleSystems::Act).before(ActSystems::Say),
            )
                .run_if(resource_exists::<TeamMessages>),
        );
    }
}

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
    packet_number: u8,
    /// What was told last, to the robots and to monitors, without its time.
    told: [Option<ControlPacket>; 2],
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
            packet_number: 0,
            told: [None, None],
            shoot_out: None,
            shots_scored: PerTeam::default(),
        })
    }

    /// Tells robots and monitors how the match is, if it is time or something has changed.
    fn tell(&mut self, told: &ToldMatch, is_time: bool) {
        let ToldMatch { clock, game, rules, memory, robots } = told;
        portrait::note_shots(&mut self.shots_scored, self.shoot_out.as_ref(), game.shoot_out.as_ref());
        self.shoot_out = game.shoot_out;
        let mut robots: Vec<(RobotId, Penalty)> = robots.iter().map(|(id, penalty)| (*id, *penalty)).collect();
        robots.sort_by_key(|(id, _)| *id);
        let GameControllerSettings { version, team_numbers, .. } = self.settings;
        let shots_scored = self.shots_scored;
        let records = &memory.robots;
        let portrayed = |game| Portrayed { game, rules, clock, robots: &robots, records, team_numbers, shots_scored };
        self.send(portrayed(memory.announcement.told(game)).packet(version, false), is_time);
        if self.network.has_monitors() {
            self.send(portrayed(game).packet(version, true), is_time);
        }
    }

    /// Sends a packet, if it is time or it says something new.
    fn send(&mut self, packet: ControlPacket, is_time: bool) {
        let told = &mut self.told[usize::from(packet.for_monitors)];
        let without_time = packet.without_time();
        if !is_time && told.as_ref() == Some(&without_time) {
            return;
        }
        *told = Some(without_time);
        self.network.send(&ControlPacket { packet_number: self.packet_number, ..packet });
        self.packet_number = self.packet_number.wrapping_add(1);
    }
}

/// Lets a GameController tell of the match in `world` from now on, its beginning first.
pub fn start(world: &mut World, controller: GameController) {
    world.insert_resource(controller);
    // It fails only where there is no match.
    let _ = world.run_system_cached(tell);
}

/// What a match is told of from.
#[derive(SystemParam)]
struct ToldMatch<'w, 's> {
    clock: Res<'w, CycleClock>,
    game: Res<'w, Game>,
    rules: Res<'w, Rules>,
    memory: Res<'w, RefereeMemory>,
    robots: Query<'w, 's, (&'static RobotId, &'static Penalty)>,
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
    let is_time = told.clock.cycle.is_multiple_of(u64::from(told.clock.cycles_in(PERIOD_S)).max(1));
    controller.tell(&told, is_time);
}

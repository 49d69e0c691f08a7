//! The data from which packets are made, and when to send them.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::colours::TeamColours;
use super::division::Division;
use super::packet::{ControlPacket, ProtocolVersion};
use super::packet_source::{EndedPart, PacketSource};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Penalty, Rules};
use naoisis_core::pitch::Pitch;
use naoisis_core::referee::RefereeMemory;
use naoisis_core::robot::body::Body;
use naoisis_core::team::{PerTeam, RobotId};

/// The time between two packets without changes, s.
const PERIOD_S: f32 = 0.5;
/// The time between two packets when a brief stop has begun, s, and their number after the first.
const STOP_PERIOD_S: f32 = 0.2;
const STOP_PACKETS: u64 = 5;
/// The number of packets that follow the one of the final whistle: those of 5 s, which are not played.
pub(super) const PACKETS_AFTER_END: u32 = 10;

/// The resources and components from which packets are made.
#[derive(SystemParam)]
pub(super) struct MatchStatus<'w, 's> {
    pub clock: Res<'w, CycleClock>,
    pub game: Res<'w, Game>,
    rules: Res<'w, Rules>,
    pitch: Res<'w, Pitch>,
    memory: Res<'w, RefereeMemory>,
    robots: Query<'w, 's, (&'static RobotId, &'static Penalty, &'static Body)>,
}

impl MatchStatus<'_, '_> {
    /// Whether this cycle is that of the final whistle, after which there may be none.
    pub fn is_just_over(&self) -> bool {
        self.game.state == GameState::Finished && self.game.state_cycles == 0
    }

    /// Whether a packet is due after this cycle: twice a second, more often when a brief stop has begun, and at the final whistle.
    pub fn is_time(&self) -> bool {
        let stop_period = u64::from(self.clock.cycles_in(STOP_PERIOD_S)).max(1);
        let in_burst = self
            .game
            .stop
            .is_some_and(|stop| stop.cycles.is_multiple_of(stop_period) && stop.cycles <= STOP_PACKETS * stop_period);
        self.is_just_over()
            || in_burst
            || self.clock.cycle.is_multiple_of(u64::from(self.clock.cycles_in(PERIOD_S)).max(1))
    }

    /// The packet of the current state: the true one for monitors, the announced one for robots. Without `colours` it tells what the
    /// robots wear. `ended` is how the last half or shot ended, and is updated in play.
    pub fn packet(
        &self,
        version: ProtocolVersion,
        for_monitors: bool,
        team_numbers: PerTeam<u8>,
        colours: Option<PerTeam<TeamColours>>,
        shots_scored: PerTeam<u16>,
        ended: Option<&mut EndedPart>,
    ) -> ControlPacket {
        let Self { clock, game, rules, pitch, memory, robots } = self;
        let mut all: Vec<_> = robots.iter().map(|(id, penalty, body)| (*id, *penalty, body.jersey)).collect();
        all.sort_by_key(|(id, ..)| *id);
        let (robots, jerseys): (Vec<_>, Vec<_>) =
            all.into_iter().map(|(id, penalty, jersey)| ((id, penalty), (id, jersey))).unzip();
        let overtime_cycles = game.overtime_cycles;
        let game = if for_monitors { game } else { memory.announcement.announced(game) };
        let colours = colours.unwrap_or_else(|| TeamColours::worn_by(&jerseys, game));
        let records = &memory.robots;
        let division = Division::on(pitch);
        let source = PacketSource {
            game,
            rules,
            division,
            clock,
            robots: &robots,
            records,
            team_numbers,
            colours,
            shots_scored,
            ended: None,
        };
        match ended {
            Some(ended) if source.game_that_ended().is_some() => {
                PacketSource { ended: Some(ended), ..source }.packet(version, for_monitors)
            }
            ended => {
                let packet = source.packet(version, for_monitors);
                ended.into_iter().for_each(|ended| *ended = EndedPart { robots: robots.clone(), overtime_cycles });
                packet
            }
        }
    }
}

/// A numbered series of packets for one group of receivers.
#[derive(Debug, Default)]
pub(super) struct PacketSeries {
    number: u8,
    /// The last packet that was sent, without its time.
    last: Option<ControlPacket>,
}

impl PacketSeries {
    /// The packet with its number if `is_time` or it differs from the last one, else `None`.
    pub fn next(&mut self, packet: ControlPacket, is_time: bool) -> Option<ControlPacket> {
        let without_time = packet.without_time();
        if !is_time && self.last.as_ref() == Some(&without_time) {
            return None;
        }
        self.last = Some(without_time);
        let packet_number = self.number;
        self.number = packet_number.wrapping_add(1);
        Some(ControlPacket { packet_number, ..packet })
    }
}

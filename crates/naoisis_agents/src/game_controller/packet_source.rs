//! Makes control packets from the state of a match.

use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Penalty, PenaltyReason, Rules, SetPlay, ShootOut};
use naoisis_core::pitch::End;
use naoisis_core::referee::{RobotMemory, SetPlayStatus};
use naoisis_core::team::{PerTeam, RobotId, Team};

use super::colours::TeamColours;
use super::division::Division;
use super::packet::{ControlPacket, GamePhase, MOST_PLAYERS, PlayerPacket, ProtocolVersion, TeamPacket};

/// The state of a match from which a packet is made.
#[derive(Clone, Copy, Debug)]
pub struct PacketSource<'a> {
    /// The game: the true one for monitors, the announced one for robots.
    pub game: &'a Game,
    /// The rules of the match.
    pub rules: &'a Rules,
    /// The division that plays.
    pub division: Division,
    /// The clock; the packet is for the end of its cycle.
    pub clock: &'a CycleClock,
    /// All robots, each with its penalty.
    pub robots: &'a [(RobotId, Penalty)],
    /// The referee's memory of each of these robots, in the same order.
    pub records: &'a [RobotMemory],
    /// The numbers of the teams in the league.
    pub team_numbers: PerTeam<u8>,
    /// The colours of the teams' jerseys.
    pub colours: PerTeam<TeamColours>,
    /// The scored shots of a shoot-out, one bit per shot.
    pub shots_scored: PerTeam<u16>,
    /// How the last part of the match ended; `None` if that is not known.
    pub ended: Option<&'a EndedPart>,
}

/// How a half or a shot of a shoot-out ended. It is told while the next one is already prepared.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct EndedPart {
    /// All robots, each with its penalty.
    pub robots: Vec<(RobotId, Penalty)>,
    /// The time that was played beyond the end, cycles.
    pub overtime_cycles: u64,
}

impl PacketSource<'_> {
    /// The packet of this state.
    pub fn packet(&self, version: ProtocolVersion, for_monitors: bool) -> ControlPacket {
        let PacketSource { rules, clock, .. } = *self;
        let break_left = self.seconds_left_of_break();
        if let Some(game) = self.game_that_ended() {
            let robots = self.ended.map_or(self.robots, |ended| &ended.robots);
            let mut packet = PacketSource { game: &game, robots, ended: None, ..*self }.packet(version, for_monitors);
            packet.secondary_seconds_left = break_left.unwrap_or(packet.secondary_seconds_left);
            return packet;
        }
        if let Some(game) = self.game_before_the_shoot_out() {
            return PacketSource { game: &game, ended: None, ..*self }.packet(version, for_monitors);
        }
        let game = self.game;
        let left = Team::BOTH.into_iter().find(|team| game.own_end(*team) == End::NegativeX).unwrap_or_default();
        let [primary, secondary] = self.cycles_left();
        let plays = |penalty: &Penalty| penalty.0.is_none_or(|penalty| penalty.reason != PenaltyReason::Substitute);
        let numbers = |team: Team| self.robots.iter().filter(move |(id, penalty)| id.team == team && plays(penalty));
        let largest_team = Team::BOTH.into_iter().map(|team| numbers(team).count()).max().unwrap_or(0);
        ControlPacket {
            version,
            for_monitors,
            packet_number: 0,
            players_per_team: u8::try_from(largest_team).unwrap_or(u8::MAX),
            is_knockout: rules.shoot_out,
            division: self.division,
            is_stopped: game.stop.is_some(),
            phase: if game.state == GameState::Timeout {
                GamePhase::Timeout
            } else if game.shoot_out.is_some() {
                GamePhase::ShootOut
            } else if rules.is_extra_time(game.half) {
                GamePhase::ExtraTime
            } else {
                GamePhase::Normal
            },
            state: game.state,
            set_play: game.set_play.map(|set_play| set_play.kind),
            is_first_half: game.half == 1 || game.half == rules.halves + 1,
            kicking_team: self.kicking_team(for_monitors).map(|team| self.team_numbers[team]),
            seconds_left: match primary {
                0 => -((game.overtime_cycles as f64 * clock.period_s) as i16),
                _ => whole_seconds(primary, clock).min(i16::MAX as u64) as i16,
            },
            secondary_seconds_left: break_left
                .unwrap_or_else(|| whole_seconds(secondary, clock).min(i16::MAX as u64) as i16),
            teams: [left, left.opponent()].map(|team| self.team(team, version)),
        }
    }

    /// The state of the game at the end of the previous half or shot. Packets have it for a while after the next one has been prepared.
    pub fn game_that_ended(&self) -> Option<Game> {
        self.game_before_the_break().or_else(|| self.game_after_the_shot()).or_else(|| self.game_after_play())
    }

    /// The state of the game at the end of the previous half. Packets have it in the first half of the break.
    fn game_before_the_break(&self) -> Option<Game> {
        let game = self.game;
        (2 * game.state_cycles < self.cycles_of_break()?).then(|| Game {
            state: GameState::Finished,
            half: game.half - 1,
            blue_end: game.blue_end.opposite(),
            cycles_left: Some(0),
            overtime_cycles: self.overtime_cycles(),
            ..game.clone()
        })
    }

    /// The state of the game at the end of the shot before, which is told for a moment when the next shot has been prepared.
    fn game_after_the_shot(&self) -> Option<Game> {
        let game = self.game;
        let shoot_out = self.shoot_out_in_preparation().filter(|shoot_out| !is_first_shot(shoot_out))?;
        let team = shoot_out.team.opponent();
        Some(Game {
            state: GameState::Finished,
            blue_end: game.blue_end.opposite(),
            shoot_out: Some(ShootOut { team, shot: shoot_out.last[team as usize], ..shoot_out }),
            ..game.clone()
        })
    }

    /// The state of the game at the end of play, which is told for a moment when the first shot of a shoot-out has been prepared.
    fn game_after_play(&self) -> Option<Game> {
        let game = self.game;
        self.shoot_out_in_preparation().filter(is_first_shot)?;
        (2 * game.state_cycles < self.cycles_after_shot()).then(|| Game {
            state: GameState::Finished,
            shoot_out: None,
            cycles_left: Some(0),
            overtime_cycles: self.overtime_cycles(),
            ..game.clone()
        })
    }

    /// The state of the game before the first shot, which is told for a moment between the end of play and that shot.
    fn game_before_the_shoot_out(&self) -> Option<Game> {
        self.shoot_out_in_preparation().filter(is_first_shot)?;
        Some(Game { state: GameState::Initial, ..self.game.clone() })
    }

    /// The shoot-out, while the shot or the play before its next shot is told.
    fn shoot_out_in_preparation(&self) -> Option<ShootOut> {
        let game = self.game;
        game.shoot_out.filter(|_| game.state == GameState::Set && game.state_cycles < self.cycles_after_shot())
    }

    /// The time for which the end of a shot is told, cycles: a second, or half of a shorter `set`.
    fn cycles_after_shot(&self) -> u64 {
        u64::from(self.clock.cycles_in(0.5 * self.rules.set_s.min(2.0)))
    }

    /// The length of the break before a half, cycles; `None` in play.
    fn cycles_of_break(&self) -> Option<u64> {
        let is_break = self.game.state == GameState::Initial && self.game.half > 1 && self.game.shoot_out.is_none();
        is_break.then(|| u64::from(self.clock.cycles_in(self.rules.initial_s)))
    }

    /// The time until the break ends, s; `None` in play.
    fn seconds_left_of_break(&self) -> Option<i16> {
        let left = self.cycles_of_break()?.saturating_sub(self.game.state_cycles);
        Some(whole_seconds(left, self.clock).min(i16::MAX as u64) as i16)
    }

    fn overtime_cycles(&self) -> u64 {
        self.ended.map_or(self.game.overtime_cycles, |ended| ended.overtime_cycles)
    }

    /// The cycles left on the primary and the secondary clock, as a GameController runs them. In `set` the secondary
    /// clock stands, because the time of the whistle is not announced. A shot of a shoot-out is on the primary clock.
    fn cycles_left(&self) -> [u64; 2] {
        let PacketSource { game, rules, clock, .. } = *self;
        let of_half = game.cycles_left.unwrap_or(0);
        match (game.state, game.shoot_out) {
            (GameState::Set | GameState::Playing | GameState::Finished, Some(shoot_out)) => {
                let shot = u64::from(clock.cycles_in(shoot_out.shot_s(rules)));
                [shot.saturating_sub(shoot_out.shot.cycles), 0]
            }
            (_, Some(_)) => [0, 0],
            (GameState::Set, None) => [of_half, 0],
            (_, None) => [of_half, game.secondary_cycles_left(rules, clock).unwrap_or(0)],
        }
    }

    /// The team that takes the set play, as far as announced. `None` in play after the end of a kick-off or free kick.
    fn kicking_team(&self, for_monitors: bool) -> Option<Team> {
        let is_told = |set_play: SetPlay| match for_monitors {
            true => Some(set_play.team),
            false => SetPlayStatus::of(&set_play, self.rules, self.clock).team,
        };
        match (self.game.shoot_out, self.game.set_play) {
            (Some(shoot_out), _) => Some(shooting_team(&shoot_out)),
            (None, Some(set_play)) => is_told(set_play),
            (None, None) => match self.game.state {
                GameState::Playing | GameState::Finished => None,
                _ => self.game.kick_off(),
            },
        }
    }

    fn team(&self, team: Team, version: ProtocolVersion) -> TeamPacket {
        let mut players =
            [PlayerPacket { penalty: version.substitute_code(), ..PlayerPacket::default() }; MOST_PLAYERS];
        for (id, penalty) in self.robots.iter().filter(|(id, _)| id.team == team) {
            if let Some(player) = players.get_mut(usize::from(id.number).wrapping_sub(1)) {
                *player = self.player(*id, *penalty, version);
            }
        }
        let messages_left = self.game.messages_left.map_or(u32::MAX, |left| left[team]);
        let shoot_out = self.game.shoot_out;
        let shoots = shoot_out.is_some_and(|shoot_out| shooting_team(&shoot_out) == team);
        let (taken, goals) = shoot_out.map_or((0, 0), |shoot_out| (shoot_out.taken[team], shoot_out.goals[team]));
        let byte = |number: u32| u8::try_from(number).unwrap_or(u8::MAX);
        TeamPacket {
            number: self.team_numbers[team],
            colour: self.colours[team].players,
            goalkeeper_colour: self.colours[team].goalkeeper,
            goalkeeper: if shoots { 0 } else { self.game.goalkeepers[team].unwrap_or(RobotId::GOALKEEPER) },
            // Goals of a shoot-out are added to the others.
            score: byte(self.game.score[team].saturating_add(goals)),
            shots: byte(taken + u32::from(shoots && self.game.state != GameState::Finished)),
            shots_scored: self.shots_scored[team],
            message_budget: u16::try_from(messages_left).unwrap_or(u16::MAX),
            players,
        }
    }

    fn player(&self, id: RobotId, penalty: Penalty, version: ProtocolVersion) -> PlayerPacket {
        let cautions = self.records.iter().find(|record| record.id == id).map_or(0, |record| record.cautions);
        let cautioned = PlayerPacket { cautions: u8::try_from(cautions).unwrap_or(u8::MAX), ..PlayerPacket::default() };
        let Some(active) = penalty.0 else { return cautioned };
        if active.reason == PenaltyReason::SentOff {
            // It does not come back, and its cautions are forgotten.
            return PlayerPacket { penalty: version.penalty_code(active.reason), ..PlayerPacket::default() };
        }
        if active.reason == PenaltyReason::ShootOut {
            return PlayerPacket { penalty: version.penalty_code(active.reason), ..cautioned };
        }
        PlayerPacket {
            penalty: version.penalty_code(active.reason),
            seconds_left: whole_seconds(active.cycles_left, self.clock).min(u64::from(u8::MAX)) as u8,
            ..cautioned
        }
    }
}

fn is_first_shot(shoot_out: &ShootOut) -> bool {
    shoot_out.taken.blue + shoot_out.taken.pink == 0
}

/// The team that shoots, and after the last shot the one that took it.
fn shooting_team(shoot_out: &ShootOut) -> Team {
    if shoot_out.winner.is_some() { shoot_out.team.opponent() } else { shoot_out.team }
}

/// The number of seconds, rounded up as in the countdown of a GameController.
fn whole_seconds(cycles: u64, clock: &CycleClock) -> u64 {
    // Rounding errors must not add a second.
    (cycles as f64 * clock.period_s - 1e-6).ceil() as u64
}

/// Updates the scored shots: `before` and `after` are the shoot-out before and after a cycle.
pub fn note_shots(scored: &mut PerTeam<u16>, before: Option<&ShootOut>, after: Option<&ShootOut>) {
    let (Some(before), Some(after)) = (before, after) else { return };
    for team in Team::BOTH {
        let shot = after.taken[team].saturating_sub(1);
        if after.taken[team] > before.taken[team] && after.goals[team] > before.goals[team] && shot < u16::BITS {
            scored[team] |= 1 << shot;
        }
    }
}

#[cfg(test)]
mod tests;

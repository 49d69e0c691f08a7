//! The robots' information about the game.
//!
//! Robots are informed of most changes at once, and hear the [whistles](super::hearing). The start of play after `set` and goals are delayed by
//! [`Rules::status_delay_s`](crate::game::Rules::status_delay_s) and [`Rules::goal_delay_s`](crate::game::Rules::goal_delay_s), as by the
//! real GameController (2025 rule book, sections 3.2 and 3.3: 15 s); robots can react earlier to [`GameStatus::whistles`]. A half's first
//! `ready` is delayed by [`Rules::ready_delay_s`](crate::game::Rules::ready_delay_s) (45 s), with [`GameStatus::ready_signals`]. Until the
//! delay is over, the status is that of a game without the change, with running clocks. Any other change of the game ends the delay.
//!
//! The team of a free kick may be [delayed](crate::game::Rules::free_kick_signal_s) (2025 rule book, section 3.9.1: the referee points for
//! at least 5 s). As a simplification, every robot has seen the signal after that delay.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::snapshot::MatchSnapshot;
use crate::cycle::CycleClock;
use crate::events::MatchEvent;
use crate::game::{Game, GameState, PenaltyReason, Rules, Score, SetPlay, SetPlayKind};
use crate::knowledge::Knowledge;
use crate::pitch::End;
use crate::team::{JerseyNumbers, PerTeam, Team};

/// A robot's information about the game at the start of a cycle, as from a GameController (2010 rule book, section 3.2). It is a sensor:
/// every robot has its own, and behaviours read nothing else of the game. All information except penalties, placements and whistles may be
/// [delayed](crate::game::Rules::status_delay_s).
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Sensor)]
#[serde(default)]
pub struct GameStatus {
    /// The state of the game.
    pub state: GameState,
    /// Goals of both teams so far.
    pub score: Score,
    /// The half under way, from 1.
    pub half: u32,
    /// Seconds left in this half; `None` if the rules have no clock.
    pub time_left_s: Option<f32>,
    /// The secondary time, s: the remaining time of `ready`, of a free kick, of a time-out, or of a shot in a shoot-out. `None` in `set`,
    /// as the GameController does not send the time of the whistle.
    pub secondary_time_left_s: Option<f32>,
    /// Seconds since the start of the match.
    pub time_s: f32,
    /// The end of the pitch that this robot's team defends.
    pub own_end: End,
    /// The team that has, or had last, the kick-off.
    pub kick_off_team: Team,
    /// Whether play was last restarted by a drop ball instead: neither team has the kick-off.
    pub drop_ball: bool,
    /// The free kick under way, or the kick-off while the ball belongs to one team.
    pub set_play: Option<SetPlayStatus>,
    /// The number of its team's goalkeeper, if a substitute has replaced number 1.
    #[reflect(default)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goalkeeper: Option<u8>,
    /// How many time-outs this robot's team may still take.
    pub timeouts_left: u32,
    /// Number of messages that this robot's team may still send, by the rules and the settings of the scenario; `None` if unlimited.
    pub messages_left: Option<u32>,
    /// The team that shoots, if there is a penalty shoot-out.
    pub shoot_out: Option<Team>,
    /// Whether the match is stopped briefly, so that no robot may move. Sent without delay.
    pub stopped: bool,
    /// Whether this robot is penalised.
    pub penalised: bool,
    /// The offence, if the robot is penalised.
    pub penalty: Option<PenaltyReason>,
    /// The jersey numbers of the penalised robots of both teams, this robot's own included.
    #[reflect(default)]
    #[serde(skip_serializing_if = "are_empty")]
    pub penalised_numbers: PerTeam<JerseyNumbers>,
    /// Number of times that this robot was placed for a restart. When the number changes, the robot has been placed at its kick-off
    /// position in its team's formation or, if the rules say `walk_in`, beside the pitch.
    pub restarts: u32,
    /// Number of times that this robot was placed by hand. When the number changes, the robot stood at an illegal position and has been
    /// placed at its position for a kick-off of the other team; or, in a shoot-out, behind the ball as shooter or on the goal line as
    /// goalkeeper.
    pub hand_placements: u32,
    /// The number of whistles that the robot has heard. A whistle is heard at once, even if the change of the game is delayed.
    pub whistles: u32,
    /// Number of times that the referee has raised its arms for the first `ready` of a half. Robots see it at once.
    pub ready_signals: u32,
}

fn are_empty(numbers: &PerTeam<JerseyNumbers>) -> bool {
    *numbers == PerTeam::default()
}

/// The robots' information about a set play.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
pub struct SetPlayStatus {
    /// Its kind.
    pub kind: SetPlayKind,
    /// The team that the ball belongs to; `None` if not known yet.
    pub team: Option<Team>,
}

impl SetPlayStatus {
    /// The information about `set_play`. The team of a kick-off is always known.
    pub fn of(set_play: &SetPlay, rules: &Rules, clock: &CycleClock) -> Self {
        let is_known = set_play.kind == SetPlayKind::KickOff
            || set_play.cycles >= u64::from(clock.cycles_in(rules.free_kick_signal_s));
        Self { kind: set_play.kind, team: is_known.then_some(set_play.team) }
    }
}

/// The delayed information of the robots.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct Announcement {
    /// The game without the delayed change; `None` if nothing is delayed.
    pub instead: Option<Game>,
    /// Cycles until the end of the delay.
    pub cycles_left: u64,
}

impl Announcement {
    /// The game that the robots are informed of, given the true game.
    pub fn announced<'a>(&'a self, truth: &'a Game) -> &'a Game {
        self.instead.as_ref().unwrap_or(truth)
    }

    /// Updates the information after a cycle. `after` is the game after the cycle, `events` are those of the cycle.
    pub fn advance(&mut self, seen: &MatchSnapshot, after: &Game, events: &[MatchEvent]) {
        let before = seen.game;
        let goal = events.iter().any(|event| matches!(event, MatchEvent::Goal { .. }));
        let ends = after.state == GameState::Finished || after.half != before.half;
        let delay_s = match (before.state, after.state) {
            _ if goal => seen.rules.goal_delay_s,
            (GameState::Set, GameState::Playing) => seen.rules.status_delay_s,
            (GameState::Standby, GameState::Ready) => seen.rules.ready_delay_s,
            _ => 0.0,
        };
        let delay_cycles = seen.cycles(delay_s);
        if ends {
            // A goal is delayed even if its half is over, unless it is the last half.
            let score = self.announced(before).score;
            let cycles_left = if goal { delay_cycles } else { self.cycles_left };
            *self = Self::default();
            if score != after.score && cycles_left > 0 && after.state != GameState::Finished {
                *self = Self { instead: Some(Game { score, ..after.clone() }), cycles_left };
            }
        } else if delay_cycles > 0 {
            *self = Self { instead: Some(before.clone()), cycles_left: delay_cycles };
        } else if self.cycles_left == 0
            || is_announced_at_once(before, after)
            || self.instead.as_ref().is_some_and(|game| events.iter().any(|event| contradicts(game, seen, event)))
        {
            *self = Self::default();
        }
        if let Some(game) = &mut self.instead {
            game.stop = after.stop;
            self.cycles_left -= 1;
            advance_clocks(game, seen.rules, &seen.clock);
        }
    }
}

/// Returns whether robots must be told at once of the change from `before` to `after`. Clocks and the end of a set play can wait.
fn is_announced_at_once(before: &Game, after: &Game) -> bool {
    let begun = |game: &Game| game.set_play.map(|set_play| (set_play.kind, set_play.team));
    let begins_set_play = after.set_play.is_some() && begun(before) != begun(after);
    let rest =
        |game: &Game| (game.state, game.half, game.score, game.kick_off(), game.shoot_out.map(|shot| shot.taken));
    begins_set_play || rest(before) != rest(after)
}

/// Whether `event` is a penalty, or the end of one, that is impossible in the announced game.
fn contradicts(announced: &Game, seen: &MatchSnapshot, event: &MatchEvent) -> bool {
    match (announced.state, event) {
        (GameState::Standby, MatchEvent::Penalty { reason, .. }) => *reason != PenaltyReason::MotionInStandby,
        (GameState::Set, MatchEvent::Penalty { reason, .. }) => {
            matches!(reason, PenaltyReason::BallHolding | PenaltyReason::GameStuck)
        }
        // The time of a penalty does not run in `set`, except for motion in `set` itself.
        (GameState::Set, MatchEvent::PenaltyOver { robot, .. }) => seen
            .robots
            .iter()
            .filter(|other| other.id == *robot)
            .any(|robot| robot.penalty.0.is_some_and(|penalty| !penalty.reason.is_in_place())),
        _ => false,
    }
}

/// Advances the clocks of a game by one cycle.
fn advance_clocks(game: &mut Game, rules: &Rules, clock: &CycleClock) {
    if game.stop.is_some() {
        return;
    }
    if game.clock_runs(rules, clock) {
        game.cycles_left = game.cycles_left.map(|left| left.saturating_sub(1));
    }
    game.state_cycles += 1;
    let in_play = game.state == GameState::Playing;
    let set_play = game.set_play.map(|set_play| set_play.later(in_play));
    game.set_play = set_play.filter(|set_play| set_play.cycles_left > 0);
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::Intervention;
    use crate::team::RobotId;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

    /// A match in which robots are informed of goals and of the start of play five cycles late.
    fn delayed() -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        situation.rules.status_delay_s = 5.0 * situation.clock.period();
        situation.rules.goal_delay_s = situation.rules.status_delay_s;
        situation.rules.kick_off = crate::game::KickOffProcedure::ReadyAndSet;
        situation
    }

    /// The number of cycles from now on until robots are informed of this state.
    fn told_in(situation: &mut MatchFixture, state: GameState) -> Option<usize> {
        (1..20).find(|_| {
            situation.pass();
            situation.memory.announcement.announced(&situation.game).state == state
        })
    }

    #[test]
    fn that_play_begins_is_told_late_and_that_it_stops_at_once() {
        let mut situation = delayed();
        situation.game.state = GameState::Set;
        situation.interventions = vec![Intervention::Whistle];
        assert_eq!(told_in(&mut situation, GameState::Playing), Some(6));
        situation.interventions = vec![Intervention::KickOff { team: Team::Pink }];
        assert_eq!(told_in(&mut situation, GameState::Ready), Some(1));
        situation.interventions = vec![Intervention::Whistle];
        assert_eq!(told_in(&mut situation, GameState::Set), Some(1));
    }

    #[test]
    fn a_goal_is_told_late_with_what_follows_and_the_clock_that_they_see_runs_on() {
        let mut situation = delayed().touched_by(BLUE2).ball_rolled([2.9, 0.0], [3.2, 0.0]);
        situation.game.cycles_left = Some(1000);
        situation.pass();
        let told = situation.memory.announcement.announced(&situation.game);
        assert_eq!((told.state, told.score.blue, told.cycles_left), (GameState::Playing, 0, Some(999)));
        assert_eq!(told_in(&mut situation, GameState::Ready), Some(5));
        assert_eq!(situation.memory.announcement.announced(&situation.game).score.blue, 1);
    }

    #[test]
    fn a_goal_is_told_late_even_if_the_half_ends_meanwhile() {
        for cycles_left in [1, 3] {
            let mut situation = delayed().touched_by(BLUE2).ball_rolled([2.9, 0.0], [3.2, 0.0]);
            situation.rules.clock_runs_in_stoppages = true;
            situation.game.cycles_left = Some(cycles_left);
            let told = [(); 7].map(|()| {
                situation.pass();
                let told = situation.memory.announcement.announced(&situation.game);
                (told.half, told.score.blue)
            });
            let over = cycles_left as usize - 1;
            assert!(told[..over].iter().all(|told| *told == (1, 0)), "{told:?}");
            assert!(told[over..5].iter().all(|told| *told == (2, 0)), "{told:?}");
            assert_eq!(told[5..], [(2, 1); 2]);
        }
    }

    #[test]
    fn a_goal_may_be_told_at_once_where_the_start_of_play_is_not() {
        let mut situation = delayed().touched_by(BLUE2).ball_rolled([2.9, 0.0], [3.2, 0.0]);
        situation.rules.goal_delay_s = 0.0;
        situation.pass();
        assert_eq!(situation.memory.announcement.announced(&situation.game).score.blue, 1);
    }

    #[test]
    fn what_happens_in_the_meantime_is_told_with_the_rest() {
        let mut situation = delayed();
        situation.game.state = GameState::Set;
        situation.interventions = vec![Intervention::Whistle];
        situation.pass();
        situation.interventions = vec![Intervention::DropBall { position_m: Vec2::ZERO }];
        assert_eq!(told_in(&mut situation, GameState::Playing), Some(1));
    }

    #[test]
    fn a_penalty_that_cannot_be_in_set_tells_that_play_has_begun() {
        let told = |reason| {
            let mut situation = delayed();
            situation.game.state = GameState::Set;
            situation.interventions = vec![Intervention::Whistle];
            situation.pass();
            situation.interventions = vec![Intervention::Penalise { robot: BLUE2, reason, duration_s: Some(1.0) }];
            situation.pass();
            situation.memory.announcement.announced(&situation.game).state
        };
        assert_eq!(told(PenaltyReason::BallHolding), GameState::Playing);
        assert_eq!(told(PenaltyReason::Fallen), GameState::Set);
    }

    #[test]
    fn a_penalty_that_is_over_in_set_tells_that_play_has_begun() {
        let told = |reason| {
            let mut situation = delayed();
            situation.game.state = GameState::Set;
            let penalty = Intervention::Penalise { robot: BLUE2, reason, duration_s: Some(0.05) };
            situation.interventions = vec![penalty, Intervention::Whistle];
            situation.pass();
            let told = [(); 4].map(|()| {
                situation.pass();
                (
                    situation.robots.iter().any(|robot| robot.penalty.0.is_some()),
                    situation.memory.announcement.announced(&situation.game).state,
                )
            });
            assert!(told.contains(&(true, GameState::Set)) && !told[3].0, "{told:?}");
            told[3].1
        };
        assert_eq!(told(PenaltyReason::Pushing), GameState::Playing);
        assert_eq!(told(PenaltyReason::MotionInSet), GameState::Set);
    }

    #[test]
    fn whose_a_free_kick_is_comes_later_than_which_it_is() {
        let (rules, clock) = (Rules { free_kick_signal_s: 0.1, ..Rules::default() }, CycleClock::default());
        let told = |kind, cycles| {
            let set_play = SetPlay { cycles, ..SetPlay::new(kind, Team::Pink, Vec2::ZERO, 100) };
            SetPlayStatus::of(&set_play, &rules, &clock)
        };
        assert_eq!(told(SetPlayKind::KickIn, 2), SetPlayStatus { kind: SetPlayKind::KickIn, team: None });
        assert_eq!(told(SetPlayKind::KickIn, 3).team, Some(Team::Pink));
        assert_eq!(told(SetPlayKind::KickOff, 0).team, Some(Team::Pink));
    }
}

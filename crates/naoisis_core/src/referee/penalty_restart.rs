//! The procedure of a [penalty kick](super::penalty_kick).

use bevy::prelude::*;

use super::areas::penalty_mark;
use super::decide::{Referee, Stoppage};
use super::indirect_goal::Plays;
use super::penalty_kick::{end, keeper_left_too_early, keeper_off_its_line};
use super::placing::Occupied;
use crate::events::MatchEvent;
use crate::game::{GameState, SetPlay, SetPlayKind};
use crate::geometry::Pose;
use crate::team::Team;

impl Referee<'_, '_> {
    /// Stops play for a penalty kick of `team`: robots walk to their positions.
    pub(super) fn begin_penalty_kick(&mut self, team: Team) {
        let mark = penalty_mark(self.seen.pitch, end(self.seen, team));
        let place = self.put_ball(mark);
        self.memory.kick_off = None;
        self.memory.cycles_lined_up = 0;
        let cycles = self.seen.cycles(self.seen.rules.penalty_kick_s);
        self.decisions.game.set_play = Some(SetPlay::new(SetPlayKind::PenaltyKick, team, place, cycles));
        for record in &mut self.memory.robots {
            record.forgive();
        }
        let set_play = SetPlayKind::PenaltyKick;
        self.decisions.events.push(MatchEvent::FreeKick { set_play, team, position_m: place });
        self.enter(GameState::Ready);
    }

    /// Puts a goalkeeper that stands ahead of its line in its penalty area back onto the line, without turning it.
    pub(super) fn put_keeper_on_its_line(&mut self, team: Team) {
        let snapshot = self.now();
        let Some(index) = keeper_off_its_line(&snapshot, team) else { return };
        let robot = &snapshot.robots[index];
        let line = end(&snapshot, team).sign() * snapshot.pitch.half_length();
        let wanted = Pose { position: Vec2::new(line, robot.pose.position.y), ..robot.pose };
        let pose = Occupied::by_others(&snapshot, Some(index)).free_pose(wanted, &robot.bounds);
        let rule = "At a penalty kick the keeper is in contact with its goal line, or outside its penalty area.";
        let evidence = snapshot.evidence_against(rule, robot).otherwise("It had to be there before `set` began.");
        let robot = robot.id;
        self.decisions.robots[index].pose = pose;
        self.memory.robots[index].hand_placements = self.memory.robots[index].hand_placements.saturating_add(1);
        self.decisions.events.push(MatchEvent::PlacedByHand { robot, position_m: pose.position, evidence });
    }

    /// Ends a penalty kick with a goal if the goalkeeper has left its line too early, and the rules say so.
    pub(super) fn judge_keepers_line(&mut self) -> Option<Stoppage> {
        // A penalty kick given in this cycle begins with `ready`: the goalkeeper has until `set` to go to its line.
        if self.decisions.game.state != GameState::Playing {
            return None;
        }
        let penalty_kick = self.decisions.game.penalty_kick().filter(|_| self.seen.rules.penalty_kick_keeper_goal)?;
        let evidence = keeper_left_too_early(&penalty_kick, self.seen)?;
        self.decisions.game.set_play = None;
        let team = penalty_kick.team;
        self.decisions.events.push(MatchEvent::Goal { team, scorer: None, own_goal: false, evidence });
        Some(self.count_goal(team))
    }

    /// Begins the kick after the whistle: the ball belongs to the attackers, and a direct goal by them counts.
    pub(super) fn begin_penalty_shot(&mut self, set_play: SetPlay) {
        self.whistle();
        self.memory.plays = Plays::direct_for(set_play.team);
        self.memory.stuck = default();
        self.decisions.game.set_play = Some(SetPlay { touched: false, ..set_play });
    }
}

//! Counts the events of a match. Batches, expectations, summaries and the viewer read the same [`MatchCounts`]; the detection of mistakes
//! uses the same [kicks].
//!
//! The definitions are those of football, as far as they exist: [Opta's event
//! definitions](https://www.statsperform.com/opta-event-definitions/)
//! and [FIFA's football language](https://www.fifatrainingcentre.com/en/game/performance-analysis/football-language-analysis/the-fifa-football-language.php).
//! Both judge a player's intention. A simulator does not know it, and judges by where the ball goes instead.
//!
//! | counted | definition | source |
//! |---|---|---|
//! | goal | counts for the team, own goals of the opponents included; a robot's goals are those that it touched last, or kicked before an opponent deflected the ball | Opta "Goal/Own Goal" |
//! | goals in a half | the goals that were added to the score in it | |
//! | own goal | a goal that counts for the other team | Opta "Goal/Own Goal" |
//! | kick | a kick that struck the ball, in any state of the game | |
//! | pass | a kick that another robot touched next, or that left the pitch, and that was no shot. A ball that the kicker touches again after 0.5 s is a dribble, and one that is stopped by the referee no pass | Opta "Pass": the attempted delivery of the ball from one player to another |
//! | pass completed | a team-mate touched the ball next, wherever the kick was aimed | Opta "Successful Pass" |
//! | shot | a kick that no team-mate touched next and that scored, or would have rolled over the opponents' goal line at most 0.5 m outside a post | Opta "Shot": any goal attempt |
//! | shot on target | a shot that scored, deflected or not, or would have between the posts | Opta "Shot on Target": goals, and shots that a save or the last defender kept out |
//! | save | a shot on target that the goalkeeper touched next, and that did not score | Opta "Save" |
//! | possession | time in play in which the team touched the ball last since the ball was put down or thrown in; until then it is nobody's, and out of play it is not counted | FIFA EFI "Possession control", which leaves out the time out of play; there, a third share is "in contest" |
//! | duel | in play, upright robots of both teams are within 0.5 m of the ball, until one team has none within 0.75 m. The team that touched the ball last during it has won; a duel without a touch, or that a dead ball ends, is not counted | Opta "Duel": a 50-50 contest between two players of opposing sides, one of whom wins |
//! | ball in a half | time in play with the ball on that side of the halfway line | |
//! | out | the ball left the pitch; of the team that touched it last | |
//! | set play | a free kick or penalty kick that the team was given; kick-offs are not counted | |
//! | fall, penalty, program lost | each such event, in any state of the game | |
//! | share of `playing` | of the time in `ready`, `set` and `playing`, the share of `playing` | statistics of the league's GameController |
//! | active robots | of the robots' time in `ready`, `set` and `playing`, the share without a penalty | the same |
//! | distance | the way that the robot went in play, m, by its true speed; robots that are carried do not walk | FIFA "Total distance", in play |
//! | ball seen | share of the time in which the robot recognised the ball | |
//! | pose error | distance of the place where the robot believes itself to be from its true place when it sensed (the end of the cycle before), m; its mean, its median, and the share of the time in which it is over 0.5 m and over 1 m | |
//! | ball error | the same of the ball, while the robot believes to know where it is: the mean | |
//!
//! "In play" is the state `playing` of the game. What takes time (distance, ball seen, errors) counts in play and without a
//! penalty.

mod episode;
pub mod kicks;
mod observed;
mod robot_counts;

use bevy::prelude::*;
use std::collections::BTreeMap;

pub use episode::begin_episode;
pub use kicks::KickOutcome;
use kicks::{KickEnd, KickFollower, StruckKick};
pub use observed::{MatchCounter, Observed, ObservedRobot};
use robot_counts::SensedPlaces;
pub use robot_counts::{ErrorCounts, RobotCounts};

use naoisis_core::events::{CollisionPartner, KickResult, MatchEvent};
use naoisis_core::game::{GameState, Intervention, Score, SetPlayKind};
use naoisis_core::pitch::End;
use naoisis_core::statistics::median;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// Distance to the ball within which robots of both teams begin a duel, m.
const DUEL_BEGINS_M: f32 = 0.5;
/// Distance to the ball beyond which a team's nearest robot ends a duel, m.
const DUEL_ENDS_M: f32 = 0.75;

/// Everything that is counted in a match.
#[derive(Clone, Debug, Default)]
pub struct MatchCounts {
    /// Goals that count for the team.
    pub goals: PerTeam<u32>,
    /// Goals of the team that count for the other team.
    pub own_goals: PerTeam<u32>,
    /// Goals in a shoot-out.
    pub shoot_out_goals: PerTeam<u32>,
    /// The winner, after the final whistle.
    pub winner: Option<Team>,
    /// The score at the end of each half, or now for the half under way.
    pub score_after_half: BTreeMap<u32, Score>,
    /// Set plays awarded to the team, by kind.
    pub set_plays: PerTeam<BTreeMap<SetPlayKind, u32>>,
    /// Balls that left the pitch.
    pub outs: u32,
    /// Balls that left the pitch after the team's touch.
    pub outs_of: PerTeam<u32>,
    /// Duels that the team won.
    pub duels_won: PerTeam<u32>,
    /// The counted time, s.
    pub duration_s: f64,
    /// The robots' counts.
    pub robots: BTreeMap<RobotId, RobotCounts>,
    /// All passes and shots, in the order in which they ended.
    pub passes_and_shots: Vec<PlayedKick>,
    period_s: f64,
    play_cycles: u64,
    /// Cycles in `ready`, `set` and `playing`.
    game_cycles: u64,
    /// Cycles of all robots of a team in these states; below, those without a penalty.
    robot_cycles: PerTeam<u64>,
    active_cycles: PerTeam<u64>,
    possession_cycles: PerTeam<u64>,
    ball_in_half_cycles: PerTeam<u64>,
    /// Pose errors of each team's robots in play, m.
    pose_errors_m: PerTeam<Vec<f64>>,
    kicks: KickFollower,
    /// The last robot that touched the ball since it was put down.
    last_touch: Option<RobotId>,
    /// The scorer of a goal in this cycle whose kick an opponent touched last.
    deflected: Option<RobotId>,
    duel: Option<Duel>,
    /// The corner of the pitch at +x and +y, m.
    corner_m: Vec2,
    /// The last position of the ball, and those of the robots without a penalty, m, pitch frame.
    ball_m: Option<Vec2>,
    positions_m: Vec<(RobotId, Vec2)>,
    goalkeepers: PerTeam<Option<u8>>,
    /// Time and score at which counting began.
    began: Option<(f64, Score)>,
    last_cycle: u64,
}

/// A pass or a shot. Blue defends -x: halves that are played the other way are turned around.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PlayedKick {
    /// The robot that kicked.
    pub robot: RobotId,
    /// The time of the kick, s since the start of the match.
    pub time_s: f64,
    /// The position of the ball before the kick, m.
    pub from_m: Vec2,
    /// The last position of the ball before it was touched, left the pitch or play was stopped, m.
    pub to_m: Vec2,
    /// What came of it.
    pub outcome: KickOutcome,
}

/// A duel under way.
#[derive(Clone, Copy, Debug, Default)]
struct Duel {
    /// The team that touched the ball last during the duel.
    touched_by: Option<Team>,
}

impl MatchCounts {
    /// Creates a counter for matches of `scenario`. Counting begins with the first cycle that it [reads](Self::look).
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            period_s: scenario.cycle_s,
            kicks: KickFollower::new(scenario),
            corner_m: Vec2::new(scenario.field.half_length(), scenario.field.half_width()),
            ..default()
        }
    }

    /// Counts the cycle of `record`. Returns the time in play that it covers, s.
    pub fn look_at_record(&mut self, record: &CycleRecord) -> f64 {
        self.look(&record.into(), record.robots.iter().map(ObservedRobot::from))
    }

    /// Counts `cycle`, with the `robots` after it. Returns the time in play that it covers, s. If earlier cycles were left out, this is
    /// more than one cycle.
    pub fn look<'a>(&mut self, cycle: &Observed, robots: impl Iterator<Item = ObservedRobot<'a>>) -> f64 {
        let cycles = cycle.cycle.saturating_sub(self.last_cycle);
        self.last_cycle = cycle.cycle;
        let robots: Vec<ObservedRobot> = robots.collect();
        // A robot with a penalty senses nothing: the belief with which it returns is that of before its penalty.
        let sensing = robots.iter().filter(|robot| !robot.is_penalised);
        let positions_m = sensing.map(|robot| (robot.id, robot.pose.position)).collect();
        let ball_before_m = self.ball_m;
        let positions_before_m = core::mem::replace(&mut self.positions_m, positions_m);
        (self.ball_m, self.goalkeepers) = (cycle.ball_m, cycle.goalkeepers);
        let Some((began_s, score)) = self.began else {
            self.began = Some((cycle.time_s, cycle.score));
            self.robots.extend(robots.iter().map(|robot| (robot.id, RobotCounts::default())));
            return 0.0;
        };
        self.duration_s = cycle.time_s - began_s;
        self.goals = PerTeam::new(|team| cycle.score[team].saturating_sub(score[team]));
        self.score_after_half.insert(cycle.half, self.goals);
        for event in cycle.events {
            self.count(event);
        }
        let first_way = |place: Vec2| if cycle.blue_end == End::NegativeX { place } else { -place };
        for (kick, end) in self.kicks.look(cycle) {
            let outcome = self.count_kick(kick, end);
            if outcome != KickOutcome::Neither {
                let StruckKick { robot, time_s, position_m, .. } = kick;
                let (from_m, to_m) = (first_way(position_m), first_way(ball_before_m.unwrap_or(position_m)));
                self.passes_and_shots.push(PlayedKick { robot, time_s, from_m, to_m, outcome });
            }
        }
        if let Some(scorer) = self.deflected.take() {
            self.count_deflected(scorer, ball_before_m.map(first_way));
        }
        if cycle.state != GameState::Playing {
            self.dead_ball();
            if matches!(cycle.state, GameState::Ready | GameState::Set) {
                self.game_cycles += cycles;
                robots.iter().for_each(|robot| self.count_active(robot, cycles));
            }
            return 0.0;
        }
        self.game_cycles += cycles;
        self.play_cycles += cycles;
        if let Some(robot) = self.last_touch {
            self.possession_cycles[robot.team] += cycles;
        }
        if let Some(ball) = cycle.ball_m.filter(|ball| ball.x != 0.0) {
            let end = if ball.x < 0.0 { End::NegativeX } else { End::PositiveX };
            let team = if cycle.blue_end == end { Team::Blue } else { Team::Pink };
            self.ball_in_half_cycles[team] += cycles;
        }
        let mut nearest_m = PerTeam { blue: f32::INFINITY, pink: f32::INFINITY };
        for robot in &robots {
            self.count_active(robot, cycles);
            if robot.is_penalised {
                continue;
            }
            // Robots sense where everything was at the end of the cycle before.
            let before = positions_before_m.iter().find(|(id, _)| *id == robot.id).map(|(_, position_m)| *position_m);
            let sensed = SensedPlaces {
                robot_m: if cycles == 1 { before } else { Some(robot.pose.position) },
                ball_m: if cycles == 1 { ball_before_m } else { cycle.ball_m },
                own_end: cycle.own_end(robot.id.team),
            };
            self.pose_errors_m[robot.id.team].extend(sensed.pose_error_m(robot));
            self.robots.entry(robot.id).or_default().play(robot, &sensed, cycles, self.period_s);
            if let Some(ball) = cycle.ball_m.filter(|_| robot.is_upright) {
                let nearest_m = &mut nearest_m[robot.id.team];
                *nearest_m = nearest_m.min(robot.pose.position.distance(ball));
            }
        }
        self.count_duel(nearest_m.blue.max(nearest_m.pink));
        cycles as f64 * self.period_s
    }

    /// Returns the distances of the ball from the centre mark and from the left and the right corner at +x, m.
    pub fn ball_distances_m(&self) -> Option<[f32; 3]> {
        let Vec2 { x, y } = self.corner_m;
        let ball = self.ball_m?;
        Some([Vec2::ZERO, Vec2::new(x, y), Vec2::new(x, -y)].map(|target| target.distance(ball)))
    }

    fn count_active(&mut self, robot: &ObservedRobot, cycles: u64) {
        self.robot_cycles[robot.id.team] += cycles;
        self.active_cycles[robot.id.team] += if robot.is_penalised { 0 } else { cycles };
    }

    fn robot(&mut self, id: RobotId) -> &mut RobotCounts {
        self.robots.entry(id).or_default()
    }

    fn count(&mut self, event: &MatchEvent) {
        match event {
            MatchEvent::Kick { robot, result: KickResult::Kicked | KickResult::Reduced, .. } => {
                self.robot(*robot).kicks += 1;
                self.touched(*robot);
            }
            MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Ball, .. } => self.touched(*robot),
            MatchEvent::Goal { team, scorer, own_goal, .. } => {
                self.own_goals[team.opponent()] += u32::from(*own_goal);
                if let Some(scorer) = scorer.filter(|_| !own_goal) {
                    self.robot(scorer).goals += 1;
                    self.deflected = self.last_touch.filter(|by| by.team != *team).map(|_| scorer);
                }
                self.dead_ball();
            }
            MatchEvent::BallOut { last_touch, .. } => {
                self.outs += 1;
                if let Some(team) = last_touch {
                    self.outs_of[*team] += 1;
                }
                self.dead_ball();
            }
            MatchEvent::FreeKick { set_play, team, .. } => {
                *self.set_plays[*team].entry(*set_play).or_default() += 1;
                self.dead_ball();
            }
            MatchEvent::Shot { goals, .. } => {
                self.shoot_out_goals = *goals;
                self.dead_ball();
            }
            MatchEvent::ShootOutWon { team } => self.winner = Some(*team),
            MatchEvent::FinalWhistle => {
                self.winner = self.winner.or(self.goals.leader());
            }
            MatchEvent::KickOff { .. }
            | MatchEvent::DropBall { .. }
            | MatchEvent::ThrowIn { .. }
            | MatchEvent::Intervention { intervention: Intervention::PlaceBall { .. } } => self.dead_ball(),
            MatchEvent::Fall { robot, .. } => self.robot(*robot).falls += 1,
            MatchEvent::Penalty { robot, reason, .. } => {
                *self.robot(*robot).penalties.entry(*reason).or_default() += 1;
            }
            MatchEvent::AgentLost { robot, .. } => self.robot(*robot).programs_lost += 1,
            _ => {}
        }
    }

    fn touched(&mut self, robot: RobotId) {
        self.last_touch = Some(robot);
        if let Some(duel) = &mut self.duel {
            duel.touched_by = Some(robot.team);
        }
    }

    /// Notes that the ball is dead or was put down for a restart.
    fn dead_ball(&mut self) {
        self.last_touch = None;
        self.duel = None;
    }

    fn count_kick(&mut self, kick: StruckKick, end: KickEnd) -> KickOutcome {
        let outcome = kick.outcome(end, self.kicks.pitch());
        let robot = self.robot(kick.robot);
        match outcome {
            KickOutcome::PassCompleted => {
                (robot.passes, robot.passes_completed) = (robot.passes + 1, robot.passes_completed + 1);
            }
            KickOutcome::PassFailed { .. } => robot.passes += 1,
            KickOutcome::ShotOffTarget => robot.shots += 1,
            KickOutcome::ShotOnTarget { stopped_by } => {
                (robot.shots, robot.shots_on_target) = (robot.shots + 1, robot.shots_on_target + 1);
                if let Some(keeper) = stopped_by.filter(|robot| robot.is_goalkeeper_of(&self.goalkeepers)) {
                    self.robot(keeper).saves += 1;
                }
            }
            KickOutcome::Neither => {}
        }
        outcome
    }

    /// Counts the scorer's kick, which an opponent touched next, as a shot that scored. `to_m` is the last position of the ball.
    fn count_deflected(&mut self, scorer: RobotId, to_m: Option<Vec2>) {
        let is_meant = |kick: &&mut PlayedKick| kick.robot == scorer && kick.outcome != KickOutcome::PassCompleted;
        let Some(kick) = self.passes_and_shots.last_mut().filter(is_meant) else { return };
        let before = core::mem::replace(&mut kick.outcome, KickOutcome::ShotOnTarget { stopped_by: None });
        kick.to_m = to_m.unwrap_or(kick.to_m);
        if let KickOutcome::ShotOnTarget { stopped_by } = before {
            if let Some(keeper) = stopped_by.filter(|robot| robot.is_goalkeeper_of(&self.goalkeepers)) {
                let saves = &mut self.robot(keeper).saves;
                *saves = saves.saturating_sub(1);
            }
            return;
        }
        let robot = self.robot(scorer);
        robot.shots_on_target += 1;
        if let KickOutcome::PassFailed { .. } = before {
            (robot.passes, robot.shots) = (robot.passes - 1, robot.shots + 1);
        }
    }

    /// Begins or ends a duel. `further_m` is the distance of each team's nearest robot to the ball, the greater of the two.
    fn count_duel(&mut self, further_m: f32) {
        match self.duel {
            None if further_m <= DUEL_BEGINS_M => self.duel = Some(Duel::default()),
            Some(Duel { touched_by }) if further_m > DUEL_ENDS_M => {
                self.duel = None;
                if let Some(team) = touched_by {
                    self.duels_won[team] += 1;
                }
            }
            _ => {}
        }
    }

    /// Returns the sum of the counts of all robots of `team`.
    pub fn team(&self, team: Team) -> RobotCounts {
        let mut sum = RobotCounts::default();
        for (_, robot) in self.robots.iter().filter(|(id, _)| id.team == team) {
            sum.add(robot);
        }
        sum
    }

    /// Returns the time in play, s.
    pub fn play_s(&self) -> f64 {
        self.play_cycles as f64 * self.period_s
    }

    /// Returns the time in `ready`, `set` and `playing`, s.
    pub fn game_s(&self) -> f64 {
        self.game_cycles as f64 * self.period_s
    }

    /// Returns the time of all robots of `team` in `ready`, `set` and `playing`, and the part of it without a penalty, s.
    pub fn robot_and_active_s(&self, team: Team) -> [f64; 2] {
        [self.robot_cycles[team], self.active_cycles[team]].map(|cycles| cycles as f64 * self.period_s)
    }

    /// Returns the goals of each team in `half`, from 1.
    pub fn goals_in_half(&self, half: u32) -> Score {
        let earlier = self.score_after_half.range(..half).next_back().map(|(_, score)| *score).unwrap_or_default();
        let after = self.score_after_half.get(&half).copied().unwrap_or(earlier);
        PerTeam::new(|team| after[team].saturating_sub(earlier[team]))
    }

    /// Returns the possession of `team`, from 0 to 1. Returns `None` if no robot touched the ball.
    pub fn possession(&self, team: Team) -> Option<f64> {
        share_of_team(self.possession_cycles, team)
    }

    /// Returns the share of the time in play with the ball in the half of `team`, from 0 to 1. Returns `None` without a ball.
    pub fn ball_in_half(&self, team: Team) -> Option<f64> {
        share_of_team(self.ball_in_half_cycles, team)
    }

    /// Returns the median of the pose errors of `team`, m. Returns `None` without beliefs.
    pub fn median_pose_error_m(&self, team: Team) -> Option<f64> {
        median(self.pose_errors_m[team].clone())
    }
}

fn share_of_team(cycles: PerTeam<u64>, team: Team) -> Option<f64> {
    let all = cycles.blue + cycles.pink;
    (all > 0).then(|| cycles[team] as f64 / all as f64)
}

#[cfg(test)]
mod tests;

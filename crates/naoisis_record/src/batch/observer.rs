//! What is noted of a match of a batch.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::record::mistakes::Mistake;
use naoisis_core::ball::Ball;
use naoisis_core::communication::MessageStatistics;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::{CollisionPartner, CycleEvents, KickResult, MatchEvent};
use naoisis_core::game::{Game, GameState, Penalty};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::End;
use naoisis_core::referee::RefereeMemory;
use naoisis_core::statistics::median;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sensing::belief::{Belief, pitch_from_team};

/// Cycles between two looks at the beliefs; one look a cycle would tell hardly more.
const CYCLES_PER_BELIEF: u64 = 30;

/// How a match ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum MatchOutcome {
    /// With the final whistle.
    FinalWhistle,
    /// At the end of the scenario's duration.
    Duration,
    /// At its end, but something that must always hold did not.
    InvariantBroken,
    /// With a panic, of a behaviour for instance.
    Panicked,
    /// It could not be started.
    Refused,
}

impl MatchOutcome {
    /// Whether the match was played as it should be.
    pub fn is_valid(self) -> bool {
        matches!(self, MatchOutcome::FinalWhistle | MatchOutcome::Duration)
    }
}

/// What came of one match: a row of a batch's table.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct MatchRow {
    /// Its place in the batch, from 0.
    pub index: usize,
    /// Which variant of the scenario was played, from 0.
    pub variant: usize,
    /// The seed that it was played with.
    pub seed: u64,
    /// How it ended.
    pub outcome: MatchOutcome,
    /// How long it was, s of the match's time.
    pub duration_s: f64,
    /// Goals that count for the team.
    pub goals: PerTeam<u32>,
    /// Goals against itself, which count for the other team.
    pub own_goals: PerTeam<u32>,
    /// Balls that it struck.
    pub kicks: PerTeam<u32>,
    /// Balls that it kicked without scoring and of which the next touch was a team-mate's.
    pub kept: PerTeam<u32>,
    /// Balls that it kicked without scoring and that an opponent touched next, or that left the pitch.
    pub given_away: PerTeam<u32>,
    /// Penalties against it.
    pub penalties: PerTeam<u32>,
    /// Balls that left the pitch.
    pub outs: u32,
    /// Blue's share of the time of play in which it had touched the ball last. None if nobody touched it.
    pub blue_possession: Option<f64>,
    /// Share of the time of play in which the ball was in blue's half. None without a ball.
    pub ball_in_blue_half: Option<f64>,
    /// Messages lost on the way, out of those that should have reached somebody. None if there were none.
    pub messages_lost: Option<f64>,
    /// The median distance of the place where a robot of the team believes to be from where it is, m. None without
    /// beliefs.
    pub belief_error_m: PerTeam<Option<f64>>,
    /// What went wrong.
    pub note: String,
    /// What robots did wrong, where [that is looked for](super::mistakes::FindMistakes). It stands in a table of its own.
    pub mistakes: Vec<Mistake>,
}

impl MatchRow {
    /// Whether the matches of each variant were one and the same whatever their seeds, as where nothing is left to chance: they are
    /// one sample each, and no interval can be told. False unless a variant was played twice.
    pub(super) fn are_repetitions(rows: &[&Self]) -> bool {
        let mut first_of: BTreeMap<usize, &Self> = BTreeMap::new();
        for row in rows {
            let first = first_of.entry(row.variant).or_insert(row);
            if (Self { index: first.index, seed: first.seed, ..(*row).clone() }) != **first {
                return false;
            }
        }
        first_of.len() < rows.len()
    }

    /// The row of a match that did not come to its end.
    pub(super) fn failed(seed: u64, outcome: MatchOutcome, note: String) -> Self {
        Self {
            index: 0,
            variant: 0,
            seed,
            outcome,
            duration_s: 0.0,
            goals: PerTeam::default(),
            own_goals: PerTeam::default(),
            kicks: PerTeam::default(),
            kept: PerTeam::default(),
            given_away: PerTeam::default(),
            penalties: PerTeam::default(),
            outs: 0,
            blue_possession: None,
            ball_in_blue_half: None,
            messages_lost: None,
            belief_error_m: PerTeam::default(),
            note,
            mistakes: Vec::new(),
        }
    }
}

/// Watches a match, cycle by cycle.
#[derive(Clone, Debug, Default)]
pub struct MatchObserver {
    /// The score when it began, and when that was, s since the start of the match.
    before: (PerTeam<u32>, f64),
    own_goals: PerTeam<u32>,
    kicks: PerTeam<u32>,
    kept: PerTeam<u32>,
    given_away: PerTeam<u32>,
    /// Who kicked the ball that nobody else has touched since.
    kicker: Option<RobotId>,
    penalties: PerTeam<u32>,
    outs: u32,
    /// Cycles of play in which the team had touched the ball last.
    possession: PerTeam<u64>,
    /// Cycles of play with the ball in the team's half.
    ball_in_half: PerTeam<u64>,
    belief_errors: PerTeam<Vec<f64>>,
    first_broken_invariant: Option<String>,
    /// Robots whose programs were lost.
    agents_lost: PerTeam<u32>,
}

impl MatchObserver {
    /// Begins to watch a match where it is: what was before does not count.
    pub fn begin(world: &World) -> Self {
        let before = (world.resource::<Game>().score, world.resource::<CycleClock>().end_time_s());
        Self { before, ..Self::default() }
    }

    /// Notes what happened in the last cycle.
    pub fn observe(&mut self, world: &mut World) {
        for event in world.resource::<CycleEvents>().iter() {
            self.count(event);
        }
        let game = world.resource::<Game>();
        if game.state != GameState::Playing {
            self.kicker = None;
            return;
        }
        let own_ends = PerTeam::new(|team| game.own_end(team));
        if let Some(touch) = world.resource::<RefereeMemory>().last_touch {
            self.possession[touch.robot.team] += 1;
        }
        let ball =
            world.try_query_filtered::<&Pose, With<Ball>>().and_then(|mut balls| balls.iter(world).next().copied());
        if let Some(ball) = ball
            && ball.position.x != 0.0
        {
            let end = if ball.position.x < 0.0 { End::NegativeX } else { End::PositiveX };
            let team = if own_ends.blue == end { Team::Blue } else { Team::Pink };
            self.ball_in_half[team] += 1;
        }
        if world.resource::<CycleClock>().cycle.is_multiple_of(CYCLES_PER_BELIEF) {
            self.compare_beliefs(world, own_ends);
        }
    }

    fn count(&mut self, event: &MatchEvent) {
        match event {
            MatchEvent::Goal { team, own_goal, .. } => {
                self.own_goals[team.opponent()] += u32::from(*own_goal);
                self.kicker = None;
            }
            MatchEvent::Kick { robot, result: KickResult::Kicked | KickResult::Reduced, .. } => {
                self.kicks[robot.team] += 1;
                self.touched(*robot);
                self.kicker = Some(*robot);
            }
            MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Ball, .. } => self.touched(*robot),
            MatchEvent::Penalty { robot, .. } => self.penalties[robot.team] += 1,
            MatchEvent::BallOut { .. } => {
                self.outs += 1;
                if let Some(kicker) = self.kicker.take() {
                    self.given_away[kicker.team] += 1;
                }
            }
            MatchEvent::AgentLost { robot, .. } => self.agents_lost[robot.team] += 1,
            MatchEvent::InvariantBroken { message } if self.first_broken_invariant.is_none() => {
                self.first_broken_invariant = Some(message.clone());
            }
            _ => {}
        }
    }

    /// A robot touched the ball: whose it was after a kick is known now, unless it was the kicker again.
    fn touched(&mut self, robot: RobotId) {
        let Some(kicker) = self.kicker.take_if(|kicker| *kicker != robot) else { return };
        if robot.team == kicker.team {
            self.kept[kicker.team] += 1;
        } else {
            self.given_away[kicker.team] += 1;
        }
    }

    fn compare_beliefs(&mut self, world: &World, own_ends: PerTeam<End>) {
        let Some(mut robots) = world.try_query::<(&RobotId, &Pose, &Belief, Option<&Penalty>)>() else { return };
        for (id, pose, belief, penalty) in robots.iter(world) {
            if !penalty.is_some_and(Penalty::is_active) {
                let believed = pitch_from_team(belief.pose, own_ends[id.team]);
                let error = believed.position.distance(pose.position);
                self.belief_errors[id.team].push(f64::from(error));
            }
        }
    }

    /// The row of the match that was watched.
    pub(super) fn row(self, world: &World, seed: u64, outcome: MatchOutcome) -> MatchRow {
        let (score_before, began_s) = self.before;
        let score = world.resource::<Game>().score;
        let goals = PerTeam::new(|team| score[team].saturating_sub(score_before[team]));
        let messages = world.resource::<MessageStatistics>();
        let [delivered, lost] = [&messages.blue, &messages.pink].into_iter().fold([0, 0], |[delivered, lost], team| {
            [delivered + u64::from(team.delivered), lost + u64::from(team.lost)]
        });
        let share = |part: u64, other: u64| (part + other > 0).then(|| rounded(part as f64 / (part + other) as f64));
        let [blue_errors, pink_errors] =
            [self.belief_errors.blue, self.belief_errors.pink].map(|errors| median(errors).map(rounded));
        MatchRow {
            duration_s: world.resource::<CycleClock>().end_time_s() - began_s,
            goals,
            own_goals: self.own_goals,
            kicks: self.kicks,
            kept: self.kept,
            given_away: self.given_away,
            penalties: self.penalties,
            outs: self.outs,
            blue_possession: share(self.possession.blue, self.possession.pink),
            ball_in_blue_half: share(self.ball_in_half.blue, self.ball_in_half.pink),
            messages_lost: share(lost, delivered),
            belief_error_m: PerTeam { blue: blue_errors, pink: pink_errors },
            ..match self.first_broken_invariant {
                Some(message) => MatchRow::failed(seed, MatchOutcome::InvariantBroken, message),
                None => MatchRow::failed(seed, outcome, programs_lost(self.agents_lost)),
            }
        }
    }
}

fn programs_lost(lost: PerTeam<u32>) -> String {
    match lost {
        PerTeam { blue: 0, pink: 0 } => String::new(),
        PerTeam { blue, pink } => format!("programs lost: blue {blue}, pink {pink}"),
    }
}

/// With the digits of a batch's table, so that a batch that goes on with one comes to the same to the last digit.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::kick_geometry::KickType;

    fn kick(robot: RobotId) -> MatchEvent {
        MatchEvent::Kick {
            robot,
            kick_type: KickType::LeftStraight,
            speed: Some(1.0),
            result: KickResult::Kicked,
            reason: None,
            direction: Some(0.0),
            launch_speed_mps: Some(2.0),
        }
    }

    #[test]
    fn a_kicked_ball_is_kept_by_a_team_mate_and_given_away_to_an_opponent_or_over_a_line() {
        const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
        const BLUE3: RobotId = RobotId::new(Team::Blue, 3);
        const PINK1: RobotId = RobotId::new(Team::Pink, 1);
        let mut observer = MatchObserver::default();
        // A dribble, a pass, a ball for the opponents, and theirs back.
        for robot in [BLUE2, BLUE2, BLUE3, PINK1, BLUE2] {
            observer.count(&kick(robot));
        }
        assert_eq!((observer.kept, observer.given_away), (PerTeam { blue: 1, pink: 0 }, PerTeam { blue: 1, pink: 1 }));
        let scorer = Some(BLUE2);
        let goal = MatchEvent::Goal { team: Team::Blue, scorer, own_goal: false, evidence: default() };
        observer.count(&goal);
        observer.count(&kick(PINK1));
        assert_eq!((observer.kept.blue, observer.given_away.blue), (1, 1), "a goal is neither");
    }
}

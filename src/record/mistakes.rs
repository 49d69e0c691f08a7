//! Mistakes that are found by themselves: what a team would want to look at after a match, from the
//! [records of its cycles](CycleRecord), those of a running match and of a trace alike.
//!
//! | mistake | when |
//! |---|---|
//! | `ball_misplaced` | for half a second a robot believes the ball more than 0.5 m from where it is |
//! | `own_pose_lost` | for a second it believes itself more than 0.5 m, or 30°, from where it is |
//! | `ball_not_seen` | the robot of its team that is nearest to the ball, within 2 m, has not seen it for 3 s |
//! | `kick_missed` | a kick did not reach the ball |
//! | `kick_at_own_goal` | the ball left towards the own goal, fast enough to get there |
//! | `ball_given_away` | a kick that was not at the goal: an opponent touched the ball next, or it was out |
//! | `team_mates_collide` | two robots of a team ran into each other |
//! | `same_ball` | for a second two robots of a team, neither its keeper, walked to the ball within 0.75 m of it |
//!
//! Only play counts. A mistake that goes on is one, from when it began until it was over, with the worst of what was measured.

use bevy::prelude::*;
use core::fmt;
use serde::Serialize;

use super::cycle_record::{CycleRecord, RobotRecord};
use super::kick_outcomes::{KickEnd, KickFollower, StruckKick};
use crate::belief::{pitch_from_team, point_pitch_from_team};
use crate::events::{CollisionPartner, KickMiss, KickResult, MatchEvent};
use crate::game::GameState;
use crate::geometry::wrap_angle;
use crate::scenario::Scenario;
use crate::team::{RobotId, Team};

/// How far a believed ball or pose may be from the truth, m.
const MISPLACED_M: f32 = 0.5;
/// How far the heading may, radians.
const TURNED: f32 = core::f32::consts::FRAC_PI_6;
/// How near a robot must be to the ball that it should see, m.
const OWN_BALL_M: f32 = 2.0;
/// How near two robots go for the same ball, m, and how fast towards it, m/s.
const SAME_BALL_M: f32 = 0.75;
const TOWARDS_MPS: f32 = 0.05;
/// What happens again so soon is the same mistake still, s.
const SAME_S: f64 = 2.0;
/// A kick is at the goal that passes no further beside a post, m.
const BESIDE_GOAL_M: f32 = 0.5;
/// The jersey number of the keeper.
const KEEPER: u8 = 1;

/// What went wrong.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum MistakeKind {
    /// It believed the ball elsewhere.
    BallMisplaced,
    /// It believed itself elsewhere.
    OwnPoseLost,
    /// It did not see the ball next to it.
    BallNotSeen,
    /// Its kick did not reach the ball.
    KickMissed,
    /// It kicked towards its own goal.
    KickAtOwnGoal,
    /// It kicked the ball to an opponent, or out.
    BallGivenAway,
    /// It ran into a team-mate, or a team-mate into it.
    TeamMatesCollide,
    /// It and a team-mate went for the same ball.
    SameBall,
}

impl MistakeKind {
    /// All kinds.
    pub const ALL: [MistakeKind; 8] = [
        MistakeKind::BallMisplaced,
        MistakeKind::OwnPoseLost,
        MistakeKind::BallNotSeen,
        MistakeKind::KickMissed,
        MistakeKind::KickAtOwnGoal,
        MistakeKind::BallGivenAway,
        MistakeKind::TeamMatesCollide,
        MistakeKind::SameBall,
    ];

    /// Its name, for people.
    pub fn words(self) -> &'static str {
        match self {
            MistakeKind::BallMisplaced => "ball misplaced",
            MistakeKind::OwnPoseLost => "own pose lost",
            MistakeKind::BallNotSeen => "ball not seen",
            MistakeKind::KickMissed => "kick missed",
            MistakeKind::KickAtOwnGoal => "kick at own goal",
            MistakeKind::BallGivenAway => "ball given away",
            MistakeKind::TeamMatesCollide => "team-mates collide",
            MistakeKind::SameBall => "same ball",
        }
    }

    /// How long it must last to be one, s; none of what happens in an instant.
    fn least_s(self) -> Option<f64> {
        match self {
            MistakeKind::BallMisplaced => Some(0.5),
            MistakeKind::OwnPoseLost | MistakeKind::SameBall => Some(1.0),
            MistakeKind::BallNotSeen => Some(3.0),
            _ => None,
        }
    }
}

impl fmt::Display for MistakeKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.words())
    }
}

/// A mistake of a robot.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Mistake {
    /// What went wrong.
    pub kind: MistakeKind,
    /// Whose mistake it is.
    pub robot: RobotId,
    /// The other robot that was in it, if any: the team-mate, or the opponent that got the ball.
    pub other: Option<RobotId>,
    /// When it began, s since the start of the match.
    pub from_s: f64,
    /// When it was over, s.
    pub until_s: f64,
    /// Where the robot was when it began, m, pitch frame.
    pub position_m: Vec2,
    /// The greatest of what was measured, if anything was, in its [unit](Mistake::unit): how far away ball or place were, how
    /// fast the two met or the ball was.
    pub worst: Option<f32>,
}

impl Mistake {
    /// What [`Mistake::worst`] is in.
    pub fn unit(&self) -> &'static str {
        match self.kind {
            MistakeKind::BallMisplaced | MistakeKind::OwnPoseLost | MistakeKind::BallNotSeen => "m",
            MistakeKind::TeamMatesCollide | MistakeKind::KickAtOwnGoal => "m/s",
            _ => "",
        }
    }

    fn is_of(&self, kind: MistakeKind, robot: RobotId) -> bool {
        self.kind == kind && self.robot == robot
    }
}

/// Finds mistakes, cycle by cycle.
#[derive(Clone, Debug)]
pub struct MistakeFinder {
    kicks: KickFollower,
    /// What lasts, and may become a mistake.
    under_way: Vec<Mistake>,
    found: Vec<Mistake>,
}

impl MistakeFinder {
    /// A finder for the matches of a scenario.
    pub fn new(scenario: &Scenario) -> Self {
        Self { kicks: KickFollower::new(scenario), under_way: Vec::new(), found: Vec::new() }
    }

    /// Looks at the next cycle.
    pub fn look(&mut self, record: &CycleRecord) {
        for (kick, end) in self.kicks.look(record) {
            self.judge_kick(kick, end, record.time_s);
        }
        if record.game.state != GameState::Playing {
            self.end(|_| true);
            return;
        }
        for robot in record.robots.iter().filter(|robot| robot.penalised.is_none()) {
            self.look_at_beliefs(record, robot);
        }
        self.look_at_teams(record);
        for event in &record.events {
            self.look_at_event(record, event);
        }
        // What was not so in this cycle is over.
        self.end(|mistake| mistake.until_s < record.time_s);
    }

    /// All mistakes in the order in which they began, when the match is over, or until now.
    pub fn mistakes(&self) -> Vec<Mistake> {
        let mut whole = self.clone();
        if let Some((kick, end)) = whole.kicks.finish() {
            whole.judge_kick(kick, end, kick.time_s);
        }
        whole.end(|_| true);
        let mut all = whole.found;
        all.sort_by(|one, other| one.from_s.total_cmp(&other.from_s).then(one.robot.cmp(&other.robot)));
        all
    }

    /// What robots believe, against what is.
    fn look_at_beliefs(&mut self, record: &CycleRecord, robot: &RobotRecord) {
        let Some(belief) = &robot.belief else { return };
        let own_end = record.game.own_end(robot.id.team);
        let pose = pitch_from_team(belief.pose, own_end);
        let away_m = pose.position.distance(robot.pose.position);
        let turned = wrap_angle(pose.heading - robot.pose.heading).abs();
        if away_m > MISPLACED_M || turned > TURNED {
            self.goes_on(MistakeKind::OwnPoseLost, record, robot, None, Some(away_m));
        }
        let ball = record.ball.map(|ball| ball.position_m.truncate());
        if let (Some(ball), Some(believed)) = (ball, belief.ball) {
            let away_m = point_pitch_from_team(believed.position_m, own_end).distance(ball);
            if away_m > MISPLACED_M {
                self.goes_on(MistakeKind::BallMisplaced, record, robot, None, Some(away_m));
            }
        }
    }

    /// What the robots of each team do with respect to each other.
    fn look_at_teams(&mut self, record: &CycleRecord) {
        let Some(ball) = record.ball.map(|ball| ball.position_m.truncate()) else { return };
        for team in Team::BOTH {
            let is_there =
                |robot: &&RobotRecord| robot.id.team == team && robot.penalised.is_none() && robot.posture.is_upright();
            let distance = |robot: &RobotRecord| robot.pose.position.distance(ball);
            let robots = || record.robots.iter().filter(is_there);
            let nearest = robots().min_by(|one, other| distance(one).total_cmp(&distance(other)));
            if let Some(robot) = nearest.filter(|robot| distance(robot) < OWN_BALL_M && robot.percepts.ball.is_none()) {
                self.goes_on(MistakeKind::BallNotSeen, record, robot, None, Some(distance(robot)));
            }
            let goes = |robot: &&RobotRecord| {
                let towards = (ball - robot.pose.position).normalize_or_zero();
                robot.id.number != KEEPER
                    && distance(robot) < SAME_BALL_M
                    && robot.velocity.linear.dot(towards) > TOWARDS_MPS
            };
            let mut both = robots().filter(goes);
            if let (Some(one), Some(other)) = (both.next(), both.next()) {
                // It is the mistake of the one that is further away.
                let (near, far) = if distance(one) < distance(other) { (one, other) } else { (other, one) };
                self.goes_on(MistakeKind::SameBall, record, far, Some(near.id), None);
            }
        }
    }

    fn look_at_event(&mut self, record: &CycleRecord, event: &MatchEvent) {
        match event {
            MatchEvent::Kick { robot, result: KickResult::Missed, reason: Some(KickMiss::OutOfReach), .. } => {
                self.happened(MistakeKind::KickMissed, record, *robot, None, None);
            }
            MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Robot(other), speed_mps, .. }
                if robot.team == other.team =>
            {
                self.happened(MistakeKind::TeamMatesCollide, record, *robot, Some(*other), Some(*speed_mps));
            }
            _ => {}
        }
    }

    /// Whether a kick was a mistake, now that it is known what became of it.
    fn judge_kick(&mut self, kick: StruckKick, end: KickEnd, until_s: f64) {
        let mistake = |kind, other, worst| Mistake {
            kind,
            robot: kick.robot,
            other,
            from_s: kick.time_s,
            until_s,
            position_m: kick.position_m,
            worst,
        };
        let pitch = self.kicks.pitch();
        if kick.is_at_own_goal(pitch) {
            self.found.push(mistake(MistakeKind::KickAtOwnGoal, None, Some(kick.speed_mps)));
            return;
        }
        let is_given_away = match end {
            KickEnd::Touched(robot) => robot.team != kick.robot.team,
            KickEnd::Out => true,
            KickEnd::Goal(_) | KickEnd::Stopped => false,
        };
        if is_given_away && !kick.is_at_goal(pitch, BESIDE_GOAL_M) {
            let other = if let KickEnd::Touched(robot) = end { Some(robot) } else { None };
            self.found.push(mistake(MistakeKind::BallGivenAway, other, None));
        }
    }

    /// Something lasts: it is so in this cycle, too.
    fn goes_on(
        &mut self,
        kind: MistakeKind,
        record: &CycleRecord,
        robot: &RobotRecord,
        other: Option<RobotId>,
        measured: Option<f32>,
    ) {
        let known = self.under_way.iter_mut().find(|mistake| mistake.is_of(kind, robot.id));
        match known {
            Some(mistake) => {
                mistake.until_s = record.time_s;
                mistake.worst = greater(mistake.worst, measured);
            }
            None => self.under_way.push(Mistake {
                kind,
                robot: robot.id,
                other,
                from_s: record.time_s,
                until_s: record.time_s,
                position_m: robot.pose.position,
                worst: measured,
            }),
        }
    }

    /// Something happened in an instant; soon after the last time it is the same still.
    fn happened(
        &mut self,
        kind: MistakeKind,
        record: &CycleRecord,
        robot: RobotId,
        other: Option<RobotId>,
        measured: Option<f32>,
    ) {
        let is_same = |mistake: &&mut Mistake| mistake.is_of(kind, robot) && record.time_s - mistake.until_s < SAME_S;
        if let Some(mistake) = self.found.iter_mut().rev().find(is_same) {
            mistake.until_s = record.time_s;
            mistake.worst = greater(mistake.worst, measured);
            return;
        }
        let position_m = record.robot(robot).map_or(Vec2::ZERO, |robot| robot.pose.position);
        let (from_s, until_s) = (record.time_s, record.time_s);
        self.found.push(Mistake { kind, robot, other, from_s, until_s, position_m, worst: measured });
    }

    /// Ends what lasts no more: it becomes a mistake if it lasted long enough.
    fn end(&mut self, is_over: impl Fn(&Mistake) -> bool) {
        let found = &mut self.found;
        self.under_way.retain(|mistake| {
            let over = is_over(mistake);
            if over && has_lasted(mistake) {
                let is_same = |before: &&mut Mistake| {
                    before.is_of(mistake.kind, mistake.robot) && mistake.from_s - before.until_s < SAME_S
                };
                match found.iter_mut().rev().find(is_same) {
                    Some(before) => {
                        before.until_s = mistake.until_s;
                        before.worst = greater(before.worst, mistake.worst);
                    }
                    None => found.push(*mistake),
                }
            }
            !over
        });
    }
}

fn has_lasted(mistake: &Mistake) -> bool {
    mistake.kind.least_s().is_none_or(|least_s| mistake.until_s - mistake.from_s >= least_s)
}

fn greater(one: Option<f32>, other: Option<f32>) -> Option<f32> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.max(other)),
        (one, other) => one.or(other),
    }
}

#[cfg(test)]
mod tests {
    use super::super::cycle_record::{BallRecord, GameRecord};
    use super::*;
    use crate::belief::{BallBelief, Belief};
    use crate::camera_model::CameraName;
    use crate::events::CollisionType;
    use crate::geometry::Pose;
    use crate::kick_geometry::KickType;
    use crate::sensing::vision::BallPercept;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const BLUE3: RobotId = RobotId::new(Team::Blue, 3);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    /// Blue defends -x; the ball lies on the centre mark.
    fn cycle(number: u64) -> CycleRecord {
        let mut robots = vec![RobotRecord::new(BLUE2), RobotRecord::new(BLUE3), RobotRecord::new(PINK2)];
        for (robot, x) in robots.iter_mut().zip([-0.4, -2.0, 2.5]) {
            robot.pose = Pose::new(x, 0.0, 0.0);
            robot.percepts.ball = Some(BallPercept { camera: CameraName::TOP, pixel: Vec2::ZERO, position_m: Vec2::X });
        }
        CycleRecord {
            cycle: number,
            time_s: number as f64 / 30.0,
            ball: Some(BallRecord { position_m: Vec3::ZERO, velocity_mps: Vec3::ZERO }),
            robots,
            game: GameRecord { state: GameState::Playing, ..default() },
            events: Vec::new(),
        }
    }

    /// What is found in so many cycles.
    fn found(cycles: u64, change: impl Fn(&mut CycleRecord)) -> Vec<Mistake> {
        let mut finder = MistakeFinder::new(&Scenario::default());
        for number in 1..=cycles {
            let mut record = cycle(number);
            change(&mut record);
            finder.look(&record);
        }
        finder.mistakes()
    }

    fn kinds(mistakes: &[Mistake]) -> Vec<(MistakeKind, RobotId)> {
        mistakes.iter().map(|mistake| (mistake.kind, mistake.robot)).collect()
    }

    #[test]
    fn a_wrong_belief_is_a_mistake_if_it_lasts() {
        let believes = |ball_x: f32| {
            move |record: &mut CycleRecord| {
                let ball = BallBelief { position_m: Vec2::new(ball_x, 0.0), ..default() };
                let pose = record.robots[0].pose;
                record.robots[0].belief = Some(Belief { pose, ball: Some(ball), ..default() });
            }
        };
        assert_eq!(kinds(&found(15, believes(0.6))), []);
        let [mistake] = found(30, believes(0.6)).try_into().unwrap();
        assert_eq!((mistake.kind, mistake.robot), (MistakeKind::BallMisplaced, BLUE2));
        assert_eq!((mistake.worst, mistake.position_m), (Some(0.6), Vec2::new(-0.4, 0.0)));
        // From the first to the thirtieth cycle.
        assert!((mistake.until_s - mistake.from_s - 29.0 / 30.0).abs() < 1e-9);
        assert_eq!(kinds(&found(30, believes(0.4))), []);
        // What is wrong twice is two mistakes, if it was right for long enough.
        let twice = |right_cycles: u64| {
            found(60 + right_cycles, move |record| {
                if record.cycle <= 30 || record.cycle > 30 + right_cycles {
                    believes(0.6)(record);
                }
            })
        };
        assert_eq!((twice(30).len(), twice(90).len()), (1, 2));
    }

    #[test]
    fn a_robot_lost_its_pose_by_place_or_by_heading() {
        for (away_m, turned, expected) in [(0.6, 0.0, 1), (0.4, 0.0, 0), (0.0, 0.6, 1), (0.0, 0.4, 0)] {
            let mistakes = found(40, |record| {
                let pose = Pose::new(-0.4 + away_m, 0.0, turned);
                record.robots[0].belief = Some(Belief { pose, ..default() });
            });
            assert_eq!(mistakes.len(), expected, "{away_m} m, {turned} rad: {mistakes:?}");
        }
    }

    #[test]
    fn the_robot_at_the_ball_should_see_it() {
        let blind = |record: &mut CycleRecord| record.robots.iter_mut().for_each(|robot| robot.percepts.ball = None);
        // Pink is more than 2 m away.
        assert_eq!(kinds(&found(100, blind)), [(MistakeKind::BallNotSeen, BLUE2)]);
        assert_eq!(kinds(&found(85, blind)), []);
        let stopped = found(100, |record| {
            blind(record);
            record.game.state = GameState::Ready;
        });
        assert_eq!(stopped, []);
    }

    fn kick(robot: RobotId, direction: f32) -> MatchEvent {
        MatchEvent::Kick {
            robot,
            kick_type: KickType::LeftStraight,
            speed: Some(1.0),
            result: KickResult::Kicked,
            reason: None,
            direction: Some(direction),
            launch_speed_mps: Some(2.0),
        }
    }

    fn touch(robot: RobotId) -> MatchEvent {
        let (with, collision_type) = (CollisionPartner::Ball, CollisionType::StandingRobotAndBall);
        MatchEvent::Collision { robot: Some(robot), with, collision_type, speed_mps: 0.2, position_m: Vec2::ZERO }
    }

    #[test]
    fn kicks_are_mistakes_by_where_they_go_and_who_gets_them() {
        let kicked = |direction: f32, next: RobotId| {
            found(60, move |record| match record.cycle {
                10 => record.events.push(kick(BLUE2, direction)),
                50 => record.events.push(touch(next)),
                _ => {}
            })
        };
        let (to_side, to_own_goal) = (1.2, core::f32::consts::PI);
        assert_eq!(kinds(&kicked(to_side, BLUE3)), []);
        let [given] = kicked(to_side, PINK2).try_into().unwrap();
        assert_eq!((given.kind, given.other), (MistakeKind::BallGivenAway, Some(PINK2)));
        // A shot at the goal that is saved is none.
        assert_eq!(kinds(&kicked(0.1, PINK2)), []);
        assert_eq!(kinds(&kicked(to_own_goal, BLUE3)), [(MistakeKind::KickAtOwnGoal, BLUE2)]);
    }

    #[test]
    fn team_mates_are_in_each_others_way() {
        let collide = found(60, |record| {
            let (with, collision_type) = (CollisionPartner::Robot(BLUE3), CollisionType::MovingRobots);
            let (robot, position_m) = (Some(BLUE2), Vec2::ZERO);
            // Twice within two seconds is once.
            if record.cycle == 10 || record.cycle == 40 {
                record.events.push(MatchEvent::Collision { robot, with, collision_type, speed_mps: 0.3, position_m });
            }
        });
        assert_eq!(kinds(&collide), [(MistakeKind::TeamMatesCollide, BLUE2)]);
        let both_go = |second_x: f32| {
            move |record: &mut CycleRecord| {
                record.robots[1].pose.position.x = second_x;
                for robot in &mut record.robots {
                    robot.velocity.linear = Vec2::X * 0.2;
                }
            }
        };
        let [same] = found(40, both_go(-0.6)).try_into().unwrap();
        assert_eq!((same.kind, same.robot, same.other), (MistakeKind::SameBall, BLUE3, Some(BLUE2)));
        assert_eq!(kinds(&found(40, both_go(-0.9))), []);
    }
}

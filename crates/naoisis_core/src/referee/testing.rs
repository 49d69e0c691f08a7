//! Situations for the tests of the rules.

use bevy::prelude::*;

use super::custom_rules::CustomRules;
use super::decide::{Decisions, decide};
use super::formation::formation;
use super::memory::RefereeMemory;
use super::snapshot::{BallSnapshot, Disc, MatchSnapshot, RobotSnapshot};
use super::touch::Touch;
use crate::cycle::CycleClock;
use crate::game::{Game, GameState, Intervention, OutsideReferee, Penalty, Rules};
use crate::geometry::Pose;
use crate::pitch::Pitch;
use crate::robot::body::Body;
use crate::robot::head::HeadAngles;
use crate::robot::posture::Posture;
use crate::team::{PerTeam, RobotId, Team};

/// Everything that a [`MatchSnapshot`] borrows.
#[derive(Clone, Debug)]
pub struct MatchFixture {
    pub clock: CycleClock,
    pub pitch: Pitch,
    pub rules: Rules,
    pub game: Game,
    pub path: Vec<Vec2>,
    pub robots: Vec<RobotSnapshot>,
    pub posts: Vec<Disc>,
    pub memory: RefereeMemory,
    pub contacts: Vec<[usize; 2]>,
    pub touches: Vec<(RobotId, bool)>,
    pub interventions: Vec<Intervention>,
    pub outside: Option<OutsideReferee>,
    pub messages_sent: PerTeam<u32>,
}

impl MatchFixture {
    /// Three robots a side, lined up for blue's kick-off, in play, with the ball at rest on the centre mark.
    pub fn three_a_side() -> Self {
        let (clock, pitch, rules) = (CycleClock { cycle: 100, ..default() }, Pitch::default(), Rules::default());
        let mut game = Game::at_start(&rules, &clock);
        game.state = GameState::Playing;
        let robots = Team::BOTH
            .into_iter()
            .flat_map(|team| (1..=3).map(move |number| RobotId::new(team, number)))
            .map(|id| {
                let pose = formation(&pitch, 3, id.number, game.own_end(id.team), id.team == Team::Blue);
                RobotSnapshot {
                    id,
                    pose,
                    previous: pose,
                    wanted_velocity: Vec2::ZERO,
                    head: HeadAngles::default(),
                    is_kicking: false,
                    bounds: Body::default(),
                    posture: Posture::Upright,
                    penalty: Penalty(None),
                }
            })
            .collect();
        let posts = pitch.goal_posts().iter().map(|post| Disc { centre: post.position, radius: post.radius }).collect();
        Self {
            clock,
            pitch,
            rules,
            game,
            path: vec![Vec2::ZERO; 2],
            robots,
            posts,
            memory: RefereeMemory::default(),
            contacts: vec![],
            touches: vec![],
            interventions: vec![],
            outside: None,
            messages_sent: PerTeam::default(),
        }
    }

    /// The ball rolled straight from one position to another in this cycle.
    pub fn ball_rolled(mut self, from: [f32; 2], to: [f32; 2]) -> Self {
        self.path = vec![from.into(), to.into()];
        self
    }

    /// This robot touched the ball last, at its present position.
    pub fn touched_by(mut self, robot: RobotId) -> Self {
        let robot_position = self.robots.iter().find(|seen| seen.id == robot).unwrap().pose.position;
        self.memory.last_touch = Some(Touch { robot, cycle: self.clock.cycle - 1, robot_position, kick: true });
        self
    }

    pub fn snapshot(&self) -> MatchSnapshot<'_> {
        let ball = self.path.last().map(|position| BallSnapshot {
            path: &self.path,
            heights_m: &[],
            position: *position,
            velocity: (*position - self.path[0]) / self.clock.period(),
            radius: 0.03,
        });
        MatchSnapshot {
            clock: self.clock,
            pitch: &self.pitch,
            rules: &self.rules,
            game: &self.game,
            ball,
            robots: &self.robots,
            posts: &self.posts,
            last_touch: self.memory.last_touch,
            contacts: &self.contacts,
            touches: &self.touches,
            interventions: &self.interventions,
            outside: self.outside.as_ref(),
            messages_sent: self.messages_sent,
        }
    }

    /// This robot stands at `pose`.
    pub fn robot_at(mut self, robot: RobotId, pose: Pose) -> Self {
        let robot = self.robot_mut(robot);
        (robot.pose, robot.previous) = (pose, pose);
        self
    }

    /// This robot wanted to walk with this velocity in this cycle, m/s.
    pub fn walking(mut self, robot: RobotId, velocity: [f32; 2]) -> Self {
        self.robot_mut(robot).wanted_velocity = velocity.into();
        self
    }

    /// These two robots touched in this cycle.
    pub fn contact(mut self, a: RobotId, b: RobotId) -> Self {
        let index = |id| self.robots.iter().position(|robot| robot.id == id).unwrap();
        let pair = [index(a), index(b)];
        self.contacts.push(pair);
        self
    }

    pub fn robot_mut(&mut self, robot: RobotId) -> &mut RobotSnapshot {
        self.robots.iter_mut().find(|seen| seen.id == robot).unwrap()
    }

    pub fn decide(&self) -> Decisions {
        self.clone().pass()
    }

    /// Advances by a cycle in which nothing else happens, and applies the decisions of the referee.
    pub fn pass(&mut self) -> Decisions {
        let mut decisions = Decisions::default();
        let mut memory = self.memory.clone();
        decide(&self.snapshot(), &CustomRules::default(), &mut memory, &mut decisions);
        self.memory = memory;
        self.game = decisions.game.clone();
        self.robots.clone_from(&decisions.robots);
        self.clock.cycle += 1;
        self.touches.clear();
        self.interventions.clear();
        let ball = decisions.ball.or(self.path.last().copied());
        self.path = ball.map_or(vec![], |ball| vec![ball; 2]);
        decisions
    }
}

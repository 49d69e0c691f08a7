//! Situations for the tests of the rules.

use bevy::prelude::*;

use super::formation::formation;
use super::game::{Game, GameState};
use super::officiate::{Decisions, decide};
use super::rules::Rules;
use super::snapshot::{BallSnapshot, Disc, MatchSnapshot, RobotSnapshot};
use super::touch::{LastTouch, Touch};
use crate::cycle::CycleClock;
use crate::pitch::Pitch;
use crate::robot::body::BodyBounds;
use crate::robot::{RobotId, Team, Velocity};

/// Everything that a [`MatchSnapshot`] borrows.
#[derive(Clone, Debug)]
pub struct Situation {
    pub clock: CycleClock,
    pub pitch: Pitch,
    pub rules: Rules,
    pub game: Game,
    pub path: Vec<Vec2>,
    pub robots: Vec<RobotSnapshot>,
    pub posts: Vec<Disc>,
    pub last_touch: LastTouch,
}

impl Situation {
    /// Three a side as lined up for blue's kick-off, play on, the ball at rest on the centre mark.
    pub fn three_a_side() -> Self {
        let (clock, pitch, rules) = (CycleClock { cycle: 100, ..default() }, Pitch::default(), Rules::default());
        let mut game = Game::at_start(&rules, &clock);
        game.state = GameState::Playing;
        let robots = Team::BOTH
            .into_iter()
            .flat_map(|team| (1..=3).map(move |number| RobotId::new(team, number)))
            .map(|id| RobotSnapshot {
                id,
                pose: formation(&pitch, 3, id.number, game.own_end(id.team), id.team == Team::Blue),
                velocity: Velocity::default(),
                bounds: BodyBounds::default(),
                penalised: false,
            })
            .collect();
        let posts = pitch.goal_posts().iter().map(|post| Disc { centre: post.position, radius: post.radius }).collect();
        Self { clock, pitch, rules, game, path: vec![Vec2::ZERO; 2], robots, posts, last_touch: LastTouch(None) }
    }

    /// The ball went straight from one place to another in this cycle.
    pub fn ball_rolled(mut self, from: [f32; 2], to: [f32; 2]) -> Self {
        self.path = vec![from.into(), to.into()];
        self
    }

    /// This robot touched the ball last, from where it is.
    pub fn touched_by(mut self, robot: RobotId) -> Self {
        let robot_position = self.robots.iter().find(|seen| seen.id == robot).unwrap().pose.position;
        self.last_touch.0 = Some(Touch { robot, cycle: self.clock.cycle - 1, robot_position, kick: true });
        self
    }

    pub fn snapshot(&self) -> MatchSnapshot<'_> {
        let ball = self.path.last().map(|position| BallSnapshot {
            path: &self.path,
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
            last_touch: self.last_touch.0,
        }
    }

    pub fn decide(&self) -> Decisions {
        let mut decisions = Decisions::default();
        decide(&self.snapshot(), &mut decisions);
        decisions
    }
}

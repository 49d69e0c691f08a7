//! The situations in which episodes start, drawn from areas of the pitch.

use bevy::prelude::*;
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use naoisis_core::game::{Intervention, TimedIntervention};
use naoisis_core::geometry::{Pose, to_radians, wrap_angle};
use naoisis_core::random::RandomStream;
use naoisis_core::robot::posture::LyingOn;
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::{Scenario, ScenarioFault};

/// A range: the least and the greatest value.
type Range = [f32; 2];

/// The areas from which start positions are drawn. Everything else starts as in the scenario.
#[derive(Clone, PartialEq, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Situation {
    /// The area of the ball, pitch frame.
    pub ball: Option<Area>,
    /// How the ball rolls at the start; it rests without it.
    pub ball_rolls: Option<Shot>,
    /// The areas of robots.
    pub robots: BTreeMap<RobotId, StartArea>,
    /// The areas to which robots are carried one second after the start, which their sensors do not tell them.
    pub carried: BTreeMap<RobotId, StartArea>,
    /// Whether half of the situations, drawn by chance, are mirrored at the long axis of the pitch.
    pub mirrored: bool,
}

/// Why no episode can start in a [`Situation`].
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SituationError {
    /// A robot of the situation is not in the match.
    #[error("there is no {0} in the match")]
    NoRobot(RobotId),
    /// A range ends below its beginning, or is not finite.
    #[error("{0} is from {1} to {2}; expected the least value and then the greatest")]
    Range(String, f32, f32),
    /// All positions that were drawn are invalid.
    #[error("no start is possible in these areas: {0}")]
    Impossible(ScenarioFault),
}

naoisis_core::debug_as_displayed!(SituationError);

/// An area on the pitch, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// The range along the pitch, m.
    x_m: Range,
    /// The range across the pitch, m.
    y_m: Range,
}

impl Area {
    /// Whether a point is in the area.
    pub(super) fn contains(&self, point: Vec2) -> bool {
        let within = |[low, high]: Range, value: f32| low <= value && value <= high;
        within(self.x_m, point.x) && within(self.y_m, point.y)
    }

    fn draw(&self, stream: &mut RandomStream) -> Vec2 {
        Vec2::new(draw(self.x_m, stream), draw(self.y_m, stream))
    }
}

/// A ball that rolls.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shot {
    /// The area of a point on its line.
    towards: Area,
    /// The range of its speed at the start, m/s.
    speed_mps: Range,
}

/// The area in which a robot may start, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartArea {
    /// The range along the pitch, m.
    x_m: Range,
    /// The range across the pitch, m.
    y_m: Range,
    /// The range of its heading, deg.
    heading_deg: Range,
    /// Whether it lies, on its front or on its back.
    #[serde(default)]
    lies: bool,
}

impl StartArea {
    fn draw(&self, stream: &mut RandomStream) -> Pose {
        let [x, y] = [self.x_m, self.y_m].map(|range| draw(range, stream));
        Pose::new(x, y, wrap_angle(to_radians(draw(self.heading_deg, stream))))
    }
}

fn is_range([low, high]: &Range) -> bool {
    low.is_finite() && high.is_finite() && low <= high
}

fn draw([low, high]: Range, stream: &mut RandomStream) -> f32 {
    low + (high - low) * stream.random::<f32>()
}

impl Situation {
    /// The time at which robots are carried away, s.
    pub const CARRIED_AT_S: f64 = 1.0;

    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Checks that a start can be drawn for `scenario`.
    ///
    /// # Errors
    /// If a robot is not in the match, or no positions of a hundred draws are possible.
    pub fn check(&self, scenario: &Scenario) -> Result<(), SituationError> {
        if let Some((name, [low, high])) = self.ranges().find(|(_, range)| !is_range(range)) {
            return Err(SituationError::Range(name, low, high));
        }
        let mut robots = self.robots.keys().chain(self.carried.keys());
        match robots.find(|id| !scenario.has_robot(**id)) {
            Some(id) => Err(SituationError::NoRobot(*id)),
            None => self.try_drawn(scenario).map(drop).map_err(SituationError::Impossible),
        }
    }

    /// All ranges, with their names.
    fn ranges(&self) -> impl Iterator<Item = (String, Range)> {
        let of_area = |name: &str, area: &Area| {
            [(format!("{name}.x_m"), area.x_m), (format!("{name}.y_m"), area.y_m)].into_iter()
        };
        let of_robots = |name: &'static str, robots: &BTreeMap<RobotId, StartArea>| {
            let ranges = robots.iter().flat_map(move |(id, area)| {
                let name = format!("{name}.{id}");
                [("x_m", area.x_m), ("y_m", area.y_m), ("heading_deg", area.heading_deg)]
                    .map(|(part, range)| (format!("{name}.{part}"), range))
            });
            ranges.collect::<Vec<_>>()
        };
        let ball = self.ball.iter().flat_map(|area| of_area("ball", area)).collect::<Vec<_>>();
        let shot = self.ball_rolls.iter().flat_map(|shot| {
            let speed = ("ball_rolls.speed_mps".to_owned(), shot.speed_mps);
            of_area("ball_rolls.towards", &shot.towards).chain([speed])
        });
        let shot = shot.collect::<Vec<_>>();
        let (robots, carried) = (of_robots("robots", &self.robots), of_robots("carried", &self.carried));
        ball.into_iter().chain(shot).chain(robots).chain(carried)
    }

    /// Returns the scenario with start positions drawn by its seed; without a possible start, the scenario itself.
    pub(super) fn drawn(&self, scenario: Scenario) -> Scenario {
        self.try_drawn(&scenario).unwrap_or(scenario)
    }

    fn try_drawn(&self, scenario: &Scenario) -> Result<Scenario, ScenarioFault> {
        /// The greatest number of draws of the positions, which are repeated if robots overlap.
        const MOST_TRIES: usize = 100;

        let mut stream = RandomStream::for_match(scenario.seed, "situation");
        let mut last = Ok(scenario.clone());
        for _ in 0..MOST_TRIES {
            let tried = self.draw(scenario.clone(), &mut stream);
            last = tried.validate().map(|()| tried);
            if last.is_ok() {
                break;
            }
        }
        last
    }

    fn draw(&self, mut scenario: Scenario, stream: &mut RandomStream) -> Scenario {
        let side = if self.mirrored && stream.chance(0.5) { -1.0 } else { 1.0 };
        let place = |point: Vec2| Vec2::new(point.x, side * point.y);
        let turned = |pose: Pose| Pose::new(pose.position.x, side * pose.position.y, side * pose.heading);
        if let Some(ball) = &mut scenario.ball {
            if let Some(area) = self.ball {
                ball.position_m = place(area.draw(stream)).extend(0.0);
            }
            if let Some(shot) = self.ball_rolls {
                let line = place(shot.towards.draw(stream)) - ball.place_m();
                ball.velocity_mps = (line.normalize_or_zero() * draw(shot.speed_mps, stream)).extend(0.0);
            }
        }
        for robot in &mut scenario.robots {
            let Some(area) = self.robots.get(&robot.id()) else { continue };
            robot.pose = turned(area.draw(stream));
            if area.lies {
                robot.lies_on = Some(if stream.chance(0.5) { LyingOn::Front } else { LyingOn::Back });
            }
        }
        for (id, area) in &self.carried {
            scenario.interventions.push(TimedIntervention {
                at_s: Self::CARRIED_AT_S,
                intervention: Intervention::PlaceRobot { robot: *id, pose: turned(area.draw(stream)) },
            });
        }
        scenario
    }
}

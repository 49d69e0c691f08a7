//! The latest cycles in numbers: what robots were told to do, how far they were from the truth, where they were.
//!
//! Kept of every cycle as it is played or, where it lies in the past, as it is looked at. For plots, trails and whatever
//! shows commands, which are gone when a cycle is over.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use std::collections::BTreeMap;

use super::timeline::Timeline;
use crate::ball::{Ball, BallVelocity};
use crate::belief::error::{BeliefError, Truth};
use crate::belief::{Belief, point_team_from_pitch, team_from_pitch};
use crate::cycle::{Cycle, CycleClock};
use crate::game::{Game, Penalty};
use crate::geometry::Pose;
use crate::record::gather::{CurrentRecord, RecordSystems};
use crate::record::vocabulary::RobotCommand;
use crate::robot::head::HeadAngles;
use crate::robot::{Roster, Velocity};
use crate::scenario::Scenario;
use crate::sensing::sonar::SonarReading;
use crate::team::RobotId;

/// The latest so many cycles are kept.
const LONGEST: usize = 3600;

/// Keeps the [`CycleSamples`].
pub struct CycleSamplesPlugin;

impl Plugin for CycleSamplesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CycleSamples>()
            .add_systems(Cycle, note_cycle.in_set(RecordSystems::Keep))
            .add_systems(First, begin_anew.run_if(resource_exists_and_changed::<Scenario>))
            .add_systems(PreUpdate, note_past);
    }
}

/// A robot in a cycle.
#[derive(Clone, PartialEq, Debug)]
pub struct RobotSample {
    /// Where it was at the end of it, pitch frame.
    pub pose: Pose,
    /// How fast it was, m/s.
    pub speed_mps: f32,
    /// Where its head was turned, radians.
    pub head: HeadAngles,
    /// What its sonars heard.
    pub sonar: SonarReading,
    /// How far its belief was from the truth.
    pub error: Option<BeliefError>,
    /// How far away the ball was, m.
    pub ball_m: Option<f32>,
    /// Whether it was off the pitch.
    pub penalised: bool,
    /// What its behaviour wanted, if that is known.
    pub command: Option<RobotCommand>,
}

/// A cycle in numbers.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CycleSample {
    /// Its end, s since the start.
    pub time_s: f64,
    /// Where the ball was at the end of it, m, pitch frame.
    pub ball: Option<Vec2>,
    /// The robots, in the order of their ids.
    pub robots: BTreeMap<RobotId, RobotSample>,
}

/// The latest cycles.
#[derive(Resource, Default, Debug)]
pub struct CycleSamples {
    samples: BTreeMap<u64, CycleSample>,
}

impl CycleSamples {
    /// What there is of a cycle.
    pub fn sample(&self, cycle: u64) -> Option<&CycleSample> {
        self.samples.get(&cycle)
    }

    /// What there is of a robot in a cycle.
    pub fn robot(&self, cycle: u64, id: RobotId) -> Option<&RobotSample> {
        self.sample(cycle)?.robots.get(&id)
    }

    /// What there is of the cycles from one to another, in order.
    pub fn between(&self, first: u64, last: u64) -> impl Iterator<Item = (u64, &CycleSample)> {
        // Without an end before its start, of which there would be no range.
        self.samples.range(first.min(last)..=last).map(|(cycle, sample)| (*cycle, sample))
    }

    fn note(&mut self, cycle: u64, sample: CycleSample) {
        self.samples.insert(cycle, sample);
        while self.samples.len() > LONGEST {
            // What is furthest from now.
            let first = self.samples.keys().next().copied();
            let last = self.samples.keys().next_back().copied();
            let is_first_further = first.zip(last).is_none_or(|(first, last)| cycle - first >= last - cycle);
            if is_first_further {
                self.samples.pop_first()
            } else {
                self.samples.pop_last()
            };
        }
    }
}

/// What is noted of a robot.
#[derive(QueryData)]
struct NotedRobot {
    pose: &'static Pose,
    velocity: &'static Velocity,
    head: &'static HeadAngles,
    sonar: &'static SonarReading,
    penalty: &'static Penalty,
    belief: Option<&'static Belief>,
}

type NotedBall<'w, 's> = Query<'w, 's, (&'static Pose, &'static BallVelocity), (With<Ball>, Without<RobotId>)>;

fn begin_anew(mut samples: ResMut<CycleSamples>) {
    *samples = CycleSamples::default();
}

fn note_cycle(
    mut samples: ResMut<CycleSamples>,
    clock: Res<CycleClock>,
    game: Res<Game>,
    roster: Res<Roster>,
    current: Res<CurrentRecord>,
    robots: Query<NotedRobot>,
    balls: NotedBall,
) {
    samples.note(clock.cycle, sample(&clock, &game, &roster, &current, robots, balls));
}

/// Notes what is looked at again, unless it is known.
fn note_past(
    mut samples: ResMut<CycleSamples>,
    timeline: Res<Timeline>,
    clock: Res<CycleClock>,
    game: Res<Game>,
    roster: Res<Roster>,
    current: Res<CurrentRecord>,
    robots: Query<NotedRobot>,
    balls: NotedBall,
) {
    if timeline.is_past() && samples.sample(clock.cycle).is_none() {
        samples.note(clock.cycle, sample(&clock, &game, &roster, &current, robots, balls));
    }
}

fn sample(
    clock: &CycleClock,
    game: &Game,
    roster: &Roster,
    current: &CurrentRecord,
    robots: Query<NotedRobot>,
    balls: NotedBall,
) -> CycleSample {
    let ball = balls.iter().next().map(|(pose, velocity)| [pose.position, velocity.0]);
    let present: Vec<(RobotId, NotedRobotItem)> =
        roster.iter().filter_map(|(id, entity)| Some((id, robots.get(entity).ok()?))).collect();
    let of_robot = |(id, robot): &(RobotId, NotedRobotItem)| {
        let own_end = game.own_end(id.team);
        let to_team = |place: Vec2| point_team_from_pitch(place, own_end);
        let opponents = present.iter().filter(|(other, robot)| other.team != id.team && !robot.penalty.is_active());
        let error = robot.belief.filter(|_| !robot.penalty.is_active()).map(|belief| {
            let truth = Truth {
                pose: team_from_pitch(*robot.pose, own_end),
                ball: ball.map(|vectors| vectors.map(to_team)),
                opponents: opponents.map(|(_, robot)| to_team(robot.pose.position)).collect(),
            };
            BeliefError::of(belief, &truth, |_| {})
        });
        let sample = RobotSample {
            pose: *robot.pose,
            speed_mps: robot.velocity.linear.length(),
            head: *robot.head,
            sonar: *robot.sonar,
            error,
            ball_m: ball.map(|[place, _]| place.distance(robot.pose.position)),
            penalised: robot.penalty.is_active(),
            command: current.record.robot(*id).and_then(|robot| robot.command.clone()),
        };
        (*id, sample)
    };
    CycleSample {
        time_s: clock.end_time_s(),
        ball: ball.map(|[place, _]| place),
        robots: present.iter().map(of_robot).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::RecordPlugin;
    use crate::simulation::{MatchApp, NaoisisPlugins};
    use crate::team::Team;

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);

    #[test]
    fn a_cycle_is_noted_with_what_the_behaviour_wanted_in_it() {
        let scenario = Scenario::from_json(
            r#"{ "rules": "free", "ball": { "position_m": [1.0, 0.0] },
                 "robots": [{ "number": 1, "pose": [0.0, 0.0, 0.0], "behaviour": { "script": [
                    { "from_s": 0.0, "until_s": 60.0, "walk": [0.004, 0.0, 0.0] },
                    { "from_s": 0.0, "until_s": 60.0, "say": { "intention": "go" } }] } }] }"#,
        );
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, RecordPlugin, CycleSamplesPlugin));
        app.init_resource::<Timeline>().init_resource::<CurrentRecord>();
        app.start_match(&scenario.unwrap()).unwrap();
        app.run_cycles(30);
        let samples = app.world().resource::<CycleSamples>();
        let robot = samples.robot(30, BLUE).unwrap();
        // 30 steps of 4 mm.
        assert!((robot.pose.position.x - 0.12).abs() < 1e-5 && (robot.ball_m.unwrap() - 0.88).abs() < 1e-5);
        let command = robot.command.as_ref().unwrap();
        assert_eq!(command.walk.map(|walk| walk.dx), Some(0.004));
        assert_eq!(command.say.as_ref().and_then(|say| say.intention.as_deref()), Some("go"));
        assert_eq!(robot.error, None, "it believes nothing");
        assert_eq!(samples.between(20, 30).count(), 11);
        assert_eq!(samples.between(25, 20).count(), 1);
    }

    #[test]
    fn what_is_furthest_from_now_is_forgotten() {
        let mut samples = CycleSamples::default();
        for cycle in 0..LONGEST as u64 + 100 {
            samples.note(cycle, CycleSample::default());
        }
        assert_eq!(samples.samples.len(), LONGEST);
        assert!(samples.sample(99).is_none() && samples.sample(100).is_some());
        // Back at the start.
        samples.note(3, CycleSample::default());
        assert!(samples.sample(3).is_some() && samples.sample(LONGEST as u64 + 99).is_none());
    }
}

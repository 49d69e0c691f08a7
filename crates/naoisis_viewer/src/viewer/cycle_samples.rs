//! Numbers of the latest cycles: commands of robots, errors of their beliefs, positions.
//!
//! Each cycle is sampled when it is played. When the past is shown, the seconds before it are read from the records.
//! Used by plots, trails and others that show several cycles.

use bevy::app::RunFixedMainLoopSystems;
use bevy::prelude::*;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::timeline::{Timeline, TimelineSystems};
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::RobotId;
use naoisis_record::record::beliefs::Sensed;
use naoisis_record::record::history::History;
use naoisis_sensing::belief::error::{BeliefError, Truth};
use naoisis_sensing::belief::{point_team_from_pitch, team_from_pitch};
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::interface::gather::{CurrentRecord, RecordSystems};
use naoisis_sim::interface::vocabulary::RobotCommand;
use naoisis_sim::scenario::Scenario;

/// The number of cycles that are kept.
const LONGEST: usize = 3600;
/// The time before a moment of the past whose cycles are read from the records, s.
pub const LOOK_BACK_S: f64 = 20.0;
/// The part of a frame in which records are read.
const BUDGET: Duration = Duration::from_millis(4);

/// Keeps the [`CycleSamples`].
pub struct CycleSamplesPlugin;

impl Plugin for CycleSamplesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<CycleSamples>()
            .add_systems(Cycle, note_cycle.in_set(RecordSystems::Keep))
            .add_systems(First, reset.run_if(resource_exists_and_changed::<Scenario>))
            // The moment that is played now, not the one of the frame before.
            .add_systems(
                RunFixedMainLoop,
                note_past.in_set(RunFixedMainLoopSystems::AfterFixedMainLoop).after(TimelineSystems),
            );
    }
}

/// The values of a robot in a cycle.
#[derive(Clone, PartialEq, Debug)]
pub struct RobotSample {
    /// The pose at the end of the cycle, pitch frame.
    pub pose: Pose,
    /// The speed, m/s.
    pub speed_mps: f32,
    /// The angles of the head, radians.
    pub head: HeadAngles,
    /// The reading of the sonars.
    pub sonar: SonarReading,
    /// The error of the belief.
    pub error: Option<BeliefError>,
    /// The distance to the ball, m.
    pub ball_m: Option<f32>,
    /// Whether it was penalised.
    pub penalised: bool,
    /// The command of its behaviour, if it is known.
    pub command: Option<RobotCommand>,
}

/// The values of a cycle.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct CycleSample {
    /// The end of the cycle, s since the start.
    pub time_s: f64,
    /// The position of the ball at the end of the cycle, m, pitch frame.
    pub ball: Option<Vec2>,
    /// The robots, sorted by id.
    pub robots: BTreeMap<RobotId, RobotSample>,
}

/// The latest cycles.
#[derive(Resource, Default, Debug)]
pub struct CycleSamples {
    samples: BTreeMap<u64, CycleSample>,
}

impl CycleSamples {
    /// Returns the sample of a cycle, if it is kept.
    pub fn sample(&self, cycle: u64) -> Option<&CycleSample> {
        self.samples.get(&cycle)
    }

    /// Returns the sample of a robot in a cycle, if it is kept.
    pub fn robot(&self, cycle: u64, id: RobotId) -> Option<&RobotSample> {
        self.sample(cycle)?.robots.get(&id)
    }

    /// Returns the samples from `first` to `last`, in order.
    pub fn between(&self, first: u64, last: u64) -> impl Iterator<Item = (u64, &CycleSample)> {
        // `min`, because a range whose end is before its start would panic.
        self.samples.range(first.min(last)..=last).map(|(cycle, sample)| (*cycle, sample))
    }

    fn note(&mut self, cycle: u64, sample: CycleSample) {
        self.samples.insert(cycle, sample);
        while self.samples.len() > LONGEST {
            // The sample that is furthest from the current cycle is removed.
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

fn reset(mut samples: ResMut<CycleSamples>) {
    *samples = CycleSamples::default();
}

fn note_cycle(
    mut samples: ResMut<CycleSamples>,
    current: Res<CurrentRecord>,
    mut before: Local<Option<(u64, Sensed)>>,
) {
    let record = &current.record;
    let sensed = before.take().filter(|(cycle, _)| cycle + 1 == record.cycle).map(|(_, sensed)| sensed);
    samples.note(record.cycle, CycleSample::of(record, sensed.as_ref()));
    *before = Some((record.cycle, Sensed::of(record)));
}

/// Samples the moment that is shown and, a few in each frame, the cycles before it, unless they are known.
fn note_past(
    mut samples: ResMut<CycleSamples>,
    mut history: ResMut<History>,
    timeline: Res<Timeline>,
    clock: Res<CycleClock>,
) {
    // The present of a match that was put back, and that has not run since, is not known either.
    if !timeline.is_past() && samples.sample(clock.cycle).is_some() {
        return;
    }
    let started = Instant::now();
    let first = clock.cycle.saturating_sub((LOOK_BACK_S / clock.period_s) as u64);
    let mut cycle = clock.cycle;
    while samples.sample(cycle).is_some() || note_record(&mut samples, &mut history, cycle) {
        // If only every few cycles have a record, the previous record is used.
        let Some(before) = history.around(cycle).0.filter(|before| *before >= first) else { return };
        if started.elapsed() > BUDGET {
            return;
        }
        cycle = before;
    }
}

/// Samples a cycle from its record, if there is one.
fn note_record(samples: &mut CycleSamples, history: &mut History, cycle: u64) -> bool {
    let Ok(Some(record)) = history.record(cycle) else { return false };
    let before = record.cycle.checked_sub(1).and_then(|before| history.record(before).ok()?);
    let sensed = before.filter(|before| before.cycle + 1 == record.cycle).map(|before| Sensed::of(&before));
    samples.note(record.cycle, CycleSample::of(&record, sensed.as_ref()));
    record.cycle == cycle
}

impl CycleSample {
    /// The sample of a record. Errors of beliefs refer to `sensed`, the end of the cycle before. If it is not known, as
    /// in a trace of every few cycles, they refer to the end of this cycle.
    pub fn of(record: &CycleRecord, sensed: Option<&Sensed>) -> Self {
        let now = Sensed::of(record);
        let sensed = sensed.unwrap_or(&now);
        CycleSample {
            time_s: record.time_s,
            ball: now.ball.map(|[place, _]| place),
            robots: record.robots.iter().map(|robot| (robot.id, RobotSample::of(robot, record, sensed))).collect(),
        }
    }
}

impl RobotSample {
    /// The sample of a robot in a record, with the error of its belief relative to `sensed`.
    fn of(robot: &RobotRecord, record: &CycleRecord, sensed: &Sensed) -> Self {
        let own_end = record.game.own_end(robot.id.team);
        let opponents =
            record.robots.iter().filter(|other| other.id.team != robot.id.team && other.penalised.is_none());
        // A robot that has just returned from a penalty has not sensed yet.
        let sensing = robot.belief.as_ref().filter(|_| robot.penalised.is_none()).zip(sensed.pose(robot.id));
        let error = sensing.map(|(belief, pose)| {
            let truth = Truth {
                pose: team_from_pitch(pose, own_end),
                ball: sensed.ball.map(|vectors| vectors.map(|vector| point_team_from_pitch(vector, own_end))),
                opponents: opponents
                    .filter_map(|other| sensed.pose(other.id))
                    .map(|pose| point_team_from_pitch(pose.position, own_end))
                    .collect(),
            };
            BeliefError::of(belief, &truth, |_| {})
        });
        RobotSample {
            pose: robot.pose,
            speed_mps: robot.velocity.linear.length(),
            head: robot.head,
            sonar: robot.sonar_m,
            error,
            ball_m: record.ball.map(|ball| ball.position_m.truncate().distance(robot.pose.position)),
            penalised: robot.penalised.is_some(),
            command: robot.command.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::commands::TimelineCommand;
    use crate::viewer::drive::DrivePlugin;
    use crate::viewer::event_log::EventLogPlugin;
    use crate::viewer::shared::Playback;
    use bevy::time::TimeUpdateStrategy;
    use naoisis_core::game::PenaltyReason;
    use naoisis_core::team::Team;
    use naoisis_record::record::RecordPlugin;
    use naoisis_sim::interface::cycle_record::PenaltyRecord;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);

    #[test]
    fn a_past_cycle_is_known_in_the_frame_that_shows_it() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, CycleSamplesPlugin));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(40)));
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        while app.cycle() < 60 {
            app.update();
        }
        *app.world_mut().resource_mut::<CycleSamples>() = CycleSamples::default();
        app.world_mut().write_message(TimelineCommand::GoTo(20));
        for _ in 0..15 {
            app.update();
            app.world_mut().resource_mut::<Playback>().paused = false;
            let samples = app.world().resource::<CycleSamples>();
            assert!(samples.robot(app.cycle(), BLUE).is_some(), "cycle {}", app.cycle());
        }
        assert!((25..60).contains(&app.cycle()), "it played: cycle {}", app.cycle());
    }

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
        app.init_resource::<Timeline>().init_resource::<CurrentRecord>().init_resource::<History>();
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
    fn the_present_of_a_match_that_was_put_back_is_known_before_it_runs() {
        let mut app = App::new();
        app.init_resource::<Timeline>().init_resource::<CycleSamples>();
        let mut history = History::default();
        history.push(&CycleRecord { cycle: 7, robots: vec![RobotRecord::new(BLUE)], ..default() }).unwrap();
        app.insert_resource(history).insert_resource(CycleClock { cycle: 7, ..default() });
        app.add_systems(Update, note_past);
        app.update();
        assert!(app.world().resource::<CycleSamples>().robot(7, BLUE).is_some());
    }

    #[test]
    fn what_was_before_a_moment_of_the_past_is_read_from_its_records() {
        let (mut samples, mut history) = (CycleSamples::default(), History::of_every(3));
        for cycle in (0..=30).step_by(3) {
            let robots = vec![RobotRecord::new(BLUE)];
            history.push(&CycleRecord { cycle, time_s: cycle as f64 / 30.0, robots, ..default() }).unwrap();
        }
        assert!(note_record(&mut samples, &mut history, 12) && !note_record(&mut samples, &mut history, 13));
        let noted: Vec<u64> = samples.between(0, 30).map(|(cycle, _)| cycle).collect();
        assert_eq!(noted, [12, 15]);
        assert_eq!(samples.robot(15, BLUE).map(|robot| robot.speed_mps), Some(0.0));
    }

    #[test]
    fn a_belief_is_compared_with_what_was_sensed() {
        let belief = naoisis_sensing::belief::Belief { pose: Pose::new(1.0, 0.0, 0.0), ..default() };
        let record = |cycle, x| {
            let robot =
                RobotRecord { pose: Pose::new(x, 0.0, 0.0), belief: Some(belief.clone()), ..RobotRecord::new(BLUE) };
            CycleRecord { cycle, robots: vec![robot], ..default() }
        };
        // The belief is right for the pose when it sensed. The robot has walked on since.
        let mut history = History::default();
        history.push(&record(0, 1.0)).unwrap();
        history.push(&record(1, 1.5)).unwrap();
        let mut samples = CycleSamples::default();
        assert!(note_record(&mut samples, &mut history, 1));
        let error_m = |sample: &CycleSample| sample.robots[&BLUE].error.as_ref().map(|error| error.position_m);
        assert_eq!(samples.sample(1).and_then(error_m), Some(0.0));
        // A robot that served a penalty did not sense: its belief is that of before.
        let mut penalised = record(0, 9.0);
        penalised.robots[0].penalised = Some(PenaltyRecord { reason: PenaltyReason::Pushing, time_left_s: 0.1 });
        assert_eq!(error_m(&CycleSample::of(&record(1, 1.5), Some(&Sensed::of(&penalised)))), None);
        // Without the previous cycle's record, the belief is compared with the end of its own cycle.
        assert_eq!(error_m(&CycleSample::of(&record(1, 1.5), None)), Some(0.5));
    }

    #[test]
    fn what_is_furthest_from_now_is_forgotten() {
        let mut samples = CycleSamples::default();
        for cycle in 0..LONGEST as u64 + 100 {
            samples.note(cycle, CycleSample::default());
        }
        assert_eq!(samples.samples.len(), LONGEST);
        assert!(samples.sample(99).is_none() && samples.sample(100).is_some());
        // After going back to the start, the last samples are removed instead.
        samples.note(3, CycleSample::default());
        assert!(samples.sample(3).is_some() && samples.sample(LONGEST as u64 + 99).is_none());
    }
}

//! Measures a match.

use super::ball_meter::BallMeter;
use super::measures::{FieldMeasures, MatchMeasures};
use super::metered_cycle::MeteredCycle;
use super::robot_meter::RobotMeter;
use naoisis_core::game::GameState;
use naoisis_core::team::{PerTeam, Team};
use naoisis_record::record::match_counts::{MatchCounts, RobotCounts};
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// Measures a match from the records of its cycles.
pub struct MatchMeter {
    counts: MatchCounts,
    robots: RobotMeter,
    ball: BallMeter,
    field: FieldMeasures,
    messages: PerTeam<u32>,
    period_s: f64,
    last_cycle: Option<u64>,
}

impl MatchMeter {
    /// Creates a meter for matches of `scenario`. Measuring begins with the first record that it [reads](Self::look).
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            counts: MatchCounts::new(scenario),
            robots: RobotMeter::default(),
            ball: BallMeter::new(scenario),
            field: FieldMeasures::default(),
            messages: PerTeam::default(),
            period_s: scenario.cycle_s,
            last_cycle: None,
        }
    }

    /// Reads the next record. A shoot-out is not measured, because it comes after the match.
    pub fn look(&mut self, record: &CycleRecord) {
        if record.game.shoot_out.is_some() {
            return;
        }
        self.counts.look_at_record(record);
        let cycles = self.last_cycle.map_or(0, |last| record.cycle.saturating_sub(last));
        self.last_cycle = Some(record.cycle);
        let cycle = MeteredCycle {
            record,
            is_playing: record.game.state == GameState::Playing,
            duration_s: cycles as f64 * self.period_s,
        };
        self.robots.look(cycle, &mut self.field);
        self.ball.look(cycle, &mut self.field);
        let is_counted = matches!(record.game.state, GameState::Ready | GameState::Set | GameState::Playing);
        for robot in record.robots.iter().filter(|_| is_counted) {
            let says = robot.command.as_ref().is_some_and(|command| command.say.is_some());
            self.messages[robot.id.team] += u32::from(says);
        }
    }

    /// Returns the counts of the match.
    pub fn counts(&self) -> &MatchCounts {
        &self.counts
    }

    /// Ends measuring and returns the measures.
    pub fn finish(mut self) -> MatchMeasures {
        self.ball.finish(&mut self.field);
        let counts = &self.counts;
        let teams = Team::BOTH.map(|team| counts.team(team));
        let of_teams = |share: fn(&RobotCounts) -> Option<f64>| {
            let shares: Vec<f64> = teams.iter().filter_map(share).collect();
            (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
        };
        let distances: Vec<f64> =
            counts.robots.iter().filter(|(id, _)| !id.is_goalkeeper()).map(|(_, robot)| robot.distance_m).collect();
        let field = FieldMeasures {
            outs: counts.outs,
            passes: teams.iter().map(|team| team.passes).sum(),
            passes_completed: teams.iter().map(|team| team.passes_completed).sum(),
            possession: PerTeam::new(|team| counts.possession(team)),
            ball_seen: of_teams(RobotCounts::ball_seen),
            pose_over_half_m: of_teams(|robots| robots.pose_errors.over_half_m()),
            pose_over_1_m: of_teams(|robots| robots.pose_errors.over_1_m()),
            field_player_distance_m: (!distances.is_empty())
                .then(|| distances.iter().sum::<f64>() / distances.len() as f64),
            ..self.field
        };
        MatchMeasures { field: Some(field), ..MatchMeasures::of_counts(counts, Some(self.messages)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::*;
    use naoisis_core::events::{CollisionPartner, CollisionType, FallCause, KickMiss, KickResult, MatchEvent};
    use naoisis_core::geometry::Pose;
    use naoisis_core::kick_geometry::KickType;
    use naoisis_core::robot::posture::{LyingOn, Posture};
    use naoisis_core::team::RobotId;
    use naoisis_sim::interface::cycle_record::{BallRecord, GameRecord, RobotRecord};

    use super::super::measures::NextTouch;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    /// Measures a match of blue 2 and pink 2 with a record every tenth of a second. `change` changes the record of a cycle.
    fn measured(cycles: u64, change: impl Fn(&mut CycleRecord)) -> MatchMeasures {
        let mut meter = MatchMeter::new(&Scenario { cycle_s: 0.1, ..default() });
        for cycle in 0..=cycles {
            let mut record = CycleRecord {
                cycle,
                time_s: cycle as f64 * 0.1,
                ball: Some(BallRecord { position_m: Vec3::ZERO, velocity_mps: Vec3::ZERO }),
                robots: [BLUE2, PINK2].map(RobotRecord::new).into(),
                game: GameRecord { state: GameState::Playing, half: 1, ..default() },
                ..default()
            };
            record.robots[0].pose = Pose::new(-3.0, 0.0, 0.0);
            record.robots[1].pose = Pose::new(3.0, 0.0, 0.0);
            change(&mut record);
            meter.look(&record);
        }
        meter.finish()
    }

    fn field(measures: MatchMeasures) -> FieldMeasures {
        measures.field.unwrap()
    }

    fn kick(robot: RobotId, result: KickResult) -> MatchEvent {
        let is_struck = result != KickResult::Missed;
        MatchEvent::Kick {
            robot,
            kick_type: KickType::LeftSide,
            speed: Some(1.0),
            result,
            reason: (!is_struck).then_some(KickMiss::OutOfReach),
            direction: is_struck.then_some(0.0),
            launch_speed_mps: is_struck.then_some(1.0),
        }
    }

    #[test]
    fn steps_under_10_cm_are_no_walk() {
        // Back and forth by 5 cm for 2 s, then 1 m ahead in 2 s.
        let walked = field(measured(40, |record| {
            let cycle = record.cycle;
            let x = if cycle <= 20 { 0.05 * (cycle % 2) as f32 } else { 0.05 * (cycle - 20) as f32 };
            record.robots[0].pose = Pose::new(x, 2.0, 0.0);
        }));
        assert!((walked.walked_m - 1.0).abs() < 0.051, "{}", walked.walked_m);
    }

    #[test]
    fn falls_are_counted_in_play_and_getting_up_takes_its_time() {
        let fall = MatchEvent::Fall { robot: BLUE2, cause: FallCause::Walking, speed_mps: 0.2, probability: 0.1 };
        let fell = field(measured(100, |record| {
            record.robots[0].posture =
                if (10..60).contains(&record.cycle) { Posture::fallen(LyingOn::Back) } else { Posture::Upright };
            match record.cycle {
                10 => record.events.push(fall.clone()),
                60 => record.events.push(MatchEvent::GotUp { robot: BLUE2 }),
                // In `ready` a fall does not count as in play.
                90.. => {
                    record.game.state = GameState::Ready;
                    record.events.push(fall.clone());
                }
                _ => {}
            }
        }));
        assert_eq!(fell.falls, [(FallCause::Walking, 1)].into());
        assert!((fell.get_up_back_s[0] - 5.0).abs() < 1e-9 && fell.get_up_back_s.len() == 1);
        assert!(fell.get_up_front_s.is_empty());
        assert!((fell.lying_s - 5.0).abs() < 1e-9 && (fell.robot_play_s - 2.0 * 8.9).abs() < 1e-9);
    }

    #[test]
    fn a_kick_has_its_way_its_next_touch_and_the_time_before() {
        let kicked = field(measured(60, |record| {
            // Blue comes near after 1 s and kicks after 3 s; the ball rolls 1 m in 1 s, and pink touches it.
            record.robots[0].pose.position.x = if record.cycle < 10 { -3.0 } else { -0.3 };
            let rolled_m = (record.cycle.saturating_sub(30) as f32 * 0.1).min(1.0);
            if let Some(ball) = &mut record.ball {
                ball.position_m.x = rolled_m;
                ball.velocity_mps.x = if (31..=40).contains(&record.cycle) { 1.0 } else { 0.0 };
            }
            match record.cycle {
                20 => record.events.push(kick(BLUE2, KickResult::Missed)),
                30 => record.events.push(kick(BLUE2, KickResult::Kicked)),
                41 => record.events.push(MatchEvent::Collision {
                    robot: Some(PINK2),
                    with: CollisionPartner::Ball,
                    collision_type: CollisionType::MovingRobotAndStaticBall,
                    speed_mps: 0.1,
                    position_m: Vec2::X,
                }),
                _ => {}
            }
        }));
        assert_eq!((kicked.kicks.clone(), kicked.kicks_missed), ([("side".to_owned(), 1)].into(), 1));
        assert_eq!(kicked.next_touches, [(NextTouch::Opponent, 1)].into());
        assert!((kicked.kick_ways_m[0] - 1.0).abs() < 1e-6, "{:?}", kicked.kick_ways_m);
        assert!((kicked.near_before_kick_s[0] - 2.0).abs() < 0.11, "{:?}", kicked.near_before_kick_s);
        assert!((kicked.ball_way_m - 1.0).abs() < 1e-6 && (kicked.ball_rolls_s - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_ball_that_four_robots_leave_alone_is_noticed() {
        let four = |record: &mut CycleRecord| {
            let near = [(Team::Blue, 2), (Team::Blue, 3), (Team::Pink, 2), (Team::Pink, 3)];
            record.robots = near.map(|(team, number)| RobotRecord::new(RobotId::new(team, number))).into();
            for (robot, x) in record.robots.iter_mut().zip([-0.4, -0.9, 0.4, 0.9]) {
                robot.pose = Pose::new(x, 0.0, 0.0);
            }
        };
        let alone = field(measured(50, four));
        assert!((alone.four_near_ball_s - 5.0).abs() < 1e-9 && (alone.contested_s - 5.0).abs() < 1e-9);
        assert!((alone.robots_near_ball_s - 20.0).abs() < 1e-9);
        assert!((alone.left_alone_s - 3.0).abs() < 0.11, "{}", alone.left_alone_s);
    }

    #[test]
    fn a_ball_is_unknown_until_one_robot_sees_it_again() {
        use naoisis_core::camera_model::CameraName;
        use naoisis_sensing::sensing::vision::BallPercept;
        let unknown = field(measured(60, |record| {
            // Blue sees the ball at the start and again after 4 s, and not for half a second later; pink always sees it.
            let blue_sees = !(1..40).contains(&record.cycle) && !(50..55).contains(&record.cycle);
            let seen = BallPercept::new(CameraName::TOP, Vec2::ZERO, Vec2::ZERO);
            record.robots[0].percepts.ball = blue_sees.then_some(seen);
            record.robots[1].percepts.ball = Some(seen);
        }));
        assert_eq!(unknown.ball_unknown_s.len(), 1);
        assert!((unknown.ball_unknown_s[0] - 4.0).abs() < 1e-9, "{:?}", unknown.ball_unknown_s);
    }

    #[test]
    fn the_first_touch_is_timed_from_the_whistle() {
        let touched = field(measured(60, |record| {
            record.game.state = if record.cycle < 10 { GameState::Set } else { GameState::Playing };
            if [33, 50].contains(&record.cycle) {
                record.events.push(kick(BLUE2, KickResult::Kicked));
            }
        }));
        assert_eq!(touched.first_touch_s.len(), 1);
        assert!((touched.first_touch_s[0] - 2.3).abs() < 1e-9, "{:?}", touched.first_touch_s);
    }

    #[test]
    fn a_shoot_out_is_not_measured() {
        use naoisis_sim::interface::cycle_record::ShootOutRecord;
        let measures = measured(100, |record| {
            let shoot_out = ShootOutRecord { team: Team::Blue, taken: default(), goals: default() };
            record.game.shoot_out = (record.cycle >= 50).then_some(shoot_out);
            record.events.extend((record.cycle == 60).then(|| kick(BLUE2, KickResult::Kicked)));
        });
        assert!((measures.play_s - 4.9).abs() < 1e-9, "{}", measures.play_s);
        assert!(field(measures).kicks.is_empty());
    }

    #[test]
    fn a_stuck_game_is_counted_with_and_without_a_removed_robot() {
        use naoisis_core::game::Evidence;
        let stuck = field(measured(60, |record| {
            let robot = match record.cycle {
                10 | 20 => Some(BLUE2),
                30 => None,
                _ => return,
            };
            record.events.push(MatchEvent::GameStuck { robot, evidence: Evidence::default() });
        }));
        assert_eq!((stuck.stuck_robots, stuck.stuck_stops), (2, 1));
    }

    #[test]
    fn what_a_game_controller_knows_is_counted() {
        let measures = measured(100, |record| {
            record.game.half = if record.cycle < 50 { 1 } else { 2 };
            record.game.score = PerTeam { blue: u32::from(record.cycle >= 20), pink: u32::from(record.cycle >= 70) };
            record.game.state = if record.cycle < 40 { GameState::Ready } else { GameState::Playing };
        });
        assert_eq!((measures.all_goals(), measures.goals_in_first_half), (2, 1));
        assert!((measures.game_s - 10.0).abs() < 1e-9 && (measures.play_s - 6.1).abs() < 1e-9);
        assert!((measures.robot_s - 20.0).abs() < 1e-9 && measures.robot_s == measures.active_s);
    }
}

use super::super::match_counts::kicks::kick;
use super::*;
use naoisis_core::camera_model::CameraName;
use naoisis_core::events::CollisionType;
use naoisis_core::geometry::Pose;
use naoisis_sensing::belief::{BallBelief, Belief};
use naoisis_sensing::sensing::vision::BallPercept;
use naoisis_sim::interface::cycle_record::{BallRecord, GameRecord};

const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
const BLUE3: RobotId = RobotId::new(Team::Blue, 3);
const PINK2: RobotId = RobotId::new(Team::Pink, 2);

/// Returns a record in which blue defends -x and the ball lies on the centre mark.
fn cycle(number: u64) -> CycleRecord {
    let mut robots = vec![RobotRecord::new(BLUE2), RobotRecord::new(BLUE3), RobotRecord::new(PINK2)];
    for (robot, x) in robots.iter_mut().zip([-0.4, -2.0, 2.5]) {
        robot.pose = Pose::new(x, 0.0, 0.0);
        robot.percepts.ball = Some(BallPercept::new(CameraName::TOP, Vec2::ZERO, Vec2::X));
    }
    CycleRecord {
        cycle: number,
        time_s: number as f64 / 30.0,
        ball: Some(BallRecord { position_m: Vec3::ZERO, velocity_mps: Vec3::ZERO }),
        robots,
        game: GameRecord { state: GameState::Playing, ..default() },
        ..default()
    }
}

/// Returns the mistakes that are found in this number of cycles.
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
    // Two wrong periods are two mistakes if there was a long enough right one in between.
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
fn beliefs_are_excused_while_a_program_restarts_and_just_after_the_ball_was_put_elsewhere() {
    let found_after = |cycles: u64, event: MatchEvent| {
        found(cycles, move |record| {
            let ball = BallBelief { position_m: Vec2::new(1.0, 0.0), ..default() };
            let pose = record.robots[0].pose;
            record.robots[0].belief = Some(Belief { pose, ball: Some(ball), ..default() });
            record.events.extend((record.cycle == 1).then(|| event.clone()));
        })
    };
    // Wrong for 3 s before it may be a mistake, which takes another half second.
    let put = MatchEvent::DropBall { position_m: Vec2::ZERO };
    assert_eq!((found_after(100, put.clone()).len(), found_after(115, put).len()), (0, 1));
    let restarts = |robot| MatchEvent::ProgramRestarts { robot, duration_s: 2.0 };
    assert_eq!((found_after(70, restarts(BLUE2)).len(), found_after(85, restarts(BLUE2)).len()), (0, 1));
    assert_eq!(found_after(70, restarts(BLUE3)).len(), 1, "another robot's");
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
    // Pink's robot is not expected to see the ball: it is more than 2 m away.
    assert_eq!(kinds(&found(100, blind)), [(MistakeKind::BallNotSeen, BLUE2)]);
    assert_eq!(kinds(&found(85, blind)), []);
    let stopped = found(100, |record| {
        blind(record);
        record.game.state = GameState::Ready;
    });
    assert_eq!(stopped, []);
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
    // A shot at the goal that is saved is no mistake.
    assert_eq!(kinds(&kicked(0.1, PINK2)), []);
    assert_eq!(kinds(&kicked(to_own_goal, BLUE3)), [(MistakeKind::KickAtOwnGoal, BLUE2)]);
}

#[test]
fn team_mates_are_in_each_others_way() {
    let collide = found(60, |record| {
        let (with, collision_type) = (CollisionPartner::Robot(BLUE3), CollisionType::MovingRobots);
        let (robot, position_m) = (Some(BLUE2), Vec2::ZERO);
        // Two collisions within two seconds are one mistake.
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

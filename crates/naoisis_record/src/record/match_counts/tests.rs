use super::kicks::kick;
use super::*;
use core::f32::consts::FRAC_PI_2;
use naoisis_core::events::BoundaryLine;
use naoisis_core::game::{Evidence, PenaltyReason};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Velocity;
use naoisis_sensing::belief::Belief;
use naoisis_sim::interface::cycle_record::{BallRecord, GameRecord, PenaltyRecord, RobotRecord};

const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
const BLUE3: RobotId = RobotId::new(Team::Blue, 3);
const PINK1: RobotId = RobotId::new(Team::Pink, 1);
const PERIOD_S: f64 = 1.0 / 30.0;

/// Returns a cycle of play with these events. Blue 2 walks at 0.3 m/s, and blue attacks +x.
fn record(cycle: u64, events: Vec<MatchEvent>) -> CycleRecord {
    let mut robots: Vec<RobotRecord> = [BLUE2, BLUE3, PINK1].map(RobotRecord::new).into();
    robots[0].velocity = Velocity { linear: Vec2::new(0.0, 0.3), angular: 0.0 };
    robots[2].pose = Pose::new(2.0, 0.0, 0.0);
    CycleRecord {
        cycle,
        time_s: cycle as f64 * PERIOD_S,
        ball: Some(BallRecord { position_m: Vec3::ZERO, velocity_mps: Vec3::ZERO }),
        robots,
        game: GameRecord { state: GameState::Playing, ..default() },
        events,
        ..default()
    }
}

/// Returns the counts of a match with these events in its cycles.
fn counts(events: impl IntoIterator<Item = Vec<MatchEvent>>) -> MatchCounts {
    let mut counts = MatchCounts::new(&Scenario::default());
    for (cycle, events) in [Vec::new()].into_iter().chain(events).enumerate() {
        counts.look_at_record(&record(cycle as u64, events));
    }
    counts
}

fn out() -> MatchEvent {
    let (position_m, evidence) = (Vec2::ZERO, Evidence::default());
    MatchEvent::BallOut { line: BoundaryLine::Side, position_m, last_touch: Some(Team::Blue), evidence }
}

#[test]
fn kicks_are_shots_that_are_saved_and_passes_that_are_completed() {
    let saved = counts([vec![kick(BLUE2, 0.0)], vec![kick(PINK1, FRAC_PI_2)], vec![]]);
    let blue = saved.team(Team::Blue);
    assert_eq!((blue.shots, blue.shots_on_target, blue.passes), (1, 1, 0));
    assert_eq!(saved.robots[&PINK1].saves, 1);
    let passed = counts([vec![kick(BLUE2, FRAC_PI_2)], vec![kick(BLUE3, FRAC_PI_2)], vec![kick(PINK1, 0.0)]]);
    let blue = passed.team(Team::Blue);
    assert_eq!((blue.kicks, blue.passes, blue.passes_completed, blue.shots), (2, 2, 1, 0));
    assert_eq!(passed.robots[&BLUE2].passes_completed, 1);
    assert_eq!(passed.robots[&BLUE3].passes_completed, 0);
}

#[test]
fn passes_and_shots_have_their_places_and_halves_the_other_way_are_turned_around() {
    for (blue_end, sign) in [(End::NegativeX, 1.0), (End::PositiveX, -1.0)] {
        let mut counts = MatchCounts::new(&Scenario::default());
        // The ball lies, is kicked, rolls 1 m to the side, and is touched by a team-mate when the referee has put it elsewhere.
        for (cycle, y_m, event) in [
            (0, 0.0, None),
            (1, 0.0, Some(kick(BLUE2, FRAC_PI_2))),
            (2, 1.0, None),
            (3, -2.0, Some(kick(BLUE3, FRAC_PI_2))),
        ] {
            let mut record = record(cycle, event.into_iter().collect());
            record.ball = Some(BallRecord { position_m: Vec3::Y * y_m, velocity_mps: Vec3::ZERO });
            record.game.blue_end = blue_end;
            counts.look_at_record(&record);
        }
        let [pass] = counts.passes_and_shots[..] else { panic!("{:?}", counts.passes_and_shots) };
        assert_eq!((pass.robot, pass.outcome), (BLUE2, KickOutcome::PassCompleted));
        assert_eq!((pass.from_m, pass.to_m), (Vec2::ZERO * sign, Vec2::Y * sign));
    }
}

#[test]
fn a_shot_that_is_touched_on_its_way_into_the_goal_is_the_kickers_and_no_save() {
    let touch = MatchEvent::Collision {
        robot: Some(PINK1),
        with: CollisionPartner::Ball,
        collision_type: naoisis_core::events::CollisionType::StandingRobotAndBall,
        position_m: Vec2::ZERO,
        speed_mps: 1.0,
    };
    let goal = |scorer, own_goal| {
        let (team, evidence) = (Team::Blue, Evidence::default());
        MatchEvent::Goal { team, scorer: Some(scorer), own_goal, evidence }
    };
    // On target, beside the goal, and to the side: the second one misses a post by less than 0.5 m.
    for direction in [0.0, 0.35, FRAC_PI_2] {
        let scored = counts([vec![kick(BLUE2, direction)], vec![touch.clone()], vec![goal(BLUE2, false)]]);
        let blue = scored.team(Team::Blue);
        assert_eq!((blue.goals, blue.shots, blue.shots_on_target, blue.passes), (1, 1, 1, 0), "{direction}");
        assert_eq!((scored.robots[&PINK1].saves, scored.own_goals.pink), (0, 0));
        assert_eq!(scored.passes_and_shots[0].outcome, KickOutcome::ShotOnTarget { stopped_by: None });
    }
    // A save stays one if the kicker scores later by walking into the ball.
    let own_touch = MatchEvent::Collision {
        robot: Some(BLUE2),
        with: CollisionPartner::Ball,
        collision_type: naoisis_core::events::CollisionType::MovingRobotAndStaticBall,
        position_m: Vec2::ZERO,
        speed_mps: 0.2,
    };
    let dribbled = [vec![kick(BLUE2, 0.0)], vec![touch.clone()], vec![own_touch], vec![goal(BLUE2, false)]];
    assert_eq!(counts(dribbled).robots[&PINK1].saves, 1);
    let own = counts([vec![kick(BLUE2, 0.0)], vec![touch], vec![goal(PINK1, true)]]);
    assert_eq!((own.own_goals.pink, own.team(Team::Blue).goals), (1, 0));
}

#[test]
fn a_substitute_that_keeps_goal_has_the_saves() {
    let mut counts = MatchCounts::new(&Scenario::default());
    for (cycle, events) in
        [vec![], vec![kick(BLUE2, 0.0)], vec![kick(PINK1, FRAC_PI_2)], vec![]].into_iter().enumerate()
    {
        let mut record = record(cycle as u64, events);
        record.game.goalkeepers.pink = Some(6);
        counts.look_at_record(&record);
    }
    assert_eq!((counts.team(Team::Blue).shots_on_target, counts.robots[&PINK1].saves), (1, 0));
}

#[test]
fn the_ball_is_a_teams_from_its_touch_until_it_is_dead() {
    // Blue has the ball for two cycles and pink for one. Then it is out: nobody has it in the fourth and fifth cycle.
    let counts = counts([vec![kick(BLUE2, FRAC_PI_2)], vec![], vec![kick(PINK1, 0.0)], vec![out()], vec![]]);
    assert_eq!(counts.possession(Team::Blue), Some(2.0 / 3.0));
    assert_eq!((counts.outs, counts.outs_of.blue, counts.outs_of.pink), (1, 1, 0));
    assert!((counts.play_s() - 5.0 * PERIOD_S).abs() < 1e-9);
    assert_eq!(self::counts([vec![], vec![]]).possession(Team::Blue), None);
}

#[test]
fn cycles_that_were_left_out_count_with_the_next() {
    let mut counts = MatchCounts::new(&Scenario::default());
    for cycle in [0, 5, 10] {
        counts.look_at_record(&record(cycle, vec![]));
    }
    assert!((counts.play_s() - 10.0 * PERIOD_S).abs() < 1e-9);
    assert!((counts.robots[&BLUE2].distance_m - 0.1).abs() < 1e-6);
    assert_eq!(counts.robots[&BLUE3].distance_m, 0.0);
}

#[test]
fn a_duel_is_won_by_the_team_that_touched_the_ball_last_in_it() {
    let mut counts = MatchCounts::new(&Scenario::default());
    // Pink approaches, touches the ball, stays between the two distances, and leaves.
    let steps = [(2.0, None), (0.4, None), (0.4, Some(PINK1)), (0.7, None), (0.8, None), (0.4, None), (2.0, None)];
    for (cycle, (pink_x, kicker)) in steps.into_iter().enumerate() {
        let mut record = record(cycle as u64, kicker.map(|kicker| kick(kicker, 0.0)).into_iter().collect());
        record.robots[2].pose.position.x = pink_x;
        counts.look_at_record(&record);
    }
    // The second duel, without a touch, does not count.
    assert_eq!((counts.duels_won.blue, counts.duels_won.pink), (0, 1));
}

#[test]
fn pose_errors_have_a_mean_and_shares_of_time() {
    let mut counts = MatchCounts::new(&Scenario::default());
    for cycle in 0..=4 {
        let mut record = record(cycle, vec![]);
        let pose = Pose::new([0.0, 0.0, 0.2, 0.6, 1.2][cycle as usize], 0.0, 0.0);
        record.robots[0].belief = Some(Belief { pose, ..default() });
        counts.look_at_record(&record);
    }
    let errors = counts.team(Team::Blue).pose_errors;
    assert!((errors.mean_m().unwrap() - 0.5).abs() < 1e-6);
    assert_eq!((errors.over_half_m(), errors.over_1_m()), (Some(0.5), Some(0.25)));
    assert_eq!(counts.team(Team::Pink).pose_errors.mean_m(), None);
}

#[test]
fn a_robot_that_returns_from_a_penalty_has_no_error_until_it_has_sensed() {
    let mut counts = MatchCounts::new(&Scenario::default());
    for cycle in 0..=4 {
        let mut record = record(cycle, vec![]);
        // It is put elsewhere in cycle 2, and believes so from cycle 3 on.
        let [place, belief] = [if cycle < 2 { 0.0 } else { 2.0 }, if cycle < 3 { 0.0 } else { 2.0 }];
        let robot = &mut record.robots[0];
        robot.pose = Pose::new(place, 0.0, 0.0);
        robot.belief = Some(Belief { pose: robot.pose, ..default() });
        robot.belief.as_mut().unwrap().pose.position.x = belief;
        robot.penalised = (cycle == 1).then_some(PenaltyRecord { reason: PenaltyReason::Pushing, time_left_s: 0.1 });
        counts.look_at_record(&record);
    }
    let errors = counts.team(Team::Blue).pose_errors;
    assert_eq!((errors.mean_m(), errors.over_half_m()), (Some(0.0), Some(0.0)));
}

#[test]
fn out_of_play_nothing_takes_time() {
    let mut counts = MatchCounts::new(&Scenario::default());
    for cycle in 0..3 {
        let mut record = record(cycle, vec![kick(BLUE2, FRAC_PI_2)]);
        record.game.state = GameState::Ready;
        counts.look_at_record(&record);
    }
    // Kicks of the first cycle are left out, because counting starts at its end.
    assert_eq!((counts.play_s(), counts.possession(Team::Blue), counts.robots[&BLUE2].kicks), (0.0, None, 2));
    assert_eq!((counts.robots[&BLUE2].distance_m, counts.robots[&BLUE2].ball_seen()), (0.0, None));
}

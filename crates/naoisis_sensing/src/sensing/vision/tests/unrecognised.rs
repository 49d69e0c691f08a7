//! Why objects are not recognised: each reason, and that no recognised object has one.

use super::*;
use crate::appearance::scene::Scene;
use crate::sensing::vision::{Cover, MissedObject, SceneObject, Unrecognised, WhyMissed};
use naoisis_core::random::RandomStream;

const BLUE1: RobotId = RobotId::new(Team::Blue, 1);

/// A world that notes reasons, with a robot at the origin that looks straight ahead.
fn noting_app(noise: VisionNoise) -> (App, Entity) {
    let mut app = sensing_app();
    app.init_resource::<Unrecognised>();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    set(&mut app, robot, VisionSettings { noise, ..default() });
    (app, robot)
}

/// The percepts of a robot in the next cycle, and the objects that it did not recognise.
fn look(app: &mut App, robot: Entity) -> (Percepts, Vec<MissedObject>) {
    let percepts = sense::<Percepts>(app, robot);
    let time_s = app.world().resource::<CycleClock>().start_time_s();
    let missed = app.world().resource::<Unrecognised>().of(BLUE1, &Percepts { time_s, ..percepts.clone() });
    (percepts, missed.expect("noted in every cycle"))
}

/// Why a ball at this position is not recognised with this noise, with other robots at these poses; `None` if it is.
fn why_no_ball(x: f32, y: f32, noise: VisionNoise, others: &[[f32; 3]]) -> Option<WhyMissed> {
    let (mut app, robot) = noting_app(noise);
    spawn_ball(&mut app, x, y);
    for (number, pose) in (1..).zip(others) {
        spawn_robot(&mut app, Team::Pink, number, *pose, LEVEL);
    }
    let (_, missed) = look(&mut app, robot);
    missed.iter().find(|missed| missed.object == SceneObject::Ball(0)).map(|missed| missed.why)
}

fn ball_noise(ball: ClassNoise) -> VisionNoise {
    VisionNoise { ball, ..VisionNoise::none() }
}

#[test]
fn a_ball_that_is_seen_has_no_reason_and_others_are_outside_or_covered() {
    let exact = VisionNoise::none;
    // The edges of the images are those of the test of the ball.
    assert_eq!(why_no_ball(1.60, 0.0, exact(), &[]), None);
    assert_eq!(why_no_ball(1.565, 0.0, exact(), &[]), Some(WhyMissed::PartlyOutside));
    assert_eq!(why_no_ball(1.40, 0.0, exact(), &[]), Some(WhyMissed::OutsideImage));
    assert_eq!(why_no_ball(-2.0, 0.0, exact(), &[]), Some(WhyMissed::OutsideImage));
    // The robot at 1 m that faces this one hides, at x = 3 and on the ground, |y| < 0.4932.
    let facing = [[1.0, 0.0, 180.0]];
    let by = Cover::Robot(RobotId::new(Team::Pink, 1));
    assert_eq!(why_no_ball(3.0, 0.0, exact(), &facing), Some(WhyMissed::Covered { by, share: 1.0 }));
    assert_eq!(why_no_ball(3.0, 0.51, exact(), &facing), None);
    // A robot that is not in the way covers nothing.
    assert_eq!(why_no_ball(3.0, 0.0, exact(), &[[1.0, 1.5, 180.0]]), None);
    let Some(WhyMissed::Covered { share, .. }) = why_no_ball(3.0, 0.485, exact(), &facing) else { panic!() };
    assert!(share > 0.4 && share < 1.0, "{share}");
}

#[test]
fn a_range_counts_only_in_the_image_and_chance_only_in_view() {
    let near = ball_noise(ClassNoise { max_distance_m: Some(2.5), ..default() });
    assert_eq!(why_no_ball(3.0, 0.0, near, &[]), Some(WhyMissed::TooFar { distance_m: 3.0, limit_m: 2.5 }));
    assert_eq!(why_no_ball(-3.0, 0.0, near, &[]), Some(WhyMissed::OutsideImage));
    let never = ball_noise(ClassNoise { miss_probability: 1.0, ..default() });
    assert_eq!(why_no_ball(2.0, 0.0, never, &[]), Some(WhyMissed::Chance { probability: 0.0 }));
    assert_eq!(why_no_ball(-2.0, 0.0, never, &[]), Some(WhyMissed::OutsideImage));
    let behind = why_no_ball(3.0, 0.0, never, &[[1.0, 0.0, 180.0]]);
    assert!(matches!(behind, Some(WhyMissed::Covered { .. })), "{behind:?}");
}

#[test]
fn the_probability_is_the_share_of_images_in_which_a_ball_is_recognised() {
    // A fifth is missed at any distance, and half of the others at 2 m: 40 % are left. Of 2000, the share is known to 1.1 %; four of them.
    let falloff = Some(Falloff { half_distance_m: 2.0, exponent: 3.0 });
    let (mut app, robot) = noting_app(ball_noise(ClassNoise { miss_probability: 0.2, falloff, ..default() }));
    spawn_ball(&mut app, 2.0, 0.0);
    let mut seen = 0;
    for _ in 0..2000 {
        let (percepts, missed) = look(&mut app, robot);
        seen += usize::from(percepts.ball.is_some());
        match missed[..] {
            [] => assert!(percepts.ball.is_some()),
            [MissedObject { object: SceneObject::Ball(0), why: WhyMissed::Chance { probability } }] => {
                assert!(percepts.ball.is_none());
                assert_abs_diff_eq!(probability, 0.4, epsilon = 1e-5);
            }
            _ => panic!("{missed:?}"),
        }
    }
    assert!((seen as f32 / 2000.0 - 0.4).abs() < 0.044, "{seen}");
}

#[test]
fn posts_cover_robots_and_robots_cover_posts() {
    let (mut app, robot) = noting_app(VisionNoise::none());
    // A post of 5 cm radius at 1 m hides ±6 cm at 1.2 m, and the points of a waistband are at ±4 cm.
    spawn_post(&mut app, 1.0, 0.0, None);
    spawn_robot(&mut app, Team::Pink, 1, [1.2, 0.0, 0.0], LEVEL);
    let (_, missed) = look(&mut app, robot);
    let object = SceneObject::Robot(RobotId::new(Team::Pink, 1));
    assert_eq!(missed, [MissedObject { object, why: WhyMissed::Covered { by: Cover::Post, share: 1.0 } }]);
    // A low post behind a robot; posts without a colour are no goal posts.
    let (mut app, robot) = noting_app(VisionNoise::none());
    spawn_robot(&mut app, Team::Pink, 1, [1.0, 0.0, 180.0], LEVEL);
    let post = spawn_post(&mut app, 3.0, 0.0, Some(GoalColour::Yellow));
    set(&mut app, post, naoisis_core::pitch::Post { radius: 0.05, height: 0.25, colour: Some(GoalColour::Yellow) });
    let (_, missed) = look(&mut app, robot);
    let by = Cover::Robot(RobotId::new(Team::Pink, 1));
    assert_eq!(missed.len(), 1);
    assert_eq!(missed[0].why, WhyMissed::Covered { by, share: 1.0 });
}

#[test]
fn an_object_whose_pixel_is_above_the_horizon_has_no_position() {
    let far = ClassNoise { pixel_sd: 60.0, ..default() };
    let (mut app, robot) = noting_app(VisionNoise { goal_posts: far, ..VisionNoise::none() });
    spawn_post(&mut app, 9.0, 0.0, Some(GoalColour::Yellow));
    let mut lost = 0;
    for _ in 0..100 {
        let (percepts, missed) = look(&mut app, robot);
        assert_eq!(percepts.goal_posts.len() + missed.len(), 1);
        lost += missed.len();
        assert!(missed.iter().all(|missed| missed.why == WhyMissed::NoPosition), "{missed:?}");
    }
    assert!(lost > 20, "{lost}");
}

#[test]
fn in_any_scene_an_object_is_either_recognised_or_has_a_reason() {
    let mut stream = RandomStream::for_match(5, "reasons");
    let mut within = |least: f32, greatest: f32| least + stream.uniform() * (greatest - least);
    let (mut seen, mut covered) = (0, 0);
    for _ in 0..150 {
        let (mut app, robot) = noting_app(VisionNoise::none());
        for number in 1..=5 {
            let pose = [within(-1.0, 4.0), within(-2.0, 2.0), within(-180.0, 180.0)];
            spawn_robot(&mut app, if number < 3 { Team::Blue } else { Team::Pink }, number + 1, pose, LEVEL);
        }
        for _ in 0..3 {
            spawn_post(&mut app, within(0.5, 4.0), within(-2.0, 2.0), Some(GoalColour::White));
        }
        spawn_ball(&mut app, within(0.2, 4.0), within(-1.5, 1.5));
        let (percepts, missed) = look(&mut app, robot);
        let scene = app.world().resource::<Scene>();
        let place_of = |missed: &MissedObject| match missed.object {
            SceneObject::Ball(_) => scene.ball.unwrap().position,
            SceneObject::GoalPost { position_m, .. } => position_m,
            SceneObject::Robot(id) => scene.robot(id).unwrap().pose.position,
        };
        // Without noise, percepts are at the true positions.
        let robots = percepts.robots.iter().map(|robot| robot.position_m);
        let posts = percepts.goal_posts.iter().map(|post| post.position_m);
        let places: Vec<Vec2> = robots.chain(posts).chain(percepts.ball.map(|ball| ball.position_m)).collect();
        assert_eq!(places.len() + missed.len(), 9, "{places:?} {missed:?}");
        for one in &missed {
            assert!(places.iter().all(|place| place.distance(place_of(one)) > 1e-3), "{one:?} {places:?}");
            let is_geometry =
                matches!(one.why, WhyMissed::OutsideImage | WhyMissed::PartlyOutside | WhyMissed::Covered { .. });
            assert!(is_geometry, "{one:?}");
            covered += usize::from(matches!(one.why, WhyMissed::Covered { .. }));
        }
        seen += places.len();
    }
    assert!(seen > 300 && covered > 30, "{seen} {covered}");
}

#[test]
fn a_vision_that_knows_the_truth_misses_nothing_and_one_by_images_names_only_what_is_certain() {
    let (mut app, robot) = noting_app(VisionNoise::none());
    spawn_ball(&mut app, -2.0, 0.0);
    set(&mut app, robot, VisionSettings { source: VisionSource::Truth, ..default() });
    assert_eq!(look(&mut app, robot).1, []);
    set(&mut app, robot, VisionSettings { source: VisionSource::Image, ..default() });
    spawn_robot(&mut app, Team::Pink, 1, [2.0, 0.0, 0.0], LEVEL);
    let (percepts, missed) = look(&mut app, robot);
    let outside = MissedObject { object: SceneObject::Ball(0), why: WhyMissed::OutsideImage };
    assert!(missed.contains(&outside), "{missed:?}");
    // The robot ahead is in the image: it has a percept or this reason.
    let pink = MissedObject { object: SceneObject::Robot(RobotId::new(Team::Pink, 1)), why: WhyMissed::InImage };
    assert_eq!(missed.contains(&pink), percepts.robots.iter().all(|robot| robot.team != Team::Pink), "{percepts:?}");
}

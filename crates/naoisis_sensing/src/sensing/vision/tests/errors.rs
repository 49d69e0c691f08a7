//! The vision's errors compared with their statistics.

use super::*;
use crate::sensing::sonar::{SonarNoise, SonarReading};

/// Percepts of the ball, 2 m ahead of the lens, in many cycles with this noise.
fn noisy_balls(noise: VisionNoise, cycles: usize) -> Vec<Option<BallPercept>> {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    set(&mut app, robot, VisionSettings { noise, ..default() });
    spawn_ball(&mut app, 2.0539, 0.0);
    (0..cycles).map(|_| sense::<Percepts>(&mut app, robot).ball).collect()
}

fn mean_and_deviation(values: impl Iterator<Item = f32> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().map(f64::from).sum::<f64>() / count;
    (mean, (values.map(|value| (f64::from(value) - mean).powi(2)).sum::<f64>() / count).sqrt())
}

#[test]
fn pixels_spread_as_asked_for_and_places_follow() {
    let noise = VisionNoise { ball: ClassNoise { pixel_sd: 1.5, ..default() }, ..VisionNoise::none() };
    let balls = noisy_balls(noise, 5000);
    // Standard errors: mean 1.5 / sqrt(5000) = 0.0212, deviation 1.5 / sqrt(10000) = 0.015. Four of them: 99.99 %.
    for (axis, expected) in [(0, 160.0), (1, 211.50)] {
        let (mean, deviation) = mean_and_deviation(balls.iter().flatten().map(|ball| ball.pixel[axis]));
        assert!((mean - expected).abs() < 4.0 * 0.0212 + 0.01, "{mean}");
        assert!((deviation - 1.5).abs() < 4.0 * 0.015, "{deviation}");
    }
    // The place is that of the pixel: x - 0.0539 = 360.81 * 0.5072 / (v - 120).
    for ball in balls.iter().flatten() {
        let expected = 0.0539 + 360.81 * 0.5072 / (ball.pixel.y - 120.0);
        assert_abs_diff_eq!(ball.position_m.x, expected, epsilon = 1e-3);
    }
}

#[test]
fn an_error_of_the_head_angles_shifts_the_pixels_and_the_robot_does_not_know() {
    let noise = VisionNoise { head_angle_sd: to_radians(1.0), ..VisionNoise::none() };
    let balls = noisy_balls(noise, 5000);
    // A degree of yaw moves a point at the middle of the image by f tan 1° = 6.298 px sideways, times its distance
    // along the ground over its depth, 1. Standard error of the deviation 1 %, four of them: 99.99 %.
    let (_, deviation) = mean_and_deviation(balls.iter().flatten().map(|ball| ball.pixel.x));
    assert!((deviation - 6.298).abs() < 0.05 * 6.298, "{deviation}");
    // So the bearing of the position errs by a degree: 2.0539 m * tan 1° = 0.0359 m.
    let (_, deviation) =
        mean_and_deviation(balls.iter().flatten().map(|ball| ball.position_m.y / ball.position_m.x * 2.0539));
    assert!((deviation - 0.0359).abs() < 0.05 * 0.0359, "{deviation}");
}

#[test]
fn balls_are_missed_as_often_as_asked_for() {
    let cycles = 4000;
    // Binomial: 1200 ± sqrt(4000 * 0.3 * 0.7) = 29; four of them: 99.99 %.
    for (miss_probability, least, most) in [(0.0, 0, 0), (0.3, 1084, 1316), (1.0, cycles, cycles)] {
        let noise = VisionNoise { ball: ClassNoise { miss_probability, ..default() }, ..VisionNoise::none() };
        let missed = noisy_balls(noise, cycles).iter().filter(|ball| ball.is_none()).count();
        assert!((least..=most).contains(&missed), "{missed} missed");
    }
}

#[test]
fn false_detections_come_as_often_as_asked_for_and_lie_in_the_image() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 15.0]);
    let class = ClassNoise { false_positive_probability: 0.1, max_distance_m: Some(4.0), ..default() };
    let noise = VisionNoise { ball: class, goal_posts: class, robots: class, ..VisionNoise::none() };
    set(&mut app, robot, VisionSettings { noise, ..default() });
    let mut counts = [0; 3];
    let cycles = 4000;
    for _ in 0..cycles {
        let percepts = sense::<Percepts>(&mut app, robot);
        let imagined = [
            percepts.ball.map(|ball| (ball.pixel, ball.position_m)),
            percepts.goal_posts.first().map(|post| (post.pixel, post.position_m)),
            percepts.robots.first().map(|robot| (robot.pixel, robot.position_m)),
        ];
        for (count, imagined) in counts.iter_mut().zip(imagined) {
            *count += i32::from(imagined.is_some());
            if let Some((pixel, place)) = imagined {
                assert!(pixel.x >= 0.0 && pixel.x < 320.0 && pixel.y >= 0.0 && pixel.y < 240.0);
                assert!(place.length() <= 4.0);
            }
        }
    }
    // Binomial: 400 ± sqrt(4000 * 0.1 * 0.9) = 19; four of them: 99.99 %.
    assert!(counts.iter().all(|count| (324..=476).contains(count)), "{counts:?}");
}

#[test]
fn a_thing_half_hidden_is_recognised_as_one_that_seems_as_small() {
    let falloff = Some(Falloff { half_distance_m: 2.0, exponent: 4.0 });
    let noise = VisionNoise { ball: ClassNoise { falloff, ..default() }, ..VisionNoise::none() };
    let share_seen = |post: Option<[f32; 2]>| {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
        set(&mut app, robot, VisionSettings { noise, ..default() });
        spawn_ball(&mut app, 2.0, 0.0);
        if let Some([x, y]) = post {
            spawn_post(&mut app, x, y, None);
        }
        (0..4000).filter(|_| sense::<Percepts>(&mut app, robot).ball.is_some()).count() as f32 / 4000.0
    };
    // At the half distance a half; binomial, four standard errors: 0.032.
    assert!((share_seen(None) - 0.5).abs() < 0.032);
    // A post that hides the left one of its five points: it seems sqrt(5 / 4) times as far, and (5/4)² to 1 are against it.
    let hidden = share_seen(Some([1.5, 0.0655]));
    assert!((hidden - 1.0 / (1.0 + 1.5625)).abs() < 0.032, "{hidden}");
}

#[test]
fn everything_is_recognised_less_often_further_away_but_nowhere_never() {
    let falloff = Some(Falloff { half_distance_m: 2.0, exponent: 2.0 });
    let class = ClassNoise { falloff, ..default() };
    let noise = VisionNoise {
        ball: class,
        goal_posts: class,
        robots: class,
        lines: class,
        junctions: class,
        penalty_crosses: class,
        centre_circle: class,
        ..VisionNoise::none()
    };
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [-1.0, 0.0, 0.0], LEVEL);
    set(&mut app, robot, VisionSettings { noise, ..default() });
    spawn_ball(&mut app, 3.0, 0.2);
    spawn_robot(&mut app, Team::Pink, 1, [3.0, -0.3, 180.0], LEVEL);
    spawn_post(&mut app, 3.0, 0.6, Some(GoalColour::Yellow));
    let cycles = 2000;
    let mut counts = [0; 4];
    let mut farthest_line_m: f32 = 0.0;
    for _ in 0..cycles {
        let percepts = sense::<Percepts>(&mut app, robot);
        let is_far_cross = |seen: &LandmarkPercept| seen.kind == LandmarkKind::PenaltyCross && seen.position_m.x > 1.5;
        let seen = [
            percepts.ball.is_some(),
            !percepts.robots.is_empty(),
            !percepts.goal_posts.is_empty(),
            percepts.landmarks.iter().any(is_far_cross),
        ];
        for (count, seen) in counts.iter_mut().zip(seen) {
            *count += u32::from(seen);
        }
        let lines = percepts.landmarks.iter().filter(|seen| matches!(seen.kind, LandmarkKind::Line { .. }));
        farthest_line_m = lines.map(|line| line.position_m.x).fold(farthest_line_m, f32::max);
    }
    // At 4 m 1 / (1 + 4) = 0.2, the cross at 2.2 m 1 / (1 + 1.21) = 0.452; four binomial standard errors.
    for (count, expected) in counts.into_iter().zip([0.2, 0.2, 0.2, 0.452]) {
        let share = count as f32 / cycles as f32;
        assert!((share - expected).abs() < 4.0 * (expected * (1.0 - expected) / cycles as f32).sqrt(), "{counts:?}");
    }
    assert!(farthest_line_m > 3.9);
}

#[test]
fn a_robot_whose_feet_are_hidden_seems_further_away_and_one_whose_feet_are_seen_does_not() {
    let noise = VisionNoise { hidden_feet: HiddenFeet { bias: 0.3, sd: 0.1 }, ..VisionNoise::none() };
    let distances = |x: f32| {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
        set(&mut app, robot, VisionSettings { noise, ..default() });
        spawn_robot(&mut app, Team::Pink, 1, [x, 0.0, 180.0], LEVEL);
        (0..2000).map(|_| sense::<Percepts>(&mut app, robot).robots[0].position_m.x).collect::<Vec<_>>()
    };
    assert!(distances(2.5).iter().all(|distance| (distance - 2.5).abs() < 1e-3));
    // At 1.4 m the feet are between the two images. The upper one begins 18.396° below the horizon, at 1.4 m where it is
    // 0.5372 - 1.3461 * 0.33259 = 0.0895 m high: of the points of the legs 0.10 m is the lowest in view, a third of 0.30.
    let (mean, deviation) = mean_and_deviation(distances(1.4).into_iter());
    assert!((mean - 1.4 * 1.1).abs() < 4.0 * 0.0467 / 44.7, "{mean}");
    assert!((deviation - 1.4 * 0.1 / 3.0).abs() < 4.0 * 0.0467 / 63.2, "{deviation}");
}

#[test]
fn the_number_of_a_robot_is_read_near_enough_from_the_front_and_from_behind() {
    let jerseys = JerseyVision { number_m: 2.0, number_error: 0.2, heading_m: 3.0, heading_sd: 0.1, ..default() };
    let noise = VisionNoise { jerseys, ..VisionNoise::none() };
    let seen = |x: f32, heading_deg: f32, noise: VisionNoise| {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
        set(&mut app, robot, VisionSettings { noise, ..default() });
        spawn_robot(&mut app, Team::Pink, 4, [x, 0.0, heading_deg], LEVEL);
        (0..2000).map(|_| sense::<Percepts>(&mut app, robot).robots[0]).collect::<Vec<_>>()
    };
    let nothing = |seen: &RobotPercept| (seen.number, seen.heading) == (None, None);
    assert!(seen(1.5, 180.0, VisionNoise::none()).iter().all(nothing) && seen(3.2, 0.0, noise).iter().all(nothing));
    // From the side, or from further away, the heading alone is recognised.
    assert!(seen(1.5, 90.0, noise).iter().all(|seen| seen.number.is_none() && seen.heading.is_some()));
    assert!(seen(2.5, 180.0, noise).iter().all(|seen| seen.number.is_none() && seen.heading.is_some()));
    for heading_deg in [0.0, 180.0, 150.0] {
        let seen = seen(1.5, heading_deg, noise);
        // One in nine of those that are misread is the true number: 1 - 0.2 * 8 / 9 = 0.822, four binomial standard errors.
        let share = seen.iter().filter(|seen| seen.number == Some(4)).count() as f32 / 2000.0;
        assert!((share - 0.822).abs() < 4.0 * (0.822 * 0.178 / 2000.0_f32).sqrt(), "{share}");
        let off = seen.iter().map(|seen| wrap_angle(seen.heading.unwrap() - to_radians(heading_deg)));
        let (mean, deviation) = mean_and_deviation(off);
        assert!(mean.abs() < 4.0 * 0.1 / 44.7 && (deviation - 0.1).abs() < 4.0 * 0.1 / 63.2, "{mean} {deviation}");
    }
}

#[test]
fn a_place_that_looks_like_a_ball_stays_where_it_is_while_the_robot_moves() {
    let noise = VisionNoise {
        false_balls: FalsePositives { per_minute: 60.0, life_s: 30.0 },
        false_robots: FalsePositives { per_minute: 60.0, life_s: 30.0 },
        ..VisionNoise::none()
    };
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [-2.8, 0.0, 0.0], LEVEL);
    set(&mut app, robot, VisionSettings { noise, ..default() });
    // Repeated until there are robots of both kinds ahead.
    let first = (0..3000).map(|_| sense::<Percepts>(&mut app, robot));
    let first = first.filter(|percepts| percepts.ball.is_some()).find(|percepts| !percepts.robots.is_empty()).unwrap();
    let ball = Pose::new(-2.8, 0.0, 0.0).transform_point(first.ball.unwrap().position_m);
    let markings = naoisis_core::pitch::Markings::new(&naoisis_core::pitch::Pitch::default());
    let marks = markings.junctions.iter().map(|junction| junction.position).chain(markings.penalty_crosses);
    assert!(marks.into_iter().any(|mark| mark.distance(ball) < 1e-3), "{ball}");
    // From another pose the false positive is at the same position on the pitch, and behind the robot it is not seen.
    let elsewhere = Pose::new(-2.5, 0.3, -0.1);
    set(&mut app, robot, elsewhere);
    let then = sense::<Percepts>(&mut app, robot);
    assert!(elsewhere.transform_point(then.ball.unwrap().position_m).distance(ball) < 1e-3);
    let place = Pose::new(-2.8, 0.0, 0.0).transform_point(first.robots[0].position_m);
    let again = then.robots.iter().map(|robot| elsewhere.transform_point(robot.position_m));
    assert!(again.into_iter().any(|again| again.distance(place) < 2e-3), "{then:?}");
    set(&mut app, robot, Pose::new(-2.9, 0.0, core::f32::consts::PI));
    assert_eq!(sense::<Percepts>(&mut app, robot).ball, None);
}

#[test]
fn the_gaze_errs_alike_from_one_image_to_the_next_and_more_while_walking() {
    let gaze = GazeNoise { standing_sd: to_radians(0.5), walking_sd: to_radians(2.0), correlation_s: 0.3, ..default() };
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    set(&mut app, robot, VisionSettings { noise: VisionNoise { gaze, ..VisionNoise::none() }, ..default() });
    spawn_ball(&mut app, 2.2, 0.0);
    for (step, sd_deg) in [(0.0, 0.5), (0.003, 2.0)] {
        set(&mut app, robot, ExecutedStep(naoisis_core::robot::motion::WalkCommand::new(step, 0.0, 0.0)));
        let bearings: Vec<f32> =
            (0..9000).filter_map(|_| sense::<Percepts>(&mut app, robot).ball.map(|ball| ball.bearing())).collect();
        let (_, deviation) = mean_and_deviation(bearings.iter().copied());
        // In 300 s there are 500 independent pairs: the deviation is known to 1 / sqrt(1000) = 3.2 %, four of them.
        assert!((deviation / f64::from(to_radians(sd_deg)) - 1.0).abs() < 0.13, "{deviation}");
        // From one image to the next it changes by sqrt(2 (1 - exp(-1 / 9))) = 0.459 of that.
        let (_, change) = mean_and_deviation(bearings.windows(2).map(|pair| pair[1] - pair[0]));
        assert!((change / deviation - 0.459).abs() < 0.06, "{change} of {deviation}");
    }
}

#[test]
fn each_class_ends_at_its_greatest_distance() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [-3.0, 0.0, 0.0], LEVEL);
    let class = ClassNoise { max_distance_m: Some(2.5), ..default() };
    let noise = VisionNoise {
        ball: class,
        goal_posts: class,
        robots: class,
        lines: class,
        junctions: class,
        penalty_crosses: class,
        centre_circle: class,
        ..VisionNoise::none()
    };
    set(&mut app, robot, VisionSettings { noise, ..default() });
    let ball = spawn_ball(&mut app, -0.51, 0.0);
    let other = spawn_robot(&mut app, Team::Pink, 1, [-0.55, 0.3, 0.0], LEVEL);
    let percepts = sense::<Percepts>(&mut app, robot);
    assert!(percepts.ball.is_some() && percepts.robots.len() == 1);
    for entity in [ball, other] {
        set(&mut app, entity, Pose::new(-0.49, 0.2, 0.0));
    }
    let percepts = sense::<Percepts>(&mut app, robot);
    assert!(percepts.ball.is_none() && percepts.robots.is_empty());
    for landmark in &percepts.landmarks {
        assert!(landmark.position_m.length() < 2.501, "{landmark:?}");
    }
}

#[test]
fn the_settings_of_one_robot_leave_the_others_readings_as_they_are() {
    let run = |settings: VisionSettings, sonar: SonarSettings| {
        let mut app = sensing_app();
        let robots =
            [(Team::Blue, 1, 0.0), (Team::Blue, 2, 120.0), (Team::Pink, 1, 240.0)].map(|(team, number, deg)| {
                let place = 0.3 * unit(to_radians(deg));
                let robot = spawn_robot(&mut app, team, number, [place.x, place.y, deg + 150.0], [0.0, 10.0]);
                set(&mut app, robot, VisionSettings::default());
                set(&mut app, robot, SonarSettings::default());
                robot
            });
        spawn_ball(&mut app, 0.0, 0.0);
        set(&mut app, robots[0], settings);
        set(&mut app, robots[0], sonar);
        (0..50)
            .map(|_| {
                let first = sense::<Percepts>(&mut app, robots[0]);
                let others = [1, 2].map(|index| {
                    let robot = app.world().entity(robots[index]);
                    (robot.get::<Percepts>().cloned(), robot.get::<SonarReading>().copied())
                });
                (first, others)
            })
            .collect::<Vec<_>>()
    };
    let noisy = run(VisionSettings::default(), SonarSettings::default());
    let exact = run(
        VisionSettings { noise: VisionNoise::none(), ..default() },
        SonarSettings { noise: SonarNoise::None, ..default() },
    );
    let truth = run(VisionSettings { source: VisionSource::Truth, ..default() }, SonarSettings::default());
    assert!(noisy.iter().any(|(_, others)| others.iter().any(|(percepts, sonar)| {
        percepts.as_ref().is_some_and(|percepts| percepts.ball.is_some())
            && sonar.is_some_and(|sonar| sonar.left.is_some() || sonar.right.is_some())
    })));
    for (index, (first, others)) in noisy.iter().enumerate() {
        assert_eq!(others, &exact[index].1);
        assert_eq!(others, &truth[index].1);
        assert_ne!(first, &exact[index].0);
    }
}

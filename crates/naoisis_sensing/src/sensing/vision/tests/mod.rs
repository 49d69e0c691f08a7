//! The vision compared with hand-computed positions.

mod errors;
mod unrecognised;

use super::*;
use crate::sensing::sonar::SonarSettings;
use crate::sensing::testing::{sense, sensing_app, set, spawn_ball, spawn_post, spawn_robot};
use approx::assert_abs_diff_eq;
use naoisis_core::camera_model::CameraName;
use naoisis_core::geometry::{to_radians, unit, wrap_angle};
use naoisis_core::pitch::{GoalColour, JunctionShape};
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::robot::motion::ExecutedStep;
use naoisis_core::team::Team;

const LEVEL: [f32; 2] = [0.0, 0.0];

/// The percept of a ball at this position, for a robot at the origin with this head.
fn ball_at(x: f32, y: f32, head_deg: [f32; 2]) -> Option<BallPercept> {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], head_deg);
    spawn_ball(&mut app, x, y);
    sense::<Percepts>(&mut app, robot).ball
}

#[track_caller]
fn assert_place(actual: Vec2, x: f32, y: f32) {
    assert_abs_diff_eq!(actual, Vec2::new(x, y), epsilon = 2e-4);
}

#[test]
fn a_ball_ahead_is_seen_where_it_is() {
    // Centre 3 cm above the ground: 360.81 (0.5372 - 0.03) / 2 = 91.50 px below the middle, at 2 m from the lens.
    let ball = ball_at(2.0539, 0.0, LEVEL).unwrap();
    assert_eq!(ball.camera, CameraName::TOP);
    assert_abs_diff_eq!(ball.pixel, Vec2::new(160.0, 211.50), epsilon = 0.01);
    assert_place(ball.position_m, 2.0539, 0.0);
    // Near, in the lower camera: from its lens 0.5512 ahead and 0.4409 down; in the camera's frame
    // 0.5512 cos 40 + 0.4409 sin 40 = 0.70565 ahead and 0.4409 cos 40 - 0.5512 sin 40 = -0.01655 down: v = 120 - 8.46.
    let ball = ball_at(0.6, 0.1, LEVEL).unwrap();
    assert_eq!(ball.camera, CameraName::BOTTOM);
    // 0.1 m to the left: 360.81 * 0.1 / 0.70565 = 51.13 px.
    assert_abs_diff_eq!(ball.pixel, Vec2::new(160.0 - 51.13, 111.54), epsilon = 0.01);
    assert_place(ball.position_m, 0.6, 0.1);
    // atan(0.1 / 0.6) = 9.462°.
    assert_abs_diff_eq!(ball.bearing(), to_radians(9.462), epsilon = 1e-4);
}

#[test]
fn a_ball_is_seen_while_most_of_it_is_in_an_image() {
    // The upper camera's lower edge looks 18.396° down: at the height of the centre (0.5072 m below the lens) it ends
    // at x = 0.0539 + 0.5072 / 0.33259 = 1.5789.
    assert_eq!(ball_at(1.60, 0.0, LEVEL).unwrap().camera, CameraName::TOP);
    assert_eq!(ball_at(1.56, 0.0, LEVEL), None);
    // The lower camera's upper edge looks 21.604° down: x = 0.0488 + 0.4409 / 0.39602 = 1.1621.
    assert_eq!(ball_at(1.15, 0.0, LEVEL).unwrap().camera, CameraName::BOTTOM);
    assert_eq!(ball_at(1.18, 0.0, LEVEL), None);
    // To the side: 160 / 360.81 of the depth, 2 m: 0.8869 m.
    assert!(ball_at(2.0539, 0.880, LEVEL).is_some() && ball_at(2.0539, -0.880, LEVEL).is_some());
    assert!(ball_at(2.0539, 0.895, LEVEL).is_none() && ball_at(2.0539, -0.895, LEVEL).is_none());
    // Behind the robot.
    assert_eq!(ball_at(-2.0, 0.0, LEVEL), None);
}

#[test]
fn turning_the_head_brings_a_ball_into_view_and_leaves_its_place() {
    let at = |degrees: f32| 1.0 * unit(to_radians(degrees));
    for (bearing, head) in
        [(100.0, [100.0, 10.0]), (-120.0, [-110.0, 20.0]), (0.0, [10.0, -15.0]), (35.0, [20.0, 25.0])]
    {
        let place = at(bearing);
        let ball = ball_at(place.x, place.y, head).unwrap();
        assert_place(ball.position_m, place.x, place.y);
    }
    assert_eq!(ball_at(at(100.0).x, at(100.0).y, LEVEL), None);
}

#[test]
fn a_robots_percepts_are_in_its_own_frame() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [1.0, -1.0, 90.0], LEVEL);
    // 2 m ahead and 0.3 m to the left of a robot at (1, -1) that faces +y.
    spawn_ball(&mut app, 0.7, 1.0);
    assert_place(sense::<Percepts>(&mut app, robot).ball.unwrap().position_m, 2.0, 0.3);
}

#[test]
fn a_ball_behind_a_robot_is_hidden_until_most_of_it_sticks_out() {
    // The robot at 1 m that faces this one hides, at x = 3 and on the ground, |y| < 0.4932 (see the test of the occlusion).
    let seen_at = |y: f32| {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
        spawn_robot(&mut app, Team::Pink, 1, [1.0, 0.0, 180.0], LEVEL);
        spawn_ball(&mut app, 3.0, y);
        sense::<Percepts>(&mut app, robot).ball.is_some()
    };
    assert!(!seen_at(0.0) && !seen_at(0.48) && !seen_at(-0.48));
    assert!(seen_at(0.51) && seen_at(-0.51));
}

#[test]
fn goal_posts_have_their_colour_and_extra_posts_are_none() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    spawn_post(&mut app, 2.975, 0.7, Some(GoalColour::Yellow));
    spawn_post(&mut app, 2.975, -0.7, Some(GoalColour::Yellow));
    spawn_post(&mut app, -2.975, 0.7, Some(GoalColour::Blue));
    spawn_post(&mut app, 2.0, 0.0, None);
    let Percepts { goal_posts, robots, .. } = sense(&mut app, robot);
    let [left, right] = goal_posts[..] else { panic!("{goal_posts:?}") };
    assert!(left.colour == GoalColour::Yellow && right.colour == GoalColour::Yellow && robots.is_empty());
    assert_place(left.position_m, 2.975, 0.7);
    assert_place(right.position_m, 2.975, -0.7);
    // Its foot: 2.9211 m from the lens, u = 160 - 360.81 * 0.7 / 2.9211 = 73.54, v = 120 + 360.81 * 0.5372 / 2.9211.
    assert_abs_diff_eq!(left.pixel, Vec2::new(73.54, 186.35), epsilon = 0.01);
}

#[test]
fn a_post_between_the_cameras_is_located_by_its_top_and_a_near_one_by_its_width() {
    let goal_post = |x: f32, head_deg: [f32; 2]| {
        let mut app = sensing_app();
        let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], head_deg);
        spawn_post(&mut app, x, 0.1, Some(GoalColour::Blue));
        sense::<Percepts>(&mut app, robot).goal_posts.first().copied()
    };
    // At 1.4 m the ground is between the two images, but the top is at (0.8 - 0.5372) / 1.3461 = 11.05° in the upper.
    let by_top = goal_post(1.4, LEVEL).unwrap();
    assert_place(by_top.position_m, 1.4, 0.1);
    assert!(by_top.camera == CameraName::TOP && by_top.pixel.y > 240.0);
    // At 0.32 m the upper camera sees it from 0.449 to 0.626 m, and neither its top nor its foot is in view.
    assert_eq!(goal_post(0.32, LEVEL), None, "one of five points in each is not enough");
    // With the head 10° up, the lower camera sees about 0.15 to 0.41 m of it: two points, neither of them an end.
    let by_width = goal_post(0.33, [0.0, -10.0]).unwrap();
    assert_place(by_width.position_m, 0.33, 0.1);
    assert!(by_width.camera == CameraName::BOTTOM && by_width.pixel.y > 240.0);
}

#[test]
fn robots_have_the_team_of_their_waistband() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    spawn_robot(&mut app, Team::Blue, 2, [2.5, 0.8, 0.0], LEVEL);
    let pink = spawn_robot(&mut app, Team::Pink, 1, [2.0, -0.5, 45.0], LEVEL);
    let Percepts { robots, .. } = sense(&mut app, robot);
    let [left, right] = robots[..] else { panic!("{robots:?}") };
    assert!(left.team == Team::Blue && right.team == Team::Pink);
    assert_place(left.position_m, 2.5, 0.8);
    assert_place(right.position_m, 2.0, -0.5);
    // Its foot: 1.9461 m ahead of the lens, u = 160 + 360.81 * 0.5 / 1.9461, v = 120 + 360.81 * 0.5372 / 1.9461.
    assert_abs_diff_eq!(right.pixel, Vec2::new(252.70, 219.60), epsilon = 0.01);
    // At 1.4 m its feet are between the images; the waistband tells the place, and the pixel is below the upper image.
    set(&mut app, pink, Pose::new(1.4, -0.3, 0.0));
    let percepts = sense::<Percepts>(&mut app, robot);
    let near = percepts.robots.iter().find(|percept| percept.team == Team::Pink).unwrap();
    assert_place(near.position_m, 1.4, -0.3);
    assert!(near.camera == CameraName::TOP && near.pixel.y > 240.0);
    // At 1 m the upper camera sees the waistband and the lower one the feet.
    set(&mut app, pink, Pose::new(1.0, 0.0, 0.0));
    let percepts = sense::<Percepts>(&mut app, robot);
    let near = percepts.robots.iter().find(|percept| percept.team == Team::Pink).unwrap();
    assert_eq!(near.camera, CameraName::BOTTOM);
    assert_place(near.position_m, 1.0, 0.0);
}

#[test]
fn a_robot_behind_another_is_hidden() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    spawn_robot(&mut app, Team::Pink, 1, [1.5, 0.0, 180.0], LEVEL);
    let hidden = spawn_robot(&mut app, Team::Pink, 2, [2.5, 0.0, 180.0], LEVEL);
    assert_eq!(sense::<Percepts>(&mut app, robot).robots.len(), 1);
    set(&mut app, hidden, Pose::new(2.5, 0.4, core::f32::consts::PI));
    assert_eq!(sense::<Percepts>(&mut app, robot).robots.len(), 2);
}

#[test]
fn the_markings_ahead_are_seen() {
    let mut app = sensing_app();
    // On the halfway line's left end, looking along it to the circle and beyond: at (0, 2), facing -y.
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 2.0, -90.0], LEVEL);
    let Percepts { landmarks, .. } = sense(&mut app, robot);
    let of = |shape| {
        landmarks
            .iter()
            .filter(move |percept| percept.kind == LandmarkKind::Junction { shape })
            .map(|percept| percept.position_m)
            .collect::<Vec<_>>()
    };
    // The halfway line meets the far side line 4 m ahead (T), and crosses the circle 2.6 m ahead; the crossing at
    // 1.4 m is between the images.
    let [far_side] = of(JunctionShape::T)[..] else { panic!("{landmarks:?}") };
    assert_place(far_side, 4.0, 0.0);
    let [crossing] = of(JunctionShape::X)[..] else { panic!("{landmarks:?}") };
    assert_place(crossing, 2.6, 0.0);
    assert!(of(JunctionShape::L).is_empty());
    let circle = landmarks.iter().find(|percept| percept.kind == LandmarkKind::CentreCircle).unwrap();
    assert_place(circle.position_m, 2.0, 0.0);
    // The halfway line, in the upper image from 1.669 m to its end, in the lower from 0.339 to 1.238 m.
    let stretches: Vec<(CameraName, f32, f32)> = landmarks
        .iter()
        .filter_map(|percept| match percept.kind {
            LandmarkKind::Line { end_position_m: end, .. } if percept.position_m.y.abs().max(end.y.abs()) < 1e-3 => {
                let (near, far) = (percept.position_m.x.min(end.x), percept.position_m.x.max(end.x));
                Some((percept.camera, near, far))
            }
            _ => None,
        })
        .collect();
    let [(CameraName::TOP, near, far), (CameraName::BOTTOM, nearest, less_near)] = stretches[..] else {
        panic!("{stretches:?}")
    };
    for (actual, expected) in [(near, 1.669), (far, 4.0), (nearest, 0.339), (less_near, 1.238)] {
        assert_abs_diff_eq!(actual, expected, epsilon = 1e-3);
    }
    // The far side line: its right half's end to the left end in the image, 4 m ahead, ± 160/360.81 * 3.9461 m.
    let side_line = landmarks
        .iter()
        .find_map(|percept| match percept.kind {
            LandmarkKind::Line { end_position_m, .. } if (percept.position_m.x - 4.0).abs() < 1e-3 => {
                Some((percept.position_m, end_position_m))
            }
            _ => None,
        })
        .unwrap();
    assert_abs_diff_eq!(side_line.0, Vec2::new(4.0, 1.7499), epsilon = 2e-3);
    assert_abs_diff_eq!(side_line.1, Vec2::new(4.0, -1.7499), epsilon = 2e-3);
}

#[test]
fn penalty_crosses_and_corners_are_seen() {
    let mut app = sensing_app();
    // In front of the yellow goal's right corner: the corner (3, -2) is 2.5 m ahead, the cross (1.2, 0) 0.7 m ahead
    // and 2 m to the left, out of view.
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.5, -2.0, 0.0], LEVEL);
    let Percepts { landmarks, .. } = sense(&mut app, robot);
    let corners: Vec<Vec2> = landmarks
        .iter()
        .filter(|percept| percept.kind == LandmarkKind::Junction { shape: JunctionShape::L })
        .map(|percept| percept.position_m)
        .collect();
    // The penalty area's corner (2.4, -1.1) is 1.9 m ahead and 0.9 to the left: outside 160 / 360.81 = 0.4434.
    assert_eq!(corners.len(), 1);
    assert_place(corners[0], 2.5, 0.0);
    set(&mut app, robot, HeadAngles { yaw: to_radians(65.0), pitch: 0.0 });
    let Percepts { landmarks, .. } = sense(&mut app, robot);
    let cross = landmarks.iter().find(|percept| percept.kind == LandmarkKind::PenaltyCross).unwrap();
    assert_place(cross.position_m, 0.7, 2.0);
}

#[test]
fn truth_is_everything_wherever_the_robot_looks() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    set(&mut app, robot, VisionSettings { source: VisionSource::Truth, ..default() });
    spawn_robot(&mut app, Team::Pink, 1, [-1.0, 0.5, 0.0], LEVEL);
    spawn_post(&mut app, -2.975, 0.7, Some(GoalColour::Blue));
    spawn_ball(&mut app, -2.0, 0.0);
    let percepts = sense::<Percepts>(&mut app, robot);
    assert_eq!(percepts.ball.unwrap().position_m, Vec2::new(-2.0, 0.0));
    assert_eq!(percepts.robots[0].position_m, Vec2::new(-1.0, 0.5));
    assert_eq!(percepts.goal_posts[0].position_m, Vec2::new(-2.975, 0.7));
    // 11 lines, 16 junctions, 2 crosses, 1 circle.
    assert_eq!(percepts.landmarks.len(), 30);
    assert!(percepts.landmarks.iter().all(|percept| percept.pixel.is_finite()));
}

#[test]
fn a_robot_without_eyes_costs_and_draws_nothing() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    app.world_mut().entity_mut(robot).remove::<(VisionSettings, Percepts, SonarSettings, ExecutedStep)>();
    let before = app.world().get::<RandomStreams>(robot).unwrap().clone();
    assert_eq!(sense::<RandomStreams>(&mut app, robot), before);
}

#[test]
fn points_lie_on_lines_and_on_the_edge_of_the_carpet() {
    let mut app = sensing_app();
    // From the halfway line towards the far goal, 4.5 m from the edge of the carpet.
    let robot = spawn_robot(&mut app, Team::Blue, 1, [-1.0, 0.3, 20.0], [0.0, 5.0]);
    let exact = VisionSettings { noise: VisionNoise::none(), ..default() };
    set(&mut app, robot, exact.clone());
    let without = sense::<Percepts>(&mut app, robot);
    assert!(without.line_points.is_empty() && without.border_points.is_empty());
    set(&mut app, robot, VisionSettings { points: true, ..exact });
    let Percepts { line_points, border_points, landmarks, .. } = sense(&mut app, robot);
    assert_eq!(landmarks, without.landmarks);
    assert!(line_points.len() > 10 && border_points.len() > 10, "{} {}", line_points.len(), border_points.len());
    let pose = Pose::new(-1.0, 0.3, to_radians(20.0));
    let scene = app.world().resource::<Scene>();
    let distance_to = |point: Vec2, [start, end]: [Vec2; 2]| {
        let share = (point - start).dot(end - start) / (end - start).length_squared();
        point.distance(start.lerp(end, share.clamp(0.0, 1.0)))
    };
    for point in &line_points {
        let place = pose.transform_point(point.position_m);
        let lines = scene.markings.lines.iter().map(|line| distance_to(place, [line.start, line.end]));
        assert!(lines.fold(f32::INFINITY, f32::min) < 5e-3, "{place}");
    }
    let half = scene.pitch.carpet_half_extents();
    for point in &border_points {
        let beyond = pose.transform_point(point.position_m).abs() - half;
        assert!(beyond.max_element().abs() < 0.02, "{beyond}");
    }
}

#[test]
fn the_confidence_tells_true_balls_from_false_ones() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    let ball = ClassNoise { miss_probability: 0.2, false_positive_probability: 1.0, ..default() };
    let noise = VisionNoise { ball, confidence: true, ..VisionNoise::none() };
    set(&mut app, robot, VisionSettings { noise, ..default() });
    spawn_ball(&mut app, 2.0, 0.0);
    let mut found = [0; 2];
    for _ in 0..500 {
        let Percepts { ball, landmarks, .. } = sense(&mut app, robot);
        assert!(landmarks.iter().all(|landmark| landmark.confidence.is_some()));
        let Some(ball) = ball else { continue };
        let is_true = ball.position_m.distance(Vec2::new(2.0, 0.0)) < 1e-3;
        // A ball in view is detected with 80 %.
        assert_eq!(is_true, ball.confidence.unwrap() >= 0.8, "{ball:?}");
        found[usize::from(is_true)] += 1;
    }
    assert!(found.iter().all(|count| *count > 50), "{found:?}");
}

#[test]
fn the_colour_of_a_jersey_is_seen_as_far_and_as_well_as_asked_for() {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], LEVEL);
    let other = spawn_robot(&mut app, Team::Pink, 1, [2.0, 0.0, 0.0], LEVEL);
    set(&mut app, other, Body { jersey: Some(Jersey::Team), ..default() });
    assert_eq!(sense::<Percepts>(&mut app, robot).robots[0].colour, None);
    let with = |app: &mut App, colour_m: f32, colour_error: f32, false_positive_probability: f32| {
        let jerseys = JerseyVision { colour_m, colour_error, ..default() };
        let robots = ClassNoise { false_positive_probability, ..default() };
        let noise = VisionNoise { jerseys, robots, ..VisionNoise::none() };
        set(app, robot, VisionSettings { noise, ..default() });
        sense::<Percepts>(app, robot).robots.into_iter().map(|seen| seen.colour).collect::<Vec<_>>()
    };
    assert_eq!(with(&mut app, 3.0, 0.0, 0.0), [Some(Jersey::Red)]);
    assert_eq!(with(&mut app, 1.5, 0.0, 0.0), [None]);
    let mistaken = (0..200).filter(|_| with(&mut app, 3.0, 1.0, 0.0) != [Some(Jersey::Red)]).count();
    // Nine of ten: 180, and four standard deviations are 17.
    assert!((163..=197).contains(&mistaken), "{mistaken}");
    // A robot that is not there wears the jersey of its team, and so does not give itself away.
    set(&mut app, robot, Body { jersey: Some(Jersey::Purple), ..default() });
    let colours: Vec<Option<Jersey>> = (0..50).flat_map(|_| with(&mut app, 100.0, 0.0, 1.0)).collect();
    assert!(colours.len() > 80 && colours.iter().all(Option::is_some), "{colours:?}");
}

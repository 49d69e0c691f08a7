use super::*;
use crate::appearance::robot::RobotDesign;
use crate::appearance::scene::{Scene, SceneBall, SceneRobot};
use crate::appearance::view::View;
use crate::sensing::camera::CameraSettings;
use crate::sensing::camera::image::Layers;
use crate::sensing::camera::software::{Detail, PreparedScene, Renderer};
use crate::sensing::vision::LandmarkKind;
use naoisis_core::ball::BallLook;
use naoisis_core::geometry::{Pose, to_radians};
use naoisis_core::pitch::JunctionShape;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::{RobotId, Team};

mod random_scenes;

/// The detections of a robot at `[x m, y m, heading deg]`, which looks straight ahead and `pitch_deg` down, in the image of one of its
/// cameras. The scene is given in the pitch frame.
fn look(scene: &Scene, [x, y, heading]: [f32; 3], pitch_deg: f32, camera: CameraName) -> ImageDetections {
    look_knowing(scene, [x, y, heading], pitch_deg, camera, &ObjectModel::new(&scene.pitch, 0.03))
}

/// Like [`look`], for a robot with an object model.
fn look_knowing(
    scene: &Scene,
    [x, y, heading]: [f32; 3],
    pitch_deg: f32,
    camera: CameraName,
    model: &ObjectModel,
) -> ImageDetections {
    let pose = Pose::new(x, y, to_radians(heading));
    let head = HeadAngles { yaw: 0.0, pitch: to_radians(pitch_deg) };
    let body = Body::default();
    let camera_view = CameraSettings::default().view(camera, &body, head).unwrap();
    let own = SceneRobot::standing(RobotId::new(Team::Blue, 1), pose, body);
    let mut prepared = PreparedScene::default();
    prepared.prepare(scene, Detail::default());
    let mut image = Image::default();
    let view = View::of_robot(&camera_view, own.world_from_robot(), own.id);
    Renderer::default().draw(&prepared, &view, Layers::default(), &mut image);
    let mut detections = ImageDetections::default();
    ImageVision::default().recognise(&image, camera, &camera_view, model, &mut detections);
    detections
}

fn pitch() -> Scene {
    Scene::empty(Pitch::default())
}

fn robot(team: Team, number: u8, x: f32, y: f32, heading: f32) -> SceneRobot {
    SceneRobot::standing(RobotId::new(team, number), Pose::new(x, y, heading), Body::default())
}

#[test]
fn the_ball_is_found_where_it_is() {
    for (place, pitch_deg, camera) in [
        (Vec2::new(2.0, 0.3), 0.0, CameraName::TOP),
        (Vec2::new(0.8, -0.2), 0.0, CameraName::BOTTOM),
        (Vec2::new(0.2, 0.05), 25.0, CameraName::BOTTOM),
    ] {
        let scene = Scene { ball: Some(SceneBall::on_ground(place, 0.03)), ..pitch() };
        let (pixels, ball) = look(&scene, [0.0, 0.0, 0.0], pitch_deg, camera).ball.unwrap();
        assert!(ball.position_m.distance(place) < 0.02 * place.length(), "{place}: {ball:?}");
        // The disc's area: pi (f r / d)².
        assert!(pixels as f32 > 2.0 * (361.0 * 0.03 / (place.length() + 0.5)).powi(2), "{pixels}");
    }
}

#[test]
fn half_a_ball_at_the_edge_of_the_image_is_still_found_where_it_is() {
    // Looking ahead, the lower camera's image ends at x = 0.339 m on the ground (half of 36.8° and 40° below the horizon).
    let place = Vec2::new(0.345, 0.0);
    let scene = Scene { ball: Some(SceneBall::on_ground(place, 0.03)), ..pitch() };
    let (_, ball) = look(&scene, [0.0, 0.0, 0.0], 0.0, CameraName::BOTTOM).ball.unwrap();
    assert!(ball.position_m.distance(place) < 0.02, "{ball:?}");
}

#[test]
fn an_orange_thing_of_the_wrong_size_is_no_ball() {
    let scene = Scene { ball: Some(SceneBall::on_ground(Vec2::new(1.9, 0.0), 0.15)), ..pitch() };
    assert_eq!(look(&scene, [0.0, 0.0, 0.0], 0.0, CameraName::TOP).ball, None);
    assert_eq!(look(&pitch(), [0.0, 0.0, 0.0], 0.0, CameraName::TOP).ball, None);
}

/// A pitch with white goals, a football at `ball` and the object model for it.
fn with_football(ball: Option<Vec2>) -> (Scene, ObjectModel) {
    let look = BallLook::Pentagons;
    let ball = ball.map(|place| SceneBall { look, ..SceneBall::on_ground(place, 0.05) });
    let scene = Scene { ball, ..white_goals() };
    let model = ObjectModel { ball_look: look, ..ObjectModel::new(&scene.pitch, 0.05) };
    (scene, model)
}

#[test]
fn a_black_and_white_ball_is_found_where_it_is_on_carpet_and_on_lines() {
    // The goal area's line is at x = 2.4 m, the centre circle's at 0.6 m.
    for (place, pitch_deg, camera) in [
        (Vec2::new(2.0, 0.3), 0.0, CameraName::TOP),
        (Vec2::new(2.4, -0.2), 0.0, CameraName::TOP),
        (Vec2::new(3.0, 0.4), 0.0, CameraName::TOP),
        (Vec2::new(0.8, -0.2), 0.0, CameraName::BOTTOM),
        (Vec2::new(0.6, 0.0), 0.0, CameraName::BOTTOM),
        (Vec2::new(0.25, 0.05), 25.0, CameraName::BOTTOM),
        (Vec2::new(0.355, 0.0), 0.0, CameraName::BOTTOM),
    ] {
        let (scene, model) = with_football(Some(place));
        let ball = look_knowing(&scene, [0.0, 0.0, 0.0], pitch_deg, camera, &model).ball;
        let (_, ball) = ball.unwrap_or_else(|| panic!("{place}"));
        assert!(ball.position_m.distance(place) < 0.03 * (1.0 + place.length()), "{place}: {ball:?}");
    }
}

#[test]
fn marks_posts_and_robots_are_no_black_and_white_ball() {
    let (mut scene, model) = with_football(None);
    scene.robots = vec![
        robot(Team::Pink, 1, 1.2, 0.2, 3.0),
        robot(Team::Blue, 2, 2.5, -0.6, 1.0),
        robot(Team::Blue, 3, -0.4, 0.6, -1.0),
        robot(Team::Pink, 2, -1.0, -0.6, 0.3),
    ];
    for (x, y) in [(0.0, 0.0), (-2.0, 0.0), (0.5, -1.5), (1.5, 1.0)] {
        for heading in (0..12).map(|step| 30.0 * step as f32) {
            for (pitch_deg, camera) in [(0.0, CameraName::TOP), (15.0, CameraName::TOP), (0.0, CameraName::BOTTOM)] {
                let ball = look_knowing(&scene, [x, y, heading], pitch_deg, camera, &model).ball;
                assert_eq!(ball, None, "{x} {y} {heading} {pitch_deg}");
            }
        }
    }
}

#[test]
fn robots_in_jerseys_of_all_colours_but_green_are_found() {
    let of = |jersey| Body { jersey: Some(jersey), ..Body::default() };
    for (jersey, is_seen) in [
        (Jersey::Team, true),
        (Jersey::Red, true),
        (Jersey::Yellow, true),
        (Jersey::Purple, true),
        (Jersey::Orange, true),
        (Jersey::Black, true),
        (Jersey::White, true),
        (Jersey::Grey, true),
        (Jersey::Brown, true),
        (Jersey::Green, false),
    ] {
        let mut scene = white_goals();
        let id = RobotId::new(Team::Pink, 4);
        scene.robots = vec![SceneRobot::standing(id, Pose::new(1.6, 0.2, 3.0), of(jersey))];
        let (pink, blue) = (of(jersey), of(Jersey::Blue));
        let model = ObjectModel::new(&scene.pitch, 0.05).with_robots([(Team::Pink, &pink), (Team::Blue, &blue)]);
        let model = ObjectModel { ball_look: BallLook::Pentagons, ..model };
        let robots = look_knowing(&scene, [0.0, 0.0, 0.0], -5.0, CameraName::TOP, &model).robots;
        assert_eq!(robots.len(), usize::from(is_seen), "{jersey:?}: {robots:?}");
        for (_, robot) in robots {
            // Where the feet are below the image, a body's distance is less certain.
            let is_band = !matches!(jersey, Jersey::Black | Jersey::White | Jersey::Grey | Jersey::Brown);
            let (place, tolerance_m) = (Vec2::new(1.6, 0.2), if is_band { 0.1 } else { 0.35 });
            let aside_m = robot.position_m.normalize_or(Vec2::X).perp_dot(place).abs();
            let is_near = robot.position_m.distance(place) < tolerance_m && aside_m < 0.05;
            assert!(robot.team == Team::Pink && is_near, "{jersey:?}: {robot:?}");
        }
    }
}

#[test]
fn both_posts_of_a_goal_are_found_with_their_colour() {
    for (pose, colour) in [([0.5, 0.0, 0.0], GoalColour::Yellow), ([-0.5, 0.0, 180.0], GoalColour::Blue)] {
        let detections = look(&pitch(), pose, 0.0, CameraName::TOP);
        let mut posts: Vec<_> = detections.goal_posts.iter().map(|(_, post)| (post.position_m, post.colour)).collect();
        posts.sort_by(|a, b| a.0.y.total_cmp(&b.0.y));
        // They stand at x = 2.975 m.
        assert_eq!(posts.len(), 2, "{posts:?}");
        for ((place, seen), y) in posts.into_iter().zip([-0.7, 0.7]) {
            assert_eq!(seen, colour);
            assert!(place.distance(Vec2::new(2.475, y)) < 0.08, "{place}");
        }
    }
}

#[test]
fn a_post_without_a_foot_in_the_image_is_located_all_the_same() {
    // The upper camera sees the ground from 1.67 m on; the post is 1.05 m away.
    let detections = look(&pitch(), [2.0, -0.7, 0.0], 0.0, CameraName::TOP);
    let nearest =
        detections.goal_posts.iter().map(|(foot, post)| (*foot, post.position_m)).find(|(_, p)| p.y.abs() < 0.2);
    let (has_foot, place) = nearest.unwrap();
    assert!(!has_foot && place.distance(Vec2::new(0.975, 0.0)) < 0.06, "{place}");
}

#[test]
fn robots_are_found_by_their_waistbands_with_team_and_distance() {
    let mut scene = pitch();
    scene.robots = vec![robot(Team::Pink, 1, 1.2, 0.2, 3.0), robot(Team::Blue, 2, 2.5, -0.6, 1.0)];
    let mut robots = look(&scene, [0.0, 0.0, 0.0], 5.0, CameraName::TOP).robots;
    robots.sort_by(|a, b| a.1.position_m.x.total_cmp(&b.1.position_m.x));
    assert_eq!(robots.iter().map(|(_, robot)| robot.team).collect::<Vec<_>>(), [Team::Pink, Team::Blue]);
    for ((_, robot), place) in robots.iter().zip([Vec2::new(1.2, 0.2), Vec2::new(2.5, -0.6)]) {
        assert!(robot.position_m.distance(place) < 0.05 * place.length(), "{robot:?}");
    }
}

#[test]
fn robots_of_a_mixed_team_are_each_located_by_a_band_of_their_own_kind() {
    #[derive(serde::Deserialize)]
    struct Model {
        settings: Settings,
    }
    #[derive(serde::Deserialize)]
    struct Settings {
        body: Body,
    }
    let model: Model = ron::from_str(include_str!("../../../../../../assets/robots/booster_k1.ron")).unwrap();
    let k1 = model.settings.body;
    let nao = Body::default();
    // A vision that takes all robots for one kind locates them badly.
    let of_both = ObjectModel::new(&Pitch::default(), 0.03).with_robots([(Team::Pink, &nao), (Team::Pink, &k1)]);
    let (mut found, mut placed, mut placed_as_naos) = (0, 0, 0);
    let mut looked = 0;
    for distance in [1.3, 1.6, 2.0, 2.5, 3.0] {
        for (body, aside, heading) in [(nao, 0.3, 2.0), (k1, -0.3, 0.5), (k1, 0.2, 2.8), (nao, -0.2, -1.0)] {
            let place = Vec2::new(distance, aside);
            let mut scene = pitch();
            let id = RobotId::new(Team::Pink, 2);
            scene.robots = vec![SceneRobot::standing(id, Pose::new(place.x, place.y, heading), body)];
            // Whether the robot is found, and near its position, with a model of both kinds or of NAOs only.
            let near = |model: &ObjectModel| {
                let detections = look_knowing(&scene, [0.0, 0.0, 0.0], -8.0, CameraName::TOP, model).robots;
                assert!(detections.iter().all(|(_, robot)| robot.team == Team::Pink));
                let is_near = |place_m: Vec2| place_m.distance(place) < 0.15 * place.length();
                (!detections.is_empty(), detections.iter().any(|(_, robot)| is_near(robot.position_m)))
            };
            looked += 1;
            let (is_found, is_near) = near(&of_both);
            found += i32::from(is_found);
            placed += i32::from(is_near);
            placed_as_naos += i32::from(near(&ObjectModel::new(&Pitch::default(), 0.03)).1);
        }
    }
    assert!((looked, found, placed) == (20, 20, 20) && placed_as_naos <= 10, "{found} {placed} {placed_as_naos}");
}

#[test]
fn lines_corners_and_the_circle_are_found() {
    // From inside the pitch at the corner (3, 2): two lines that meet there.
    let detections = look(&pitch(), [1.5, 0.5, 45.0], 0.0, CameraName::TOP);
    let corner =
        detections.landmarks.iter().find(|mark| mark.kind == LandmarkKind::Junction { shape: JunctionShape::L });
    let place = corner.unwrap().position_m;
    assert!(place.distance(Vec2::new(1.5 * core::f32::consts::SQRT_2, 0.0)) < 0.06, "{place}");
    let lines = detections.landmarks.iter().filter(|mark| matches!(mark.kind, LandmarkKind::Line { .. })).count();
    assert!(lines >= 2);

    let detections = look(&pitch(), [-1.6, 0.3, 0.0], 5.0, CameraName::TOP);
    let circle = detections.landmarks.iter().find(|mark| mark.kind == LandmarkKind::CentreCircle).unwrap();
    assert!(circle.position_m.distance(Vec2::new(1.6, -0.3)) < 0.1, "{circle:?}");
}

/// The positions at which crosses are detected, robot frame.
fn crosses(detections: &ImageDetections) -> Vec<Vec2> {
    let marks = detections.landmarks.iter().filter(|mark| mark.kind == LandmarkKind::PenaltyCross);
    marks.map(|mark| mark.position_m).collect()
}

#[test]
fn a_penalty_cross_is_found_from_every_side() {
    // The cross is at (1.2, 0).
    for heading in [0.0f32, 20.0, 45.0, 90.0, 165.0, -120.0] {
        for (distance, pitch_deg, camera) in
            [(0.5, 10.0, CameraName::BOTTOM), (1.0, 0.0, CameraName::BOTTOM), (2.5, 0.0, CameraName::TOP)]
        {
            let place = Vec2::new(1.2, 0.0) - distance * Vec2::from_angle(heading.to_radians());
            let detections = look(&pitch(), [place.x, place.y, heading], pitch_deg, camera);
            let near: Vec<Vec2> = crosses(&detections).into_iter().filter(|cross| cross.x < distance + 0.5).collect();
            assert_eq!(near.len(), 1, "{heading} {distance}: {near:?}");
            assert!(
                near[0].distance(Vec2::new(distance, 0.0)) < 0.01 * (1.0 + distance),
                "{heading} {distance}: {near:?}"
            );
        }
    }
}

#[test]
fn neither_the_centre_mark_nor_pieces_of_lines_are_penalty_crosses() {
    for pose in [[-0.7, 0.0, 0.0], [0.0, 0.7, -90.0], [0.5, 0.5, -135.0], [1.5, 1.5, 45.0], [2.0, -1.5, 0.0]] {
        for (pitch_deg, camera) in [(0.0, CameraName::BOTTOM), (20.0, CameraName::TOP)] {
            let detections = look(&pitch(), pose, pitch_deg, camera);
            let in_pitch =
                |cross: Vec2| Vec2::new(pose[0], pose[1]) + Vec2::from_angle(pose[2].to_radians()).rotate(cross);
            let others = crosses(&detections).into_iter().map(in_pitch).filter(|cross| {
                cross.distance(Vec2::new(1.2, 0.0)) > 0.1 && cross.distance(Vec2::new(-1.2, 0.0)) > 0.1
            });
            assert_eq!(others.count(), 0, "{pose:?} {pitch_deg}");
        }
    }
}

fn white_goals() -> Scene {
    let mut white = Pitch::default();
    (white.goal.negative_x_colour, white.goal.positive_x_colour) = (GoalColour::White, GoalColour::White);
    Scene::empty(white)
}

#[test]
fn the_posts_of_white_goals_are_found_by_their_height() {
    let detections = look(&white_goals(), [0.5, 0.0, 0.0], -10.0, CameraName::TOP);
    let mut posts: Vec<_> = detections.goal_posts.iter().map(|(_, post)| (post.position_m, post.colour)).collect();
    posts.sort_by(|a, b| a.0.y.total_cmp(&b.0.y));
    assert_eq!(posts.len(), 2, "{posts:?}");
    for ((place, seen), y) in posts.into_iter().zip([-0.7, 0.7]) {
        assert_eq!(seen, GoalColour::White);
        assert!(place.distance(Vec2::new(2.475, y)) < 0.15, "{place}");
    }
}

#[test]
fn white_robots_are_no_posts_of_white_goals() {
    let mut scene = white_goals();
    scene.robots = (0..12u8)
        .map(|index| {
            robot(
                Team::BOTH[usize::from(index % 2)],
                2 + index / 2,
                0.6 + 0.3 * f32::from(index % 6),
                0.5 * (f32::from(index) - 5.5),
                f32::from(index),
            )
        })
        .collect();
    for heading in [0.0, 40.0, -40.0] {
        let detections = look(&scene, [-2.5, 0.0, heading], 0.0, CameraName::TOP);
        let false_posts: Vec<_> = detections.goal_posts.iter().filter(|(_, post)| post.position_m.x < 4.0).collect();
        assert!(false_posts.is_empty(), "{heading}: {false_posts:?}");
    }
}

#[test]
fn an_empty_image_has_nothing_in_it() {
    let camera = CameraSettings::default().view(CameraName::TOP, &Body::default(), HeadAngles::default()).unwrap();
    let mut detections = ImageDetections::default();
    let model = ObjectModel::new(&Pitch::default(), 0.03);
    ImageVision::default().recognise(&Image::default(), CameraName::TOP, &camera, &model, &mut detections);
    assert_eq!(detections, ImageDetections::default());
}

#[test]
fn a_field_without_robots_has_hardly_any_black_white_grey_or_brown_ones() {
    let body = |jersey| Body { jersey: Some(jersey), ..Body::default() };
    for [blue, pink] in [[Jersey::Black, Jersey::White], [Jersey::Grey, Jersey::Brown]] {
        let (scene, model) = with_football(Some(Vec2::new(0.6, 0.4)));
        let model = model.with_robots([(Team::Blue, &body(blue)), (Team::Pink, &body(pink))]);
        let (mut images, mut robots) = (0, 0);
        for (x, y) in [(0.0, 0.0), (-2.0, 0.0), (0.5, -1.5), (1.5, 1.0)] {
            for heading in (0..12).map(|step| 30.0 * step as f32) {
                for (pitch_deg, camera) in [(0.0, CameraName::TOP), (15.0, CameraName::TOP), (0.0, CameraName::BOTTOM)]
                {
                    images += 1;
                    robots += look_knowing(&scene, [x, y, heading], pitch_deg, camera, &model).robots.len();
                }
            }
        }
        // Pieces of white posts that show neither foot nor top.
        assert!(images == 144 && robots <= 7, "{blue:?} {pink:?}: {robots} in {images}");
    }
}

#[test]
fn points_of_lines_and_of_the_edge_of_the_carpet_are_found() {
    let scene = pitch();
    let pose = Pose::new(-1.0, 0.3, to_radians(20.0));
    let detections = look(&scene, [-1.0, 0.3, 20.0], 5.0, CameraName::TOP);
    let ImageDetections { line_points, border_points, .. } = detections;
    assert!(line_points.len() > 5 && border_points.len() > 10, "{} {}", line_points.len(), border_points.len());
    for point in &line_points {
        let place = pose.transform_point(point.position_m);
        let nearest = scene.markings.lines.iter().map(|line| {
            let along = (line.end - line.start).normalize_or_zero();
            (place - line.start).perp_dot(along).abs()
        });
        let error_m = nearest.fold(f32::INFINITY, f32::min);
        let is_on_circle = (place.length() - scene.pitch.centre_circle_diameter_m / 2.0).abs() < 0.1;
        assert!(error_m < 0.02 + 0.03 * point.position_m.length() || is_on_circle, "{place}: {error_m}");
    }
    let half = scene.pitch.carpet_half_extents();
    // Where a goal hides the edge, there is no point.
    for point in &border_points {
        let beyond = (pose.transform_point(point.position_m).abs() - half).max_element();
        assert!(beyond.abs() < 0.01 + 0.01 * point.position_m.length_squared(), "{point:?}: {beyond}");
    }
}

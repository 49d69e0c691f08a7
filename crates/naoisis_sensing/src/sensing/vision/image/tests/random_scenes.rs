//! What the image vision detects in random scenes.

use super::super::accuracy::{self, Conditions, EVERYWHERE_M};
use super::*;
use naoisis_core::random::RandomStream;
use naoisis_core::team::PerTeam;

#[test]
fn in_random_scenes_nearly_everything_visible_is_found_at_its_distance() {
    for design in RobotDesign::BOTH {
        let mut stream = RandomStream::for_match(7, "scenes of a test");
        let mut conditions = Conditions::default();
        conditions.cameras.design = design;
        let accuracy = accuracy::measure(250, &conditions, &mut stream);
        let classes = [&accuracy.ball, &accuracy.goal_posts, &accuracy.robots, &accuracy.penalty_crosses];
        // A white spot close beside a robot may be its arm: such crosses are left out.
        for (class, least) in classes.into_iter().zip([0.95, 0.95, 0.95, 0.8]) {
            assert!(class.found_share(EVERYWHERE_M) >= least, "{accuracy}");
            // Half of the directions are known to a degree.
            assert!(class.bearing_error(EVERYWHERE_M, 0.5) < to_radians(1.0), "{accuracy}");
            assert!(class.visible(EVERYWHERE_M).count() > 20, "{accuracy}");
            assert!(class.range_error([0.0, 2.0], 0.5) < 0.05, "{accuracy}");
        }
        // In 500 images: the parts of a waistband divided by a robot in front count as more than one.
        let false_detections = accuracy.ball.false_detections + accuracy.goal_posts.false_detections;
        let false_detections = false_detections + accuracy.penalty_crosses.false_detections;
        assert!(false_detections <= 2 && accuracy.robots.false_detections <= 10, "{accuracy}");
    }
}

#[test]
fn in_random_scenes_a_football_and_jerseys_are_found_as_well() {
    let mut stream = RandomStream::for_match(7, "scenes of a test");
    let jersey = Some(Jersey::Team);
    let conditions = Conditions {
        pitch: white_goals().pitch,
        ball_radius_m: 0.05,
        ball_look: BallLook::Pentagons,
        bodies: PerTeam::new(|_| Body { jersey, ..Body::default() }),
        ..Conditions::default()
    };
    let accuracy = accuracy::measure(250, &conditions, &mut stream);
    // On this small pitch, robots, lines and posts hide much of the outline of many balls.
    for (class, least) in [(&accuracy.ball, 0.87), (&accuracy.robots, 0.92)] {
        assert!(class.found_share(EVERYWHERE_M) >= least, "{accuracy}");
        assert!(class.bearing_error(EVERYWHERE_M, 0.5) < to_radians(1.0), "{accuracy}");
        assert!(class.range_error([0.0, 2.0], 0.5) < 0.05, "{accuracy}");
    }
    assert!(accuracy.ball.false_detections <= 2 && accuracy.robots.false_detections <= 10, "{accuracy}");
}

#[test]
fn in_random_scenes_jerseys_without_a_hue_are_found_as_bodies() {
    for (pair, least) in [([Jersey::Black, Jersey::White], 0.75), ([Jersey::Brown, Jersey::Grey], 0.6)] {
        let mut stream = RandomStream::for_match(7, "scenes of a test");
        let conditions = Conditions {
            pitch: white_goals().pitch,
            ball_radius_m: 0.05,
            ball_look: BallLook::Pentagons,
            bodies: PerTeam::new(|team| Body { jersey: Some(pair[team as usize]), ..Body::default() }),
            ..Conditions::default()
        };
        let accuracy = accuracy::measure(250, &conditions, &mut stream);
        assert!(accuracy.robots.found_share(EVERYWHERE_M) >= least, "{pair:?}: {accuracy}");
        assert!(accuracy.robots.bearing_error(EVERYWHERE_M, 0.5) < to_radians(1.0), "{pair:?}: {accuracy}");
        assert!(accuracy.robots.range_error([0.0, 2.0], 0.5) < 0.08, "{pair:?}: {accuracy}");
        // In 500 images.
        assert!(accuracy.robots.false_detections <= 35, "{pair:?}: {accuracy}");
        // Few people beside the pitch look like robots, although they wear the same colours.
        let conditions = Conditions { pitch: Pitch { people: 40, ..conditions.pitch }, ..conditions };
        let accuracy = accuracy::measure(250, &conditions, &mut RandomStream::for_match(7, "scenes of a test"));
        assert!(accuracy.robots.found_share(EVERYWHERE_M) >= least, "{pair:?}: {accuracy}");
        assert!(accuracy.robots.false_detections <= 80, "{pair:?}: {accuracy}");
    }
}

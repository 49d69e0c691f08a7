//! The detections of a robot of things that are not there.

use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_sensing::sensing::vision::{MissedObject, Percepts, SceneObject};

/// Numbers of balls, posts and robots.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Objects {
    /// Balls.
    pub balls: usize,
    /// Goal posts.
    pub posts: usize,
    /// Other robots.
    pub robots: usize,
}

impl Objects {
    /// Returns the objects that a robot may have detected. Robots that are off the pitch may have been there when it sensed.
    pub fn there(balls: usize, pitch: &Pitch, roster: &Roster) -> Objects {
        Objects { balls, posts: pitch.goal_posts().len(), robots: roster.len().saturating_sub(1) }
    }

    /// Returns the numbers of detections that are of nothing, at least: of the objects that are `there`, the robot detected no more than those
    /// that it did not miss. A vision that does not name its objects may have more false ones.
    pub fn false_ones(percepts: &Percepts, missed: &[MissedObject], there: Objects) -> Objects {
        let missed_of =
            |is_kind: fn(&SceneObject) -> bool| missed.iter().filter(|missed| is_kind(&missed.object)).count();
        let more = |seen: usize, there: usize, missed: usize| seen.saturating_sub(there.saturating_sub(missed));
        let is_ball = |object: &SceneObject| matches!(object, SceneObject::Ball(_));
        let is_post = |object: &SceneObject| matches!(object, SceneObject::GoalPost { .. });
        let is_robot = |object: &SceneObject| matches!(object, SceneObject::Robot(_));
        Objects {
            balls: more(percepts.all_balls().count(), there.balls, missed_of(is_ball)),
            posts: more(percepts.goal_posts.len(), there.posts, missed_of(is_post)),
            robots: more(percepts.robots.len(), there.robots, missed_of(is_robot)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec2;
    use naoisis_core::camera_model::CameraName;
    use naoisis_core::team::{RobotId, Team};
    use naoisis_sensing::sensing::vision::{BallPercept, RobotPercept, WhyMissed};

    #[test]
    fn detections_beyond_the_objects_that_were_not_missed_are_false() {
        let missed = |object| MissedObject { object, why: WhyMissed::OutsideImage };
        let robot = |number| missed(SceneObject::Robot(RobotId::new(Team::Pink, number)));
        let there = Objects { robots: 3, ..Objects::there(1, &Pitch::default(), &Roster::default()) };
        let robot_percept = RobotPercept::new(CameraName::TOP, Team::Pink, Vec2::ZERO, Vec2::X);
        let mut percepts = Percepts::default();
        percepts.ball = Some(BallPercept::new(CameraName::TOP, Vec2::ZERO, Vec2::X));
        percepts.robots = vec![robot_percept; 2];
        let of = |missed: &[MissedObject]| Objects::false_ones(&percepts, missed, there);
        assert_eq!(of(&[robot(1)]), Objects::default());
        assert_eq!(of(&[robot(1), robot(2)]), Objects { robots: 1, ..Objects::default() });
        assert_eq!(of(&[missed(SceneObject::Ball(0))]), Objects { balls: 1, ..Objects::default() });
        // A pitch has four posts, in a replay, too.
        assert_eq!(there.posts, 4);
    }
}

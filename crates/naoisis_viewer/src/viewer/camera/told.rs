//! Tells through whose camera the match is seen, in the uses without panels: nothing else names the robot.

use bevy::prelude::*;

use super::{CameraMode, ViewerCamera};
use crate::viewer::shared::{Notice, Selection};
use naoisis_core::camera_model::CameraName;
use naoisis_core::team::RobotId;

/// Names the robot when another one is followed or looked through.
pub(super) fn tell_robot(
    camera: Single<&ViewerCamera>,
    selection: Res<Selection>,
    mut last: Local<Option<Followed>>,
    mut notice: ResMut<Notice>,
) {
    let followed = Followed::of(camera.mode, selection.0);
    if followed != *last
        && let Some(followed) = followed
    {
        notice.tell(followed.words());
    }
    *last = followed;
}

/// A robot that the camera follows, or through whose camera the match is seen.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Followed {
    robot: RobotId,
    through: Option<CameraName>,
}

impl Followed {
    /// The robot in a mode of the camera.
    fn of(mode: CameraMode, selected: Option<RobotId>) -> Option<Self> {
        let through = match mode {
            CameraMode::Robot { .. } => None,
            CameraMode::RobotCamera(name) => Some(name),
            _ => return None,
        };
        Some(Followed { robot: selected?, through })
    }

    fn words(self) -> String {
        match self.through {
            None => format!("Behind {}", self.robot),
            // A robot with one camera shows the same through both keys.
            Some(_) => format!("Through a camera of {}", self.robot),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    #[test]
    fn a_robot_is_named_when_it_is_looked_through_or_followed() {
        let robot = RobotId::new(Team::Pink, 2);
        let words = |mode, robot| Followed::of(mode, robot).map(Followed::words);
        let eyes = CameraMode::RobotCamera(CameraName::TOP);
        assert_eq!(words(eyes, Some(robot)).as_deref(), Some("Through a camera of pink2"));
        assert_eq!(words(CameraMode::Robot { heading: 1.0 }, Some(robot)).as_deref(), Some("Behind pink2"));
        assert_eq!((words(CameraMode::Play, Some(robot)), words(eyes, None)), (None, None));
        // Turning is no reason to say it again.
        let turned = [1.0, 2.0].map(|heading| Followed::of(CameraMode::Robot { heading }, Some(robot)));
        assert_eq!(turned[0], turned[1]);
    }
}

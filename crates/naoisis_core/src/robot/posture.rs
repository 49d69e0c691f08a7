//! The posture of a robot: upright, fallen, getting up, diving. See [`falls`](super::falls) for what changes it.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::body::{Body, BodyBox};
use crate::geometry::Pose;
use crate::kick_geometry::Side;
use crate::knowledge::Knowledge;

/// A motion of the whole body.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PostureRequest {
    /// Getting up from a fall or dive.
    GetUp,
    /// A dive to a side; the robot lies afterwards.
    Dive(Side),
}

/// The request of this cycle, if any. Reset to `None` after every cycle.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct PostureCommand(pub Option<PostureRequest>);

/// The side of the body on which a fallen robot lies.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LyingOn {
    /// Face down.
    #[default]
    Front,
    /// Face up.
    Back,
}

/// The posture of a robot.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub enum Posture {
    /// On its feet.
    #[default]
    Upright,
    /// Lying on the ground.
    Fallen {
        /// Cycles since it fell.
        cycles: u64,
        /// The side of the body that is down.
        on: LyingOn,
    },
    /// Getting up.
    GettingUp {
        /// The side of the body that was down.
        on: LyingOn,
        /// Cycles since it fell.
        cycles: u64,
        /// Cycles until it stands.
        cycles_left: u64,
    },
    /// Diving.
    Diving {
        /// The side.
        side: Side,
        /// Cycles until it lies.
        cycles_left: u64,
        /// Whether the body is down and blocks the ball. It does not if it came down on the ball.
        blocks: bool,
    },
}

/// Rear and front of the strip that a dive blocks, robot frame, m: its thickness is that of a lying body.
fn strip_x_m(body: &Body) -> [f32; 2] {
    [-body.lying_height_m / 3.0, body.lying_height_m * 2.0 / 3.0]
}

impl Posture {
    /// Returns the name of the posture in tables and labels.
    pub const fn name(self) -> &'static str {
        match self {
            Posture::Upright => "upright",
            Posture::Fallen { .. } => "fallen",
            Posture::GettingUp { .. } => "getting_up",
            Posture::Diving { .. } => "diving",
        }
    }

    /// Whether the robot stands on its feet.
    pub fn is_upright(self) -> bool {
        self == Posture::Upright
    }

    /// The posture of a robot that has just fallen on the side `on`.
    pub fn fallen(on: LyingOn) -> Posture {
        Posture::Fallen { cycles: 0, on }
    }

    /// The side on which the robot lies, or lay before it began to get up. `None` if it is upright or dives.
    pub fn lying_on(self) -> Option<LyingOn> {
        match self {
            Posture::Fallen { on, .. } | Posture::GettingUp { on, .. } => Some(on),
            Posture::Upright | Posture::Diving { .. } => None,
        }
    }

    /// Whether the robot lies on the ground. A robot that gets up or dives does not.
    pub fn is_fallen(self) -> bool {
        matches!(self, Posture::Fallen { .. })
    }

    /// Cycles since the fall, if the robot lies or gets up.
    pub fn cycles_down(self) -> Option<u64> {
        match self {
            Posture::Fallen { cycles, .. } | Posture::GettingUp { cycles, .. } => Some(cycles),
            Posture::Upright | Posture::Diving { .. } => None,
        }
    }

    /// The strip in which a dive blocks the ball: the pose of its centre in the robot frame, and its box. `None` unless the robot dives and
    /// its dive blocks the ball.
    pub fn strip(self, body: &Body, reach_m: f32) -> Option<(Pose, BodyBox)> {
        match self {
            Posture::Diving { side, blocks: true, .. } => Some(dive_strip(side, body, reach_m)),
            _ => None,
        }
    }

    /// The posture one cycle later. `request` is the command to the robot, `None` if it may not act. A dive does not block before
    /// [`falls`](super::falls) lets the body come down.
    pub fn advance(self, request: Option<PostureRequest>, get_up_cycles: u64, dive_cycles: u64) -> Posture {
        match (self, request) {
            (Posture::Upright, Some(PostureRequest::Dive(side))) => {
                Posture::Diving { side, cycles_left: dive_cycles, blocks: false }
            }
            (Posture::Upright, _) => Posture::Upright,
            (Posture::Diving { cycles_left: 0, .. }, _) => Posture::Fallen { cycles: 1, on: LyingOn::Front },
            (Posture::Diving { side, cycles_left, blocks }, _) => {
                Posture::Diving { side, cycles_left: cycles_left - 1, blocks }
            }
            (Posture::Fallen { cycles, on }, Some(PostureRequest::GetUp)) => {
                Posture::GettingUp { on, cycles: cycles + 1, cycles_left: get_up_cycles }
            }
            (Posture::Fallen { cycles, on }, _) => Posture::Fallen { cycles: cycles + 1, on },
            (Posture::GettingUp { cycles_left: 0, .. }, _) => Posture::Upright,
            (Posture::GettingUp { on, cycles, cycles_left }, _) => {
                Posture::GettingUp { on, cycles: cycles + 1, cycles_left: cycles_left - 1 }
            }
        }
    }
}

/// The strip that a dive to `side` covers: the pose of its centre in the robot frame, and its box. It begins at the edge of the
/// base.
pub(super) fn dive_strip(side: Side, body: &Body, reach_m: f32) -> (Pose, BodyBox) {
    let sign = match side {
        Side::Left => 1.0,
        Side::Right => -1.0,
    };
    let middle = Pose::new(0.0, sign * (body.base.half_width_m + reach_m / 2.0), 0.0);
    (middle, BodyBox { x_m: strip_x_m(body), half_width_m: reach_m / 2.0, z_m: [0.0, body.lying_height_m] })
}

impl Body {
    /// The box of this body when the robot lies: as long as the robot is high, half of it before and half of it behind its place.
    pub fn lying_box(&self) -> BodyBox {
        let half_length_m = self.height_m / 2.0;
        let half_width_m = self.torso.half_width_m.max(self.base.half_width_m);
        BodyBox { x_m: [-half_length_m, half_length_m], half_width_m, z_m: [0.0, self.lying_height_m] }
    }

    /// This body in a posture: low and long if the robot lies, low if it dives, else unchanged.
    #[must_use]
    pub fn in_posture(self, posture: Posture) -> Body {
        let z_m = [0.0, self.lying_height_m];
        let (torso, base) = match posture {
            Posture::Upright | Posture::GettingUp { .. } => return self,
            Posture::Fallen { .. } => (self.lying_box(), self.lying_box()),
            Posture::Diving { .. } => (BodyBox { z_m, ..self.torso }, BodyBox { z_m, ..self.base }),
        };
        Body { torso, base, height_m: self.lying_height_m, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_fallen_robot_lies_until_it_is_told_to_get_up_which_takes_its_time() {
        let mut posture = Posture::fallen(LyingOn::Back);
        for _ in 0..10 {
            posture = posture.advance(None, 5, 3);
        }
        assert_eq!(posture, Posture::Fallen { cycles: 10, on: LyingOn::Back });
        posture = posture.advance(Some(PostureRequest::GetUp), 5, 3);
        let mut cycles = 0;
        while !posture.is_upright() {
            posture = posture.advance(None, 5, 3);
            cycles += 1;
        }
        // Five cycles of getting up; in the next cycle it stands.
        assert_eq!(cycles, 6);
    }

    #[test]
    fn a_dive_that_is_down_blocks_a_strip_on_its_side_and_ends_on_the_ground() {
        let mut posture = Posture::Upright.advance(Some(PostureRequest::Dive(Side::Right)), 5, 3);
        assert_eq!(posture.strip(&Body::default(), 0.5), None);
        let Posture::Diving { blocks, .. } = &mut posture else { panic!("{posture:?}") };
        *blocks = true;
        let (middle, strip) = posture.strip(&Body::default(), 0.5).unwrap();
        // From 10 cm to 60 cm to the right.
        assert_abs_diff_eq!(middle.position.y + strip.half_width_m, -0.1, epsilon = 1e-6);
        assert_abs_diff_eq!(middle.position.y - strip.half_width_m, -0.6, epsilon = 1e-6);
        for _ in 0..4 {
            posture = posture.advance(Some(PostureRequest::GetUp), 5, 3);
        }
        assert_eq!(
            (posture, posture.strip(&Body::default(), 0.5)),
            (Posture::Fallen { cycles: 1, on: LyingOn::Front }, None)
        );
    }

    #[test]
    fn a_lying_body_is_low_and_long_and_any_other_as_it_is_on_its_feet() {
        let tall = Body { height_m: 1.2, ..Body::default() };
        for body in [Body::default(), tall] {
            let lying = body.in_posture(Posture::fallen(LyingOn::Front));
            assert!(lying.height_m < 0.2 && lying.torso.z_m[1] < 0.2);
            assert_eq!((lying.torso.x_m[1] - lying.torso.x_m[0], lying.base.half_width_m), (body.height_m, 0.15));
            let dive = Posture::Diving { side: Side::Left, cycles_left: 3, blocks: true };
            assert_eq!(body.in_posture(dive).torso.x_m, body.torso.x_m);
            for posture in [Posture::Upright, Posture::GettingUp { on: LyingOn::Back, cycles: 9, cycles_left: 1 }] {
                assert_eq!(body.in_posture(posture), body);
            }
        }
    }
}

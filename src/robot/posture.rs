//! Falls, getting up, and a keeper's dives: what the paper leaves to future versions (section 4), coarsely. All of it
//! happens only where the rules have it switched on ([`Rules::falls`], [`Rules::dives`]).
//!
//! - When two robots collide, each may fall, with a probability that grows with the speed at which they met.
//! - A fallen robot lies where it stood: it is low, so others see over it and sonars do not hear it; it neither walks
//!   nor kicks; its cameras and sonars tell it nothing. It takes the same room on the ground as before.
//! - It gets up when it is told to, which takes its time.
//! - A dive blocks a strip beside the robot against the ball for a time. Then the robot lies, as after a fall.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::Roster;
use super::body::{BodyBounds, BodyBox};
use super::kick::KickPhase;
use crate::ball::{Ball, BallPhysics};
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CollisionPartner, CommandKind, CycleEvents, MatchEvent, Refusal};
use crate::game::{Game, GameState, Penalty, Rules};
use crate::geometry::Pose;
use crate::kick_geometry::Side;
use crate::knowledge::Knowledge;
use crate::random::RandomStreams;
use crate::state::ReflectState;
use crate::team::RobotId;

/// Takes posture commands in [`CycleSystems::Act`]; robots fall after the collisions, before the referee looks.
pub struct PosturePlugin;

impl Plugin for PosturePlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Posture>()
            .register_type::<PostureCommand>()
            .register_required_components::<RobotId, Posture>()
            .register_required_components::<RobotId, PostureCommand>()
            .add_systems(
                Cycle,
                (
                    take_posture_commands.in_set(ActSystems::Body),
                    fall.in_set(FallSystems).in_set(CycleSystems::Officiate),
                ),
            );
    }
}

/// The system in which robots fall; the referee looks after it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FallSystems;

/// What a robot does with its whole body, rather than with its legs.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum PostureRequest {
    /// Gets up from a fall or dive.
    GetUp,
    /// Dives to a side; the robot lies afterwards.
    Dive(Side),
}

/// The request of this cycle, if any. None again after every cycle.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(State, @Knowledge::Command)]
pub struct PostureCommand(pub Option<PostureRequest>);

/// How a robot's body is.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(State, @Knowledge::Truth)]
#[non_exhaustive]
pub enum Posture {
    /// On its feet.
    #[default]
    Upright,
    /// Lies.
    Fallen {
        /// Cycles since it fell.
        cycles: u64,
    },
    /// Gets up.
    GettingUp {
        /// Cycles since it fell.
        cycles: u64,
        /// Cycles until it stands.
        cycles_left: u64,
    },
    /// Dives.
    Diving {
        /// To which side.
        side: Side,
        /// Cycles until it lies.
        cycles_left: u64,
        /// Whether its body keeps the ball off: not if the ball was under it already.
        blocks: bool,
    },
}

/// Height of a lying body, m.
const LYING_HEIGHT_M: f32 = 0.15;
/// The strip that a dive blocks begins this far from the robot's middle, m: where its base ends.
const STRIP_START_M: f32 = 0.10;
/// Rear and front of the strip, robot frame, m.
const STRIP_X_M: [f32; 2] = [-0.05, 0.10];

impl Posture {
    /// Whether the robot stands on its feet.
    pub fn is_upright(self) -> bool {
        self == Posture::Upright
    }

    /// Cycles since it fell, if it lies or gets up.
    pub fn cycles_down(self) -> Option<u64> {
        match self {
            Posture::Fallen { cycles } | Posture::GettingUp { cycles, .. } => Some(cycles),
            Posture::Upright | Posture::Diving { .. } => None,
        }
    }

    /// The strip that a dive blocks against the ball: the pose of its middle in the robot frame, and its box.
    pub fn strip(self, reach_m: f32) -> Option<(Pose, BodyBox)> {
        match self {
            Posture::Diving { side, blocks: true, .. } => Some(dive_strip(side, reach_m)),
            _ => None,
        }
    }

    /// A cycle later. `request` is what the robot is told, if it may act.
    pub fn advance(self, request: Option<PostureRequest>, get_up_cycles: u64, dive_cycles: u64) -> Posture {
        match (self, request) {
            (Posture::Upright, Some(PostureRequest::Dive(side))) => {
                Posture::Diving { side, cycles_left: dive_cycles, blocks: true }
            }
            (Posture::Upright, _) => Posture::Upright,
            (Posture::Diving { cycles_left: 0, .. }, _) => Posture::Fallen { cycles: 1 },
            (Posture::Diving { side, cycles_left, blocks }, _) => {
                Posture::Diving { side, cycles_left: cycles_left - 1, blocks }
            }
            (Posture::Fallen { cycles }, Some(PostureRequest::GetUp)) => {
                Posture::GettingUp { cycles: cycles + 1, cycles_left: get_up_cycles }
            }
            (Posture::Fallen { cycles }, _) => Posture::Fallen { cycles: cycles + 1 },
            (Posture::GettingUp { cycles_left: 0, .. }, _) => Posture::Upright,
            (Posture::GettingUp { cycles, cycles_left }, _) => {
                Posture::GettingUp { cycles: cycles + 1, cycles_left: cycles_left - 1 }
            }
        }
    }
}

/// The strip that a dive to `side` covers: the pose of its middle in the robot frame, and its box.
fn dive_strip(side: Side, reach_m: f32) -> (Pose, BodyBox) {
    let sign = match side {
        Side::Left => 1.0,
        Side::Right => -1.0,
    };
    let middle = Pose::new(0.0, sign * (STRIP_START_M + reach_m / 2.0), 0.0);
    (middle, BodyBox { x_m: STRIP_X_M, half_width_m: reach_m / 2.0, z_m: [0.0, LYING_HEIGHT_M] })
}

impl BodyBounds {
    /// The room that this body takes in a posture: as it is on its feet, and low where it lies.
    #[must_use]
    pub fn in_posture(self, posture: Posture) -> BodyBounds {
        if !matches!(posture, Posture::Fallen { .. } | Posture::Diving { .. }) {
            return self;
        }
        let z_m = [0.0, LYING_HEIGHT_M];
        BodyBounds {
            torso: BodyBox { z_m, ..self.torso },
            base: BodyBox { z_m, ..self.base },
            height_m: LYING_HEIGHT_M,
        }
    }
}

/// The probability that a robot falls in a collision at `speed` m/s: none up to `least`, one from `certain` on, and
/// in proportion between.
pub fn fall_probability(speed: f32, least: f32, certain: f32) -> f32 {
    if speed <= least {
        0.0
    } else if speed >= certain {
        1.0
    } else {
        (speed - least) / (certain - least)
    }
}

fn take_posture_commands(
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    game: Res<Game>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<(&RobotId, &Pose, &Penalty, &KickPhase, &mut PostureCommand, &mut Posture), Without<Ball>>,
    balls: Query<(&Pose, &BallPhysics), (With<Ball>, Without<RobotId>)>,
) {
    let [get_up, dive] = [rules.get_up_s, rules.dive_s].map(|seconds| u64::from(clock.cycles_in(seconds)));
    for entity in roster.entities() {
        let Ok((id, pose, penalty, kick, mut command, mut posture)) = robots.get_mut(entity) else { continue };
        // Without a request nothing changes for who stands: the usual case.
        if command.0.is_none() && posture.is_upright() {
            continue;
        }
        let wanted = command.0.take();
        let may_dive =
            rules.dives && game.state == GameState::Playing && *kick == KickPhase::Ready && !penalty.is_active();
        let request = wanted.filter(|request| matches!(request, PostureRequest::GetUp) || may_dive);
        if wanted != request {
            let (robot, command) = (*id, CommandKind::Posture);
            events.push(MatchEvent::CommandRefused { robot, command, reason: Refusal::NotAllowed });
        }
        let mut next = posture.advance(request, get_up, dive);
        if let (Posture::Upright, Posture::Diving { side, blocks, .. }) = (*posture, &mut next) {
            events.push(MatchEvent::Dive { robot: *id, side: *side });
            let (middle, strip) = dive_strip(*side, rules.dive_reach_m);
            let strip = strip.footprint(pose.compose(middle));
            *blocks = balls.iter().all(|(ball, physics)| strip.overlap_disc(ball.position, physics.radius_m).is_none());
        }
        if matches!((*posture, next), (Posture::GettingUp { .. }, Posture::Upright)) {
            events.push(MatchEvent::GotUp { robot: *id });
        }
        *posture = next;
    }
}

/// Whoever collided may fall.
fn fall(
    mut collided: Local<Vec<(RobotId, f32)>>,
    roster: Res<Roster>,
    rules: Res<Rules>,
    mut events: ResMut<CycleEvents>,
    mut robots: Query<(&Penalty, &mut Posture, &mut KickPhase, &mut RandomStreams)>,
) {
    if !rules.falls {
        return;
    }
    collided.clear();
    for event in events.iter() {
        if let MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Robot(other), speed_mps, .. } = event
        {
            collided.extend([(*robot, *speed_mps), (*other, *speed_mps)]);
        }
    }
    for (robot, speed) in collided.drain(..) {
        let Some(entity) = roster.get(robot) else { continue };
        let Ok((penalty, mut posture, mut kick, mut streams)) = robots.get_mut(entity) else { continue };
        let probability = fall_probability(speed, rules.fall_from_mps, rules.fall_certain_mps);
        if !posture.is_upright() || penalty.is_active() || !streams.balance.chance(probability) {
            continue;
        }
        *posture = Posture::Fallen { cycles: 0 };
        *kick = KickPhase::Ready;
        events.push(MatchEvent::Fall { robot, speed_mps: speed, probability });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_probability_of_a_fall_grows_with_the_speed() {
        assert_eq!(fall_probability(0.1, 0.1, 0.5), 0.0);
        assert_abs_diff_eq!(fall_probability(0.3, 0.1, 0.5), 0.5, epsilon = 1e-6);
        assert_eq!(fall_probability(0.5, 0.1, 0.5), 1.0);
        // The same speed for both: a step.
        assert_eq!([fall_probability(0.2, 0.2, 0.2), fall_probability(0.21, 0.2, 0.2)], [0.0, 1.0]);
    }

    #[test]
    fn a_fallen_robot_lies_until_it_is_told_to_get_up_which_takes_its_time() {
        let mut posture = Posture::Fallen { cycles: 0 };
        for _ in 0..10 {
            posture = posture.advance(None, 5, 3);
        }
        assert_eq!(posture, Posture::Fallen { cycles: 10 });
        posture = posture.advance(Some(PostureRequest::GetUp), 5, 3);
        let mut cycles = 0;
        while !posture.is_upright() {
            posture = posture.advance(None, 5, 3);
            cycles += 1;
        }
        // Five cycles of getting up, and the next it stands.
        assert_eq!(cycles, 6);
    }

    #[test]
    fn a_dive_blocks_a_strip_on_its_side_for_its_time_and_ends_on_the_ground() {
        let mut posture = Posture::Upright.advance(Some(PostureRequest::Dive(Side::Right)), 5, 3);
        let (middle, strip) = posture.strip(0.5).unwrap();
        // From 10 cm to 60 cm to the right.
        assert_abs_diff_eq!(middle.position.y + strip.half_width_m, -0.1, epsilon = 1e-6);
        assert_abs_diff_eq!(middle.position.y - strip.half_width_m, -0.6, epsilon = 1e-6);
        for _ in 0..4 {
            posture = posture.advance(Some(PostureRequest::GetUp), 5, 3);
        }
        assert_eq!((posture, posture.strip(0.5)), (Posture::Fallen { cycles: 1 }, None));
    }

    #[test]
    fn a_lying_body_is_low_and_any_other_as_it_is_on_its_feet() {
        let tall = BodyBounds { height_m: 1.2, ..BodyBounds::default() };
        for body in [BodyBounds::default(), tall] {
            let lying = body.in_posture(Posture::Fallen { cycles: 0 });
            assert!(lying.height_m < 0.2 && lying.torso.z_m[1] < 0.2);
            assert_eq!((lying.torso.x_m, lying.base.half_width_m), (body.torso.x_m, body.base.half_width_m));
            for posture in [Posture::Upright, Posture::GettingUp { cycles: 9, cycles_left: 1 }] {
                assert_eq!(body.in_posture(posture), body);
            }
        }
    }
}

//! Falls, getting up, and a keeper's dives: what the paper leaves to future versions (section 4), coarsely. All of it
//! happens only where the rules have it switched on ([`Rules::falls`], [`Rules::dives`]).
//!
//! - When two robots collide, each may fall, with a probability that grows with the speed at which they met.
//! - A fallen robot lies where it stood: it is low, so others see over it and sonars do not hear it; it neither walks
//!   nor kicks; its cameras and sonars tell it nothing. It takes the same room on the ground as before.
//! - It gets up when it is told to, which takes its time.
//! - A dive blocks a strip beside the robot against the ball for a time. Then the robot lies, as after a fall.

use bevy::prelude::*;

use super::Roster;
use super::kick::KickPhase;
use super::posture::{Posture, PostureCommand, PostureRequest, dive_strip};
use crate::ball::{Ball, BallPhysics};
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CollisionPartner, CommandKind, CycleEvents, MatchEvent, Refusal};
use crate::game::{Game, GameState, Penalty, Rules};
use crate::geometry::Pose;
use crate::random::RandomStreams;
use crate::team::RobotId;

/// Takes posture commands in [`ActSystems::Body`]; robots fall after the collisions, before the referee looks.
pub struct FallsPlugin;

impl Plugin for FallsPlugin {
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
}

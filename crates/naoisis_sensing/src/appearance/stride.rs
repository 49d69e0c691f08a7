//! The stride: the smooth motion of a robot's legs and arms while it walks and kicks.

use bevy::math::ops;
use bevy::prelude::*;
use core::f32::consts::{PI, TAU};
use serde::{Deserialize, Serialize};

use super::posing::{self, JointAngles, SWING_S};
use naoisis_core::cycle::{Cycle, CycleClock, CycleSystems};
use naoisis_core::events::{CycleEvents, KickResult, MatchEvent};
use naoisis_core::game::Penalty;
use naoisis_core::geometry::{Pose, unrotate};
use naoisis_core::kick_geometry::{KickType, Side};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::kick::{KickPhase, KickSettings};
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::RobotId;

/// The time constant with which the stride follows the speed, s.
const SETTLING_S: f32 = 0.15;

/// Updates the [`Stride`]s of robots once a cycle.
pub struct StridePlugin;

impl Plugin for StridePlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Stride>()
            .init_resource::<Roster>()
            .init_resource::<CycleEvents>()
            .add_systems(Cycle, (follow_robots, note_kicks_under_way, note_kicks).chain().in_set(CycleSystems::Record));
    }
}

/// The motion of a robot's limbs. For display only: nothing in the simulation depends on it.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Stride {
    /// The time of the match, s.
    pub time_s: f64,
    /// The forward speed of the steps, m/s.
    pub speed: f32,
    /// The height to which the feet are lifted, 0 to 1.
    pub liveliness: f32,
    /// The kick under way, or the last one.
    pub kick: Option<Swing>,
}

/// The swing of a leg for a kick.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Swing {
    /// The kick, which determines the leg.
    pub kick_type: KickType,
    /// The start of the swing, s.
    pub begins_s: f64,
    /// The time at which the foot meets the ball, s.
    pub strikes_s: f64,
    /// Whether it is a side kick that strikes a ball on the wrong side straight ahead.
    pub is_reduced: bool,
}

impl Swing {
    /// The swing of a kick that meets the ball at the time `strikes_s`, on the wrong side if `is_reduced`.
    ///
    /// The swing of a side kick begins with an extension to the front, which strikes a ball on the wrong side.
    pub fn of(kick_type: KickType, is_reduced: bool, strikes_s: f64, kicks: &KickSettings) -> Self {
        let takes_s = match (kick_type.is_side_kick(), is_reduced) {
            (true, true) => kicks.extension_of_s(kick_type),
            (true, false) => kicks.wind_up_of_s(kick_type),
            (false, _) => kicks.wind_up_of_s(kick_type).min(SWING_S),
        };
        Self { kick_type, begins_s: strikes_s - f64::from(takes_s), strikes_s, is_reduced }
    }

    /// The position of the kicking foot at the time `time_s` relative to standing, forward and up, m, and the leg's swing to the left,
    /// radians.
    fn pose(&self, time_s: f64) -> (Vec2, f32) {
        let [age_s, swing_s] = [time_s - self.strikes_s, self.strikes_s - self.begins_s].map(|time_s| time_s as f32);
        let (reach, aside) = posing::kick_pose(self.kick_type, age_s, swing_s);
        (reach, if self.is_reduced { 0.0 } else { aside })
    }
}

impl Stride {
    /// Advances the stride to the time `now_s`, for a robot with this velocity.
    pub fn follow(&mut self, pose: Pose, velocity: Velocity, now_s: f64) {
        let elapsed_s = (now_s - self.time_s) as f32;
        self.time_s = now_s;
        if elapsed_s <= 0.0 {
            return;
        }
        let share = 1.0 - ops::exp(-elapsed_s / SETTLING_S);
        let in_robot = unrotate(pose.forward(), velocity.linear);
        let liveliness = (in_robot.length() / 0.08 + velocity.angular.abs() / 0.5).min(1.0);
        self.speed += share * (in_robot.x - self.speed);
        self.liveliness += share * (liveliness - self.liveliness);
    }

    /// The joint angles of the robot.
    pub fn joints(&self, id: RobotId, head: HeadAngles, body: &Body) -> JointAngles {
        // The phase differs from robot to robot. Double precision keeps it exact at late times.
        let turns = f64::from(posing::STEP_FREQUENCY) * self.time_s;
        let phase = TAU * (turns - turns.floor()) as f32 + id.stable_number() as f32;
        let mut joints = JointAngles { head, ..JointAngles::default() };
        for side in 0..2 {
            let side_phase = phase + side as f32 * PI;
            let mut step = posing::step(side_phase, self.speed, self.liveliness);
            let mut aside = 0.0;
            if let Some(kick) = self.kick
                && (kick.kick_type.foot() == Side::Left) == (side == 0)
            {
                let (reach, swing) = kick.pose(self.time_s);
                step += reach;
                aside = swing;
            }
            if let Some(legs) = &body.legs {
                joints.legs[side] = posing::LegAngles { aside, ..posing::leg_angles(legs, step) };
            }
            joints.arms[side] = 0.3 * ops::sin(side_phase) * (self.speed / 0.2).clamp(-1.0, 1.0);
        }
        joints
    }
}

fn follow_robots(clock: Res<CycleClock>, mut robots: Query<(&Pose, &Velocity, Option<&Penalty>, &mut Stride)>) {
    for (pose, velocity, penalty, mut stride) in &mut robots {
        // Penalised robots are carried.
        if !penalty.is_some_and(Penalty::is_active) {
            stride.follow(*pose, *velocity, clock.end_time_s());
        }
    }
}

fn note_kicks_under_way(clock: Res<CycleClock>, mut robots: Query<(&KickPhase, &KickSettings, &mut Stride)>) {
    for (phase, kicks, mut stride) in &mut robots {
        if let KickPhase::WindUp { request, cycles_left, .. } = *phase {
            let strikes_s = clock.end_time_s() + f64::from(cycles_left) * clock.period_s;
            stride.kick = Some(Swing::of(request.kick_type, false, strikes_s, kicks));
        } else if stride.kick.is_some_and(|kick| kick.strikes_s > clock.start_time_s()) {
            // Either the kick struck a ball earlier, and is noted next, or the robot fell or was penalised.
            stride.kick = None;
        }
    }
}

fn note_kicks(
    events: Res<CycleEvents>,
    clock: Res<CycleClock>,
    roster: Res<Roster>,
    mut strides: Query<(&KickSettings, &mut Stride)>,
) {
    for event in events.iter() {
        let MatchEvent::Kick { robot, kick_type, result, reason, .. } = event else { continue };
        if !result.swings(*reason) {
            continue;
        }
        if let Some((kicks, mut stride)) = roster.get(*robot).and_then(|robot| strides.get_mut(robot).ok()) {
            let is_reduced = *result == KickResult::Reduced;
            stride.kick = Some(Swing::of(*kick_type, is_reduced, clock.start_time_s(), kicks));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    #[test]
    fn a_robot_that_walks_gets_into_step_and_out_of_it() {
        let mut stride = Stride::default();
        let walking = Velocity { linear: Vec2::new(0.0, 0.2), angular: 0.0 };
        let pose = Pose::new(0.0, 0.0, PI / 2.0);
        for cycle in 1..=30 {
            stride.follow(pose, walking, f64::from(cycle) / 30.0);
        }
        // After a second, exp(-1 / 0.15) = 0.13 % of the difference are left.
        assert!((stride.speed - 0.2).abs() < 0.001 && stride.liveliness > 0.99, "{stride:?}");
        for cycle in 31..=60 {
            stride.follow(pose, Velocity::default(), f64::from(cycle) / 30.0);
        }
        let id = RobotId::new(Team::Blue, 1);
        assert!(stride.speed < 0.001 && stride.joints(id, HeadAngles::default(), &Body::default()).legs[0].knee < 0.2);
    }

    #[test]
    fn the_foot_of_a_side_kick_extends_to_the_front_before_it_moves_aside() {
        let id = RobotId::new(Team::Blue, 1);
        let legs = |time_s: f64| {
            let kick = Swing::of(KickType::RightSide, false, 1.0, &KickSettings::default());
            let stride = Stride { time_s, kick: Some(kick), ..Stride::default() };
            stride.joints(id, HeadAngles::default(), &Body::default()).legs
        };
        let [before, extended, strikes] = [0.5, 0.85, 1.0].map(legs);
        assert!(before[1].hip.abs() < 1e-3 && before[1].aside == 0.0, "{before:?}");
        assert!(extended[1].hip > 0.3 && extended[1].aside == 0.0 && extended[0].hip.abs() < 1e-3, "{extended:?}");
        assert!(strikes[1].hip > 0.3 && strikes[1].aside > 0.25, "{strikes:?}");
    }

    #[test]
    fn the_kicking_leg_swings_and_the_other_does_not() {
        let kick = Swing::of(KickType::RightStraight, false, 1.0, &KickSettings::default());
        let stride = Stride { time_s: 1.0, kick: Some(kick), ..Stride::default() };
        let joints = stride.joints(RobotId::new(Team::Pink, 2), HeadAngles::default(), &Body::default());
        assert!(joints.legs[1].hip > 0.5 && joints.legs[0].hip.abs() < 1e-3, "{joints:?}");
    }
}

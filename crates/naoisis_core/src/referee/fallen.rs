//! Fallen robots: they are removed unless they begin to get up, and stand, within given times (2010 rule book, section 4.7; 2025
//! rule book, section 4.6, which counts attempts instead).

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::Evidence;
use crate::robot::posture::Posture;

/// The attempts of a fallen robot to get up.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct GetUp {
    /// Whether an attempt is under way.
    is_trying: bool,
    /// Cycles for which the robot has lain without an attempt.
    cycles_lying: u64,
    /// Whether another robot has touched the robot during an attempt.
    is_disturbed: bool,
    /// Failed attempts since the fall.
    failed: u32,
}

impl GetUp {
    /// The attempts after this cycle. `index` is the index of `robot` in the snapshot.
    #[must_use]
    pub fn advance(self, snapshot: &MatchSnapshot, index: usize, robot: &RobotSnapshot) -> Self {
        if robot.posture.cycles_down().is_none() {
            return Self::default();
        }
        let is_trying = matches!(robot.posture, Posture::GettingUp { .. });
        Self {
            is_trying,
            cycles_lying: if is_trying { 0 } else { self.cycles_lying + 1 },
            is_disturbed: self.is_disturbed || is_trying && snapshot.contacts.iter().any(|pair| pair.contains(&index)),
            failed: self.failed.saturating_add(u32::from(self.is_trying && !is_trying)),
        }
    }

    /// The number of attempts that the robot has: one more than `attempts` if it was touched.
    fn allowed(&self, attempts: u32) -> u32 {
        attempts + u32::from(self.is_disturbed)
    }
}

/// The evidence against a robot that lies for too long, or has failed to get up too often.
pub fn judge(get_up: &GetUp, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    let cycles = robot.posture.cycles_down()?;
    let limit_s = snapshot.rules.fallen_s;
    if get_up.cycles_lying >= snapshot.cycles(limit_s) {
        let evidence =
            snapshot.evidence_against("A fallen robot that does not begin to get up soon is removed.", robot);
        return Some(
            evidence
                .with_measurement("s on the ground", snapshot.seconds(get_up.cycles_lying), limit_s)
                .otherwise("It had to begin to get up in time."),
        );
    }
    match snapshot.rules.get_up_attempts.map(|attempts| get_up.allowed(attempts)) {
        Some(allowed) => (get_up.failed >= allowed).then(|| {
            snapshot
                .evidence_against("A fallen robot that cannot get up in a few attempts is removed.", robot)
                .with_measurement("attempts", get_up.failed as f32, allowed as f32)
                .otherwise("Its last attempt had to succeed.")
        }),
        None => (cycles >= snapshot.cycles(snapshot.rules.get_up_limit_s)).then(|| {
            snapshot
                .evidence_against("A fallen robot that does not stand again before long is removed.", robot)
                .with_measurement("s on the ground", snapshot.seconds(cycles), snapshot.rules.get_up_limit_s)
                .otherwise("It had to stand in time.")
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::robot::posture::LyingOn;
    use crate::team::{RobotId, Team};

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    /// A match in which a robot lies, with two attempts to get up.
    fn fallen() -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        situation.rules.fallen = true;
        situation.rules.get_up_attempts = Some(2);
        situation.robot_mut(BLUE2).posture = Posture::Fallen { cycles: 1, on: LyingOn::Front };
        situation
    }

    /// Lets the robot try to get up, and fall back. Returns whether it is penalised.
    fn tries(situation: &mut MatchFixture) -> bool {
        for posture in [
            Posture::GettingUp { on: LyingOn::Front, cycles: 1000, cycles_left: 1 },
            Posture::Fallen { cycles: 1001, on: LyingOn::Front },
        ] {
            situation.robot_mut(BLUE2).posture = posture;
            situation.pass();
        }
        situation.robots[1].penalty.is_active()
    }

    #[test]
    fn the_second_attempt_has_to_succeed_or_the_third_of_who_was_touched() {
        let mut alone = fallen();
        assert_eq!([tries(&mut alone), tries(&mut alone)], [false, true]);
        let mut touched = fallen().contact(BLUE2, PINK2);
        touched.pass();
        // A robot that only lies is not disturbed.
        assert!(!touched.memory.robots[1].get_up.is_disturbed);
        touched.robot_mut(BLUE2).posture = Posture::GettingUp { on: LyingOn::Front, cycles: 900, cycles_left: 1 };
        touched.pass();
        touched.contacts.clear();
        assert_eq!([(); 3].map(|()| tries(&mut touched)), [false, false, true]);
    }

    #[test]
    fn standing_up_meanwhile_restarts_the_time() {
        let mut situation = fallen();
        assert!(!tries(&mut situation));
        situation.robot_mut(BLUE2).posture = Posture::Upright;
        situation.pass();
        assert!(!tries(&mut situation));
    }

    #[test]
    fn who_fell_back_has_time_to_try_again() {
        let mut situation = fallen();
        situation.rules.fallen_s = 4.0 * situation.clock.period();
        assert!(!tries(&mut situation));
        let penalised = [(); 3].map(|()| situation.pass().robots[1].penalty.is_active());
        assert_eq!(penalised, [false, false, true]);
    }
}

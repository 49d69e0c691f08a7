//! Fallen robots: they begin to get up soon, and stand before long, or they are removed (2010 rule book, section 4.7;
//! 2025 rule book, section 4.6, which counts attempts instead of the 20 s).

use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::Evidence;
use crate::robot::posture::Posture;

/// The case against a robot that lies for too long.
pub fn judge(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    let cycles = robot.posture.cycles_down()?;
    let lies = matches!(robot.posture, Posture::Fallen { .. });
    let (rule, limit_s, otherwise) = if lies && cycles >= snapshot.cycles(snapshot.rules.fallen_s) {
        let rule = "A fallen robot that does not begin to get up soon is removed.";
        (rule, snapshot.rules.fallen_s, "It had to begin to get up in time.")
    } else if cycles >= snapshot.cycles(snapshot.rules.get_up_limit_s) {
        let rule = "A fallen robot that does not stand again before long is removed.";
        (rule, snapshot.rules.get_up_limit_s, "It had to stand in time.")
    } else {
        return None;
    };
    let evidence = snapshot.evidence_against(rule, robot);
    Some(evidence.with_measurement("s on the ground", snapshot.seconds(cycles), limit_s).otherwise(otherwise))
}

//! Fits the range and spread of kicks.

use super::log::Kick;
use super::{Calibration, basis, groups, jackknife_positive, mean, variance, wrap_degrees};
use naoisis_core::kick_geometry::{KickType, strike};
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::statistics::Estimate;
use naoisis_sim::scenario::RobotModel;

/// The least speed of a kick that counts for the range.
const FULL_SPEED: f64 = 0.99;

/// The distance that the ball rolled, m.
fn distance(kick: &Kick) -> f64 {
    libm::hypot(kick.rest[0] - kick.start[0], kick.rest[1] - kick.start[1])
}

/// The error of the direction, degrees to the left. The expected direction is that from the foot to the ball; if the
/// ball is out of reach of the kick's geometry, it is straight ahead or aside.
fn off_deg(kick: &Kick, own: &KickSettings) -> f64 {
    let start = bevy::math::Vec2::new(kick.start[0] as f32, kick.start[1] as f32);
    let struck = strike(kick.kick_type, start).or_else(|| own.strike(kick.kick_type, start, 0.0));
    let expected = match (struck, kick.kick_type) {
        (Some(strike), _) => libm::atan2(f64::from(strike.direction.y), f64::from(strike.direction.x)),
        (None, KickType::LeftSide) => -core::f64::consts::FRAC_PI_2,
        (None, KickType::RightSide) => core::f64::consts::FRAC_PI_2,
        (None, _) => 0.0,
    };
    let direction = libm::atan2(kick.rest[1] - kick.start[1], kick.rest[0] - kick.start[0]);
    wrap_degrees((direction - expected).to_degrees())
}

/// Fits the figures of kicks.
pub(super) fn fit(kicks: &[Kick], model: &RobotModel, into: &mut Calibration) {
    if kicks.is_empty() {
        into.lacking.push("kicks: no kicks".to_owned());
        return;
    }
    // The way grows with the speed, or with the square of it where the ball slows down evenly.
    let power = if rolls_evenly(model) { 2.0 } else { 1.0 };
    let full: Vec<Kick> = kicks.iter().copied().filter(|kick| kick.speed >= FULL_SPEED).collect();
    let robot = |kick: &Kick| kick.robot;
    let own = model.scenario().map(|scenario| scenario.settings.kicks).unwrap_or_default();
    let mut types: Vec<KickType> = KickType::ALL.into_iter().chain(kicks.iter().map(|kick| kick.kick_type)).collect();
    types.sort();
    types.dedup();
    types.retain(|kick_type| match own.check(*kick_type) {
        Ok(()) => true,
        Err(unknown) => {
            into.lacking.push(format!("kicks: in the model, {unknown}"));
            false
        }
    });
    for &kick_type in &types {
        let of_type: Vec<Kick> = full.iter().copied().filter(|kick| kick.kick_type == kick_type).collect();
        let path = match kick_type {
            KickType::Custom(name) => format!("kicks.own.{name}.max_distance_m"),
            _ => format!("kicks.{kick_type}.max_distance_m"),
        };
        let reach = |kicks: &[Kick]| {
            let distances: Vec<f64> = kicks.iter().map(distance).collect();
            let mean = mean(&distances)?;
            let spread = variance(&distances).unwrap_or_default().sqrt() / (power * mean);
            // A spread of the speed makes the mean way longer where that grows with the square.
            Some(if power > 1.0 { mean / (1.0 + spread * spread) } else { mean })
        };
        let estimate = if of_type.len() < 3 { None } else { jackknife_positive(&groups(&of_type, robot), reach) };
        let needs = format!("{} full kicks; three are needed", of_type.len());
        into.add(&path, estimate, &basis(&of_type, "kicks", robot), &needs);
    }
    let by_type = |kicks: &[Kick], value: &dyn Fn(&Kick, f64) -> f64, centre: &dyn Fn(&[Kick]) -> f64| {
        let (mut squares, mut degrees) = (0.0, 0.0);
        for &kick_type in &types {
            let of_type: Vec<Kick> = kicks.iter().copied().filter(|kick| kick.kick_type == kick_type).collect();
            if of_type.len() < 2 {
                continue;
            }
            let centre = centre(&of_type);
            squares += of_type.iter().map(|kick| value(kick, centre) * value(kick, centre)).sum::<f64>();
            degrees += of_type.len() as f64 - 1.0;
        }
        (degrees > 0.0).then(|| (squares / degrees).sqrt())
    };
    let spread = |rows: &[Kick], statistic: &dyn Fn(&[Kick]) -> Option<f64>| -> Option<Estimate> {
        if rows.len() < 5 { None } else { jackknife_positive(&groups(rows, robot), statistic) }
    };
    let speed = |kicks: &[Kick]| {
        let mean_distance = |kicks: &[Kick]| mean(&kicks.iter().map(distance).collect::<Vec<f64>>()).unwrap_or(1.0);
        by_type(kicks, &|kick, mean| (distance(kick) / mean - 1.0) / power, &mean_distance)
    };
    let direction = |kicks: &[Kick]| {
        let off_deg = |kick: &Kick| off_deg(kick, &own);
        let mean_off = |kicks: &[Kick]| mean(&kicks.iter().map(off_deg).collect::<Vec<f64>>()).unwrap_or_default();
        by_type(kicks, &|kick, mean| off_deg(kick) - mean, &mean_off)
    };
    let few = "fewer than five kicks";
    into.add("kicks.speed_sd", spread(&full, &speed), &basis(&full, "full kicks", robot), few);
    into.add("kicks.direction_sd_deg", spread(kicks, &direction), &basis(kicks, "kicks", robot), few);
}

/// Whether the ball of the model's league has a constant deceleration.
fn rolls_evenly(model: &RobotModel) -> bool {
    model.scenario().is_ok_and(|scenario| {
        let ball = scenario.ball.unwrap_or_default();
        matches!(ball.rolling, naoisis_core::ball::Rolling::ConstantMps2(_))
    })
}

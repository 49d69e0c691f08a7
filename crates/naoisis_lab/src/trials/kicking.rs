//! Trials of kicks and of the rolling ball.

use bevy::math::Vec2;
use serde_json::json;

use super::{Laboratory, MeasuredQuantity, TRIED, TrialError, deviation_of, mean_of};
use naoisis_core::ball::Rolling;
use naoisis_core::cycle::CycleClock;
use naoisis_core::events::MatchEvent;
use naoisis_core::geometry::{to_degrees, wrap_angle};
use naoisis_core::kick_geometry::{KickName, KickType};
use naoisis_core::robot::kick::KickPhase;
use naoisis_sim::scenario::{RobotModel, Scenario};
use naoisis_sim::simulation::MatchApp;

/// The number of repetitions of values without a spread.
const FEW: u32 = 5;

/// The results of kicks of one type.
#[derive(Default)]
struct Kicks {
    /// The distances that the ball rolled, m.
    distances: Vec<f64>,
    /// The errors of the direction, degrees.
    directions: Vec<f64>,
    /// The times from the command until the ball leaves, s.
    departures: Vec<f64>,
    /// The times from the command until the robot is ready again, s.
    ready: Vec<f64>,
}

/// The kicks of a robot.
struct TriedKicks {
    /// The straight kick; if the robot has none, the kick with the greatest reach.
    main: KickType,
    straight: Kicks,
    side: Option<Kicks>,
    /// Side kicks at a ball on the wrong side.
    extended: Option<Kicks>,
    /// The robot's own kicks: name, mean distance, and the distance of the model, m.
    own: Vec<(KickName, f64, f32)>,
}

/// Runs kicks at a ball at `place`, m, robot frame, each until the ball rests.
fn kick(laboratory: &mut Laboratory, kick_type: KickType, place: Vec2, repetitions: u32) -> Result<Kicks, TrialError> {
    /// Longer than any ball rolls, s.
    const LONGEST_S: f64 = 40.0;

    let mut kicks = Kicks::default();
    for seed in 1..=repetitions.max(2) {
        let script = json!({ "script": [{ "from_s": 0, "kick": { "type": kick_type.name() } }] });
        laboratory.begin(json!({
            "seed": seed, "ball": { "position_m": [place.x, place.y] }, "falls": { "kick_probability": 0 },
            // The pitch is so large that the ball can roll as far as it does.
            "field": { "preset": "spl2025", "length_m": 40, "width_m": 20 },
            "robots": [{ "team": "blue", "number": 1, "behaviour": script }],
        }))?;
        let start = laboratory.app.ball().unwrap_or_default().position;
        let cycles = laboratory.cycles(LONGEST_S);
        let period_s = laboratory.period_s();
        let (mut direction, mut is_ready) = (None, false);
        laboratory.app.run_until(cycles, |app| {
            let cycle = app.world().resource::<CycleClock>().cycle;
            for event in app.events() {
                if let MatchEvent::Kick { direction: Some(angle), .. } = event {
                    direction = Some(*angle);
                    // The ball leaves within the cycle that has just ended.
                    kicks.departures.push((cycle - 1) as f64 * period_s);
                }
            }
            if !is_ready && direction.is_some() && app.robot::<KickPhase>(TRIED) == Some(&KickPhase::Ready) {
                is_ready = true;
                kicks.ready.push(cycle as f64 * period_s);
            }
            is_ready && app.ball_velocity().is_none_or(|velocity| velocity.length() == 0.0)
        });
        let end = laboratory.app.ball().unwrap_or_default().position;
        kicks.distances.push(f64::from(end.distance(start)));
        kicks.directions.extend(direction.map(|angle| f64::from(to_degrees(wrap_angle(angle)))));
    }
    Ok(kicks)
}

/// Measures distances, spreads and times of the robot's kicks, and the deceleration of the ball.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut laboratory = Laboratory::new(model);
    let real = laboratory.scenario(json!({}))?;
    let Some(tried) = try_kicks(&mut laboratory, &real, repetitions)? else { return Ok(Vec::new()) };
    let speed_left_mps = speed_after_a_second(&mut laboratory)?;
    Ok(quantities(&laboratory, &real, tried, speed_left_mps))
}

/// Runs the kicks of a robot with the settings of `real`. Returns `None` for a robot without kicks.
fn try_kicks(laboratory: &mut Laboratory, real: &Scenario, repetitions: u32) -> Result<Option<TriedKicks>, TrialError> {
    let mut of_type = |kick_type: KickType| match real.settings.kicks.geometry(kick_type) {
        Some(geometry) => kick(laboratory, kick_type, geometry.best_m, repetitions).map(Some),
        None => Ok(None),
    };
    let side = of_type(KickType::LeftSide)?;
    // If the robot has no straight kick, the kick with the greatest reach is measured.
    let Some(main) = real
        .settings
        .kicks
        .get(KickType::RightStraight)
        .map(|_| KickType::RightStraight)
        .or(real.settings.kicks.strongest())
    else {
        return Ok(None);
    };
    let Some(straight) = of_type(main)? else { return Ok(None) };
    let mut own = Vec::new();
    for (name, model) in real.settings.kicks.own.iter() {
        if let Some(kicks) = of_type(KickType::Custom(*name))? {
            own.push((*name, mean_of(&kicks.distances), model.max_distance_m));
        }
    }
    // A ball on the wrong side is struck as soon as the foot is at the front.
    let [of_side, of_straight] =
        [KickType::LeftSide, KickType::LeftStraight].map(|kick| real.settings.kicks.geometry(kick));
    let extended = match (of_side, of_straight) {
        (Some(side), Some(straight)) if !side.admits(straight.best_m) => {
            Some(kick(laboratory, KickType::LeftSide, straight.best_m, FEW)?)
        }
        _ => None,
    };
    Ok(Some(TriedKicks { main, straight, side, extended, own }))
}

/// The speed of a ball a second after it rolled at 1 m/s, m/s.
fn speed_after_a_second(laboratory: &mut Laboratory) -> Result<f64, TrialError> {
    laboratory.begin(json!({ "ball": { "position_m": [-3, 0], "velocity_mps": [1, 0] } }))?;
    let second = laboratory.cycles(1.0);
    laboratory.app.run_cycles(second);
    Ok(f64::from(laboratory.app.ball_velocity().unwrap_or_default().length()))
}

/// The measured values beside those of `real`.
fn quantities(
    laboratory: &Laboratory,
    real: &Scenario,
    tried: TriedKicks,
    speed_left_mps: f64,
) -> Vec<MeasuredQuantity> {
    let TriedKicks { main, straight, side, extended, own } = tried;
    let (kicks, latency, rolling) = (real.settings.kicks, real.settings.latency, real.ball.unwrap_or_default().rolling);
    // The distance grows with the speed of the ball, or with its square at constant deceleration, and so does its spread.
    let distance_spread = match rolling {
        Rolling::ExponentialPerS(_) => kicks.speed_sd_of(main),
        Rolling::ConstantMps2(_) => 2.0 * kicks.speed_sd_of(main),
    };
    let relative_spread = deviation_of(&straight.distances) / mean_of(&straight.distances);
    let departure_s = latency.kick_s + kicks.wind_up_of_s(main);
    let whole_s = departure_s + kicks.recovery_of_s(main);
    let quantity = |name: &str, unit, measured, real: f32, path: &str| {
        laboratory.quantity(name, unit, measured, real.into(), path)
    };
    let side = side.filter(|_| main != KickType::LeftSide).map(|side| {
        quantity("side kick", "m", mean_of(&side.distances), kicks.left_side.max_distance_m, "kicks.left_side")
    });
    let extended = extended.map(|extended| {
        let real_s = latency.kick_s + kicks.extension_of_s(KickType::LeftSide);
        let path = "kicks.extension_s";
        quantity("command to a side kick's foot at the front", "s", mean_of(&extended.departures), real_s, path)
    });
    let own = own.into_iter().filter(|(name, ..)| main != KickType::Custom(*name)).map(|(name, measured, real)| {
        quantity(&format!("kick {name}"), "m", measured, real, &format!("kicks.own.{name}"))
    });
    let (name, path) = match main {
        KickType::Custom(name) => (format!("kick {name}"), format!("kicks.own.{name}")),
        KickType::LeftStraight | KickType::RightStraight => ("straight kick".to_owned(), format!("kicks.{main}")),
        KickType::LeftSide | KickType::RightSide => ("side kick".to_owned(), format!("kicks.{main}")),
    };
    // A kick's own figures take precedence over the common ones.
    let of_main = |field: &str| {
        let own = format!("{path}.{field}");
        if laboratory.model.says(&own) { own } else { format!("kicks.{field}") }
    };
    let straight = [
        quantity(&name, "m", mean_of(&straight.distances), kicks.max_distance_m(main), &path),
        quantity("spread of a kick's way, of the whole", "", relative_spread, distance_spread, &of_main("speed_sd")),
        quantity(
            "spread of a kick's direction",
            "°",
            deviation_of(&straight.directions),
            to_degrees(kicks.direction_sd_of(main)),
            &of_main("direction_sd_deg"),
        ),
        quantity("command to ball's departure", "s", mean_of(&straight.departures), departure_s, &of_main("wind_up_s")),
        quantity("command to ready again", "s", mean_of(&straight.ready), whole_s, &of_main("recovery_s")),
        quantity("ball's speed after a second from 1 m/s", "m/s", speed_left_mps, rolling.advance(1.0, 1.0).1, "ball"),
    ];
    straight.into_iter().chain(side).chain(extended).chain(own).collect()
}

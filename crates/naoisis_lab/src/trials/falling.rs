//! Trials of falling and getting up.

use serde_json::{Value, json};

use super::walking::walks;
use super::{Laboratory, MeasuredQuantity, TRIED, TrialError, mean_of};
use naoisis_core::events::{CollisionPartner, FallCause, MatchEvent};
use naoisis_core::geometry::to_degrees;
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::falls::CollisionFalls;
use naoisis_core::robot::posture::LyingOn;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

/// The duration of each trial per repetition, s.
const TIME_S: u32 = 60;
/// The number of collisions per repetition.
const COLLISIONS: u32 = 2;
/// The factor by which the tried robots fall more often, because falls are rare.
const OFTENER: f32 = 10.0;

const NOBODY_FELL: &str = "nobody fell in so few repetitions";
const NOBODY_GOT_UP: &str = "nobody fell and got up in so few repetitions";

/// Counts of a trial with a robot that always gets up again.
#[derive(Default)]
struct Falls {
    /// Falls for the reason that is tried.
    falls: f64,
    /// Falls onto the back.
    fell_back: f64,
    /// The times to get up, s.
    got_up_s: Vec<f64>,
    /// The walking time, s.
    walked_s: f64,
    /// The number of kicks.
    kicked: f64,
}

/// The limit on the turning speed of a robot in these trials, °/s. Robots do not turn here, and a scenario with cycles of a
/// second allows no high limit.
fn turns_degps(laboratory: &Laboratory) -> Result<f32, TrialError> {
    const MOST_DEGPS: f32 = 150.0;
    Ok(to_degrees(laboratory.scenario(json!({}))?.settings.motion.max_angular).min(MOST_DEGPS))
}

/// Runs a trial with cycles of `cycle_s` seconds. The robot gets up again after each fall.
fn fall(
    laboratory: &mut Laboratory,
    action: Value,
    own: Value,
    cycle_s: f64,
    cause: FallCause,
    cycles: u32,
) -> Result<Falls, TrialError> {
    const ALWAYS_S: f64 = 1e9;
    let mut does = json!({ "from_s": 0, "until_s": ALWAYS_S, "posture": "get_up" });
    if let (Value::Object(does), Value::Object(action)) = (&mut does, action) {
        does.extend(action);
    }
    let turns_degps = turns_degps(laboratory)?;
    laboratory.begin(json!({
        "motion": { "max_angular_degps": turns_degps },
        // Out of reach of any kick.
        "cycle_s": cycle_s, "falls": own, "kicks": { "wind_up_s": 0, "extension_s": 0, "recovery_s": 0 }, "ball": { "position_m": [0, 3] },
        "robots": [{ "team": "blue", "number": 1, "behaviour": { "script": [does] } }],
    }))?;
    let mut result = Falls::default();
    let mut down_s = 0.0;
    for _ in 0..cycles {
        laboratory.app.run_cycles(1);
        let body = laboratory.reading::<BodyStatus>();
        result.walked_s += if body == BodyStatus::Walking { cycle_s } else { 0.0 };
        down_s += cycle_s;
        for event in laboratory.app.events() {
            match event {
                MatchEvent::Fall { cause: FallCause::GettingUp, .. } => {
                    (result.fell_back, down_s) = (result.fell_back + 1.0, 0.0);
                }
                MatchEvent::Fall { cause: of, .. } => {
                    result.falls += f64::from(u8::from(*of == cause));
                    down_s = 0.0;
                }
                MatchEvent::GotUp { .. } => result.got_up_s.push(down_s),
                MatchEvent::Kick { result: kick, reason, .. } if kick.swings(*reason) => result.kicked += 1.0,
                _ => {}
            }
        }
    }
    Ok(result)
}

/// The slip of robots that walk straight at each other, so that none passes by.
fn no_slip() -> Value {
    json!({ "scale": 1, "scale_sd": 0, "drift_sd_degpm": 0,
        "error": { "translation_sd_m": 0, "heading_per_metre_sd_deg": 0, "rotation_sd_deg": 0 } })
}

/// The share of head-on collisions in which the tried robot falls, and the share that its settings give for the
/// measured speeds. `None` if no collision happened.
fn collide(
    laboratory: &mut Laboratory,
    falls: CollisionFalls,
    repetitions: u32,
) -> Result<Option<[f64; 2]>, TrialError> {
    /// The distance at the start, m; enough to reach the full speed, or nearly.
    const APART_M: f32 = 1.5;
    /// A longer cycle than usual, because the result does not depend on it, s.
    const CYCLE_S: f64 = 0.1;
    /// The time until which they walk, s.
    const ALWAYS_S: f64 = 1e9;
    /// The time until they reach their speed, s.
    const BEGINNING_S: f32 = 10.0;

    let walks = json!({ "script": [{ "from_s": 0, "until_s": ALWAYS_S, "walk": [9, 0, 0] }] });
    let (mut collisions, mut fell, mut expected) = (0.0, 0.0, 0.0);
    let motion = laboratory.scenario(json!({}))?.settings.motion;
    let has_gait = motion.gait.is_some();
    let meet_s = BEGINNING_S + APART_M / motion.max_linear_mps.max(1e-3);
    let turns_degps = turns_degps(laboratory)?;
    let gait = if has_gait { json!({ "slip": no_slip() }) } else { Value::Null };
    for seed in 1..=repetitions {
        laboratory.begin(json!({
            "seed": seed, "ball": null, "cycle_s": CYCLE_S, "falls": { "falls_per_min": 0 },
            "motion": { "gait": gait, "max_angular_degps": turns_degps },
            "robots": [
                { "team": "blue", "number": 1, "pose": [0, 0, 0], "behaviour": walks },
                { "team": "pink", "number": 1, "pose": [APART_M, 0, 180], "behaviour": walks },
            ],
        }))?;
        let cycles = laboratory.cycles(meet_s.into());
        laboratory.app.run_until(cycles, |app| {
            let mut met = false;
            for event in app.events() {
                match event {
                    MatchEvent::Collision { speed_mps, with: CollisionPartner::Robot(_), .. } if !met => {
                        met = true;
                        collisions += 1.0;
                        expected += f64::from(falls.probability(*speed_mps));
                    }
                    MatchEvent::Fall { robot, cause: FallCause::Collision, .. } if *robot == TRIED => fell += 1.0,
                    _ => {}
                }
            }
            met
        });
    }
    Ok((collisions > 0.0).then_some([fell / collisions, expected / collisions]))
}

/// Counts falls of two robots that press against each other until one falls. Returns the number of falls, and the time of contact of both
/// robots together, s.
fn press(laboratory: &mut Laboratory, contact_falls_per_min: f32, repetitions: u32) -> Result<[f64; 2], TrialError> {
    /// The distance at the start, m: little, so that they meet at once.
    const APART_M: f32 = 0.6;
    const CYCLE_S: f64 = 0.1;
    const MOST_S: f64 = 120.0;

    let walks = json!({ "script": [{ "from_s": 0, "until_s": MOST_S, "walk": [9, 0, 0] }] });
    let gait = if laboratory.scenario(json!({}))?.settings.motion.gait.is_some() {
        json!({ "slip": no_slip() })
    } else {
        Value::Null
    };
    let turns_degps = turns_degps(laboratory)?;
    let (mut fell, mut touched_s) = (0.0, 0.0);
    for seed in 1..=repetitions {
        laboratory.begin(json!({
            "seed": seed, "ball": null, "cycle_s": CYCLE_S,
            "falls": { "falls_per_min": 0, "contact_falls_per_min": contact_falls_per_min, "collisions": { "from_mps": 100, "certain_mps": 100 }, "spread": 0 },
            "motion": { "gait": gait, "max_angular_degps": turns_degps },
            "robots": [
                { "team": "blue", "number": 1, "pose": [0, 0, 0], "behaviour": walks },
                { "team": "pink", "number": 1, "pose": [APART_M, 0, 180], "behaviour": walks },
            ],
        }))?;
        let mut touching = false;
        laboratory.app.run_until(laboratory.cycles(MOST_S), |app| {
            for event in app.events() {
                match event {
                    MatchEvent::Collision { with: CollisionPartner::Robot(_), .. } => touching = true,
                    MatchEvent::Fall { cause: FallCause::Contact, .. } => {
                        touched_s += 2.0 * CYCLE_S;
                        fell += 1.0;
                        return true;
                    }
                    _ => {}
                }
            }
            touched_s += if touching { 2.0 * CYCLE_S } else { 0.0 };
            false
        });
    }
    Ok([fell, touched_s])
}

/// Measures how often robots fall, and how they get up.
///
/// # Errors
/// When the model makes no valid scenario.
pub fn measure(model: &RobotModel, repetitions: u32) -> Result<Vec<MeasuredQuantity>, TrialError> {
    let mut laboratory = Laboratory::new(model);
    let scenario = laboratory.scenario(json!({}))?;
    let (real, has_walk) = (scenario.settings.falls, walks(&scenario));
    let main_kick = scenario.settings.kicks.get(KickType::LeftStraight).map(|_| KickType::LeftStraight);
    let main_kick = main_kick.or(scenario.settings.kicks.strongest());
    let cycles = TIME_S * repetitions.max(2);
    let often = json!({ "falls_per_min": OFTENER * real.falls_per_min, "spread": 0, "get_up_failure": 0 });
    let walking = json!({ "walk": [9, 0, 0] });
    let falls = fall(&mut laboratory, walking.clone(), often, 1.0, FallCause::Walking, cycles)?;
    let mut got_up_s = Vec::new();
    for on in [LyingOn::Front, LyingOn::Back] {
        let on_back_share = f32::from(u8::from(on == LyingOn::Back));
        let gets_up = json!({ "falls_per_min": 60, "spread": 0, "on_back_share": on_back_share, "get_up_failure": 0 });
        let ups = fall(&mut laboratory, walking.clone(), gets_up, 0.1, FallCause::Walking, cycles / 5)?;
        got_up_s.push((on, ups.got_up_s));
    }
    let at_once = json!({ "falls_per_min": 1000, "spread": 0, "get_up_s": 0, "get_up_from_back_s": 0 });
    let tries = fall(&mut laboratory, walking, at_once, 0.1, FallCause::Walking, cycles)?;
    let mut kicks = None;
    if let Some(kick) = main_kick {
        let kicking = json!({ "kick": { "type": kick.name() } });
        let at_once = json!({ "falls_per_min": 0, "get_up_s": 0, "get_up_from_back_s": 0, "get_up_failure": 0 });
        kicks = Some(fall(&mut laboratory, kicking, at_once, 0.1, FallCause::Kick, cycles)?);
    }

    let collisions = match real.collisions {
        Some(falls) if has_walk => collide(&mut laboratory, falls, COLLISIONS * repetitions)?,
        _ => None,
    };
    let pressed = if has_walk && real.contact_falls_per_min > 0.0 {
        Some(press(&mut laboratory, real.contact_falls_per_min, COLLISIONS * repetitions)?)
    } else {
        None
    };

    let quantity = |name, unit, measured, real: f32, path| laboratory.quantity(name, unit, measured, real.into(), path);
    let a_minute = 60.0 * falls.falls / falls.walked_s.max(1.0) / f64::from(OFTENER);
    let ups = got_up_s.iter().filter(|_| has_walk).map(|(on, times_s)| {
        let (name, path) = match on {
            LyingOn::Back if real.get_up_from_back_s.is_some() => {
                ("getting up from the back", "falls.get_up_from_back_s")
            }
            LyingOn::Back => ("getting up from the back", "falls.get_up_s"),
            LyingOn::Front => ("getting up from the front", "falls.get_up_s"),
        };
        let get_up_s = real.get_up_time_s(*on).unwrap_or(scenario.rules.get_up_s);
        quantity(name, "s", mean_of(times_s), get_up_s, path).if_seen(times_s.len() as f64, NOBODY_GOT_UP)
    });
    let quantities = [
        has_walk.then(|| {
            let path = "falls.falls_per_min";
            quantity("falls in a minute at full speed", "", a_minute, real.falls_per_min, path)
                .if_seen(falls.falls, NOBODY_FELL)
        }),
        kicks.map(|kicks| {
            let share = kicks.falls / kicks.kicked.max(1.0);
            quantity("kicks in which it falls", "", share, real.kick_probability, "falls.kick_probability")
                .if_seen(kicks.falls, NOBODY_FELL)
        }),
        collisions.map(|[fell, expected]| {
            let path = "falls.collisions";
            quantity("head-on collisions in which it falls", "", fell, expected as f32, path).if_seen(fell, NOBODY_FELL)
        }),
        pressed.map(|[fell, touched_s]| {
            let (rate, path) = (60.0 * fell / touched_s.max(1.0), "falls.contact_falls_per_min");
            quantity("falls in a minute of contact", "", rate, real.contact_falls_per_min, path)
                .if_seen(fell, NOBODY_FELL)
        }),
        // A robot that does not walk cannot fall in these trials.
        has_walk.then(|| {
            let share = tries.fell_back / (tries.fell_back + tries.got_up_s.len() as f64).max(1.0);
            quantity("tries to get up that fail", "", share, real.get_up_failure, "falls.get_up_failure")
                .if_seen(tries.fell_back, "no try failed in so few repetitions")
        }),
    ];
    Ok(quantities.into_iter().flatten().chain(ups).collect())
}

//! Whatever `check` accepts can be played: nothing gets into anything else, every number stays finite, and the trace can
//! be read back.
//!
//! The scenarios are drawn from the whole ranges that are accepted, and from their ends more often than not: robots that
//! stumble fast among posts, balls of all sizes in grass of all depths, cycles of a second, teams on pitches that they
//! hardly fit on. `PROPTEST_CASES` asks for more of them.

use bevy::app::App;
use bevy::math::{Vec2, ops};
use core::f32::consts::PI;
use core::ops::RangeInclusive;
use naoisis::ball::Rolling;
use naoisis::ball::flight::FlightPhysics;
use naoisis::behaviour::script::ScriptEntry;
use naoisis::belief::localisation_method::LocalisationMethod;
use naoisis::communication::{MessageSettings, TeamMessage};
use naoisis::game::Rules;
use naoisis::game::{Intervention, PenaltyReason, TimedIntervention};
use naoisis::geometry::to_radians;
use naoisis::kick_geometry::Side;
use naoisis::pitch::Pitch;
use naoisis::prelude::*;
use naoisis::record::read::TraceReader;
use naoisis::robot::falls::{CollisionFalls, FallModel};
use naoisis::robot::gait::{BallTouch, Gait, Slip, StepNoise, WalkVolume};
use naoisis::robot::head::HeadLimits;
use naoisis::robot::kick::{KickModel, KickSettings};
use naoisis::robot::latency::Latency;
use naoisis::robot::motion::{MotionError, MotionSettings};
use naoisis::robot::posture::PostureRequest;
use naoisis::robot::request::TeamRequest;
use naoisis::scenario::{
    BallSpec, BehaviourSpec, PostSpec, RULES_PRESETS, RobotPatch, RobotSettings, RobotSpec, TeamsSpec, rules_preset,
};
use naoisis::sensing::odometry::{OdometryNoise, OdometrySettings};
use naoisis::sensing::sonar::{SonarNoise, SonarSettings};
use naoisis::sensing::vision::{
    ClassNoise, Falloff, FalsePositives, GazeNoise, HiddenFeet, JerseyVision, VisionNoise, VisionSettings,
};
use naoisis::simulation::Snapshot;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use proptest::sample::select;
use std::path::Path;

use crate::support::{begin_trace, headless_app};

/// Cycles of each match.
const CYCLES: usize = 60;

/// A scenario that shows as its file.
#[derive(Clone)]
struct Accepted(Scenario);

impl core::fmt::Debug for Accepted {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(&self.0.resolved_json().unwrap_or_default())
    }
}

/// A number of a range: often an end of it, and as often a small one as a large one.
fn within(range: RangeInclusive<f32>) -> impl Strategy<Value = f32> {
    let (least, most) = (*range.start(), *range.end());
    let floor = (most.abs().max(least.abs()) * 1e-5).max(least);
    let by_magnitude = (0.0f32..1.0, any::<bool>()).prop_map(move |(share, negative)| {
        let size = floor * ops::powf(most / floor, share);
        if negative && least < 0.0 { -size } else { size }
    });
    prop_oneof![1 => Just(least), 1 => Just(most), 2 => range, 3 => by_magnitude]
}

/// One thing, but at times another.
fn mostly<T: Clone + core::fmt::Debug + 'static>(
    usual: T,
    other: impl Strategy<Value = T> + 'static,
) -> impl Strategy<Value = T> {
    prop_oneof![2 => Just(usual), 1 => other]
}

fn place(range: f32) -> impl Strategy<Value = Vec2> {
    (-range..range, -range..range).prop_map(Vec2::from)
}

fn pose(range: f32) -> impl Strategy<Value = Pose> {
    let whole_degrees = (-180.0f32..180.0).prop_map(|degrees| to_radians(degrees.round()));
    let heading = prop_oneof![2 => whole_degrees, 1 => -7.0f32..7.0, 1 => select(vec![-0.0, -PI, PI, 1e-12])];
    (place(range), heading).prop_map(|(position, heading)| Pose { position, heading })
}

fn ball() -> impl Strategy<Value = Option<BallSpec>> {
    let rolling = prop_oneof![
        within(1e-6..=1000.0).prop_map(Rolling::ExponentialPerS),
        within(1e-6..=1000.0).prop_map(Rolling::ConstantMps2),
    ];
    let flight = (within(0.0..=10.0), within(0.0..=1.0), within(0.0..=10.0)).prop_map(
        |(drag_per_m, ground_restitution, ground_friction)| FlightPhysics {
            drag_per_m,
            ground_restitution,
            ground_friction,
        },
    );
    let ball = (
        place(1.0),
        mostly(Vec2::ZERO, (-3.1f32..3.1, within(0.0..=99.9)).prop_map(|(turn, speed)| Vec2::from_angle(turn) * speed)),
        within(0.005..=0.5),
        mostly(Rolling::default(), rolling),
        mostly(0.4, within(0.0..=1.0)),
        mostly([0.0; 2], [within(0.0..=2.0), within(-3.0..=5.0)]),
        mostly(FlightPhysics::default(), flight).boxed(),
    );
    let ball = ball.prop_map(|(place, velocity, radius_m, rolling, restitution, [height_m, climb_mps], flight)| {
        let (position_m, velocity_mps) = (place.extend(height_m), velocity.extend(climb_mps));
        Some(BallSpec { position_m, velocity_mps, radius_m, rolling, restitution, flight, ..BallSpec::default() })
    });
    prop_oneof![9 => ball, 1 => Just(None)].boxed()
}

fn motion() -> impl Strategy<Value = MotionSettings> {
    let error_sd = (within(0.0..=10.0), within(0.0..=10.0), within(0.0..=360.0))
        .prop_map(|(dx_m, dy_m, degrees)| MotionError { dx_m, dy_m, dtheta: to_radians(degrees) });
    (
        mostly(0.2, within(0.0..=5.0)),
        mostly(90.0, within(0.0..=1080.0)),
        mostly(MotionError::default(), error_sd),
        mostly(None, gait().prop_map(Some)).boxed(),
    )
        .prop_map(|(max_linear_mps, degrees, error_sd, gait)| MotionSettings {
            max_linear_mps,
            max_angular: to_radians(degrees),
            error_sd,
            gait,
        })
}

fn latency() -> impl Strategy<Value = Latency> {
    let seconds = || within(0.0..=2.0);
    let sensed = (seconds(), seconds(), seconds());
    let acted = (seconds(), seconds(), seconds());
    (sensed, acted).prop_map(|((vision_s, image_s, sonar_s), (walk_s, kick_s, head_s))| Latency {
        vision_s,
        image_s,
        sonar_s,
        walk_s,
        kick_s,
        head_s,
    })
}

fn falls() -> impl Strategy<Value = FallModel> {
    let collisions = (within(0.0..=10.0), within(0.0..=10.0))
        .prop_map(|(one, other)| Some(CollisionFalls { from_mps: one.min(other), certain_mps: one.max(other) }));
    let duration = || mostly(None, within(0.0..=5.0).prop_map(Some));
    let probability = || within(0.0..=1.0);
    let rates = (within(0.0..=1000.0), within(0.0..=1000.0), within(0.0..=3.0));
    let falls = (rates, probability(), mostly(None, collisions), mostly(None, probability().prop_map(Some)));
    let get_up = (probability(), duration(), duration(), probability(), probability());
    (falls, get_up).prop_map(|((rates, kick_probability, collisions, trip_probability), get_up)| FallModel {
        falls_per_min: rates.0,
        contact_falls_per_min: rates.1,
        kick_probability,
        collisions,
        trip_probability,
        spread: rates.2,
        on_back_share: get_up.0,
        get_up_s: get_up.1,
        get_up_from_back_s: get_up.2,
        get_up_failure: get_up.3,
        get_up_failure_in_contact: get_up.4,
    })
}

fn gait() -> impl Strategy<Value = Gait> {
    let limits = (within(0.05..=5.0), within(0.001..=5.0), within(0.001..=5.0), within(0.0..=1.0), within(0.0..=180.0));
    let acceleration = (within(0.01..=1000.0), within(1.0..=100_000.0));
    let slip = (within(0.1..=2.0), within(0.0..=0.3), within(0.0..=90.0));
    let error = (within(0.0..=1.0), within(0.0..=180.0), within(0.0..=180.0));
    let touch = (within(1.0..=5.0), within(0.0..=90.0));
    let volume = (within(1.0..=10.0), within(1.0..=10.0));
    let parts = (limits, acceleration, volume, slip, error, touch);
    let gait = parts.prop_map(|(limits, acceleration, volume, slip, error, touch)| Gait {
        step_s: limits.0,
        backward_mps: limits.1,
        sideways_mps: limits.2,
        acceleration_mps2: acceleration.0,
        angular_acceleration: to_radians(acceleration.1),
        least_mps: limits.3,
        least_angular: to_radians(limits.4),
        volume: WalkVolume { translation_exponent: volume.0, rotation_exponent: volume.1 },
        slip: Slip {
            scale: slip.0,
            scale_sd: slip.1,
            drift_sd: to_radians(slip.2),
            error: StepNoise {
                translation_sd_m: error.0,
                heading_per_metre_sd: to_radians(error.1),
                rotation_sd: to_radians(error.2),
            },
        },
        touch: BallTouch { foot_speed: touch.0, direction_sd: to_radians(touch.1) },
    });
    gait.boxed()
}

/// A number as a message may have it.
fn said() -> impl Strategy<Value = f32> {
    prop_oneof![-3.0f32..3.0, within(-1e30..=1e30), Just(f32::MAX), Just(-f32::MAX)]
}

fn message() -> impl Strategy<Value = TeamMessage> {
    let place = || (said(), said()).prop_map(Vec2::from);
    let pose = (place(), -3.1f32..3.1).prop_map(|(position, heading)| Pose { position, heading });
    (option::of(pose), option::of(place()), vec(place(), 0..3)).prop_map(|(pose, ball_m, robots_m)| TeamMessage {
        pose,
        ball_m,
        robots_m,
        ..TeamMessage::default()
    })
}

/// What a robot does in a stretch of time of a script.
fn script_entry() -> impl Strategy<Value = ScriptEntry> {
    let step = || mostly(0.05, within(-2000.0..=2000.0));
    let kick = (select(KickType::ALL.to_vec()), -1.0f32..2.0)
        .prop_map(|(kick_type, speed)| KickRequest::new(kick_type, speed));
    let head = [within(-1e5..=1e5), within(-1e5..=1e5)];
    let posture =
        select(vec![PostureRequest::GetUp, PostureRequest::Dive(Side::Left), PostureRequest::Dive(Side::Right)]);
    (
        0.0f64..1.0,
        option::of(0.1f64..9.0),
        [step(), step(), step()],
        option::of(kick),
        option::of(head),
        option::of(posture),
        option::of(select(vec![TeamRequest::Timeout, TeamRequest::PickUp, TeamRequest::Substitute(3)])),
        option::of(message()),
    )
        .prop_map(|(from_s, duration_s, walk, kick, head, posture, request, say)| ScriptEntry {
            from_s,
            until_s: duration_s.map(|duration_s| from_s + duration_s),
            walk: Some(walk),
            kick,
            head,
            posture,
            request,
            say,
        })
}

fn robot() -> impl Strategy<Value = RobotSpec> {
    let named = select(vec!["idle", "chaser", "keeper", "striker", "supporter", "passer", "passing_keeper"]);
    let behaviour = prop_oneof![
        1 => named.prop_map(|name| BehaviourSpec::Named(name.to_owned())),
        2 => vec(script_entry(), 1..4).prop_map(BehaviourSpec::Script),
    ];
    (select(Team::BOTH.to_vec()), pose(0.8), behaviour, option::of(motion()), mostly(false, Just(true))).prop_map(
        |(team, pose, behaviour, motion, substitute)| {
            let own = RobotPatch { motion, ..RobotPatch::default() };
            RobotSpec { team, pose, behaviour, substitute, own, ..RobotSpec::default() }
        },
    )
}

fn rules() -> impl Strategy<Value = Rules> {
    let names: Vec<&str> = RULES_PRESETS.iter().map(|preset| preset.name).collect();
    // Short, so that much happens in few cycles.
    let seconds = || within(0.01..=5.0);
    (select(names), 1u8..=11, [seconds(), seconds(), seconds(), seconds(), seconds()], any::<[bool; 4]>()).prop_map(
        |(name, team_size, [half_s, ready_s, set_s, penalty_s, stall_s], [falls, dives, shoot_out, is_short])| {
            let preset = rules_preset(name).unwrap();
            let short =
                Rules { half_s, ready_s, set_s, penalty_s, stall_s, shoot_out, timeout_s: set_s, ..preset.clone() };
            let substitutes = team_size % 3;
            Rules { team_size, substitutes, falls, dives, get_up_s: 0.2, ..if is_short { short } else { preset } }
        },
    )
}

fn field() -> impl Strategy<Value = Pitch> {
    let small = (within(1.0..=9.0), within(1.0..=6.0), within(0.2..=2.0), within(0.05..=1.0), within(0.01..=1.0))
        .prop_map(|(length_m, width_m, border_m, goal, post)| {
            let mut pitch = Pitch { length_m, width_m, border_m, ..Pitch::default() };
            pitch.goal.width_m = (goal * width_m).max(0.2);
            pitch.goal.post_diameter_m = (post * pitch.goal.width_m / 2.0).max(0.01);
            pitch.goal.bar_diameter_m = pitch.goal.bar_diameter_m.min(pitch.goal.width_m / 2.0);
            pitch.centre_circle_diameter_m = pitch.centre_circle_diameter_m.min(width_m);
            pitch.penalty_area.depth_m = pitch.penalty_area.depth_m.min(length_m / 2.0);
            pitch.penalty_area.width_m = pitch.penalty_area.width_m.min(width_m);
            pitch.penalty_mark_distance_m = pitch.penalty_mark_distance_m.min(length_m / 2.0);
            pitch
        });
    mostly(Pitch::default(), small)
}

fn intervention() -> impl Strategy<Value = TimedIntervention> {
    let robot = || (select(Team::BOTH.to_vec()), 1u8..4).prop_map(|(team, number)| RobotId::new(team, number));
    let velocity = (-3.1f32..3.1, within(0.0..=99.9)).prop_map(|(turn, speed)| Vec2::from_angle(turn) * speed);
    let what = prop_oneof![
        (place(1.0), velocity)
            .prop_map(|(position_m, velocity_mps)| Intervention::PlaceBall { position_m, velocity_mps }),
        (robot(), pose(0.8)).prop_map(|(robot, pose)| Intervention::PlaceRobot { robot, pose }),
        robot().prop_map(|robot| Intervention::Penalise {
            robot,
            reason: PenaltyReason::Manual,
            duration_s: Some(0.3)
        }),
        robot().prop_map(|robot| Intervention::Return { robot }),
        place(1.0).prop_map(|position_m| Intervention::DropBall { position_m }),
        select(Team::BOTH.to_vec()).prop_map(|team| Intervention::KickOff { team }),
        option::of(select(Team::BOTH.to_vec())).prop_map(|team| Intervention::Timeout { team, duration_s: Some(0.3) }),
        (robot(), robot()).prop_map(|(robot, by)| Intervention::Substitute { robot, by }),
        Just(Intervention::Resume),
        Just(Intervention::Whistle),
    ];
    (0.0f64..2.0, what).prop_map(|(at_s, intervention)| TimedIntervention { at_s, intervention })
}

/// How a robot senses, talks, turns its head and kicks.
#[derive(Clone, Debug)]
struct Abilities {
    sonar: SonarSettings,
    odometry: OdometrySettings,
    vision: VisionSettings,
    messages: MessageSettings,
    head: HeadLimits,
    kicks: KickSettings,
    falls: FallModel,
    latency: Latency,
}

impl Default for Abilities {
    fn default() -> Self {
        let Scenario { settings, messages, .. } = Scenario::default();
        let RobotSettings { sonar, odometry, vision, head, kicks, falls, latency, .. } = settings;
        Self { sonar, odometry, vision, messages, head, kicks, falls, latency }
    }
}

fn abilities() -> impl Strategy<Value = Abilities> {
    let degrees = |range: RangeInclusive<f32>| within(range).prop_map(to_radians);
    let sonar_noise = prop_oneof![
        within(0.0..=10.0).prop_map(|sd_m| SonarNoise::Gaussian { sd_m }),
        within(0.0..=10.0).prop_map(|half_width_m| SonarNoise::Uniform { half_width_m }),
        (within(0.0..=10.0), 0.0f32..=1.0).prop_map(|(sd_m, probability)| SonarNoise::Outliers { sd_m, probability }),
    ];
    let sonar = (
        within(0.0..=9.9),
        within(0.01..=10.0),
        degrees(-180.0..=180.0),
        degrees(0.1..=90.0),
        0.0f32..=2.0,
        sonar_noise,
        (option::of(within(0.1..=1000.0)), within(0.0..=1.0)),
    )
        .prop_map(|(min_m, length_m, heading, half_angle, height_m, noise, (rate_hz, crosstalk))| SonarSettings {
            min_m,
            max_m: (min_m + length_m).min(10.0),
            heading,
            half_angle,
            height_m,
            noise,
            rate_hz,
            crosstalk_probability: crosstalk,
            ..SonarSettings::default()
        });
    let odometry = [within(0.0..=10.0), within(0.0..=6.2), within(0.0..=6.2), within(0.0..=10.0), within(0.0..=10.0)]
        .prop_map(|[translation_sd_m, heading_per_metre_sd, rotation_sd, translation_scale, rotation_scale]| {
            OdometrySettings {
                noise: OdometryNoise {
                    translation_sd_m,
                    heading_per_metre_sd,
                    rotation_sd,
                    translation_scale,
                    rotation_scale,
                },
                ..OdometrySettings::default()
            }
        });
    let class =
        || {
            let falloff = (within(0.01..=1000.0), within(0.5..=100.0))
                .prop_map(|(half_distance_m, exponent)| Falloff { half_distance_m, exponent });
            (
                within(0.0..=1000.0),
                within(0.0..=1.0),
                within(0.0..=1.0),
                option::of(within(0.0..=1000.0)),
                option::of(falloff),
            )
                .prop_map(|(pixel_sd, miss_probability, false_positive_probability, max_distance_m, falloff)| {
                    ClassNoise { pixel_sd, miss_probability, false_positive_probability, max_distance_m, falloff }
                })
                .boxed()
        };
    let gaze = (degrees(0.0..=180.0), degrees(0.0..=180.0), degrees(0.0..=180.0), within(0.0..=3600.0)).prop_map(
        |(bias_sd, standing_sd, walking_sd, correlation_s)| GazeNoise {
            bias_sd,
            standing_sd,
            walking_sd,
            correlation_s,
        },
    );
    let places = || {
        (within(0.0..=600.0), within(0.0..=3600.0))
            .prop_map(|(per_minute, life_s)| FalsePositives { per_minute, life_s })
    };
    let feet = (within(-1.0..=10.0), within(0.0..=10.0)).prop_map(|(bias, sd)| HiddenFeet { bias, sd });
    let jerseys = (within(0.0..=1000.0), within(0.0..=1.0), within(0.0..=1000.0), degrees(0.0..=180.0)).prop_map(
        |(number_m, number_error, heading_m, heading_sd)| JerseyVision {
            number_m,
            number_error,
            heading_m,
            heading_sd,
            colour_m: number_m,
            colour_error: number_error,
        },
    );
    let lasting = (degrees(0.0..=180.0), gaze, places(), places(), feet, jerseys, any::<bool>());
    let vision = ([class(), class(), class(), class(), class(), class(), class()], lasting).prop_map(
        |([ball, goal_posts, robots, lines, junctions, penalty_crosses, centre_circle], lasting)| {
            let (head_angle_sd, gaze, false_balls, false_robots, hidden_feet, jerseys, confidence) = lasting;
            VisionSettings {
                noise: VisionNoise {
                    ball,
                    goal_posts,
                    robots,
                    lines,
                    junctions,
                    penalty_crosses,
                    centre_circle,
                    head_angle_sd,
                    gaze,
                    false_balls,
                    false_robots,
                    hidden_feet,
                    jerseys,
                    confidence,
                },
                points: confidence,
                ..VisionSettings::default()
            }
        },
    );
    let messages = (within(0.0..=1.0), 1u32..=20, 0u32..=20, option::of(within(0.0..=1000.0))).prop_map(
        |(loss, delay_cycles, jitter_cycles, range_m)| MessageSettings {
            loss,
            delay_cycles,
            jitter_cycles,
            range_m,
            ..MessageSettings::default()
        },
    );
    let limits = |most: f32| {
        (within(-most..=most), within(-most..=most)).prop_map(|(one, other)| [one.min(other), one.max(other)])
    };
    let head = (limits(3.1), limits(1.5), degrees(0.0..=3600.0)).prop_map(|(yaw, pitch, max_speed)| HeadLimits {
        yaw,
        pitch,
        max_speed,
        ..HeadLimits::default()
    });
    let seconds = || within(0.0..=2.0);
    let times = [seconds(), seconds(), seconds()];
    let kicks = (within(0.001..=50.0), 0.0f32..=1.0, times, degrees(0.0..=180.0), within(0.0..=10.0)).prop_map(
        |(max_distance_m, wrong_side_speed_factor, [wind_up_s, extension_s, recovery_s], direction_sd, speed_sd)| {
            let range = KickModel::of(max_distance_m);
            KickSettings {
                left_straight: range,
                right_straight: range,
                left_side: range,
                right_side: range,
                wrong_side_speed_factor,
                wind_up_s,
                extension_s,
                recovery_s,
                direction_sd,
                speed_sd,
                ..KickSettings::default()
            }
        },
    );
    // On the heap: together they are too large for the stack of a test.
    let any = (
        sonar.boxed(),
        odometry.boxed(),
        vision.boxed(),
        messages.boxed(),
        head.boxed(),
        kicks.boxed(),
        (falls(), latency()).boxed(),
    )
        .prop_map(|(sonar, odometry, vision, messages, head, kicks, (falls, latency))| Abilities {
            sonar,
            odometry,
            vision,
            messages,
            head,
            kicks,
            falls,
            latency,
        });
    mostly(Abilities::default(), any)
}

fn scenario() -> impl Strategy<Value = Accepted> {
    let cycle_s = mostly(1.0 / 30.0, within(0.001..=1.0).prop_map(f64::from));
    let teams = (select(vec!["roles", "chasers", "passers"]), select(vec!["roles", "chasers", "passers"]))
        .prop_map(|(blue, pink)| TeamsSpec::new(blue, pink));
    let post = (place(0.9), within(0.001..=1.0)).prop_map(|(position_m, radius_m)| PostSpec {
        position_m,
        radius_m,
        height_m: 0.5,
    });
    let who = prop_oneof![3 => vec(robot(), 0..9).prop_map(Ok), 1 => teams.prop_map(Err)];
    let localisation =
        select(vec![LocalisationMethod::Kalman, LocalisationMethod::Unscented, LocalisationMethod::Particles]);
    let numbers = (any::<u64>(), cycle_s, ball(), motion(), rules(), field().boxed(), abilities(), localisation);
    (numbers, (who, vec(post, 0..4), vec(intervention(), 0..4)))
        .prop_map(
            |((seed, cycle_s, ball, motion, rules, field, abilities, localisation), (who, posts, interventions))| {
                let Abilities { sonar, odometry, vision, messages, head, kicks, falls, latency } = abilities;
                let (mut robots, teams) = who.map_or_else(|teams| (Vec::new(), Some(teams)), |robots| (robots, None));
                for (number, robot) in (1..).zip(&mut robots) {
                    robot.number = number;
                }
                let settings = RobotSettings {
                    motion,
                    sonar,
                    odometry,
                    vision,
                    head,
                    kicks,
                    falls,
                    latency,
                    localisation,
                    ..RobotSettings::default()
                };
                let scenario = Scenario {
                    seed,
                    cycle_s,
                    ball,
                    rules,
                    field,
                    robots,
                    teams,
                    posts,
                    interventions,
                    settings,
                    messages,
                    ..Scenario::default()
                };
                Accepted(without_faults(scenario))
            },
        )
        .prop_filter("refused", |scenario| scenario.0.validate().is_ok())
}

/// The scenario without whatever stands in something else, and what cannot be done.
fn without_faults(mut scenario: Scenario) -> Scenario {
    while let Err(fault) = scenario.validate() {
        let path = fault.path.to_string();
        let index = |list: &str| path.strip_prefix(list)?.split(']').next()?.parse::<usize>().ok();
        if let Some(robot) = index("robots[") {
            scenario.robots.remove(robot);
        } else if let Some(post) = index("posts[") {
            scenario.posts.remove(post);
        } else if let Some(intervention) = index("interventions[") {
            scenario.interventions.remove(intervention);
        } else if path.starts_with("ball") {
            scenario.ball = None;
        } else if path.contains("max_angular") {
            scenario.settings.motion.max_angular = 0.1;
        } else {
            break;
        }
    }
    scenario
}

/// Plays a match and looks at everything that it says. Its trace.
fn play(scenario: &Scenario) -> Result<Vec<u8>, TestCaseError> {
    let mut app = headless_app();
    app.start_match(scenario).map_err(|fault| TestCaseError::fail(fault.to_string()))?;
    let bytes = begin_trace(&mut app);
    for cycle in 1..=CYCLES {
        app.run_cycles(1);
        for event in app.events() {
            let broken = matches!(event, MatchEvent::InvariantBroken { .. });
            prop_assert!(!broken, "in cycle {cycle}: {event:?}");
        }
    }
    // What it has come to can be saved and restored.
    let fail = |error: &dyn std::fmt::Display| TestCaseError::fail(error.to_string());
    let saved = |app: &mut App| Snapshot::take(app.world_mut()).and_then(|moment| moment.to_bytes(app.world()));
    let bytes_before = saved(&mut app).map_err(|error| fail(&error))?;
    let moment = Snapshot::from_bytes(&bytes_before, app.world()).map_err(|error| fail(&error))?;
    moment.restore(app.world_mut()).map_err(|error| fail(&error))?;
    prop_assert!(saved(&mut app).map_err(|error| fail(&error))? == bytes_before, "it is not restored as it was saved");
    drop(app);
    let written = bytes.written();
    let mut trace = TraceReader::new(Path::new("trace"), std::io::Cursor::new(written.clone()))
        .map_err(|error| TestCaseError::fail(error.to_string()))?;
    while trace.next_cycle().map_err(|error| TestCaseError::fail(error.to_string()))?.is_some() {}
    Ok(written)
}

/// Some, unless more are asked for.
fn cases() -> ProptestConfig {
    let default = ProptestConfig { failure_persistence: None, max_shrink_iters: 500, ..ProptestConfig::default() };
    if std::env::var_os("PROPTEST_CASES").is_some() { default } else { ProptestConfig { cases: 40, ..default } }
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn whatever_is_accepted_can_be_played_and_the_header_of_its_trace_plays_it_again(scenario in scenario(), ron: bool) {
        let trace = play(&scenario.0)?;
        let header = trace.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let header: serde_json::Value = serde_json::from_slice(header).unwrap();
        let text = header["scenario"].to_string();
        let again = if ron {
            let scenario: Scenario = serde_json::from_str(&text).unwrap();
            Scenario::from_ron(&ron::to_string(&scenario).unwrap())
        } else {
            Scenario::from_json(&text)
        };
        let again = again.map_err(|error| TestCaseError::fail(format!("{error}\n{text}")))?;
        let traced_again = play(&again)?;
        let differing = trace.split(|byte| *byte == b'\n').zip(traced_again.split(|byte| *byte == b'\n')).find(|(one, other)| one != other);
        if let Some((one, other)) = differing {
            let [one, other] = [one, other].map(String::from_utf8_lossy);
            prop_assert!(false, "written\n{one}\nand then\n{other}");
        }
        prop_assert_eq!(trace.len(), traced_again.len());
    }
}

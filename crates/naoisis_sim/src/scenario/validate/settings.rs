//! The ranges of settings: what a NAO, or any robot of its size, could be set to, generously.

use bevy::math::Vec2;

use super::{Checks, ScenarioFault};
use crate::scenario::field_path::FieldPath;
use crate::scenario::types::BallSpec;
use naoisis_core::ball::{FASTEST_MPS, Rolling};
use naoisis_core::communication::{MessageLimits, MessageSettings};
use naoisis_core::game::Rules;
use naoisis_core::geometry::to_degrees;
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::falls::{CollisionFalls, FallModel};
use naoisis_core::robot::gait::{Gait, StepNoise};
use naoisis_core::robot::head::HeadLimits;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::latency::Latency;
use naoisis_core::robot::motion::MotionLimits;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::noise::ImageNoise;
use naoisis_sensing::sensing::odometry::OdometrySettings;
use naoisis_sensing::sensing::sonar::{SonarNoise, SonarSettings};
use naoisis_sensing::sensing::vision::VisionSettings;

/// The largest datagram of UDP, bytes.
const LARGEST_DATAGRAM_BYTES: u32 = 65_507;

impl Checks {
    pub(super) fn rules(&mut self, path: &FieldPath, rules: &Rules) {
        for error in rules.errors() {
            let limits = error.limited_by.map(|field| path.field(field));
            self.push(ScenarioFault::new(path.field(error.field), error.message, error.expected).judged_with(limits));
        }
    }

    pub(super) fn ball(&mut self, path: &FieldPath, ball: &BallSpec) {
        self.range(path.field("radius_m"), ball.radius_m, 0.005..=0.5, " m");
        self.ball_speed(path.field("velocity_mps"), ball.velocity_mps);
        let rolling = path.field("rolling");
        match ball.rolling {
            Rolling::ExponentialPerS(drag) => self.positive(rolling.field("exponential_per_s"), drag, 1000.0, " /s"),
            Rolling::ConstantMps2(deceleration) => {
                self.positive(rolling.field("constant_mps2"), deceleration, 1000.0, " m/s²");
            }
        }
        self.range(path.field("restitution"), ball.restitution, 0.0..=1.0, "");
    }

    pub(super) fn ball_speed(&mut self, path: FieldPath, velocity_mps: Vec2) {
        if velocity_mps.length() > FASTEST_MPS {
            let message = format!("the ball's speed is {} m/s", velocity_mps.length());
            self.value_fault(path, message, format!("a speed of at most {FASTEST_MPS} m/s"));
        }
    }

    pub(super) fn motion(&mut self, path: &FieldPath, motion: &MotionLimits) {
        self.range(path.field("max_linear_mps"), motion.max_linear_mps, 0.0..=5.0, " m/s");
        self.degrees(path.field("max_angular_degps"), motion.max_angular, 0.0..=1080.0, " degrees/s");
        let error = path.field("error_sd");
        self.range(error.field("dx_m"), motion.error_sd.dx_m, 0.0..=10.0, " m");
        self.range(error.field("dy_m"), motion.error_sd.dy_m, 0.0..=10.0, " m");
        self.degrees(error.field("dtheta_deg"), motion.error_sd.dtheta, 0.0..=360.0, " degrees");
        if let Some(gait) = &motion.gait {
            self.gait(&path.field("gait"), gait);
            let (most, most_turn) = (motion.max_linear_mps, to_degrees(motion.max_angular));
            let speeds = [
                ("least_mps", gait.least_mps, "max_linear_mps", most, "m/s"),
                ("least_degps", to_degrees(gait.least_angular), "max_angular_degps", most_turn, "degrees/s"),
            ];
            for (name, least, greatest_name, greatest, unit) in speeds {
                // A robot of which the greatest is nought does not walk, or not turn, at all.
                if least > greatest && greatest > 0.0 {
                    let message = format!("`{name}` is {least}: it never gets so fast");
                    let expected = format!("at most {greatest} {unit}, its `{greatest_name}`");
                    let fault = ScenarioFault::new(path.field("gait").field(name), message, expected);
                    self.push(fault.judged_with([path.field(greatest_name)]));
                }
            }
        }
    }

    fn gait(&mut self, path: &FieldPath, gait: &Gait) {
        self.range(path.field("step_s"), gait.step_s, 0.05..=5.0, " s");
        self.range(path.field("backward_mps"), gait.backward_mps, 0.001..=5.0, " m/s");
        self.range(path.field("sideways_mps"), gait.sideways_mps, 0.001..=5.0, " m/s");
        self.range(path.field("acceleration_mps2"), gait.acceleration_mps2, 0.01..=1000.0, " m/s²");
        let turning = path.field("angular_acceleration_degps2");
        self.degrees(turning, gait.angular_acceleration, 1.0..=100_000.0, " degrees/s²");
        self.range(path.field("least_mps"), gait.least_mps, 0.0..=1.0, " m/s");
        self.degrees(path.field("least_degps"), gait.least_angular, 0.0..=180.0, " degrees/s");
        let slip = path.field("slip");
        self.range(slip.field("scale"), gait.slip.scale, 0.1..=2.0, "");
        self.range(slip.field("scale_sd"), gait.slip.scale_sd, 0.0..=0.3, "");
        self.degrees(slip.field("drift_sd_degpm"), gait.slip.drift_sd, 0.0..=90.0, " degrees/m");
        let StepNoise { translation_sd_m, heading_per_metre_sd, rotation_sd } = gait.slip.error;
        let error = slip.field("error");
        self.range(error.field("translation_sd_m"), translation_sd_m, 0.0..=1.0, " m");
        self.degrees(error.field("heading_per_metre_sd_deg"), heading_per_metre_sd, 0.0..=180.0, " degrees");
        self.degrees(error.field("rotation_sd_deg"), rotation_sd, 0.0..=180.0, " degrees");
    }

    pub(super) fn kicks(&mut self, path: &FieldPath, kicks: &KickSettings) {
        for (kick_type, kick) in kicks.models() {
            let path = match kick_type {
                KickType::Custom(_) => path.field("own").field(kick_type.name()),
                _ => path.field(kick_type.name()),
            };
            self.kick(&path, kick_type, kick);
        }
        self.range(path.field("wrong_side_speed_factor"), kicks.wrong_side_speed_factor, 0.0..=1.0, "");
        self.range(path.field("wind_up_s"), kicks.wind_up_s, 0.0..=60.0, " s");
        self.range(path.field("extension_s"), kicks.extension_s, 0.0..=60.0, " s");
        self.range(path.field("recovery_s"), kicks.recovery_s, 0.0..=60.0, " s");
        self.degrees(path.field("direction_sd_deg"), kicks.direction_sd, 0.0..=180.0, " degrees");
        self.range(path.field("speed_sd"), kicks.speed_sd, 0.0..=10.0, ", a share of the speed");
    }

    pub(super) fn falls(&mut self, path: &FieldPath, falls: &FallModel) {
        self.range(path.field("falls_per_min"), falls.falls_per_min, 0.0..=1000.0, " a minute");
        self.range(path.field("contact_falls_per_min"), falls.contact_falls_per_min, 0.0..=1000.0, " a minute");
        self.range(path.field("kick_probability"), falls.kick_probability, 0.0..=1.0, "");
        if let Some(CollisionFalls { from_mps, certain_mps }) = falls.collisions {
            let path = path.field("collisions");
            self.range(path.field("from_mps"), from_mps, 0.0..=100.0, " m/s");
            if !(from_mps..=100.0).contains(&certain_mps) {
                let message = format!("`certain_mps` is {certain_mps}, and `from_mps` {from_mps}");
                let fault =
                    ScenarioFault::new(path.field("certain_mps"), message, "at least `from_mps`, at most 100 m/s");
                self.push(fault.judged_with([path.field("from_mps")]));
            }
        }
        self.range(path.field("spread"), falls.spread, 0.0..=3.0, "");
        self.range(path.field("on_back_share"), falls.on_back_share, 0.0..=1.0, "");
        if let Some(probability) = falls.trip_probability {
            self.range(path.field("trip_probability"), probability, 0.0..=1.0, "");
        }
        let times = [("get_up_s", falls.get_up_s), ("get_up_from_back_s", falls.get_up_from_back_s)];
        for (name, time_s) in times {
            if let Some(time_s) = time_s {
                self.range(path.field(name), time_s, 0.0..=600.0, " s");
            }
        }
        self.range(path.field("get_up_failure"), falls.get_up_failure, 0.0..=1.0, "");
        self.range(path.field("get_up_failure_in_contact"), falls.get_up_failure_in_contact, 0.0..=1.0, "");
    }

    pub(super) fn latency(&mut self, path: &FieldPath, latency: Latency) {
        for (name, seconds) in latency.by_name() {
            self.range(path.field(name), seconds, 0.0..=2.0, " s");
        }
    }

    pub(super) fn head(&mut self, path: &FieldPath, head: &HeadLimits) {
        for (name, limit, farthest) in [("yaw_deg", head.yaw, 180.0), ("pitch_deg", head.pitch, 90.0)] {
            let [least, most] = limit.map(to_degrees);
            if least > most || least < -farthest || most > farthest {
                self.value_fault(
                    path.field(name),
                    format!("`{name}` is [{least}, {most}]"),
                    format!("the least and then the greatest angle, both from -{farthest} to {farthest} degrees"),
                );
            }
        }
        let mut before = f32::NEG_INFINITY;
        for (index, limit) in head.pitch_at_yaw.as_slice().iter().enumerate() {
            let [yaw, least, most] = [limit.yaw, limit.pitch[0], limit.pitch[1]].map(to_degrees);
            if !(-180.0..=180.0).contains(&yaw) || yaw <= before || least > most || least < -90.0 || most > 90.0 {
                self.value_fault(
                    path.field("pitch_at_yaw_deg").index(index),
                    format!("the limits of the pitch at a yaw are [{yaw}, {least}, {most}]"),
                    "the yaw, more than the one before and from -180 to 180 degrees, then the least and the greatest pitch, both \
                     from -90 to 90 degrees",
                );
            }
            let [least, most] = head.pitch_at(limit.yaw).map(to_degrees);
            if least > most {
                let message = format!("at a yaw of {yaw} degrees there is no pitch from {least} to {most} degrees");
                let fault = ScenarioFault::new(
                    path.field("pitch_at_yaw_deg").index(index),
                    message,
                    "limits that leave some of `pitch_deg`",
                );
                self.push(fault.judged_with([path.field("pitch_deg")]));
            }
            before = yaw;
        }
        self.degrees(path.field("max_degps"), head.max_speed, 0.0..=3600.0, " degrees/s");
    }

    pub(super) fn sonar(&mut self, path: &FieldPath, sonar: &SonarSettings) {
        const FARTHEST_M: f32 = 10.0;
        self.range(path.field("min_m"), sonar.min_m, 0.0..=FARTHEST_M, " m");
        if !(sonar.max_m > sonar.min_m && sonar.max_m <= FARTHEST_M) {
            let message = format!("`max_m` is {}, and `min_m` {}", sonar.max_m, sonar.min_m);
            let expected = format!("more than `min_m`, at most {FARTHEST_M} m");
            let fault = ScenarioFault::new(path.field("max_m"), message, expected);
            self.push(fault.judged_with([path.field("min_m")]));
        }
        self.degrees(path.field("heading_deg"), sonar.heading, -180.0..=180.0, " degrees");
        self.degrees(path.field("half_angle_deg"), sonar.half_angle, 0.1..=90.0, " degrees");
        self.range(path.field("height_m"), sonar.height_m, 0.0..=2.0, " m");
        let noise = path.field("noise");
        let deviation = 0.0..=FARTHEST_M;
        match sonar.noise {
            SonarNoise::None => {}
            SonarNoise::Gaussian { sd_m } => self.range(noise.field("gaussian.sd_m"), sd_m, deviation, " m"),
            SonarNoise::Uniform { half_width_m } => {
                self.range(noise.field("uniform.half_width_m"), half_width_m, deviation, " m");
            }
            SonarNoise::Outliers { sd_m, probability } => {
                self.range(noise.field("outliers.sd_m"), sd_m, deviation, " m");
                self.probability(noise.field("outliers.probability"), probability);
            }
        }
        self.probability(path.field("miss_probability"), sonar.miss_probability);
        if let Some(rate_hz) = sonar.rate_hz {
            self.range(path.field("rate_hz"), rate_hz, 0.1..=1000.0, " Hz");
        }
        self.probability(path.field("crosstalk_probability"), sonar.crosstalk_probability);
    }

    pub(super) fn odometry(&mut self, path: &FieldPath, odometry: &OdometrySettings) {
        let (path, noise) = (path.field("noise"), &odometry.noise);
        self.range(path.field("translation_sd_m"), noise.translation_sd_m, 0.0..=10.0, " m");
        self.degrees(path.field("heading_per_metre_sd_deg"), noise.heading_per_metre_sd, 0.0..=360.0, " degrees");
        self.degrees(path.field("rotation_sd_deg"), noise.rotation_sd, 0.0..=360.0, " degrees");
        self.range(path.field("translation_scale"), noise.translation_scale, 0.0..=10.0, "");
        self.range(path.field("rotation_scale"), noise.rotation_scale, 0.0..=10.0, "");
    }

    pub(super) fn vision(&mut self, path: &FieldPath, vision: &VisionSettings) {
        let (path, noise) = (path.field("noise"), &vision.noise);
        let classes = [
            ("ball", noise.ball),
            ("goal_posts", noise.goal_posts),
            ("robots", noise.robots),
            ("lines", noise.lines),
            ("junctions", noise.junctions),
            ("penalty_crosses", noise.penalty_crosses),
            ("centre_circle", noise.centre_circle),
        ];
        for (name, class) in classes {
            let path = path.field(name);
            self.range(path.field("pixel_sd"), class.pixel_sd, 0.0..=1000.0, " pixels");
            self.probability(path.field("miss_probability"), class.miss_probability);
            self.probability(path.field("false_positive_probability"), class.false_positive_probability);
            if let Some(distance) = class.max_distance_m {
                self.range(path.field("max_distance_m"), distance, 0.0..=1000.0, " m");
            }
            if let Some(falloff) = class.falloff {
                let path = path.field("falloff");
                self.positive(path.field("half_distance_m"), falloff.half_distance_m, 1000.0, " m");
                self.range(path.field("exponent"), falloff.exponent, 0.5..=100.0, "");
            }
        }
        self.degrees(path.field("head_angle_sd_deg"), noise.head_angle_sd, 0.0..=180.0, " degrees");
        let gaze = path.field("gaze");
        self.degrees(gaze.field("bias_sd_deg"), noise.gaze.bias_sd, 0.0..=180.0, " degrees");
        self.degrees(gaze.field("standing_sd_deg"), noise.gaze.standing_sd, 0.0..=180.0, " degrees");
        self.degrees(gaze.field("walking_sd_deg"), noise.gaze.walking_sd, 0.0..=180.0, " degrees");
        self.range(gaze.field("correlation_s"), noise.gaze.correlation_s, 0.0..=3600.0, " s");
        for (name, class) in [("false_balls", noise.false_balls), ("false_robots", noise.false_robots)] {
            let path = path.field(name);
            self.range(path.field("per_minute"), class.per_minute, 0.0..=600.0, " a minute");
            self.range(path.field("life_s"), class.life_s, 0.0..=3600.0, " s");
        }
        let feet = path.field("hidden_feet");
        self.range(feet.field("bias"), noise.hidden_feet.bias, -1.0..=10.0, ", a share of the distance");
        self.range(feet.field("sd"), noise.hidden_feet.sd, 0.0..=10.0, ", a share of the distance");
    }

    pub(super) fn cameras(&mut self, path: &FieldPath, cameras: &CameraSettings) {
        self.range(path.field("width"), cameras.width, 1..=4096, " pixels");
        self.range(path.field("height"), cameras.height, 1..=4096, " pixels");
        self.degrees(path.field("diagonal_fov_deg"), cameras.diagonal_fov, 1.0..=170.0, " degrees");
        self.mounts(&path.field("mounts"), &cameras.mounts);
        self.range(path.field("every_cycles"), cameras.every_cycles, 1..=100_000, " cycles");
        let lens = path.field("lens");
        for (index, factor) in cameras.lens.distortion.into_iter().enumerate() {
            self.range(lens.field("distortion").index(index), factor, -1.0..=1.0, "");
        }
        self.range(lens.field("vignetting"), cameras.lens.vignetting, 0.0..=1.0, ", a share of the light");
        self.range(lens.field("exposure_s"), cameras.lens.exposure_s, 0.0..=1.0, " s");
        let (path, noise) = (path.field("noise"), &cameras.noise);
        self.range(path.field("brightness"), noise.brightness, 0.0..=10.0, "");
        self.range(path.field("brightness_sd"), noise.brightness_sd, 0.0..=10.0, "");
        for (index, shift) in noise.colour_shift.into_iter().enumerate() {
            self.range(path.field("colour_shift").index(index), shift, -255.0..=255.0, ", of 255");
        }
        self.range(path.field("colour_shift_sd"), noise.colour_shift_sd, 0.0..=255.0, ", of 255");
        self.range(path.field("pixel_sd"), noise.pixel_sd, 0.0..=255.0, ", of 255");
        self.range(path.field("blur_px"), noise.blur_px, 0.0..=ImageNoise::MOST_BLUR_PX, " pixels");
    }

    pub(super) fn messages(&mut self, path: &FieldPath, messages: &MessageSettings) {
        self.probability(path.field("loss"), messages.loss);
        self.range(path.field("delay_cycles"), messages.delay_cycles, 1..=1000, " cycles");
        self.range(path.field("jitter_cycles"), messages.jitter_cycles, 0..=1000, " cycles");
        if let Some(range) = messages.range_m {
            self.range(path.field("range_m"), range, 0.0..=1000.0, " m");
        }
        self.range(path.field("max_text_bytes"), messages.max_text_bytes, 0..=LARGEST_DATAGRAM_BYTES, " bytes");
        self.message_limits(&path.field("robots"), &messages.robots);
    }

    pub(super) fn message_limits(&mut self, path: &FieldPath, limits: &MessageLimits) {
        let most = limits.max_text_bytes.unwrap_or_default();
        self.range(path.field("max_text_bytes"), most, 0..=LARGEST_DATAGRAM_BYTES, " bytes");
    }
}

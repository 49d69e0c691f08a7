//! Checks single settings of which several values must agree.

use bevy::math::Vec3;

use super::Checks;
use crate::scenario::field_path::FieldPath;
use naoisis_core::ball::FASTEST_MPS;
use naoisis_core::camera_model::CameraIntrinsics;
use naoisis_core::game::Rules;
use naoisis_core::geometry::to_degrees;
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::falls::{CollisionFalls, FallModel};
use naoisis_core::robot::head::HeadLimits;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::motion::MotionSettings;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::sonar::SonarSettings;

impl Checks {
    pub(super) fn rules(&mut self, path: &FieldPath, rules: &Rules) {
        let Rules { fall_from_mps, fall_certain_mps, dive_s, dive_down_s, .. } = *rules;
        if (0.0..fall_from_mps).contains(&fall_certain_mps) {
            let message = format!("`fall_certain_mps` is {fall_certain_mps}");
            let expected = format!("at least {fall_from_mps} m/s, the rules' `fall_from_mps`");
            self.fault(path.field("fall_certain_mps"), message, expected);
        }
        if dive_down_s > dive_s {
            let message = format!("`dive_down_s` is {dive_down_s}");
            self.fault(path.field("dive_down_s"), message, format!("at most {dive_s} s, the rules' `dive_s`"));
        }
    }

    pub(super) fn ball_speed(&mut self, path: FieldPath, velocity_mps: Vec3) {
        if velocity_mps.length() > FASTEST_MPS {
            let message = format!("the ball's speed is {} m/s", velocity_mps.length());
            self.fault(path, message, format!("a speed of at most {FASTEST_MPS} m/s"));
        }
    }

    pub(super) fn motion(&mut self, path: &FieldPath, motion: &MotionSettings) {
        if let Some(gait) = &motion.gait {
            let (most, most_turn) = (motion.max_linear_mps, to_degrees(motion.max_angular));
            let speeds = [
                ("least_mps", gait.least_mps, "max_linear_mps", most, "m/s"),
                ("least_degps", to_degrees(gait.least_angular), "max_angular_degps", most_turn, "degrees/s"),
            ];
            for (name, least, greatest_name, greatest, unit) in speeds {
                // A robot whose greatest speed is zero does not walk or turn at all.
                if least > greatest && greatest > 0.0 {
                    let message = format!("`{name}` is {least}: it never gets so fast");
                    let expected = format!("at most {greatest} {unit}, its `{greatest_name}`");
                    self.fault(path.field("gait").field(name), message, expected);
                }
            }
        }
    }

    pub(super) fn kicks(&mut self, path: &FieldPath, kicks: &KickSettings) {
        for (kick_type, kick) in kicks.models() {
            let path = match kick_type {
                KickType::Custom(_) => path.field("own").field(kick_type.name()),
                _ => path.field(kick_type.name()),
            };
            self.kick(&path, kick_type, kick);
        }
    }

    pub(super) fn falls(&mut self, path: &FieldPath, falls: &FallModel) {
        if let Some(CollisionFalls { from_mps, certain_mps }) = falls.collisions {
            let path = path.field("collisions");
            if !(from_mps..=100.0).contains(&certain_mps) {
                let message = format!("`certain_mps` is {certain_mps}, and `from_mps` {from_mps}");
                self.fault(path.field("certain_mps"), message, "at least `from_mps`, at most 100 m/s");
            }
        }
    }

    pub(super) fn head(&mut self, path: &FieldPath, head: &HeadLimits) {
        for (name, limit) in [("yaw_deg", head.yaw), ("pitch_deg", head.pitch)] {
            let [least, most] = limit.map(to_degrees);
            if least > most {
                self.fault(
                    path.field(name),
                    format!("`{name}` is [{least}, {most}]"),
                    "the least and then the greatest angle",
                );
            }
        }
        let mut before = f32::NEG_INFINITY;
        for (index, limit) in head.pitch_at_yaw.as_slice().iter().enumerate() {
            let [yaw, least, most] = [limit.yaw, limit.pitch[0], limit.pitch[1]].map(to_degrees);
            if !(-180.0..=180.0).contains(&yaw) || yaw <= before || least > most || least < -90.0 || most > 90.0 {
                self.fault(
                    path.field("pitch_at_yaw_deg").index(index),
                    format!("the limits of the pitch at a yaw are [{yaw}, {least}, {most}]"),
                    "the yaw, more than the one before and from -180 to 180 degrees, then the least and the greatest pitch, both \
                     from -90 to 90 degrees",
                );
            }
            let [least, most] = head.pitch_at(limit.yaw).map(to_degrees);
            if least > most {
                let message = format!("at a yaw of {yaw} degrees there is no pitch from {least} to {most} degrees");
                self.fault(
                    path.field("pitch_at_yaw_deg").index(index),
                    message,
                    "limits that leave some of `pitch_deg`",
                );
            }
            before = yaw;
        }
    }

    pub(super) fn sonar(&mut self, path: &FieldPath, sonar: &SonarSettings) {
        const FARTHEST_M: f32 = 10.0;
        if !(sonar.max_m > sonar.min_m && sonar.max_m <= FARTHEST_M) {
            let message = format!("`max_m` is {}, and `min_m` {}", sonar.max_m, sonar.min_m);
            self.fault(path.field("max_m"), message, format!("more than `min_m`, at most {FARTHEST_M} m"));
        }
    }

    /// Checks that cameras have distinct names, are on the robot, and have lenses that show each place only once.
    pub(super) fn cameras(&mut self, path: &FieldPath, cameras: &CameraSettings) {
        let mounts = path.field("mounts");
        self.mounts(&mounts, &cameras.mounts);
        let lens = path.field("lens").field("distortion");
        if cameras.calibration.is_some() && !cameras.lens.distortion.is_none() {
            self.fault(
                lens.clone(),
                "`intrinsics` has the distortion already",
                "no `lens.distortion` beside `intrinsics`",
            );
        }
        let has_calibration = cameras.calibration.is_some();
        let place = if has_calibration { path.field("intrinsics") } else { lens };
        self.optics(&place, CameraIntrinsics::from(cameras));
        for (index, mount) in cameras.mounts.iter().enumerate() {
            let path = mounts.index(index);
            if mount.distortion.is_some()
                && (mount.calibration.is_some() || has_calibration && mount.diagonal_fov.is_none())
            {
                let message = "`intrinsics` has the distortion already";
                self.fault(path.field("distortion"), message, "no `distortion` beside `intrinsics`");
            }
            if !mount.is_as_others() {
                let own = if mount.calibration.is_some() { path.field("intrinsics") } else { path };
                self.optics(&own, cameras.intrinsics(mount));
            }
        }
    }

    /// Checks that a camera's field of view is limited, and that no pixel shows two places.
    fn optics(&mut self, path: &FieldPath, intrinsics: CameraIntrinsics) {
        /// The greatest slope of a camera's ray: the tangent of 85°.
        const STEEPEST: f32 = 11.4;

        let half = intrinsics.half_slopes();
        let corners = intrinsics.outline().map(|pixel| intrinsics.slope(pixel).length()).fold(0.0, f32::max);
        let holds_up_to = intrinsics.distortion.holds_up_to();
        if corners > holds_up_to {
            let (message, expected) = if intrinsics.distortion.is_fisheye() && holds_up_to > STEEPEST {
                (
                    "the image of the fisheye lens reaches more than 85° from its axis",
                    "a smaller field of view, a greater focal length or a smaller image",
                )
            } else {
                (
                    "the distortion cannot be inverted within the image",
                    "coefficients with which the distorted radius grows up to the corners of the image",
                )
            };
            self.fault(path.clone(), message, expected);
        } else if half.max_element() > STEEPEST {
            let message = format!("the image shows slopes of up to {:.1} from the camera's axis", half.max_element());
            self.fault(path.clone(), message, format!("focal lengths of at least half the image's size / {STEEPEST}"));
        }
    }
}

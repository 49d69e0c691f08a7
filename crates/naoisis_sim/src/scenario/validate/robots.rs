//! Checks the bodies, cameras and kicks of robots: whether they could be built and walk on a pitch.

use bevy::math::{Vec2, Vec3};

use super::Checks;
use crate::scenario::field_path::FieldPath;
use crate::scenario::robot_settings::RobotSettings;
use naoisis_core::camera_model::CameraMounts;
use naoisis_core::kick_geometry::{KickGeometry, KickType};
use naoisis_core::robot::body::{Arms, Body, BodyBox, Legs};
use naoisis_core::robot::kick::KickModel;
use naoisis_sensing::sensing::sonar::SonarSettings;

/// Extent of a robot on the ground at most, m: a pitch must have room for several robots.
const WIDEST_M: f32 = 1.0;
/// Height of a robot at most, m.
const HIGHEST_M: f32 = 2.5;
/// Length of a mast beyond a robot's body at most, m.
const MAST_M: f32 = 0.5;
/// Height of the neck joint above the torso at most, as a share of the robot's height.
const LONGEST_NECK: f32 = 0.2;
/// Tolerance within which measures of a robot agree, m.
const SAME_M: f32 = 0.01;

/// The body of a robot, and the sensors on it.
pub(super) struct SensorsAtBody<'a> {
    pub body: &'a Body,
    pub mounts: &'a CameraMounts,
    pub sonar: &'a SonarSettings,
}

impl<'a> SensorsAtBody<'a> {
    pub fn of(settings: &'a RobotSettings) -> Self {
        Self { body: &settings.body, mounts: &settings.cameras.mounts, sonar: &settings.sonar }
    }
}

impl Checks {
    pub(super) fn body(&mut self, path: &FieldPath, body: &Body) {
        self.body_box(&path.field("torso"), &body.torso);
        self.body_box(&path.field("base"), &body.base);
        if body.neck_m.truncate().abs().max_element() > WIDEST_M || !(0.0..=body.height_m).contains(&body.neck_m.z) {
            let message = format!("the neck is at ({}, {}, {})", body.neck_m.x, body.neck_m.y, body.neck_m.z);
            let expected = format!("a place up to {} m high, the robot's height", body.height_m);
            self.fault(path.field("neck_m"), message, expected);
        }
        for (name, part) in [("torso", &body.torso), ("base", &body.base)] {
            self.below_top(path.field(name).field("z_m").index(1), part.z_m[1], body);
        }
        let lowest = body.torso.z_m[0].min(body.base.z_m[0]);
        if lowest > SAME_M {
            let message = format!("the lowest part of the robot is {lowest} m above the ground");
            self.fault(path.field("base").field("z_m").index(0), message, "0 m: it stands on the ground");
        }
        self.trunk_on_base(path, body);
        self.below_top(path.field("lying_height_m"), body.lying_height_m, body);
        if body.foot_y_m > body.base.half_width_m + SAME_M {
            let message = format!("`foot_y_m` is {}", body.foot_y_m);
            let expected = format!("at most {} m, half the width of the base", body.base.half_width_m);
            self.fault(path.field("foot_y_m"), message, expected);
        }
        let band = path.field("waistband");
        self.span(&band.field("z_m"), body.waistband.z_m);
        self.below_top(band.field("z_m").index(1), body.waistband.z_m[1], body);
        let half_size = body.waistband.half_size_m;
        if half_size.min_element() <= 0.0 || half_size.max_element() > WIDEST_M {
            let message = format!("`half_size_m` is [{}, {}]", half_size.x, half_size.y);
            self.fault(band.field("half_size_m"), message, format!("more than 0, at most {WIDEST_M} m each"));
        }
        if let Some(height_m) = body.look.number_z_m {
            let number = path.field("look").field("number_z_m");
            self.below_top(number, height_m, body);
        }
        if let Some(Legs { hip_m, thigh_m, shank_m, ankle_m }) = body.legs {
            let legs = path.field("legs");
            self.joint(&legs.field("hip_m"), hip_m, body);
            let length = thigh_m + shank_m + ankle_m;
            if length > hip_m.z + SAME_M {
                let message = format!("the legs are {length:.3} m long, and the hip is {} m high", hip_m.z);
                let expected = "`thigh_m`, `shank_m` and `ankle_m` that add up to the hip's height at most";
                self.fault(legs.field("hip_m"), message, expected);
            } else if length < hip_m.z - SAME_M {
                let message = format!("the hip is {} m high, and the legs are {length:.3} m long", hip_m.z);
                let expected = "`thigh_m`, `shank_m` and `ankle_m` that reach from the hip to the ground";
                self.fault(legs.field("hip_m"), message, expected);
            }
        }
        if let Some(Arms { shoulder_m, .. }) = body.arms {
            let arms = path.field("arms");
            self.joint(&arms.field("shoulder_m"), shoulder_m, body);
        }
    }

    /// Checks that torso, base, neck and waistband make up one body: the torso is on the base, the neck on the torso, and the band is
    /// visible.
    fn trunk_on_base(&mut self, path: &FieldPath, body: &Body) {
        let (Body { torso, base, .. }, torso_path) = (body, path.field("torso"));
        let is_box = |part: &BodyBox| part.x_m[0] < part.x_m[1] && part.z_m[0] < part.z_m[1];
        if !is_box(torso) || !is_box(base) {
            return;
        }
        let [over, under] = [torso.z_m[0] - base.z_m[1], base.z_m[0] - torso.z_m[1]];
        if over > SAME_M || under > SAME_M {
            let message = format!("there are {:.3} m between the torso and the base", over.max(under));
            let expected = format!("a torso that begins where the base ends, at {} m", base.z_m[1]);
            self.fault(torso_path.field("z_m"), message, expected);
        }
        if torso.x_m[0] >= base.x_m[1] || base.x_m[0] >= torso.x_m[1] {
            let message = format!("the torso is from {} to {} m, not above the base", torso.x_m[0], torso.x_m[1]);
            let expected = format!("a torso above the base, which is from {} to {} m", base.x_m[0], base.x_m[1]);
            self.fault(torso_path.field("x_m"), message, expected);
        }
        let (neck, most) = (body.neck_m.z, torso.z_m[1].max(base.z_m[1]) + LONGEST_NECK * body.height_m);
        if neck > most && neck <= body.height_m {
            let message = format!("the neck is {neck} m high, and the torso ends at {} m", torso.z_m[1]);
            self.fault(path.field("neck_m"), message, format!("a neck on the torso, at most {most:.3} m"));
        }
        let [depth, width] = [torso.x_m[0].abs().max(torso.x_m[1].abs()), body.drawn_half_width_m()];
        let Vec2 { x, y } = body.waistband.half_size_m;
        if x > 0.0 && y > 0.0 && x <= depth && y <= width {
            let message = format!("the waistband of ({x}, {y}) m is inside the trunk, where no camera sees it");
            let expected = format!("half sizes of more than {depth} m along x or {width:.3} m along y");
            self.fault(path.field("waistband").field("half_size_m"), message, expected);
        }
    }

    /// Checks that a height is not above the top of the robot's head.
    fn below_top(&mut self, path: FieldPath, height_m: f32, body: &Body) {
        if height_m > body.height_m + SAME_M && body.height_m > 0.0 {
            let name = path.name();
            let expected = format!("at most {} m, the robot's `height_m`", body.height_m);
            self.fault(path, format!("`{name}` is {height_m}"), expected);
        }
    }

    /// Checks that a joint is within the robot.
    fn joint(&mut self, path: &FieldPath, place: Vec3, body: &Body) {
        if place.truncate().abs().max_element() > WIDEST_M || !(0.0..=body.height_m + SAME_M).contains(&place.z) {
            let name = path.last_field().unwrap_or_default();
            let message = format!("`{name}` is ({}, {}, {})", place.x, place.y, place.z);
            let expected =
                format!("a place at most {WIDEST_M} m aside and {} m high, the robot's `height_m`", body.height_m);
            self.fault(path.clone(), message, expected);
        }
    }

    /// Checks that cameras and sonars are on the robot, or at most on a mast.
    pub(super) fn sensors_at_body(&mut self, [cameras, sonar]: [&FieldPath; 2], robot: SensorsAtBody) {
        let SensorsAtBody { body, mounts, sonar: settings } = robot;
        let reach_m = body.torso.reach().max(body.base.reach()) + MAST_M;
        let top_m = body.height_m + MAST_M;
        for (index, mount) in mounts.as_slice().iter().enumerate() {
            let lens = mount.lens_m;
            if lens.truncate().length() > reach_m || lens.z > top_m {
                let message = format!("the camera is at ({}, {}, {}), away from the robot", lens.x, lens.y, lens.z);
                let expected =
                    format!("a place at most {reach_m:.2} m aside and {top_m:.2} m high: {MAST_M} m beyond its body");
                let place = cameras.field("mounts").index(index).field("position_m");
                self.fault(place, message, expected);
            }
        }
        if settings.fitted && settings.height_m > top_m {
            let message = format!("`height_m` is {}", settings.height_m);
            let expected = format!("at most {top_m:.2} m: {MAST_M} m above the robot");
            self.fault(sonar.field("height_m"), message, expected);
        }
    }

    fn body_box(&mut self, path: &FieldPath, part: &BodyBox) {
        self.span(&path.field("x_m"), part.x_m);
        self.span(&path.field("z_m"), part.z_m);
    }

    /// Checks that the second of two numbers is greater than the first.
    fn span(&mut self, path: &FieldPath, [least, most]: [f32; 2]) {
        if least >= most {
            let name = path.name();
            self.fault(path.clone(), format!("`{name}` is [{least}, {most}]"), "the lesser and then the greater");
        }
    }

    pub(super) fn mounts(&mut self, path: &FieldPath, mounts: &CameraMounts) {
        for (index, mount) in mounts.as_slice().iter().enumerate() {
            let path = path.index(index);
            if mounts.order(mount.name) != index {
                let message = format!("there is a camera `{}` already", mount.name);
                self.fault(path.field("name"), message, "a name that no other camera of the robot has");
            }
            let lens = mount.lens_m;
            if lens.truncate().abs().max_element() > WIDEST_M || !(0.0..=HIGHEST_M).contains(&lens.z) {
                let message = format!("the camera is at ({}, {}, {})", lens.x, lens.y, lens.z);
                self.fault(path.field("position_m"), message, format!("a place up to {HIGHEST_M} m high"));
            }
        }
    }

    pub(super) fn kick(&mut self, path: &FieldPath, kick_type: KickType, kick: &KickModel) {
        if kick.min_distance_m > kick.max_distance_m {
            let message = format!("`min_distance_m` is {}", kick.min_distance_m);
            let expected = format!("at most {} m, its `max_distance_m`", kick.max_distance_m);
            self.fault(path.field("min_distance_m"), message, expected);
        }
        match (&kick.region, kick_type) {
            (Some(region), _) => self.kick_region(&path.field("region"), region),
            (None, KickType::Custom(name)) => {
                let expected = "`region`, with `x_m`, `y_m`, `foot_m` and `best_m`: where the ball must lie";
                self.fault(path.clone(), format!("the kick `{name}` does not say where the ball must lie"), expected);
            }
            (None, _) => {}
        }
    }

    fn kick_region(&mut self, path: &FieldPath, region: &KickGeometry) {
        self.span(&path.field("x_m"), region.x_m);
        self.span(&path.field("y_m"), region.y_m);
        let Vec2 { x, y } = region.best_m;
        if !region.admits(region.best_m) {
            let expected = "a place in the rectangle of `x_m` and `y_m`";
            self.fault(path.field("best_m"), format!("`best_m` is ({x}, {y})"), expected);
        }
    }
}

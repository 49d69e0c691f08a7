//! The bodies, cameras and kicks of robots: within what could be built and walk on a pitch.

use bevy::math::Vec2;

use super::{Checks, ScenarioFault};
use crate::camera_model::CameraMounts;
use crate::geometry::to_degrees;
use crate::kick_geometry::KickGeometry;
use crate::robot::body::{Arms, Body, BodyBox, Legs};
use crate::scenario::field_path::FieldPath;

/// The greatest extent of a robot on the ground, m: a pitch has room for several.
const WIDEST_M: f32 = 1.0;
/// The greatest height of a robot, m.
const HIGHEST_M: f32 = 2.5;

impl Checks {
    pub(super) fn body(&mut self, path: &FieldPath, body: &Body) {
        self.body_box(&path.field("torso"), &body.torso);
        self.body_box(&path.field("base"), &body.base);
        self.positive(path.field("height_m"), body.height_m, HIGHEST_M, " m");
        self.positive(path.field("lying_height_m"), body.lying_height_m, HIGHEST_M, " m");
        self.range(path.field("foot_y_m"), body.foot_y_m, 0.0..=WIDEST_M, " m");
        if body.neck_m.truncate().abs().max_element() > WIDEST_M || !(0.0..=body.height_m).contains(&body.neck_m.z) {
            let message = format!("the neck is at ({}, {}, {})", body.neck_m.x, body.neck_m.y, body.neck_m.z);
            let expected = format!("a place up to {} m high, the robot's height", body.height_m);
            let fault = ScenarioFault::new(path.field("neck_m"), message, expected);
            self.push(fault.judged_with([path.field("height_m")]));
        }
        let band = path.field("waistband");
        self.span(&band.field("z_m"), body.waistband.z_m, [0.0, HIGHEST_M]);
        let half_size = body.waistband.half_size_m;
        for (index, half) in [half_size.x, half_size.y].into_iter().enumerate() {
            self.positive(band.field("half_size_m").index(index), half, WIDEST_M, " m");
        }
        if let Some(Legs { thigh_m, shank_m, ankle_m, .. }) = body.legs {
            let path = path.field("legs");
            for (name, length) in [("thigh_m", thigh_m), ("shank_m", shank_m), ("ankle_m", ankle_m)] {
                self.positive(path.field(name), length, HIGHEST_M, " m");
            }
        }
        if let Some(Arms { length_m, .. }) = body.arms {
            self.positive(path.field("arms").field("length_m"), length_m, HIGHEST_M, " m");
        }
    }

    fn body_box(&mut self, path: &FieldPath, part: &BodyBox) {
        self.span(&path.field("x_m"), part.x_m, [-WIDEST_M, WIDEST_M]);
        self.positive(path.field("half_width_m"), part.half_width_m, WIDEST_M, " m");
        self.span(&path.field("z_m"), part.z_m, [0.0, HIGHEST_M]);
    }

    /// That the second of two numbers is more than the first, both within limits, m.
    fn span(&mut self, path: &FieldPath, [least, most]: [f32; 2], limits: [f32; 2]) {
        if !(least < most && limits[0] <= least && most <= limits[1]) {
            let name = path.last_field().unwrap_or_default().to_owned();
            let expected = format!("the lesser and then the greater, both from {} to {} m", limits[0], limits[1]);
            self.value_fault(path.clone(), format!("`{name}` is [{least}, {most}]"), expected);
        }
    }

    pub(super) fn mounts(&mut self, path: &FieldPath, mounts: &CameraMounts) {
        for (index, mount) in mounts.as_slice().iter().enumerate() {
            let path = path.index(index);
            if mounts.order(mount.name) != index {
                let message = format!("there is a camera `{}` already", mount.name);
                self.value_fault(path.field("name"), message, "a name that no other camera of the robot has");
            }
            let lens = mount.lens_m;
            if lens.truncate().abs().max_element() > WIDEST_M || !(0.0..=HIGHEST_M).contains(&lens.z) {
                let message = format!("the camera is at ({}, {}, {})", lens.x, lens.y, lens.z);
                self.value_fault(path.field("position_m"), message, format!("a place up to {HIGHEST_M} m high"));
            }
            let tilt_deg = to_degrees(mount.tilt());
            self.range(path.field("tilt_deg"), tilt_deg, -90.0..=90.0, " degrees");
            if let Some(fov) = mount.diagonal_fov {
                self.degrees(path.field("diagonal_fov_deg"), fov, 1.0..=170.0, " degrees");
            }
            for (index, factor) in mount.distortion.into_iter().flatten().enumerate() {
                self.range(path.field("distortion").index(index), factor, -1.0..=1.0, "");
            }
            if let Some(cycles) = mount.every_cycles {
                self.range(path.field("every_cycles"), cycles, 1..=100_000, " cycles");
            }
            for (side, pixels) in mount.size.into_iter().flatten().enumerate() {
                self.range(path.field("size").index(side), pixels, 1..=4096, " pixels");
            }
        }
    }

    pub(super) fn kick_region(&mut self, path: &FieldPath, region: &KickGeometry) {
        self.span(&path.field("x_m"), region.x_m, [-WIDEST_M, 2.0 * WIDEST_M]);
        self.span(&path.field("y_m"), region.y_m, [-WIDEST_M, WIDEST_M]);
        let Vec2 { x, y } = region.best_m;
        if !region.admits(region.best_m) {
            let expected = "a place in the rectangle of `x_m` and `y_m`";
            let fault = ScenarioFault::new(path.field("best_m"), format!("`best_m` is ({x}, {y})"), expected);
            self.push(fault.judged_with(["x_m", "y_m"].map(|field| path.field(field))));
        }
    }
}

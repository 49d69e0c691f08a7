//! Drawing of the NAO, and of robots that look like one: its limbs, stretched to the measures of their bodies.

use bevy::math::{Affine3A, Mat3, Quat, Vec2, Vec3, Vec3A};

use super::by_measures::{Trunk, chassis, mast};
use super::number::{self, Plates};
use super::{PartList, RobotPart, labels};
use crate::appearance::colours::Colour;
use crate::appearance::posing::{Limb, on_side};
use crate::appearance::shapes::Shape;
use naoisis_core::robot::body::{Body, Legs};
use naoisis_core::robot::look::Top;
use naoisis_core::team::RobotId;

/// The parts of the detailed design: close to the real robot, with a number on chest and back.
pub(super) fn detailed(id: RobotId, body: &Body) -> Vec<RobotPart> {
    let stretch = Stretch::to(body);
    let mut list = PartList::new(id, body, 96);
    trunk(&mut list, id, body, &stretch);
    head(&mut list);
    for side in 0..2 {
        arm(&mut list, side);
        leg(&mut list, side);
    }
    stretch.fit(list, id, body)
}

/// The parts of the simple design: a few boxes.
pub(super) fn simple(id: RobotId, body: &Body) -> Vec<RobotPart> {
    let Legs { thigh_m, shank_m, ankle_m, .. } = Legs::default();
    let mut list = PartList::new(id, body, 16);
    let [shell, joint] = list.colours();
    let band_size = (2.0 * body.waistband.half_size_m).extend(body.waistband.height());
    list.band(id.team, body, Shape::Box { half_size: band_size / 2.0 });
    list.cuboid(Limb::Trunk, shell, Vec3::new(0.1, 0.15, 0.118), Vec3::Z * 0.409);
    if list.has_jersey {
        number::write(&mut list, id.number, &Plates { x_m: [0.05, -0.05], z_m: 0.412, size: 1.4 });
    }
    list.cuboid(Limb::Head, shell, Vec3::new(0.1, 0.11, 0.105), Vec3::Z * 0.061);
    // The face is dark, so that front and back differ.
    list.cuboid(Limb::Head, joint, Vec3::new(0.01, 0.08, 0.04), Vec3::new(0.0475, 0.0, 0.065));
    for side in 0..2 {
        let arm = on_side(Vec3::new(0.0, 0.012, -0.07), side);
        list.cuboid(Limb::ARMS[side], shell, Vec3::new(0.05, 0.045, 0.17), arm);
        let thigh = Vec3::Z * (-thigh_m / 2.0);
        list.cuboid(Limb::THIGHS[side], joint, Vec3::new(0.07, 0.07, thigh_m), thigh);
        let shank = Vec3::Z * (-(shank_m + 0.01) / 2.0);
        list.cuboid(Limb::SHANKS[side], shell, Vec3::new(0.066, 0.066, shank_m + 0.01), shank);
        let height = 0.036;
        let foot = on_side(Vec3::new(0.025, 0.003, height / 2.0 - ankle_m), side);
        list.cuboid(Limb::FEET[side], shell, Vec3::new(0.15, 0.084, height), foot);
    }
    Stretch::to(body).fit(list, id, body)
}

/// Adds the pelvis, the waistband, the chest that widens to the shoulders, collar and neck, the button on the chest, and the plates with the
/// number.
fn trunk(list: &mut PartList, id: RobotId, body: &Body, stretch: &Stretch) {
    let ([shell, joint], label, look) = (list.colours(), list.label, list.look);
    let trunk = Limb::Trunk;
    list.ellipsoid(trunk, joint, Vec3::new(0.046, 0.062, 0.03), Vec3::Z * 0.246);
    let radii = body.waistband.half_size_m;
    let band = Shape::Frustum { bottom: radii, top: radii, half_height: body.waistband.height() / 2.0 };
    list.band(id.team, body, band);
    let (chest, shoulders, collar) = (Vec2::new(0.053, 0.07), Vec2::new(0.061, 0.09), Vec2::new(0.036, 0.05));
    list.frustum(trunk, shell, [(chest, 0.35), (shoulders, 0.425)]);
    list.frustum(trunk, shell, [(shoulders, 0.425), (collar, 0.452)]);
    list.frustum(trunk, joint, [(Vec2::splat(0.022), 0.44), (Vec2::splat(0.022), 0.475)]);
    let button = Affine3A::from_mat3_translation(along_x(), Vec3::new(0.058, 0.0, 0.427));
    let shape = Shape::cylinder(0.011, 0.012);
    list.parts.push(RobotPart { frame: trunk, label, colour: joint, shape, frame_from_shape: button });
    let mut plates = Plates::of_nao();
    plates.z_m = look.number_z_m.map_or(plates.z_m, |z_m| stretch.trunk_before(z_m));
    for (facing, is_there) in [(1.0, look.number.chest), (-1.0, look.number.back)] {
        if is_there {
            let middle = Vec3::new(facing * 0.057, 0.0, plates.z_m);
            list.cuboid(trunk, Colour(look.plates), Vec3::new(0.012, 0.088, 0.066), middle);
        }
    }
    number::write(list, id.number, &plates);
}

/// Adds the skull with a brow, eyes, cameras in forehead and chin, and ears.
fn head(list: &mut PartList) {
    let ([shell, joint], label, eyes) = (list.colours(), list.label, Colour(list.look.eyes));
    let head = Limb::Head;
    let middle = Vec3::Z * 0.055;
    list.ellipsoid(head, shell, Vec3::new(0.057, 0.062, 0.0535), middle);
    list.ellipsoid(head, shell, Vec3::new(0.03, 0.05, 0.02), middle + Vec3::new(0.024, 0.0, 0.03));
    list.ball(head, joint, 0.0085, middle + Vec3::new(0.049, 0.0, 0.025));
    list.ball(head, joint, 0.0085, middle + Vec3::new(0.049, 0.0, -0.024));
    for side in 0..2 {
        let eye = on_side(Vec3::new(0.0445, 0.025, 0.004), side);
        list.ellipsoid(head, joint, Vec3::new(0.008, 0.0165, 0.0165), middle + eye);
        list.ellipsoid(head, eyes, Vec3::new(0.0105, 0.0115, 0.0115), middle + eye);
        let ear = Affine3A::from_mat3_translation(along_y(), middle + on_side(Vec3::new(-0.004, 0.057, 0.0), side));
        let shape = Shape::cylinder(0.031, 0.02);
        list.parts.push(RobotPart { frame: head, label, colour: joint, shape, frame_from_shape: ear });
        let cap = middle + on_side(Vec3::new(-0.004, 0.066, 0.0), side);
        list.ellipsoid(head, shell, Vec3::new(0.021, 0.006, 0.021), cap);
    }
}

/// Adds an arm, bent at the elbow.
fn arm(list: &mut PartList, side: usize) {
    let [shell, joint] = list.colours();
    let arm = Limb::ARMS[side];
    let elbow = on_side(Vec3::new(0.0, 0.022, -0.098), side);
    let wrist = on_side(Vec3::new(0.062, 0.012, -0.142), side);
    list.ball(arm, joint, 0.032, Vec3::ZERO);
    list.ellipsoid(arm, shell, Vec3::new(0.037, 0.034, 0.037), on_side(Vec3::new(0.0, 0.006, 0.002), side));
    list.rod(arm, shell, 0.025, [on_side(Vec3::new(0.0, 0.008, -0.02), side), elbow * 0.86]);
    list.ball(arm, joint, 0.025, elbow);
    list.rod(arm, shell, 0.0225, [elbow.lerp(wrist, 0.2), wrist]);
    let hand = wrist + on_side(Vec3::new(0.022, 0.0, -0.012), side);
    list.ball(arm, joint, 0.019, hand);
    for finger in [-1.0, 1.0] {
        let knuckle = hand + Vec3::new(0.01, finger * 0.009, 0.002);
        list.rod(arm, shell, 0.007, [knuckle, knuckle + Vec3::new(0.02, 0.0, -0.014)]);
    }
}

/// Adds a leg: shells over the joints.
fn leg(list: &mut PartList, side: usize) {
    let Legs { thigh_m, shank_m, ankle_m, .. } = Legs::default();
    let [shell, joint] = list.colours();
    let [thigh, shank, foot] = [Limb::THIGHS[side], Limb::SHANKS[side], Limb::FEET[side]];
    list.ball(thigh, joint, 0.034, Vec3::ZERO);
    list.frustum(thigh, shell, [(Vec2::new(0.033, 0.034), 0.018 - thigh_m), (Vec2::new(0.04, 0.0385), -0.012)]);
    list.ellipsoid(thigh, shell, Vec3::new(0.038, 0.037, 0.05), Vec3::new(0.006, 0.0, -0.05));
    list.ball(shank, joint, 0.031, Vec3::ZERO);
    list.ellipsoid(shank, shell, Vec3::new(0.026, 0.028, 0.03), Vec3::new(0.014, 0.0, 0.0));
    list.frustum(shank, shell, [(Vec2::new(0.031, 0.033), 0.022 - shank_m), (Vec2::new(0.037, 0.036), -0.02)]);
    list.ellipsoid(shank, shell, Vec3::new(0.036, 0.034, 0.05), Vec3::new(0.006, 0.0, -0.055));
    list.ball(foot, joint, 0.028, Vec3::ZERO);
    // The sole is 15 cm long and rounded in front and behind.
    let middle = on_side(Vec3::new(0.025, 0.003, 0.0), side);
    let (sole, height) = (-ankle_m, 0.034);
    list.cuboid(foot, shell, Vec3::new(0.09, 0.084, height), middle + Vec3::Z * (sole + height / 2.0));
    for (end, radius) in [(0.045, 0.042), (-0.045, 0.042)] {
        let shape = Shape::Frustum {
            bottom: Vec2::new(0.036, radius),
            top: Vec2::new(0.03, radius * 0.9),
            half_height: height / 2.0,
        };
        list.add(foot, shell, shape, middle + Vec3::new(end, 0.0, sole + height / 2.0));
    }
    list.ellipsoid(foot, shell, Vec3::new(0.058, 0.039, 0.022), middle + Vec3::Z * (sole + height - 0.004));
}

/// The lengths of a robot's limbs as multiples of a NAO's, along x, y and z of their frames.
#[derive(PartialEq)]
struct Stretch {
    trunk: Vec3,
    /// The height of a NAO's hips and of the robot's, m: the trunk is stretched between hips and neck.
    hips_m: [f32; 2],
    head: Vec3,
    arm: Vec3,
    thigh: Vec3,
    shank: Vec3,
    foot: Vec3,
}

impl Stretch {
    /// The stretch from a NAO to a robot with this body.
    fn to(body: &Body) -> Self {
        let nao = Body::default();
        let hips = |body: &Body| body.legs.map_or(body.base.z_m[1], |legs| legs.hip_m.z);
        let (from, to) = (hips(&nao), hips(body).min(body.neck_m.z - 0.02));
        let above_hips = |body: &Body, hips: f32| body.neck_m.z - hips;
        let of_arms = |body: &Body| body.arms.unwrap_or_default();
        let ([legs, nao_legs], depth) =
            ([body, &nao].map(|body| body.legs.unwrap_or_default()), |body: &Body| 2.0 * body.torso.half_extents().x);
        let width = match body.arms {
            Some(arms) => arms.shoulder_m.y / of_arms(&nao).shoulder_m.y,
            None => body.torso.half_width_m / nao.torso.half_width_m,
        };
        let head = (body.height_m - body.neck_m.z).max(0.02) / (nao.height_m - nao.neck_m.z);
        let arm = of_arms(body).length_m / of_arms(&nao).length_m;
        // The thickness of the legs follows from the distance of the feet.
        let thick = (body.foot_y_m / nao.foot_y_m).max(0.1);
        let sole = body.base.half_extents().x / nao.base.half_extents().x;
        Self {
            trunk: Vec3::new(depth(body) / depth(&nao), width, above_hips(body, to) / above_hips(&nao, from)),
            hips_m: [from, to],
            head: Vec3::splat(head),
            arm: Vec3::splat(arm),
            thigh: Vec3::new(thick, thick, legs.thigh_m / nao_legs.thigh_m),
            shank: Vec3::new(thick, thick, legs.shank_m / nao_legs.shank_m),
            foot: Vec3::new(sole, thick, legs.ankle_m / nao_legs.ankle_m),
        }
    }

    /// Converts the height `z_m` of a point in the robot's trunk to that in a NAO's trunk, m.
    fn trunk_before(&self, z_m: f32) -> f32 {
        if self.trunk.z == 1.0 && self.hips_m[0] == self.hips_m[1] {
            return z_m;
        }
        (z_m - self.hips_m[1]) / self.trunk.z + self.hips_m[0]
    }

    fn of(&self, limb: Limb) -> Vec3 {
        match limb {
            Limb::Trunk => self.trunk,
            Limb::Head => self.head,
            Limb::LeftArm | Limb::RightArm => self.arm,
            Limb::LeftThigh | Limb::RightThigh => self.thigh,
            Limb::LeftShank | Limb::RightShank => self.shank,
            Limb::LeftFoot | Limb::RightFoot => self.foot,
        }
    }

    /// Stretches the parts of a NAO, and removes the limbs that the robot lacks.
    fn fit(&self, mut list: PartList, id: RobotId, body: &Body) -> Vec<RobotPart> {
        let has_mast = body.look.head == Top::Mast;
        list.parts.retain(|part| match part.frame {
            Limb::Trunk => true,
            Limb::Head => !has_mast,
            Limb::LeftArm | Limb::RightArm => body.arms.is_some(),
            _ => body.legs.is_some(),
        });
        // A NAO itself is not stretched, to avoid rounding.
        if *self != Self::to(&Body::default()) {
            let [_, band] = labels(id.team);
            for part in list.parts.iter_mut().filter(|part| part.label != band) {
                self.stretch(part);
            }
        }
        if has_mast {
            mast(&mut list, &Trunk::of(body));
        }
        if body.legs.is_none() {
            let [_, wheels] = list.colours();
            chassis(&mut list, body, wheels);
        }
        list.parts
    }

    fn stretch(&self, part: &mut RobotPart) {
        let scale = self.of(part.frame);
        let origin = if part.frame == Limb::Trunk { self.hips_m.map(|z| Vec3A::Z * z) } else { [Vec3A::ZERO; 2] };
        let frame_from_shape = &mut part.frame_from_shape;
        frame_from_shape.translation = (frame_from_shape.translation - origin[0]) * Vec3A::from(scale) + origin[1];
        // The factor on the length of each axis of the shape.
        let axes = frame_from_shape.matrix3;
        let longer = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| (axis * Vec3A::from(scale)).length());
        let (longer, thicker) = (Vec3::from(longer), (longer[0] * longer[1]).sqrt());
        part.shape = match part.shape {
            Shape::Box { half_size } => Shape::Box { half_size: half_size * longer },
            Shape::Ellipsoid { radii } => Shape::Ellipsoid { radii: radii * longer },
            Shape::Frustum { bottom, top, half_height } => Shape::Frustum {
                bottom: bottom * longer.truncate(),
                top: top * longer.truncate(),
                half_height: half_height * longer.z,
            },
            Shape::Capsule { radius, half_length } => {
                Shape::Capsule { radius: radius * thicker, half_length: half_length * longer.z }
            }
        };
    }
}

/// Turns a shape's z axis to the front.
fn along_x() -> Mat3 {
    Mat3::from_quat(Quat::from_rotation_arc(Vec3::Z, Vec3::X))
}

/// Turns a shape's z axis to the left.
fn along_y() -> Mat3 {
    Mat3::from_quat(Quat::from_rotation_arc(Vec3::Z, Vec3::Y))
}

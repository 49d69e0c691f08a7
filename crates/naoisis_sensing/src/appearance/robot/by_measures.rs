//! Drawing of robots from the measures of their bodies: a trunk between hips and neck, a head above it, and legs and arms if the robot has
//! them. A robot without legs stands on a base with wheels.

use bevy::math::{Vec2, Vec3};

use super::number::{self, Plates};
use super::{PartList, RobotPart};
use crate::appearance::colours::Colour;
use crate::appearance::posing::{Limb, on_side};
use crate::appearance::shapes::Shape;
use naoisis_core::robot::body::{Arms, Body, Legs};
use naoisis_core::robot::look::Top;
use naoisis_core::team::{RobotId, Team};

/// The positions of trunk and head of a body.
pub(super) struct Trunk {
    /// Lower and upper edge, m above the ground.
    z_m: [f32; 2],
    /// Rear and front, m.
    x_m: [f32; 2],
    /// Half its width without the arms, m.
    half_width_m: f32,
    /// Half the size of the head, m.
    half_head_m: Vec3,
    /// The middle of the head above the neck, m.
    head_z_m: f32,
}

impl Trunk {
    pub(super) fn of(body: &Body) -> Self {
        let lower = body.legs.map_or(body.base.z_m[1], |legs| legs.hip_m.z);
        let head_m = (body.height_m - body.neck_m.z).max(0.02);
        let half_head = head_m / 2.0;
        Self {
            z_m: [lower.min(body.neck_m.z - 0.02), body.neck_m.z],
            x_m: body.torso.x_m,
            half_width_m: body.drawn_half_width_m().max(0.02),
            half_head_m: Vec3::new(half_head.min(0.12), half_head.min(0.11), half_head),
            head_z_m: half_head,
        }
    }

    fn size(&self) -> Vec3 {
        let [x, z] = [self.x_m, self.z_m].map(|[least, most]| most - least);
        Vec3::new(x, 2.0 * self.half_width_m, z)
    }

    fn middle(&self) -> Vec3 {
        let [x, z] = [self.x_m, self.z_m].map(|[least, most]| (most + least) / 2.0);
        Vec3::new(x, 0.0, z)
    }
}

/// Adds the waistband of a box-shaped trunk.
fn band(list: &mut PartList, team: Team, body: &Body) {
    let half_size = body.waistband.half_size_m.extend(body.waistband.height() / 2.0);
    list.band(team, body, Shape::Box { half_size });
}

/// Adds the shell of the trunk. With a jersey, which ends at the lower edge of the waistband, the part below it has the colour of the joints.
fn chest(list: &mut PartList, body: &Body, size: Vec3, middle: Vec3) {
    let [shell, joint] = list.colours();
    if body.jersey.is_none() {
        list.cuboid(Limb::Trunk, shell, size, middle);
        return;
    }
    let [lower, upper] = [-0.5, 0.5].map(|half| middle.z + half * size.z);
    let cut = body.waistband.z_m[0].clamp(lower, upper);
    for (colour, [from, to]) in [(joint, [lower, cut]), (shell, [cut, upper])] {
        if from < to {
            list.cuboid(Limb::Trunk, colour, size.with_z(to - from), middle.with_z((from + to) / 2.0));
        }
    }
}

/// The parts of the simple design: a few boxes.
pub(super) fn simple(id: RobotId, body: &Body) -> Vec<RobotPart> {
    let trunk = Trunk::of(body);
    let mut list = PartList::new(id, body, 16);
    let [shell, joint] = list.colours();
    let (size, middle) = (trunk.size(), trunk.middle());
    chest(&mut list, body, size, middle);
    band(&mut list, id.team, body);
    if list.has_jersey {
        let z_m = body.look.number_z_m.unwrap_or(middle.z + 0.2 * size.z);
        let plates = Plates { x_m: [trunk.x_m[1], trunk.x_m[0]], z_m, size: 1.4 * (size.y / 0.15).min(size.z / 0.2) };
        number::write(&mut list, id.number, &plates);
    }
    if body.look.head == Top::Mast {
        mast(&mut list, &trunk);
    } else {
        let head = 2.0 * trunk.half_head_m;
        list.cuboid(Limb::Head, shell, head, Vec3::Z * trunk.head_z_m);
        // The face is dark, or light on a dark head, so that front and back differ.
        let face = Vec3::new(0.01, 0.75 * head.y, 0.4 * head.z);
        list.cuboid(Limb::Head, joint, face, Vec3::new(trunk.half_head_m.x, 0.0, trunk.head_z_m));
    }
    for side in 0..2 {
        if let Some(Arms { length_m, .. }) = body.arms {
            let thickness = 0.25 * length_m;
            let size = Vec3::new(thickness, thickness, length_m);
            list.cuboid(Limb::ARMS[side], shell, size, Vec3::Z * (-0.45 * length_m));
        }
        if let Some(Legs { thigh_m, shank_m, ankle_m, .. }) = body.legs {
            let [thigh, shank] = [0.5 * thigh_m, 0.45 * shank_m].map(|thickness| Vec2::splat(thickness.min(0.12)));
            list.cuboid(Limb::THIGHS[side], joint, thigh.extend(thigh_m), Vec3::Z * (-thigh_m / 2.0));
            list.cuboid(Limb::SHANKS[side], shell, shank.extend(shank_m), Vec3::Z * (-shank_m / 2.0));
            let (size, middle) = foot(body, ankle_m, side);
            list.cuboid(Limb::FEET[side], shell, size, middle);
        }
    }
    if body.legs.is_none() {
        chassis(&mut list, body, joint);
    }
    list.parts
}

/// The parts of the detailed design: rounded shells over the joints, and a number on chest and back.
pub(super) fn detailed(id: RobotId, body: &Body) -> Vec<RobotPart> {
    let trunk = Trunk::of(body);
    let look = body.look;
    let mut list = PartList::new(id, body, 64);
    let [shell, joint] = list.colours();
    let (size, middle) = (trunk.size(), trunk.middle());
    // Wider at the shoulders.
    list.cuboid(Limb::Trunk, joint, size * Vec3::new(0.8, 0.8, 0.4), middle - Vec3::Z * (0.3 * size.z));
    let chest_m = middle + Vec3::Z * (0.12 * size.z);
    chest(&mut list, body, size * Vec3::new(1.0, 1.0, 0.66), chest_m);
    let neck = Shape::cylinder(0.25 * trunk.half_head_m.y, 0.06 * size.z + 0.02);
    list.add(Limb::Trunk, joint, neck, body.neck_m);
    band(&mut list, id.team, body);
    let scale = (size.y / 0.15).min(size.z / 0.2);
    let z_m = look.number_z_m.unwrap_or(chest_m.z + 0.08 * size.z);
    let plates = Plates { x_m: [trunk.x_m[1] + 0.004, trunk.x_m[0] - 0.004], z_m, size: scale };
    let plate = Vec3::new(0.008, 0.088, 0.066) * Vec3::new(1.0, scale, scale);
    for (x, is_there) in trunk.x_m.into_iter().zip([look.number.back, look.number.chest]) {
        if is_there {
            list.cuboid(Limb::Trunk, Colour(look.plates), plate, Vec3::new(x, 0.0, plates.z_m));
        }
    }
    number::write(&mut list, id.number, &plates);

    if look.head == Top::Mast {
        mast(&mut list, &trunk);
    } else {
        face(&mut list, &trunk);
    }
    for side in 0..2 {
        if let Some(Arms { length_m, .. }) = body.arms {
            let arm = Limb::ARMS[side];
            let radius = 0.14 * length_m;
            let elbow = on_side(Vec3::new(0.0, 0.06, -0.5) * length_m, side);
            let hand = on_side(Vec3::new(0.2, 0.04, -0.86) * length_m, side);
            list.ball(arm, joint, 1.15 * radius, Vec3::ZERO);
            list.rod(arm, shell, radius, [elbow * 0.15, elbow * 0.9]);
            list.ball(arm, joint, 0.95 * radius, elbow);
            list.rod(arm, shell, 0.85 * radius, [elbow.lerp(hand, 0.2), elbow.lerp(hand, 0.85)]);
            list.ball(arm, joint, 0.9 * radius, hand);
        }
        if let Some(Legs { thigh_m, shank_m, ankle_m, .. }) = body.legs {
            let [thigh, shank] = [0.26 * thigh_m, 0.22 * shank_m].map(|radius| radius.min(0.07));
            list.ball(Limb::THIGHS[side], joint, 1.05 * thigh, Vec3::ZERO);
            list.rod(Limb::THIGHS[side], shell, thigh, [Vec3::Z * (-0.15 * thigh_m), Vec3::Z * (-0.8 * thigh_m)]);
            list.ball(Limb::SHANKS[side], joint, shank.max(0.9 * thigh), Vec3::ZERO);
            list.rod(Limb::SHANKS[side], shell, shank, [Vec3::Z * (-0.2 * shank_m), Vec3::Z * (-0.85 * shank_m)]);
            // Ankles near the ground are flat.
            list.ball(Limb::FEET[side], joint, shank.min(ankle_m), Vec3::ZERO);
            let (size, middle) = foot(body, ankle_m, side);
            list.cuboid(Limb::FEET[side], shell, size * Vec3::new(0.7, 1.0, 1.0), middle);
            let toe = size * Vec3::new(0.5, 0.5, 0.5);
            let ends = Vec3::X * (0.35 * size.x - 0.001);
            for end in [ends, -ends] {
                let shape = Shape::Frustum {
                    bottom: Vec2::new(0.3, 1.0) * toe.truncate(),
                    top: Vec2::new(0.22, 0.85) * toe.truncate(),
                    half_height: toe.z,
                };
                list.add(Limb::FEET[side], shell, shape, middle + end);
            }
        }
    }
    if body.legs.is_none() {
        chassis(&mut list, body, joint);
    }
    list.parts
}

/// Adds a head with a visor, and two eyes behind it.
fn face(list: &mut PartList, trunk: &Trunk) {
    let ([shell, joint], eyes) = (list.colours(), Colour(list.look.eyes));
    let half = trunk.half_head_m;
    let head = Vec3::Z * trunk.head_z_m;
    list.ellipsoid(Limb::Head, shell, half, head);
    let visor = Vec3::new(0.45, 0.72, 0.34) * half;
    list.ellipsoid(Limb::Head, joint, visor, head + Vec3::new(0.62, 0.0, 0.1) * half);
    for side in 0..2 {
        let eye = on_side(Vec3::new(1.0, 0.32, 0.12) * half, side);
        list.ball(Limb::Head, eyes, 0.13 * half.y, head + eye * Vec3::new(0.98, 1.0, 1.0));
    }
}

/// Adds a mast instead of a head, with a camera that looks ahead.
pub(super) fn mast(list: &mut PartList, trunk: &Trunk) {
    let [shell, joint] = list.colours();
    let top_m = 2.0 * trunk.head_z_m;
    let thickness = 0.12 * trunk.half_width_m;
    let camera = Vec3::new(1.2, 2.4, 1.2) * thickness.min(top_m / 2.0);
    list.cuboid(Limb::Head, joint, Vec3::new(thickness, thickness, top_m), Vec3::Z * (top_m / 2.0));
    let middle = Vec3::new(thickness, 0.0, top_m - camera.z / 2.0);
    list.cuboid(Limb::Head, shell, camera, middle);
    // The lens.
    list.cuboid(Limb::Head, joint, camera * Vec3::new(0.1, 0.4, 0.6), middle + Vec3::X * (0.55 * camera.x));
}

/// The size of a foot and its middle in the foot's frame, m. The foot is as long as the base, and at most half as wide.
fn foot(body: &Body, ankle_m: f32, side: usize) -> (Vec3, Vec3) {
    let [rear, front] = body.base.x_m;
    let half_width = (body.base.half_width_m - body.foot_y_m).clamp(0.01, 0.9 * body.foot_y_m.max(0.02));
    let height = (0.75 * ankle_m).min(0.05);
    let hip = body.legs.map_or(Vec3::ZERO, |legs| legs.hip_m);
    let aside = on_side(Vec3::Y * (body.foot_y_m - hip.y), side);
    let middle = Vec3::new((rear + front) / 2.0 - hip.x, 0.0, height / 2.0 - ankle_m) + aside;
    (Vec3::new(front - rear, 2.0 * half_width, height), middle)
}

/// Adds the base of a robot without legs: a box, and two wheels.
pub(super) fn chassis(list: &mut PartList, body: &Body, wheels: Colour) {
    let base = body.base;
    let radius = (0.3 * (base.z_m[1] - base.z_m[0])).min(0.4 * (base.x_m[1] - base.x_m[0]));
    let height = base.z_m[1] - radius / 2.0;
    let size = Vec3::new(base.x_m[1] - base.x_m[0], 1.6 * base.half_width_m, height);
    let middle = Vec3::new(base.centre_x(), 0.0, base.z_m[1] - height / 2.0);
    list.cuboid(Limb::Trunk, Colour(list.look.shell), size, middle);
    for side in 0..2 {
        let wheel = on_side(Vec3::new(base.centre_x(), 0.9 * base.half_width_m, radius), side);
        list.ellipsoid(Limb::Trunk, wheels, Vec3::new(radius, 0.1 * base.half_width_m, radius), wheel);
    }
}

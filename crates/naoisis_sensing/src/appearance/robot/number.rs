//! Jersey numbers with seven segments per digit.

use bevy::math::{Vec2, Vec3};

use super::{Limb, PartList};
use crate::appearance::colours::Colour;

/// The plates of a number.
pub(super) struct Plates {
    /// The x of their surfaces, in front and behind, m, robot frame.
    pub x_m: [f32; 2],
    /// The height of their middle, m.
    pub z_m: f32,
    /// The size of the digits, as a multiple of a NAO's.
    pub size: f32,
}

impl Plates {
    /// The plates on a NAO's chest and back.
    pub(super) const fn of_nao() -> Self {
        Self { x_m: [0.063, -0.063], z_m: 0.386, size: 1.0 }
    }
}

/// Half the width and height of a digit between the middles of its segments, m.
const HALF: Vec2 = Vec2::new(0.011, 0.021);
/// The thickness of the segments, m.
const STROKE: f32 = 0.009;

/// The centre of each segment in half widths and half heights, x to the reader's right, and whether it is horizontal: top, upper left, upper
/// right, middle, lower left, lower right, bottom.
const PLACES: [(Vec2, bool); 7] = [
    (Vec2::new(0.0, 1.0), true),
    (Vec2::new(-1.0, 0.5), false),
    (Vec2::new(1.0, 0.5), false),
    (Vec2::new(0.0, 0.0), true),
    (Vec2::new(-1.0, -0.5), false),
    (Vec2::new(1.0, -0.5), false),
    (Vec2::new(0.0, -1.0), true),
];

/// The segments of each digit.
const SEGMENTS: [[u8; 7]; 10] = [
    [1, 1, 1, 0, 1, 1, 1],
    [0, 0, 1, 0, 0, 1, 0],
    [1, 0, 1, 1, 1, 0, 1],
    [1, 0, 1, 1, 0, 1, 1],
    [0, 1, 1, 1, 0, 1, 0],
    [1, 1, 0, 1, 0, 1, 1],
    [1, 1, 0, 1, 1, 1, 1],
    [1, 0, 1, 0, 0, 1, 0],
    [1, 1, 1, 1, 1, 1, 1],
    [1, 1, 1, 1, 0, 1, 1],
];

/// Adds a number on the plates that the robot's look has. 0 stands for an unknown number: the plates stay empty.
pub(super) fn write(body: &mut PartList, number: u8, plates: &Plates) {
    if number == 0 {
        return;
    }
    let digits = number.to_string();
    let Plates { x_m, z_m, size: scale } = *plates;
    let (look, colour) = (body.look, Colour(body.look.number_colour));
    let spacing = scale * 0.036_f32.min(0.075 / digits.len() as f32);
    for (index, digit) in digits.bytes().enumerate() {
        let middle = (index as f32 - (digits.len() - 1) as f32 / 2.0) * spacing;
        let lit = SEGMENTS[usize::from(digit - b'0')];
        for ((place, lies), _) in PLACES.iter().zip(lit).filter(|(_, lit)| *lit == 1) {
            let size = scale * (if *lies { Vec2::new(2.0 * HALF.x, 0.0) } else { Vec2::new(0.0, HALF.y) } + STROKE);
            let right = middle + place.x * scale * HALF.x;
            // On the chest, the robot's left, +y, is to the reader's right.
            for (facing, surface, is_there) in [(1.0, x_m[0], look.number.chest), (-1.0, x_m[1], look.number.back)] {
                if !is_there {
                    continue;
                }
                let centre = Vec3::new(surface + facing * 0.0005, facing * right, z_m + place.y * scale * HALF.y);
                body.cuboid(Limb::Trunk, colour, Vec3::new(0.002, size.x, size.y), centre);
            }
        }
    }
}

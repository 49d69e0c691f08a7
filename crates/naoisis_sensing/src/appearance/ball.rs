//! The appearance of the ball: its colours, its pattern, and how the pattern turns as the ball rolls.

use bevy::math::{Mat3, Vec3};

use super::colours::{self, Colour};
use super::posing::{about_x, about_y};
use super::scene::SceneBall;
use naoisis_core::ball::BallLook;

/// The white of a football.
pub const WHITE: Colour = Colour([236, 236, 234]);
/// The black of its pentagons.
pub const BLACK: Colour = Colour([26, 26, 29]);

/// The scalar product of the axis of a pentagon with the points on its edge. Twelve such caps cover 28 % of the ball, as the pentagons of a
/// ball of 32 pieces do.
const PENTAGON_EDGE: f32 = 0.953;

/// A patch of another colour on an ellipsoid. It contains the points of the unit sphere, in the frame of its part, whose scalar product
/// with `axis` is between `from` and `to`. If `to` is 1 it is a cap about the axis; if `from` is `-to` it is a band.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PatchArea {
    /// The axis, unit vector.
    pub axis: Vec3,
    /// The least scalar product.
    pub from: f32,
    /// The greatest scalar product.
    pub to: f32,
    /// Its colour.
    pub colour: Colour,
}

impl PatchArea {
    /// Whether a point of the unit sphere is in the patch.
    #[inline(always)]
    pub fn covers(&self, point: Vec3) -> bool {
        let along = self.axis.dot(point);
        self.from <= along && along <= self.to
    }
}

/// The base colour of a ball with this look.
pub const fn ground(look: BallLook) -> Colour {
    match look {
        BallLook::Pentagons => WHITE,
        _ => colours::BALL,
    }
}

/// The pattern of a ball with this look.
pub fn patches(look: BallLook) -> Vec<PatchArea> {
    match look {
        BallLook::Pentagons => pentagons(BLACK, PENTAGON_EDGE).to_vec(),
        _ => Vec::new(),
    }
}

/// Twelve equal caps at the corners of an icosahedron. `edge` is the scalar product of a cap's axis with the points on its edge.
pub fn pentagons(colour: Colour, edge: f32) -> [PatchArea; 12] {
    ICOSAHEDRON.map(|corner| PatchArea { axis: corner.normalize(), from: edge, to: 1.0, colour })
}

/// The colour of a ball with this look at a point of the unit sphere.
pub fn colour_at(look: BallLook, patches: &[PatchArea], point: Vec3) -> Colour {
    let patch = patches.iter().rev().find(|patch| patch.covers(point));
    patch.map_or(ground(look), |patch| patch.colour)
}

impl SceneBall {
    /// The rotation of its pattern. It follows from its place, so that it needs no memory: the pattern turns as that of a rolling ball along
    /// the pitch; across the pitch it turns as fast, but not always about the right axis.
    pub fn turn(&self) -> Mat3 {
        let [x, y] = [self.position.x, self.position.y].map(|way| way / self.radius.max(1e-3));
        about_y(x) * about_x(-y)
    }
}

/// The golden ratio.
const GOLDEN: f32 = 1.618_034;

/// The corners of an icosahedron.
const ICOSAHEDRON: [Vec3; 12] = [
    Vec3::new(0.0, 1.0, GOLDEN),
    Vec3::new(0.0, -1.0, GOLDEN),
    Vec3::new(0.0, 1.0, -GOLDEN),
    Vec3::new(0.0, -1.0, -GOLDEN),
    Vec3::new(1.0, GOLDEN, 0.0),
    Vec3::new(-1.0, GOLDEN, 0.0),
    Vec3::new(1.0, -GOLDEN, 0.0),
    Vec3::new(-1.0, -GOLDEN, 0.0),
    Vec3::new(GOLDEN, 0.0, 1.0),
    Vec3::new(GOLDEN, 0.0, -1.0),
    Vec3::new(-GOLDEN, 0.0, 1.0),
    Vec3::new(-GOLDEN, 0.0, -1.0),
];

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Vec2;

    #[test]
    fn a_ball_that_rolls_along_the_pitch_does_not_slide() {
        let at = |x: f32| SceneBall::on_ground(Vec2::new(x, 0.0), 0.05);
        // The lowest point of the ball stands still while its centre moves.
        let (before, after) = (at(0.3), at(0.301));
        let lowest = before.turn().transpose() * (Vec3::NEG_Z * 0.05);
        let moved = (after.centre() + after.turn() * lowest) - (before.centre() + before.turn() * lowest);
        assert!(moved.length() < 2e-5, "{moved}");
    }

    #[test]
    fn pentagons_cover_as_much_as_those_of_a_football() {
        // The area of a cap on the unit sphere, as a share of the sphere's, is (1 - edge) / 2. A truncated icosahedron has 28.4 %.
        let share: f32 = patches(BallLook::Pentagons).iter().map(|patch| (patch.to - patch.from) / 2.0).sum();
        assert!((share - 0.284).abs() < 0.005, "{share}");
        assert!(patches(BallLook::Orange).is_empty());
    }
}

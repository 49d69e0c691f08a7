//! The pitch as a Foxglove scene.

use bevy::math::{Affine3A, Vec2};
use foxglove::messages::SceneUpdate;

use super::shapes::{Entity, PITCH, colour};
use naoisis_core::geometry::unit;
use naoisis_core::pitch::{End, Post};
use naoisis_sensing::appearance::colours;
use naoisis_sensing::appearance::field::{GroundShape, STRING_M, goal_frame, ground, net_strings, post};
use naoisis_sim::scenario::Scenario;

/// Distance of the carpet below the lines, which are at the height of the ground, m.
const BELOW_M: f32 = 0.004;
/// Number of corners that approximate the centre circle.
const CORNERS: u32 = 64;

/// Draws the carpet with its markings, the goals and posts.
pub(super) fn pitch(scenario: &Scenario) -> SceneUpdate {
    let field = &scenario.field;
    let mut entity = Entity::new(PITCH, PITCH, 0);
    for (index, mark) in ground(field).into_iter().enumerate() {
        let height = if index == 0 { -BELOW_M } else { 0.0 };
        entity.triangles(corners(mark.shape).map(|corner| corner.extend(height)), colour(mark.colour, 1.0));
    }
    let goals = field.goal_posts().map(|goal| post(&goal.into(), goal.position));
    let others = scenario.posts.iter().map(|spec| {
        let own = Post { radius: spec.radius_m, height: spec.height_m, colour: None };
        post(&own, spec.position_m)
    });
    let frames = End::BOTH.into_iter().flat_map(|end| goal_frame(field, end));
    for part in goals.into_iter().chain(others).chain(frames) {
        entity.part(&part, Affine3A::IDENTITY, 1.0);
    }
    entity.lines(End::BOTH.into_iter().flat_map(|end| net_strings(field, end)), STRING_M, colour(colours::NET, 0.6));
    entity.scene()
}

/// Returns the corners of a shape's triangles, three for each triangle.
fn corners(shape: GroundShape) -> impl Iterator<Item = Vec2> {
    let corners: Vec<Vec2> = match shape {
        GroundShape::Quadrilateral([a, b, c, d]) => vec![a, b, c, a, c, d],
        GroundShape::Ring { centre, inner, outer } => {
            let at = |corner: u32| unit(core::f32::consts::TAU * corner as f32 / CORNERS as f32);
            let piece = |corner: u32| {
                let [a, b] = [at(corner), at(corner + 1)];
                let [a, b, c, d] = [outer * a, outer * b, inner * b, inner * a].map(|offset| centre + offset);
                [a, b, c, a, c, d]
            };
            (0..CORNERS).flat_map(piece).collect()
        }
    };
    corners.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the total area of a shape's triangles, m².
    fn area(shape: GroundShape) -> f32 {
        let corners: Vec<Vec2> = corners(shape).collect();
        corners.chunks(3).map(|corner| (corner[1] - corner[0]).perp_dot(corner[2] - corner[0]).abs() / 2.0).sum()
    }

    #[test]
    fn triangles_cover_their_shapes() {
        let square = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
        assert_eq!(area(GroundShape::Quadrilateral(square)), 1.0);
        let ring = area(GroundShape::Ring { centre: Vec2::ONE, inner: 1.0, outer: 2.0 });
        // A polygon of 64 corners has 99.8 % of its circle.
        assert!((ring / (3.0 * core::f32::consts::PI) - 0.998).abs() < 1e-3, "{ring}");
        let scene = pitch(&Scenario::default());
        let entity = &scene.entities[0];
        assert_eq!((entity.frame_id.as_str(), entity.cylinders.len() >= 4), ("pitch", true));
        assert!(entity.triangles.len() > 10 && entity.lines[0].points.len() > 100);
    }
}

//! The hall about the pitch: its floor, which is darker far from the pitch, and the boards along the carpet.

use bevy::prelude::*;

use super::super::camera::{CameraMode, ViewerCamera};
use super::quads::QuadMesh;
use naoisis_core::pitch::Pitch;
use naoisis_sensing::appearance::colours::{self, Colour};

/// The depth of the floor below the carpet, m.
pub(super) const FLOOR_DEPTH_M: f32 = 0.02;
/// The brightness of the floor at distances from the carpet, m, as a multiple of the floor's colour.
const BRIGHTNESS: [(f32, f32); 6] = [(0.0, 0.55), (0.6, 0.6), (2.0, 0.45), (6.0, 0.28), (16.0, 0.2), (600.0, 0.2)];
/// The distance of the boards from the carpet, m. All people stand behind them.
const BOARDS_M: f32 = 0.15;
/// The height of the boards, m.
const BOARD_HEIGHT_M: f32 = 0.3;
/// The wanted length of a board, m.
const BOARD_LENGTH_M: f32 = 1.5;
/// The height of the bright edge at the top of the boards, m.
const EDGE_M: f32 = 0.03;
/// The colours of every other board, and of their edge.
const BOARDS: [Colour; 2] = [Colour([50, 64, 88]), Colour([62, 79, 108])];
const EDGE: Colour = Colour([190, 198, 208]);

/// Marks what robots' cameras do not have in their images.
#[derive(Component)]
pub(super) struct NotInRobotsImages;

/// Returns the floor around the carpet, which is bright near it and dark far away.
pub(super) fn floor(pitch: &Pitch) -> QuadMesh {
    let mut floor = QuadMesh::default();
    for ring in BRIGHTNESS.windows(2) {
        let ((inner_m, near), (outer_m, far)) = (ring[0], ring[1]);
        let [inner, outer] = [inner_m, outer_m].map(|distance_m| corners(pitch.carpet_half_extents() + distance_m));
        for (side, next) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
            let around = [outer[side], outer[next], inner[next], inner[side]];
            floor.shaded(around.map(|corner| corner.extend(0.0)), colours::FLOOR, [far, far, near, near]);
        }
    }
    floor
}

/// Returns the boards along the carpet, which are seen from the side of the pitch only.
pub(super) fn boards(pitch: &Pitch) -> QuadMesh {
    let mut boards = QuadMesh::default();
    let corners = corners(pitch.carpet_half_extents() + BOARDS_M);
    for (from, to) in [(0, 1), (1, 2), (2, 3), (3, 0)].map(|(from, to)| (corners[from], corners[to])) {
        let count = (from.distance(to) / BOARD_LENGTH_M).round().max(1.0);
        for index in 0..count as usize {
            let [start, end] = [0, 1].map(|step| from.lerp(to, (index + step) as f32 / count));
            let mut add = |colour, bottom_m: f32, top_m: f32| {
                let [left, right] = [end, start];
                let quad = [left.extend(bottom_m), right.extend(bottom_m), right.extend(top_m), left.extend(top_m)];
                boards.add(quad, colour);
            };
            add(BOARDS[index % 2], -FLOOR_DEPTH_M, BOARD_HEIGHT_M - EDGE_M);
            add(EDGE, BOARD_HEIGHT_M - EDGE_M, BOARD_HEIGHT_M);
        }
    }
    boards
}

/// Returns the corners of a rectangle about the centre of the pitch, counter-clockwise from -x, -y.
fn corners(half: Vec2) -> [Vec2; 4] {
    [-half, Vec2::new(half.x, -half.y), half, Vec2::new(-half.x, half.y)]
}

/// Hides the boards while the match is seen through the camera of a robot, whose images are without them.
pub(super) fn hide_from_robots(
    camera: Single<&ViewerCamera>,
    mut hidden: Query<&mut Visibility, With<NotInRobotsImages>>,
) {
    let sees_as_robot = matches!(camera.mode, CameraMode::RobotCamera(_));
    for mut visibility in &mut hidden {
        visibility.set_if_neq(if sees_as_robot { Visibility::Hidden } else { Visibility::Inherited });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_floor_surrounds_the_carpet_and_boards_face_the_pitch() {
        let pitch = Pitch::default();
        let positions = |mesh: Mesh, attribute| match mesh.attribute(attribute) {
            Some(bevy::mesh::VertexAttributeValues::Float32x3(values)) => values.clone(),
            _ => panic!("three numbers"),
        };
        let carpet = pitch.carpet_half_extents();
        for [x, y, _] in positions(floor(&pitch).finish(), Mesh::ATTRIBUTE_POSITION) {
            assert!(x.abs() >= carpet.x || y.abs() >= carpet.y);
        }
        let normals = positions(floor(&pitch).finish(), Mesh::ATTRIBUTE_NORMAL);
        assert!(normals.iter().all(|normal| normal[2] > 0.99));
        let places = positions(boards(&pitch).finish(), Mesh::ATTRIBUTE_POSITION);
        let normals = positions(boards(&pitch).finish(), Mesh::ATTRIBUTE_NORMAL);
        for ([x, y, _], [toward_x, toward_y, _]) in places.into_iter().zip(normals) {
            assert!(x * toward_x + y * toward_y < 0.0, "({x}, {y}) faces away");
        }
    }
}

//! The haze in which the floor of the hall ends, and the background. The haze begins behind the pitch, wherever the camera is.
//! Through the camera of a robot, both have the colour of the sky in its images.

use bevy::camera::ClearColorConfig;
use bevy::pbr::{DistanceFog, FogFalloff};
use bevy::prelude::*;

use super::super::palette;
use super::super::shared::SecondPitch;
use super::{CameraMode, ViewerCamera};
use naoisis_core::pitch::Pitch;

/// Where the haze begins and where it hides everything, as multiples of the distance of the farthest point of the carpet.
const BEGINS: f32 = 1.2;
pub(super) const HIDES: f32 = 4.0;
/// The latter through the camera of a robot, in whose images the floor is not dark far from the pitch.
const HIDES_FROM_ROBOT: f32 = 1.8;

/// Moves the haze with the camera, and sets the background.
pub(super) fn thin_haze(
    (pitch, second): (Res<Pitch>, Res<SecondPitch>),
    camera: Single<(Ref<Transform>, &ViewerCamera, &mut DistanceFog, &mut Camera)>,
) {
    let (place, viewer, mut fog, mut camera) = camera.into_inner();
    let sees_as_robot = matches!(viewer.mode, CameraMode::RobotCamera(_));
    let color = if sees_as_robot { palette::SKY } else { palette::HALL };
    if place.is_changed() || pitch.is_changed() || second.is_changed() || fog.color != color {
        let hides = if sees_as_robot { HIDES_FROM_ROBOT } else { HIDES };
        *fog = DistanceFog { color, ..haze(place.translation, &pitch, second.0.unwrap_or_default(), hides) };
        camera.clear_color = ClearColorConfig::Custom(color);
    }
}

/// Returns the haze for a camera at `eye`, m, pitch frame, and a second pitch `second_m` further in +y. It hides everything from `hides`
/// times the distance of the farthest point of the carpet on.
pub(super) fn haze(eye: Vec3, pitch: &Pitch, second_m: f32, hides: f32) -> DistanceFog {
    let corner = Vec2::new(pitch.half_length(), pitch.half_width() + second_m) + pitch.border_m;
    let farthest_m = (eye.xy().abs() + corner).extend(eye.z).length();
    let falloff = FogFalloff::Linear { start: BEGINS * farthest_m, end: hides * farthest_m };
    DistanceFog { color: palette::HALL, falloff, ..default() }
}

#[cfg(test)]
mod tests {
    use super::super::viewpoint::{Overview, Viewpoint};
    use super::*;

    #[test]
    fn no_part_of_a_pitch_is_hidden_from_any_view_of_it() {
        let adult = Pitch { length_m: 22.0, width_m: 14.0, ..Pitch::default() };
        for pitch in [Pitch::default(), adult] {
            let whole = [Overview::Broadcast, Overview::TopDown]
                .into_iter()
                .flat_map(|view| [0.3, 1.0, 3.0].map(|aspect| Viewpoint::of_pitch(view, &pitch, aspect)));
            let from_a_corner = Viewpoint { distance: 40.0, ..Viewpoint::of_ball(Vec2::new(-11.0, -7.0)) };
            for view in whole.chain([from_a_corner]) {
                let FogFalloff::Linear { start, end } = haze(view.eye(), &pitch, 0.0, HIDES).falloff else {
                    panic!("linear")
                };
                assert!(start < end);
                for (x, y) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                    let corner = Vec2::new(x * pitch.half_length(), y * pitch.half_width());
                    let distance_m = view.eye().distance(corner.extend(0.0));
                    assert!(distance_m < start, "{view:?}: {corner} is {distance_m} m away, haze begins at {start} m");
                }
            }
        }
    }
}

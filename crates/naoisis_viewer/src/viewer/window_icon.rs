//! The icon of the window: a mown pitch from above, with a ball on the kick-off spot.

use bevy::ecs::system::NonSendMarker;
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy::winit::WINIT_WINDOWS;
use winit::window::Icon;

/// Gives the window its icon.
pub(super) struct WindowIconPlugin;

impl Plugin for WindowIconPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, set_icon);
    }
}

/// Width and height of the icon, pixels.
const SIZE: u32 = 64;
/// Each pixel is the mean of this many samples in each direction.
const SAMPLES: u32 = 4;

/// Sets the icon once the window is open. Windows are of the main thread alone.
fn set_icon(_main_thread: NonSendMarker, windows: Query<Entity, With<PrimaryWindow>>, mut is_set: Local<bool>) {
    let Some(window) = windows.iter().next().filter(|_| !*is_set) else { return };
    WINIT_WINDOWS.with_borrow(|opened| {
        let Some(window) = opened.get_window(window) else { return };
        match Icon::from_rgba(picture(), SIZE, SIZE) {
            Ok(icon) => window.set_window_icon(Some(icon)),
            Err(error) => warn!("the window has no icon: {error}"),
        }
        *is_set = true;
    });
}

/// Returns the pixels of the icon: red, green, blue and opacity of each, rows from the top.
fn picture() -> Vec<u8> {
    let places = (0..SIZE).flat_map(|row| (0..SIZE).map(move |column| (column, row)));
    places.flat_map(|(column, row)| pixel(column, row)).collect()
}

fn pixel(column: u32, row: u32) -> [u8; 4] {
    let steps = SIZE * SAMPLES;
    let coordinate = |pixel: u32, sample: u32| 2.0 * ((pixel * SAMPLES + sample) as f32 + 0.5) / steps as f32 - 1.0;
    let samples = (0..SAMPLES * SAMPLES)
        .filter_map(|i| ink_at(Vec2::new(coordinate(column, i % SAMPLES), coordinate(row, i / SAMPLES))));
    let (count, sum) = samples.fold((0, Vec3::ZERO), |(count, sum), ink| (count + 1, sum + ink));
    let mean = sum / count.max(1) as f32;
    let opacity = 255.0 * count as f32 / (SAMPLES * SAMPLES) as f32;
    [mean.x, mean.y, mean.z, opacity].map(|value| value.round() as u8)
}

/// Returns the colour at a point of the icon, 0 to 255, or `None` outside of its rounded corners. The icon reaches from -1 to 1.
fn ink_at(point: Vec2) -> Option<Vec3> {
    const CORNER: f32 = 0.35;
    const WHITE: Vec3 = Vec3::splat(250.0);
    const BLACK: Vec3 = Vec3::splat(30.0);
    const MOWN: [Vec3; 2] = [Vec3::new(46.0, 125.0, 62.0), Vec3::new(57.0, 145.0, 74.0)];
    let beyond = (point.abs() - Vec2::splat(1.0 - CORNER)).max(Vec2::ZERO);
    if beyond.length() > CORNER {
        return None;
    }
    let radius = point.length();
    let is_line = point.x.abs() < 0.05 || (0.62..0.72).contains(&radius);
    let stripe = usize::from(((point.x + 1.0) * 2.0) as i32 % 2 == 1);
    Some(match radius {
        0.0..0.14 => BLACK,
        0.14..0.36 => WHITE,
        0.36..0.44 => BLACK,
        _ if is_line => WHITE,
        _ => MOWN[stripe],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_icon_has_clear_corners_and_a_ball_in_the_middle() {
        let picture = picture();
        assert_eq!(picture.len(), (SIZE * SIZE * 4) as usize);
        let at = |column: u32, row: u32| &picture[4 * (row * SIZE + column) as usize..][..4];
        assert_eq!(at(0, 0)[3], 0);
        assert_eq!(at(32, 32), [30, 30, 30, 255]);
        assert_eq!(at(40, 32), [250, 250, 250, 255]);
        assert!(Icon::from_rgba(picture.clone(), SIZE, SIZE).is_ok());
    }
}

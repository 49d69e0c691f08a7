//! Pictures of the window, with its panels or of the match alone.

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use std::path::Path;

use super::commands::TakePicture;
use super::layout::HiddenPanels;
use super::new_file::write_new;
use super::shared::{KeysSystems, Notice};
use naoisis_core::cycle::CycleClock;
use naoisis_record::record::summary_recorder::png;
use naoisis_sensing::sensing::camera::image::Image as Picture;

/// The time until the camera has fitted the match into a window whose panels were hidden, s, and the least number of frames of it.
pub const FITTING_S: f64 = 0.8;
const FITTING_FRAMES: u32 = 3;

/// Saves pictures in the current folder.
pub struct PicturePlugin;

impl Plugin for PicturePlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<TakePicture>()
            .init_resource::<HiddenPanels>()
            .add_systems(Update, take_pictures.after(KeysSystems).in_set(PictureSystems));
    }
}

/// The systems that take pictures.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PictureSystems;

/// Takes a picture of the window at once, and one of the match when its panels have been hidden for long enough.
fn take_pictures(
    mut requests: MessageReader<TakePicture>,
    (clock, time): (Res<CycleClock>, Res<Time<Real>>),
    mut hidden: ResMut<HiddenPanels>,
    (mut due, mut is_due): (Local<Option<(f64, u32)>>, Local<bool>),
    mut commands: Commands,
) {
    let now_s = time.elapsed_secs_f64();
    let mut take = || {
        let name = format!("naoisis-{:06}", clock.cycle);
        let save = move |captured: On<ScreenshotCaptured>, mut notice: ResMut<Notice>| {
            let Some(picture) = picture_of(&captured.image) else { return };
            let written = png(&picture).and_then(|bytes| write_new(Path::new(""), &name, "png", &bytes));
            notice.tell(match written {
                Ok(path) => format!("Saved as {}", path.display()),
                Err(error) => format!("The picture was not saved: {error}"),
            });
        };
        commands.spawn(Screenshot::primary_window()).observe(save);
    };
    for request in requests.read() {
        match request {
            TakePicture::OfWindow => *is_due = true,
            TakePicture::OfMatch => *due = Some((now_s + FITTING_S, FITTING_FRAMES)),
        }
    }
    hidden.for_picture = due.is_some();
    // There is one picture of a frame at most, and one with panels after they are shown again.
    if *is_due && due.is_none() {
        take();
        *is_due = false;
    }
    if let Some((due_s, frames)) = &mut *due {
        if now_s >= *due_s && *frames == 0 {
            // This frame is still drawn without panels.
            take();
            *due = None;
        } else {
            *frames = frames.saturating_sub(1);
        }
    }
}

/// Converts a picture of the window; `None` if its pixels have a format that cannot be converted.
pub(super) fn picture_of(image: &Image) -> Option<Picture> {
    let rgb = image.clone().try_into_dynamic().ok()?.into_rgb8();
    Some(Picture { width: rgb.width(), height: rgb.height(), rgb: rgb.into_raw(), ..default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::time::TimeUpdateStrategy;
    use std::time::Duration;

    #[test]
    fn panels_are_hidden_until_the_picture_of_the_match_is_taken() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, PicturePlugin))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(300)))
            .init_resource::<CycleClock>();
        app.update();
        app.world_mut().write_message(TakePicture::OfMatch);
        let mut frames = Vec::new();
        for _ in 0..5 {
            app.update();
            let taken = app.world_mut().query::<&Screenshot>().iter(app.world()).count();
            frames.push((app.world().resource::<HiddenPanels>().for_picture, taken));
        }
        assert_eq!(frames, [(true, 0), (true, 0), (true, 0), (true, 1), (false, 1)]);
    }
}

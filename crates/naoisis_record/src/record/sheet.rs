//! Makes a contact sheet: a match at a glance, as in the paper's Fig. 8. It shows moments at equal intervals, each with the field above and
//! the view of one robot below.

use bevy::math::Vec2;
use bevy::prelude::World;
use std::path::{Path, PathBuf};

use super::canvas::{Anchor, Canvas, GREY, INK, PAPER};
use super::encoder::{Layer, RecordError, write_png};
use super::match_renderer::MatchRenderer;
use super::picture::FIELD_SAMPLES;
use super::video::check_extension;
use naoisis_core::camera_model::CameraName;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Game;
use naoisis_core::replace_file::UnfinishedFile;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::camera::image::Image;

/// Number of moments on a sheet.
const MOMENTS: usize = 8;
/// Number of moments that are kept during the match at most. The moments of the sheet are spread evenly among them.
const KEPT: usize = 8 * MOMENTS;
const COLUMNS: usize = 4;
/// Width of a moment, heights of its field and of the robot's view, the gap between moments, and the height of captions, pixels.
const WIDTH: u32 = 440;
const FIELD_HEIGHT: u32 = 248;
const VIEW_HEIGHT: u32 = 330;
const GAP: u32 = 14;
const CAPTION: u32 = 30;

/// Collects the moments of a contact sheet.
pub struct SheetRecorder {
    path: PathBuf,
    robot: RobotId,
    side: CameraName,
    /// The number of cycles from one moment to the next. It grows with the length of the match.
    interval: u64,
    moments: Vec<Moment>,
}

struct Moment {
    cycle: u64,
    caption: String,
    field: Image,
    view: Option<Image>,
}

impl SheetRecorder {
    /// Creates a sheet with the view of a robot's camera. It replaces an earlier file when the match is over.
    ///
    /// # Errors
    /// If the file's name does not end in `.png`, or it cannot be written.
    pub fn create(path: &Path, robot: RobotId, side: CameraName) -> Result<Self, RecordError> {
        check_extension(path, "png")?;
        // Test now whether it can be written, not after the match.
        UnfinishedFile::whole(path).map_err(RecordError::io(path))?;
        Ok(Self { path: path.to_owned(), robot, side, interval: 1, moments: Vec::new() })
    }

    /// Reads the last completed cycle.
    pub fn record(&mut self, world: &mut World, renderer: &mut MatchRenderer) {
        let clock = *world.resource::<CycleClock>();
        if !clock.cycle.is_multiple_of(self.interval) {
            return;
        }
        if self.moments.len() == KEPT {
            // The match is longer than expected: keep every other moment.
            self.interval *= 2;
            let interval = self.interval;
            self.moments.retain(|moment| moment.cycle.is_multiple_of(interval));
            if !clock.cycle.is_multiple_of(interval) {
                return;
            }
        }
        let score = world.resource::<Game>().score;
        self.moments.push(Moment {
            cycle: clock.cycle,
            caption: format!("{:.1} s   {} : {}", clock.end_time_s(), score.blue, score.pink),
            field: renderer.draw_field(world, [WIDTH, FIELD_HEIGHT], FIELD_SAMPLES),
            view: renderer.through_the_eyes_of(world, self.robot, self.side),
        });
    }

    /// Writes the sheet.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn finish(self) -> Result<(), RecordError> {
        let count = self.moments.len();
        let chosen: Vec<&Moment> = (0..count.min(MOMENTS))
            .map(|index| &self.moments[(index * (count - 1)) / (count.min(MOMENTS) - 1).max(1)])
            .collect();
        write_png(&self.path, Layer::Colours, &sheet(&chosen, self.robot)).map_err(RecordError::io(&self.path))
    }
}

fn sheet(moments: &[&Moment], robot: RobotId) -> Image {
    let columns = moments.len().clamp(1, COLUMNS) as u32;
    let rows = moments.len().div_ceil(COLUMNS).max(1) as u32;
    let [across, down] = [WIDTH + GAP, CAPTION + FIELD_HEIGHT + VIEW_HEIGHT + 2 + GAP];
    let mut canvas = Canvas::new([GAP + columns * across, GAP + rows * down], PAPER);
    for (index, moment) in moments.iter().enumerate() {
        let [column, row] = [index % COLUMNS, index / COLUMNS].map(|place| place as u32);
        let corner = Vec2::new((GAP + column * across) as f32, (GAP + row * down) as f32);
        canvas.words(&moment.caption, corner + Vec2::new(2.0, 20.0), 19.0, Anchor::Left, INK);
        let right = corner + Vec2::new(WIDTH as f32 - 2.0, 20.0);
        canvas.words(&format!("below: what {robot} sees"), right, 15.0, Anchor::Right, GREY);
        let field = corner + Vec2::Y * CAPTION as f32;
        canvas.picture(&moment.field, field, 1.0);
        let below = field + Vec2::Y * (FIELD_HEIGHT + 2) as f32;
        match &moment.view {
            Some(view) if view.width > 0 && view.height > 0 => {
                let scale = (WIDTH as f32 / view.width as f32).min(VIEW_HEIGHT as f32 / view.height as f32);
                canvas.picture(view, below, scale);
            }
            _ => {
                let size = Vec2::new(WIDTH as f32, VIEW_HEIGHT as f32);
                canvas.rectangle(below, size, GREY, 0.25);
                canvas.words("not on the pitch", below + size / 2.0, 18.0, Anchor::Middle, INK);
            }
        }
    }
    canvas.into_image()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::*;
    use naoisis_core::team::Team;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    #[test]
    fn moments_are_evenly_apart_whatever_the_match_takes() {
        let folder = tempfile::tempdir().unwrap();
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        let scenario = Scenario::from_json(r#"{ "rules": "free", "robots": [{ "number": 1 }] }"#).unwrap();
        app.start_match(&scenario).unwrap();
        let path = folder.path().join("sheet.png");
        let mut sheet = SheetRecorder::create(&path, RobotId::new(Team::Blue, 1), CameraName::TOP).unwrap();
        let mut renderer = MatchRenderer::default();
        renderer.look(app.world_mut());
        for cycles in [20, 30, 50] {
            for _ in 0..cycles {
                app.run_cycles(1);
                renderer.look(app.world_mut());
                sheet.record(app.world_mut(), &mut renderer);
            }
            let cycles: Vec<u64> = sheet.moments.iter().map(|moment| moment.cycle).collect();
            assert!((KEPT / 2..=KEPT).contains(&cycles.len()) || sheet.interval == 1, "{cycles:?}");
            assert!(cycles.windows(2).all(|pair| pair[1] - pair[0] == sheet.interval), "{cycles:?}");
        }
        sheet.finish().unwrap();
        assert!(path.metadata().unwrap().len() > 10_000);
    }
}

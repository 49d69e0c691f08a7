//! Records a sequence of frames: PNG files of the field and of the view of one robot, drawn in software.
//!
//! This is what `naoisis run match3v3 --frames DIR` does. A program can record anything between two cycles; this does
//! not change the match.
//!
//! Run with `cargo run --release --no-default-features --example record_frames [DIR]`; the folder must be new or empty.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use core::error::Error;
use naoisis::camera_model::CameraName;
use naoisis::prelude::*;
use naoisis::record::frames::FrameRecorder;
use naoisis::record::match_renderer::MatchRenderer;
use naoisis::record::picture::Picture;
use std::path::PathBuf;

/// The duration of the recording, and the number of cycles between frames: six frames per second.
const DURATION_S: u64 = 5;
const EVERY: u64 = 5;

fn main() -> Result<(), Box<dyn Error>> {
    if common::view(r#"{ "teams": { "blue": "passers", "pink": "roles" } }"#, |_| {}, |_| {})? {
        return Ok(());
    }
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "frames".to_owned()));
    let striker = RobotId::new(Team::Blue, 2);
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app.start_match(&Scenario::named("match3v3")?)?;
    let mut renderer = MatchRenderer::default();
    let pictures = vec![Picture::Field, Picture::Camera(striker, CameraName::TOP)];
    let mut frames = FrameRecorder::create(&folder, EVERY, pictures).map_err(|error| error.to_string())?;
    for _ in 0..30 * DURATION_S {
        app.run_cycles(1);
        // Every cycle, also without a frame, so that the legs follow the walk.
        renderer.look(app.world_mut());
        frames.record(app.world_mut(), &mut renderer);
    }
    let written = frames.finish()?;
    println!("{written} frames of {DURATION_S} s in {}:", folder.display());
    println!("  field/000005.png, ... and blue2_top/000005.png, ..., numbered by their cycles");
    Ok(())
}

//! Pictures and videos of `naoisis run`.

use bevy::prelude::*;
use clap::Args;
use std::path::PathBuf;

use super::outputs::Output;
use super::recording::Recording;
use naoisis_core::camera_model::CameraMounts;
use naoisis_core::cycle::CycleClock;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_record::record::encoder::RecordError;
use naoisis_record::record::frames::{FrameRecorder, remove_frames};
use naoisis_record::record::overlay::OverlayOf;
use naoisis_record::record::picture::Picture;
use naoisis_record::record::picture_recorder::PictureRecorder;
use naoisis_record::record::recorder::Recorder;
use naoisis_record::record::sheet::SheetRecorder;
use naoisis_record::record::video::VideoRecorder;
use naoisis_sensing::sensing::camera::CameraSettings;

/// The arguments for pictures.
#[derive(Args, Debug, Clone, Default)]
pub struct PictureArguments {
    /// Write frames into a new or empty folder: PNG files of the field, and of the robots' cameras if they are rendered
    #[arg(long, value_name = "DIR")]
    pub frames: Option<PathBuf>,
    /// Write a video of the field, or of `--views` side by side: a new .mp4 file
    #[arg(long, value_name = "FILE")]
    pub video: Option<PathBuf>,
    /// Write a contact sheet, the match on one page: a new .png file. Of the cameras in `--views`, it shows the first
    #[arg(long, value_name = "FILE")]
    pub sheet: Option<PathBuf>,
    /// The views of frames and video: field,blue1.top,pink2.bottom
    #[arg(long, value_name = "VIEWS", value_delimiter = ',')]
    pub views: Vec<Picture>,
    /// Draw over the field what robots sense, what they believe, or what their behaviours draw; of one robot or all:
    /// blue2.beliefs,senses,drawings
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub draw: Vec<OverlayOf>,
    /// Use only every N-th cycle for frames and video
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub every: Option<u64>,
}

impl Recording for PictureArguments {
    /// Checks that `--views` and `--every` apply to some output.
    fn check(&self) -> Result<(), String> {
        let moving = self.frames.is_some() || self.video.is_some();
        if self.every.is_some() && !moving {
            return Err("--every: expected --frames DIR or --video FILE with it".to_owned());
        }
        for (index, picture) in self.views.iter().enumerate() {
            if self.views[..index].contains(picture) {
                return Err(format!("--views: {picture} is listed twice; expected different views"));
            }
        }
        if !self.views.is_empty() && !moving && self.sheet.is_none() {
            return Err("--views: expected --frames DIR, --video FILE or --sheet FILE with it".to_owned());
        }
        if !self.draw.is_empty() && !moving && self.sheet.is_none() {
            return Err("--draw: expected --frames DIR, --video FILE or --sheet FILE with it".to_owned());
        }
        if !self.draw.is_empty() && !self.views.is_empty() && !self.views.contains(&Picture::Field) && moving {
            return Err("--draw: expected `field` among --views, which is what it draws on".to_owned());
        }
        Ok(())
    }

    fn outputs(&self) -> Vec<Output> {
        let files = [("--video", &self.video), ("--sheet", &self.sheet)];
        files.into_iter().filter_map(|(option, path)| Some(Output { option, path: path.clone()? })).collect()
    }

    fn open(&self, world: &World, force: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        for picture in &self.views {
            if let Picture::Camera(robot, _) = picture
                && world.resource::<Roster>().get(*robot).is_none()
            {
                return Err(format!(
                    "--views: {picture}: there is no such robot in the match; expected one of {}",
                    who_plays(world)
                ));
            }
            if let Picture::Camera(robot, camera) = picture
                && let mounts = mounts_of(world, *robot)
                && mounts.get(*camera).is_none()
            {
                let cameras: Vec<String> = mounts.names().map(|name| format!("{robot}.{name}")).collect();
                let expected = if cameras.is_empty() { "another robot".to_owned() } else { cameras.join(" or ") };
                return Err(format!("--views: {picture}: the robot has no such camera; expected {expected}"));
            }
        }
        for drawn in &self.draw {
            if drawn.robot.is_some_and(|robot| world.resource::<Roster>().get(robot).is_none()) {
                return Err(format!(
                    "--draw: {drawn}: there is no such robot in the match; expected one of {}",
                    who_plays(world)
                ));
            }
        }
        let every = self.every.unwrap_or(1);
        let cycle_s = world.resource::<CycleClock>().period_s;
        let mut pictures = PictureRecorder::default();
        pictures.renderer.overlays.clone_from(&self.draw);
        // The file of the video is created last, so that nothing is left behind if the command fails earlier.
        if let Some(path) = &self.sheet {
            let camera = self.views.iter().find_map(|picture| match picture {
                Picture::Camera(robot, side) => Some((*robot, *side)),
                Picture::Field => None,
            });
            let first_of = |id: RobotId| mounts_of(world, id).names().next().map(|camera| (id, camera));
            let first = || world.resource::<Roster>().iter().find_map(|(id, _)| first_of(id));
            let Some((robot, side)) = camera.or_else(first) else {
                return Err("--sheet: no robot has a camera; expected a robot with one".to_owned());
            };
            let sheet = SheetRecorder::create(path, robot, side);
            pictures.sheet = Some(sheet.map_err(|error| format!("--sheet: {error}"))?);
        }
        if let Some(folder) = &self.frames {
            let cleared = if force { remove_frames(folder) } else { Ok(()) };
            let frames = cleared.and_then(|()| FrameRecorder::create(folder, every, self.views.clone()));
            pictures.frames = Some(frames.map_err(|error| format!("--frames: {error}{}", or_force(&error)))?);
        }
        if let Some(path) = &self.video {
            let video = VideoRecorder::create(path, every, self.views.clone(), cycle_s);
            pictures.video = Some(video.map_err(|error| format!("--video: {error}"))?);
        }
        Ok(if pictures.is_empty() { Vec::new() } else { vec![Box::new(pictures)] })
    }
}

/// Returns a hint that --force helps, for errors about existing frames.
pub fn or_force(error: &RecordError) -> &'static str {
    if matches!(error, RecordError::NotEmpty(_)) { ", or --force to replace frames that are there" } else { "" }
}

/// Returns the list of the robots in the match.
fn who_plays(world: &World) -> String {
    let robots: Vec<String> = world.resource::<Roster>().iter().map(|(id, _)| id.to_string()).collect();
    robots.join(", ")
}

/// Returns the cameras of a robot.
fn mounts_of(world: &World, robot: RobotId) -> CameraMounts {
    let robot = world.resource::<Roster>().get(robot);
    let settings = robot.and_then(|robot| world.get::<CameraSettings>(robot));
    settings.map(|settings| settings.mounts).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_for_pictures_need_pictures_and_each_view_is_named_once() {
        let frames = Some(PathBuf::from("frames"));
        let views = |words: &[&str]| words.iter().map(|word| word.parse().unwrap()).collect::<Vec<Picture>>();
        let fine = PictureArguments { frames, views: views(&["field", "blue1.top"]), every: Some(2), ..default() };
        assert_eq!(fine.check(), Ok(()));
        let twice = PictureArguments { views: views(&["blue1.top", "field", "blue1.top"]), ..fine.clone() };
        assert!(twice.check().unwrap_err().starts_with("--views: blue1.top is listed twice"));
        let only_sheet = PictureArguments { frames: None, sheet: fine.frames.clone(), ..fine.clone() };
        assert!(only_sheet.check().unwrap_err().starts_with("--every"));
        let drawn = PictureArguments { draw: vec!["beliefs".parse().unwrap()], ..default() };
        assert!(drawn.check().unwrap_err().starts_with("--draw: expected --frames"));
        let unseen = PictureArguments { views: views(&["blue1.top"]), draw: drawn.draw, ..fine.clone() };
        assert!(unseen.check().unwrap_err().starts_with("--draw: expected `field`"));
        let nothing = PictureArguments { frames: None, every: None, ..fine };
        assert!(nothing.check().unwrap_err().starts_with("--views"));
    }
}

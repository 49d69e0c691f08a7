//! Makes the images of one match: moments are played or drawn, images taken, labelled and written.

use bevy::app::App;
use jpeg_encoder::{ColorType, Encoder};
use std::io;
use std::path::PathBuf;

use super::annotate::annotations;
use super::folder::Folder;
use super::looks::{ImageLooks, MatchLooks};
use super::moments::{Cast, Moment, drawn, played};
use super::record::{ImageRecord, MatchFacts, Split, metadata};
use super::shot::{MatchSetting, Shot, take};
use super::staging::Surroundings;
use super::texture::Texture;
use super::{DatasetError, DatasetFormat, DatasetSettings, tar, yolo};
use crate::record::png_file::{Layer, encode_png};
use naoisis_core::random::RandomStream;
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sensing::sensing::camera::software::stage_camera::StageCamera;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::MatchApp;

/// Plays matches and takes images, on one thread.
pub struct Worker {
    app: App,
    camera: StageCamera,
}

/// Returns the number of images of match `index`.
pub fn count_of(settings: &DatasetSettings, index: usize) -> u32 {
    let each = settings.images_of_match();
    each.min(settings.images.saturating_sub(each * index as u32))
}

/// Checks that matches of the scenario start, and that at least one robot has a camera.
pub fn check(app: &mut App, scenario: &Scenario) -> Result<(), DatasetError> {
    app.start_match(scenario).map_err(DatasetError::Match)?;
    if Cast::of(app.world(), scenario).has_cameras() { Ok(()) } else { Err(DatasetError::NoCameras) }
}

/// The files of one image.
struct Files {
    jpeg: Vec<u8>,
    mask: Option<Vec<u8>>,
    depth: Option<Vec<u8>>,
}

impl Worker {
    /// Creates a worker. `app` has no match.
    pub fn new(app: App) -> Self {
        Self { app, camera: StageCamera::default() }
    }

    /// Makes the images of a match.
    pub fn make_match(
        &mut self,
        folder: &Folder,
        scenario: &Scenario,
        settings: &DatasetSettings,
        index: usize,
    ) -> Result<(), DatasetError> {
        let seed = settings.seed.wrapping_add(index as u64);
        let scenario = Scenario { seed, ..scenario.clone() };
        let realism = scenario.realism_in_words();
        let facts = MatchFacts { index, seed, scenario: &scenario.name, realism: &realism };
        let mut stream = RandomStream::for_match(seed, "data set");
        self.app.start_match(&scenario).map_err(DatasetError::Match)?;
        let mut scene = Scene::default();
        scene.gather(self.app.world_mut());
        let looks = MatchLooks::draw(&settings.ranges, scene.markings.goal_colours, &mut stream);
        let setting = MatchSetting {
            surroundings: Surroundings::draw(&scene.pitch, &looks, &mut stream),
            texture: Texture::draw(&mut stream),
            looks,
        };
        let moments = self.moments(&scenario, settings, &scene, count_of(settings, index) as usize, &mut stream);
        let mut images = Vec::with_capacity(moments.len());
        for (number, moment) in moments.iter().enumerate() {
            let image_looks = ImageLooks::draw(&settings.ranges, &mut stream);
            let Some(shot) = take(&mut self.camera, moment, &setting, &image_looks, &mut stream) else { continue };
            let record = ImageRecord {
                stem: format!("{index:06}_{number:02}"),
                width: shot.image.width,
                height: shot.image.height,
                annotations: annotations(&shot, &moment.scene.markings, &settings.ranges.labels),
                metadata: metadata(facts, moment, &shot, &setting.looks, &image_looks),
            };
            let files = Files::of(shot, settings, image_looks.jpeg_quality)
                .map_err(|error| DatasetError::Io { path: folder.path().to_owned(), error })?;
            write_files(folder, settings, Split::of_match(index), &record, &files)?;
            images.push((record, files));
        }
        if settings.formats.contains(&DatasetFormat::Webdataset) {
            write_archive(folder, settings, index, &images)?;
        }
        let records: Vec<ImageRecord> = images.into_iter().map(|(record, _)| record).collect();
        folder.finish_match(index, &records)
    }

    /// Returns the moments of a match that has started, either played or drawn. Moments are drawn, too, if too few played ones were found.
    fn moments(
        &mut self,
        scenario: &Scenario,
        settings: &DatasetSettings,
        scene: &Scene,
        count: usize,
        stream: &mut RandomStream,
    ) -> Vec<Moment> {
        let ranges = &settings.ranges;
        let mut cast = Cast::of(self.app.world(), scenario);
        if let Some(size) = settings.size {
            cast.set_size(size);
        }
        let is_drawn = stream.chance(ranges.scenes.drawn_share);
        let mut moments =
            if is_drawn { Vec::new() } else { played(&mut self.app, scenario, &cast, &ranges.scenes, count, stream) };
        while moments.len() < count {
            let Some(moment) = drawn(scene, &cast, ranges, stream) else { break };
            moments.push(moment);
        }
        moments
    }
}

impl Files {
    fn of(shot: Shot, settings: &DatasetSettings, quality: u8) -> io::Result<Self> {
        let Shot { mut image, objects, .. } = shot;
        let jpeg = jpeg(&image, quality)?;
        let png = |layer: Layer, image: &Image| {
            let mut bytes = Vec::new();
            encode_png(&mut bytes, layer, image).map(|()| bytes)
        };
        let depth = settings.depth.then(|| png(Layer::Depth, &image)).transpose()?;
        // Maps numbers of objects to their labels. Lower numbers are labels already.
        let mut table: [u8; 256] = core::array::from_fn(|number| number as u8);
        for object in &objects {
            table[usize::from(object.number)] = object.label as u8;
        }
        image.labels.iter_mut().for_each(|label| *label = table[usize::from(*label)]);
        let mask = settings.masks.then(|| png(Layer::Labels, &image)).transpose()?;
        Ok(Self { jpeg, mask, depth })
    }

    fn layers(&self) -> impl Iterator<Item = (&'static str, &Vec<u8>)> {
        [("masks", &self.mask), ("depth", &self.depth)]
            .into_iter()
            .filter_map(|(name, layer)| Some((name, layer.as_ref()?)))
    }
}

fn jpeg(image: &Image, quality: u8) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let size = |size: u32| u16::try_from(size).map_err(io::Error::other);
    let encoder = Encoder::new(&mut bytes, quality);
    encoder.encode(&image.rgb, size(image.width)?, size(image.height)?, ColorType::Rgb).map_err(io::Error::other)?;
    Ok(bytes)
}

/// Writes the files of an image, in all layouts that have separate files for each image.
fn write_files(
    folder: &Folder,
    settings: &DatasetSettings,
    split: Split,
    record: &ImageRecord,
    files: &Files,
) -> Result<(), DatasetError> {
    let ImageRecord { stem, width, height, annotations, .. } = record;
    let place = |outer: &str, split: &str, ending: &str| -> PathBuf {
        folder.path().join(outer).join(split).join(format!("{stem}.{ending}"))
    };
    if settings.formats.contains(&DatasetFormat::Coco) {
        folder.write(&place("", split.name(), "jpg"), &files.jpeg)?;
    }
    if settings.formats.contains(&DatasetFormat::Yolo) {
        let text = yolo::label_file(annotations, [*width, *height], settings.names, settings.yolo);
        folder.write(&place("images", split.yolo_name(), "jpg"), &files.jpeg)?;
        folder.write(&place("labels", split.yolo_name(), "txt"), text.as_bytes())?;
    }
    if settings.formats.iter().any(|format| *format != DatasetFormat::Webdataset) {
        for (layer, bytes) in files.layers() {
            folder.write(&place(layer, split.name(), "png"), bytes)?;
        }
    }
    Ok(())
}

/// Writes the archive of a match.
fn write_archive(
    folder: &Folder,
    settings: &DatasetSettings,
    index: usize,
    images: &[(ImageRecord, Files)],
) -> Result<(), DatasetError> {
    let name = format!("{}-{:06}.tar", Split::of_match(index).name(), Split::place_of_match(index));
    let path = folder.path().join(name);
    let mut bytes = Vec::new();
    let mut fill = || {
        for (record, files) in images {
            let stem = &record.stem;
            tar::add(&mut bytes, &format!("{stem}.jpg"), &files.jpeg)?;
            for (layer, png) in files.layers() {
                tar::add(&mut bytes, &format!("{stem}.{}.png", layer.trim_end_matches('s')), png)?;
            }
            let labelled = record.annotations.iter().filter_map(|it| Some((settings.names.number(it.class)?, it)));
            let labelled: Vec<_> = labelled
                .map(|(category, annotation)| serde_json::json!({ "category_id": category, "annotation": annotation }))
                .collect();
            let json = serde_json::json!({ "width": record.width, "height": record.height, "objects": labelled,
                "metadata": record.metadata });
            tar::add(&mut bytes, &format!("{stem}.json"), json.to_string().as_bytes())?;
        }
        tar::end(&mut bytes)
    };
    fill().map_err(|error| DatasetError::Io { path: path.clone(), error })?;
    folder.write(&path, &bytes)
}

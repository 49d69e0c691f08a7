//! The folder of a data set: its contents, whether it can be continued, and the files that are written at the end.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::record::{ImageRecord, Split};
use super::{DatasetError, DatasetFormat, DatasetSettings, coco, yolo};
use naoisis_core::read_file::read_file;
use naoisis_core::replace_file::replace_file;

/// Name of the file with the settings of a data set.
pub const SETTINGS_FILE: &str = "dataset.json";
/// Name of the file with a line about each image.
const METADATA_FILE: &str = "metadata.jsonl";
/// Name of the file that describes the data set to Ultralytics' tools.
const YOLO_FILE: &str = "data.yaml";
/// Name of the folder with the records of finished matches.
const PARTS: &str = ".parts";

/// The contents of the settings file.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
struct About {
    /// The version of the program.
    naoisis: String,
    settings: Value,
    /// The scenario, with all of its settings.
    scenario: Value,
    is_complete: bool,
}

/// The folder of a data set.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    about: About,
}

/// The state of a folder before anything is written.
#[derive(Debug)]
pub enum Found {
    /// The data set can be made, or continued.
    Ready(Folder),
    /// The data set is complete and has the same settings.
    Complete,
}

impl Folder {
    /// Opens the folder of a data set, and creates it if there is none. With `force`, a data set with other settings is removed.
    ///
    /// # Errors
    /// If the folder has other contents or cannot be written to.
    pub fn open(path: &Path, settings: &DatasetSettings, scenario: Value, force: bool) -> Result<Found, DatasetError> {
        let about = About {
            naoisis: env!("CARGO_PKG_VERSION").to_owned(),
            settings: serde_json::to_value(settings).unwrap_or_default(),
            scenario,
            is_complete: false,
        };
        if path.is_file() {
            return Err(DatasetError::NotAFolder(path.to_owned()));
        }
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        if let Some(parent) = parent.filter(|parent| !parent.is_dir()) {
            let missing = parent
                .ancestors()
                .filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir())
                .last()
                .unwrap_or(parent);
            return Err(DatasetError::NoParent { path: path.to_owned(), missing: missing.to_owned() });
        }
        let folder = Self { path: path.to_owned(), about };
        let mut is_empty = true;
        if path.is_dir() {
            is_empty = fs::read_dir(path).map_err(folder.io(path))?.next().is_none();
        }
        if !is_empty {
            let Some(earlier) = read_about(path) else { return Err(DatasetError::Foreign(path.to_owned())) };
            let differs = folder.difference(&earlier);
            match differs {
                None if !force => {
                    if earlier.is_complete {
                        return Ok(Found::Complete);
                    }
                }
                Some(field) if !force => return Err(DatasetError::OtherSettings { path: path.to_owned(), field }),
                _ => folder.clear()?,
            }
        }
        for inner in folder.folders_needed() {
            fs::create_dir_all(&inner).map_err(folder.io(&inner))?;
            folder.remove_unfinished(&inner)?;
        }
        folder.write_about(false)?;
        if let Some(task) = settings.formats.contains(&DatasetFormat::Yolo).then_some(settings.yolo) {
            folder.write(&path.join(YOLO_FILE), yolo::data_file(settings.names, task).as_bytes())?;
        }
        Ok(Found::Ready(folder))
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the first setting in which an earlier data set differs.
    fn difference(&self, earlier: &About) -> Option<String> {
        if self.about.naoisis != earlier.naoisis {
            return Some("version of naoisis".to_owned());
        }
        let fields = self.about.settings.as_object()?;
        let differs = fields.iter().find(|(name, value)| earlier.settings.get(name.as_str()) != Some(value));
        match differs {
            Some((name, _)) => Some(name.clone()),
            None => (self.about.scenario != earlier.scenario).then(|| "scenario".to_owned()),
        }
    }

    fn folders_needed(&self) -> Vec<PathBuf> {
        let formats = self.about.settings.get("formats").cloned().unwrap_or_default();
        let formats: Vec<DatasetFormat> = serde_json::from_value(formats).unwrap_or_default();
        let has = |field: &str| self.about.settings.get(field) == Some(&Value::Bool(true));
        let mut folders = vec![self.path.join(PARTS)];
        for split in Split::ALL {
            let mut add = |outer: &str, name: &str| folders.push(self.path.join(outer).join(name));
            if formats.contains(&DatasetFormat::Coco) {
                add("", split.name());
            }
            if formats.contains(&DatasetFormat::Yolo) {
                add("images", split.yolo_name());
                add("labels", split.yolo_name());
            }
            if formats.iter().any(|format| *format != DatasetFormat::Webdataset) {
                for layer in ["masks", "depth"].into_iter().filter(|layer| has(layer)) {
                    add(layer, split.name());
                }
            }
        }
        folders
    }

    /// Removes incomplete files that a killed program left behind.
    fn remove_unfinished(&self, inner: &Path) -> Result<(), DatasetError> {
        for entry in fs::read_dir(inner).map_err(self.io(inner))? {
            let path = entry.map_err(self.io(inner))?.path();
            if path.extension().is_some_and(|extension| extension == "part") {
                fs::remove_file(&path).map_err(self.io(&path))?;
            }
        }
        Ok(())
    }

    /// Removes an earlier data set: only files with names that this module writes, and the folders that are empty after that.
    fn clear(&self) -> Result<(), DatasetError> {
        // The settings file comes first, since it says that the data set is complete.
        for name in [SETTINGS_FILE, METADATA_FILE, YOLO_FILE] {
            let file = self.path.join(name);
            if file.is_file() {
                fs::remove_file(&file).map_err(self.io(&file))?;
            }
        }
        self.remove_written(&self.path, is_archive)?;
        for name in [PARTS, "train", "valid", "test"] {
            self.clear_folder(&self.path.join(name))?;
        }
        for name in ["images", "labels", "masks", "depth"] {
            let outer = self.path.join(name);
            if outer.is_dir() && !outer.is_symlink() {
                for inner in ["train", "valid", "val", "test"] {
                    self.clear_folder(&outer.join(inner))?;
                }
                self.remove_if_empty(&outer)?;
            }
        }
        Ok(())
    }

    /// Removes the files of a data set in a folder, and the folder if it is empty after that.
    fn clear_folder(&self, inner: &Path) -> Result<(), DatasetError> {
        if inner.is_dir() && !inner.is_symlink() {
            self.remove_written(inner, |name| name == coco::FILE || is_file_of_match(name))?;
            self.remove_if_empty(inner)?;
        }
        Ok(())
    }

    /// Removes the files in a folder with names for which `is_written` is true.
    fn remove_written(&self, inner: &Path, is_written: impl Fn(&str) -> bool) -> Result<(), DatasetError> {
        for entry in fs::read_dir(inner).map_err(self.io(inner))? {
            let entry = entry.map_err(self.io(inner))?;
            let path = entry.path();
            if entry.file_name().to_str().is_some_and(&is_written) && path.is_file() {
                fs::remove_file(&path).map_err(self.io(&path))?;
            }
        }
        Ok(())
    }

    fn remove_if_empty(&self, inner: &Path) -> Result<(), DatasetError> {
        let is_empty = fs::read_dir(inner).map_err(self.io(inner))?.next().is_none();
        if is_empty { fs::remove_dir(inner).map_err(self.io(inner)) } else { Ok(()) }
    }

    fn part(&self, index: usize) -> PathBuf {
        self.path.join(PARTS).join(format!("{index:06}.jsonl"))
    }

    /// Returns whether all images of a match are there.
    pub fn has_match(&self, index: usize) -> bool {
        self.part(index).is_file()
    }

    /// Notes that all images of a match are there, by writing their records.
    pub fn finish_match(&self, index: usize, records: &[ImageRecord]) -> Result<(), DatasetError> {
        let mut text = Vec::new();
        for record in records {
            serde_json::to_writer(&mut text, record).map_err(|error| self.io(&self.path)(error.into()))?;
            text.push(b'\n');
        }
        self.write(&self.part(index), &text)
    }

    /// Writes a file atomically.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
        replace_file(path, |mut file| file.write_all(bytes)).map_err(self.io(path))
    }

    /// Returns a function that turns an I/O error at `path` into a [`DatasetError`].
    fn io(&self, path: &Path) -> impl FnOnce(io::Error) -> DatasetError + use<> {
        let path = path.to_owned();
        move |error| DatasetError::Io { path, error }
    }

    fn write_about(&self, is_complete: bool) -> Result<(), DatasetError> {
        let about = About { is_complete, ..self.about.clone() };
        let text = serde_json::to_string_pretty(&about).unwrap_or_default() + "\n";
        self.write(&self.path.join(SETTINGS_FILE), text.as_bytes())
    }

    /// Writes the files about all images of the finished matches, out of `matches`. Returns the number of images.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn annotate(&self, settings: &DatasetSettings, matches: usize) -> Result<u32, DatasetError> {
        let mut all = Vec::new();
        for index in (0..matches).filter(|index| self.has_match(*index)) {
            let part = self.part(index);
            let bytes = fs::read(&part).map_err(self.io(&part))?;
            for line in bytes.split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
                let record: ImageRecord = serde_json::from_slice(line).map_err(|error| self.io(&part)(error.into()))?;
                all.push((Split::of_match(index), record));
            }
        }
        if settings.formats.contains(&DatasetFormat::Coco) {
            for split in Split::ALL {
                let of_split = all.iter().filter(|(other, _)| *other == split).map(|(_, record)| record);
                let path = self.path.join(split.name()).join(coco::FILE);
                let about = "Images of robot soccer, drawn by naoisis";
                let written = replace_file(&path, |file| {
                    let mut out = BufWriter::new(file);
                    coco::write(&mut out, settings.names, about, &of_split.collect::<Vec<_>>())?;
                    out.flush()
                });
                written.map_err(self.io(&path))?;
            }
        }
        let path = self.path.join(METADATA_FILE);
        let written = replace_file(&path, |file| {
            let mut out = BufWriter::new(file);
            for (split, record) in &all {
                serde_json::to_writer(&mut out, &described(*split, record, settings))?;
                out.write_all(b"\n")?;
            }
            out.flush()
        });
        written.map_err(self.io(&path))?;
        Ok(all.len() as u32)
    }

    /// Writes the files about all images, and notes that the data set is complete if all `matches` are finished. Returns the number of
    /// images.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn finish(&self, settings: &DatasetSettings, matches: usize) -> Result<u32, DatasetError> {
        let images = self.annotate(settings, matches)?;
        if (0..matches).all(|index| self.has_match(index)) {
            self.write_about(true)?;
            let parts = self.path.join(PARTS);
            fs::remove_dir_all(&parts).map_err(self.io(&parts))?;
        }
        Ok(images)
    }
}

/// Returns the line of an image in `metadata.jsonl`: its file name first, and its objects as lists, as the `imagefolder` of `datasets`
/// expects them.
fn described(split: Split, record: &ImageRecord, settings: &DatasetSettings) -> Value {
    let stem = &record.stem;
    let file_name = match settings.formats.first() {
        Some(DatasetFormat::Yolo) => format!("images/{}/{stem}.jpg", split.yolo_name()),
        Some(DatasetFormat::Webdataset) => format!("{stem}.jpg"),
        _ => format!("{}/{stem}.jpg", split.name()),
    };
    let labelled = record.annotations.iter().filter_map(|it| Some((settings.names.number(it.class)?, it)));
    let (categories, annotations): (Vec<usize>, Vec<_>) = labelled.unzip();
    let mut line = serde_json::json!({
        "file_name": file_name,
        "split": split,
        "width": record.width,
        "height": record.height,
        "objects": {
            "category": categories,
            "bbox": annotations.iter().map(|it| it.bbox).collect::<Vec<_>>(),
            "area": annotations.iter().map(|it| it.area).collect::<Vec<_>>(),
            "visible": annotations.iter().map(|it| it.visible).collect::<Vec<_>>(),
            "object": annotations.iter().map(|it| it.object.as_str()).collect::<Vec<_>>(),
        },
    });
    if let (Some(line), Some(metadata)) = (line.as_object_mut(), record.metadata.as_object()) {
        line.extend(metadata.clone());
    }
    line
}

/// Returns whether `name` is the name of an archive of a match, such as `train-000012.tar`.
fn is_archive(name: &str) -> bool {
    let Some(stem) = name.strip_suffix(".tar") else { return false };
    let number = Split::ALL.iter().find_map(|split| stem.strip_prefix(split.name())?.strip_prefix('-'));
    number.is_some_and(|number| is_number(number, 6))
}

/// Returns whether `name` is the name of a match's records or of one of its images, such as `000012.jsonl` or `000012_03.jpg`.
fn is_file_of_match(name: &str) -> bool {
    let Some((stem, extension)) = name.split_once('.') else { return false };
    match (stem.split_once('_'), extension) {
        (None, "jsonl") => is_number(stem, 6),
        (Some((index, number)), "jpg" | "txt" | "png") => is_number(index, 6) && is_number(number, 2),
        _ => false,
    }
}

/// Returns whether `digits` is a number that was formatted with at least `least` digits.
fn is_number(digits: &str, least: usize) -> bool {
    digits.len() >= least && digits.bytes().all(|byte| byte.is_ascii_digit())
}

fn read_about(path: &Path) -> Option<About> {
    serde_json::from_slice(&read_file(&path.join(SETTINGS_FILE)).ok()?).ok()
}

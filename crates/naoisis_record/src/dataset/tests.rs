//! Tests with small but complete data sets.

use bevy::app::App;
use core::sync::atomic::{AtomicBool, Ordering};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use super::*;
use naoisis_sim::simulation::NaoisisPlugins;

fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app
}

/// Returns settings for few and small images, which need no long matches.
fn settings(images: u32) -> DatasetSettings {
    let folder = tempfile::tempdir().unwrap();
    let looks = folder.path().join("looks.json");
    fs::write(&looks, r#"{ "scenes": { "first_s": [0.5, 2], "gap_s": [0.1, 0.3] }, "labels": { "least_px": 3 } }"#)
        .unwrap();
    let size = Some([96, 72]);
    DatasetSettings { size, ..DatasetSettings::new(images, Ranges::read(Some(&looks)).unwrap()) }
}

fn scenario() -> Scenario {
    Scenario::named("match3v3").unwrap()
}

fn made(folder: &Path, settings: &DatasetSettings, force: bool, threads: usize) -> Result<Made, DatasetError> {
    make(folder, &scenario(), settings, force, threads, &AtomicBool::new(false), simulator, |_| {})
}

/// Returns all files of a folder with their bytes.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    found
}

#[test]
fn a_data_set_is_the_same_on_any_number_of_threads_and_after_an_interruption() {
    let folder = tempfile::tempdir().unwrap();
    let [one, three, continued] = ["one", "three", "continued"].map(|name| folder.path().join(name));
    let settings =
        DatasetSettings { masks: true, formats: vec![DatasetFormat::Coco, DatasetFormat::Yolo], ..settings(12) };
    assert_eq!(made(&one, &settings, false, 1).unwrap(), Made { images: 12, earlier: 0, is_complete: true });
    made(&three, &settings, false, 3).unwrap();
    let whole = files(&one);
    assert!(whole == files(&three), "other bytes");

    // At any moment, most of the images have annotations.
    let annotated = |split: &str| {
        let text = fs::read(continued.join(split).join("_annotations.coco.json")).unwrap();
        serde_json::from_slice::<Value>(&text).unwrap()["images"].as_array().unwrap().len()
    };
    // Stopped after some matches: the existing images have annotations.
    let stop = AtomicBool::new(false);
    let stopped = make(&continued, &scenario(), &settings, false, 1, &stop, simulator, |images| {
        assert!(5 * ["train", "valid", "test"].map(annotated).iter().sum::<usize>() >= 4 * images as usize);
        stop.store(images >= 5, Ordering::SeqCst);
    });
    let stopped = stopped.unwrap();
    assert!((5..12).contains(&stopped.images) && !stopped.is_complete);
    let coco: Value = serde_json::from_slice(&files(&continued)["train/_annotations.coco.json"]).unwrap();
    assert!(!coco["images"].as_array().unwrap().is_empty());
    // Killed in the middle of a match: some of its images exist, and half of another one.
    let left = continued.join("train/000009_00.jpg");
    fs::write(&left, "half an image").unwrap();
    fs::write(continued.join("train/000009_00.jpg.77.part"), "half an image").unwrap();
    let finished = made(&continued, &settings, false, 2).unwrap();
    assert_eq!(finished, Made { images: 12, earlier: stopped.images, is_complete: true });
    assert!(whole == files(&continued), "continued otherwise");
    // A complete data set is not changed.
    fs::remove_file(&left).unwrap();
    assert_eq!(made(&continued, &settings, false, 2).unwrap().earlier, 12);
    assert!(!left.exists());
    assert_eq!(made(&continued, &settings, true, 2).unwrap().earlier, 0);
    assert!(whole == files(&continued), "made again otherwise");
}

#[test]
fn folders_with_other_things_and_other_settings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name);
    fs::write(inside("diary.txt"), "dear diary").unwrap();
    let small = settings(1);
    assert!(matches!(made(folder.path(), &small, true, 1), Err(DatasetError::Foreign(_))));
    assert!(matches!(made(&inside("diary.txt"), &small, false, 1), Err(DatasetError::NotAFolder(_))));
    let error = made(&inside("a/b/c"), &small, false, 1).unwrap_err();
    assert!(matches!(&error, DatasetError::NoParent { missing, .. } if *missing == inside("a")), "{error}");
    let set = inside("set");
    made(&set, &small, false, 1).unwrap();
    let own = ["notes.txt", "train/notes.txt", "train/1.jpg", "masks/own/000000_00.png", "train-my.tar"];
    for name in own {
        fs::create_dir_all(set.join(name).parent().unwrap()).unwrap();
        fs::write(set.join(name), "mine").unwrap();
    }
    let other = DatasetSettings { seed: 9, ..small };
    let error = made(&set, &other, false, 1).unwrap_err();
    assert!(matches!(&error, DatasetError::OtherSettings { field, .. } if field == "seed"), "{error}");
    made(&set, &other, true, 1).unwrap();
    assert!(own.iter().all(|name| set.join(name).is_file()), "what is not of the data set is kept");
    // Without robots there are no cameras.
    let blind = Scenario { robots: Vec::new(), teams: None, ..scenario() };
    let error = make(&inside("blind"), &blind, &other, false, 1, &AtomicBool::new(false), simulator, |_| {});
    assert!(matches!(error, Err(DatasetError::NoCameras)));
    assert!(!inside("blind").exists());
}

#[test]
fn annotations_are_in_their_images_and_matches_in_one_split() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let settings = DatasetSettings { size: Some([160, 120]), ..settings(40) };
    made(&set, &settings, false, 2).unwrap();
    let files = files(&set);
    let mut matches = BTreeMap::new();
    let (mut boxes, mut classes) = (0, BTreeSet::new());
    for split in record::Split::ALL {
        let coco: Value = serde_json::from_slice(&files[&format!("{}/_annotations.coco.json", split.name())]).unwrap();
        let images = coco["images"].as_array().unwrap();
        assert!(!images.is_empty());
        for image in images {
            let name = image["file_name"].as_str().unwrap();
            assert!(files[&format!("{}/{name}", split.name())].starts_with(&[0xff, 0xd8]), "{name}");
            let other = matches.insert(name[..6].to_owned(), split);
            assert!(other.is_none_or(|other| other == split), "{name}");
        }
        for annotation in coco["annotations"].as_array().unwrap() {
            let numbers: Vec<f64> = annotation["bbox"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
            let [left, top, width, height] = numbers.try_into().unwrap();
            assert!(left >= 0.0 && top >= 0.0 && left + width <= 160.0 && top + height <= 120.0, "{annotation}");
            assert!(width >= 3.0 && height >= 3.0);
            let (area, visible) =
                (annotation["area"].as_f64().unwrap(), annotation["attributes"]["visible"].as_f64().unwrap());
            assert!(area <= width * height && (0.15..=1.0).contains(&visible), "{annotation}");
            for polygon in annotation["segmentation"].as_array().unwrap() {
                let polygon: Vec<f64> = polygon.as_array().unwrap().iter().filter_map(Value::as_f64).collect();
                let is_inside = |pixel: &[f64]| {
                    (left..=left + width).contains(&pixel[0]) && (top..=top + height).contains(&pixel[1])
                };
                assert!(polygon.len() >= 6 && polygon.chunks(2).all(is_inside), "{annotation}");
            }
            boxes += 1;
            classes.insert(annotation["category_id"].as_u64().unwrap());
        }
    }
    assert_eq!(matches.len(), 20);
    assert!(boxes > 100 && classes.len() >= 6, "{boxes} {classes:?}");
    let metadata = String::from_utf8(files["metadata.jsonl"].clone()).unwrap();
    let lines: Vec<Value> = metadata.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 40);
    for line in &lines {
        assert!(files.contains_key(line["file_name"].as_str().unwrap()));
        assert_eq!(
            line["objects"]["bbox"].as_array().map(Vec::len),
            line["objects"]["category"].as_array().map(Vec::len)
        );
    }
    let of_kind = |kind: &str| lines.iter().filter(|line| line["scene"] == kind).count();
    assert!(of_kind("played") > 5 && of_kind("drawn") > 5);
}

#[test]
fn archives_have_the_files_of_each_image_together() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let formats = vec![DatasetFormat::Webdataset];
    made(&set, &DatasetSettings { formats, masks: true, depth: true, ..settings(4) }, false, 2).unwrap();
    let archives: Vec<String> = files(&set).into_keys().filter(|name| name.ends_with(".tar")).collect();
    assert_eq!(archives, ["test-000000.tar", "train-000000.tar", "train-000001.tar", "valid-000000.tar"]);
    let bytes = fs::read(set.join("train-000000.tar")).unwrap();
    assert!(bytes.len().is_multiple_of(512));
    let (mut at, mut names) = (0, Vec::new());
    while bytes[at] != 0 {
        let name = bytes[at..at + 100].split(|byte| *byte == 0).next().unwrap();
        names.push(String::from_utf8(name.to_vec()).unwrap());
        let length = usize::from_str_radix(core::str::from_utf8(&bytes[at + 124..at + 135]).unwrap(), 8).unwrap();
        at += 512 + length.next_multiple_of(512);
    }
    assert_eq!(names, ["000000_00.jpg", "000000_00.mask.png", "000000_00.depth.png", "000000_00.json"]);
}

//! Annotations in COCO's format: `_annotations.coco.json` beside the images of each split, as Roboflow lays them out.

use serde_json::{Value, json};
use std::io::{self, Write};

use super::annotate::Annotation;
use super::names::{Class, ClassNames, KEYPOINTS, SKELETON};
use super::record::ImageRecord;

/// The name of the file with the annotations of a split.
pub const FILE: &str = "_annotations.coco.json";

/// Writes the annotations of the images of one split.
pub fn write(out: &mut impl Write, names: ClassNames, about: &str, records: &[&ImageRecord]) -> io::Result<()> {
    let categories: Vec<Value> =
        names.list().iter().enumerate().map(|(id, (name, class))| category(id, name, *class)).collect();
    let info = json!({ "description": about, "version": "1.0" });
    write!(out, "{{\"info\":{info},\"licenses\":[],\"categories\":{},\"images\":[", json!(categories))?;
    for (index, record) in records.iter().enumerate() {
        let ImageRecord { stem, width, height, .. } = record;
        let image = json!({ "id": index, "file_name": format!("{stem}.jpg"), "width": width, "height": height });
        write!(out, "{}\n{image}", if index > 0 { "," } else { "" })?;
    }
    write!(out, "],\"annotations\":[")?;
    let mut id = 0;
    for (image, record) in records.iter().enumerate() {
        for annotation in &record.annotations {
            let Some(category) = names.number(annotation.class) else { continue };
            id += 1;
            let line = of(annotation, id, image, category);
            write!(out, "{}\n{line}", if id > 1 { "," } else { "" })?;
        }
    }
    writeln!(out, "]}}")
}

fn category(id: usize, name: &str, class: Option<Class>) -> Value {
    let mut category = json!({ "id": id, "name": name, "supercategory": "none" });
    if class == Some(Class::Robot) {
        category["keypoints"] = json!(KEYPOINTS);
        category["skeleton"] = json!(SKELETON);
    }
    category
}

fn of(annotation: &Annotation, id: usize, image: usize, category: usize) -> Value {
    let Annotation { bbox, area, visible, truncated, distance_m, object, .. } = annotation;
    let polygons: Vec<Vec<u32>> = annotation.polygons.iter().map(|polygon| polygon.as_flattened().to_vec()).collect();
    let mut value = json!({
        "id": id,
        "image_id": image,
        "category_id": category,
        "bbox": bbox,
        "area": area,
        "iscrowd": 0,
        "segmentation": polygons,
        "attributes": { "object": object, "visible": visible, "truncated": truncated, "distance_m": distance_m },
    });
    if annotation.class == Class::Robot {
        let mut flat = Vec::with_capacity(3 * KEYPOINTS.len());
        for index in 0..KEYPOINTS.len() {
            let (u, v, visibility) = annotation.keypoints.get(index).copied().unwrap_or_default();
            flat.extend([json!(u), json!(v), json!(visibility)]);
        }
        let seen = annotation.keypoints.iter().filter(|(_, _, visibility)| *visibility > 0).count();
        value["keypoints"] = json!(flat);
        value["num_keypoints"] = json!(seen);
    }
    value
}

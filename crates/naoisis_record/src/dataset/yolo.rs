//! Labels in the layout of Ultralytics: a text file for each image, and `data.yaml`.

use bevy::math::Vec2;
use core::fmt::Write;
use serde::{Deserialize, Serialize};

use super::annotate::Annotation;
use super::names::{ClassNames, KEYPOINTS, MIRRORED};
use super::outline::one_polygon;

/// The kind of labels in the text files.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum YoloTask {
    /// The box of each object.
    #[default]
    Detect,
    /// The outline of each object.
    Segment,
    /// The box of each object, and the key points of robots.
    Pose,
}

impl YoloTask {
    /// All kinds, with their names on the command line.
    pub const ALL: [(&'static str, YoloTask); 3] =
        [("detect", YoloTask::Detect), ("segment", YoloTask::Segment), ("pose", YoloTask::Pose)];
}

/// Returns the text of `data.yaml`. It has no `path`, so that readers take the folder of the file.
pub fn data_file(names: ClassNames, task: YoloTask) -> String {
    let mut text = "train: images/train\nval: images/val\ntest: images/test\n".to_owned();
    if task == YoloTask::Pose {
        let mirrored = MIRRORED.map(|index| index.to_string()).join(", ");
        // Writing to a string cannot fail.
        let _ = writeln!(text, "kpt_shape: [{}, 3]\nflip_idx: [{mirrored}]", KEYPOINTS.len());
    }
    text.push_str("names:\n");
    for (number, (name, _)) in names.list().iter().enumerate() {
        let _ = writeln!(text, "  {number}: {name}");
    }
    text
}

/// Returns the text file of an image of this size (pixels): a line for each object, in shares of the image size.
pub fn label_file(annotations: &[Annotation], [width, height]: [u32; 2], names: ClassNames, task: YoloTask) -> String {
    let size = Vec2::new(width as f32, height as f32);
    let mut text = String::new();
    for annotation in annotations {
        let Some(number) = names.number(annotation.class) else { continue };
        let _ = write!(text, "{number}");
        let mut add = |value: Vec2| {
            let _ = write!(text, " {:.6} {:.6}", value.x, value.y);
        };
        if task == YoloTask::Segment {
            let polygons = annotation.polygons.iter();
            let polygons =
                polygons.map(|polygon| polygon.iter().map(|[u, v]| Vec2::new(*u as f32, *v as f32)).collect());
            one_polygon(&polygons.collect::<Vec<_>>())
                .unwrap_or_default()
                .into_iter()
                .for_each(|point| add(point / size));
        } else {
            let [left, top, across, down] = annotation.bbox.map(|side| side as f32);
            add(Vec2::new(left + across / 2.0, top + down / 2.0) / size);
            add(Vec2::new(across, down) / size);
        }
        if task == YoloTask::Pose {
            for index in 0..KEYPOINTS.len() {
                let (u, v, visibility) = annotation.keypoints.get(index).copied().unwrap_or_default();
                let _ = write!(text, " {:.6} {:.6} {visibility}", u / size.x, v / size.y);
            }
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::names::Class;

    #[test]
    fn lines_are_shares_of_the_image() {
        let ball = Annotation {
            class: Class::Ball,
            object: "ball".to_owned(),
            bbox: [10, 20, 40, 20],
            area: 400,
            visible: 1.0,
            truncated: false,
            distance_m: 1.0,
            polygons: vec![vec![[10, 20], [50, 20], [50, 40], [10, 40]]],
            keypoints: Vec::new(),
        };
        let person = Annotation { class: Class::Person, ..ball.clone() };
        let of = |task| label_file(&[ball.clone(), person.clone()], [100, 100], ClassNames::Torso21, task);
        // TORSO-21 has no class for people.
        assert_eq!(of(YoloTask::Detect), "0 0.300000 0.300000 0.400000 0.200000\n");
        assert_eq!(of(YoloTask::Segment).split(' ').count(), 9);
        assert_eq!(of(YoloTask::Pose).trim().split(' ').count(), 5 + 3 * KEYPOINTS.len());
        assert!(data_file(ClassNames::Hulks, YoloTask::Pose).contains("kpt_shape: [11, 3]\nflip_idx: [0, 2, 1,"));
    }
}

//! The record of an image without its pixels, and its split.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::annotate::Annotation;
use super::looks::{ImageLooks, MatchLooks};
use super::moments::Moment;
use super::shot::Shot;
use naoisis_core::geometry::to_degrees;
use naoisis_sensing::appearance::scene::SceneBall;

/// A split of a data set.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Split {
    /// For training.
    Train,
    /// For choosing between trained models.
    Valid,
    /// For the final result.
    Test,
}

impl Split {
    /// All splits.
    pub const ALL: [Split; 3] = [Split::Train, Split::Valid, Split::Test];

    /// Returns the split of all images of a match: of ten matches, seven are for training, two for validation and one for the test.
    pub fn of_match(index: usize) -> Split {
        match index % 10 {
            1 | 6 => Split::Valid,
            3 => Split::Test,
            _ => Split::Train,
        }
    }

    /// Returns the number of earlier matches in the same split.
    pub fn place_of_match(index: usize) -> usize {
        let split = Split::of_match(index);
        let of_split = |to: usize| (0..to).filter(|index| Split::of_match(*index) == split).count();
        index / 10 * of_split(10) + of_split(index % 10)
    }

    /// Returns the name of the split.
    pub fn name(self) -> &'static str {
        match self {
            Split::Train => "train",
            Split::Valid => "valid",
            Split::Test => "test",
        }
    }

    /// Returns the name of the split in Ultralytics' layout.
    pub fn yolo_name(self) -> &'static str {
        if self == Split::Valid { "val" } else { self.name() }
    }
}

/// An image of a data set, without its pixels.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct ImageRecord {
    /// File name without folder and ending.
    pub stem: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Its labels.
    pub annotations: Vec<Annotation>,
    /// All other metadata of the image.
    pub metadata: Value,
}

/// The match of an image.
#[derive(Clone, Copy, Debug)]
pub struct MatchFacts<'a> {
    /// Its number in the data set.
    pub index: usize,
    /// Its seed.
    pub seed: u64,
    /// The name of the scenario.
    pub scenario: &'a str,
    /// The scenario's level of realism, in words.
    pub realism: &'a str,
}

/// Returns the metadata of an image.
pub fn metadata(facts: MatchFacts<'_>, moment: &Moment, shot: &Shot, looks: &MatchLooks, image: &ImageLooks) -> Value {
    let camera = &shot.view;
    let intrinsics = shot.intrinsics;
    let robots: Vec<Value> = moment
        .scene
        .robots
        .iter()
        .map(|robot| {
            let model = moment.models.iter().find(|(id, _)| *id == robot.id).map(|(_, model)| model);
            json!({
                "id": robot.id,
                "model": model,
                "pose": [robot.pose.position.x, robot.pose.position.y, to_degrees(robot.pose.heading)],
                "posture": robot.posture.name(),
                "lying_on": robot.posture.lying_on(),
                "head_deg": [to_degrees(robot.head.yaw), to_degrees(robot.head.pitch)],
            })
        })
        .collect();
    let head = moment.scene.robot(moment.robot).map(|robot| [to_degrees(robot.head.yaw), to_degrees(robot.head.pitch)]);
    let in_image: Vec<Value> = shot
        .objects
        .iter()
        .zip(&shot.visible)
        .filter_map(|(object, visible)| {
            Some(json!({ "object": object.name, "label": object.label, "visible": (*visible)? }))
        })
        .collect();
    let ball = |ball: &SceneBall| json!({ "position_m": ball.centre(), "radius_m": ball.radius });
    json!({
        "match": facts.index,
        "seed": facts.seed,
        "scenario": facts.scenario,
        "realism": facts.realism,
        "scene": if moment.time.is_some() { "played" } else { "drawn" },
        "cycle": moment.time.map(|(cycle, _)| cycle),
        "time_s": moment.time.map(|(_, time_s)| time_s),
        "robot": moment.robot,
        "head_deg": head,
        "camera": {
            "name": moment.camera,
            "focal_px": intrinsics.focal,
            "centre_px": intrinsics.centre,
            "distortion": intrinsics.distortion,
            "position_m": camera.eye,
            "right": camera.right,
            "down": camera.down,
            "forward": camera.forward,
            "turn_degps": [to_degrees(moment.turn.x), to_degrees(moment.turn.y)],
        },
        "robots": robots,
        "ball": moment.scene.ball.as_ref().map(ball),
        "more_balls": moment.scene.more_balls.iter().map(ball).collect::<Vec<_>>(),
        "in_image": in_image,
        "looks": looks,
        "image_looks": image,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_have_their_shares_and_their_matches_are_numbered_through() {
        let mut next = [0; 3];
        for index in 0..1000 {
            let split = Split::of_match(index);
            assert_eq!(Split::place_of_match(index), next[split as usize], "{index}");
            next[split as usize] += 1;
        }
        assert_eq!(next, [700, 200, 100]);
        // Four matches are enough for all splits.
        assert!(Split::ALL.iter().all(|split| (0..4).any(|index| Split::of_match(index) == *split)));
    }
}

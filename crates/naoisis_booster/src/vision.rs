//! The vision service of the SDK: what the robot sees, on request.

use bevy::prelude::*;
use serde_json::{Value, json};

use crate::firmware::status;
use crate::messages::DetectedObject;

/// The part of the image about its middle that is searched without another wish (the SDK's default).
const FOCUS_RATIO: f64 = 0.33;

/// The vision service of a robot.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Vision {
    is_on: bool,
    /// What the robot sees.
    pub seen: Vec<DetectedObject>,
    /// Width and height of its image, pixels.
    pub size: Vec2,
}

impl Vision {
    /// Answers a request with a code and a body: 3000 starts the service, 3001 stops it, and 3002 tells the objects whose middle is in the
    /// middle part of the image (409 while the service is off).
    pub fn request(&mut self, api: i64, body: &str) -> (i64, String) {
        match api {
            3000 => self.is_on = true,
            3001 => self.is_on = false,
            3002 if self.is_on => {
                let body = serde_json::from_str::<Value>(body).unwrap_or_default();
                let ratio = body.get("focus_ratio").and_then(Value::as_f64).unwrap_or(FOCUS_RATIO) as f32;
                return (status::SUCCESS, self.objects(ratio).to_string());
            }
            3002 => return (status::CONFLICT, String::new()),
            _ => return (status::SERVER_REFUSED, String::new()),
        }
        (status::SUCCESS, String::new())
    }

    fn objects(&self, ratio: f32) -> Value {
        let is_in_focus = |object: &&DetectedObject| {
            let middle = Vec2::new((object.xmin + object.xmax) as f32, (object.ymin + object.ymax) as f32) / 2.0;
            ((middle - self.size / 2.0).abs()).cmple(self.size / 2.0 * ratio).all()
        };
        let told = |object: &DetectedObject| {
            json!({
                "xmin": object.xmin, "ymin": object.ymin, "xmax": object.xmax, "ymax": object.ymax,
                "position": object.position, "tag": object.label, "conf": object.confidence, "rgb_mean": [],
            })
        };
        self.seen.iter().filter(is_in_focus).map(told).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_in_the_middle_of_the_image_are_told_while_the_service_is_on() {
        let seen = |label: &str, x: i64| DetectedObject {
            label: label.to_owned(),
            xmin: x,
            xmax: x,
            ymin: 50,
            ymax: 50,
            ..default()
        };
        let mut vision =
            Vision { seen: vec![seen("Ball", 50), seen("Goalpost", 90)], size: Vec2::splat(100.0), ..default() };
        assert_eq!(vision.request(3002, "{}"), (status::CONFLICT, String::new()));
        assert_eq!(vision.request(3000, "{}").0, status::SUCCESS);
        let mut tags = |body: &str| {
            let objects: Value = serde_json::from_str(&vision.request(3002, body).1).unwrap();
            objects.as_array().unwrap().iter().map(|object| object["tag"].clone()).collect::<Vec<_>>()
        };
        assert_eq!(tags("{}"), ["Ball"]);
        assert_eq!(tags(r#"{"focus_ratio":1.0}"#), ["Ball", "Goalpost"]);
        assert_eq!(vision.request(3001, "").0, status::SUCCESS);
        assert_eq!(vision.request(3002, "").0, status::CONFLICT);
    }
}

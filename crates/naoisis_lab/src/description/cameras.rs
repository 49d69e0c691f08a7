//! The figures of the cameras.

use bevy::math::DVec3;
use serde_json::{Value, json};

use super::body::{Measures, Standing};
use super::figures::{Figures, degrees, place};
use super::tree::{Camera, Fov};
use super::{DescriptionError, ImportOptions};
use naoisis_core::camera_model::CameraMounts;

/// Image size of a camera without one: width and height, pixels.
const USUAL_SIZE: [u32; 2] = [640, 480];
/// Diagonal field of view of a camera without one, degrees.
const USUAL_FOV_DEG: f64 = 90.0;
/// Distance between frames of the same camera at most, m.
const SAME_M: f64 = 1e-3;
/// Roll of a camera from which on it is reported, degrees.
const LEVEL_DEG: f64 = 2.0;

/// A camera of the description, with the index of its link.
type Found<'a> = (usize, &'a Camera);

impl Standing<'_> {
    /// Sets the figures of the cameras: those in the options, or the most likely camera of the head.
    ///
    /// # Errors
    /// If a camera in the options does not exist.
    pub fn cameras(
        &self,
        figures: &mut Figures,
        measures: &Measures,
        options: &ImportOptions,
    ) -> Result<(), DescriptionError> {
        let all = || {
            self.tree
                .links
                .iter()
                .enumerate()
                .flat_map(|(link, of)| of.cameras.iter().map(move |camera| (link, camera)))
        };
        let mut chosen: Vec<Found> = Vec::new();
        for name in &options.cameras {
            let found = all().find(|(_, camera)| camera.name == *name);
            chosen.push(found.ok_or_else(|| DescriptionError::NoCamera {
                name: name.clone(),
                known: all().map(|(_, camera)| camera.name.clone()).collect(),
            })?);
        }
        if chosen.len() > CameraMounts::MOST {
            return Err(DescriptionError::TooManyCameras(chosen.len()));
        }
        if chosen.is_empty() {
            chosen.extend(all().max_by_key(|found| (self.likelihood(*found), core::cmp::Reverse(found.0))));
            let others: Vec<&str> = all()
                .filter(|found| chosen.iter().all(|chosen| chosen.1.name != found.1.name))
                .map(|(_, camera)| camera.name.as_str())
                .collect();
            if !others.is_empty() {
                figures.lacking.push(format!("other cameras that it may have (--camera NAME): {}", others.join(", ")));
            }
        }
        if chosen.is_empty() {
            guess_camera(figures, measures);
            return Ok(());
        }
        let names = names_of(&chosen);
        let mounts: Vec<Value> =
            chosen.iter().zip(&names).map(|(found, name)| self.mount(figures, *found, name)).collect();
        let source = |camera: &Camera| format!("{}, {}", camera.place, camera.name);
        let sources: Vec<String> = chosen.iter().map(|(_, camera)| source(camera)).collect();
        figures.found("cameras.mounts", Value::Array(mounts), sources.join("; "));
        // Another frame of the same camera may have the image's properties.
        let lens = |(link, camera): Found| (self.places[link] * camera.link_from_camera).translation;
        let is_same = |found: &Found| lens(*found).distance(lens(chosen[0])) < SAME_M;
        let camera = all().filter(is_same).find(|(_, camera)| camera.fov.is_some()).unwrap_or(chosen[0]).1;
        let size = camera.size.filter(|size| size.iter().all(|side| (1..=4096).contains(side)));
        let [width, height] = size.unwrap_or(USUAL_SIZE);
        let size_source = match size {
            Some(_) => Ok(source(camera)),
            None => Err("the description has no size of the image".to_owned()),
        };
        figures.either("cameras.width", json!(width), &size_source);
        figures.either("cameras.height", json!(height), &size_source);
        match camera.fov.map(|fov| degrees(diagonal(fov, [width, height]))) {
            Some(fov) => figures.found("cameras.diagonal_fov_deg", fov, source(camera)),
            None => {
                figures
                    .lacking
                    .push("the camera's field of view: --camera-info FILE takes it from a calibration".to_owned());
                figures.guess("cameras.diagonal_fov_deg", json!(USUAL_FOV_DEG), "the description has no field of view");
            }
        }
        Ok(())
    }

    /// Returns a score of how likely a frame is the camera that the robot plays with. Scores are compared in order.
    fn likelihood(&self, (link, camera): Found) -> [bool; 4] {
        let name = camera.name.to_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
        let is_of_head = self.limbs.head.link().is_some_and(|head| self.tree.is_within(link, head));
        [
            is_of_head,
            camera.fov.is_some(),
            !has(&["depth", "infra", "imu", "right", "bottom", "track"]),
            has(&["optical"]),
        ]
    }

    /// Returns the mount of a camera in the form of files: its position and direction while the head is straight.
    fn mount(&self, figures: &mut Figures, (link, camera): Found, name: &str) -> Value {
        let at = self.places[link] * camera.link_from_camera;
        let rotation = at.matrix3;
        let forward = camera.forward(rotation);
        let right = camera.right(rotation);
        let (tilt, pan) = (-libm::asin(forward.z.clamp(-1.0, 1.0)), libm::atan2(forward.y, forward.x));
        // The right side of a level image points along the ground.
        let roll = libm::asin(right.z.clamp(-1.0, 1.0));
        if roll.abs().to_degrees() > LEVEL_DEG {
            figures.lacking.push(format!(
                "{}, {}: its image is turned by {} degrees about its axis, which a model cannot say",
                camera.place,
                camera.name,
                degrees(roll)
            ));
        }
        let mut mount = json!({ "name": name, "position_m": place(at.translation), "tilt_deg": degrees(tilt) });
        if pan.abs().to_degrees() > 0.5 {
            mount["pan_deg"] = degrees(pan);
        }
        mount
    }
}

/// Returns the diagonal field of view, radians.
fn diagonal(fov: Fov, [width, height]: [u32; 2]) -> f64 {
    let [width, height] = [width, height].map(f64::from);
    let focal = match fov {
        Fov::Horizontal(angle) => width / 2.0 / libm::tan(angle / 2.0),
        Fov::Vertical(angle) => height / 2.0 / libm::tan(angle / 2.0),
    };
    2.0 * libm::atan(libm::hypot(width, height) / 2.0 / focal)
}

/// Sets the figures of a camera in the middle of the face, as a guess.
fn guess_camera(figures: &mut Figures, measures: &Measures) {
    let Measures { neck_m, height_m, .. } = measures;
    let lens = DVec3::new(neck_m.x + 0.06, 0.0, neck_m.z + 0.5 * (height_m - neck_m.z));
    figures
        .lacking
        .push("no camera was found by its name: its place, direction and field of view are guesses".to_owned());
    let reason = "a camera in the middle of the face";
    // If the head does not nod, the camera has to see the ball at the feet.
    let tilt_deg = if measures.nods { 12.0 } else { 35.0 };
    let mount = json!({ "name": "head", "position_m": place(lens), "tilt_deg": tilt_deg });
    figures.guess("cameras.mounts", json!([mount]), reason);
    let [width, height] = USUAL_SIZE;
    figures.guess("cameras.width", json!(width), reason);
    figures.guess("cameras.height", json!(height), reason);
    figures.guess("cameras.diagonal_fov_deg", json!(USUAL_FOV_DEG), reason);
}

/// Returns short names for cameras: `head` for a single one, otherwise the parts of their names that differ.
fn names_of(cameras: &[Found]) -> Vec<String> {
    /// Words without information.
    const EMPTY: [&str; 7] = ["camera", "optical", "frame", "link", "joint", "sensor", "head"];

    if cameras.len() == 1 {
        return vec!["head".to_owned()];
    }
    let mut names: Vec<String> = Vec::new();
    for (_, camera) in cameras {
        let mut name = camera.name.to_lowercase();
        EMPTY.iter().for_each(|word| name = name.replace(word, ""));
        let words: Vec<&str> =
            name.split(|letter: char| !letter.is_ascii_alphanumeric()).filter(|word| !word.is_empty()).collect();
        let mut name: String = words.join("_").chars().take(13).collect();
        if name.is_empty() || names.contains(&name) {
            name = format!("camera_{}", names.len() + 1);
        }
        names.push(name);
    }
    names
}

//! Reads calibrations of cameras: ROS' `camera_info`, Kalibr's `camchain`, and OpenCV's files, all in YAML.

use serde::Deserialize;
use serde_json::{Value, json};
use serde_norway::Deserializer;
use std::path::Path;

use super::DescriptionError;
use super::figures::Figures;
use naoisis_core::read_file::read_file;

/// Number of cameras that are read from a Kalibr file at most.
const MOST_CAMERAS: usize = 16;
/// The contents that are expected, for error messages.
const EXPECTED: &str =
    "expected YAML of ROS (camera_info), Kalibr (camchain) or OpenCV, with camera matrix, distortion and image size";
/// The names of the radial and tangential model.
const PLUMB_BOB: [&str; 5] = ["plumb_bob", "radtan", "rational_polynomial", "none", ""];
/// The names of the model of fisheye lenses.
const FISHEYE: [&str; 2] = ["equidistant", "fisheye"];

/// The calibrations in a file.
pub(super) struct Calibrations {
    file: String,
    cameras: Vec<Calibrated>,
}

/// The calibration of one camera.
#[derive(PartialEq, Debug)]
struct Calibrated {
    size: [u32; 2],
    /// fx, fy, cx and cy.
    pinhole: [f64; 4],
    /// k1, k2, p1, p2 and k3, or fewer of them; k1 to k4 of a fisheye lens.
    distortion: Vec<f64>,
    is_fisheye: bool,
}

/// A text with the name of its file.
struct Source<'a> {
    file: String,
    text: &'a str,
}

/// Reads the calibrations of a file.
///
/// # Errors
/// If the file cannot be read, or has no calibration.
pub(super) fn read(path: &Path) -> Result<Calibrations, DescriptionError> {
    let unreadable = |reason: String| DescriptionError::Unreadable { file: path.display().to_string(), reason };
    let bytes = read_file(path).map_err(|problem| unreadable(problem.to_string()))?;
    let text = String::from_utf8(bytes).map_err(|_| unreadable("it is not UTF-8 text".to_owned()))?;
    let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let source = Source { file, text: &text };
    Ok(Calibrations { cameras: source.cameras()?, file: source.file })
}

impl Source<'_> {
    /// Returns an error at the first line that contains `word`.
    fn wrong(&self, word: &str, problem: impl Into<String>) -> DescriptionError {
        let line = self.text.lines().position(|line| !word.is_empty() && line.contains(word)).map(|line| line + 1);
        DescriptionError::Calibration { file: self.file.clone(), line, problem: problem.into() }
    }

    fn cameras(&self) -> Result<Vec<Calibrated>, DescriptionError> {
        // OpenCV's files begin with a line that is not valid YAML today, and have their own tags.
        let text = self.text.trim_start_matches('\u{feff}');
        let is_opencv = text.starts_with("%YAML:");
        let body = if is_opencv { text.split_once('\n').map_or("", |(_, rest)| rest) } else { text };
        let body = body.replace("!!opencv-matrix", "");
        // If there are several documents, such as the messages of a topic, the first one is used.
        let Some(document) = Deserializer::from_str(&body).next() else {
            return Err(self.wrong("", format!("the file is empty; {EXPECTED}")));
        };
        let value = Value::deserialize(document).map_err(|error| DescriptionError::Calibration {
            file: self.file.clone(),
            line: error.location().map(|at| at.line() + usize::from(is_opencv)),
            problem: format!("this is no YAML: {error}"),
        })?;
        let Value::Object(fields) = &value else { return Err(self.wrong("", format!("no calibration; {EXPECTED}"))) };
        let chain: Vec<&Value> = (0..MOST_CAMERAS).map_while(|index| fields.get(&format!("cam{index}"))).collect();
        if chain.is_empty() {
            Ok(vec![self.matrix(&value)?])
        } else {
            chain.into_iter().map(|camera| self.kalibr(camera)).collect()
        }
    }

    /// Reads a camera of Kalibr.
    fn kalibr(&self, camera: &Value) -> Result<Calibrated, DescriptionError> {
        let model = camera.get("camera_model").and_then(Value::as_str).unwrap_or("pinhole");
        if model != "pinhole" {
            return Err(self.wrong(model, format!("the camera model {model} is not known; expected pinhole")));
        }
        let numbers = |name: &str, count: usize| {
            let found = numbers(camera.get(name));
            let fits = found.as_ref().is_some_and(|found| count == 0 || found.len() == count);
            found
                .filter(|_| fits)
                .ok_or_else(|| self.wrong(name, format!("`{name}` is not there, or not {count} numbers")))
        };
        let pinhole = numbers("intrinsics", 4)?;
        let size = numbers("resolution", 2)?;
        let model = camera.get("distortion_model").and_then(Value::as_str).unwrap_or_default();
        let distortion = numbers("distortion_coeffs", 0)?;
        self.calibrated([pinhole[0], pinhole[1], pinhole[2], pinhole[3]], [size[0], size[1]], model, distortion)
    }

    /// Reads a camera with a matrix, from ROS or OpenCV.
    fn matrix(&self, camera: &Value) -> Result<Calibrated, DescriptionError> {
        let needs = |names: &[&str], what: &str| {
            let found = names.iter().find_map(|name| field(camera, name));
            found.ok_or_else(|| self.wrong("", format!("there is no {what}; {EXPECTED}")))
        };
        let matrix = numbers(Some(needs(&["cameramatrix", "k", "intrinsicmatrix", "intrinsics"], "camera matrix")?));
        let Some([fx, skew, cx, _, fy, cy, ..]) = matrix.as_deref() else {
            return Err(self.wrong("atrix", "the camera matrix has no nine numbers"));
        };
        if skew.abs() > 1e-6 {
            return Err(self.wrong("atrix", "the camera matrix has a skew, which is not known"));
        }
        let side = |names: &[&str], what: &str| {
            needs(names, what)?.as_f64().ok_or_else(|| self.wrong(what, format!("the {what} is no number")))
        };
        let size = [side(&["imagewidth", "width"], "image_width")?, side(&["imageheight", "height"], "image_height")?];
        let model = field(camera, "distortionmodel").and_then(Value::as_str).unwrap_or_default();
        let coefficients = needs(&["distortioncoefficients", "distcoeffs", "distortion", "d"], "distortion")?;
        let distortion = numbers(Some(coefficients))
            .ok_or_else(|| self.wrong("istortion", "the distortion is no list of numbers"))?;
        self.calibrated([*fx, *fy, *cx, *cy], size, model, distortion)
    }

    fn calibrated(
        &self,
        pinhole: [f64; 4],
        size: [f64; 2],
        model: &str,
        mut distortion: Vec<f64>,
    ) -> Result<Calibrated, DescriptionError> {
        let is_fisheye = FISHEYE.contains(&model);
        if !is_fisheye && !PLUMB_BOB.contains(&model) {
            let problem = format!(
                "the distortion model {model} is not known; calibrate with plumb_bob (radtan in Kalibr) or equidistant (a fisheye lens)"
            );
            return Err(self.wrong(model, problem));
        }
        let (model, most) = if is_fisheye { ("equidistant, of four", 4) } else { ("plumb_bob, of five", 5) };
        // The rational model and the thin prism model begin with the five coefficients of plumb_bob.
        while distortion.len() > most && distortion.last() == Some(&0.0) {
            distortion.pop();
        }
        if distortion.len() > most {
            let problem = format!("the distortion has {} coefficients; calibrate with {model}", distortion.len());
            return Err(self.wrong("istortion", problem));
        }
        // Missing coefficients of short lists are zero: k1, k2, p1, p2, k3.
        let count = if distortion.len() == 5 { 5 } else { 4 };
        distortion.resize(count, 0.0);
        if pinhole[..2].iter().any(|focal| *focal <= 0.0) {
            return Err(self.wrong("", "the camera is not calibrated: its focal lengths are not positive"));
        }
        if !size.iter().all(|side| (1.0..=4096.0).contains(side)) {
            return Err(
                self.wrong("idth", format!("an image of {} x {}; expected 1 to 4096 pixels a side", size[0], size[1]))
            );
        }
        Ok(Calibrated { size: size.map(|side| side as u32), pinhole, distortion, is_fisheye })
    }
}

/// Returns the field of an object with this name, ignoring case and underscores.
fn field<'a>(object: &'a Value, name: &str) -> Option<&'a Value> {
    let plain = |word: &str| word.chars().filter(|letter| *letter != '_').collect::<String>().to_lowercase();
    object.as_object()?.iter().find(|(own, _)| plain(own) == name).map(|(_, value)| value)
}

/// Returns the numbers of a list, of a matrix' `data`, or of a list of rows.
fn numbers(value: Option<&Value>) -> Option<Vec<f64>> {
    match value? {
        Value::Object(matrix) => numbers(matrix.get("data")),
        Value::Array(values) if values.iter().all(Value::is_array) && !values.is_empty() => {
            let rows: Option<Vec<Vec<f64>>> = values.iter().map(|row| numbers(Some(row))).collect();
            rows.map(|rows| rows.concat())
        }
        Value::Array(values) => values.iter().map(Value::as_f64).collect(),
        _ => None,
    }
}

impl Calibrations {
    /// Sets the figures of cameras from their calibrations. A single calibration applies to all cameras; several apply in the order of the
    /// cameras.
    ///
    /// # Errors
    /// If there are several calibrations, but not as many as cameras.
    pub fn set(&self, figures: &mut Figures) -> Result<(), DescriptionError> {
        let count = figures.get("cameras.mounts").and_then(Value::as_array).map_or(0, Vec::len);
        let intrinsics = |camera: &Calibrated| {
            let [fx, fy, cx, cy] = camera.pinhole;
            let coefficients = &camera.distortion;
            let distortion = if camera.is_fisheye { json!({ "fisheye": coefficients }) } else { json!(coefficients) };
            json!({ "fx": fx, "fy": fy, "cx": cx, "cy": cy, "distortion": distortion, "size": camera.size })
        };
        let [first, others @ ..] = self.cameras.as_slice() else { return Ok(()) };
        figures.remove("cameras.diagonal_fov_deg");
        figures.lacking.retain(|words| !words.contains("field of view: --camera-info"));
        figures.found("cameras.width", json!(first.size[0]), &self.file);
        figures.found("cameras.height", json!(first.size[1]), &self.file);
        figures.found("cameras.intrinsics", intrinsics(first), &self.file);
        if others.is_empty() {
            return Ok(());
        }
        if self.cameras.len() != count {
            let problem = format!(
                "calibrations of {} cameras for a robot with {count}; --camera NAME names each",
                self.cameras.len()
            );
            return Err(DescriptionError::Calibration { file: self.file.clone(), line: None, problem });
        }
        let Some(Value::Array(mounts)) = figures.get("cameras.mounts") else { return Ok(()) };
        let mut mounts = mounts.clone();
        for (mount, camera) in mounts.iter_mut().zip(&self.cameras) {
            mount["size"] = json!(camera.size);
            mount["intrinsics"] = intrinsics(camera);
        }
        let source = figures.sources.get("cameras.mounts").cloned().unwrap_or_default();
        figures.found("cameras.mounts", Value::Array(mounts), format!("{source}; {}", self.file));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cameras(text: &str) -> Result<Vec<Calibrated>, String> {
        Source { file: "c.yaml".to_owned(), text }.cameras().map_err(|error| error.to_string())
    }

    fn expected(distortion: &[f64]) -> Calibrated {
        let pinhole = [605.0, 611.0, 331.5, 247.5];
        Calibrated { size: [640, 480], pinhole, distortion: distortion.to_vec(), is_fisheye: false }
    }

    const ROS: &str = "image_width: 640
image_height: 480
camera_name: head
camera_matrix:
  rows: 3
  cols: 3
  data: [605, 0, 331.5, 0, 611.0, 247.5, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 0.001, 0.002, 0.05]
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
";

    #[test]
    fn tools_write_the_same_camera_in_their_ways() {
        let all = [0.1, -0.2, 0.001, 0.002, 0.05];
        assert_eq!(cameras(ROS).unwrap(), [expected(&all)]);
        let topic = "header: {frame_id: cam}\nheight: 480\nwidth: 640\ndistortion_model: rational_polynomial\nd:\n- 0.1\n- -0.2\n- 0.001\n- 0.002\n- 0.05\n- 0.0\n- 0.0\n- 0.0\n\
            k: [605.0, 0.0, 331.5, 0.0, 611.0, 247.5, 0.0, 0.0, 1.0]\n---\nheight: 9\n";
        assert_eq!(cameras(topic).unwrap(), [expected(&all)]);
        let opencv = "%YAML:1.0\n---\ncalibration_time: \"today\"\nimage_Width: 640\nimage_Height: 480\nCamera_Matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   \
            data: [ 6.05e+02, 0., 3.315e+02, 0.,\n       6.11e+02, 2.475e+02, 0., 0., 1. ]\nDistortion_Coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n   \
            data: [ 1.0e-01, -2.0e-01, 1.0e-03, 2.0e-03, 5.0e-02 ]\n";
        assert_eq!(cameras(opencv).unwrap(), [expected(&all)]);
        let kalibr = "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0.1, -0.2, 0.001, 0.002]\n  distortion_model: radtan\n  intrinsics: [605.0, 611.0, 331.5, 247.5]\n  \
            resolution: [640, 480]\n  rostopic: /cam0\ncam1:\n  camera_model: pinhole\n  distortion_coeffs: []\n  distortion_model: none\n  intrinsics: [605.0, 611.0, 331.5, 247.5]\n  resolution: [640, 480]\n";
        assert_eq!(cameras(kalibr).unwrap(), [expected(&all[..4]), expected(&[0.0; 4])]);
        let fisheye = kalibr.replace("radtan", "equidistant");
        assert_eq!(cameras(&fisheye).unwrap()[0], Calibrated { is_fisheye: true, ..expected(&all[..4]) });
    }

    #[test]
    fn what_cannot_be_used_is_said_with_its_line() {
        let error = |from: &str, to: &str| cameras(&ROS.replace(from, to)).unwrap_err();
        let model = error("plumb_bob", "double_sphere");
        assert!(
            model.starts_with("c.yaml:8: the distortion model double_sphere is not known; calibrate with plumb_bob"),
            "{model}"
        );
        let fisheye = error("plumb_bob", "equidistant");
        assert!(fisheye.ends_with("has 5 coefficients; calibrate with equidistant, of four"), "{fisheye}");
        assert!(error("0.05]", "0.05, 0.1, 0.0, 0.2]").contains("has 8 coefficients"));
        assert!(error("data: [605, 0,", "data: [605, 3.0,").starts_with("c.yaml:4: the camera matrix has a skew"));
        assert!(error("[605,", "[0.0,").contains("is not calibrated"));
        assert!(error("camera_matrix", "matrix").contains("there is no camera matrix; expected YAML of ROS"));
        assert!(error("640", "\"wide\"").contains("image_width is no number"));
        let syntax = cameras("%YAML:1.0\n---\na: [1\nb: }\n").unwrap_err();
        assert!(syntax.starts_with("c.yaml:4: this is no YAML"), "{syntax}");
        assert!(cameras("- 1\n").is_err() && cameras("").is_err());
    }
}

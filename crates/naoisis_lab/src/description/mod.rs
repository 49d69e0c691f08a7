//! Makes models of robots from their descriptions: URDF and MJCF.
//!
//! A description has links, joints with limits, shapes, and sometimes cameras. [`import`] finds head, legs and arms among them and makes a
//! [model](naoisis_sim::scenario::RobotModel): the boxes of the body, hips, knees and feet, the neck with its limits, and the cameras. Each
//! figure has its place in the file as its source. Figures that descriptions do not have (walking, kicks, noise) are guessed and marked as
//! guesses.
//! have (walking, kicks, noise) is guessed, and marked as a guess.

use std::path::{Path, PathBuf};

mod body;
mod calibration_file;
mod cameras;
mod figures;
mod limbs;
mod meshes;
mod mjcf;
mod model;
mod tree;
mod urdf;
mod xml;

#[cfg(test)]
mod tests;

use body::Standing;
use figures::Figures;
use limbs::{Limbs, standing};
use xml::Element;

/// Choices for the import where the description is ambiguous.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct ImportOptions {
    /// The name of the model. `None` for that of the description.
    pub name: Option<String>,
    /// The yaw joint of the head. `None` for the joint with such a name.
    pub head_yaw: Option<String>,
    /// The pitch joint of the head. `None` for the joint with such a name.
    pub head_pitch: Option<String>,
    /// The frames of the cameras. If empty, the frame with such a name.
    pub cameras: Vec<String>,
    /// A calibration file of the cameras: ROS' `camera_info`, Kalibr's `camchain`, or OpenCV's, in YAML.
    pub camera_info: Option<PathBuf>,
    /// The joint angles of the standing robot, radians; those of other joints are 0. If empty, the knees are slightly bent.
    pub stand: Vec<(String, f64)>,
}

/// A model made from a description.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub struct Imported {
    /// Name of the model.
    pub name: String,
    /// The text of the model's file, in RON.
    pub text: String,
    /// The figures from the description or a calibration.
    pub found: Vec<ImportedFigure>,
    /// The figures that are guesses, with their reasons.
    pub guessed: Vec<ImportedFigure>,
    /// What is missing from the description or could not be read, in words.
    pub lacking: Vec<String>,
    /// What has to be measured on the real robot, in words.
    pub to_measure: Vec<&'static str>,
}

/// A figure of an imported model.
#[derive(Clone, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub struct ImportedFigure {
    /// Path in the model, such as `body.neck_m`.
    pub path: String,
    /// Value, in the form of a file.
    pub value: String,
    /// The source, such as `robot.urdf:120, joint head_pitch`, or the reason of a guess.
    pub source: String,
}

/// Why a description cannot be imported.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DescriptionError {
    /// A file cannot be read.
    #[error("{file} cannot be read: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// The operating system's error.
        reason: String,
    },
    /// The contents of a file are wrong.
    #[error("{file}:{line}:{column}: {problem}")]
    Wrong {
        /// The name of the file.
        file: String,
        /// The line, from 1.
        line: u32,
        /// The column, from 1.
        column: u32,
        /// What is wrong.
        problem: String,
    },
    /// A mesh cannot be read.
    #[error("{0}")]
    Mesh(String),
    /// A file is no usable calibration of a camera.
    #[error("{file}{}: {problem}", .line.map(|line| format!(":{line}")).unwrap_or_default())]
    Calibration {
        /// The name of the file.
        file: String,
        /// The line, from 1, if it is known.
        line: Option<usize>,
        /// What is wrong.
        problem: String,
    },
    /// There is no joint with this name.
    #[error("there is no joint `{name}`; there are {}", .known.join(", "))]
    NoJoint {
        /// The name.
        name: String,
        /// All joints.
        known: Vec<String>,
    },
    /// A joint of the standing robot is beyond its limits.
    #[error("`{name}` cannot stand at {angle} rad; its limits are {limits} rad")]
    BeyondLimits {
        /// The name of the joint.
        name: String,
        /// The angle, radians.
        angle: String,
        /// The limits, radians.
        limits: String,
    },
    /// There is no camera with this name.
    #[error(
        "there is no camera `{name}`; {}",
        if .known.is_empty() { "no link or camera of the description is called one".to_owned() } else { format!("there are {}", .known.join(", ")) }
    )]
    NoCamera {
        /// The name.
        name: String,
        /// All frames that may be cameras.
        known: Vec<String>,
    },
    /// There are more cameras than a robot may have.
    #[error("{0} cameras; a robot has at most {most}", most = naoisis_core::camera_model::CameraMounts::MOST)]
    TooManyCameras(usize),
    /// The description does not determine the size of the robot.
    #[error("{0}: nothing says how large the robot is: it has no legs, and no shapes that can be read")]
    NoSize(String),
}

naoisis_core::debug_as_displayed!(DescriptionError);

/// Makes a model from the URDF or MJCF description at `path`.
///
/// # Errors
/// If a file is missing or wrong, has another format, or lacks a joint or camera of the options.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Imported, DescriptionError> {
    let root = Element::read(path)?;
    let tree = match root.name.as_str() {
        "robot" => urdf::read(&root, path)?,
        "mujoco" => mjcf::read(root, path)?,
        other => {
            let kind = match other {
                "sdf" => "an SDF file",
                "COLLADA" => "a mesh (COLLADA)",
                "launch" => "a launch file",
                "mujocoinclude" => "a part of an MJCF model, which another file includes",
                _ => return Err(root.place.wrong(format!("<{other}> is no description of a robot; {EXPECTED}"))),
            };
            return Err(root.place.wrong(format!("this is {kind}; {EXPECTED}")));
        }
    };
    let limbs = Limbs::of(&tree, options)?;
    let posture = standing(&tree, &limbs, options)?;
    let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let standing = Standing::new(&tree, &limbs, &posture, &file);
    let standing = standing.ok_or_else(|| DescriptionError::NoSize(file.clone()))?;
    let mut figures = Figures::default();
    figures.lacking = shortened(&tree.warnings);
    let measures = standing.body(&mut figures);
    standing.head(&mut figures);
    standing.cameras(&mut figures, &measures, options)?;
    if let Some(path) = &options.camera_info {
        calibration_file::read(path)?.set(&mut figures)?;
    }
    if limbs.legs.is_none() {
        figures.lacking.push("no pair of legs with knees was found: the robot is drawn on wheels".to_owned());
    }
    let realistic = model::add_guesses(&mut figures, &measures);
    let name = options.name.clone().unwrap_or_else(|| name_of(&tree.name, path));
    let text = model::text(&name, &file, &figures, &realistic);
    let (found, guessed) = figures.with_reasons();
    Ok(Imported { name, text, found, guessed, lacking: figures.lacking, to_measure: model::TO_MEASURE.to_vec() })
}

/// Returns the warnings, with only the first ones about meshes.
fn shortened(warnings: &[String]) -> Vec<String> {
    /// Number of meshes that are named at most.
    const MOST_MESHES: usize = 3;

    let (meshes, mut others): (Vec<&String>, Vec<&String>) =
        warnings.iter().partition(|words| words.contains("the mesh "));
    let more = meshes.len().saturating_sub(MOST_MESHES);
    others.extend(meshes.into_iter().take(MOST_MESHES));
    let more = (more > 0).then(|| format!("{more} more meshes that cannot be read"));
    others.into_iter().cloned().chain(more).collect()
}

/// The formats that can be read, for error messages.
const EXPECTED: &str = "expected URDF (<robot>) or MJCF (<mujoco>)";

/// Returns a name for a model, from the description's name or its file name: lower-case letters, digits and underscores.
fn name_of(robot: &str, path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let word = |name: &str| {
        let letters = name
            .trim()
            .chars()
            .map(|letter| if letter.is_ascii_alphanumeric() { letter.to_ascii_lowercase() } else { '_' });
        letters.take(40).collect::<String>()
    };
    let names = [word(robot), word(&stem)];
    let has_letters = |name: &&String| name.chars().any(|letter| letter != '_');
    names.iter().find(has_letters).cloned().unwrap_or_else(|| "robot".to_owned())
}

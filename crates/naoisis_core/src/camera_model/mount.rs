//! The cameras of a robot: their names and mounting in its head.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tinyvec::ArrayVec;

use super::{CameraCalibration, Distortion};
use crate::geometry::{file_units, unit};
use crate::short_name::short_name;

short_name! {
    /// The name of one of a robot's cameras.
    CameraName, NotACameraName, 15, "a camera", "The name of a camera of the robot's model.", "^[a-z0-9_]{1,15}$"
}

impl CameraName {
    /// The upper camera of a NAO, which looks ahead.
    pub const TOP: CameraName = CameraName { letters: *b"top\0\0\0\0\0\0\0\0\0\0\0\0" };

    /// The lower camera of a NAO, which looks 40° further down.
    pub const BOTTOM: CameraName = CameraName { letters: *b"bottom\0\0\0\0\0\0\0\0\0" };
}

/// A camera in a robot's head.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(from = "MountFields", into = "MountFields")]
pub struct CameraMount {
    /// Its name.
    pub name: CameraName,
    /// Its lens with the head straight, m, robot frame.
    pub lens_m: Vec3,
    /// Width and height of its image, pixels; by default those of the robot's cameras in common.
    pub size: Option<[u32; 2]>,
    /// Its field of view along the diagonal, radians; by default the common one.
    pub diagonal_fov: Option<f32>,
    /// The distortion of its lens. `None`: as for the robot's other cameras.
    pub distortion: Option<Distortion>,
    /// Its calibration, which overrides fields of view; by default the common one, unless the camera has a field of view of its own.
    pub calibration: Option<CameraCalibration>,
    /// Cycles from one image to the next. `None`: as for the robot's other cameras.
    pub every_cycles: Option<u32>,
    /// Tilt below the head's x axis, radians.
    tilt: f32,
    /// Cosine and sine of the tilt.
    tilt_unit: Vec2,
    /// Pan to the left of the head's x axis, radians.
    pan: f32,
}

impl CameraMount {
    /// The upper camera of a NAO.
    const NAO_TOP: CameraMount = CameraMount {
        name: CameraName::TOP,
        lens_m: Vec3::new(0.0539, 0.0, 0.5372),
        size: None,
        diagonal_fov: None,
        distortion: None,
        calibration: None,
        every_cycles: None,
        tilt: 0.0,
        tilt_unit: Vec2::X,
        pan: 0.0,
    };

    /// The lower camera of a NAO.
    const NAO_BOTTOM: CameraMount = CameraMount {
        name: CameraName::BOTTOM,
        lens_m: Vec3::new(0.0488, 0.0, 0.4709),
        tilt: super::BOTTOM_TILT,
        tilt_unit: super::BOTTOM_TILT_UNIT,
        ..CameraMount::NAO_TOP
    };

    /// A camera with its lens at `lens_m`, m, robot frame, tilted by `tilt` below the head's x axis, radians.
    pub fn new(name: CameraName, lens_m: Vec3, tilt: f32) -> Self {
        let tilt_unit = unit(tilt);
        Self { name, lens_m, tilt, tilt_unit, ..Self::NAO_TOP }
    }

    /// This camera, panned by `pan` to the left of the head's x axis, radians, before the tilt.
    #[must_use]
    pub fn panned(self, pan: f32) -> Self {
        Self { pan, ..self }
    }

    /// The pan to the left of the head's x axis, radians.
    pub fn pan(&self) -> f32 {
        self.pan
    }

    /// The tilt below the head's x axis, radians.
    pub fn tilt(&self) -> f32 {
        self.tilt
    }

    /// Whether size, field of view, distortion and calibration are those that the robot's cameras have in common.
    pub fn is_as_others(&self) -> bool {
        self.size.is_none() && self.diagonal_fov.is_none() && self.distortion.is_none() && self.calibration.is_none()
    }

    pub(super) fn tilt_unit(&self) -> Vec2 {
        self.tilt_unit
    }
}

impl Default for CameraMount {
    fn default() -> Self {
        Self::NAO_TOP
    }
}

/// A camera as written in files.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MountFields {
    name: CameraName,
    #[schemars(with = "[f32; 3]")]
    position_m: Vec3,
    #[serde(default, with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = -90.0, max = 90.0))]
    tilt_deg: f32,
    #[serde(default, with = "file_units::degrees", skip_serializing_if = "is_zero")]
    #[schemars(with = "f32", range(min = -180.0, max = 180.0))]
    pan_deg: f32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(range(min = 1, max = 4096)), extend("unit" = "pixels"))]
    size: Option<[u32; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none", with = "file_units::optional_degrees")]
    #[schemars(with = "Option<f32>", range(min = 1.0, max = 170.0))]
    diagonal_fov_deg: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    distortion: Option<Distortion>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    intrinsics: Option<CameraCalibration>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 100_000))]
    every_cycles: Option<u32>,
}

/// Whether `pan` is zero, in which case it is not written.
fn is_zero(pan: &f32) -> bool {
    *pan == 0.0
}

impl From<MountFields> for CameraMount {
    fn from(fields: MountFields) -> Self {
        let MountFields { name, position_m, tilt_deg, pan_deg, size, .. } = fields;
        let MountFields { diagonal_fov_deg, distortion, intrinsics, every_cycles, .. } = fields;
        let mount = Self::new(name, position_m, tilt_deg).panned(pan_deg);
        Self { size, diagonal_fov: diagonal_fov_deg, distortion, calibration: intrinsics, every_cycles, ..mount }
    }
}

impl From<CameraMount> for MountFields {
    fn from(mount: CameraMount) -> Self {
        let CameraMount { name, lens_m, size, diagonal_fov, distortion, calibration, every_cycles, tilt, pan, .. } =
            mount;
        Self {
            name,
            position_m: lens_m,
            tilt_deg: tilt,
            pan_deg: pan,
            size,
            diagonal_fov_deg: diagonal_fov,
            distortion,
            intrinsics: calibration,
            every_cycles,
        }
    }
}

/// The cameras of a robot, at most [`CameraMounts::MOST`], in the order of its model.
#[derive(Clone, Copy, PartialEq, Debug, Deref, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(try_from = "Vec<CameraMount>", into = "Vec<CameraMount>")]
pub struct CameraMounts(ArrayVec<[CameraMount; CameraMounts::MOST]>);

impl TryFrom<Vec<CameraMount>> for CameraMounts {
    type Error = String;

    fn try_from(cameras: Vec<CameraMount>) -> Result<Self, String> {
        let too_many = || format!("{} cameras; expected at most {}", cameras.len(), Self::MOST);
        Self::new(&cameras).ok_or_else(too_many)
    }
}

impl From<CameraMounts> for Vec<CameraMount> {
    fn from(mounts: CameraMounts) -> Self {
        mounts.0.to_vec()
    }
}

impl CameraMounts {
    /// The most cameras that a robot may have.
    pub const MOST: usize = 4;

    /// These cameras; `None` if there are more than [`MOST`](Self::MOST).
    pub fn new(cameras: &[CameraMount]) -> Option<Self> {
        ArrayVec::try_from(cameras).ok().map(Self)
    }

    /// The camera with this name.
    pub fn get(&self, name: CameraName) -> Option<&CameraMount> {
        self.iter().find(|mount| mount.name == name)
    }

    /// The index of the camera with this name, or the number of cameras if there is none.
    pub fn order(&self, name: CameraName) -> usize {
        self.iter().position(|mount| mount.name == name).unwrap_or(self.len())
    }

    /// The names of the cameras.
    pub fn names(&self) -> impl Iterator<Item = CameraName> + '_ {
        self.iter().map(|mount| mount.name)
    }
}

impl Default for CameraMounts {
    /// The two cameras of a NAO.
    fn default() -> Self {
        Self([CameraMount::NAO_TOP, CameraMount::NAO_BOTTOM].into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_words() {
        for name in ["top", "bottom", "c", "fisheye_front_0"] {
            let parsed: CameraName = name.parse().unwrap();
            assert_eq!((parsed.as_str(), parsed.to_string().as_str()), (name, name));
        }
        assert_eq!(["top".parse(), "bottom".parse()], [Ok(CameraName::TOP), Ok(CameraName::BOTTOM)]);
        for wrong in ["", "Top", "sixteen_letters_", "a b", "ü"] {
            assert!(wrong.parse::<CameraName>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn files_have_them_as_a_list() {
        let text =
            r#"[{ "name": "head", "position_m": [0.05, 0.0, 0.9], "tilt_deg": 12.0, "diagonal_fov_deg": 101.0 }]"#;
        let mounts: CameraMounts = serde_json::from_str(text).unwrap();
        let again: CameraMounts = serde_json::from_str(&serde_json::to_string(&mounts).unwrap()).unwrap();
        assert_eq!((mounts.as_slice().len(), again), (1, mounts));
        assert_eq!(mounts.order("head".parse().unwrap()), 0);
        assert!(mounts.get(CameraName::TOP).is_none());
        let five = vec![mounts.as_slice()[0]; 5];
        assert!(serde_json::from_str::<CameraMounts>(&serde_json::to_string(&five).unwrap()).is_err());
        assert!(serde_json::from_str::<CameraMounts>("[]").unwrap().as_slice().is_empty());
    }
}

//! The pictures of a match that can be recorded: `field`, or a robot's camera such as `blue1.top`.

use bevy::prelude::*;
use core::fmt;
use core::str::FromStr;

use super::match_renderer::MatchRenderer;
use naoisis_core::camera_model::CameraName;
use naoisis_core::team::RobotId;
use naoisis_sensing::sensing::camera::image::Image;

/// Size of a picture of the field, pixels.
pub const FIELD_SIZE: [u32; 2] = [960, 540];
/// The samples of a pixel of the field in single pictures, across and down.
pub const FIELD_SAMPLES: u32 = 3;

/// A picture of a match.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Picture {
    /// The whole field, from above a touchline.
    Field,
    /// What a robot's camera sees.
    Camera(RobotId, CameraName),
}

impl Picture {
    /// Takes the picture of the match, which the renderer has just observed. A pixel of the field has `samples` across and down. Returns
    /// `None` for a robot that is not on the pitch.
    pub fn take(self, renderer: &mut MatchRenderer, world: &mut World, samples: u32) -> Option<Image> {
        match self {
            Picture::Field => Some(renderer.draw_field(world, FIELD_SIZE, samples)),
            Picture::Camera(robot, side) => renderer.through_the_eyes_of(world, robot, side),
        }
    }
}

impl fmt::Display for Picture {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Picture::Field => formatter.write_str("field"),
            Picture::Camera(robot, camera) => write!(formatter, "{robot}.{camera}"),
        }
    }
}

/// The error for a word that names no picture.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no picture `{0}`: expected `field`, or a robot's camera such as `blue1.top` or `pink2.bottom`")]
pub struct NoPicture(String);

naoisis_core::debug_as_displayed!(NoPicture);

impl FromStr for Picture {
    type Err = NoPicture;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        if word == "field" {
            return Ok(Picture::Field);
        }
        let unknown = || NoPicture(word.to_owned());
        let (who, side) = word.split_once('.').ok_or_else(unknown)?;
        let camera = side.parse().map_err(|_| unknown())?;
        Ok(Picture::Camera(who.parse().map_err(|_| unknown())?, camera))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_named_as_they_are_asked_for() {
        for word in ["field", "blue1.top", "pink12.bottom"] {
            assert_eq!(word.parse::<Picture>().unwrap().to_string(), word);
        }
        for word in ["", "fields", "blue.top", "blue0.top", "blue1", "blue1.", "blue1.LEFT", "green1.top", "blü1.top"]
        {
            assert!(word.parse::<Picture>().is_err(), "{word}");
        }
    }
}

//! Writes the sheet of a robot model to a file.

use std::path::Path;

use naoisis_lab::figures::model_sheet;
use naoisis_record::record::encoder::{Layer, write_png};
use naoisis_sim::scenario::RobotModel;

/// Draws the sheet of a model into a file.
///
/// # Errors
/// When the sheet cannot be drawn or written.
pub(super) fn draw_sheet(model: &RobotModel, path: &Path) -> Result<(), String> {
    let image = model_sheet::draw(model, 1.0).map_err(|error| error.to_string())?;
    write_png(path, Layer::Colours, &image).map_err(|error| format!("{}: {error}", path.display()))
}

/// Returns the file name of the sheet of a model. Characters that would lead to other folders are replaced.
pub(super) fn sheet_name(model: &str) -> String {
    let allowed = |character: char| character.is_alphanumeric() || "-_+ ".contains(character);
    let name: String = model.chars().map(|character| if allowed(character) { character } else { '_' }).collect();
    format!("{}.png", if name.trim().is_empty() { "robot" } else { &name })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_lies_in_its_folder_whatever_the_model_is_called() {
        let names = ["booster_k1", "../../evil", "/etc/x", ""].map(sheet_name);
        assert_eq!(names, ["booster_k1.png", "______evil.png", "_etc_x.png", "robot.png"]);
    }
}

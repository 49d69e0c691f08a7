//! The lines about objects that a robot did not recognise, below its images.

use bevy_egui::egui;

use crate::viewer::theme::{dim, text_size};
use naoisis_core::pitch::End;
use naoisis_sensing::sensing::vision::{Cover, MissedObject, SceneObject, WhyMissed};

/// The lines about objects that a robot did not recognise.
#[derive(PartialEq, Debug)]
struct Lines {
    /// One for each object in the images: the ball, robots, goal posts.
    in_images: Vec<String>,
    /// The names of the objects outside the images.
    outside: Option<String>,
}

/// Shows what a robot, whose team defends `own_end`, did not recognise, or why this is not known. While the match is played, the lines have
/// the same height in every cycle, so that nothing below them jumps.
pub fn show(ui: &mut egui::Ui, missed: &Result<Vec<MissedObject>, String>, own_end: End, is_paused: bool) {
    let label = |ui: &mut egui::Ui, text: egui::RichText, wraps: bool| {
        let label = egui::Label::new(text.size(text_size::SMALL));
        ui.add(if wraps { label.wrap() } else { label.truncate() });
    };
    let Lines { in_images, outside } = match missed {
        Ok(missed) => lines(missed, own_end),
        Err(why) if is_paused => return label(ui, dim(format!("What it did not recognise: {why}")), true),
        Err(_) => {
            label(ui, dim("Pause to see what it did not recognise."), false);
            return label(ui, dim(" "), false);
        }
    };
    if is_paused {
        in_images.into_iter().for_each(|line| label(ui, line.into(), true));
    } else {
        let words = if in_images.is_empty() { " ".to_owned() } else { in_images.join("; ") };
        label(ui, words.into(), false);
    }
    match outside {
        Some(outside) => label(ui, dim(outside), false),
        None if is_paused => {}
        None => label(ui, dim(" "), false),
    }
}

fn lines(missed: &[MissedObject], own_end: End) -> Lines {
    let mut missed = missed.to_vec();
    missed.sort_by_key(|missed| match missed.object {
        SceneObject::Ball(_) => 0,
        SceneObject::Robot(_) => 1,
        SceneObject::GoalPost { .. } => 2,
    });
    let (outside, in_images): (Vec<_>, Vec<_>) =
        missed.into_iter().partition(|missed| missed.why == WhyMissed::OutsideImage);
    let names: Vec<String> = outside.iter().map(|missed| name(missed.object, own_end)).collect();
    Lines {
        in_images: in_images
            .iter()
            .map(|missed| format!("{}: {}", name(missed.object, own_end), why(missed.why)))
            .collect(),
        outside: (!names.is_empty()).then(|| format!("outside the image: {}", names.join(", "))),
    }
}

/// The name of an object for a robot whose team defends `own_end`.
fn name(object: SceneObject, own_end: End) -> String {
    match object {
        SceneObject::Ball(0) => "ball".to_owned(),
        SceneObject::Ball(index) => format!("ball {}", index + 1),
        SceneObject::Robot(id) => id.to_string(),
        SceneObject::GoalPost { position_m, .. } => {
            let is_own = position_m.x * own_end.sign() > 0.0;
            // As seen from the pitch.
            let is_left = position_m.x * position_m.y > 0.0;
            let [whose, side] = [if is_own { "own" } else { "other" }, if is_left { "left" } else { "right" }];
            format!("{side} post of the {whose} goal")
        }
    }
}

fn why(why: WhyMissed) -> String {
    match why {
        WhyMissed::OutsideImage => "outside the image".to_owned(),
        WhyMissed::PartlyOutside => "mostly outside the image".to_owned(),
        WhyMissed::TooFar { distance_m, limit_m } => {
            format!("too far ({distance_m:.2} m; recognised up to {limit_m:.1} m)")
        }
        WhyMissed::Covered { by, share } => {
            let by = match by {
                Cover::Robot(id) => id.to_string(),
                Cover::Post => "a post".to_owned(),
            };
            format!("covered by {by} ({:.0} %)", 100.0 * share)
        }
        WhyMissed::Chance { probability } if probability <= 0.0 => "this vision never recognises it".to_owned(),
        WhyMissed::Chance { probability } if probability < 0.01 => {
            "hardly ever recognised like this (in less than 1 % of such images)".to_owned()
        }
        WhyMissed::Chance { probability } if probability < 0.2 => {
            format!("hardly ever recognised like this (in {:.0} % of such images)", 100.0 * probability)
        }
        WhyMissed::Chance { probability } => {
            format!("not recognised by chance (recognised in {:.0} % of such images)", 100.0 * probability)
        }
        WhyMissed::NoPosition => "recognised, but its pixel gives no position on the pitch".to_owned(),
        WhyMissed::InImage => "in the image, not detected".to_owned(),
        _ => "not recognised".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::prelude::*;
    use naoisis_core::pitch::GoalColour;
    use naoisis_core::team::{RobotId, Team};

    #[test]
    fn objects_in_the_images_come_first_and_the_others_share_a_line() {
        let pink2 = SceneObject::Robot(RobotId::new(Team::Pink, 2));
        let blue3 = Cover::Robot(RobotId::new(Team::Blue, 3));
        let post = |x: f32, y: f32| SceneObject::GoalPost { position_m: Vec2::new(x, y), colour: GoalColour::White };
        let missed = [
            (post(4.5, 0.8), WhyMissed::TooFar { distance_m: 8.04, limit_m: 8.0 }),
            (post(-4.5, 0.8), WhyMissed::OutsideImage),
            (pink2, WhyMissed::Covered { by: blue3, share: 0.8 }),
            (SceneObject::Ball(0), WhyMissed::Chance { probability: 0.854 }),
            (SceneObject::Ball(1), WhyMissed::OutsideImage),
        ];
        let missed = missed.map(|(object, why)| MissedObject { object, why });
        let expected = Lines {
            in_images: vec![
                "ball: not recognised by chance (recognised in 85 % of such images)".to_owned(),
                "pink2: covered by blue3 (80 %)".to_owned(),
                "left post of the other goal: too far (8.04 m; recognised up to 8.0 m)".to_owned(),
            ],
            outside: Some("outside the image: ball 2, right post of the own goal".to_owned()),
        };
        assert_eq!(lines(&missed, End::NegativeX), expected);
        assert_eq!(lines(&[], End::NegativeX), Lines { in_images: Vec::new(), outside: None });
    }

    #[test]
    fn a_vision_that_never_recognises_an_object_does_not_do_so_by_chance() {
        assert_eq!(why(WhyMissed::Chance { probability: 0.0 }), "this vision never recognises it");
        assert!(why(WhyMissed::Chance { probability: 0.004 }).contains("less than 1 %"));
    }
}

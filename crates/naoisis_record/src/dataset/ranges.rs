//! The ranges from which the looks of images are drawn: files in `assets/looks`, and users' own files.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

use naoisis_core::random::RandomStream;
use naoisis_sim::scenario::{ScenarioError, read_looks};

/// A range from a least to a greatest value, with a uniform distribution.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Range([f32; 2]);

impl Range {
    /// Draws a value from the range.
    pub fn draw(self, stream: &mut RandomStream) -> f32 {
        let [least, most] = self.0;
        least + (most - least) * stream.uniform()
    }

    /// Draws a whole number from the range, both ends included.
    pub fn draw_whole(self, stream: &mut RandomStream) -> u32 {
        let [least, most] = self.0;
        let count = (most - least).max(0.0).floor() + 1.0;
        (least + (stream.uniform() * count).floor()).max(0.0) as u32
    }
}

macro_rules! ranges {
    ($($(#[$about:meta])* $name:ident { $($(#[$what:meta])* $field:ident: $type:ty,)* })*) => {
        $(
            $(#[$about])*
            #[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
            #[serde(deny_unknown_fields)]
            #[non_exhaustive]
            pub struct $name {
                $($(#[$what])* pub $field: $type,)*
            }
        )*
    };
}

ranges! {
    /// All ranges, and their sources.
    Ranges {
        /// The light.
        light: LightRanges,
        /// The carpet.
        turf: TurfRanges,
        /// The lines.
        lines: LineRanges,
        /// The goals.
        goals: GoalRanges,
        /// The ball.
        ball: BallRanges,
        /// The robots.
        robots: RobotRanges,
        /// What is around the pitch.
        surroundings: SurroundingRanges,
        /// The cameras.
        camera: CameraRanges,
        /// The situations.
        scenes: SceneRanges,
        /// Limits for labels.
        labels: LabelLimits,
        /// The source of each range, by its path.
        sources: BTreeMap<String, String>,
    }
    /// The light.
    LightRanges {
        /// The height of the lamp or the sun above the horizon, degrees.
        elevation_deg: Range,
        /// Its light on a surface that faces it, as a share of full light.
        from_sun: Range,
        /// The light from everywhere, as a share of full light.
        ambient: Range,
        /// The share of the light that is left in a shadow.
        in_shadow: Range,
        /// How much darker the darkest places of the ground are, as a share.
        unevenness: Range,
        /// The distance between bright and dark places, m.
        pools_m: Range,
    }
    /// The carpet.
    TurfRanges {
        /// The hue, degrees; green is 120.
        hue_deg: Range,
        /// The saturation.
        saturation: Range,
        /// The brightness.
        value: Range,
        /// The contrast of blades of grass.
        grain: Range,
        /// The contrast of patches.
        mottling: Range,
        /// How often it has stripes.
        stripe_chance: f32,
        /// The width of a stripe, m.
        stripe_m: Range,
        /// The contrast of stripes.
        stripe_contrast: Range,
    }
    /// The lines.
    LineRanges {
        /// Their width, m.
        width_m: Range,
        /// Their brightness.
        value: Range,
        /// How much of the turf shows through where they are worn most.
        wear: Range,
    }
    /// The goals.
    GoalRanges {
        /// How often the goals are white. Otherwise they have the colours of the scenario's field, or are yellow if those are white as
        /// well.
        white_chance: f32,
        /// The diameter of the posts, m.
        post_diameter_m: Range,
        /// The brightness of the net.
        net_value: Range,
    }
    /// The ball.
    BallRanges {
        /// How often the ball is missing, in drawn situations.
        missing_chance: f32,
        /// How often the base colour is white; otherwise it is any colour.
        white_chance: f32,
        /// The weight of balls of one colour.
        plain: f32,
        /// The weight of balls with twelve dark patches.
        pentagons: f32,
        /// The weight of balls with some large patches.
        caps: f32,
        /// The weight of balls with bands.
        bands: f32,
    }
    /// The robots.
    RobotRanges {
        /// The colours of teams.
        jerseys: Vec<Jersey>,
        /// How often the robots of a team wear shirts in its colour.
        shirt_chance: f32,
        /// How often the robots' limbs have the team's colour.
        limbs_chance: f32,
        /// How often shells keep the colour of the robot's model.
        own_shell_chance: f32,
        /// The brightness of shells of another colour.
        shell_value: Range,
        /// The saturation of shells of another colour.
        shell_saturation: Range,
        /// How often a robot has another model than in the scenario, in drawn situations.
        other_model_chance: f32,
    }
    /// The colour of a team.
    Jersey {
        /// Its name.
        name: String,
        /// Red, green and blue, sRGB.
        rgb: [u8; 3],
    }
    /// The surroundings of the pitch.
    SurroundingRanges {
        /// The brightness of the walls.
        wall_value: Range,
        /// Their saturation.
        wall_saturation: Range,
        /// The contrast of the patterns on the walls.
        wall_contrast: Range,
        /// The brightness of the floor.
        floor_value: Range,
        /// Its saturation.
        floor_saturation: Range,
        /// The number of things beside the pitch.
        things: Range,
        /// The number of people beside the pitch.
        people: Range,
        /// The distance of things and people from the carpet, m.
        beyond_m: Range,
        /// How often there is another pitch beside this one.
        neighbour_chance: f32,
    }
    /// The cameras.
    CameraRanges {
        /// The factor on the brightness.
        exposure: Range,
        /// The factors on red and blue.
        white_balance: Range,
        /// The standard deviation of the noise of each channel, of 255.
        pixel_sd: Range,
        /// The standard deviation of the blur, pixels.
        blur_px: Range,
        /// The share of the light that is lost in the corners.
        vignetting: Range,
        /// The exposure time, ms.
        exposure_ms: Range,
        /// The speed at which the camera turns, degrees per second, in drawn situations.
        turn_degps: Range,
        /// How far the lens displaces a corner of the image, as a share of its distance from the middle. It applies to cameras without a
        /// known distortion.
        distortion: Range,
        /// How often a robot sees its own body.
        own_body_chance: f32,
        /// The quality of JPEG files, up to 100.
        jpeg_quality: Range,
    }
    /// The situations.
    SceneRanges {
        /// The share of matches whose situations are drawn at random instead of played.
        drawn_share: f32,
        /// The time of the first image of a match that is played, s.
        first_s: Range,
        /// The time from one image to the next, s.
        gap_s: Range,
        /// How often a robot lies, in drawn situations.
        lying_chance: f32,
    }
    /// Limits for labels.
    LabelLimits {
        /// The least width and height of a labelled object, pixels.
        least_px: f32,
        /// The least visible share of a labelled object, of its area in the image.
        least_visible: f32,
        /// Half the side of the square around a crossing of lines, or a penalty mark, that is labelled, m.
        crossing_m: f32,
        /// The greatest distance at which crossings and penalty marks are labelled, m.
        crossing_reach_m: f32,
    }
}

impl Ranges {
    /// Reads the ranges of the file at `path`, which replace those of the program. Returns the program's ranges if there is no file.
    ///
    /// # Errors
    /// The first fault of the file, and where it is.
    pub fn read(path: Option<&Path>) -> Result<Ranges, ScenarioError> {
        read_looks(path)
    }

    /// Returns the first invalid value: its path, and what was expected.
    pub fn fault(&self) -> Option<(String, String)> {
        let shares = "a share from 0 to 1".to_owned();
        let value = serde_json::to_value(self).unwrap_or_default();
        let mut fault = None;
        for (path, value) in leaves(&value) {
            let name = path.rsplit('.').next().unwrap_or_default();
            let numbers = value
                .as_array()
                .map_or_else(|| vec![value.as_f64()], |list| list.iter().map(|it| it.as_f64()).collect());
            let numbers: Vec<f64> = numbers.into_iter().flatten().collect();
            let found = match numbers.as_slice() {
                [chance] if is_chance(name) && !(0.0..=1.0).contains(chance) => Some(shares.clone()),
                [least, most] if least > most => Some("the smaller number first".to_owned()),
                [first, ..] if *first < 0.0 && name != "distortion" => Some("a number of at least 0".to_owned()),
                [_, most] if greatest(&path).is_some_and(|greatest| *most > greatest) => {
                    greatest(&path).map(|greatest| format!("at most {greatest}"))
                }
                [least, _] if least_of(&path).is_some_and(|lowest| *least < lowest) => {
                    least_of(&path).map(|lowest| format!("at least {lowest}"))
                }
                _ => None,
            };
            fault = fault.or(found.map(|expected| (path.clone(), expected)));
        }
        let BallRanges { plain, pentagons, caps, bands, .. } = self.ball;
        if fault.is_none() && plain + pentagons + caps + bands <= 0.0 {
            fault = Some(("ball".to_owned(), "a weight above 0 for one of the patterns".to_owned()));
        }
        if fault.is_none() && self.robots.jerseys.len() < 2 {
            fault = Some(("robots.jerseys".to_owned(), "at least two colours".to_owned()));
        }
        fault
    }
}

fn is_chance(name: &str) -> bool {
    name.ends_with("_chance") || name.ends_with("_share") || name == "least_visible"
}

/// Returns the upper limit of some ranges.
fn greatest(path: &str) -> Option<f64> {
    Some(match path {
        "light.elevation_deg" => 90.0,
        "light.unevenness" | "light.in_shadow" | "lines.wear" | "camera.vignetting" => 1.0,
        "lines.width_m" | "goals.post_diameter_m" => 0.5,
        "surroundings.things" => 200.0,
        // Each person needs a number of its own in the image.
        "surroundings.people" => 60.0,
        "camera.jpeg_quality" => 100.0,
        "camera.blur_px" => 8.0,
        "camera.exposure_ms" => 100.0,
        "camera.distortion" => 0.3,
        "scenes.first_s" | "scenes.gap_s" => 600.0,
        _ => return None,
    })
}

/// Returns the lower limit of some ranges.
fn least_of(path: &str) -> Option<f64> {
    Some(match path {
        "light.elevation_deg" => 10.0,
        "light.pools_m" | "turf.stripe_m" => 0.1,
        "lines.width_m" | "goals.post_diameter_m" => 0.01,
        "camera.jpeg_quality" => 1.0,
        "camera.distortion" => -0.3,
        _ => return None,
    })
}

/// Returns all values with their paths: numbers, and lists of numbers.
pub(super) fn leaves(value: &serde_json::Value) -> Vec<(String, serde_json::Value)> {
    let mut found = Vec::new();
    let Some(fields) = value.as_object() else { return found };
    for (name, value) in fields {
        if name == "sources" {
            continue;
        }
        match value {
            serde_json::Value::Object(_) => {
                found.extend(leaves(value).into_iter().map(|(path, value)| (format!("{name}.{path}"), value)));
            }
            _ => found.push((name.clone(), value.clone())),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn every_range_that_comes_with_the_program_has_a_source_and_can_be() {
        let ranges = Ranges::read(None).unwrap();
        assert_eq!(ranges.fault(), None);
        let value = serde_json::to_value(&ranges).unwrap();
        let leaves = leaves(&value);
        let is_within = |path: &str, source: &str| path == source || path.starts_with(&format!("{source}."));
        for (path, _) in &leaves {
            assert!(ranges.sources.keys().any(|source| is_within(path, source)), "{path} has no source");
        }
        for source in ranges.sources.keys() {
            assert!(leaves.iter().any(|(path, _)| is_within(path, source)), "{source} is no range");
        }
    }

    #[test]
    fn ones_own_file_says_only_what_differs_and_errors_point_into_it() {
        let folder = tempfile::tempdir().unwrap();
        let read = |name: &str, text: &str| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            Ranges::read(Some(&path)).map_err(|error| error.to_string())
        };
        let own = read("a.json", r#"{ "turf": { "hue_deg": [0, 360] } }"#).unwrap();
        let built_in = Ranges::read(None).unwrap();
        assert_eq!((own.turf.hue_deg, &own.lines), (Range([0.0, 360.0]), &built_in.lines));
        let error = read("b.ron", "(\n  turf: (hue: (0, 1)),\n)").unwrap_err();
        assert!(error.contains("b.ron:2:10") && error.contains("`hue`"), "{error}");
        assert!(read("c.json", "[]").unwrap_err().contains("no looks"));
        assert!(read("d.txt", "").unwrap_err().contains(".ron"));
        let fault = |text: &str| read("e.json", text).unwrap().fault().map(|(path, _)| path);
        for (text, path) in [
            (r#"{ "turf": { "hue_deg": [2, 1] } }"#, "turf.hue_deg"),
            (r#"{ "ball": { "white_chance": 2 } }"#, "ball.white_chance"),
            (r#"{ "camera": { "pixel_sd": [-1, 1] } }"#, "camera.pixel_sd"),
            (r#"{ "surroundings": { "people": [0, 900] } }"#, "surroundings.people"),
            (r#"{ "robots": { "jerseys": [] } }"#, "robots.jerseys"),
        ] {
            assert_eq!(fault(text).as_deref(), Some(path));
        }
    }

    #[test]
    fn draws_stay_in_their_range() {
        let mut stream = RandomStream::for_match(1, "test");
        let whole: Vec<u32> = (0..200).map(|_| Range([2.0, 4.0]).draw_whole(&mut stream)).collect();
        assert!(
            [2, 3, 4].iter().all(|number| whole.contains(number))
                && whole.iter().all(|number| (2..=4).contains(number))
        );
        assert!((0..200).all(|_| (0.5..0.75).contains(&Range([0.5, 0.75]).draw(&mut stream))));
    }
}

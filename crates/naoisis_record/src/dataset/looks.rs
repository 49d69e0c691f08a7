//! Randomly drawn looks of a match and of each of its images. The metadata contains all of them.

use bevy::math::{Vec3, ops};
use serde::Serialize;

use super::ranges::{BallRanges, Range, Ranges};
use naoisis_core::geometry::{to_radians, unit};
use naoisis_core::pitch::GoalColour;
use naoisis_core::random::RandomStream;
use naoisis_core::robot::look::Rgb;
use naoisis_core::team::{PerTeam, Team};
use naoisis_sensing::appearance::ball;
use naoisis_sensing::appearance::colours::{Colour, hsv};
use naoisis_sensing::sensing::camera::software::stage::PatchArea;

/// The looks of a match: the hall, the pitch, the robots and their cameras.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct MatchLooks {
    /// The direction of the lamp, unit vector.
    pub sun: Vec3,
    /// The light of the lamp, as a share of full light.
    pub from_sun: f32,
    /// The ambient light, as a share of full light.
    pub ambient: f32,
    /// The share of the light that is left in a shadow.
    pub in_shadow: f32,
    /// How much darker the darkest places of the ground are, as a share.
    pub unevenness: f32,
    /// The distance between bright and dark places, m.
    pub pool_m: f32,
    /// The colour of the turf.
    pub turf: Rgb,
    /// The contrast of the blades of grass.
    pub grain: f32,
    /// The contrast of the patches of the turf.
    pub mottling: f32,
    /// Stripes across the pitch.
    pub stripes: Option<Stripes>,
    /// The colour of lines.
    pub line: Rgb,
    /// The width of the lines, m.
    pub line_width_m: f32,
    /// The share of the turf's colour that shows through worn lines.
    pub wear: f32,
    /// The colours of the goals at negative and positive x.
    pub goals: [Rgb; 2],
    /// The diameter of posts, m.
    pub post_diameter_m: f32,
    /// The colour of nets.
    pub net: Rgb,
    /// The ball.
    pub ball: BallLook,
    /// The teams.
    pub teams: PerTeam<TeamLook>,
    /// The colour of the walls.
    pub wall: Rgb,
    /// The contrast of the patterns on the walls.
    pub wall_contrast: f32,
    /// The colour of the floor.
    pub floor: Rgb,
    /// The number of things beside the pitch.
    pub things: u32,
    /// The number of people beside the pitch.
    pub people: u32,
    /// The range of the distance of things and people from the carpet, m.
    #[serde(skip)]
    pub beyond_m: Range,
    /// Whether there is another pitch beside this one.
    pub has_neighbour: bool,
    /// The factors on red, green and blue.
    pub white_balance: [f32; 3],
    /// The share of the light that is lost in the corners.
    pub vignetting: f32,
    /// The displacement of the image corners by the lens, as a share of their distance from the middle.
    pub distortion: f32,
    /// Whether a camera sees the robot's own body.
    pub sees_itself: bool,
}

/// Stripes of a carpet.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Stripes {
    /// The width of a stripe, m.
    pub width_m: f32,
    /// The contrast of the stripes.
    pub contrast: f32,
}

/// The look of a team.
#[derive(Clone, PartialEq, Debug, Default, Serialize)]
pub struct TeamLook {
    /// The name of the team's colour.
    pub jersey: String,
    /// The team's colour.
    pub colour: Rgb,
    /// Whether the robots wear shirts in the team's colour.
    pub shirts: bool,
    /// Whether the robots' limbs have the team's colour.
    pub limbs: bool,
    /// The colour of the robots' shells. `None` for the colour of their models.
    pub shell: Option<Rgb>,
}

/// The look of a ball.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct BallLook {
    /// The name of its pattern.
    pub pattern: &'static str,
    /// The base colour.
    pub ground: Rgb,
    /// The colours of its patches.
    pub colours: Vec<Rgb>,
    /// The coloured patches.
    #[serde(skip)]
    pub patches: Vec<PatchArea>,
}

/// The looks of one image.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct ImageLooks {
    /// The factor on the brightness.
    pub exposure: f32,
    /// Standard deviation of the noise of each channel, of 255.
    pub pixel_sd: f32,
    /// Standard deviation of the blur, pixels.
    pub blur_px: f32,
    /// Exposure time, s.
    pub exposure_s: f32,
    /// The quality of the JPEG file.
    pub jpeg_quality: u8,
}

impl ImageLooks {
    /// Draws the looks of an image.
    pub fn draw(ranges: &Ranges, stream: &mut RandomStream) -> Self {
        let camera = &ranges.camera;
        Self {
            exposure: camera.exposure.draw(stream),
            pixel_sd: camera.pixel_sd.draw(stream),
            blur_px: camera.blur_px.draw(stream),
            exposure_s: camera.exposure_ms.draw(stream) / 1e3,
            jpeg_quality: camera.jpeg_quality.draw_whole(stream).clamp(1, 100) as u8,
        }
    }
}

impl MatchLooks {
    /// Draws the looks of a match. `goals` are the colours of the scenario's goals.
    pub fn draw(ranges: &Ranges, goals: [GoalColour; 2], stream: &mut RandomStream) -> Self {
        let Ranges { light, turf, lines, goals: goal_ranges, surroundings, camera, .. } = ranges;
        let elevation = to_radians(light.elevation_deg.draw(stream));
        let around = unit(to_radians(360.0 * stream.uniform()));
        let (sin, cos) = ops::sin_cos(elevation);
        let goals = if stream.chance(goal_ranges.white_chance) {
            [WHITE; 2]
        } else if goals == [GoalColour::White; 2] {
            [goal_colour(GoalColour::Yellow); 2]
        } else {
            goals.map(goal_colour)
        };
        let stripes = stream
            .chance(turf.stripe_chance)
            .then(|| Stripes { width_m: turf.stripe_m.draw(stream), contrast: turf.stripe_contrast.draw(stream) });
        let (things, people) = (surroundings.things.draw_whole(stream), surroundings.people.draw_whole(stream));
        let [red, blue] = [0, 1].map(|_| camera.white_balance.draw(stream));
        Self {
            sun: (cos * around).extend(sin),
            from_sun: light.from_sun.draw(stream),
            ambient: light.ambient.draw(stream),
            in_shadow: light.in_shadow.draw(stream),
            unevenness: light.unevenness.draw(stream),
            pool_m: light.pools_m.draw(stream),
            turf: hsv(turf.hue_deg.draw(stream), turf.saturation.draw(stream), turf.value.draw(stream)),
            grain: turf.grain.draw(stream),
            mottling: turf.mottling.draw(stream),
            stripes,
            line: hsv(60.0, 0.03 * stream.uniform(), lines.value.draw(stream)),
            line_width_m: lines.width_m.draw(stream),
            wear: lines.wear.draw(stream),
            goals,
            post_diameter_m: goal_ranges.post_diameter_m.draw(stream),
            net: hsv(0.0, 0.0, goal_ranges.net_value.draw(stream)),
            ball: BallLook::draw(&ranges.ball, stream),
            teams: teams(ranges, stream),
            wall: any_hue(surroundings.wall_saturation, surroundings.wall_value, stream),
            wall_contrast: surroundings.wall_contrast.draw(stream),
            floor: any_hue(surroundings.floor_saturation, surroundings.floor_value, stream),
            things,
            people,
            beyond_m: surroundings.beyond_m,
            has_neighbour: stream.chance(surroundings.neighbour_chance),
            white_balance: [red, 1.0, blue],
            vignetting: camera.vignetting.draw(stream),
            distortion: camera.distortion.draw(stream),
            sees_itself: stream.chance(camera.own_body_chance),
        }
    }
}

const WHITE: Rgb = [238; 3];

fn goal_colour(colour: GoalColour) -> Rgb {
    let Colour(rgb) = naoisis_sensing::appearance::colours::goal(colour);
    rgb
}

/// Draws two teams of different colours.
fn teams(ranges: &Ranges, stream: &mut RandomStream) -> PerTeam<TeamLook> {
    let robots = &ranges.robots;
    let count = robots.jerseys.len().max(1);
    let blue = (stream.uniform() * count as f32) as usize % count;
    let pink = (blue + 1 + (stream.uniform() * (count - 1) as f32) as usize) % count;
    let mut draw = |index: usize| {
        let jersey = robots.jerseys.get(index);
        TeamLook {
            jersey: jersey.map(|jersey| jersey.name.clone()).unwrap_or_default(),
            colour: jersey.map(|jersey| jersey.rgb).unwrap_or_default(),
            shirts: stream.chance(robots.shirt_chance),
            limbs: stream.chance(robots.limbs_chance),
            shell: (!stream.chance(robots.own_shell_chance))
                .then(|| any_hue(robots.shell_saturation, robots.shell_value, stream)),
        }
    };
    let [blue, pink] = [draw(blue), draw(pink)];
    PerTeam::new(|team| if team == Team::Blue { blue.clone() } else { pink.clone() })
}

impl BallLook {
    /// Draws the look of a ball.
    fn draw(ranges: &BallRanges, stream: &mut RandomStream) -> Self {
        let ground = if stream.chance(ranges.white_chance) {
            hsv(60.0, 0.05 * stream.uniform(), 0.85 + 0.15 * stream.uniform())
        } else {
            hsv(360.0 * stream.uniform(), 0.6 + 0.4 * stream.uniform(), 0.5 + 0.5 * stream.uniform())
        };
        let dark = |stream: &mut RandomStream| {
            let is_black = stream.chance(0.5);
            let [saturation, value] = if is_black { [0.2, 0.15] } else { [1.0, 0.8] };
            hsv(360.0 * stream.uniform(), saturation * stream.uniform(), value * (0.4 + 0.6 * stream.uniform()))
        };
        let BallRanges { plain, pentagons, caps, bands, .. } = ranges;
        let choice = stream.uniform() * (plain + pentagons + caps + bands);
        let colours: Vec<Rgb> = (0..2).map(|_| dark(stream)).collect();
        let colour = |index: usize| Colour(colours[index % 2]);
        let (pattern, patches): (_, Vec<PatchArea>) = if choice < *plain {
            ("plain", Vec::new())
        } else if choice < plain + pentagons {
            // The patches are as wide as the black pieces of a ball made of 32 pieces.
            ("pentagons", ball::pentagons(colour(0), 0.925).to_vec())
        } else if choice < plain + pentagons + caps {
            let count = 3 + (stream.uniform() * 4.0) as usize;
            let mut draw = |index| {
                let from = 0.6 + 0.35 * stream.uniform();
                PatchArea { axis: direction(stream), from, to: 1.0, colour: colour(index) }
            };
            ("caps", (0..count).map(&mut draw).collect())
        } else {
            let count = 1 + (stream.uniform() * 3.0) as usize;
            let mut draw = |index| {
                let half = 0.05 + 0.15 * stream.uniform();
                let middle = 0.6 * (stream.uniform() - 0.5);
                PatchArea { axis: direction(stream), from: middle - half, to: middle + half, colour: colour(index) }
            };
            ("bands", (0..count).map(&mut draw).collect())
        };
        Self { pattern, ground, colours, patches }
    }
}

/// Draws a direction.
pub fn direction(stream: &mut RandomStream) -> Vec3 {
    Vec3::new(stream.gaussian(1.0), stream.gaussian(1.0), stream.gaussian(1.0)).normalize_or(Vec3::Z)
}

/// Draws a colour of any hue.
pub fn any_hue(saturation: Range, value: Range, stream: &mut RandomStream) -> Rgb {
    let hue = 360.0 * stream.uniform();
    hsv(hue, saturation.draw(stream), value.draw(stream))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_draws_the_same_looks_and_teams_differ() {
        let ranges = Ranges::read(None).unwrap();
        let draw = |seed| MatchLooks::draw(&ranges, [GoalColour::White; 2], &mut RandomStream::for_match(seed, "test"));
        assert!(draw(1) == draw(1) && draw(1) != draw(2));
        let looks: Vec<MatchLooks> = (0..100).map(draw).collect();
        for look in &looks {
            assert_ne!(look.teams[Team::Blue].jersey, look.teams[Team::Pink].jersey);
            assert!(look.sun.is_normalized() && look.sun.z > 0.5);
            let [red, green, blue] = look.turf;
            assert!(green > red && green > blue, "{:?}", look.turf);
        }
        for pattern in ["plain", "pentagons", "caps", "bands"] {
            assert!(looks.iter().any(|look| look.ball.pattern == pattern));
        }
    }
}

//! Tests that colours can be told apart by people who lack one kind of cones: teams, ball, lines, the lanes' colours
//! for knowledge of the ball. Only compiled for tests.
//!
//! Colour vision is simulated as by Machado, Oliveira and Fernandes (2009), "A physiologically-based model for
//! simulation of color vision deficiency", with complete loss. The difference of colours is their distance in `OKLab`,
//! in which black and white are 1 apart.

use bevy::color::{Mix, Oklaba};
use bevy::prelude::*;

use super::palette;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::team::Team;
use naoisis_sensing::appearance::colours;

/// The least difference of colours that nothing else distinguishes, for every kind of colour vision.
const APART: f32 = 0.13;
/// The least difference of colours that a shape, a name or a ring distinguishes, too.
const APART_BESIDES: f32 = 0.03;

/// Rows of the matrices of linear red, green and blue.
const NONE: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const PROTANOPIA: [[f32; 3]; 3] =
    [[0.152_286, 1.052_583, -0.204_868], [0.114_503, 0.786_281, 0.099_216], [-0.003_882, -0.048_116, 1.051_998]];
const DEUTERANOPIA: [[f32; 3]; 3] =
    [[0.367_322, 0.860_646, -0.227_968], [0.280_085, 0.672_501, 0.047_413], [-0.011_820, 0.042_940, 0.968_881]];
const TRITANOPIA: [[f32; 3]; 3] =
    [[1.255_528, -0.076_749, -0.178_779], [-0.078_411, 0.930_809, 0.147_602], [0.004_733, 0.691_367, 0.303_900]];

/// A colour as it is seen.
fn seen(colour: Color, rows: [[f32; 3]; 3]) -> Color {
    let linear = colour.to_linear();
    let [red, green, blue] = rows.map(|row| Vec3::from(row).dot(Vec3::new(linear.red, linear.green, linear.blue)));
    Color::linear_rgb(red.clamp(0.0, 1.0), green.clamp(0.0, 1.0), blue.clamp(0.0, 1.0))
}

fn distance(one: Color, other: Color) -> f32 {
    let [one, other] = [one, other].map(|colour| {
        let lab = Oklaba::from(colour);
        Vec3::new(lab.lightness, lab.a, lab.b)
    });
    one.distance(other)
}

#[test]
fn what_is_told_apart_by_colour_stays_apart_for_everybody() {
    let team = palette::team;
    let [carpet, chalk, ball] = [colours::CARPET, colours::CHALK, colours::BALL].map(palette::from_appearance);
    let ink = palette::ink;
    // Faded as in lanes, on a dark panel.
    let panel = Color::srgb_u8(20, 24, 31);
    let faded = panel.mix(&ink(DrawColour::Orange), 0.4);
    let by_colour = [
        ("blue and pink", team(Team::Blue), team(Team::Pink)),
        ("pink and the carpet", team(Team::Pink), carpet),
        ("the ball and the carpet", ball, carpet),
        ("the ball and lines", ball, chalk),
        ("the ball and blue", ball, team(Team::Blue)),
        ("lines and the carpet", chalk, carpet),
        ("believed opponents and team-mates", ink(DrawColour::Sky), ink(DrawColour::Vermilion)),
        ("a ball that is seen and one that is remembered", ink(DrawColour::Orange), faded),
        ("a ball that is seen and one that was told of", ink(DrawColour::Orange), ink(DrawColour::Sky)),
        ("a ball that is remembered and a lost one", faded, panel),
        ("the pen's arrows and its zones", ink(DrawColour::Yellow), ink(DrawColour::Sky)),
        ("the pen's arrows and the carpet", ink(DrawColour::Yellow), carpet),
        ("the pen's zones and the carpet", ink(DrawColour::Sky), carpet),
    ];
    let by_shape = [
        // The carpet: robots are white and have names. The ball is round, and has a ring where it is small.
        ("blue and the carpet", team(Team::Blue), carpet),
        ("the ball and pink", ball, team(Team::Pink)),
        // The robot is drawn as an arrow in a circle, the ball as two circles.
        ("oneself and the ball as believed", ink(DrawColour::Purple), ink(DrawColour::Orange)),
    ];
    let pairs = by_colour.map(|pair| (pair, APART)).into_iter().chain(by_shape.map(|pair| (pair, APART_BESIDES)));
    let eyes = [("all", NONE), ("no red", PROTANOPIA), ("no green", DEUTERANOPIA), ("no blue", TRITANOPIA)];
    let mut near = Vec::new();
    for (cones, rows) in eyes {
        for ((names, one, other), least) in pairs.clone() {
            let apart = distance(seen(one, rows), seen(other, rows));
            if apart < least {
                near.push(format!("{names} are {apart:.3} apart, cones: {cones}"));
            }
        }
    }
    assert!(near.is_empty(), "{near:#?}");
}

#[test]
fn the_simulation_leaves_grey_as_it_is_and_makes_red_and_green_alike() {
    let grey = Color::srgb(0.5, 0.5, 0.5);
    for rows in [PROTANOPIA, DEUTERANOPIA, TRITANOPIA] {
        assert!(distance(seen(grey, rows), grey) < 0.01);
    }
    let [red, green] = [Color::srgb(0.7, 0.3, 0.1), Color::srgb(0.35, 0.45, 0.1)];
    assert!(distance(seen(red, DEUTERANOPIA), seen(green, DEUTERANOPIA)) < 0.5 * distance(red, green));
}

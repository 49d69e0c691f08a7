//! The two designs of a robot (paper, section 3.1 and Fig. 2): one close to the real robot, and one of a few boxes, which is faster to draw.
//! Both have the robot's size and joints, and the team's waistband.
//!
//! Robots that look like a NAO are drawn as a NAO scaled to their measures, other robots from the measures of their bodies.

use bevy::math::{Vec2, Vec3};
use bevy::prelude::Reflect;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Label;
use super::colours::{self, Colour};
use super::posing::Limb;
use super::shapes::{Part, Shape};
use naoisis_core::robot::body::Body;
use naoisis_core::robot::look::{Look, LookShape, NumberPlaces};
use naoisis_core::team::{RobotId, Team};

mod by_measures;
mod nao;
mod number;

/// A part of a robot, placed in the frame of a limb.
pub type RobotPart = Part<Limb>;

/// The design of robots.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotDesign {
    /// Close to the real robot, with a number on chest and back.
    Nao,
    /// A few boxes.
    #[default]
    Simple,
}

impl RobotDesign {
    /// Both designs.
    pub const BOTH: [RobotDesign; 2] = [RobotDesign::Nao, RobotDesign::Simple];

    /// The parts of a robot with this body in this design. A robot with the number 0 has empty plates.
    pub fn parts(self, id: RobotId, body: &Body) -> Vec<RobotPart> {
        let number = body.jersey.map(colours::number_on);
        let plain = &Body { look: number.map_or(body.look, |Colour(number)| numbered(body, id, number)), ..*body };
        let mut parts = match (self, body.look.shape) {
            (RobotDesign::Nao, LookShape::Nao) => nao::detailed(id, plain),
            (RobotDesign::Nao, LookShape::Measures) => by_measures::detailed(id, plain),
            (RobotDesign::Simple, LookShape::Nao) => nao::simple(id, plain),
            (RobotDesign::Simple, LookShape::Measures) => by_measures::simple(id, plain),
        };
        if body.jersey.is_some() {
            put_jersey_on(&mut parts, id.team, body);
        }
        parts
    }
}

/// The labels of a robot's body and of its waistband, in this order.
pub const fn labels(team: Team) -> [Label; 2] {
    match team {
        Team::Blue => [Label::BlueRobot, Label::BlueWaistband],
        Team::Pink => [Label::PinkRobot, Label::PinkWaistband],
    }
}

/// The look of a robot with its number in this colour on its jersey, without plates of another colour.
fn numbered(body: &Body, id: RobotId, number: [u8; 3]) -> Look {
    let Colour(plates) = colours::worn(id.team, body.jersey);
    Look { number: NumberPlaces { chest: true, back: true }, number_colour: number, plates, ..body.look }
}

/// Colours the shells of the trunk from the waistband up, which then have its label.
fn put_jersey_on(parts: &mut [RobotPart], team: Team, body: &Body) {
    let ([_, label], colour) = (labels(team), colours::worn(team, body.jersey));
    let shell = Colour(body.look.shell);
    let lower_m = body.waistband.z_m[0];
    for part in parts.iter_mut().filter(|part| part.frame == Limb::Trunk) {
        let is_above = part.frame_from_shape.translation.z > lower_m;
        if is_above && (part.colour == shell || part.colour == colour) {
            (part.colour, part.label) = (colour, label);
        }
    }
}

/// Collects the parts of a body.
struct PartList {
    label: Label,
    team: Colour,
    look: Look,
    /// Whether it has a number in the simple design, too.
    has_jersey: bool,
    parts: Vec<RobotPart>,
}

impl PartList {
    fn new(id: RobotId, body: &Body, capacity: usize) -> Self {
        let [label, _] = labels(id.team);
        let (team, has_jersey) = (colours::worn(id.team, body.jersey), body.jersey.is_some());
        Self { label, team, look: body.look, has_jersey, parts: Vec::with_capacity(capacity) }
    }

    /// The colours of shells and of joints.
    fn colours(&self) -> [Colour; 2] {
        [Colour(self.look.shell), Colour(self.look.joints)]
    }

    /// The colour of a part of `limb` that is usually painted in `colour`. The shells of some limbs may have the team's colour.
    fn paint(&self, limb: Limb, colour: Colour) -> Colour {
        let limbs = self.look.team_limbs;
        let is_of_team = match limb {
            Limb::Trunk => false,
            Limb::Head => limbs.head,
            Limb::LeftArm | Limb::RightArm => limbs.arms,
            _ => limbs.legs,
        };
        if is_of_team && colour == Colour(self.look.shell) { self.team } else { colour }
    }

    /// Adds the waistband in the team's colour.
    fn band(&mut self, team: Team, body: &Body, shape: Shape) {
        let [_, label] = labels(team);
        self.parts.push(Part::at(Limb::Trunk, label, self.team, shape, body.waistband.middle()));
    }

    fn add(&mut self, limb: Limb, colour: Colour, shape: Shape, centre: Vec3) {
        self.parts.push(Part::at(limb, self.label, self.paint(limb, colour), shape, centre));
    }

    fn cuboid(&mut self, limb: Limb, colour: Colour, size: Vec3, centre: Vec3) {
        self.add(limb, colour, Shape::Box { half_size: size / 2.0 }, centre);
    }

    fn ball(&mut self, limb: Limb, colour: Colour, radius: f32, centre: Vec3) {
        self.add(limb, colour, Shape::sphere(radius), centre);
    }

    fn ellipsoid(&mut self, limb: Limb, colour: Colour, radii: Vec3, centre: Vec3) {
        self.add(limb, colour, Shape::Ellipsoid { radii }, centre);
    }

    fn rod(&mut self, limb: Limb, colour: Colour, radius: f32, ends: [Vec3; 2]) {
        self.parts.push(Part::rod(limb, self.label, self.paint(limb, colour), radius, ends));
    }

    /// Adds a frustum between radii at two heights.
    fn frustum(&mut self, limb: Limb, colour: Colour, [lower, upper]: [(Vec2, f32); 2]) {
        let shape = Shape::Frustum { bottom: lower.0, top: upper.0, half_height: (upper.1 - lower.1) / 2.0 };
        self.add(limb, colour, shape, Vec3::Z * ((lower.1 + upper.1) / 2.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::posing::JointAngles;
    use crate::appearance::shapes::Shape;
    use bevy::math::Affine3A;
    use naoisis_core::robot::body::{Arms, BodyBox, Legs, Waistband};

    /// The least and greatest height of a standing robot's parts, m.
    fn heights(design: RobotDesign, body: &Body) -> [f32; 2] {
        let limbs = JointAngles::default().world_from_limbs(body, Affine3A::IDENTITY);
        let mut range = [f32::MAX, f32::MIN];
        for part in design.parts(RobotId::new(Team::Blue, 3), body) {
            let place = limbs[part.frame as usize] * part.frame_from_shape;
            // The reach of the shape along z of the robot frame.
            let up = place.matrix3.transpose() * bevy::math::Vec3A::Z;
            let half = match part.shape {
                Shape::Box { half_size } => (Vec3::from(up) * half_size).abs().element_sum(),
                Shape::Ellipsoid { radii } => (Vec3::from(up) * radii).length(),
                Shape::Frustum { bottom, top, half_height } => {
                    half_height * up.z.abs() + (Vec3::from(up).truncate() * bottom.max(top)).length()
                }
                Shape::Capsule { radius, half_length } => radius + half_length * up.z.abs(),
            };
            range[0] = range[0].min(place.translation.z - half);
            range[1] = range[1].max(place.translation.z + half);
        }
        range
    }

    #[test]
    fn robots_stand_on_the_ground_and_are_as_high_as_they_should() {
        let tall = Body { height_m: 1.2, neck_m: Vec3::Z, look: Look::DARK, ..Body::default() };
        let legs = Legs { hip_m: Vec3::new(0.0, 0.1, 0.5), thigh_m: 0.22, shank_m: 0.24, ankle_m: 0.04 };
        let large_nao = Body { look: Look::NAO, legs: Some(legs), foot_y_m: 0.1, ..tall };
        let look = Look { head: naoisis_core::robot::look::Top::Mast, ..Look::LIGHT };
        let wheeled = Body { legs: None, arms: None, look, ..Body::default() };
        for design in RobotDesign::BOTH {
            // Aldebaran: 573 mm.
            for body in [Body::default(), tall, wheeled, large_nao, Body { legs: None, arms: None, ..Body::default() }]
            {
                let [sole, top] = heights(design, &body);
                // A head like a NAO's is as much rounder at its top as it is larger.
                let margin_m = 0.006 * (body.height_m - body.neck_m.z) / 0.1135;
                assert!(sole.abs() < 1e-3 && (top - body.height_m).abs() < margin_m, "{design:?}: {sole} {top}");
            }
        }
    }

    #[test]
    fn what_looks_like_a_nao_of_other_measures_holds_together() {
        // Twice a NAO in every measure is drawn as a NAO twice as large.
        let twice = |part: BodyBox| BodyBox {
            x_m: part.x_m.map(|x| 2.0 * x),
            half_width_m: 2.0 * part.half_width_m,
            z_m: part.z_m.map(|z| 2.0 * z),
        };
        let nao = Body::default();
        let legs = nao.legs.map(|Legs { hip_m, thigh_m, shank_m, ankle_m }| Legs {
            hip_m: 2.0 * hip_m,
            thigh_m: 2.0 * thigh_m,
            shank_m: 2.0 * shank_m,
            ankle_m: 2.0 * ankle_m,
        });
        let arms = nao
            .arms
            .map(|Arms { shoulder_m, length_m }| Arms { shoulder_m: 2.0 * shoulder_m, length_m: 2.0 * length_m });
        let band = nao.waistband;
        let waistband = Waistband { z_m: band.z_m.map(|z| 2.0 * z), half_size_m: 2.0 * band.half_size_m };
        let (torso, base) = (twice(nao.torso), twice(nao.base));
        let (height_m, foot_y_m, neck_m) = (2.0 * nao.height_m, 2.0 * nao.foot_y_m, 2.0 * nao.neck_m);
        let large = Body { torso, base, height_m, foot_y_m, neck_m, waistband, legs, arms, ..nao };
        for design in RobotDesign::BOTH {
            let [small, large] = [&nao, &large].map(|body| design.parts(RobotId::new(Team::Blue, 5), body));
            assert_eq!(small.len(), large.len());
            for (small, large) in small.iter().zip(&large) {
                let [near, far] = [small, large].map(|part| part.frame_from_shape.translation);
                assert!((2.0 * near).distance(far) < 1e-5, "{small:?} {large:?}");
                assert!((2.0 * small.shape.reach() - large.shape.reach()).abs() < 1e-5, "{small:?} {large:?}");
            }
        }
    }

    #[test]
    fn waistbands_have_the_teams_colour_and_nothing_else_has() {
        for (design, team) in [(RobotDesign::Nao, Team::Blue), (RobotDesign::Simple, Team::Pink)] {
            let parts = design.parts(RobotId::new(team, 1), &Body::default());
            let [_, band] = labels(team);
            assert_eq!(parts.iter().filter(|part| part.label == band).count(), 1);
            assert!(parts.iter().all(|part| (part.colour == colours::team(team)) == (part.label == band)));
        }
    }

    #[test]
    fn colours_and_the_place_of_the_number_are_the_models() {
        use naoisis_core::robot::look::{NumberPlaces, TeamLimbs, Top};

        let red = [200, 30, 30];
        for shape in [LookShape::Nao, LookShape::Measures] {
            for design in RobotDesign::BOTH {
                let of = |look: Look| design.parts(RobotId::new(Team::Pink, 8), &Body { look, ..Body::default() });
                let plain = Look { shape, ..Look::LIGHT };
                let painted = of(Look { shell: red, ..plain });
                let count =
                    |parts: &[RobotPart], colour: Colour| parts.iter().filter(|part| part.colour == colour).count();
                assert!(count(&painted, Colour(red)) >= 8 && count(&of(plain), Colour(red)) == 0);
                // Two arms, of which the shells have the team's colour besides the band.
                let arms = of(Look { team_limbs: TeamLimbs { arms: true, ..TeamLimbs::default() }, ..plain });
                let of_team = |parts: &[RobotPart]| count(parts, colours::team(Team::Pink));
                assert!(of_team(&of(plain)) == 1 && of_team(&arms) >= 3);
                if design == RobotDesign::Nao {
                    let digits = |number: NumberPlaces| of(Look { number, number_colour: [1, 2, 3], ..plain });
                    let places = |chest, back| count(&digits(NumberPlaces { chest, back }), Colour([1, 2, 3]));
                    assert_eq!([places(true, true), places(false, true), places(false, false)], [14, 7, 0]);
                    let back = digits(NumberPlaces { chest: false, back: true });
                    let is_behind = |part: &RobotPart| part.frame_from_shape.translation.x < 0.0;
                    assert!(back.iter().filter(|part| part.colour == Colour([1, 2, 3])).all(is_behind));
                }
                let mast = of(Look { head: Top::Mast, shape: LookShape::Measures, ..plain });
                assert!(count(&mast, Colour(plain.eyes)) == 0);
            }
        }
    }

    #[test]
    fn a_jersey_covers_the_trunk_and_has_a_number_in_both_designs() {
        use naoisis_core::robot::jersey::Jersey;

        for shape in [LookShape::Nao, LookShape::Measures] {
            for design in RobotDesign::BOTH {
                let look = Look { shape, ..Look::LIGHT };
                let of = |jersey, number| {
                    design.parts(RobotId::new(Team::Pink, number), &Body { look, jersey, ..Body::default() })
                };
                let black = of(Some(Jersey::Black), 8);
                let in_colour = |colour: Colour| move |part: &&RobotPart| part.colour == colour;
                let worn = colours::worn(Team::Pink, Some(Jersey::Black));
                let shirt: Vec<&RobotPart> = black.iter().filter(in_colour(worn)).collect();
                assert!(shirt.len() >= 2 && shirt.iter().all(|part| part.label == Label::PinkWaistband), "{design:?}");
                assert!(black.iter().all(|part| part.colour != colours::team(Team::Pink)));
                // Seven segments on the chest and on the back.
                assert_eq!(black.iter().filter(in_colour(colours::number_on(Jersey::Black))).count(), 14);
                let top = shirt.iter().map(|part| part.frame_from_shape.translation.z).fold(0.0, f32::max);
                assert!(top > 0.34, "{design:?}: {top}");
            }
        }
    }

    #[test]
    fn numbers_are_on_chest_and_back() {
        let count = |number| RobotDesign::Nao.parts(RobotId::new(Team::Blue, number), &Body::default()).len();
        // A 1 has two segments, an 8 seven, each on chest and back.
        assert_eq!(count(8) - count(1), 2 * 5);
        assert_eq!(count(18) - count(8), 2 * 2);
        assert_eq!(count(8) - count(0), 2 * 7);
    }
}

//! The two designs of a robot (paper, section 3.1 and Fig. 2): one close to the real robot, and one of a few boxes, which is
//! quicker to draw. Both have the robot's size and joints, and the team's waistband.
//!
//! The NAO is drawn as it is; other robots by the measures of their bodies.

use bevy::math::{Affine3A, Mat3, Quat, Vec2, Vec3};
use bevy::prelude::Reflect;
use serde::{Deserialize, Serialize};

use super::Label;
use super::colours::{self, Colour};
use super::posing::{Limb, on_side};
use super::shapes::{Part, Shape};
use crate::robot::body::{Arms, Body, Legs};
use crate::robot::look::{Look, LookShape};
use crate::team::{RobotId, Team};

mod by_measures;
mod number;

/// A part of a robot, placed in the frame of a limb.
pub type RobotPart = Part<Limb>;

/// How robots look.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Default, Reflect, Serialize, Deserialize)]
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

    /// The parts of a robot with this body, of this design.
    pub fn parts(self, id: RobotId, body: &Body) -> Vec<RobotPart> {
        match (self, body.look.shape) {
            (RobotDesign::Nao, LookShape::Nao) => nao(id, body),
            (RobotDesign::Nao, LookShape::Measures) => by_measures::detailed(id, body),
            (RobotDesign::Simple, LookShape::Nao) => simple(id.team, body),
            (RobotDesign::Simple, LookShape::Measures) => by_measures::simple(id, body),
        }
    }
}

/// The label of a robot's body and of its waistband.
pub const fn labels(team: Team) -> [Label; 2] {
    match team {
        Team::Blue => [Label::BlueRobot, Label::BlueWaistband],
        Team::Pink => [Label::PinkRobot, Label::PinkWaistband],
    }
}

/// Collects the parts of a body.
struct PartList {
    label: Label,
    team: Colour,
    look: Look,
    parts: Vec<RobotPart>,
}

impl PartList {
    fn new(id: RobotId, look: Look, capacity: usize) -> Self {
        let [label, _] = labels(id.team);
        Self { label, team: colours::team(id.team), look, parts: Vec::with_capacity(capacity) }
    }

    /// The colours of shells, and of what is between them.
    fn colours(&self) -> [Colour; 2] {
        [Colour(self.look.shell), Colour(self.look.joints)]
    }

    /// The colour of a part of a limb: shells of some limbs may have the team's.
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

    /// The band in the team's colour.
    fn band(&mut self, team: Team, body: &Body, shape: Shape) {
        let [_, label] = labels(team);
        self.parts.push(Part::at(Limb::Trunk, label, colours::team(team), shape, body.waistband.middle()));
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

    /// A frustum from the radii at the lower height to those at the upper.
    fn frustum(&mut self, limb: Limb, colour: Colour, [lower, upper]: [(Vec2, f32); 2]) {
        let shape = Shape::Frustum { bottom: lower.0, top: upper.0, half_height: (upper.1 - lower.1) / 2.0 };
        self.add(limb, colour, shape, Vec3::Z * ((lower.1 + upper.1) / 2.0));
    }
}

/// The measures of the limbs of a body that looks like a NAO.
fn limbs_of_nao(measures: &Body) -> (Legs, Arms) {
    (measures.legs.unwrap_or_default(), measures.arms.unwrap_or_default())
}

fn nao(id: RobotId, measures: &Body) -> Vec<RobotPart> {
    let look = measures.look;
    let (Legs { thigh_m, shank_m, ankle_m, .. }, _) = limbs_of_nao(measures);
    let mut body = PartList::new(id, look, 96);
    let ([shell, joint], label) = (body.colours(), body.label);

    // Trunk: pelvis, waistband, chest that widens to the shoulders, collar and neck.
    let trunk = Limb::Trunk;
    body.ellipsoid(trunk, joint, Vec3::new(0.046, 0.062, 0.03), Vec3::Z * 0.246);
    let radii = measures.waistband.half_size_m;
    let band = Shape::Frustum { bottom: radii, top: radii, half_height: measures.waistband.height() / 2.0 };
    body.band(id.team, measures, band);
    let (chest, shoulders, collar) = (Vec2::new(0.053, 0.07), Vec2::new(0.061, 0.09), Vec2::new(0.036, 0.05));
    body.frustum(trunk, shell, [(chest, 0.35), (shoulders, 0.425)]);
    body.frustum(trunk, shell, [(shoulders, 0.425), (collar, 0.452)]);
    body.frustum(trunk, joint, [(Vec2::splat(0.022), 0.44), (Vec2::splat(0.022), 0.475)]);
    // The button on the chest, and plates that carry the number.
    let button = Affine3A::from_mat3_translation(along_x(), Vec3::new(0.058, 0.0, 0.427));
    let shape = Shape::cylinder(0.011, 0.012);
    body.parts.push(Part { frame: trunk, label, colour: joint, shape, frame_from_shape: button });
    let mut plates = number::Plates::of_nao();
    plates.z_m = look.number_z_m.unwrap_or(plates.z_m);
    for (facing, is_there) in [(1.0, look.number.chest), (-1.0, look.number.back)] {
        if is_there {
            let middle = Vec3::new(facing * 0.057, 0.0, plates.z_m);
            body.cuboid(trunk, Colour(look.plates), Vec3::new(0.012, 0.088, 0.066), middle);
        }
    }
    number::write(&mut body, id.number, &plates);

    // Head: skull with a brow, eyes, cameras in forehead and chin, ears.
    let head = Limb::Head;
    let middle = Vec3::Z * 0.055;
    body.ellipsoid(head, shell, Vec3::new(0.057, 0.062, 0.0535), middle);
    body.ellipsoid(head, shell, Vec3::new(0.03, 0.05, 0.02), middle + Vec3::new(0.024, 0.0, 0.03));
    body.ball(head, joint, 0.0085, middle + Vec3::new(0.049, 0.0, 0.025));
    body.ball(head, joint, 0.0085, middle + Vec3::new(0.049, 0.0, -0.024));
    for side in 0..2 {
        let eye = on_side(Vec3::new(0.0445, 0.025, 0.004), side);
        body.ellipsoid(head, joint, Vec3::new(0.008, 0.0165, 0.0165), middle + eye);
        body.ellipsoid(head, Colour(look.eyes), Vec3::new(0.0105, 0.0115, 0.0115), middle + eye);
        let ear = Affine3A::from_mat3_translation(along_y(), middle + on_side(Vec3::new(-0.004, 0.057, 0.0), side));
        let shape = Shape::cylinder(0.031, 0.02);
        body.parts.push(Part { frame: head, label, colour: joint, shape, frame_from_shape: ear });
        body.ellipsoid(
            head,
            shell,
            Vec3::new(0.021, 0.006, 0.021),
            middle + on_side(Vec3::new(-0.004, 0.066, 0.0), side),
        );
    }

    for side in 0..2 {
        // Arms, bent at the elbows.
        let arm = Limb::ARMS[side];
        let elbow = on_side(Vec3::new(0.0, 0.022, -0.098), side);
        let wrist = on_side(Vec3::new(0.062, 0.012, -0.142), side);
        body.ball(arm, joint, 0.032, Vec3::ZERO);
        body.ellipsoid(arm, shell, Vec3::new(0.037, 0.034, 0.037), on_side(Vec3::new(0.0, 0.006, 0.002), side));
        body.rod(arm, shell, 0.025, [on_side(Vec3::new(0.0, 0.008, -0.02), side), elbow * 0.86]);
        body.ball(arm, joint, 0.025, elbow);
        body.rod(arm, shell, 0.0225, [elbow.lerp(wrist, 0.2), wrist]);
        let hand = wrist + on_side(Vec3::new(0.022, 0.0, -0.012), side);
        body.ball(arm, joint, 0.019, hand);
        for finger in [-1.0, 1.0] {
            let knuckle = hand + Vec3::new(0.01, finger * 0.009, 0.002);
            body.rod(arm, shell, 0.007, [knuckle, knuckle + Vec3::new(0.02, 0.0, -0.014)]);
        }

        // Legs: shells over the joints.
        let [thigh, shank, foot] = [Limb::THIGHS[side], Limb::SHANKS[side], Limb::FEET[side]];
        body.ball(thigh, joint, 0.034, Vec3::ZERO);
        body.frustum(thigh, shell, [(Vec2::new(0.033, 0.034), 0.018 - thigh_m), (Vec2::new(0.04, 0.0385), -0.012)]);
        body.ellipsoid(thigh, shell, Vec3::new(0.038, 0.037, 0.05), Vec3::new(0.006, 0.0, -0.05));
        body.ball(shank, joint, 0.031, Vec3::ZERO);
        body.ellipsoid(shank, shell, Vec3::new(0.026, 0.028, 0.03), Vec3::new(0.014, 0.0, 0.0));
        body.frustum(shank, shell, [(Vec2::new(0.031, 0.033), 0.022 - shank_m), (Vec2::new(0.037, 0.036), -0.02)]);
        body.ellipsoid(shank, shell, Vec3::new(0.036, 0.034, 0.05), Vec3::new(0.006, 0.0, -0.055));
        body.ball(foot, joint, 0.028, Vec3::ZERO);
        // The sole is 15 cm long and rounded in front and behind.
        let middle = on_side(Vec3::new(0.025, 0.003, 0.0), side);
        let (sole, height) = (-ankle_m, 0.034);
        body.cuboid(foot, shell, Vec3::new(0.09, 0.084, height), middle + Vec3::Z * (sole + height / 2.0));
        for (end, radius) in [(0.045, 0.042), (-0.045, 0.042)] {
            let shape = Shape::Frustum {
                bottom: Vec2::new(0.036, radius),
                top: Vec2::new(0.03, radius * 0.9),
                half_height: height / 2.0,
            };
            body.add(foot, shell, shape, middle + Vec3::new(end, 0.0, sole + height / 2.0));
        }
        body.ellipsoid(foot, shell, Vec3::new(0.058, 0.039, 0.022), middle + Vec3::Z * (sole + height - 0.004));
    }
    body.parts
}

fn simple(team: Team, measures: &Body) -> Vec<RobotPart> {
    let (Legs { thigh_m, shank_m, ankle_m, .. }, _) = limbs_of_nao(measures);
    let mut body = PartList::new(RobotId::new(team, 1), measures.look, 16);
    let [shell, joint] = body.colours();
    let band_size = (2.0 * measures.waistband.half_size_m).extend(measures.waistband.height());
    body.band(team, measures, Shape::Box { half_size: band_size / 2.0 });
    body.cuboid(Limb::Trunk, shell, Vec3::new(0.1, 0.15, 0.118), Vec3::Z * 0.409);
    body.cuboid(Limb::Head, shell, Vec3::new(0.1, 0.11, 0.105), Vec3::Z * 0.061);
    // The face is dark, so that front and back differ.
    body.cuboid(Limb::Head, joint, Vec3::new(0.01, 0.08, 0.04), Vec3::new(0.0475, 0.0, 0.065));
    for side in 0..2 {
        let arm = on_side(Vec3::new(0.0, 0.012, -0.07), side);
        body.cuboid(Limb::ARMS[side], shell, Vec3::new(0.05, 0.045, 0.17), arm);
        let thigh = Vec3::Z * (-thigh_m / 2.0);
        body.cuboid(Limb::THIGHS[side], joint, Vec3::new(0.07, 0.07, thigh_m), thigh);
        let shank = Vec3::Z * (-(shank_m + 0.01) / 2.0);
        body.cuboid(Limb::SHANKS[side], shell, Vec3::new(0.066, 0.066, shank_m + 0.01), shank);
        let height = 0.036;
        let foot = on_side(Vec3::new(0.025, 0.003, height / 2.0 - ankle_m), side);
        body.cuboid(Limb::FEET[side], shell, Vec3::new(0.15, 0.084, height), foot);
    }
    body.parts
}

/// Turns a shape's z axis to the front.
fn along_x() -> Mat3 {
    Mat3::from_quat(Quat::from_rotation_arc(Vec3::Z, Vec3::X))
}

/// Turns a shape's z axis to the left.
fn along_y() -> Mat3 {
    Mat3::from_quat(Quat::from_rotation_arc(Vec3::Z, Vec3::Y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::posing::JointAngles;

    /// The least and greatest height of a standing robot's parts, m.
    fn heights(design: RobotDesign, body: &Body) -> [f32; 2] {
        let limbs = JointAngles::default().world_from_limbs(body, Affine3A::IDENTITY);
        let mut range = [f32::MAX, f32::MIN];
        for part in design.parts(RobotId::new(Team::Blue, 3), body) {
            let place = limbs[part.frame as usize] * part.frame_from_shape;
            // How far the shape reaches along z of the robot frame.
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
        let look = Look { head: crate::robot::look::Top::Mast, ..Look::LIGHT };
        let wheeled = Body { legs: None, arms: None, look, ..Body::default() };
        for design in RobotDesign::BOTH {
            // Aldebaran: 573 mm.
            for body in [Body::default(), tall, wheeled] {
                let [sole, top] = heights(design, &body);
                assert!(sole.abs() < 1e-3 && (top - body.height_m).abs() < 0.006, "{design:?}: {sole} {top}");
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
        use crate::robot::look::{NumberPlaces, TeamLimbs, Top};

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
    fn numbers_are_on_chest_and_back() {
        let count = |number| RobotDesign::Nao.parts(RobotId::new(Team::Blue, number), &Body::default()).len();
        // A 1 has two segments, an 8 seven, each on chest and back.
        assert_eq!(count(8) - count(1), 2 * 5);
        assert_eq!(count(18) - count(8), 2 * 2);
    }
}

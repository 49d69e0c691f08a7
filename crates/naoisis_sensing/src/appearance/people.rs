//! People beside the pitch: the referee, two assistant referees and spectators. They are drawn, but neither collide nor are detected.

use bevy::math::{Affine3A, Mat3, Vec2, Vec3};

use super::Label;
use super::colours::{Colour, hsv};
use super::shapes::{Part, Shape};
use naoisis_core::geometry::{angle_of, unit};
use naoisis_core::pitch::Pitch;
use naoisis_core::random::RandomStream;

/// Distance of the referees from the carpet, m.
const REFEREE_M: f32 = 0.3;
/// The range of the distances of spectators from the carpet, m.
const SPECTATORS_M: [f32; 2] = [0.5, 2.5];
/// The black of the referees' clothes.
const BLACK: Colour = Colour([24, 24, 27]);

/// A standing person. Lengths in m, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Person {
    /// The point on the ground between the feet.
    pub place: Vec2,
    /// The direction of the face, rad.
    pub heading: f32,
    /// The height.
    pub height: f32,
    /// The colour of shirt and upper arms.
    pub shirt: Colour,
    /// The colour of the trousers.
    pub trousers: Colour,
    /// The colour of the hair.
    pub hair: Colour,
    /// The colour of head and lower arms.
    pub skin: Colour,
    /// The colour of the shoes.
    pub shoes: Colour,
    /// How much farther apart than the hips the feet are, on each side.
    pub spread: f32,
    /// How much the arms are bent, from 0 to 1.
    pub bent: f32,
}

impl Person {
    /// Draws a person of random height, posture and colours.
    pub fn draw(place: Vec2, heading: f32, stream: &mut RandomStream) -> Self {
        let height = 1.55 + 0.35 * stream.uniform();
        let [shirt, trousers, hair] = [0, 1, 2].map(|_| clothing(stream));
        let skin = hsv(18.0 + 12.0 * stream.uniform(), 0.3 + 0.3 * stream.uniform(), 0.35 + 0.6 * stream.uniform());
        let shoes = hsv(0.0, 0.0, stream.uniform());
        let spread = 0.05 + 0.08 * stream.uniform();
        let bent = 0.5 * stream.uniform();
        let (hair, skin, shoes) = (Colour(hair.0.map(|channel| channel / 3)), Colour(skin), Colour(shoes));
        Self { place, heading, height, shirt, trousers, hair, skin, shoes, spread, bent }
    }

    /// The parts of the person.
    pub fn parts(&self) -> Vec<Part<()>> {
        let &Self { place, heading, height, shirt, trousers, hair, skin, shoes, spread, bent } = self;
        let forward = unit(heading);
        let at = |ahead: f32, left: f32, up: f32| {
            (place + forward * ahead + forward.perp() * left).extend(up) * Vec3::new(1.0, 1.0, height)
        };
        let rod = |colour, radius, ends| Part::rod((), Label::Person, colour, radius, ends);
        let mut parts = Vec::with_capacity(12);
        for side in [-1.0, 1.0] {
            let hip = at(0.0, side * 0.09, 0.50);
            let foot = at(0.0, side * (0.09 + spread), 0.045);
            parts.push(rod(trousers, 0.075, [hip, foot]));
            parts.push(rod(shoes, 0.05, [foot.with_z(0.05), foot.with_z(0.05) + (0.14 * forward).extend(0.0)]));
            let shoulder = at(0.0, side * 0.19, 0.80);
            let elbow = at(0.02, side * 0.25, 0.62);
            let hand = at(0.05 + 0.2 * bent, side * (0.25 - 0.1 * bent), 0.47 + 0.18 * bent);
            parts.push(rod(shirt, 0.05, [shoulder, elbow]));
            parts.push(rod(skin, 0.04, [elbow, hand]));
        }
        let chest =
            Shape::Frustum { bottom: Vec2::new(0.12, 0.17), top: Vec2::new(0.12, 0.22), half_height: 0.17 * height };
        parts.push(turned(Label::Person, shirt, chest, at(0.0, 0.0, 0.65), heading));
        parts.push(rod(skin, 0.05, [at(0.0, 0.0, 0.82), at(0.0, 0.0, 0.87)]));
        let skull = Shape::Ellipsoid { radii: Vec3::new(0.1, 0.08, 0.12) };
        parts.push(turned(Label::Person, skin, skull, at(0.01, 0.0, 0.93), heading));
        let cap = Shape::Ellipsoid { radii: Vec3::new(0.1, 0.09, 0.09) };
        parts.push(turned(Label::Person, hair, cap, at(-0.015, 0.0, 0.957), heading));
        parts
    }
}

/// Draws a colour of clothes and other things beside a pitch. Most colours are dull.
pub fn clothing(stream: &mut RandomStream) -> Colour {
    let saturation = if stream.chance(0.3) { 0.9 } else { 0.3 };
    Colour(hsv(360.0 * stream.uniform(), saturation * stream.uniform(), 0.2 + 0.78 * stream.uniform()))
}

/// A part with its middle at `middle`, pitch frame, turned about the vertical axis by `heading`, rad.
pub fn turned(label: Label, colour: Colour, shape: Shape, middle: Vec3, heading: f32) -> Part<()> {
    let Vec2 { x: cos, y: sin } = unit(heading);
    let turn = Mat3::from_cols(Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0), Vec3::Z);
    let frame_from_shape = Affine3A::from_mat3_translation(turn, middle);
    Part { frame_from_shape, ..Part::at((), label, colour, shape, middle) }
}

/// The people beside a pitch, [as many](Pitch::people) as it has: first the referee beside the halfway line, then an assistant beside each
/// goal, all in black, then spectators around the carpet. They are the same in every match on this pitch.
pub fn people(pitch: &Pitch) -> Vec<Person> {
    let mut stream = RandomStream::for_match(0, "people beside the pitch");
    let half = pitch.carpet_half_extents();
    let (beside, aside) = (half + REFEREE_M, 0.6 * pitch.half_width());
    let referees = [Vec2::new(0.0, beside.y), Vec2::new(-beside.x, -aside), Vec2::new(beside.x, aside)];
    let spectators = usize::from(pitch.people).saturating_sub(referees.len());
    let mut people = Vec::with_capacity(usize::from(pitch.people));
    for place in referees.into_iter().take(usize::from(pitch.people)) {
        let person = Person::draw(place, angle_of(-place), &mut stream);
        people.push(Person { shirt: BLACK, trousers: BLACK, ..person });
    }
    for number in 0..spectators {
        let share = (number as f32 + stream.uniform()) / spectators as f32;
        let (edge, out) = on_edge(half, share);
        let place = edge + out * (SPECTATORS_M[0] + (SPECTATORS_M[1] - SPECTATORS_M[0]) * stream.uniform());
        let heading = angle_of(-place) + stream.gaussian(0.4);
        people.push(Person::draw(place, heading, &mut stream));
    }
    people
}

/// The point at a share of the way around a rectangle with these half extents, and the direction away from the rectangle there.
fn on_edge(half: Vec2, share: f32) -> (Vec2, Vec2) {
    let sides = [(Vec2::NEG_Y, Vec2::X), (Vec2::X, Vec2::Y), (Vec2::Y, Vec2::NEG_X), (Vec2::NEG_X, Vec2::NEG_Y)];
    let mut left = share * 4.0 * (half.x + half.y);
    for (out, along) in sides {
        let reach = (half * along).abs().element_sum();
        if left <= 2.0 * reach {
            return (out * half + along * (left - reach), out);
        }
        left -= 2.0 * reach;
    }
    (half * Vec2::new(-1.0, -1.0), Vec2::NEG_X)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_stand_beside_the_carpet_on_the_ground_and_face_the_pitch() {
        let pitch = Pitch { people: 40, ..Pitch::default() };
        let half = pitch.carpet_half_extents();
        let all = people(&pitch);
        assert_eq!(all.len(), 40);
        for person in &all {
            let Person { place, heading, .. } = *person;
            assert!(place.x.abs() > half.x + 0.25 || place.y.abs() > half.y + 0.25, "{place}");
            assert!(unit(heading).dot(-place) > 0.0, "{place} {heading}");
            let heights = person.parts().into_iter().map(|part| part.frame_from_shape.translation.z);
            assert!(heights.clone().fold(0.0, f32::max) < 1.9 && heights.fold(2.0, f32::min) < 0.1);
        }
        // The referee stands beside the halfway line, and there are people on all sides.
        assert_eq!((all[0].place.x, all[0].shirt), (0.0, BLACK));
        for out in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
            assert!(all.iter().any(|person| person.place.dot(out) > (half * out).length()), "{out}");
        }
        assert!(people(&Pitch::default()).is_empty());
        assert_eq!(people(&Pitch { people: 2, ..Pitch::default() }), all[..2]);
    }
}

//! Draws the surroundings of a pitch: walls, tables, banners, poles, bags, and people.

use bevy::math::{Vec2, Vec3};

use super::looks::MatchLooks;
use naoisis_core::geometry::{angle_of, to_radians, unit};
use naoisis_core::pitch::Pitch;
use naoisis_core::random::RandomStream;
use naoisis_sensing::appearance::Label;
use naoisis_sensing::appearance::people::{Person, clothing, turned};
use naoisis_sensing::appearance::shapes::{Part, Shape};

/// Draws a place beside the carpet (m, pitch frame). Returns it with the direction away from the pitch.
fn place_beside(pitch: &Pitch, looks: &MatchLooks, stream: &mut RandomStream) -> (Vec2, Vec2) {
    let half = pitch.carpet_half_extents();
    let beyond = looks.beyond_m.draw(stream);
    let along = stream.uniform() * (half.x + half.y);
    let sign = |stream: &mut RandomStream| if stream.chance(0.5) { 1.0 } else { -1.0 };
    let side = sign(stream);
    if along < half.x {
        let x = (2.0 * stream.uniform() - 1.0) * half.x;
        (Vec2::new(x, side * (half.y + beyond)), Vec2::Y * side)
    } else {
        let y = (2.0 * stream.uniform() - 1.0) * half.y;
        (Vec2::new(side * (half.x + beyond), y), Vec2::X * side)
    }
}

/// Draws the things beside a pitch.
pub fn things(pitch: &Pitch, looks: &MatchLooks, stream: &mut RandomStream) -> Vec<Part<()>> {
    let mut parts = Vec::new();
    for _ in 0..looks.things {
        let (place, out) = place_beside(pitch, looks, stream);
        let colour = clothing(stream);
        let heading = angle_of(out) + to_radians(20.0 * (stream.uniform() - 0.5));
        let mut between = |least: f32, most: f32| least + (most - least) * stream.uniform();
        let mut add = |shape, middle, heading| parts.push(turned(Label::Clutter, colour, shape, middle, heading));
        let cuboid = |size: Vec3| Shape::Box { half_size: size / 2.0 };
        match between(0.0, 6.0) as u32 {
            // A banner along the side of the pitch.
            0 => {
                let size = Vec3::new(0.05, between(1.0, 4.0), between(0.4, 1.1));
                add(cuboid(size), place.extend(size.z / 2.0), heading);
            }
            // A table: a top on two ends.
            1 => {
                let size = Vec3::new(between(0.5, 0.9), between(1.0, 2.2), between(0.65, 0.8));
                let along = unit(heading).perp();
                add(cuboid(size.with_z(0.04)), place.extend(size.z), heading);
                for side in [-0.46, 0.46] {
                    let middle = place + along * (side * size.y);
                    add(cuboid(Vec3::new(size.x * 0.9, 0.04, size.z)), middle.extend(size.z / 2.0), heading);
                }
            }
            // A pole, or the leg of a tripod.
            2 => {
                let height = between(0.8, 2.6);
                add(Shape::cylinder(between(0.015, 0.06), height), place.extend(height / 2.0), 0.0);
            }
            // A ball-shaped bag.
            3 => {
                let radii = Vec3::new(between(0.1, 0.3), between(0.15, 0.4), between(0.1, 0.25));
                add(Shape::Ellipsoid { radii }, place.extend(radii.z), heading);
            }
            // A wall or a large screen.
            4 => {
                let size = Vec3::new(0.1, between(2.0, 6.0), between(1.2, 3.0));
                add(cuboid(size), (place + out * between(0.5, 3.0)).extend(size.z / 2.0), heading);
            }
            // A box or a chair.
            _ => {
                let size = Vec3::new(between(0.2, 0.6), between(0.2, 0.8), between(0.2, 1.0));
                add(cuboid(size), place.extend(size.z / 2.0), heading + between(-0.5, 0.5));
            }
        }
    }
    parts
}

/// Draws the people beside a pitch: the parts of each, and where they stand.
pub fn people(pitch: &Pitch, looks: &MatchLooks, stream: &mut RandomStream) -> Vec<(Vec2, Vec<Part<()>>)> {
    (0..looks.people)
        .map(|_| {
            let (place, out) = place_beside(pitch, looks, stream);
            // Most people look at the match.
            let heading = angle_of(-out) + stream.gaussian(0.6);
            (place, Person::draw(place, heading, stream).parts())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::ranges::Ranges;
    use naoisis_core::pitch::GoalColour;

    #[test]
    fn things_and_people_are_beside_the_carpet_and_stand_on_the_ground() {
        let mut stream = RandomStream::for_match(3, "test");
        let ranges = Ranges::read(None).unwrap();
        let looks = MatchLooks::draw(&ranges, [GoalColour::White; 2], &mut stream);
        let looks = MatchLooks { things: 100, people: 20, ..looks };
        let pitch = Pitch::default();
        let half = pitch.carpet_half_extents();
        for (place, parts) in people(&pitch, &looks, &mut stream) {
            assert!(place.x.abs() > half.x || place.y.abs() > half.y, "{place}");
            let tops = parts.iter().map(|part| part.frame_from_shape.translation.z);
            assert!(tops.clone().fold(0.0, f32::max) < 1.9 && tops.fold(2.0, f32::min) < 0.1);
        }
        for part in things(&pitch, &looks, &mut stream) {
            let place = part.frame_from_shape.translation;
            assert!(place.x.abs() > half.x || place.y.abs() > half.y, "{place}");
            assert!(place.z > 0.0 && place.z < 3.0);
        }
    }
}

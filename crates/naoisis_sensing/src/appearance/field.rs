//! The appearance of the pitch: the markings on the ground, the frames and nets of the goals, and posts.

use bevy::math::{Vec2, Vec3};

use super::Label;
use super::colours::{self, Colour};
use super::shapes::{Part, Shape};
use naoisis_core::pitch::{End, GoalColour, GoalDimensions, LineSegment, Pitch, Post};

/// The width of the meshes of nets, m.
const NET_MESH_M: f32 = 0.08;

/// The thickness of the strings of nets, m.
pub const STRING_M: f32 = 0.004;

/// A flat shape on the ground, m, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum GroundShape {
    /// A quadrilateral with these corners, counter-clockwise from above.
    Quadrilateral([Vec2; 4]),
    /// The area between two concentric circles.
    Ring {
        /// The centre, m, pitch frame.
        centre: Vec2,
        /// Radius of the inner circle, m.
        inner: f32,
        /// Radius of the outer circle, m.
        outer: f32,
    },
}

/// A flat marking on the ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct GroundMark {
    /// Its label.
    pub label: Label,
    /// Its colour.
    pub colour: Colour,
    /// Its shape and place.
    pub shape: GroundShape,
}

/// The number of straight pieces of a corner arc.
const CORNER_PIECES: usize = 8;

/// The carpet and its markings, from the bottom up.
pub fn ground(pitch: &Pitch) -> Vec<GroundMark> {
    let half = pitch.line_width_m / 2.0;
    let Vec2 { x, y } = pitch.carpet_half_extents();
    let carpet = [Vec2::new(-x, -y), Vec2::new(x, -y), Vec2::new(x, y), Vec2::new(-x, y)];
    let shape = GroundShape::Quadrilateral(carpet);
    let mut marks = vec![GroundMark { label: Label::Carpet, colour: colours::CARPET, shape }];
    let mut paint = |shape| marks.push(GroundMark { label: Label::Line, colour: colours::CHALK, shape });
    let radius = pitch.centre_circle_diameter_m / 2.0;
    if radius > half {
        paint(GroundShape::Ring { centre: Vec2::ZERO, inner: radius - half, outer: radius + half });
    }
    for segment in pitch.line_segments() {
        paint(strip(segment, half));
    }
    for segment in pitch.corner_arc_pieces(CORNER_PIECES) {
        paint(strip(segment, half));
    }
    for mark in pitch.marks() {
        let reach = pitch.penalty_mark_size_m / 2.0;
        for along in [Vec2::X, Vec2::Y] {
            // The strip adds half a line's width at each end.
            let end = along * (reach - half).max(0.0);
            paint(strip(LineSegment { start: mark - end, end: mark + end }, half));
        }
    }
    marks
}

/// The quadrilateral of a line with this half width. It is extended by `half_width` beyond both ends, so that corners are full.
fn strip(segment: LineSegment, half_width: f32) -> GroundShape {
    let along = (segment.end - segment.start).normalize_or(Vec2::X) * half_width;
    let aside = along.perp();
    let (start, end) = (segment.start - along, segment.end + along);
    GroundShape::Quadrilateral([start - aside, end - aside, end + aside, start + aside])
}

/// The label of a goal with this colour.
pub const fn goal_label(colour: GoalColour) -> Label {
    match colour {
        GoalColour::Yellow => Label::YellowGoal,
        GoalColour::Blue => Label::BlueGoal,
        GoalColour::White => Label::WhiteGoal,
    }
}

/// The part for a post at `position`, pitch frame.
pub fn post(post: &Post, position: Vec2) -> Part<()> {
    let (label, colour) = match post.colour {
        Some(colour) => (goal_label(colour), colours::goal(colour)),
        None => (Label::Post, colours::EXTRA_POST),
    };
    let centre = position.extend(post.height / 2.0);
    Part::at((), label, colour, Shape::cylinder(post.radius, post.height), centre)
}

/// The corners of a goal's frame, m, pitch frame: the ends of the crossbar, and of the rear bar on the ground, -y first.
fn goal_corners(pitch: &Pitch, end: End) -> ([Vec3; 2], [Vec3; 2]) {
    let GoalDimensions { width_m, height_m, depth_m, bar_diameter_m, .. } = pitch.goal;
    let front = end.sign() * pitch.goal_post_x();
    let rear = end.sign() * (pitch.goal_post_x() + depth_m);
    let half_bar = bar_diameter_m / 2.0;
    let bar = [-0.5, 0.5].map(|side| Vec3::new(front, side * width_m, height_m - half_bar));
    let ground = [-0.5, 0.5].map(|side| Vec3::new(rear, side * width_m, half_bar));
    (bar, ground)
}

/// The crossbar of a goal in its colour, and the white frame of its net, without the posts.
pub fn goal_frame(pitch: &Pitch, end: End) -> Vec<Part<()>> {
    let (bar, ground) = goal_corners(pitch, end);
    let radius = pitch.goal.bar_diameter_m / 2.0;
    let colour = pitch.goal_colour(end);
    let mut parts = vec![Part::pipe((), goal_label(colour), colours::goal(colour), radius, bar)];
    let mut white = |radius, ends| parts.push(Part::rod((), Label::GoalFrame, colours::NET, radius, ends));
    white(radius * 0.8, ground);
    for side in 0..2 {
        white(radius * 0.8, [bar[side].with_z(ground[side].z), ground[side]]);
        white(radius * 0.4, [bar[side], ground[side]]);
    }
    parts
}

/// The faces of a goal's net, m, pitch frame. In a triangular face, two corners are equal.
fn net_panels(pitch: &Pitch, end: End) -> [[Vec3; 4]; 3] {
    let (bar, ground) = goal_corners(pitch, end);
    let foot = |bar_end: Vec3| bar_end.with_z(0.0);
    [
        [bar[0], bar[1], ground[1], ground[0]],
        [bar[0], bar[0], ground[0], foot(bar[0])],
        [bar[1], bar[1], ground[1], foot(bar[1])],
    ]
}

/// The ends of the strings of a goal's net, m, pitch frame.
pub fn net_strings(pitch: &Pitch, end: End) -> Vec<[Vec3; 2]> {
    let mut strings = Vec::new();
    for [a, b, c, d] in net_panels(pitch, end) {
        let across = (a.distance(b).max(c.distance(d)) / NET_MESH_M).round().max(1.0) as u32;
        let down = (b.distance(c).max(d.distance(a)) / NET_MESH_M).round().max(1.0) as u32;
        for step in 0..=across {
            let share = step as f32 / across as f32;
            strings.push([a.lerp(b, share), d.lerp(c, share)]);
        }
        for step in 0..=down {
            let share = step as f32 / down as f32;
            strings.push([a.lerp(d, share), b.lerp(c, share)]);
        }
    }
    strings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadrilaterals_run_counter_clockwise() {
        for mark in ground(&Pitch::default()) {
            let GroundShape::Quadrilateral([a, b, c, d]) = mark.shape else { continue };
            for [a, b, c] in [[a, b, c], [b, c, d], [c, d, a]] {
                assert!((b - a).perp_dot(c - b) > 0.0);
            }
        }
    }

    #[test]
    fn a_line_covers_its_corners() {
        let line = strip(LineSegment { start: Vec2::ZERO, end: Vec2::X }, 0.1);
        let GroundShape::Quadrilateral([a, b, ..]) = line else { panic!() };
        assert_eq!([a, b], [Vec2::new(-0.1, -0.1), Vec2::new(1.1, -0.1)]);
    }

    #[test]
    fn nets_hang_between_bar_and_ground_behind_the_posts() {
        let pitch = Pitch::default();
        for end in End::BOTH {
            for corner in net_strings(&pitch, end).into_iter().flatten() {
                assert!(end.sign() * corner.x >= pitch.goal_post_x() - 1e-6);
                assert!((0.0..=pitch.goal.height_m).contains(&corner.z));
            }
        }
    }

    #[test]
    fn the_bars_top_is_as_high_as_the_goal() {
        let pitch = Pitch::default();
        let bar = goal_frame(&pitch, End::PositiveX)[0];
        let Shape::Frustum { top, .. } = bar.shape else { panic!() };
        assert!((bar.frame_from_shape.translation.z + top.x - pitch.goal.height_m).abs() < 1e-6);
        assert_eq!(bar.label, Label::YellowGoal);
    }
}

//! Robots in black, white, grey and brown jerseys, detected as bodies on the field.
//!
//! Limbs, lines, goals, footballs and the floor have these colours, too. So such a robot is not a blob of one colour but a place where a whole
//! body fits: a trunk of the right size in the jersey's colour, other colours beside and below it, and legs that end on the carpet.

use bevy::math::Vec2;

use super::Look;
use super::colour::ColourClass;
use super::robots::class_of;
use crate::sensing::vision::{GoalPostPercept, RobotPercept};
use naoisis_core::robot::body::Waistband;
use naoisis_core::team::{PerTeam, Team};

/// The least height and half width of a trunk, pixels, and its least share in the image.
const LEAST_SIZE: f32 = 3.0;
const LEAST_HALF_WIDTH: f32 = 1.5;
const LEAST_IN_IMAGE: f32 = 0.4;

/// The columns of the parts of a body, in half widths of the trunk: the trunk without its edges, which arms hide; an arm; the background beside
/// the arms; the legs; and the whole body.
const TRUNK: f32 = 0.8;
const ARM: [f32; 2] = [0.9, 1.7];
const BACKGROUND: [f32; 2] = [1.7, 2.5];
const LEGS: f32 = 0.7;
const BODY: f32 = 1.9;
/// The height of the strips above and below the trunk, as a share of the trunk's.
const ENDS: f32 = 0.25;
/// The strip of carpet in front of the feet: its distance from the robot's middle, m.
const BEFORE_FEET_M: [f32; 2] = [0.08, 0.5];

/// The strips of carpet beside the feet: how much nearer than the robot's middle their far and near ends are, m.
const BESIDE_FEET_M: [f32; 2] = [-0.6, 0.1];
/// The least share of carpet in one of these strips, and the least amount by which it is greater than that between the feet.
const LEAST_CARPET: f32 = 0.7;
const MORE_CARPET: f32 = 0.3;
/// The least share of carpet at the lower edge of the image, beside a robot with its feet below the image.
const LEAST_CARPET_ABOVE_FEET: f32 = 0.5;

/// The least share of the jersey's colour in the trunk.
const LEAST_INSIDE: f32 = 0.35;
/// The least amount by which that share is greater than the shares beside the trunk, and above or below it.
const LEAST_BESIDE: f32 = 0.3;
const LEAST_END: f32 = 0.2;
/// The greatest share of carpet between the legs.
const MOST_CARPET: f32 = 0.5;
/// The least amount by which the share of carpet in front of the feet is greater; also the amount that counts if the feet are below the image.
const LEAST_BEFORE: f32 = 0.2;
/// The least mean of the share in the trunk and these three amounts.
const LEAST_FIT: f32 = 0.5;

/// The distance from one hypothesis to the next, as shares of the trunk's half width and height.
const STEP: Vec2 = Vec2::new(0.34, 0.1);
/// The shares of that distance by which the best hypotheses are moved.
const REFINEMENTS: [f32; 3] = [0.5, 0.25, 0.125];

/// The distance at which a trunk is another robot than one that was found: m, plus a share of the robot's distance.
const APART: [f32; 2] = [0.15, 0.1];
/// The distance beside a white post within which there are no white robots, as a multiple of the half widths of both.
const BESIDE_POST: f32 = 1.5;

/// The index of the carpet among the counted classes, after those of the teams' jerseys.
const CARPET: usize = 2;

/// Memory for the search in one image.
#[derive(Default)]
pub(super) struct Bodies {
    /// The numbers of pixels of each counted class above and to the left of each corner of pixels.
    sums: Vec<[u32; 3]>,
    size: [usize; 2],
    trunks: Vec<Trunk>,
}

/// The trunk of a robot that may be in the image.
#[derive(Clone, Copy, Debug)]
struct Trunk {
    team: Team,
    band: Waistband,
    /// The middle of its lower edge, pixels.
    pixel: Vec2,
    /// Half its width, and its height, pixels.
    size: Vec2,
    position_m: Vec2,
    /// How well a body fits, at most 1.
    fit: f32,
}

impl Trunk {
    /// The columns at these distances from its middle, in half widths.
    fn columns(&self, [from, to]: [f32; 2]) -> [f32; 2] {
        [from, to].map(|halves| self.pixel.x + halves * self.size.x)
    }
}

impl Bodies {
    /// Counts the pixels of an image in the classes of the jerseys and of the carpet.
    fn count(&mut self, look: &Look<'_>, jerseys: PerTeam<Option<ColourClass>>) {
        let classes = [jerseys.blue, jerseys.pink, Some(ColourClass::Green)];
        self.size = [look.width(), look.height()];
        let columns = look.width() + 1;
        self.sums.clear();
        self.sums.resize(columns, [0; 3]);
        for row in look.segmentation.classes.chunks_exact(look.width()) {
            let above = self.sums.len() - columns;
            let mut in_row = [0; 3];
            self.sums.push(in_row);
            for (column, class) in row.iter().enumerate() {
                let upper = self.sums[above + column + 1];
                in_row = core::array::from_fn(|index| in_row[index] + u32::from(classes[index] == Some(*class)));
                self.sums.push(core::array::from_fn(|index| upper[index] + in_row[index]));
            }
        }
    }

    /// The number of pixels between these columns and rows of the image, and the share of a class among them.
    fn share(&self, columns: [f32; 2], rows: [f32; 2], class: usize) -> (f32, f32) {
        let whole = |ends: [f32; 2], most: usize| ends.map(|end| ((end.max(0.0) + 0.5) as usize).min(most));
        let ([left, right], [top, bottom]) = (whole(columns, self.size[0]), whole(rows, self.size[1]));
        if left >= right || top >= bottom {
            return (0.0, 0.0);
        }
        let at = |row: usize, column: usize| self.sums[row * (self.size[0] + 1) + column][class];
        let pixels = ((right - left) * (bottom - top)) as f32;
        let count = at(bottom, right) + at(top, left) - at(top, right) - at(bottom, left);
        (pixels, count as f32 / pixels)
    }
}

impl Look<'_> {
    /// Finds robots whose jerseys have no hue, and whether the lower edges of their jerseys are in the image. `posts` and the robots in `found`
    /// were detected before.
    pub(super) fn find_bodies(
        &self,
        posts: &[(bool, GoalPostPercept)],
        bodies: &mut Bodies,
        found: &mut Vec<(bool, RobotPercept)>,
    ) {
        let jerseys = PerTeam::new(|team| class_of(team, self.model.jerseys[team]).filter(|class| !class.is_cue()));
        if Team::BOTH.into_iter().all(|team| jerseys[team].is_none()) {
            return;
        }
        bodies.count(self, jerseys);
        let mut trunks = core::mem::take(&mut bodies.trunks);
        trunks.clear();
        for team in Team::BOTH.into_iter().filter(|team| jerseys[*team].is_some()) {
            for band in &self.model.waistbands[team] {
                self.collect_trunks(team, band, bodies, &mut trunks);
            }
        }
        trunks.sort_by(|one, other| other.fit.total_cmp(&one.fit));
        for trunk in &trunks {
            let is_post = jerseys[trunk.team] == Some(ColourClass::White)
                && posts.iter().any(|(_, post)| self.is_part_of_post(trunk, post));
            if is_post || found.iter().any(|(_, robot)| self.is_part_of_robot(trunk, robot)) {
                continue;
            }
            let Trunk { team, position_m, pixel, .. } = self.refine(*trunk, bodies);
            let foot = self.view.project_anywhere(position_m.extend(0.0));
            let has_lower_edge = pixel.y < self.height() as f32;
            found.push((has_lower_edge, self.robot_percept(team, foot, position_m)));
        }
        bodies.trunks = trunks;
    }

    /// Collects the trunks of robots of `team` with this `band` that may be in the image.
    fn collect_trunks(&self, team: Team, band: &Waistband, bodies: &Bodies, trunks: &mut Vec<Trunk>) {
        let [width, height] = bodies.size.map(|size| size as f32);
        let mut v = 1.0;
        // The lower part of a near trunk may be below the image.
        while v < 1.5 * height {
            let middle = self.trunk(team, band, Vec2::new(width / 2.0, v));
            let Some(Trunk { size, .. }) = middle.filter(|trunk| trunk.size.x >= LEAST_HALF_WIDTH) else {
                v += 1.0;
                continue;
            };
            let step = (STEP * size).max(Vec2::ONE);
            let mut u = 0.0;
            while v - size.y < height && u < width {
                let trunk = self.trunk(team, band, Vec2::new(u, v));
                trunks.extend(trunk.and_then(|trunk| self.fitted(trunk, bodies)));
                u += step.x;
            }
            v += step.y;
        }
    }

    /// The trunk with the middle of its lower edge at `pixel`, with a fit of zero.
    fn trunk(&self, team: Team, band: &Waistband, pixel: Vec2) -> Option<Trunk> {
        let [low_z, high_z] = band.z_m;
        let front = self.place(pixel, low_z)?;
        // The surface of the jersey is in front of the robot's middle.
        let position_m = front + front.normalize_or(Vec2::X) * ((band.half_size_m.x + band.half_size_m.y) / 2.0);
        let height = pixel.y - self.view.project(front.extend(high_z))?.y;
        let size = Vec2::new(self.half_width(position_m, band), height);
        (height > LEAST_SIZE).then_some(Trunk { team, band: *band, pixel, size, position_m, fit: 0.0 })
    }

    /// Half the width of a trunk at `place` in the image, pixels.
    fn half_width(&self, place: Vec2, band: &Waistband) -> f32 {
        self.view.intrinsics.focal.x * band.half_size_m.y / self.depth(place, band.z_m[0]).max(0.1)
    }

    /// The trunk with its fit, if a robot may stand there.
    fn fitted(&self, trunk: Trunk, bodies: &Bodies) -> Option<Trunk> {
        let Trunk { team, pixel, size, position_m, .. } = trunk;
        let rows = [pixel.y - size.y, pixel.y];
        let jersey = |columns: [f32; 2], rows: [f32; 2]| bodies.share(trunk.columns(columns), rows, team as usize);
        let (pixels, inside) = jersey([-TRUNK, TRUNK], rows);
        if inside < LEAST_INSIDE || pixels < LEAST_IN_IMAGE * 2.0 * TRUNK * size.x * size.y {
            return None;
        }
        // Either the arms or the background may have the jersey's colour.
        let on_side = |mirror: fn([f32; 2]) -> [f32; 2]| {
            let [(_, arm), (_, background)] = [ARM, BACKGROUND].map(|columns| jersey(mirror(columns), rows));
            arm.min(background)
        };
        let beside = inside - on_side(|columns| columns).max(on_side(|[from, to]| [-to, -from]));
        let (pixels_above, head) = jersey([-TRUNK, TRUNK], [rows[0] - ENDS * size.y, rows[0]]);
        let above = if pixels_above > 0.0 { inside - head } else { 0.0 };
        let below = inside - jersey([-TRUNK, TRUNK], [pixel.y, pixel.y + ENDS * size.y]).1;
        // Dark hips may lengthen a black jersey; the head is above it.
        let at_end = below.max(f32::midpoint(below, above));
        let row_of = |nearer_m: f32| {
            let place = position_m - position_m.normalize_or(Vec2::X) * nearer_m;
            self.view.project_anywhere(place.extend(0.0)).y
        };
        let (_, in_legs) = bodies.share(trunk.columns([-LEGS, LEGS]), [pixel.y, row_of(0.0)], CARPET);
        let (pixels_before, carpet) = bodies.share(trunk.columns([-1.0, 1.0]), BEFORE_FEET_M.map(row_of), CARPET);
        let before = if pixels_before > 0.0 { carpet - in_legs } else { LEAST_BEFORE };
        let is_body = beside >= LEAST_BESIDE && at_end >= LEAST_END && before >= LEAST_BEFORE && in_legs <= MOST_CARPET;
        let fit = (inside + beside + at_end + before) / 4.0;
        (is_body && fit >= LEAST_FIT && self.is_on_carpet(&trunk, bodies, row_of)).then_some(Trunk { fit, ..trunk })
    }

    /// Whether there is carpet beside the feet of a robot with this trunk, more than between them. People and other things beside the pitch
    /// stand on the floor. `row_of`: the row of a point on the ground this much nearer than the robot's middle, m.
    fn is_on_carpet(&self, trunk: &Trunk, bodies: &Bodies, row_of: impl Fn(f32) -> f32) -> bool {
        let height = self.height() as f32;
        let mut rows = BESIDE_FEET_M.map(row_of);
        let has_feet = rows[0] < height;
        if !has_feet {
            rows = [height - ENDS * trunk.size.y, height];
        }
        let carpet = |columns: [f32; 2]| bodies.share(trunk.columns(columns), rows, CARPET);
        let [from, to] = BACKGROUND;
        let beside = [[from, to], [-to, -from]].map(carpet);
        let most = beside.into_iter().map(|(_, share)| share).fold(0.0, f32::max);
        let (_, between) = carpet([-LEGS, LEGS]);
        most >= if has_feet { LEAST_CARPET.max(between + MORE_CARPET) } else { LEAST_CARPET_ABOVE_FEET }
    }

    /// The trunk near another that fits best.
    fn refine(&self, trunk: Trunk, bodies: &Bodies) -> Trunk {
        let mut best = trunk;
        for share in REFINEMENTS {
            let step = (share * STEP * best.size).max(Vec2::splat(0.5));
            let middle = best.pixel;
            for direction in [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y] {
                let moved = self.trunk(best.team, &best.band, middle + step * direction);
                let moved = moved.and_then(|trunk| self.fitted(trunk, bodies));
                best = moved.filter(|moved| moved.fit > best.fit).unwrap_or(best);
            }
        }
        best
    }

    /// Whether a trunk belongs to a robot that was found, or is in front of or behind its body in the image.
    fn is_part_of_robot(&self, trunk: &Trunk, robot: &RobotPercept) -> bool {
        let place = robot.position_m;
        if trunk.position_m.distance(place) < APART[0] + APART[1] * place.length() {
            return true;
        }
        let middle = trunk.pixel - Vec2::Y * (trunk.size.y / 2.0);
        self.model.waistbands[robot.team].iter().any(|band| {
            // The head ends about as far above the trunk as the trunk is high.
            let top = self.view.project_anywhere(place.extend(2.0 * band.z_m[1] - band.z_m[0]));
            let foot = self.view.project_anywhere(place.extend(0.0));
            let aside = (middle.x - f32::midpoint(top.x, foot.x)).abs();
            (top.y..foot.y).contains(&middle.y) && aside < BODY * self.half_width(place, band)
        })
    }

    /// Whether a trunk may be a piece of a white goal post.
    fn is_part_of_post(&self, trunk: &Trunk, post: &GoalPostPercept) -> bool {
        let aside = post.position_m.normalize_or(Vec2::X).perp_dot(trunk.position_m).abs();
        let is_behind = trunk.position_m.length() > post.position_m.length();
        is_behind && aside < BESIDE_POST * (self.model.post_radius + trunk.band.half_size_m.y)
    }
}

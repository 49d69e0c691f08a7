//! Traces the outlines of areas of pixels as polygons.

use bevy::math::Vec2;

/// Distance between a polygon and the pixel edges at most, pixels. It straightens the steps of slanted edges.
const TOLERANCE_PX: f32 = 0.75;
/// Area below which holes are filled, pixels.
const LEAST_HOLE_PX: f32 = 6.0;

/// The corners of a closed polygon, pixels.
pub type Polygon = Vec<Vec2>;

/// Returns the polygons around the pixels for which `is_inside`, in a window that begins at pixel `corner`. A hole is joined to the polygon
/// around it by a cut without width.
pub fn polygons(corner: [usize; 2], size: [usize; 2], is_inside: impl Fn(usize, usize) -> bool) -> Vec<Polygon> {
    let rings = rings(size, |u, v| is_inside(corner[0] + u, corner[1] + v));
    let shift = Vec2::new(corner[0] as f32, corner[1] as f32);
    let mut outer: Vec<(Polygon, Polygon)> = Vec::new();
    let mut holes = Vec::new();
    for ring in rings {
        let area = area(&ring);
        let simple: Polygon = simplified(&ring).into_iter().map(|point| point + shift).collect();
        if area > 0.0 {
            outer.push((ring, simple));
        } else if -area >= LEAST_HOLE_PX {
            holes.push((ring, simple));
        }
    }
    for (ring, hole) in holes {
        // A point beside an edge of the hole, inside the area.
        let [a, b] = [ring[0], ring[1]];
        let beside = (a + b) / 2.0 + (b - a).normalize_or_zero().perp() * 0.25;
        let around = outer.iter_mut().filter(|(whole, _)| contains(whole, beside));
        if let Some((_, simple)) = around.min_by(|(a, _), (b, _)| area(a).total_cmp(&area(b))) {
            *simple = joined(simple, &hole);
        }
    }
    outer.into_iter().map(|(_, simple)| simple).collect()
}

/// Joins polygons to one by cuts without width, beginning with the largest. Returns `None` if there are none.
pub fn one_polygon(polygons: &[Polygon]) -> Option<Polygon> {
    let mut polygons: Vec<&Polygon> = polygons.iter().collect();
    polygons.sort_by(|a, b| area(b).abs().total_cmp(&area(a).abs()));
    let (first, rest) = polygons.split_first()?;
    Some(rest.iter().fold((*first).clone(), |whole, other| joined(&whole, other)))
}

/// Returns the rings along the edges of pixels: around an area with a positive [`area`], around a hole with a negative one.
fn rings([width, height]: [usize; 2], is_inside: impl Fn(usize, usize) -> bool) -> Vec<Polygon> {
    /// Steps to the right, down, to the left, up.
    const STEPS: [[isize; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

    let across = width + 1;
    // The edges that leave each pixel corner: a bit for each direction.
    let mut edges = vec![0_u8; across * (height + 1)];
    for v in 0..height {
        for u in 0..width {
            if !is_inside(u, v) {
                continue;
            }
            let is_open = |u: isize, v: isize| {
                let is_within = u >= 0 && v >= 0 && (u as usize) < width && (v as usize) < height;
                !is_within || !is_inside(u as usize, v as usize)
            };
            let (column, row) = (u as isize, v as isize);
            // The sides of the pixel from its top edge on: where the edge begins, and the direction of the neighbouring pixel.
            let sides =
                [[u, v], [u + 1, v], [u + 1, v + 1], [u, v + 1]].into_iter().zip([[0, -1], [1, 0], [0, 1], [-1, 0]]);
            for (direction, (start, [right, down])) in sides.enumerate() {
                if is_open(column + right, row + down) {
                    edges[start[1] * across + start[0]] |= 1 << direction;
                }
            }
        }
    }
    let mut rings = Vec::new();
    for first in 0..edges.len() {
        while edges[first] != 0 {
            let mut ring = Polygon::new();
            let (mut place, mut direction) = (first, edges[first].trailing_zeros() as usize);
            loop {
                edges[place] &= !(1 << direction);
                ring.push(Vec2::new((place % across) as f32, (place / across) as f32));
                let [right, down] = STEPS[direction];
                place = (place as isize + down * across as isize + right) as usize;
                // Turn left first, so that pixels that touch at a corner belong together.
                let next = [3, 0, 1]
                    .map(|turn| (direction + turn) % 4)
                    .into_iter()
                    .find(|next| edges[place] & (1 << next) != 0);
                let Some(next) = next else { break };
                direction = next;
            }
            rings.push(ring);
        }
    }
    rings
}

/// Returns the area of a polygon, square pixels: positive if it runs clockwise as seen in the image.
pub fn area(polygon: &[Vec2]) -> f32 {
    let next = polygon.iter().cycle().skip(1);
    polygon.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f32>() / 2.0
}

fn contains(polygon: &[Vec2], point: Vec2) -> bool {
    let next = polygon.iter().cycle().skip(1);
    let crossings = polygon.iter().zip(next).filter(|(a, b)| {
        (a.y > point.y) != (b.y > point.y) && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x
    });
    crossings.count() % 2 == 1
}

/// Simplifies a polygon to fewer corners (Douglas and Peucker, 1973), within the tolerance.
fn simplified(ring: &[Vec2]) -> Polygon {
    let far = |from: Vec2| {
        let distances = ring.iter().enumerate().map(|(index, point)| (index, point.distance_squared(from)));
        distances.fold((0, -1.0), |most, next| if next.1 > most.1 { next } else { most }).0
    };
    let first = far(ring[0]);
    let other = far(ring[first]);
    let (first, other) = (first.min(other), first.max(other));
    let wrapped: Vec<Vec2> = ring[first..].iter().chain(&ring[..=first]).copied().collect();
    let mut kept = vec![false; wrapped.len()];
    (kept[0], kept[other - first]) = (true, true);
    let mut pieces = vec![(0, other - first), (other - first, wrapped.len() - 1)];
    while let Some((from, to)) = pieces.pop() {
        let (start, along) = (wrapped[from], wrapped[to] - wrapped[from]);
        let along = along.normalize_or_zero();
        let mut furthest = (from, TOLERANCE_PX);
        for (index, point) in wrapped.iter().enumerate().take(to).skip(from + 1) {
            let distance = (*point - start).perp_dot(along).abs();
            if distance > furthest.1 {
                furthest = (index, distance);
            }
        }
        if furthest.0 != from {
            kept[furthest.0] = true;
            pieces.extend([(from, furthest.0), (furthest.0, to)]);
        }
    }
    let simple: Polygon = wrapped
        .iter()
        .zip(&kept)
        .take(wrapped.len() - 1)
        .filter_map(|(point, is_kept)| is_kept.then_some(*point))
        .collect();
    // A shape thinner than the tolerance keeps all its corners.
    if simple.len() < 3 || area(&simple).abs() < 0.5 * area(ring).abs() { corners(ring) } else { simple }
}

/// Returns the corners of a ring along the edges of pixels.
fn corners(ring: &[Vec2]) -> Polygon {
    let count = ring.len();
    let is_corner = |index: usize| {
        let [before, here, after] = [index + count - 1, index, index + 1].map(|index| ring[index % count]);
        (here - before).perp_dot(after - here) != 0.0
    };
    (0..count).filter(|index| is_corner(*index)).map(|index| ring[index]).collect()
}

/// Joins two polygons where their corners are nearest.
fn joined(one: &[Vec2], other: &[Vec2]) -> Polygon {
    let mut nearest = (0, 0, f32::INFINITY);
    for (first, a) in one.iter().enumerate() {
        for (second, b) in other.iter().enumerate() {
            let distance = a.distance_squared(*b);
            if distance < nearest.2 {
                nearest = (first, second, distance);
            }
        }
    }
    let (first, second, _) = nearest;
    let mut whole = one[..=first].to_vec();
    whole.extend(other[second..].iter().chain(&other[..=second]));
    whole.extend(&one[first..]);
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(picture: &[&str]) -> Vec<Polygon> {
        polygons([10, 20], [picture[0].len(), picture.len()], |u, v| picture[v - 20].as_bytes()[u - 10] == b'#')
    }

    #[test]
    fn a_rectangle_has_four_corners_and_pixels_that_touch_belong_together() {
        let polygons = of(&["....", ".##.", ".##."]);
        assert_eq!(polygons.len(), 1);
        assert_eq!((polygons[0].len(), area(&polygons[0])), (4, 4.0));
        assert!(polygons[0].contains(&Vec2::new(11.0, 21.0)) && polygons[0].contains(&Vec2::new(13.0, 23.0)));
        assert_eq!(of(&["##..", "##..", "..##", "..##"]).len(), 1);
        assert_eq!(of(&["##.#", "##.#"]).len(), 2);
        assert_eq!(of(&["#"])[0].len(), 4);
    }

    #[test]
    fn a_hole_is_cut_out_and_a_small_one_is_filled() {
        let ring = of(&["#######", "#######", "##...##", "##...##", "#######", "#######"]);
        assert_eq!((ring.len(), area(&ring[0])), (1, 42.0 - 6.0));
        assert_eq!(area(&of(&["###", "#.#", "###"])[0]), 9.0);
    }

    #[test]
    fn a_disc_keeps_its_area_with_few_corners() {
        let is_inside = |u: usize, v: usize| (Vec2::new(u as f32, v as f32) - 49.5).length() < 40.0;
        let polygons = polygons([0, 0], [100, 100], is_inside);
        let disc = core::f32::consts::PI * 40.0 * 40.0;
        assert_eq!(polygons.len(), 1);
        assert!(polygons[0].len() < 90 && (area(&polygons[0]) / disc - 1.0).abs() < 0.01, "{}", polygons[0].len());
    }

    #[test]
    fn one_polygon_has_the_area_of_all() {
        let polygons = of(&["##..###", "##..###"]);
        assert_eq!(area(&one_polygon(&polygons).unwrap()), 10.0);
        assert_eq!(one_polygon(&[]), None);
    }
}

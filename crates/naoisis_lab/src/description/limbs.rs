//! Finds the head, legs and arms of a robot among the joints of its description.

use bevy::math::{DAffine3, DVec3};

use super::tree::{Joint, JointIndex, Posture, Tree};
use super::{DescriptionError, ImportOptions};

/// Words in the names of the joints of heads.
const HEAD_WORDS: [&str; 2] = ["head", "neck"];
/// Cosine of the angle between a joint's axis and the nominal axis, at least.
const ALONG: f64 = 0.8;
/// Difference between mirrored limbs at most, m.
const MIRRORED_M: f64 = 0.03;
/// Bend of the knees if no posture is given, radians: the bend in which Booster's robots walk.
const KNEE_BEND: f64 = 0.4;

/// The parts of a robot.
pub(super) struct Limbs {
    pub head: Head,
    pub legs: Option<Legs>,
    /// The joints of the left and the right arm, from the shoulder on.
    pub arms: Option<[Vec<JointIndex>; 2]>,
}

/// The joints of the head.
#[derive(Clone, Copy, Default)]
pub(super) struct Head {
    pub yaw: Option<JointIndex>,
    pub pitch: Option<JointIndex>,
}

/// The left and the right leg.
pub(super) struct Legs {
    pub sides: [Leg; 2],
}

/// A leg.
pub(super) struct Leg {
    /// The roll joint of the hip, or its pitch joint if it has no roll joint.
    pub hip: JointIndex,
    pub hip_pitch: JointIndex,
    pub knee: JointIndex,
    pub ankle: Option<JointIndex>,
    /// The link of the foot.
    pub foot: usize,
}

impl Head {
    /// Returns the link that carries the whole head.
    pub fn link(&self) -> Option<usize> {
        let links = [self.yaw, self.pitch].into_iter().flatten().map(|index| index.link);
        links.min()
    }
}

impl Limbs {
    /// Finds the parts of a robot.
    ///
    /// # Errors
    /// If a joint in the options does not exist or turns about another axis.
    pub fn of(tree: &Tree, options: &ImportOptions) -> Result<Limbs, DescriptionError> {
        let straight = tree.places(&Posture::new());
        let head = find_head(tree, &straight, options)?;
        let legs = find_legs(tree, &straight, head);
        let arms = find_arms(tree, &straight, head, legs.as_ref());
        Ok(Limbs { head, legs, arms })
    }
}

/// Returns the axis of a joint in the root's frame.
pub(super) fn axis_of(tree: &Tree, places: &[DAffine3], index: JointIndex) -> DVec3 {
    places[index.link].transform_vector3(tree.joint(index).axis)
}

/// Returns the position of a joint in the root's frame, m.
pub(super) fn point_of(tree: &Tree, places: &[DAffine3], index: JointIndex) -> DVec3 {
    places[index.link].transform_point3(tree.joint(index).point)
}

/// Returns the joint with this name.
pub(super) fn named(tree: &Tree, name: &str) -> Result<JointIndex, DescriptionError> {
    let found = tree.joints().find(|(_, joint)| joint.name == name);
    found.map(|(index, _)| index).ok_or_else(|| DescriptionError::NoJoint {
        name: name.to_owned(),
        known: tree.joints().map(|(_, joint)| joint.name.clone()).collect(),
    })
}

fn find_head(tree: &Tree, straight: &[DAffine3], options: &ImportOptions) -> Result<Head, DescriptionError> {
    let turns_about = |index: JointIndex, axis: DVec3| axis_of(tree, straight, index).dot(axis).abs() > ALONG;
    let is_of_head = |joint: &Joint| {
        let name = joint.name.to_lowercase();
        joint.is_hinge && HEAD_WORDS.iter().any(|word| name.contains(word))
    };
    let find = |option: &Option<String>, word: &str, axis: DVec3, letter: &str| match option {
        Some(name) => {
            let index = named(tree, name)?;
            if !turns_about(index, axis) {
                let problem =
                    format!("the joint `{name}` does not turn about the {letter} axis, as a {word} joint does");
                return Err(tree.joint(index).place.wrong(problem));
            }
            Ok(Some(index))
        }
        None => {
            let mut candidates = tree.joints().filter(|(index, joint)| is_of_head(joint) && turns_about(*index, axis));
            Ok(candidates.next().map(|(index, _)| index))
        }
    };
    Ok(Head {
        yaw: find(&options.head_yaw, "yaw", DVec3::Z, "z")?,
        pitch: find(&options.head_pitch, "pitch", DVec3::Y, "y")?,
    })
}

/// Returns pairs of tips that mirror each other at the middle of the robot, the left one first.
fn mirrored_pairs<'a>(
    tree: &'a Tree,
    straight: &'a [DAffine3],
    is_candidate: impl Fn(usize) -> bool + 'a,
) -> Vec<[usize; 2]> {
    let tips: Vec<usize> = tree.tips().into_iter().filter(|tip| is_candidate(*tip)).collect();
    let place = |tip: usize| straight[tip].translation;
    let mut pairs = Vec::new();
    for &left in tips.iter().filter(|tip| place(**tip).y > 0.0) {
        let mirrored = place(left) * DVec3::new(1.0, -1.0, 1.0);
        let right = tips.iter().copied().find(|tip| *tip != left && place(*tip).distance(mirrored) < MIRRORED_M);
        pairs.extend(right.map(|right| [left, right]));
    }
    pairs
}

/// Returns the links that are ancestors of both tips.
fn common_links(tree: &Tree, [left, right]: [usize; 2]) -> Vec<usize> {
    let others = tree.ancestry(right);
    tree.ancestry(left).into_iter().filter(|link| others.contains(link)).collect()
}

fn find_legs(tree: &Tree, straight: &[DAffine3], head: Head) -> Option<Legs> {
    let is_of_head = |tip: usize| head.link().is_some_and(|head| tree.is_within(tip, head));
    let mut pairs = mirrored_pairs(tree, straight, |tip| !is_of_head(tip));
    // The lowest pair stands on the ground.
    pairs.sort_by(|one, other| straight[one[0]].translation.z.total_cmp(&straight[other[0]].translation.z));
    pairs.into_iter().find_map(|pair| {
        let common = common_links(tree, pair);
        let [left, right] = pair.map(|foot| leg(tree, straight, foot, &common));
        Some(Legs { sides: [left?, right?] })
    })
}

/// Returns the leg that ends in `foot`. It needs two pitch joints, so that it has a knee.
fn leg(tree: &Tree, straight: &[DAffine3], foot: usize, common: &[usize]) -> Option<Leg> {
    let chain = tree.chain(foot, common);
    let along = |axis: DVec3| {
        let turns = move |index: &&JointIndex| axis_of(tree, straight, **index).dot(axis).abs() > ALONG;
        chain.iter().filter(turns).copied().collect::<Vec<JointIndex>>()
    };
    let (pitches, rolls) = (along(DVec3::Y), along(DVec3::X));
    let (&[hip_pitch, knee], rest) = pitches.split_first_chunk::<2>()?;
    let height = |index: JointIndex| point_of(tree, straight, index).z;
    // The legs must hang down from the hips.
    if height(hip_pitch) <= height(knee) || height(knee) <= straight[foot].translation.z {
        return None;
    }
    let is_above_knee = |index: &JointIndex| height(*index) > height(knee);
    let hip = rolls.into_iter().find(is_above_knee).unwrap_or(hip_pitch);
    Some(Leg { hip, hip_pitch, knee, ankle: rest.first().copied(), foot })
}

fn find_arms(tree: &Tree, straight: &[DAffine3], head: Head, legs: Option<&Legs>) -> Option<[Vec<JointIndex>; 2]> {
    let feet: Vec<usize> = legs.iter().flat_map(|legs| legs.sides.iter().map(|leg| leg.foot)).collect();
    let is_of_head = |tip: usize| head.link().is_some_and(|head| tree.is_within(tip, head));
    let pairs = mirrored_pairs(tree, straight, |tip| !feet.contains(&tip) && !is_of_head(tip));
    let hip_m = legs.map_or(f64::NEG_INFINITY, |legs| point_of(tree, straight, legs.sides[0].hip).z);
    let arms = pairs.into_iter().filter_map(|pair| {
        let common = common_links(tree, pair);
        let chains = pair.map(|tip| tree.chain(tip, &common));
        let &first = chains[0].first()?;
        // Of a hand with fingers, the longest chain counts.
        (point_of(tree, straight, first).z > hip_m && !chains[1].is_empty()).then_some(chains)
    });
    // Of chains with equal length, the first.
    arms.reduce(|longest, chains| if chains[0].len() > longest[0].len() { chains } else { longest })
}

/// Returns the posture in which the robot stands: the one in the options, or one with slightly bent knees and the ankles below the hips.
///
/// # Errors
/// If a joint in the options does not exist.
pub(super) fn standing(tree: &Tree, limbs: &Limbs, options: &ImportOptions) -> Result<Posture, DescriptionError> {
    for (name, angle) in &options.stand {
        let limits = tree.joint(named(tree, name)?).limits;
        if let Some([least, most]) = limits.filter(|[least, most]| !(*least..=*most).contains(angle)) {
            let (name, angle, limits) = (name.clone(), angle.to_string(), format!("{least} and {most}"));
            return Err(DescriptionError::BeyondLimits { name, angle, limits });
        }
    }
    if !options.stand.is_empty() {
        return Ok(options.stand.clone());
    }
    let straight = tree.places(&Posture::new());
    let mut posture = Posture::new();
    for leg in limbs.legs.iter().flat_map(|legs| &legs.sides) {
        posture.extend(bent(tree, &straight, leg));
    }
    Ok(posture)
}

/// Returns the joint angles of a leg with a bent knee, a level foot and the ankle below the hip.
fn bent(tree: &Tree, straight: &[DAffine3], leg: &Leg) -> Posture {
    // A positive angle turns the leg backwards.
    let sign = |index: JointIndex| axis_of(tree, straight, index).y.signum();
    let angle = |index: JointIndex, back: f64| (tree.joint(index).name.clone(), sign(index) * back);
    let allows = |bend: f64| {
        let limits = tree.joint(leg.knee).limits;
        limits.is_none_or(|[least, most]| (least..=most).contains(&(sign(leg.knee) * bend)))
    };
    let bend = if allows(KNEE_BEND) || !allows(-KNEE_BEND) { KNEE_BEND } else { -KNEE_BEND };
    let with_hip = |hip: f64| {
        let mut posture = vec![angle(leg.hip_pitch, hip), angle(leg.knee, bend)];
        posture.extend(leg.ankle.map(|ankle| angle(ankle, -hip - bend)));
        posture
    };
    let ankle_ahead = |hip: f64| {
        let places = tree.places(&with_hip(hip));
        let ankle = leg.ankle.map_or(places[leg.foot].translation, |ankle| point_of(tree, &places, ankle));
        ankle.x - point_of(tree, &places, leg.hip_pitch).x
    };
    // Secant method. The forward position of the ankle is nearly linear in the angle.
    let [mut before, mut hip] = [-bend, 0.0];
    let mut off_before = ankle_ahead(before);
    for _ in 0..20 {
        let off = ankle_ahead(hip);
        if (off - off_before).abs() < 1e-12 {
            break;
        }
        let next = hip - off * (hip - before) / (off - off_before);
        (before, off_before, hip) = (hip, off, next.clamp(-1.5, 1.5));
    }
    with_hip(hip)
}

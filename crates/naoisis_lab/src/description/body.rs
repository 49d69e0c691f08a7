//! The figures of the body: boxes, heights, neck, legs and arms.

use bevy::math::{DAffine3, DVec3};
use serde_json::{Value, json};

use super::figures::{Figures, degrees, joint_source, metres, place, span};
use super::limbs::{Legs, Limbs, axis_of, point_of};
use super::tree::{JointIndex, Posture, Tree, bounds};

/// Height of a head without shapes, as a share of the height of the neck.
const HEAD_SHARE: f64 = 0.25;
/// Thickness of an arm without shapes, m.
const ARM_M: f64 = 0.04;
/// Distance between the joints of one shoulder at most, m.
const SHOULDER_M: f64 = 0.15;

/// A standing robot, in the robot frame.
pub(super) struct Standing<'a> {
    pub tree: &'a Tree,
    pub limbs: &'a Limbs,
    /// The transforms from the links to the robot frame, in which the ground is at 0.
    pub places: Vec<DAffine3>,
    /// The file's name.
    pub file: &'a str,
}

/// The measures of a body that other figures depend on, m.
pub(super) struct Measures {
    pub front_m: f64,
    pub foot_y_m: f64,
    /// The height of the hips, or of the trunk's lower edge without legs.
    pub hip_m: f64,
    pub neck_m: DVec3,
    pub height_m: f64,
    pub has_legs: bool,
    /// Whether the head turns up and down.
    pub nods: bool,
}

impl<'a> Standing<'a> {
    /// Places the robot on the ground in a posture. Returns `None` if the description has neither shapes nor legs.
    pub fn new(tree: &'a Tree, limbs: &'a Limbs, posture: &Posture, file: &'a str) -> Option<Standing<'a>> {
        let places = tree.places(posture);
        let feet = limbs.legs.as_ref().map(|legs| legs.sides.each_ref().map(|leg| leg.foot));
        let groups =
            |links: &[usize]| -> Vec<usize> { links.iter().flat_map(|link| tree.rigid_group(*link)).collect() };
        let everything: Vec<usize> = (0..tree.links.len()).collect();
        let soles = feet.and_then(|feet| tree.bounds(&groups(&feet), &places));
        let ground = match (soles, &limbs.legs) {
            (Some([least, _]), _) => least.z,
            // The height of a foot without shapes is a tenth of the leg's length.
            (None, Some(Legs { sides: [leg, _] })) => {
                let ankle = places[leg.foot].translation.z;
                ankle - 0.1 * (point_of(tree, &places, leg.hip).z - ankle)
            }
            (None, None) => tree.bounds(&everything, &places)?[0].z,
        };
        let middle =
            feet.map_or(DVec3::ZERO, |[left, right]| (places[left].translation + places[right].translation) / 2.0);
        let robot_from_root = DAffine3::from_translation(DVec3::new(-middle.x, -middle.y, -ground));
        let places = places.into_iter().map(|place| robot_from_root * place).collect();
        Some(Standing { tree, limbs, places, file })
    }

    /// Returns the position of a joint, m.
    pub fn point(&self, index: JointIndex) -> DVec3 {
        point_of(self.tree, &self.places, index)
    }

    /// Returns the axis of a joint.
    pub fn axis(&self, index: JointIndex) -> DVec3 {
        axis_of(self.tree, &self.places, index)
    }

    /// Returns the source of a figure that is taken from a joint.
    pub fn source(&self, index: JointIndex) -> String {
        joint_source(self.tree.joint(index))
    }

    /// Returns the source of a figure that is taken from the shape of a link.
    fn shape_source(&self, link: usize) -> String {
        format!("{}, shape of {}", self.file, self.tree.links[link].name)
    }

    fn group_bounds(&self, link: usize) -> Option<[DVec3; 2]> {
        self.tree.bounds(&self.tree.rigid_group(link), &self.places)
    }

    /// Sets the figures of the body. Returns the measures that other figures need.
    pub fn body(&self, figures: &mut Figures) -> Measures {
        let legs = self.limbs.legs.as_ref();
        let (trunk, trunk_source) = self.trunk(figures);
        let hip_m = match legs {
            Some(legs) => legs.sides.each_ref().map(|leg| self.point(leg.hip).z).iter().sum::<f64>() / 2.0,
            None if trunk[0].z > 0.02 => trunk[0].z,
            None => 0.3 * trunk[1].z,
        };
        let (base, foot_y_m) = self.base(figures, hip_m, trunk);
        let shoulder = self.arms(figures);
        self.torso(figures, trunk, &trunk_source, hip_m, shoulder);
        figures.found(
            "body.foot_y_m",
            metres(foot_y_m),
            match legs {
                Some(legs) => format!("{}, link {}", self.file, self.tree.links[legs.sides[0].foot].name),
                None => format!("{}, the width of the lowest part", self.file),
            },
        );
        self.legs(figures, hip_m);
        let torso_top = trunk[1].z.max(hip_m + 0.05);
        let neck_m = self.neck(figures, torso_top);
        let height_m = self.height(figures, neck_m, torso_top);
        let lying = (1.3 * (trunk[1].x - trunk[0].x)).clamp(0.1, height_m);
        figures.guess("body.lying_height_m", metres(lying), "the trunk's depth and a part of the arms'");
        let width = shoulder.map_or(trunk[1].y, |shoulder| 0.75 * shoulder.y);
        let depth = trunk[0].x.abs().max(trunk[1].x.abs());
        let band = [0.1, 0.4].map(|share| hip_m + share * (torso_top - hip_m));
        let waistband = json!({ "z_m": span(band), "half_size_m": [metres(depth + 0.01), metres(width + 0.01)] });
        figures.guess("body.waistband", waistband, "a band of the team's colour about the trunk");
        let look = json!({
            "shape": "measures", "head": "head", "shell": [74, 78, 86], "joints": [228, 230, 234], "eyes": [60, 205, 190],
            "number": ["chest", "back"], "number_colour": [58, 61, 67], "plates": [228, 230, 234], "team_limbs": [],
        });
        figures.guess("body.look", look, "dark shells with light joints");
        Measures {
            front_m: base[1].x,
            foot_y_m,
            hip_m,
            neck_m,
            height_m,
            has_legs: legs.is_some(),
            nods: self.limbs.head.pitch.is_some(),
        }
    }

    /// Returns the box around the trunk, and its source or the reason of the guess.
    fn trunk(&self, figures: &mut Figures) -> ([DVec3; 2], Result<String, String>) {
        if let Some(found) = self.group_bounds(0).filter(|[least, most]| (*most - *least).min_element() > 0.01) {
            return (found, Ok(self.shape_source(0)));
        }
        figures
            .lacking
            .push("the trunk has no shapes that can be read: its box is that of the joints at it".to_owned());
        let group = self.tree.rigid_group(0);
        let at_trunk = |index: &JointIndex| self.tree.links[index.link].parent.is_some_and(|of| group.contains(&of));
        let joints = self.tree.joints().map(|(index, _)| index).filter(at_trunk).map(|index| self.point(index));
        let [least, most] = bounds(joints).unwrap_or_else(|| {
            let everything: Vec<usize> = (0..self.tree.links.len()).collect();
            self.tree.bounds(&everything, &self.places).unwrap_or([DVec3::ZERO, DVec3::splat(0.5)])
        });
        let around = DVec3::new(0.06, 0.03, 0.0);
        let most = most.with_z(most.z.max(least.z + 0.1));
        ([least - around, most + around], Err("a box around the joints at the trunk".to_owned()))
    }

    fn torso(
        &self,
        figures: &mut Figures,
        [least, most]: [DVec3; 2],
        source: &Result<String, String>,
        hip_m: f64,
        shoulder: Option<DVec3>,
    ) {
        figures.either("body.torso.x_m", span([least.x, most.x]), source);
        let half_width = least.y.abs().max(most.y);
        let arm_m = self.arm_thickness();
        match shoulder {
            Some(shoulder) if shoulder.y + arm_m > half_width => {
                let reason = "the shoulders, and arms that hang down";
                figures.guess("body.torso.half_width_m", metres(shoulder.y + arm_m), reason);
            }
            _ => figures.either("body.torso.half_width_m", metres(half_width), source),
        }
        let top = most.z.max(hip_m + 0.05);
        let source = source.clone().map(|source| format!("{source}, from the hips up"));
        figures.either("body.torso.z_m", span([hip_m, top]), &source);
    }

    fn arm_thickness(&self) -> f64 {
        let links = self.limbs.arms.iter().flat_map(|[left, _]| left.iter().map(|index| index.link));
        let shapes = links.flat_map(|link| &self.tree.links[link].shapes);
        shapes.map(|shape| shape.half.min_element()).reduce(f64::max).unwrap_or(ARM_M)
    }

    /// Sets the box of the feet and legs. Returns it with the feet's distance from the middle.
    fn base(&self, figures: &mut Figures, hip_m: f64, trunk: [DVec3; 2]) -> ([DVec3; 2], f64) {
        let legs = self.limbs.legs.as_ref();
        let (found, foot_y_m, source) = match legs {
            Some(Legs { sides: [left, right] }) => {
                let [left, right] = [left.foot, right.foot];
                let foot_y_m = (self.places[left].translation.y - self.places[right].translation.y) / 2.0;
                let bounds = [left, right].map(|foot| self.group_bounds(foot));
                let around = match bounds {
                    [Some([one, one_most]), Some([other, other_most])] => {
                        Some([one.min(other), one_most.max(other_most)])
                    }
                    _ => None,
                };
                (around, foot_y_m, self.shape_source(left))
            }
            None => {
                let lowest: Vec<DVec3> = self
                    .tree
                    .links
                    .iter()
                    .enumerate()
                    .flat_map(|(link, _)| {
                        self.tree
                            .bounds(&[link], &self.places)
                            .into_iter()
                            .filter(|[least, _]| least.z < hip_m)
                            .flatten()
                    })
                    .collect();
                let around = bounds(lowest);
                let half_width = around.map_or(trunk[1].y, |[least, most]| least.y.abs().max(most.y));
                (around, 0.8 * half_width, format!("{}, the shapes below the trunk", self.file))
            }
        };
        let (around, source) = match found {
            Some(around) => (around, Ok(source)),
            None => {
                figures.lacking.push("the feet have no shapes that can be read: their box is a guess".to_owned());
                let half = DVec3::new(0.3 * hip_m, foot_y_m + 0.1 * hip_m, 0.0);
                ([half * DVec3::new(-0.6, -1.0, 0.0), half], Err("by the length of the legs".to_owned()))
            }
        };
        let [least, most] = around;
        figures.either("body.base.x_m", span([least.x, most.x]), &source);
        figures.either("body.base.half_width_m", metres(least.y.abs().max(most.y)), &source);
        let source = source.map(|source| format!("{source}, up to the hips"));
        figures.either("body.base.z_m", span([0.0, hip_m]), &source);
        (around, foot_y_m)
    }

    fn legs(&self, figures: &mut Figures, hip_m: f64) {
        let Some(Legs { sides: [leg, _] }) = &self.limbs.legs else {
            figures.found("body.legs", Value::Null, format!("{}: it has no legs with knees", self.file));
            return;
        };
        let (hip, knee) = (self.point(leg.hip), self.point(leg.knee));
        let ankle = leg.ankle.map_or(self.places[leg.foot].translation, |ankle| self.point(ankle));
        figures.found("body.legs.hip_m", place(hip.with_z(hip_m)), self.source(leg.hip));
        // The legs of the model are straight, so the lengths of their parts are heights in the posture.
        let source = |joint: JointIndex| format!("{}, its height in the posture", self.source(joint));
        figures.found("body.legs.thigh_m", metres(hip_m - knee.z), source(leg.knee));
        let of_ankle = leg.ankle.map_or(format!("{}, link {}", self.file, self.tree.links[leg.foot].name), source);
        figures.found("body.legs.shank_m", metres(knee.z - ankle.z), &of_ankle);
        figures.found("body.legs.ankle_m", metres(ankle.z), of_ankle);
    }

    /// Sets the arms. Returns the left shoulder.
    fn arms(&self, figures: &mut Figures) -> Option<DVec3> {
        let Some([left, _]) = &self.limbs.arms else {
            figures.found("body.arms", Value::Null, format!("{}: it has no two arms", self.file));
            return None;
        };
        let points: Vec<DVec3> = left.iter().map(|index| self.point(*index)).collect();
        let near = |point: &&DVec3| point.distance(points[0]) < SHOULDER_M;
        // The outermost joint of the shoulder, from which the arm hangs.
        let of_shoulder = points.iter().take(2).take_while(near).count().saturating_sub(1);
        let shoulder = points[of_shoulder];
        let joints_m: f64 = points[of_shoulder..].windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let (last, last_point) = (left[left.len() - 1].link, points[points.len() - 1]);
        let hand_m = self
            .group_bounds(last)
            .map(|[least, most]| (least - last_point).abs().max((most - last_point).abs()).max_element());
        figures.found("body.arms.shoulder_m", place(shoulder), self.source(left[of_shoulder]));
        let length = metres((joints_m + hand_m.unwrap_or(0.1)).max(0.05));
        let source = match hand_m {
            Some(_) => Ok(format!("{}, the joints and shapes of the arm", self.file)),
            None => Err("the distances of the arm's joints, and a hand of 0.1 m".to_owned()),
        };
        figures.either("body.arms.length_m", length, &source);
        Some(shoulder)
    }

    /// Sets the point about which the head turns.
    fn neck(&self, figures: &mut Figures, torso_top: f64) -> DVec3 {
        let head = self.limbs.head;
        if let Some(index) = head.pitch.or(head.yaw) {
            let neck = self.point(index);
            if neck.z > 0.0 && neck.z > 0.5 * torso_top {
                figures.found("body.neck_m", place(neck), self.source(index));
                return neck;
            }
            let height = metres(neck.z);
            figures.lacking.push(format!(
                "{} is {height} m above the ground, inside or below the trunk: the neck is a guess",
                self.source(index)
            ));
        }
        let neck = DVec3::new(0.0, 0.0, torso_top);
        figures.guess("body.neck_m", place(neck), "on the trunk");
        neck
    }

    fn height(&self, figures: &mut Figures, neck: DVec3, torso_top: f64) -> f64 {
        let head_links: Vec<usize> = match self.limbs.head.link() {
            Some(head) => (0..self.tree.links.len()).filter(|link| self.tree.is_within(*link, head)).collect(),
            None => Vec::new(),
        };
        let everything: Vec<usize> = (0..self.tree.links.len()).collect();
        let top = |links: &[usize]| self.tree.bounds(links, &self.places).map(|[_, most]| most.z);
        match (top(&head_links).filter(|top| *top > neck.z), self.limbs.head.link()) {
            (Some(of_head), Some(link)) => {
                // The arms may be above the head if all joints are at 0.
                let height = of_head.max(torso_top);
                let top_of = |link: usize| top(&[link]).unwrap_or(f64::MIN);
                let highest = head_links.iter().copied().max_by(|one, other| top_of(*one).total_cmp(&top_of(*other)));
                figures.found("body.height_m", metres(height), self.shape_source(highest.unwrap_or(link)));
                height
            }
            (None, Some(_)) => {
                let height = (neck.z * (1.0 + HEAD_SHARE)).max(torso_top);
                figures.lacking.push("the head has no shapes that can be read: its height is a guess".to_owned());
                figures.guess("body.height_m", metres(height), "the neck's height and a quarter more");
                height
            }
            _ => {
                let height = top(&everything).unwrap_or(torso_top).max(torso_top);
                figures.found("body.height_m", metres(height), format!("{}, the highest shape", self.file));
                height
            }
        }
    }

    /// Sets the limits of the head's joints, and its speed.
    pub fn head(&self, figures: &mut Figures) {
        let head = self.limbs.head;
        for (path, index, axis) in [("head.yaw_deg", head.yaw, DVec3::Z), ("head.pitch_deg", head.pitch, DVec3::Y)] {
            let Some(index) = index else {
                figures.found(
                    path,
                    json!([0.0, 0.0]),
                    format!("{}: no joint of the head turns about that axis", self.file),
                );
                continue;
            };
            let joint = self.tree.joint(index);
            // The head looks down at positive angles, and to the left.
            let is_turned = self.axis(index).dot(axis) < 0.0;
            match joint.limits {
                Some([least, most]) if least < most => {
                    let limits = if is_turned { [-most, -least] } else { [least, most] };
                    figures.found(path, Value::Array(limits.map(degrees).to_vec()), joint_source(joint));
                }
                _ => {
                    let limits = if path == "head.yaw_deg" { [-90.0, 90.0] } else { [-20.0, 45.0] };
                    figures.lacking.push(format!("{} has no limits", joint_source(joint)));
                    figures.guess(path, json!(limits), "the description has no limits");
                }
            }
        }
        if head.yaw.is_none() && head.pitch.is_none() {
            figures.lacking.push(
                "no joint of the head was found by its name (head, neck): --head-yaw JOINT and --head-pitch JOINT name them".to_owned(),
            );
            figures.found("head.max_degps", json!(0.0), format!("{}: it has no joints of the head", self.file));
        } else {
            let reason =
                "as the Booster K1's; the speed of the joint in the description is that of its motor without a head";
            figures.guess("head.max_degps", json!(200.0), reason);
        }
    }
}

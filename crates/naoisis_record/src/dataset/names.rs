//! The classes of labelled objects, and their names in the data sets of teams.

use serde::{Deserialize, Serialize};

use naoisis_core::pitch::JunctionShape;

/// The class of a labelled object.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Class {
    /// The ball.
    Ball,
    /// A robot.
    Robot,
    /// A goal post.
    GoalPost,
    /// A person.
    Person,
    /// A penalty mark or the centre mark.
    PenaltyMark,
    /// A corner where two lines meet.
    LCrossing,
    /// A line that ends on another.
    TCrossing,
    /// Two lines that cross.
    XCrossing,
}

impl From<JunctionShape> for Class {
    fn from(shape: JunctionShape) -> Self {
        match shape {
            JunctionShape::L => Class::LCrossing,
            JunctionShape::T => Class::TCrossing,
            JunctionShape::X => Class::XCrossing,
        }
    }
}

/// The names of classes, in the order of their numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ClassNames {
    /// The names of this project.
    #[default]
    Naoisis,
    /// TORSO-21: the types of its annotations.
    Torso21,
    /// HULKs: the classes of their data set of 2026.
    Hulks,
    /// Booster: the classes of the detector in its demo for teams.
    Booster,
}

impl ClassNames {
    /// All lists of names, with their names on the command line.
    pub const ALL: [(&'static str, ClassNames); 4] = [
        ("naoisis", ClassNames::Naoisis),
        ("torso21", ClassNames::Torso21),
        ("hulks", ClassNames::Hulks),
        ("booster", ClassNames::Booster),
    ];

    /// Returns the names in their order, each with its class. A class that never occurs in the images still has its name and number.
    pub fn list(self) -> &'static [(&'static str, Option<Class>)] {
        use Class::{Ball, GoalPost, LCrossing, PenaltyMark, Person, Robot, TCrossing, XCrossing};

        match self {
            ClassNames::Naoisis => &[
                ("ball", Some(Ball)),
                ("robot", Some(Robot)),
                ("goal_post", Some(GoalPost)),
                ("person", Some(Person)),
                ("penalty_mark", Some(PenaltyMark)),
                ("l_crossing", Some(LCrossing)),
                ("t_crossing", Some(TCrossing)),
                ("x_crossing", Some(XCrossing)),
            ],
            ClassNames::Torso21 => &[
                ("ball", Some(Ball)),
                ("goalpost", Some(GoalPost)),
                ("robot", Some(Robot)),
                ("L-Intersection", Some(LCrossing)),
                ("T-Intersection", Some(TCrossing)),
                ("X-Intersection", Some(XCrossing)),
            ],
            ClassNames::Hulks => &[
                ("Ball", Some(Ball)),
                ("Robot", Some(Robot)),
                ("GoalPost", Some(GoalPost)),
                ("PenaltySpot", Some(PenaltyMark)),
                ("LSpot", Some(LCrossing)),
                ("TSpot", Some(TCrossing)),
                ("XSpot", Some(XCrossing)),
                ("Person", Some(Person)),
            ],
            ClassNames::Booster => &[
                ("Ball", Some(Ball)),
                ("Goalpost", Some(GoalPost)),
                ("Person", Some(Person)),
                ("LCross", Some(LCrossing)),
                ("TCross", Some(TCrossing)),
                ("XCross", Some(XCrossing)),
                ("PenaltyPoint", Some(PenaltyMark)),
                ("Opponent", Some(Robot)),
                ("BRMarker", None),
            ],
        }
    }

    /// Returns the number of a class, from 0. Returns `None` if these names have no such class.
    pub fn number(self, class: Class) -> Option<usize> {
        self.list().iter().position(|(_, listed)| *listed == Some(class))
    }
}

/// Names of the key points of a robot, in their order.
pub const KEYPOINTS: [&str; 11] = [
    "head", "left_shoulder", "right_shoulder", "left_hand", "right_hand", "left_hip", "right_hip", "left_knee",
    "right_knee", "left_foot", "right_foot",
];

/// Index of the key point that each becomes in a mirrored image.
pub const MIRRORED: [usize; 11] = [0, 2, 1, 4, 3, 6, 5, 8, 7, 10, 9];

/// Pairs of key points that a limb connects, counted from 1.
pub const SKELETON: [[usize; 2]; 12] =
    [[1, 2], [1, 3], [2, 3], [2, 4], [3, 5], [2, 6], [3, 7], [6, 7], [6, 8], [7, 9], [8, 10], [9, 11]];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_class_has_at_most_one_number_and_names_differ() {
        for (word, names) in ClassNames::ALL {
            let list = names.list();
            for (index, (name, class)) in list.iter().enumerate() {
                assert_eq!(list.iter().filter(|(other, _)| other == name).count(), 1, "{word}");
                assert!(class.is_none_or(|class| names.number(class) == Some(index)), "{word}");
            }
            assert_eq!(serde_json::to_value(names).unwrap(), word);
        }
        assert_eq!(ClassNames::Torso21.number(Class::Person), None);
    }

    #[test]
    fn left_and_right_change_places_in_a_mirror() {
        for (index, name) in KEYPOINTS.iter().enumerate() {
            let other = name.replace("left", "x").replace("right", "left").replace('x', "right");
            assert_eq!(KEYPOINTS[MIRRORED[index]], other);
        }
    }
}

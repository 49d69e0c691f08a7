//! The objects on the pitch that a robot did not recognise, and why.

use bevy::prelude::*;
use std::collections::{BTreeMap, VecDeque};

use super::Percepts;
use naoisis_core::pitch::GoalColour;
use naoisis_core::team::RobotId;

/// The greatest number of instants that are kept of a robot.
const MOST_INSTANTS: usize = 1000;

/// An object on the pitch.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum SceneObject {
    /// The ball with this index; 0 for the only one.
    Ball(usize),
    /// A goal post.
    GoalPost {
        /// Its position, m, pitch frame.
        position_m: Vec2,
        /// Its colour.
        colour: GoalColour,
    },
    /// Another robot.
    Robot(RobotId),
}

/// What covers an object.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cover {
    /// A robot.
    Robot(RobotId),
    /// A post.
    Post,
}

/// Why an object is not among the percepts. Parts of an object are the sample points by which the vision decides whether it is in view.
#[derive(Clone, Copy, PartialEq, Debug)]
#[non_exhaustive]
pub enum WhyMissed {
    /// No part of it is in an image.
    OutsideImage,
    /// Too few parts of it are in an image.
    PartlyOutside,
    /// It is beyond the greatest distance at which the vision detects such objects.
    TooFar {
        /// Its distance, m.
        distance_m: f32,
        /// The greatest distance, m.
        limit_m: f32,
    },
    /// Too much of it is covered.
    Covered {
        /// What covers most of it.
        by: Cover,
        /// The covered share of the parts in the image.
        share: f32,
    },
    /// It was missed by chance.
    Chance {
        /// The probability with which such an object is detected at this distance and as far as it is visible.
        probability: f32,
    },
    /// It was detected, but no position on a pitch follows from its pixel.
    NoPosition,
    /// It is in the image, and a vision by images did not detect it.
    InImage,
}

/// An object that a robot did not recognise, and why.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MissedObject {
    /// The object.
    pub object: SceneObject,
    /// Why the robot did not recognise it.
    pub why: WhyMissed,
}

/// The objects that robots did not recognise. While a program has this resource, the vision fills it in.
#[derive(Resource, Clone, Debug, Default)]
pub struct Unrecognised {
    /// The time of the images and the objects, for each instant whose percepts have not been followed by later ones.
    robots: BTreeMap<RobotId, VecDeque<(f64, Vec<MissedObject>)>>,
}

impl Unrecognised {
    /// Returns the objects that a robot did not recognise in the images of these `percepts`; `None` if this is not known. Percepts by images
    /// have no object's name: of those, only objects are returned of whose kind there is no percept.
    pub fn of(&self, robot: RobotId, percepts: &Percepts) -> Option<Vec<MissedObject>> {
        let (_, missed) = self.robots.get(&robot)?.iter().find(|(time_s, _)| *time_s == percepts.time_s)?;
        let is_certain = |missed: &&MissedObject| missed.why != WhyMissed::InImage || !percepts.have_one_like(missed);
        Some(missed.iter().filter(is_certain).copied().collect())
    }

    /// Removes everything.
    pub fn clear(&mut self) {
        self.robots.clear();
    }

    /// Adds what a robot did not recognise in the images of `time_s`, s. Its latest percepts until now are those of `arrived_s`.
    pub(super) fn note(&mut self, robot: RobotId, time_s: f64, arrived_s: f64, missed: Vec<MissedObject>) {
        let instants = self.robots.entry(robot).or_default();
        instants.retain(|(earlier_s, _)| (arrived_s..time_s).contains(earlier_s));
        if instants.len() == MOST_INSTANTS {
            instants.pop_front();
        }
        instants.push_back((time_s, missed));
    }
}

impl Percepts {
    /// Whether there is a percept that may be of this object.
    fn have_one_like(&self, missed: &MissedObject) -> bool {
        match missed.object {
            SceneObject::Ball(_) => self.ball.is_some(),
            SceneObject::GoalPost { colour, .. } => self.goal_posts.iter().any(|post| post.colour == colour),
            SceneObject::Robot(id) => self.robots.iter().any(|robot| robot.team == id.team),
        }
    }
}

/// Why an object has no percept.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Miss {
    /// The vision did not detect it.
    NotDetected,
    /// It was detected, but no position on a pitch follows from its pixel.
    NotMeasured,
}

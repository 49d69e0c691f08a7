//! The contacts of robots, posts and ball.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::CollisionPartner;
use crate::knowledge::Knowledge;
use crate::team::RobotId;

/// The contacts of the last cycle. A collision is reported once, when its contact begins.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, Serialize, Deserialize, @Knowledge::Truth)]
pub struct Contacts {
    touching: Vec<(Option<RobotId>, CollisionPartner)>,
}

impl Contacts {
    /// The robots whose bases the ball touched in the last cycle, in the order of the contacts.
    pub(crate) fn robots_at_ball(&self) -> impl DoubleEndedIterator<Item = RobotId> + '_ {
        self.touching.iter().filter(|(_, with)| *with == CollisionPartner::Ball).filter_map(|(robot, _)| *robot)
    }

    /// The pairs of robots that touched in the last cycle, in the order of their ids.
    pub(crate) fn robots_in_contact(&self) -> impl Iterator<Item = (RobotId, RobotId)> + '_ {
        self.touching.iter().filter_map(|(robot, with)| match with {
            CollisionPartner::Robot(other) => robot.map(|robot| (robot, *other)),
            _ => None,
        })
    }

    /// Whether `robot` touched another robot in the last cycle.
    pub(crate) fn touches_a_robot(&self, robot: RobotId) -> bool {
        self.robots_in_contact().any(|(one, other)| one == robot || other == robot)
    }

    /// Replaces the contacts by those of this cycle, `touching`, and returns the indices of those that are new.
    pub(crate) fn update(&mut self, touching: impl Iterator<Item = (Option<RobotId>, CollisionPartner)>) -> Vec<usize> {
        let touching: Vec<_> = touching.collect();
        let is_new = |index: &usize| {
            let pair = &touching[*index];
            !self.touching.contains(pair) && !touching[..*index].contains(pair)
        };
        let began = (0..touching.len()).filter(is_new).collect();
        self.touching = touching;
        began
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::team::Team;

    #[test]
    fn a_contact_begins_once_and_again_after_it_has_ended() {
        let blue = RobotId::new(Team::Blue, 2);
        let pink = CollisionPartner::Robot(RobotId::new(Team::Pink, 3));
        let (robots, ball) = ((Some(blue), pink), (Some(blue), CollisionPartner::Ball));
        let mut contacts = Contacts::default();
        assert_eq!(contacts.update([robots].into_iter()), [0]);
        assert!(contacts.touches_a_robot(blue) && contacts.touches_a_robot(RobotId::new(Team::Pink, 3)));
        // The same pair twice in a cycle is one contact.
        assert_eq!(contacts.update([robots, ball, ball].into_iter()), [1]);
        assert_eq!(contacts.update([ball].into_iter()), [0; 0]);
        assert!(!contacts.touches_a_robot(blue));
        assert_eq!(contacts.update([robots].into_iter()), [0]);
    }
}

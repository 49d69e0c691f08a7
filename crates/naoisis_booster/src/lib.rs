//! Programs written for [Booster's SDK](https://github.com/BoosterRobotics/booster_robotics_sdk) as players, unchanged: the services and
//! topics of a Booster robot, over DDS.
//!
//! Add the [`BoosterPlugin`] after the `AgentsPlugin`. A robot whose behaviour is `booster`, or whose team is, is then played by a program
//! that connects over DDS. The guide's page "Booster programs" has the commands, the services and the topics.
//!
//! DDS runs in real time, so two matches of the same seed differ by the times at which messages arrive.

mod door;
pub mod firmware;
pub mod messages;
mod player;
mod topics;
mod vision;
mod visual_kick;

pub use door::Reach;
pub use player::{BOOSTER, BoosterPlugin, booster_robots};

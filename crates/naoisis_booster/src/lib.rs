//! Programs written for [Booster's SDK](https://github.com/BoosterRobotics/booster_robotics_sdk) as players, unchanged: the services and
//! topics of a Booster robot, over DDS.
//!
//! Add the [`BoosterPlugin`](player::BoosterPlugin) after the `AgentsPlugin`. A robot whose behaviour is `booster`, or whose team is, is
//! then played by a program that connects over DDS. The guide's page "Booster programs" has the commands, the services and the topics.
//!
//! DDS runs in real time, so two matches of the same seed differ by the times at which messages arrive.

mod buttons;
pub mod firmware;
pub mod messages;
mod participant;
pub mod player;
pub mod reach;
mod topics;
mod vision;
mod visual_kick;

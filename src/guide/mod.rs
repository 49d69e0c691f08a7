//! The guide: from a first behaviour to an experiment, how it all works, and how to add to it.
//!
//! 1. [A first behaviour](first_behaviour), and a headless test of it.
//! 2. [My team in ten minutes](programs): a program of one's own that plays, in any language.
//! 3. [What a robot believes](beliefs): estimators, and beliefs against the truth.
//! 4. [Watching](watching): what the window shows, and what a behaviour draws in it.
//! 5. [Images and pictures](pictures): cameras, renderers, frames, videos.
//! 6. [Experiments](experiments): batches, sweeps, saved matches, learning.
//! 7. [Traces](traces): every field of them.
//! 8. [Rules](rules): what the referee judges, and what robots are told.
//! 9. [Architecture](architecture): the cycle, who knows what, determinism.
//! 10. [The paper](paper): what each of its sentences has become, and which test shows it.
//! 11. [Python](python): matches, batches and environments for learning from there.
//! 12. [A bridge to ROS 2](ros2): robots whose software is made of nodes.
//! 13. [A robot of your own](robots): from a data sheet to a match, and the leagues.
//! 14. [Adding to it](extending): a sensor, a rule, a team, a log format, a command.
//!
//! The programs in `examples/` are one idea each, and run headless:
//!
//! | example | shows |
//! |---|---|
//! | `first_behaviour` | a robot that looks for the ball and kicks it |
//! | `own_program` | a whole naoisis with a team of one's own: window, batches, replays and all other commands |
//! | `headless_test` | a test of a behaviour on `MinimalPlugins` |
//! | `belief_fusion` | what a camera, a sonar and team-mates know together |
//! | `keeper_intercepts` | what the ball's velocity is worth to a keeper |
//! | `coordination` | who goes for the ball, and what losing messages does to that |
//! | `path_planning` | a grid planner and a reactive one among moving robots |
//! | `localisation` | two Kalman filters and a particle filter on the same seeds, and after a kidnapping |
//! | `localisation_from_images` | where a robot is, from camera images alone |
//! | `decision_making` | where to shoot, when nothing is certain |
//! | `record_frames` | a sequence of PNG files from a program |
//! | `learn_to_score` | a policy learned by the cross-entropy method, saved and played |
//! | `robot_that_hears` | a sensor of one's own: a whistle, with settings in the scenario and a value in the trace |
//! | `time_wasting` | a rule of one's own, which the referee judges and explains |
//! | `log_format` | a log format of one's own: a table of where the ball was |
//! | `watched_behaviour` | a behaviour of one's own in the window, with drawings |

#[doc = include_str!("first_behaviour.md")]
pub mod first_behaviour {}

#[doc = include_str!("programs.md")]
pub mod programs {}

#[doc = include_str!("beliefs.md")]
pub mod beliefs {}

#[doc = include_str!("watching.md")]
pub mod watching {}

#[doc = include_str!("pictures.md")]
pub mod pictures {}

#[doc = include_str!("experiments.md")]
pub mod experiments {}

#[doc = include_str!("traces.md")]
pub mod traces {}

#[doc = include_str!("rules.md")]
pub mod rules {}

#[doc = include_str!("architecture.md")]
pub mod architecture {}

#[doc = include_str!("paper.md")]
pub mod paper {}

#[doc = include_str!("python.md")]
pub mod python {}

#[doc = include_str!("ros2.md")]
pub mod ros2 {}

#[doc = include_str!("robots.md")]
pub mod robots {}

#[doc = include_str!("extending.md")]
pub mod extending {
    #[doc = include_str!("extending/sensor.md")]
    pub mod sensor {}

    #[doc = include_str!("extending/rule.md")]
    pub mod rule {}

    #[doc = include_str!("extending/team.md")]
    pub mod team {}

    #[doc = include_str!("extending/log_format.md")]
    pub mod log_format {}

    #[doc = include_str!("extending/command.md")]
    pub mod command {}
}

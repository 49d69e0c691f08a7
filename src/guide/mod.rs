//! The guide: from a first behaviour to an experiment, how the simulator works, and how to extend it.
//!
//! 1. [A first behaviour](first_behaviour), and a headless test of it.
//! 2. [My team in ten minutes](programs): your own program as a player, in any language.
//! 3. [What a robot believes](beliefs): estimators, and beliefs compared with the truth.
//! 4. [Watching](watching): what the window shows, and how a behaviour draws in it.
//! 5. [Images and pictures](pictures): cameras, renderers, frames, videos.
//! 6. [Experiments](experiments): batches, sweeps, saved matches, learning.
//! 7. [Traces](traces): every field of them.
//! 8. [Rules](rules): what the referee judges, and what robots are told.
//! 9. [Architecture](architecture): the crates, the cycle, the information barrier, determinism.
//! 10. [The paper](paper): where each of its statements is implemented, and which test checks it.
//! 11. [Python](python): matches, batches and learning environments.
//! 12. [A bridge to ROS 2](ros2): robots whose software consists of nodes.
//! 13. [A robot of your own](robots): from a data sheet to a match, and the leagues.
//! 14. [Extending it](extending): a sensor, a rule, a team, a log format, a command.
//! 15. [A match in your own app](own_app): schedules, start and end, events.
//! 16. [Random numbers](random_numbers): of behaviours, sensors and programs.
//! 17. [Matches beside real ones](real_matches): goals, falls, penalties and seventy other quantities, and logs of the GameController.
//! 18. [A web page](web_page): a match that plays in a browser, in one file.
//! 19. [Tables](tables): a match as Parquet or CSV, for pandas, Polars and `DuckDB`.
//! 20. [MCAP files](mcap): a match in Lichtblick, Foxglove, Rerun and their libraries.
//! 21. [Data sets of images](data_sets): labelled images for training detectors.
//! 22. [Booster programs](booster): programs for Booster's SDK, and the topics of its demo, over DDS.
//! 23. [Challenges](challenges): tasks, baselines, results that others verify, a table of them.
//!
//! The programs in `examples/` show one idea each and run without a window:
//!
//! | example | shows |
//! |---|---|
//! | `first_behaviour` | a robot that looks for the ball and kicks it |
//! | `own_program` | a program with your own team and all commands: window, batches, replays |
//! | `bevy_game` | a match in your own Bevy game: run by `FixedUpdate`, with an observer of goals |
//! | `headless_test` | a test of a behaviour on Bevy's `MinimalPlugins` |
//! | `belief_fusion` | how observations of a camera, a sonar and team-mates are fused |
//! | `keeper_intercepts` | how much a keeper gains from an estimate of the ball's velocity |
//! | `coordination` | how team-mates agree on who goes to the ball, and what message loss does to it |
//! | `path_planning` | a grid planner and a reactive one among moving robots |
//! | `localisation` | two Kalman filters and a particle filter compared on the same seeds, also after a kidnapping |
//! | `localisation_from_images` | the pose of a robot from camera images alone |
//! | `decision_making` | where to shoot under uncertainty |
//! | `record_frames` | a sequence of PNG files from a program |
//! | `learn_to_score` | a policy learned by the cross-entropy method, saved and played |
//! | `robot_that_hears` | a custom sensor: a whistle, with settings in the scenario and a value in the trace |
//! | `time_wasting` | a custom rule, which the referee judges and explains |
//! | `log_format` | a custom log format: a table of the ball's positions |
//! | `watched_behaviour` | a behaviour in the window, with drawings of its own |

#[doc = include_str!("first_behaviour.md")]
pub mod first_behaviour {}

#[doc = include_str!("programs.md")]
pub mod programs {}

#[doc = include_str!("beliefs.md")]
pub mod beliefs {}

#[doc = include_str!("watching.md")]
pub mod watching {}

#[doc = include_str!("web_page.md")]
pub mod web_page {}

#[doc = include_str!("tables.md")]
pub mod tables {}

#[doc = include_str!("mcap.md")]
pub mod mcap {}

#[doc = include_str!("booster.md")]
pub mod booster {}

#[doc = include_str!("pictures.md")]
pub mod pictures {}

#[doc = include_str!("data_sets.md")]
pub mod data_sets {}

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

#[doc = include_str!("challenges.md")]
pub mod challenges {}

#[doc = include_str!("python.md")]
pub mod python {}

#[doc = include_str!("ros2.md")]
pub mod ros2 {}

#[doc = include_str!("real_matches.md")]
pub mod real_matches {}

#[doc = include_str!("robots.md")]
pub mod robots {}

#[doc = include_str!("own_app.md")]
pub mod own_app {}

#[doc = include_str!("random_numbers.md")]
pub mod random_numbers {}

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

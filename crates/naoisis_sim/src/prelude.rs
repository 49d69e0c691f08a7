//! Commonly used items for programs with matches. Names that also occur in Bevy's prelude or in other crates, or that need their module for
//! context, such as [`Pitch`](naoisis_core::pitch::Pitch), [`Game`](naoisis_core::game::Game) and [`Rules`](naoisis_core::game::Rules), are
//! imported from their modules.

pub use crate::scenario::Scenario;
pub use crate::simulation::{
    Fell, GoalScored, Kicked, MatchApp, MatchCommands, MatchEnd, MatchEnded, MatchNotStarted, MatchStarted,
    NaoisisPlugins, Penalised, RuleApp, SensorApp,
};
pub use naoisis_core::ball::{Ball, BallVelocity};
pub use naoisis_core::behaviour::drawings::Drawings;
pub use naoisis_core::behaviour::{BehaviourApp, BehaviourRegistry, behaviour};
pub use naoisis_core::communication::{Inbox, Outbox, TeamMessage};
pub use naoisis_core::cycle::{Cycle, CycleClock, CycleSystems, run_cycle};
pub use naoisis_core::events::{CycleEvents, MatchEvent, StampedEvent};
pub use naoisis_core::game::{GameState, Intervention};
pub use naoisis_core::geometry::Pose;
pub use naoisis_core::kick_geometry::KickType;
pub use naoisis_core::knowledge::Knowledge;
pub use naoisis_core::random::{BehaviourRandom, RandomStream};
pub use naoisis_core::referee::snapshot::{MatchSnapshot, RobotSnapshot};
pub use naoisis_core::referee::{CustomRule, GameStatus};
pub use naoisis_core::robot::head::{HeadAngles, HeadCommand};
pub use naoisis_core::robot::kick::{KickCommand, KickRequest};
pub use naoisis_core::robot::motion::WalkCommand;
pub use naoisis_core::team::{RobotId, Team};
pub use naoisis_sensing::belief::{Belief, SimpleBelief};
pub use naoisis_sensing::sensing::odometry::Odometry;
pub use naoisis_sensing::sensing::sonar::SonarReading;
pub use naoisis_sensing::sensing::status::BodyStatus;
pub use naoisis_sensing::sensing::vision::Percepts;

//! What most programs with a match in them need.

pub use crate::ball::{Ball, BallVelocity};
pub use crate::behaviour::drawings::{Drawings, Frame, Ink};
pub use crate::behaviour::{BehaviourApp, BehaviourRegistry, behaviour};
pub use crate::belief::{Belief, SimpleBelief};
pub use crate::communication::{Inbox, Outbox, TeamMessage};
pub use crate::cycle::{Cycle, CycleClock, CycleSystems, run_cycle};
pub use crate::events::{CycleEvents, MatchEvent};
pub use crate::game::{Evidence, Game, GameState, Intervention, Rules};
pub use crate::geometry::Pose;
pub use crate::kick_geometry::KickType;
pub use crate::knowledge::Knowledge;
pub use crate::pitch::Pitch;
pub use crate::random::{RandomStream, RandomStreams};
pub use crate::record::formats::LogFormatApp;
pub use crate::referee::snapshot::{MatchSnapshot, RobotSnapshot};
pub use crate::referee::{GameStatus, OwnRule};
pub use crate::robot::head::{HeadAngles, HeadCommand};
pub use crate::robot::kick::{KickCommand, KickRequest};
pub use crate::robot::motion::WalkCommand;
pub use crate::scenario::Scenario;
pub use crate::sensing::odometry::Odometry;
pub use crate::sensing::sonar::SonarReading;
pub use crate::sensing::status::BodyStatus;
pub use crate::sensing::vision::Percepts;
pub use crate::simulation::{MatchApp, NaoisisPlugins, RuleApp, SensorApp};
pub use crate::team::{RobotId, Team};

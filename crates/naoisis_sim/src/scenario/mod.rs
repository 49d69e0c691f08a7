//! Scenarios: the data that a match starts from.
//!
//! Every field has a default, so that `Scenario { robots, ..default() }` in a program and `{ "robots": [...] }` in a
//! file mean the same. Files are RON or JSON of the same shape; [`Scenario::load`] and its relatives read them:
//!
//! 1. the text becomes a tree of values, and an outline with the position of each value;
//! 2. presets are filled in; missing values are taken from the [league](League) and the [realism](RealismSettings), and those of robots from the
//!    common settings;
//! 3. the tree becomes a [`Scenario`];
//! 4. [`Scenario::validate`] checks what types cannot express: ranges, and that nothing overlaps.
//!
//! All errors are [`ScenarioError`]s with line and column, and with what was expected.

mod apply_realism;
mod bytes;
mod describe_realism;
mod deserialize;
mod error;
mod expectation;
mod fault;
mod fidelity;
mod field_path;
mod file_schema;
mod foreign;
mod format;
mod from_saved;
mod handicap;
mod inline_models;
mod leagues;
mod library;
mod lints;
mod load;
mod looks_file;
mod merge;
mod message_limits;
pub mod message_pack;
mod messages_form;
mod model_file;
mod model_gaps;
mod model_like;
mod models;
mod parse;
mod plane_or_space;
mod preset;
mod presets;
mod quantity;
mod read;
mod realism;
mod robot_settings;
mod robot_spec;
pub mod saved_match;
mod scanner;
mod setting;
mod spans;
mod teams_spec;
mod text;
mod types;
mod validate;
pub mod wording;

pub use error::{Place, ScenarioError, ScenarioErrorKind};
pub use expectation::{Comparison, Expectation, Frequency, NotAnExpectation};
pub use fault::ScenarioFault;
pub use fault::unknown_name;
pub use field_path::{FieldPath, Segment};
pub use file_schema::FileKind;
pub use foreign::foreign_file;
pub use format::Format;
pub use leagues::{LEAGUES, League};
pub use library::{LIBRARY, LibraryScenario};
pub use load::read_settings;
pub use looks_file::{LOOKS, read_looks};
pub use models::{MODELS, ModelError, RobotModel};
pub use preset::Preset;
pub use presets::{BALL_PRESETS, FIELD_PRESETS, RULES_PRESETS, pitch_preset, rules_preset};
pub use quantity::{BallQuantity, Quantity, RobotQuantity, TeamQuantity};
pub use realism::{Realism, RealismSettings};
pub use robot_settings::{RobotPatch, RobotSettings};
pub use robot_spec::{BehaviourSpec, RobotSpec};
pub use saved_match::{SavedMatch, SavedMatchError};
pub use setting::{NotASetting, Setting};
pub use teams_spec::{TeamRobots, TeamsSpec};
pub use text::{ScenarioFile, ScenarioSource};
pub use types::{BallSpec, BallStart, PostSpec, Scenario};
pub use validate::{MOST_POSTS, Numbers};

//! What goes between a match and everything outside it: what a robot perceives and commands, and the record of a cycle.
//!
//! Programs, recorders, learning environments, the viewer and Python all use these types: one [record of each
//! cycle](cycle_record::CycleRecord), with a [`Perception`](vocabulary::Perception) and a
//! [`RobotCommand`](vocabulary::RobotCommand) for each robot. It is [gathered](gather) once a cycle.

pub mod command;
pub mod cycle_record;
pub mod fields;
pub mod gather;
pub mod trace_fields;
pub mod vocabulary;

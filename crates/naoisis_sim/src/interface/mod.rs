//! The interface between a match and its users: what a robot perceives and commands, and the record of a cycle.
//!
//! Programs, recorders, learning environments, the viewer and Python all use these types: a [record of each
//! cycle](cycle_record::CycleRecord), with a [`Perception`](vocabulary::Perception) and a [`RobotCommand`](vocabulary::RobotCommand) for
//! each robot. It is [gathered](gather) once in each cycle.

pub mod command;
pub mod cycle_record;
pub mod fields;
pub mod gather;
pub mod trace_fields;
pub mod trace_numbers;
pub mod vocabulary;

//! The commands of `naoisis`.

pub mod cli;

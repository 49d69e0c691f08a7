//! Tests of the program from outside, as one crate.

mod scenario_files;

//! The integration tests: one crate, a module a subject.
#![expect(clippy::unwrap_used, reason = "a failed test may panic")]

mod accepted_scenarios;
mod agents;
mod barrier;
mod batch;
mod behaviours;
mod built_in_scenarios;
mod calibration;
mod challenges;
mod clients;
mod collisions;
mod commands;
mod completeness;
mod counts;
mod damaged_saves;
mod determinism;
mod event_messages;
mod exit_status;
mod expectations;
mod figures;
mod game_controller;
mod golden;
mod images;
mod interventions;
mod kicks;
mod layers;
mod localisation;
mod matches;
mod model_files;
mod models;
mod mutated;
mod outputs;
mod own_program;
mod own_rules;
mod pairs;
mod programs;
mod realism;
mod referee_properties;
#[cfg(feature = "gpu")]
mod renderers;
mod rule_cases;
mod saved_tests;
mod scenario_errors;
mod scenario_files;
mod schema;
mod sensing;
mod sensors;
mod situation;
mod snapshot;
mod support;
mod teams;
mod traces;
#[cfg(feature = "viewer")]
mod watched;
mod whatif;

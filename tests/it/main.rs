//! The integration tests: one crate, a module a subject.
#![expect(clippy::unwrap_used, reason = "a failed test may panic")]

mod accepted_scenarios;
mod agents;
mod barrier;
mod batch;
mod behaviours;
mod breakdowns;
mod built_in_scenarios;
mod calibration;
mod challenges;
#[cfg(unix)]
mod clients;
mod collisions;
mod commands;
mod completeness;
mod counts;
mod damaged_saves;
mod datasets;
mod determinism;
mod episodes;
mod errors;
mod event_messages;
mod exit_status;
mod expectations;
mod falls;
mod figures;
mod flight;
mod foreign_files;
mod game_controller;
mod game_controller_heard;
mod golden;
mod images;
mod interventions;
mod kicks;
mod layers;
mod localisation;
mod match_realism;
mod matches;
mod mcap_files;
mod model_files;
mod models;
mod mutated;
mod outputs;
mod own_app;
mod own_program;
mod own_rules;
mod pages;
mod pairs;
#[cfg(unix)]
mod policies;
mod programs;
mod public_api;
mod random_numbers;
mod realism;
mod referee_properties;
#[cfg(feature = "gpu")]
mod renderers;
mod robot_import;
mod rule_cases;
mod saved_tests;
mod scenario_errors;
mod scenario_files;
mod schema;
mod sensing;
mod sensors;
#[cfg(unix)]
mod served_programs;
mod several_balls;
mod situation;
mod snapshot;
mod support;
mod tables;
#[cfg(target_os = "linux")]
mod team_messages;
mod teams;
#[cfg(unix)]
mod thinking_programs;
mod traces;
#[cfg(feature = "viewer")]
mod watched;
mod whatif;

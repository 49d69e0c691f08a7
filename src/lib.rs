//! naoisis: a behavioural simulator of NAO robot soccer. Coarse motion, strict perception.

pub mod ball;
pub mod behaviour;
pub mod belief;
pub mod cli;
pub mod collision;
pub mod communication;
pub mod cycle;
pub mod events;
pub mod geometry;
pub mod knowledge;
pub mod pitch;
pub mod prelude;
pub mod random;
pub mod record;
pub mod referee;
pub mod robot;
pub mod scenario;
pub mod sensing;
pub mod simulation;

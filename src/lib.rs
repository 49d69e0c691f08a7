//! naoisis: a behavioural simulator of NAO robot soccer. Coarse motion, strict perception.

pub mod ball;
pub mod communication;
pub mod cycle;
pub mod events;
pub mod geometry;
pub mod knowledge;
pub mod pitch;
pub mod random;
pub mod referee;
pub mod robot;
pub mod scenario;
pub mod sensing;

//! What a robot can know: its cameras, sonars, joints, steps and its own state.

pub mod camera;
pub mod odometry;
pub(crate) mod preset;
pub mod scene;
pub mod sonar;
pub mod status;
pub mod vision;

#[cfg(test)]
pub(crate) mod testing;

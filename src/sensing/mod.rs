//! What a robot can know: its cameras, sonars, joints, steps and its own state.

pub mod camera;
pub mod odometry;
pub mod sonar;
pub mod status;
pub mod vision;

//! Camera images drawn on a graphics card, without a window: the same scenes as the software renderer's, by Bevy.

pub mod mesh;
pub mod renderer;

//! Shadows and anti-aliasing. They cost little with a graphics card, but most of the time without one.

use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use wgpu::DeviceType;

use super::camera::ViewerCamera;
use super::display_settings::DisplaySettings;
use super::shared::KeysSystems;

/// Switches shadows and anti-aliasing; they start switched off if there is no graphics card.
pub struct DrawingPlugin;

impl Plugin for DrawingPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PreStartup, suit_adapter)
            .add_systems(Update, switch_fine_drawing.run_if(resource_changed::<DisplaySettings>).after(KeysSystems));
    }
}

/// Switches fine drawing off if the processor renders, which then takes a seventh of the time.
fn suit_adapter(adapter: Option<Res<RenderAdapterInfo>>, mut display: ResMut<DisplaySettings>) {
    if adapter.is_some_and(|adapter| adapter.device_type == DeviceType::Cpu) {
        display.fine_drawing = false;
    }
}

fn switch_fine_drawing(
    display: Res<DisplaySettings>,
    mut cameras: Query<&mut Msaa, With<ViewerCamera>>,
    mut lights: Query<&mut DirectionalLight>,
) {
    for mut smoothing in &mut cameras {
        smoothing.set_if_neq(if display.fine_drawing { Msaa::Sample4 } else { Msaa::Off });
    }
    for mut light in &mut lights {
        if light.shadow_maps_enabled != display.fine_drawing {
            light.shadow_maps_enabled = display.fine_drawing;
        }
    }
}

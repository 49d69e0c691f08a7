//! The material of matt surfaces without fine drawing. A processor that renders draws it several times faster than Bevy's
//! material, which computes shadows and highlights for each pixel even where they are switched off.

use bevy::asset::{load_internal_asset, uuid_handle};
use bevy::prelude::*;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::{Shader, ShaderRef};

use super::super::pitch_frame::HallLight;

const SHADER: Handle<Shader> = uuid_handle!("0b7f6c55-2f86-4f0e-9d21-8f2a4f5f9a63");

/// Draws [`SimpleMaterial`]s.
pub(super) struct SimpleMaterialPlugin;

impl Plugin for SimpleMaterialPlugin {
    fn build(&self, app: &mut App) {
        load_internal_asset!(app, SHADER, "simple.wgsl", Shader::from_wgsl);
        app.add_plugins(MaterialPlugin::<SimpleMaterial>::default());
    }
}

/// A matt surface in the light of the hall, without shadows.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub(super) struct SimpleMaterial {
    #[uniform(0)]
    light: HallLight,
    /// The picture on the surface, for meshes with texture coordinates.
    #[texture(1)]
    #[sampler(2)]
    picture: Option<Handle<Image>>,
}

impl SimpleMaterial {
    /// Returns the material of a surface with this picture; without one, its vertices have the colours.
    pub(super) fn new(picture: Option<Handle<Image>>) -> Self {
        Self { light: HallLight::default(), picture }
    }
}

impl Material for SimpleMaterial {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }
}

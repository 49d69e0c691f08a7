//! The materials of the scene, and the light in it.

use bevy::asset::{load_internal_asset, uuid_handle};
use bevy::mesh::MeshVertexBufferLayoutRef;
use bevy::pbr::{MaterialPipeline, MaterialPipelineKey};
use bevy::prelude::*;
use bevy::render::render_resource::{
    AsBindGroup, ColorWrites, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError,
};
use bevy::shader::{Shader, ShaderRef};

use naoisis_sensing::appearance::field::STRING_M;
use naoisis_sensing::sensing::camera::software::light;

const SHADER: Handle<Shader> = uuid_handle!("5f1c1c0e-7e55-4a4e-9a7c-3d0a2c4b8f16");

/// How far away things are told apart, m. Beyond, they are as far as this: as far as frames on disk tell.
pub(super) const MOST_DEPTH_M: f32 = 65.535;

/// Draws [`SceneMaterial`]s.
pub(super) struct SceneMaterialPlugin;

impl Plugin for SceneMaterialPlugin {
    fn build(&self, app: &mut App) {
        load_internal_asset!(app, SHADER, "scene.wgsl", Shader::from_wgsl);
        app.add_plugins(MaterialPlugin::<SceneMaterial>::default());
    }
}

/// What a mesh is in the scene, which says when and how it is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Surface {
    /// A body, under the light.
    Body,
    /// The ground where it is not in a shadow. Drawn after the shadows, which hide it.
    Ground,
    /// The ground as it is in a shadow. Drawn first.
    ShadedGround,
    /// A shadow on the ground: it has no colour, and hides the ground that is not in a shadow.
    Shadow,
    /// The strings of a net, through which everything is seen.
    Net,
    /// How far away it is, in place of a colour.
    Depth,
}

/// The light, as the shader has it.
#[derive(Clone, Copy, ShaderType, Debug)]
struct Light {
    sun: Vec4,
    ambient: Vec4,
    other: Vec4,
}

/// A material of the scene.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
#[bind_group_data(Surface)]
pub(super) struct SceneMaterial {
    surface: Surface,
    #[uniform(0)]
    light: Light,
}

impl From<&SceneMaterial> for Surface {
    fn from(material: &SceneMaterial) -> Self {
        material.surface
    }
}

impl SceneMaterial {
    pub(super) fn new(surface: Surface) -> Self {
        Self {
            surface,
            light: Light {
                sun: light::SUN.extend(light::FROM_SUN),
                ambient: light::GRADIENT.extend(light::AMBIENT),
                other: Vec4::new(light::IN_SHADOW as f32, STRING_M, light::NET_HIDES / light::FULL, MOST_DEPTH_M),
            },
        }
    }
}

impl Material for SceneMaterial {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn alpha_mode(&self) -> AlphaMode {
        // This says only when it is drawn: first the opaque, then the masked, then the blended.
        match self.surface {
            Surface::Body | Surface::ShadedGround | Surface::Depth => AlphaMode::Opaque,
            Surface::Shadow => AlphaMode::Mask(0.0),
            Surface::Ground | Surface::Net => AlphaMode::Blend,
        }
    }

    fn depth_bias(&self) -> f32 {
        // Nets are drawn last.
        if self.surface == Surface::Net { 1e6 } else { 0.0 }
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }

    fn specialize(
        _pipeline: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _layout: &MeshVertexBufferLayoutRef,
        key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let surface = key.bind_group_data;
        if let Some(fragment) = &mut descriptor.fragment {
            match surface {
                Surface::Depth => fragment.shader_defs.push("DEPTH".into()),
                Surface::Net => fragment.shader_defs.push("NET".into()),
                Surface::ShadedGround => fragment.shader_defs.push("SHADE".into()),
                Surface::Body | Surface::Ground | Surface::Shadow => {}
            }
            for target in fragment.targets.iter_mut().flatten() {
                match surface {
                    // The label of what is behind a string stays.
                    Surface::Net => target.write_mask = ColorWrites::COLOR,
                    Surface::Shadow => target.write_mask = ColorWrites::empty(),
                    _ => target.blend = None,
                }
            }
        }
        if let Some(depth) = &mut descriptor.depth_stencil {
            depth.depth_write_enabled = Some(surface != Surface::Net);
        }
        if surface == Surface::Shadow {
            // Flattened onto the ground, a body may be inside out.
            descriptor.primitive.cull_mode = None;
        }
        Ok(())
    }
}

//! The materials and the light of the scene.

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

/// Greatest depth that is measured, m. Everything beyond has this depth. It is also the greatest one of depth images in files.
pub(super) const MOST_DEPTH_M: f32 = 65.535;

/// Draws [`SceneMaterial`]s.
pub(super) struct SceneMaterialPlugin;

impl Plugin for SceneMaterialPlugin {
    fn build(&self, app: &mut App) {
        load_internal_asset!(app, SHADER, "scene.wgsl", Shader::from_wgsl);
        app.add_plugins(MaterialPlugin::<SceneMaterial>::default());
    }
}

/// Kind of surface of a mesh, which decides when and how it is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(super) enum Surface {
    /// A body, with light.
    Body,
    /// The ground outside shadows. It is drawn after the shadows, which hide it.
    Ground,
    /// The ground in shadow. It is drawn first.
    ShadedGround,
    /// A shadow on the ground. It has no colour, but hides the [`Ground`](Self::Ground) surface, so that the shaded ground is visible.
    Shadow,
    /// The strings of a net, which are partly transparent.
    Net,
    /// A body that is drawn with its distance instead of a colour.
    Depth,
}

/// The light, in the layout of the shader.
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
        // This only decides the order of drawing: opaque, then masked, then blended.
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
                    // The label of the object behind a string is kept.
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
            // A body that is flattened onto the ground may be inside out.
            descriptor.primitive.cull_mode = None;
        }
        Ok(())
    }
}

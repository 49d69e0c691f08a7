// A matt surface in the light of the hall: its colour, haze and tone mapping, without the shadows and highlights of Bevy's material.

#import bevy_pbr::forward_io::VertexOutput
#import bevy_pbr::mesh_view_bindings::view
#ifdef DISTANCE_FOG
#import bevy_pbr::mesh_view_bindings::fog
#import bevy_pbr::fog::linear_fog
#endif
#ifdef TONEMAP_IN_SHADER
#import bevy_core_pipeline::tonemapping::tonemapping_pbr_neutral
#endif

struct Light {
    // The light from all sides, and that from the sun on surfaces that face it, as multiples of a surface's colour.
    ambient: vec4<f32>,
    direct: vec4<f32>,
    // The direction to the sun, in the world.
    to_sun: vec4<f32>,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> light: Light;
@group(#{MATERIAL_BIND_GROUP}) @binding(1) var picture: texture_2d<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(2) var picture_sampler: sampler;

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
    var colour = light.ambient + light.direct * max(dot(normalize(in.world_normal), light.to_sun.xyz), 0.0);
#ifdef VERTEX_UVS_A
    colour *= textureSample(picture, picture_sampler, in.uv);
#endif
#ifdef VERTEX_COLORS
    colour *= in.color;
#endif
#ifdef DISTANCE_FOG
    colour = linear_fog(fog, colour, distance(in.world_position.xyz, view.world_position), vec3(0.0));
#endif
#ifdef TONEMAP_IN_SHADER
    colour = vec4(tonemapping_pbr_neutral(colour.rgb), colour.a);
#endif
    return colour;
}

// What a robot's camera sees of the scene: flat colours, one sun and light from everywhere, worked out as the software
// renderer does. The opacity carries the number of the label.

#import bevy_pbr::forward_io::VertexOutput
#import bevy_pbr::mesh_view_bindings::view

struct Light {
    // Direction to the sun, and how much light it gives.
    sun: vec4<f32>,
    // How much more light comes from a direction, and how much from everywhere.
    ambient: vec4<f32>,
    // Share of the light in a shadow; thickness of a net's string, m; how much it hides; the greatest depth, m.
    other: vec4<f32>,
}

@group(#{MATERIAL_BIND_GROUP}) @binding(0) var<uniform> light: Light;

// The target stores the square-root-like sRGB curve: what is given here comes out as it went in.
fn linear_from_srgb(colour: vec3<f32>) -> vec3<f32> {
    let low = colour / 12.92;
    let high = pow((colour + 0.055) / 1.055, vec3(2.4));
    return select(high, low, colour <= vec3(0.04045));
}

fn distance_ahead(position: vec4<f32>) -> f32 {
    // Of a reversed, endless projection the depth is near / distance.
    return view.clip_from_view[3][2] / position.z;
}

@fragment
fn fragment(in: VertexOutput) -> @location(0) vec4<f32> {
#ifdef DEPTH
    // 24 bits, in three channels.
    let steps = u32(clamp(distance_ahead(in.position) / light.other.w, 0.0, 1.0) * 16777215.0);
    let bytes = vec3(f32(steps & 255u), f32((steps >> 8u) & 255u), f32(steps >> 16u));
    return vec4(linear_from_srgb(bytes / 255.0), 1.0);
#else ifdef NET
    let focal_length = view.clip_from_view[1][1] * view.viewport.w / 2.0;
    let width = focal_length * light.other.y / distance_ahead(in.position);
    return vec4(linear_from_srgb(in.color.rgb), min(width, 1.0) * light.other.z);
#else
    var level = 256.0;
    if any(in.world_normal != vec3(0.0)) {
        let normal = normalize(in.world_normal);
        let sun = max(dot(normal, light.sun.xyz), 0.0) * light.sun.w;
        level = floor(min(light.ambient.w + dot(normal, light.ambient.xyz) + sun, 1.0) * 256.0);
    }
#ifdef SHADE
    level = light.other.x;
#endif
    let lit = floor(round(in.color.rgb * 255.0) * level / 256.0);
    return vec4(linear_from_srgb(lit / 255.0), in.color.a);
#endif
}

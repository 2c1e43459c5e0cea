"""The GLSL programs of the OpenGL renderer; the light is that of :mod:`.shading`."""

from __future__ import annotations

from doro_sim_feeder.rooms.surfaces import GLSL

PARTS_BINDING, TEXELS_BINDING = 0, 1
SHADOW_COLUMNS, SHADOW_ROWS = 3, 2

SCENE_VERTEX = """
#version 430
in vec3 in_position; in vec3 in_normal; in vec2 in_uv; in int in_part;
uniform mat4 view_to_clip; uniform vec3 eye; uniform vec3 forward;
invariant gl_Position;
out vec3 point; out vec3 normal; out vec2 uv; out float depth; flat out int part;
void main() {
    point = in_position; normal = in_normal; uv = in_uv; part = in_part;
    depth = dot(in_position - eye, forward);
    gl_Position = view_to_clip * vec4(in_position, 1.0);
}
"""

SCENE_FRAGMENT = (
    """
#version 430
struct Part {
    vec4 color_shine; vec4 exponent_pattern_instance_sheen; vec4 surface; ivec4 texture_place;
};
layout(std430, binding = 0) readonly buffer Parts { Part parts[]; };
layout(std430, binding = 1) readonly buffer Texels { uint texels[]; };
in vec3 point; in vec3 normal; in vec2 uv; in float depth; flat in int part;
uniform vec3 eye; uniform vec3 lamp; uniform vec3 lamp_color; uniform vec3 ambient_color;
uniform float ambient, sky, side, head_light, lamp_light, bounce, shadow_light, exposure, gamma;
uniform mat4 shadow_views[6]; uniform sampler2DShadow shadow_map; uniform float shadow_texel;
layout(location = 0) out vec4 out_color;
layout(location = 1) out int out_instance;
layout(location = 2) out float out_depth;

"""
    + GLSL
    + """
vec3 albedo_of(Part p) {
    ivec3 place = p.texture_place.xyz;  // offset, width, height
    ivec2 texel = ivec2(floor(fract(vec2(uv.x, 1.0 - uv.y)) * vec2(place.yz)));
    texel = min(texel, place.yz - 1);
    vec3 color = unpackUnorm4x8(texels[place.x + texel.y * place.y + texel.x]).rgb
        * p.color_shine.rgb;
    return color * pattern_tone(p.exponent_pattern_instance_sheen.y, point, color);
}

// Share of the lamp that is seen from a point; the map holds six views of 90 degrees.
float lit_share(vec3 position) {
    vec3 away = position - lamp, size = abs(away);
    int face = size.x >= size.y && size.x >= size.z ? (away.x > 0.0 ? 0 : 1)
        : size.y >= size.z ? (away.y > 0.0 ? 2 : 3) : (away.z > 0.0 ? 4 : 5);
    vec4 clip = shadow_views[face] * vec4(position, 1.0);
    vec3 at = clip.xyz / clip.w * 0.5 + 0.5;
    float seen = 0.0;
    for (int i = -2; i <= 2; i++) for (int j = -2; j <= 2; j++) {
        vec2 cell = clamp(at.xy + vec2(i, j) * shadow_texel, 0.5 * shadow_texel,
            1.0 - 0.5 * shadow_texel);
        vec2 where = (cell + vec2(face % 3, face / 3)) / vec2(3.0, 2.0);
        seen += texture(shadow_map, vec3(where, at.z - 0.0004));
    }
    return seen / 25.0;
}

void main() {
    Part p = parts[part];
    vec3 view = normalize(point - eye);
    vec3 flat_normal = normalize(cross(dFdx(point), dFdy(point)));
    if (dot(flat_normal, view) > 0.0) flat_normal = -flat_normal;  // surfaces have two sides
    vec3 n = normalize(normal);
    if (dot(n, flat_normal) < 0.0) n = -n;
    vec3 toward = normalize(lamp - point);
    float seen = dot(flat_normal, toward) <= 0.0 ? 0.0 : lit_share(point + flat_normal * 0.012);
    float lit = mix(shadow_light, 1.0, seen);
    float shade = mix(0.35, 1.0, smoothstep(-0.1, 0.3, toward.y));  // shading.shade_of
    float head = clamp(-dot(n, view), 0.0, 1.0);
    vec3 light = ambient_color * (ambient + sky * n.y + side * n.x + head_light * head
        + bounce * clamp(-n.y, 0.0, 1.0));
    light += lamp_color * lamp_light * clamp(dot(n, toward), 0.0, 1.0) * lit * shade;
    float half_way = clamp(dot(n, normalize(toward - view)), 0.0, 1.0);
    float rim = 1.0 - head;
    float shine = p.color_shine.a * (pow(half_way, p.exponent_pattern_instance_sheen.x)
        * seen * shade + 0.25 * pow(rim, 4.0));
    vec3 albedo = albedo_of(p), tint = sqrt(albedo);  // surface: diffuse, mirror, clear
    vec3 behind = ambient_color * room_light(view) * (0.35 + 0.65 * albedo);
    vec3 shown = mix(albedo * light * p.surface.x, behind, p.surface.z * head);
    shown += ambient_color * p.surface.y * room_light(reflect(view, n)) * mix(vec3(1.0), tint,
        p.surface.x < 1.0 ? 1.0 : 0.0);
    shown += p.exponent_pattern_instance_sheen.w * rim * rim * light * tint;
    vec3 color = clamp((shown + shine) * exposure, 0.0, 1.0);
    out_color = vec4(pow(color, vec3(gamma)), 1.0);
    out_instance = int(p.exponent_pattern_instance_sheen.z);
    out_depth = depth;
}
"""
)

GEOMETRY_FRAGMENT = """
#version 430
struct Part {
    vec4 color_shine; vec4 exponent_pattern_instance_sheen; vec4 surface; ivec4 texture_place;
};
layout(std430, binding = 0) readonly buffer Parts { Part parts[]; };
in float depth; flat in int part;
layout(location = 1) out int out_instance;
layout(location = 2) out float out_depth;
void main() {
    out_instance = int(parts[part].exponent_pattern_instance_sheen.z);
    out_depth = depth;
}
"""

DEPTH_VERTEX = """
#version 430
in vec3 in_position; uniform mat4 view_to_clip;
invariant gl_Position;
void main() { gl_Position = view_to_clip * vec4(in_position, 1.0); }
"""

DEPTH_FRAGMENT = """
#version 430
void main() {}
"""

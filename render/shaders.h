#pragma once

// Holds GLSL 3.30 sources. Colours are linear light until the last line of a shader. Attributes and uniforms are named
// as in draw_list.h and views.h.
namespace kerf::render {

inline constexpr const char* kShaderVersion = "#version 330 core\n";

// Draws sheets, solids and ground.
inline constexpr const char* kSurfaceVertexShader = R"(
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec2 a_material;
layout(location = 3) in vec4 a_tint;
layout(location = 4) in float a_look;
uniform mat4 u_clip_from_world;
uniform float u_clip_z_offset;
out vec3 v_world;
out vec3 v_normal;
out vec2 v_material;
out vec3 v_tint;
out float v_ridge;
out vec3 v_barycentric;
flat out int v_look;

void main() {
  v_look = int(a_look);
  v_world = a_position;
  v_normal = a_normal;
  v_material = a_material;
  v_tint = a_tint.rgb * (255.0 / 128.0);
  v_ridge = (a_tint.a - 128.0 / 255.0) * (255.0 / 127.0);
  int corner = gl_VertexID % 3;
  v_barycentric = vec3(corner == 0, corner == 1, corner == 2);
  gl_Position = u_clip_from_world * vec4(a_position, 1.0);
  gl_Position.z += u_clip_z_offset;
}
)";

// Code shared by the fragment shaders below: shadows, and light from a sky above, a key light and the viewer's side.
inline constexpr const char* kLightingShader = R"(
in vec3 v_world;
in vec3 v_normal;
in vec2 v_material;
in vec3 v_tint;
in float v_ridge;
in vec3 v_barycentric;
flat in int v_look;
uniform vec3 u_eye;
uniform vec3 u_up;
uniform vec3 u_to_light;
uniform vec3 u_light_sky;
uniform vec3 u_light_below;
uniform vec3 u_light_key;
uniform bool u_shadows;
uniform mat4 u_shadow_from_world;
uniform float u_shadow_texel_m;
uniform float u_shadow_texel;
uniform float u_penumbra_texels;
uniform sampler2DShadow u_shadow_map;
out vec4 f_colour;

// Twelve places spread evenly over the unit disc (Vogel's spiral), four outer ones first.
const vec2 kDisc[12] = vec2[](
    vec2(0.790, 0.289), vec2(-0.819, 0.347), vec2(0.391, -0.849), vec2(0.301, 0.931),
    vec2(0.204, 0.000), vec2(-0.261, 0.239), vec2(0.040, -0.455), vec2(0.328, 0.429),
    vec2(-0.603, -0.107), vec2(0.571, -0.363), vec2(-0.191, 0.711), vec2(-0.361, -0.704));

// Returns the share of the key light that reaches a point, in [0, 1]. `n`: unit normal on the side that the light falls
// on. The point is lifted along it by 2.5 texels; without that, the shadow map's steps would show as stripes.
float light_visibility(vec3 point, vec3 n) {
  if (!u_shadows) return 1.0;
  vec4 clip = u_shadow_from_world * vec4(point + 2.5 * u_shadow_texel_m * n, 1.0);
  vec3 place = 0.5 * clip.xyz + 0.5;
  if (any(lessThan(place, vec3(0.0))) || any(greaterThan(place.xy, vec2(1.0)))) return 1.0;
  place.z = min(place.z, 1.0);  // The ground may be farther away than all that casts shadows.
  float sum = 0.0;
  for (int i = 0; i < 12; ++i) {
    if (i == 4 && (sum == 0.0 || sum == 4.0)) return 0.25 * sum;  // all four lit or all four in shadow: no edge is near
    sum += texture(u_shadow_map, vec3(place.xy + u_penumbra_texels * u_shadow_texel * kDisc[i], place.z));
  }
  return sum / 12.0;
}

// Returns the share of the key light in the highlight, by the reflection of B. Walter et al., "Microfacet models for
// refraction through rough surfaces" (2007), of a surface that reflects 4 % head-on.
float highlight(vec3 n, vec3 to_eye, float roughness) {
  float to_light = dot(n, u_to_light);
  float facing = dot(n, to_eye);
  if (to_light <= 0.0 || facing <= 0.0) return 0.0;
  vec3 halfway = normalize(u_to_light + to_eye);
  float a2 = pow(max(roughness, 0.0525), 4.0);
  float near = dot(n, halfway);
  float d = near * near * (a2 - 1.0) + 1.0;
  float spread = a2 / (d * d);  // Times 1 / pi, which the key light's unit has.
  float masked = 0.5 / (to_light * sqrt(a2 + (1.0 - a2) * facing * facing) +
                        facing * sqrt(a2 + (1.0 - a2) * to_light * to_light));
  float grazing = 1.0 - dot(to_eye, halfway);
  float grazing2 = grazing * grazing;
  return (0.04 + 0.96 * grazing2 * grazing2 * grazing) * masked * spread * to_light;
}

// Returns the colour of a lit surface. `roughness` in (0, 1]; `translucency` in [0, 1]: share of the light on the other
// side that comes through; `open` in [0, 2]: how much of the sky is seen, 1 on flat parts.
vec3 shade(vec3 albedo, vec3 n, float roughness, float translucency, float open) {
  vec3 to_eye = normalize(u_eye - v_world);
  float towards_light = dot(n, u_to_light);
  float visible = light_visibility(v_world, towards_light >= 0.0 ? n : -n);
  vec3 ambient = mix(u_light_below, u_light_sky, 0.5 + 0.5 * dot(n, u_up));
  vec3 key = u_light_key * visible;
  vec3 diffuse = key * (max(towards_light, 0.0) + translucency * max(-towards_light, 0.0));
  vec3 light = open * ambient + mix(1.0, open, 0.35) * diffuse;
  return albedo * light + key * highlight(n, to_eye, roughness);
}

// Approximates the sRGB curve by square roots, within 0.001 for values from 0.003 up (I. Taylor, "sRGB approximations
// for HLSL").
vec4 to_srgb(vec3 linear, float alpha) {
  vec3 c = clamp(linear, 0.0, 1.0);
  vec3 c2 = sqrt(c);
  vec3 c4 = sqrt(c2);
  vec3 c8 = sqrt(c4);
  return vec4(0.662002687 * c2 + 0.684122060 * c4 - 0.323583601 * c8 - 0.0225411470 * c, alpha);
}

vec3 unit(vec3 v, vec3 otherwise) {
  float square = dot(v, v);
  return square > 0.0 ? v * inversesqrt(square) : otherwise;
}
)";

inline constexpr const char* kSolidFragmentShader = R"(
uniform vec3 u_solids;

void main() {
  vec3 n = unit(v_normal, u_up);
  f_colour = to_srgb(shade(u_solids, n, 0.6, 0.0, 1.0), 1.0);
}
)";

// Draws a disc that fades out, with a grid, darkened by shadows and by objects that hide the sky.
inline constexpr const char* kGroundFragmentShader = R"(
uniform vec3 u_ground;
uniform vec3 u_ground_lines;

// Returns coordinates in the ground's plane: those of the world, turned the shortest way from `n` to z.
vec2 in_plane(vec3 n) {
  vec3 along = n + vec3(0.0, 0.0, 1.0);
  return n.z < -0.999 ? vec2(v_world.x, -v_world.y) : (v_world - dot(along, v_world) / (1.0 + n.z) * along).xy;
}

float grid_line(vec2 t) {
  vec2 blur = max(fwidth(t), vec2(1e-4));
  vec2 distance = abs(fract(t - 0.5) - 0.5) / blur;
  return (1.0 - min(min(distance.x, distance.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(blur.x, blur.y)));
}

void main() {
  vec3 n = unit(v_normal, u_up);
  vec2 place = in_plane(n);
  float lines = max(0.5 * grid_line(10.0 * place), grid_line(place));
  float r = length(v_material);
  if (!gl_FrontFacing || r > 1.0) discard;
  float towards_light = max(dot(n, u_to_light), 0.0);
  vec3 light = u_light_sky + u_light_key * towards_light * light_visibility(v_world, n);
  vec3 colour = mix(u_ground, u_ground_lines, 0.35 * lines) * light * v_tint.r;
  f_colour = to_srgb(colour, 1.0 - smoothstep(0.35, 1.0, r));
}
)";

// Draws the background over the whole picture, from one colour at the top to another.
inline constexpr const char* kBackdropVertexShader = R"(
out float v_down;

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  v_down = 0.5 - 0.5 * corner.y;
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

inline constexpr const char* kBackdropFragmentShader = R"(
in float v_down;
uniform vec3 u_above;
uniform vec3 u_below;
out vec4 f_colour;

void main() { f_colour = vec4(mix(u_above, u_below, v_down), 1.0); }
)";

// Draws the lips: strips of constant width in the image along borders, inside the sheet. There is one instance per
// segment, with six vertices. Strips are shaded as rounded over the edge, so that one of the two lips of a cut catches
// the light. v_material.x is 0 on the edge and 1 on the inner side; v_tint is the vector inwards.
inline constexpr const char* kLipVertexShader = R"(
layout(location = 0) in vec3 a_start;
layout(location = 1) in vec3 a_end;
layout(location = 2) in vec3 a_start_inward;
layout(location = 3) in vec3 a_end_inward;
layout(location = 4) in vec3 a_start_normal;
layout(location = 5) in vec3 a_end_normal;
layout(location = 6) in float a_look;
uniform mat4 u_clip_from_world;
uniform float u_clip_z_offset;
uniform float u_width_fraction;
uniform float u_max_width_m;
out vec3 v_world;
out vec3 v_normal;
out vec2 v_material;
out vec3 v_tint;
out float v_ridge;
out vec3 v_barycentric;
flat out int v_look;

const vec2 kCorners[6] = vec2[](vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 0), vec2(1, 1), vec2(0, 1));

void main() {
  vec2 corner = kCorners[gl_VertexID];
  bool at_end = corner.x > 0.5;
  vec3 edge = at_end ? a_end : a_start;
  vec3 inward = at_end ? a_end_inward : a_start_inward;
  float distance = (u_clip_from_world * vec4(edge, 1.0)).w;
  v_world = edge + corner.y * min(u_width_fraction * distance, u_max_width_m) * inward;
  v_normal = at_end ? a_end_normal : a_start_normal;
  v_material = vec2(corner.y, 0.0);
  v_tint = inward;
  v_ridge = 0.0;
  v_barycentric = vec3(0.0);
  v_look = int(a_look);
  gl_Position = u_clip_from_world * vec4(v_world, 1.0);
  gl_Position.z += u_clip_z_offset;
}
)";

inline constexpr const char* kLipFragmentShader = R"(
uniform vec3 u_lip[16];

void main() {
  vec3 n = unit(v_normal, u_up);
  if (dot(n, u_eye - v_world) < 0.0) n = -n;
  vec3 rounded = normalize(n - 0.9 * (1.0 - v_material.x) * unit(v_tint, vec3(0.0)));
  f_colour = to_srgb(shade(u_lip[v_look], rounded, 0.6, 0.1, 1.0), 1.0);
}
)";

// Draws lines of constant width in the image, with round ends: one instance per segment, with six vertices.
inline constexpr const char* kLineVertexShader = R"(
layout(location = 0) in vec3 a_start;
layout(location = 1) in vec3 a_end;
uniform mat4 u_clip_from_world;
uniform float u_clip_z_offset;
uniform vec2 u_half_viewport_px;
uniform float u_half_width_px;
out vec2 v_place_px;
flat out vec2 v_start_px;
flat out vec2 v_end_px;

const vec2 kCorners[6] = vec2[](vec2(0, -1), vec2(1, -1), vec2(1, 1), vec2(0, -1), vec2(1, 1), vec2(0, 1));

// Returns the end `a` of the segment from `a` to `b`, or its point on the near plane if `a` alone is behind that plane.
vec4 before_near_plane(vec4 a, vec4 b) {
  float inside_a = a.z + a.w;
  float inside_b = b.z + b.w;
  return inside_a >= 0.0 || inside_b <= 0.0 ? a : mix(a, b, inside_a / (inside_a - inside_b));
}

void main() {
  vec4 start = u_clip_from_world * vec4(a_start, 1.0);
  vec4 end = u_clip_from_world * vec4(a_end, 1.0);
  if (start.z < -start.w && end.z < -end.w) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    v_place_px = v_start_px = v_end_px = vec2(0.0);
    return;
  }
  start = before_near_plane(start, end);
  end = before_near_plane(end, start);
  v_start_px = start.xy / start.w * u_half_viewport_px;
  v_end_px = end.xy / end.w * u_half_viewport_px;
  vec2 along = v_end_px - v_start_px;
  float length_px = length(along);
  along = length_px > 1e-6 ? along / length_px : vec2(1.0, 0.0);
  vec2 corner = kCorners[gl_VertexID];
  bool at_end = corner.x > 0.5;
  float reach = u_half_width_px + 1.0;
  v_place_px = (at_end ? v_end_px : v_start_px) +
               reach * (corner.y * vec2(-along.y, along.x) + (at_end ? along : -along));
  vec4 clip = at_end ? end : start;
  gl_Position = vec4(v_place_px / u_half_viewport_px, (clip.z + u_clip_z_offset) / clip.w, 1.0);
}
)";

inline constexpr const char* kLineFragmentShader = R"(
in vec2 v_place_px;
flat in vec2 v_start_px;
flat in vec2 v_end_px;
uniform float u_half_width_px;
out vec4 f_colour;

void main() {
  vec2 along = v_end_px - v_start_px;
  float t = clamp(dot(v_place_px - v_start_px, along) / max(dot(along, along), 1e-9), 0.0, 1.0);
  float away_px = distance(v_place_px, v_start_px + t * along);
  float cover = 1.0 - smoothstep(u_half_width_px - 0.5, u_half_width_px + 0.5, away_px);
  if (cover <= 0.0) discard;
  f_colour = vec4(0.07, 0.08, 0.11, 0.9 * cover);
}
)";

inline constexpr const char* kShadowVertexShader = R"(
layout(location = 0) in vec3 a_position;
uniform mat4 u_shadow_from_world;

void main() { gl_Position = u_shadow_from_world * vec4(a_position, 1.0); }
)";

inline constexpr const char* kShadowFragmentShader = R"(
void main() {}
)";

}  // namespace kerf::render

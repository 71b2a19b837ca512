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
uniform vec3 u_background;
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
  if (any(lessThan(place, vec3(0.0))) || any(greaterThan(place, vec3(1.0)))) return 1.0;
  float sum = 0.0;
  for (int i = 0; i < 12; ++i) {
    if (i == 4 && (sum == 0.0 || sum == 4.0)) return 0.25 * sum;  // all four lit or all four in shadow: no edge is near
    sum += texture(u_shadow_map, vec3(place.xy + u_penumbra_texels * u_shadow_texel * kDisc[i], place.z));
  }
  return sum / 12.0;
}

// Returns the colour of a lit surface. `gloss` in [0, 1]: strength of the highlight; `translucency` in [0, 1]: share of
// the light on the other side that comes through; `open` in [0, 2]: how much of the sky is seen, 1 on flat parts.
vec3 shade(vec3 albedo, vec3 n, float gloss, float translucency, float open) {
  vec3 to_eye = normalize(u_eye - v_world);
  float facing = clamp(dot(n, to_eye), 0.0, 1.0);
  float towards_light = dot(n, u_to_light);
  float visible = light_visibility(v_world, towards_light >= 0.0 ? n : -n);
  vec3 ambient = mix(vec3(0.17, 0.155, 0.15), vec3(0.42, 0.45, 0.50), 0.5 + 0.5 * dot(n, u_up));
  vec3 key = vec3(0.98, 0.94, 0.86) * visible *
             (max(towards_light, 0.0) + translucency * max(-towards_light, 0.0));
  vec3 light = open * (ambient + vec3(0.10) * facing) + mix(1.0, open, 0.35) * key;
  vec3 halfway = normalize(u_to_light + to_eye);
  float shine = max(dot(n, halfway), 0.0);
  for (int i = 0; i < 3; ++i) shine *= shine;
  shine *= shine * shine;  // to the power of 24
  float highlight = gloss * visible * shine * step(0.0, towards_light);
  float edge = 1.0 - facing;
  float rim = 0.14 * edge * edge * edge * (0.5 + 0.5 * dot(n, u_up));
  return albedo * light + vec3(0.22 * highlight) + vec3(rim) * mix(vec3(0.8), albedo, 0.5);
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

inline constexpr const char* kSheetFragmentShader = R"(
// One for each look; kMaxLooks of renderer.h.
uniform vec3 u_front[16];
uniform vec3 u_back[16];
uniform bool u_banded[16];
uniform bool u_own_dye[16];
uniform vec3 u_front_dye[16];
uniform vec3 u_back_dye[16];
uniform float u_threads[16];
uniform float u_gloss[16];
uniform float u_translucency[16];
uniform float u_mirror[16];
uniform bool u_textured;
uniform bool u_coloured;
uniform bool u_wireframe;
uniform float u_wire_width_px;

const float kThreads = 16.0;  // per check

float hash(float n) { return fract(sin(n * 12.9898) * 43758.5453); }

// Returns 1 for a pattern with a period of 4 pixels or more, 0 for one below 1.6 pixels, which would only flicker.
float resolved(float period_px) { return smoothstep(1.6, 4.0, period_px); }

// Makes cloth of dyed and plain bands, as wide as a check, in both directions; at each place the thread of one
// direction lies on top. Returns the share of dye seen, in [0, 1], and the lightness of the thread, about 1. `p`:
// place; `footprint`: size of a pixel, both in checks. Threads, and at lower resolution bands, are averaged where a
// pixel holds several.
vec2 cloth(vec2 p, vec2 footprint) {
  vec2 wave = 2.0 * (abs(fract((p - 0.5 * footprint) * 0.5) - 0.5) - abs(fract((p + 0.5 * footprint) * 0.5) - 0.5)) /
              footprint;
  vec2 dyed = 0.5 - 0.5 * wave;
  float mean = 0.5 * (dyed.x + dyed.y);
  float check_px = 1.0 / max(footprint.x, footprint.y);
  float slubs = 0.09 * resolved(0.25 * check_px);  // yarn is thicker here and thinner there
  vec2 uneven = vec2(hash(floor(4.0 * p.x + 0.5)), hash(floor(4.0 * p.y + 0.5) + 71.0)) - 0.5;
  float light = 1.0 + slubs * (uneven.x + uneven.y);
  float seen = u_wireframe ? 0.0 : resolved(check_px / kThreads);
  if (seen == 0.0) return vec2(mean, light);
  vec2 along = kThreads * p;
  vec2 thread = floor(along);
  vec2 across = 2.0 * fract(along) - 1.0;
  bool warp = mod(thread.x + thread.y, 2.0) < 0.5;
  vec2 place = warp ? across : across.yx;  // across and along the thread on top
  float height = (1.0 - place.x * place.x) * (1.0 - 0.5 * place.y * place.y);
  float yarn = hash(warp ? thread.x : thread.y + 71.0) - 0.5;
  float dye = mix(mean, warp ? dyed.x : dyed.y, 0.75 * seen);
  return vec2(dye, light + seen * (0.62 * (height - 0.5556) + 0.14 * yarn));
}

// Returns the share of the wire's colour, less where triangles are only a few pixels high, so that the surface stays
// visible. `per_px`: change of each barycentric coordinate over a pixel.
float wire(vec3 per_px) {
  vec3 distance_px = v_barycentric / per_px;
  float nearest = min(distance_px.x, min(distance_px.y, distance_px.z));
  float line = 1.0 - smoothstep(0.5 * u_wire_width_px - 0.5, 0.5 * u_wire_width_px + 0.5, nearest);
  float height_px = 1.0 / max(per_px.x, max(per_px.y, per_px.z));
  return line * mix(0.25, 0.76, smoothstep(1.5, 7.0, height_px / u_wire_width_px));
}

void main() {
  // Takes derivatives before any branch: inside one they are undefined, and wrong along edges in llvmpipe.
  vec2 footprint = max(fwidth(v_material), vec2(1e-4));
  vec3 over_x = dFdx(v_barycentric);
  vec3 over_y = dFdy(v_barycentric);
  vec3 n = unit(v_normal, u_up);
  float ridge = v_ridge;
  if (!gl_FrontFacing) {
    n = -n;
    ridge = -ridge;
  }
  vec3 colour;
  if (u_coloured) {
    // Colours are read against a legend: there is neither pattern nor shadow, and only a little shading, to show folds.
    float facing = abs(dot(n, normalize(u_eye - v_world)));
    colour = mix(0.85, 1.0, facing) * pow(v_tint * (128.0 / 255.0), vec3(2.2));
  } else {
    vec3 albedo = (gl_FrontFacing ? u_front[v_look] : u_back[v_look]) * v_tint;
    if (u_textured) {
      vec2 woven = cloth(v_material, footprint);
      float dye = u_wireframe ? mix(0.5, woven.x, 0.35) : woven.x;  // fainter, so that wires stand out
      if (u_own_dye[v_look]) {
        albedo = mix(albedo, (gl_FrontFacing ? u_front_dye[v_look] : u_back_dye[v_look]) * v_tint, 0.92 * dye);
      } else if (u_banded[v_look]) {
        albedo = mix(mix(albedo, vec3(0.72), 0.55), 0.62 * albedo, dye);
      }
      albedo *= mix(1.0, woven.y, u_threads[v_look]);
    }
    colour = shade(albedo, n, u_gloss[v_look], u_translucency[v_look], 1.0 + (ridge > 0.0 ? 0.25 : 0.75) * ridge);
    if (u_mirror[v_look] > 0.0) {
      float towards_sky = dot(reflect(normalize(v_world - u_eye), n), u_up);
      vec3 surroundings = albedo * mix(vec3(0.22, 0.24, 0.27), vec3(1.25), smoothstep(-0.35, 0.75, towards_sky));
      colour = mix(colour, surroundings, u_mirror[v_look]);
    }
  }
  if (u_wireframe) {
    vec3 per_px = max(sqrt(over_x * over_x + over_y * over_y), vec3(1e-9));
    colour = mix(colour, vec3(0.012, 0.016, 0.025), wire(per_px));
  }
  f_colour = to_srgb(colour, 1.0);
}
)";

inline constexpr const char* kSolidFragmentShader = R"(
void main() {
  vec3 n = unit(v_normal, u_up);
  f_colour = to_srgb(shade(vec3(0.52, 0.52, 0.50), n, 0.6, 0.0, 1.0), 1.0);
}
)";

// Draws a disc of the background's colour that fades out, darkened by shadows and by objects that hide the sky.
inline constexpr const char* kGroundFragmentShader = R"(
void main() {
  float r = length(v_material);
  if (!gl_FrontFacing || r > 1.0) discard;
  vec3 n = unit(v_normal, u_up);
  float light = mix(0.46, 0.86, light_visibility(v_world, n)) * v_tint.r;
  f_colour = to_srgb(u_background * light, 1.0 - smoothstep(0.25, 1.0, r));
}
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
  f_colour = to_srgb(shade(u_lip[v_look], rounded, 0.3, 0.1, 1.0), 1.0);
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

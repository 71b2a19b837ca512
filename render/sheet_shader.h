#pragma once

// Holds the GLSL source that draws a sheet; see shaders.h.
namespace kerf::render {

inline constexpr const char* kSheetFragmentShader = R"(
// One for each look; kMaxLooks of renderer.h.
uniform vec3 u_front[16];
uniform vec3 u_back[16];
uniform vec3 u_front_dye[16];
uniform vec3 u_back_dye[16];
uniform vec3 u_second[16];
uniform float u_pattern[16];
uniform float u_contrast[16];
uniform float u_grid[16];
uniform float u_roughness[16];
uniform float u_sheen[16];
uniform float u_translucency[16];
uniform float u_mirror[16];
uniform bool u_textured;
uniform bool u_coloured;
uniform bool u_wireframe;
uniform float u_wire_width_px;

// The patterns are those of web/src/scene/cloth_material.ts. Lengths are in pairs of a light and a dark band; `blur` is
// the change of a place over a pixel.

float band(float t, float blur) {
  float distance = abs(fract(t + 0.25) - 0.5);
  float edge = smoothstep(0.25 - blur, 0.25 + blur, distance);
  return mix(edge, 0.5, smoothstep(0.4, 1.2, blur));
}

// Returns 1 for a pattern with a period of several pixels, 0 for one that would only flicker.
float resolved(vec2 blur) { return 1.0 - smoothstep(0.15, 0.5, max(blur.x, blur.y)); }

float grid_line(vec2 t, vec2 blur) {
  vec2 distance = abs(fract(t + 0.5) - 0.5) / blur;
  return (1.0 - min(min(distance.x, distance.y), 1.0)) * (1.0 - smoothstep(0.1, 0.3, max(blur.x, blur.y)));
}

float hash(vec2 p) { return fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453); }

float noise(vec2 p) {
  vec2 cell = floor(p);
  vec2 f = smoothstep(0.0, 1.0, fract(p));
  float below = mix(hash(cell), hash(cell + vec2(1.0, 0.0)), f.x);
  float above = mix(hash(cell + vec2(0.0, 1.0)), hash(cell + 1.0), f.x);
  return mix(below, above, f.y) - 0.5;
}

float weave(vec2 t, vec2 blur) {
  vec2 thread = 6.2832 * 24.0 * t;
  return sin(thread.x) * sin(thread.y) * resolved(24.0 * blur);
}

// Returns the colour of the cloth at a place.
vec3 cloth(vec3 color, vec2 t, vec2 blur) {
  float contrast = u_contrast[v_look];
  int pattern = int(u_pattern[v_look]);
  if (pattern == 0) {
    float bands = 0.5 * (band(t.x, blur.x) + band(t.y, blur.y));
    vec3 dye = gl_FrontFacing ? u_front_dye[v_look] : u_back_dye[v_look];
    return mix(color, dye, bands * (gl_FrontFacing ? 0.92 : 0.6)) * (1.0 + contrast * weave(t, blur));
  }
  if (pattern == 1) {
    color *= 1.0 + contrast * weave(t, blur);
  } else if (pattern == 2) {
    float rib = 0.5 + 0.5 * sin(3.1416 * 24.0 * (t.x + t.y)) * resolved(24.0 * blur);
    color = mix(color, u_second[v_look], contrast * rib);
  } else if (pattern == 3) {
    float spots = noise(6.0 * t) * resolved(3.0 * blur) + noise(31.0 * t) * resolved(16.0 * blur);
    color *= 1.0 + contrast * spots;
  } else {
    vec2 loop = 12.0 * t;
    float row = loop.y + abs(fract(loop.x) - 0.5);
    float yarn = sin(6.2832 * row) * resolved(12.0 * blur);
    color *= 1.0 + contrast * (0.5 * yarn + noise(9.0 * t) * resolved(5.0 * blur));
  }
  return color * (1.0 - u_grid[v_look] * grid_line(t, blur));
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
  vec2 blur = max(fwidth(v_material), vec2(1e-4));
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
    vec3 albedo = (gl_FrontFacing ? u_front[v_look] : u_back[v_look]);
    if (u_textured) albedo = cloth(albedo, v_material, blur);
    albedo *= v_tint;
    float open = 1.0 + (ridge > 0.0 ? 0.25 : 0.75) * ridge;
    colour = shade(albedo, n, u_roughness[v_look], u_translucency[v_look], open);
    vec3 to_eye = normalize(u_eye - v_world);
    float edge = 1.0 - abs(dot(n, to_eye));
    colour += u_sheen[v_look] * edge * edge * edge * mix(albedo, vec3(1.0), 0.4);
    float towards_sky = dot(reflect(-to_eye, n), u_up);
    vec3 surroundings = albedo * mix(vec3(0.22, 0.24, 0.27), vec3(1.25), smoothstep(-0.35, 0.75, towards_sky));
    colour = mix(colour, surroundings + 0.35 * (colour - 0.3 * albedo), u_mirror[v_look]);
  }
  if (u_wireframe) {
    vec3 per_px = max(sqrt(over_x * over_x + over_y * over_y), vec3(1e-9));
    colour = mix(colour, vec3(0.012, 0.016, 0.025), wire(per_px));
  }
  f_colour = to_srgb(colour, 1.0);
}
)";

}  // namespace kerf::render

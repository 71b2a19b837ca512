import { Color, DoubleSide, MeshStandardMaterial, Vector2 } from 'three';
import type { IUniform } from 'three';
import type { Point2 } from '../geometry/locator';
import { kClothOffset } from './depth_offsets';
import { kLooks } from './material_looks';
import type { MaterialLook } from './material_looks';

// Patterns in material coordinates, filtered to the size of a pixel, show stretch and shear. The two sides differ in
// colour, which shows folds. Colours of vertices (hasOwnColors) replace both.
const kPattern = /* glsl */ `
  uniform float checkSize;
  uniform vec2 checkOrigin;
  uniform bool hasOwnColors;
  uniform int pattern;
  uniform vec3 frontColor;
  uniform vec3 backColor;
  uniform vec3 secondColor;
  uniform float contrast;
  uniform float grid;
  uniform float sheen;
  uniform float translucency;
  uniform float mirrored;
  varying vec3 vOwnColor;

  // 0 in the light half of a band and 1 in the dark one.
  float band(float t) {
    float blur = max(fwidth(t), 1e-4);
    float distance = abs(fract(t + 0.25) - 0.5);
    float edge = smoothstep(0.25 - blur, 0.25 + blur, distance);
    return mix(edge, 0.5, smoothstep(0.4, 1.2, blur));
  }

  // 1 for a pattern with a period of several pixels, 0 for one that would only flicker.
  float resolved(vec2 period) {
    return 1.0 - smoothstep(0.15, 0.5, max(fwidth(period.x), fwidth(period.y)));
  }

  float gridLine(vec2 t) {
    vec2 width = max(fwidth(t), vec2(1e-4));
    vec2 distance = abs(fract(t + 0.5) - 0.5) / width;
    return (1.0 - min(min(distance.x, distance.y), 1.0)) * (1.0 - smoothstep(0.1, 0.3, max(width.x, width.y)));
  }

  float hash(vec2 p) {
    return fract(sin(dot(p, vec2(12.9898, 78.233))) * 43758.5453);
  }

  float noise(vec2 p) {
    vec2 cell = floor(p);
    vec2 f = smoothstep(0.0, 1.0, fract(p));
    float below = mix(hash(cell), hash(cell + vec2(1.0, 0.0)), f.x);
    float above = mix(hash(cell + vec2(0.0, 1.0)), hash(cell + 1.0), f.x);
    return mix(below, above, f.y) - 0.5;
  }

  vec3 gingham(vec2 t, bool isFront) {
    float bands = 0.5 * (band(t.x) + band(t.y));
    vec2 thread = t * 24.0;
    float weave = sin(6.2832 * thread.x) * sin(6.2832 * thread.y) * resolved(thread);
    // Linear light: linen #ebe7da and indigo #1b4c7f in front, apricot #f0b48b and brick #b6472f behind.
    vec3 dark = isFront ? vec3(0.012, 0.072, 0.21) : vec3(0.47, 0.065, 0.03);
    vec3 color = mix(isFront ? frontColor : backColor, dark, bands * (isFront ? 0.92 : 0.6));
    return color * (1.0 + contrast * weave);
  }

  vec3 clothColor(vec2 material, bool isFront) {
    vec2 t = (material - checkOrigin) / checkSize;
    if (pattern == 0) return gingham(t, isFront);
    vec3 color = isFront ? frontColor : backColor;
    vec2 thread = t * 24.0;
    if (pattern == 1) {
      color *= 1.0 + contrast * sin(6.2832 * thread.x) * sin(6.2832 * thread.y) * resolved(thread);
    } else if (pattern == 2) {
      float rib = 0.5 + 0.5 * sin(3.1416 * (thread.x + thread.y)) * resolved(thread);
      color = mix(color, secondColor, contrast * rib);
    } else if (pattern == 3) {
      color *= 1.0 + contrast * (noise(6.0 * t) * resolved(3.0 * t) + noise(31.0 * t) * resolved(16.0 * t));
    } else {
      vec2 loop = 0.5 * thread;
      float row = loop.y + abs(fract(loop.x) - 0.5);
      float yarn = sin(6.2832 * row) * resolved(loop);
      color *= 1.0 + contrast * (0.5 * yarn + noise(9.0 * t) * resolved(5.0 * t));
    }
    return color * (1.0 - grid * gridLine(t));
  }

  // Colours that say something are read against a legend: neither pattern nor shadow, and little shading, for folds.
  vec3 readableColor(vec3 normal, vec3 toEye) {
    return vOwnColor * mix(0.85, 1.0, abs(dot(normal, toEye)));
  }

  // Light that lies on fibres seen edge-on, that comes through from behind, and that a mirror reflects from the sky.
  vec3 finished(vec3 light, vec3 color, vec3 normal, vec3 toEye) {
    float edge = 1.0 - abs(dot(normal, toEye));
    light += sheen * edge * edge * edge * mix(color, vec3(1.0), 0.4);
    #if NUM_DIR_LIGHTS > 0
      float behind = max(0.0, -dot(normal, directionalLights[0].direction));
      light += translucency * behind * directionalLights[0].color * RECIPROCAL_PI * color;
    #endif
    float towardsSky = dot(reflect(-toEye, normal), (viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).xyz);
    vec3 surroundings = color * mix(vec3(0.22, 0.24, 0.27), vec3(1.25), smoothstep(-0.35, 0.75, towardsSky));
    return mix(light, surroundings + 0.35 * (light - color * 0.3), mirrored);
  }
`;

export class ClothMaterial extends MeshStandardMaterial {
  private readonly own = {
    checkSize: { value: 0.1 },
    checkOrigin: { value: new Vector2() },
    hasOwnColors: { value: false },
    pattern: { value: 0 },
    frontColor: { value: new Color() },
    backColor: { value: new Color() },
    secondColor: { value: new Color() },
    contrast: { value: 0 },
    grid: { value: 0 },
    sheen: { value: 0 },
    translucency: { value: 0 },
    mirrored: { value: 0 },
  } satisfies Record<string, IUniform>;

  constructor() {
    super({
      side: DoubleSide,
      shadowSide: DoubleSide,
      metalness: 0,
      ...kClothOffset,
    });
    this.setLook(kLooks.demo);
    this.defines = { ...this.defines, USE_UV: '' };
    this.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.own);
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nattribute vec3 ownColor;\nvarying vec3 vOwnColor;')
        .replace('#include <begin_vertex>', '#include <begin_vertex>\nvOwnColor = ownColor;');
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <lights_pars_begin>', `#include <lights_pars_begin>\n${kPattern}`)
        .replace('#include <color_fragment>', 'diffuseColor.rgb = clothColor(vUv, gl_FrontFacing);')
        .replace(
          '#include <opaque_fragment>',
          `outgoingLight = hasOwnColors
            ? readableColor(normal, normalize(vViewPosition))
            : finished(outgoingLight, diffuseColor.rgb, normal, normalize(vViewPosition));
          #include <opaque_fragment>`,
        );
    };
  }

  setLook(look: MaterialLook): void {
    const { own } = this;
    this.roughness = look.roughness;
    own.pattern.value = look.pattern;
    own.frontColor.value.set(look.front);
    own.backColor.value.set(look.back);
    own.secondColor.value.set(look.second);
    own.contrast.value = look.contrast;
    own.grid.value = look.grid;
    own.sheen.value = look.sheen;
    own.translucency.value = look.translucency;
    own.mirrored.value = look.mirror;
  }

  /**
   * Places the pattern. The server's pictures have the same patterns (render/shaders.h).
   * @param size    metres, > 0: width of a light and a dark band together
   * @param origin  the place on the undeformed sheet where a light band begins, metres
   */
  setChecks(size: number, origin: Point2): void {
    this.own.checkSize.value = size;
    this.own.checkOrigin.value.set(origin.x, origin.y);
  }

  /** Colours the sheet by the vertex attribute `ownColor` (linear) instead of the cloth's own colours. */
  setOwnColors(isOn: boolean): void {
    this.own.hasOwnColors.value = isOn;
  }
}

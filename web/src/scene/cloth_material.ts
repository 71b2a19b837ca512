import { DoubleSide, MeshStandardMaterial } from 'three';
import type { IUniform } from 'three';
import { kClothOffset } from './depth_offsets';

// Checks of woven bands in material coordinates, filtered to the size of a pixel, show stretch and shear. The two sides
// differ in colour, which shows folds. Colours of vertices (hasOwnColors) replace both.
const kPattern = /* glsl */ `
  uniform float checkSize;
  uniform bool hasOwnColors;
  varying vec3 vOwnColor;

  float band(float t, float halfWidth) {
    float blur = max(fwidth(t), 1e-4);
    float distance = abs(fract(t) - 0.5);
    float edge = smoothstep(halfWidth - blur, halfWidth + blur, distance);
    return mix(edge, 1.0 - 2.0 * halfWidth, smoothstep(0.4, 1.2, blur));
  }

  vec3 clothColor(vec2 material, bool isFront) {
    vec2 t = material / checkSize;
    float bands = 0.5 * (band(t.x, 0.25) + band(t.y, 0.25));
    vec2 thread = t * 24.0;
    float weaveBlur = max(fwidth(thread.x), fwidth(thread.y));
    float weave = sin(6.2832 * thread.x) * sin(6.2832 * thread.y) * (1.0 - smoothstep(0.15, 0.5, weaveBlur));
    // Linear light: linen #ebe7da and indigo #1b4c7f in front, apricot #f0b48b and brick #b6472f behind.
    vec3 light = isFront ? vec3(0.84, 0.80, 0.70) : vec3(0.88, 0.46, 0.26);
    vec3 dark = isFront ? vec3(0.012, 0.072, 0.21) : vec3(0.47, 0.065, 0.03);
    vec3 color = mix(light, dark, bands * (isFront ? 0.92 : 0.6));
    return color * (1.0 + 0.10 * weave);
  }

  // Colours that say something are read against a legend: neither pattern nor shadow, and little shading, for folds.
  vec3 readableColor(vec3 normal, vec3 toEye) {
    return vOwnColor * mix(0.85, 1.0, abs(dot(normal, toEye)));
  }
`;

export class ClothMaterial extends MeshStandardMaterial {
  private readonly checkSize: IUniform<number> = { value: 0.1 };
  private readonly hasOwnColors: IUniform<boolean> = { value: false };

  constructor() {
    super({
      side: DoubleSide,
      shadowSide: DoubleSide,
      roughness: 0.86,
      metalness: 0,
      ...kClothOffset,
    });
    this.defines = { ...this.defines, USE_UV: '' };
    this.onBeforeCompile = (shader) => {
      shader.uniforms.checkSize = this.checkSize;
      shader.uniforms.hasOwnColors = this.hasOwnColors;
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nattribute vec3 ownColor;\nvarying vec3 vOwnColor;')
        .replace('#include <begin_vertex>', '#include <begin_vertex>\nvOwnColor = ownColor;');
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', `#include <common>\n${kPattern}`)
        .replace('#include <color_fragment>', 'diffuseColor.rgb = clothColor(vUv, gl_FrontFacing);')
        .replace(
          '#include <opaque_fragment>',
          `if (hasOwnColors) outgoingLight = readableColor(normal, normalize(vViewPosition));
          #include <opaque_fragment>`,
        );
    };
  }

  /** @param size  metres, > 0: width of a light and a dark band together */
  setCheckSize(size: number): void {
    this.checkSize.value = size;
  }

  /** Colours the sheet by the vertex attribute `ownColor` (linear) instead of the cloth's own colours. */
  setOwnColors(isOn: boolean): void {
    this.hasOwnColors.value = isOn;
  }
}

import { Color, MeshLambertMaterial } from 'three';
import type { IUniform } from 'three';
import { kSupportOffset } from './depth_offsets';

const kGround = /* glsl */ `
  uniform float reach;
  uniform vec3 lineColor;
  varying vec2 vGround;

  float gridLines(vec2 at, float spacing) {
    vec2 t = at / spacing;
    vec2 blur = max(fwidth(t), vec2(1e-4));
    vec2 distance = abs(fract(t - 0.5) - 0.5) / blur;
    return (1.0 - min(min(distance.x, distance.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(blur.x, blur.y)));
  }
`;

/** The floor of a plane: lit and shadowed, with a grid of one metre, fading out with the distance from its middle. */
export class GroundMaterial extends MeshLambertMaterial {
  private readonly reachUniform: IUniform<number> = { value: 2 };
  private readonly lineColor: IUniform<Color> = { value: new Color(0x000000) };

  constructor() {
    super({ transparent: true, depthWrite: false, ...kSupportOffset });
    this.onBeforeCompile = (shader) => {
      shader.uniforms.reach = this.reachUniform;
      shader.uniforms.lineColor = this.lineColor;
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', '#include <common>\nuniform float reach;\nvarying vec2 vGround;')
        .replace('#include <begin_vertex>', '#include <begin_vertex>\nvGround = position.xy * 2.0 * reach;');
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', `#include <common>\n${kGround}`)
        .replace(
          '#include <color_fragment>',
          `
          float lines = max(0.5 * gridLines(vGround, 0.1), gridLines(vGround, 1.0));
          diffuseColor.rgb = mix(diffuseColor.rgb, lineColor, 0.35 * lines);
          diffuseColor.a *= 1.0 - smoothstep(0.35 * reach, reach, length(vGround));`,
        );
    };
  }

  /** Radius at which the floor has faded out, metres from its middle. */
  get reach(): number {
    return this.reachUniform.value;
  }

  set reach(metres: number) {
    this.reachUniform.value = metres;
  }

  setColors(surface: number, lines: number): void {
    this.color.set(surface);
    this.lineColor.value.set(lines);
  }
}

import {
  Box3,
  DirectionalLight,
  HemisphereLight,
  PerspectiveCamera,
  Raycaster,
  Scene,
  Sphere,
  Vector2,
  Vector3,
  WebGLRenderer,
} from 'three';
import type { Ray } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import type { Quality } from './drawing_quality';
import { GroundMaterial } from './ground_material';

const kFovDeg = 36;
const kViewDirection = new Vector3(0.5, -1, 0.62).normalize();
// The sheet fills this share of the picture's height or width at first, which leaves room to swing and fall.
const kFilled = 0.88;
// Smallest angle, radians, of the camera to straight up or down, where its up vector would flip.
const kLeastPolar = 0.01;
const kLightDirection = new Vector3(-0.45, -0.5, 1).normalize();

/** Place of the camera and the point that it looks at, world, metres. */
export interface CameraPlace {
  eye: Vector3;
  target: Vector3;
}

/** Renderer, camera, lights and floor; z is up. Draws only when something called invalidate(). */
export class Stage {
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(kFovDeg, 1, 0.01, 100);
  readonly controls: OrbitControls;
  readonly ground = new GroundMaterial();
  /** Size of the canvas, CSS pixels. */
  readonly sizePx = new Vector2(1, 1);
  /** A picture behind all that is drawn, as large as the canvas. */
  backdrop: CanvasImageSource | undefined;

  private readonly renderer: WebGLRenderer;
  private readonly sun = new DirectionalLight(0xfff9f1, 2.3);
  private readonly sky = new HemisphereLight(0xffffff, 0x8c8f98, 1.5);
  private readonly raycaster = new Raycaster();
  private quality: Quality = { scale: 1, hasShadows: true };
  private readonly shiftPx = new Vector2();
  private isStale = true;

  constructor(private readonly canvas: HTMLCanvasElement) {
    const wanted = { antialias: true, alpha: true, stencil: true, powerPreference: 'high-performance' } as const;
    this.renderer = new WebGLRenderer({ canvas, ...wanted });
    this.renderer.shadowMap.enabled = true;
    this.camera.up.set(0, 0, 1);
    this.sky.position.set(0, 0, 1);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.radius = 4;
    this.sun.shadow.bias = -0.0008;
    this.scene.add(this.sky, this.sun, this.sun.target);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.minPolarAngle = kLeastPolar;
    this.controls.maxPolarAngle = Math.PI - kLeastPolar;
    this.controls.addEventListener('change', () => this.invalidate());
    this.fit(new Box3(new Vector3(-0.5, -0.5, 0), new Vector3(0.5, 0.5, 1)));
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  invalidate(): void {
    this.isStale = true;
  }

  /** Gives the keyboard focus to the canvas, so that keys reach the tool. */
  focus(): void {
    this.canvas.focus({ preventScroll: true });
  }

  /** Continues camera motion; true if something changed since the last draw(). */
  advance(): boolean {
    this.controls.update();
    return this.isStale;
  }

  draw(): void {
    this.isStale = false;
    this.renderer.render(this.scene, this.camera);
  }

  /** Sets how finely the stage draws; false if nothing changed. */
  setQuality(quality: Quality): boolean {
    const { scale, hasShadows } = this.quality;
    if (quality.scale === scale && quality.hasShadows === hasShadows) return false;
    this.quality = quality;
    this.sun.castShadow = quality.hasShadows;
    this.resize();
    return true;
  }

  /** The browser's name for the graphics card or software that draws; empty if the browser does not give one. */
  get graphics(): string {
    const context = this.renderer.getContext();
    const info = context.getExtension('WEBGL_debug_renderer_info');
    return info ? String(context.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  }

  /**
   * Returns a new canvas with the present picture, transparent where nothing is drawn.
   * @param scale  pixels per CSS pixel
   */
  picture(scale: number): HTMLCanvasElement {
    const copy = document.createElement('canvas');
    this.renderer.setPixelRatio(scale);
    this.renderer.setSize(this.sizePx.x, this.sizePx.y, false);
    this.sun.castShadow = true;
    this.draw();
    // The canvas keeps its picture until this task ends.
    copy.width = this.canvas.width;
    copy.height = this.canvas.height;
    const context = copy.getContext('2d')!;
    if (this.backdrop) {
      context.drawImage(this.backdrop, -scale * this.shiftPx.x, -scale * this.shiftPx.y, copy.width, copy.height);
    }
    context.drawImage(this.canvas, 0, 0);
    this.sun.castShadow = this.quality.hasShadows;
    this.resize();
    return copy;
  }

  /** Moves the camera so that the whole box is in view, and sizes light, shadow and floor for the box. */
  fit(box: Box3): void {
    const { center, radius } = box.getBoundingSphere(new Sphere());
    const distance = this.fittingDistance(box, center);
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(kViewDirection, distance);
    this.camera.near = 0.01 * distance;
    this.camera.far = 30 * distance;
    this.camera.updateProjectionMatrix();
    this.controls.minDistance = 0.05 * distance;
    this.controls.maxDistance = 8 * distance;
    this.controls.update();

    this.sun.position.copy(center).addScaledVector(kLightDirection, 4 * radius);
    this.sun.target.position.copy(center);
    const { camera: shadow } = this.sun.shadow;
    [shadow.left, shadow.right, shadow.bottom, shadow.top] = [-1.7 * radius, 1.7 * radius, -1.7 * radius, 1.7 * radius];
    [shadow.near, shadow.far] = [0.5 * radius, 8 * radius];
    this.sun.shadow.normalBias = 0.012 * radius;
    shadow.updateProjectionMatrix();
    this.ground.reach = 4 * radius;
    this.invalidate();
  }

  get place(): CameraPlace {
    return { eye: this.camera.position.clone(), target: this.controls.target.clone() };
  }

  /** Moves the camera. Its distance is kept within what the last fit() allows. */
  set place({ eye, target }: CameraPlace) {
    this.camera.position.copy(eye);
    this.controls.target.copy(target);
    this.controls.update();
    this.invalidate();
  }

  /** Moves the whole picture left and up by CSS pixels; the camera stays. */
  shift(leftPx: number, upPx: number): void {
    if (leftPx === this.shiftPx.x && upPx === this.shiftPx.y) return;
    this.shiftPx.set(leftPx, upPx);
    this.resize();
  }

  /** Turns the camera around its target by `left` and `up`, radians; it stops before straight up or down. */
  orbit(left: number, up: number): void {
    const { target } = this.controls;
    const offset = this.camera.position.clone().sub(target);
    const polar = offset.angleTo(this.camera.up);
    const toPolar = Math.min(Math.PI - kLeastPolar, Math.max(kLeastPolar, polar - up));
    const right = new Vector3().crossVectors(this.camera.up, offset).normalize();
    offset.applyAxisAngle(right, toPolar - polar).applyAxisAngle(this.camera.up, left);
    this.camera.position.copy(target).add(offset);
    this.controls.update();
  }

  /** Moves the camera to one side of its target, at the present distance; straight up and down stop just before it. */
  lookFrom(direction: Vector3): void {
    const { eye, target } = this.place;
    const sideways = Math.hypot(direction.x, direction.y);
    // Seen from above, y points up in the picture.
    const from = sideways > 0 ? direction.clone() : new Vector3(0, -Math.sin(kLeastPolar), direction.z * Math.cos(kLeastPolar));
    this.place = { eye: target.clone().addScaledVector(from, eye.distanceTo(target)), target };
  }

  /** Moves the camera nearer to its target by this factor, or farther away if the factor is below 1. */
  zoom(factor: number): void {
    const { target, minDistance, maxDistance } = this.controls;
    const offset = this.camera.position.clone().sub(target);
    offset.setLength(Math.min(maxDistance, Math.max(minDistance, offset.length() / factor)));
    this.camera.position.copy(target).add(offset);
    this.controls.update();
  }

  /** Moves the camera and its target across the view, by CSS pixels. */
  pan(rightPx: number, upPx: number): void {
    const scale = this.metresPerPx(this.controls.target);
    const shift = new Vector3(rightPx * scale, upPx * scale, 0).applyQuaternion(this.camera.quaternion);
    this.lookAt(this.controls.target.clone().add(shift));
  }

  /** Moves a world point into the middle of the picture; direction and distance of the camera stay. */
  lookAt(at: Vector3): void {
    const { target } = this.controls;
    this.camera.position.add(at).sub(target);
    target.copy(at);
    this.controls.update();
  }

  // Returns the least distance from `center`, along kViewDirection, from which all corners of the box are in view with
  // some margin.
  private fittingDistance(box: Box3, center: Vector3): number {
    const right = new Vector3().crossVectors(this.camera.up, kViewDirection).normalize();
    const up = new Vector3().crossVectors(kViewDirection, right);
    const tangent = Math.tan(0.5 * kFovDeg * (Math.PI / 180)) * kFilled;
    let distance = 1e-3;
    for (let corner = 0; corner < 8; ++corner) {
      const at = new Vector3(
        corner & 1 ? box.max.x : box.min.x,
        corner & 2 ? box.max.y : box.min.y,
        corner & 4 ? box.max.z : box.min.z,
      ).sub(center);
      const across = Math.max(Math.abs(at.dot(right)) / this.camera.aspect, Math.abs(at.dot(up)));
      distance = Math.max(distance, across / tangent + at.dot(kViewDirection));
    }
    return distance;
  }

  /** Returns the ray through a point of the canvas, CSS pixels from the upper left corner. */
  rayAt(point: Vector2): Ray {
    const clip = new Vector2((2 * point.x) / this.sizePx.x - 1, 1 - (2 * point.y) / this.sizePx.y);
    this.raycaster.setFromCamera(clip, this.camera);
    return this.raycaster.ray.clone();
  }

  /** Returns the canvas point of a world point, CSS pixels; undefined behind the camera. */
  project(world: Vector3): Vector2 | undefined {
    const p = world.clone().project(this.camera);
    if (p.z > 1) return undefined;
    return new Vector2((0.5 + 0.5 * p.x) * this.sizePx.x, (0.5 - 0.5 * p.y) * this.sizePx.y);
  }

  /** Returns the metres that one CSS pixel covers at a world point, across the view. */
  metresPerPx(at: Vector3): number {
    const forward = this.camera.getWorldDirection(new Vector3());
    const depth = at.clone().sub(this.camera.position).dot(forward);
    return (2 * Math.abs(depth) * Math.tan(0.5 * kFovDeg * (Math.PI / 180))) / this.sizePx.y;
  }

  /** Sets light and floor for a dark or a light page. */
  setDark(isDark: boolean): void {
    this.sky.intensity = isDark ? 0.9 : 1.25;
    this.sky.groundColor.set(isDark ? 0x3a4250 : 0x9a948c);
    this.ground.setColors(isDark ? 0x2a303a : 0xe6eaef, isDark ? 0x8794a8 : 0x5b6675);
    this.invalidate();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.sizePx.set(clientWidth, clientHeight);
    this.renderer.setPixelRatio(this.quality.scale * Math.min(devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    const { x, y } = this.shiftPx;
    if (x === 0 && y === 0) this.camera.clearViewOffset();
    else this.camera.setViewOffset(clientWidth, clientHeight, x, y, clientWidth, clientHeight);
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }
}

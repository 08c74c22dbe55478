// Draws the points: at once a part of them, as many as the machine draws while one waits, then all, in slices, so that
// the page stays responsive however slow the machine is.
import {
  AddEquation, BufferAttribute, BufferGeometry, CustomBlending, DataTexture, GLSL3, HalfFloatType, Mesh, NearestFilter,
  NoBlending, OneFactor, Points as ThreePoints, RawShaderMaterial, RGBAFormat, Scene, Vector2, Vector3, WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { DEPTH_RANGE } from "./camera.mjs";
import { NO_VALUE_COLOR } from "./color_maps.mjs";
import { SCREEN_FRAGMENT, SCREEN_VERTEX, SPLAT_FRAGMENT, SPLAT_VERTEX } from "./shaders.mjs";

const FEWEST_POINTS = 20_000;
const FRAME_MS = 30;
const SLICE_MS = 60;
/** How long nothing must change before all points are drawn. */
const REST_MS = 60;
/** Above any value in units of its scale; the shader knows it as none. */
const NO_VALUE = 3e38;
/** Samples on a side of a pixel for smooth outlines, how much longer they take, and how long they may. */
const SMOOTH_SAMPLES = 2;
const SMOOTH_COST = 3;
const SMOOTH_MS = 1500;

/** Spreads points over the order of drawing, so that the first of them show all of the cloud. */
function drawingOrder(count) {
  const order = Uint32Array.from({ length: count }, (_, i) => i);
  for (let i = count - 1, state = 1; i > 0; i--) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    const other = Math.floor((state / 2 ** 32) * (i + 1));
    [order[i], order[other]] = [order[other], order[i]];
  }
  return order;
}

export class CloudScene {
  /** Throws if the browser offers no WebGL 2 with pictures of half floats. */
  constructor(canvas, turntable) {
    this.turntable = turntable;
    this.renderer = new WebGLRenderer({ canvas, alpha: true, antialias: false, depth: false, stencil: false });
    this.renderer.autoClear = false;
    this.renderer.setClearColor(0, 0);
    if (!this.renderer.extensions.has("EXT_color_buffer_float")) throw new Error("no pictures of half floats");
    this.count = 0;
    this.#makePasses();
    this.pointsPerMs = FEWEST_POINTS / FRAME_MS;
    this.samples = 1;
    /** Called with what is on the screen: some of the points, all, or all with the best outlines that there will be. */
    this.onPicture = () => {};
  }

  /** Draws these points from now on, those that are here. Their values and who is shown are to be set next. */
  setPoints(points) {
    this.points = points;
    this.order = points.isShuffled ? null : drawingOrder(points.count);
    this.geometry?.dispose();
    const capacity = points.report.shown;
    this.geometry = new BufferGeometry();
    const attributes = { position: [Uint16Array, 3, true], direction: [Int8Array, 2, true], traits: [Uint8Array, 4, false],
      value: [Float32Array, 1, false] };
    for (const [name, [Kind, size, isNormalized]] of Object.entries(attributes)) {
      this.geometry.setAttribute(name, new BufferAttribute(new Kind(size * capacity), size, isNormalized));
    }
    this.traits = this.geometry.getAttribute("traits").array;
    this.cloud.geometry = this.geometry;
    this.uniforms.extent.value.set(...points.extent);
    this.uniforms.largestRadius.value = points.report.largestRadius;
    [this.valueOf, this.isShown] = [() => NaN, () => true];
    this.#fill(0);
  }

  /** Draws the points too that have come since. */
  grow() {
    this.#fill(this.count);
    this.draw();
  }

  /** Which point is drawn at that place of the order. */
  #pointAt(at) {
    return this.order ? this.order[at] : at;
  }

  #fill(begin) {
    const { points } = this;
    const { arrays, signed } = points;
    const [places, directions] = ["position", "direction"].map((name) => this.geometry.getAttribute(name).array);
    for (let at = begin; at < points.count; at++) {
      const i = this.#pointAt(at);
      [places[3 * at], places[3 * at + 1], places[3 * at + 2]] = [arrays.x[i], arrays.y[i], arrays.z[i]];
      const u = signed.normal_u ? signed.normal_u[i] : -128;
      if (u !== -128) [directions[2 * at], directions[2 * at + 1]] = [u, signed.normal_v[i]];
      [this.traits[4 * at], this.traits[4 * at + 3]] = [arrays.radius8[i], u === -128 ? 1 : 0];
    }
    this.count = points.count;
    this.#fillValues(begin);
    this.#fillShown(begin);
    this.#changed(["position", "direction"], begin);
  }

  /** Has what changed from a place of the order on sent to the graphics card. */
  #changed(names, begin) {
    for (const name of names) {
      const attribute = this.geometry.getAttribute(name);
      if (begin > 0) attribute.addUpdateRange(begin * attribute.itemSize, (this.count - begin) * attribute.itemSize);
      else attribute.clearUpdateRanges();
      attribute.needsUpdate = true;
    }
  }

  #makePasses() {
    this.ramp = new DataTexture(new Uint8Array(1024), 256, 1, RGBAFormat);
    this.uniforms = {
      extent: { value: new Vector3() },
      largestRadius: { value: 1 },
      radiusFactor: { value: 1 },
      pixelsPerUnit: { value: 1 },
      depthPerPixel: { value: 1 },
      low: { value: -1 },
      high: { value: 1 },
      noValue: { value: new Vector3(...NO_VALUE_COLOR.map((c) => c / 255)) },
      ramp: { value: this.ramp },
    };
    const shaders = { vertexShader: SPLAT_VERTEX, fragmentShader: SPLAT_FRAGMENT, glslVersion: GLSL3 };
    const splats = (settings) => new RawShaderMaterial({ ...shaders, ...settings });
    this.depthPass = splats({
      uniforms: { ...this.uniforms, moveBack: { value: 1 } }, colorWrite: false, blending: NoBlending,
    });
    this.colorPass = splats({
      uniforms: { ...this.uniforms, moveBack: { value: 0 } }, depthWrite: false, transparent: true,
      blending: CustomBlending, blendEquation: AddEquation, blendSrc: OneFactor, blendDst: OneFactor,
    });
    this.cloud = new ThreePoints(new BufferGeometry(), this.depthPass);
    this.cloud.frustumCulled = false;
    this.scene = new Scene();
    this.scene.add(this.cloud);
    this.sums = { value: null };
    const corners = new BufferGeometry();
    corners.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const screen = new RawShaderMaterial({
      vertexShader: SCREEN_VERTEX, fragmentShader: SCREEN_FRAGMENT, glslVersion: GLSL3, blending: NoBlending,
      uniforms: { sums: this.sums, samples: { value: 1 } }, depthTest: false, depthWrite: false,
    });
    this.screen = new Mesh(corners, screen);
    this.screen.frustumCulled = false;
    this.screenScene = new Scene();
    this.screenScene.add(this.screen);
  }

  /** `valueOf(i)` in any unit, NaN for none; `low` and `high` in the same unit; `ramp` as rampOf makes it. */
  setValues(valueOf) {
    this.valueOf = valueOf;
    this.#fillValues(0);
  }

  #fillValues(begin) {
    const { array } = this.geometry.getAttribute("value");
    for (let at = begin; at < this.count; at++) {
      const value = this.valueOf(this.#pointAt(at));
      array[at] = Number.isNaN(value) ? NO_VALUE : Math.min(Math.max(value, -1e30), 1e30);
    }
    this.#changed(["value"], begin);
  }

  setColors(low, high, ramp) {
    this.uniforms.low.value = low;
    this.uniforms.high.value = high;
    this.ramp.image.data.set(ramp);
    this.ramp.needsUpdate = true;
    this.draw();
  }

  /** Shows the points for which `isShown(i)`. */
  setShown(isShown) {
    this.isShown = isShown;
    this.#fillShown(0);
    this.draw();
  }

  #fillShown(begin) {
    for (let at = begin; at < this.count; at++) {
      const i = this.#pointAt(at);
      this.traits[4 * at + 2] = this.points.isSomewhere(i) && this.isShown(i) ? 0 : 1;
    }
    this.#changed(["traits"], begin);
  }

  setRadiusFactor(factor) {
    this.radiusFactor = factor;
    this.draw();
  }

  resize(width, height) {
    this.pixelRatio = Math.min(window.devicePixelRatio || 1, 2);
    this.renderer.setPixelRatio(this.pixelRatio);
    this.renderer.setSize(width, height, false);
    this.turntable.resize(width, height);
    this.draw();
  }

  /** Draws in the next frame what is to be seen now. */
  draw() {
    this.step = "first";
    if (!this.waits) this.waits = requestAnimationFrame(() => this.#advance());
  }

  #again() {
    if (!this.waits) this.waits = requestAnimationFrame(() => this.#advance());
  }

  #advance() {
    this.waits = 0;
    if (this.step === "first") return this.#drawFirst();
    if (this.step === "rest") {
      if (performance.now() < this.restAt) return this.#again();
      this.#begin(this.count, this.nextSamples);
      [this.step, this.at] = ["depth", 0];
    }
    return this.#refine();
  }

  /** Draws as many points as a frame has time for. */
  #drawFirst() {
    const count = Math.min(Math.max(Math.round(this.pointsPerMs * FRAME_MS), FEWEST_POINTS), this.count);
    this.#begin(count, 1);
    this.#drawSlice(this.depthPass, 0, count);
    this.#drawSlice(this.colorPass, 0, count);
    this.#present();
    if (count === this.count) return this.#finish();
    this.onPicture("some");
    return this.#rest(1, this.isSettled ? REST_MS : 0);
  }

  /** Goes on with all points after so many milliseconds, unless something changes before. */
  #rest(samples, milliseconds) {
    [this.step, this.nextSamples, this.restAt] = ["rest", samples, performance.now() + milliseconds];
    this.#again();
  }

  #refine() {
    const pass = this.step === "depth" ? this.depthPass : this.colorPass;
    const slice = (this.pointsPerMs * SLICE_MS) / (this.samples > 1 ? SMOOTH_COST : 1);
    const count = Math.min(Math.max(Math.round(slice), 1), this.count - this.at);
    this.#drawSlice(pass, this.at, count);
    this.at += count;
    if (this.at < this.count) return this.#again();
    if (this.step === "depth") {
      [this.step, this.at] = ["color", 0];
      return this.#again();
    }
    this.#present();
    return this.#finish();
  }

  /** All points are drawn; once more with smooth outlines, if that takes no long time. */
  #finish() {
    this.isSettled = true;
    const milliseconds = ((2 * this.count) / this.pointsPerMs) * SMOOTH_COST;
    if (this.samples === 1 && this.pixelRatio < 2 && milliseconds < SMOOTH_MS) {
      this.onPicture("all");
      return this.#rest(SMOOTH_SAMPLES, REST_MS);
    }
    this.step = "done";
    return this.onPicture("smooth");
  }

  /** Clears the sums for a picture of `count` points; fewer are drawn larger. */
  #begin(count, samples) {
    const size = this.renderer.getDrawingBufferSize(new Vector2());
    const [width, height] = [Math.max(size.x * samples, 1), Math.max(size.y * samples, 1)];
    if (this.target?.width !== width || this.target?.height !== height) {
      this.target?.dispose();
      this.target = new WebGLRenderTarget(width, height, {
        type: HalfFloatType, format: RGBAFormat, minFilter: NearestFilter, magFilter: NearestFilter,
      });
    }
    this.samples = samples;
    this.turntable.update();
    const pixels = this.turntable.pixelsPerUnit() * this.pixelRatio * samples;
    this.uniforms.pixelsPerUnit.value = pixels;
    this.uniforms.depthPerPixel.value = 1 / pixels / DEPTH_RANGE;
    const fewer = Math.min(Math.sqrt(this.count / count), 3);
    const soFar = Math.sqrt(this.points.report.shown / Math.max(this.count, 1));
    this.uniforms.radiusFactor.value = (this.radiusFactor ?? 1) * fewer * soFar;
    this.renderer.setRenderTarget(this.target);
    this.renderer.clear();
  }

  /** Draws points [begin, begin + count) of the order, and measures how fast that is. */
  #drawSlice(pass, begin, count) {
    const began = performance.now();
    this.geometry.setDrawRange(begin, count);
    this.cloud.material = pass;
    this.renderer.setRenderTarget(this.target);
    this.renderer.render(this.scene, this.turntable.camera);
    // Reading a pixel waits until it is drawn.
    this.renderer.readRenderTargetPixels(this.target, 0, 0, 1, 1, new Uint16Array(4));
    if (this.samples > 1) return;
    const rate = count / Math.max(performance.now() - began, 0.5) / 2;
    this.pointsPerMs = Math.max(this.pointsPerMs * 0.5 + rate * 0.5, FEWEST_POINTS / SLICE_MS / 8);
  }

  #present() {
    this.sums.value = this.target.texture;
    this.screen.material.uniforms.samples.value = this.samples;
    this.renderer.setRenderTarget(null);
    this.renderer.clear();
    this.renderer.render(this.screenScene, this.turntable.camera);
  }
}

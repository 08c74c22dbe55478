// A turntable: the cloud turns about its up axis and tilts toward the viewer, seen without perspective.
import { Matrix4, OrthographicCamera, Vector3 } from "three";

const DISTANCE = 4;
export const DEPTH_RANGE = 2 * DISTANCE;
/** How much of the free part of the window the cloud takes: the legend lies over its top, axes and scale below. */
const FILLED = 0.92;
const TOP_PIXELS = 80;
const BOTTOM_PIXELS = 40;
const radians = (degrees) => (degrees * Math.PI) / 180;

export const VIEWS = {
  "Three-quarter": [35, 25],
  Front: [0, 0],
  Back: [180, 0],
  Left: [-90, 0],
  Right: [90, 0],
  Top: [0, 90],
  Bottom: [0, -90],
};

export class Turntable {
  /** `places`: some of the cloud's, which stand for all; `radius`: of the largest splat; `upAxis`: "y" or "z"; `pose`:
   * azimuth and elevation at first. */
  constructor(places, radius, upAxis, pose) {
    this.setCloud(places, radius, upAxis);
    this.camera = new OrthographicCamera(-1, 1, 1, -1, 0, DEPTH_RANGE);
    this.camera.matrixAutoUpdate = false;
    [this.width, this.height] = [1, 1];
    this.show(pose);
  }

  /** Takes another cloud for the one before: what is seen of it stays as it is. */
  setCloud(places, radius, upAxis) {
    this.least = Math.max(0.1, 4 * radius);
    this.places = places.map((place) => new Vector3(...place));
    this.upAxis = upAxis;
    if (this.isFitted) this.fit();
  }

  /** Turns to an azimuth and an elevation, and shows all of the cloud. */
  show([azimuth, elevation]) {
    [this.azimuth, this.elevation] = [azimuth, elevation];
    this.fit();
  }

  fit() {
    [this.zoom, this.isFitted] = [1, true];
    const { right, up } = this.axes();
    this.target = new Vector3();
    for (const axis of [right, up]) {
      const [low, high] = this.#reach(axis);
      this.target.addScaledVector(axis, (low + high) / 2);
    }
    this.scale = this.#fitScale();
    this.target.addScaledVector(up, (TOP_PIXELS - BOTTOM_PIXELS) / 2 / this.scale);
  }

  resize(width, height) {
    [this.width, this.height] = [width, height];
    if (this.isFitted) this.fit();
    else this.scale = this.#fitScale();
  }

  turn(azimuth, elevation) {
    this.isFitted = false;
    this.azimuth = (this.azimuth + azimuth) % 360;
    this.elevation = Math.min(Math.max(this.elevation + elevation, -90), 90);
  }

  /** Turns to where a direction points at the viewer, and moves a place to the middle. */
  face([x, y, z], place) {
    this.isFitted = false;
    const [ahead, above] = this.upAxis === "z" ? [-y, z] : [z, y];
    const degrees = (angle) => (angle * 180) / Math.PI;
    this.azimuth = degrees(Math.atan2(x, ahead));
    this.elevation = degrees(Math.asin(Math.min(Math.max(above, -1), 1)));
    this.target = new Vector3(...place);
  }

  /** Moves the cloud by so many pixels, to the right and down. */
  move(right, down) {
    this.isFitted = false;
    const { right: r, up } = this.axes();
    this.target.addScaledVector(r, -right / this.pixelsPerUnit()).addScaledVector(up, down / this.pixelsPerUnit());
    this.target.clampLength(0, 1.5);
  }

  /** Zooms so that what is at (x, y), in pixels from the middle, right and up, stays there. */
  zoomBy(factor, x = 0, y = 0) {
    this.isFitted = false;
    const before = this.pixelsPerUnit();
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.2), 2000);
    const shift = 1 / before - 1 / this.pixelsPerUnit();
    const { right, up } = this.axes();
    this.target.addScaledVector(right, x * shift).addScaledVector(up, y * shift);
  }

  /** Unit vectors to the right and upward on the screen, and toward the viewer. */
  axes() {
    const [a, e] = [radians(this.azimuth), radians(this.elevation)];
    const turned = (x, y, z) => (this.upAxis === "z" ? new Vector3(x, y, z) : new Vector3(x, z, -y));
    return {
      right: turned(Math.cos(a), Math.sin(a), 0),
      up: turned(-Math.sin(e) * Math.sin(a), Math.sin(e) * Math.cos(a), Math.cos(e)),
      toward: turned(Math.cos(e) * Math.sin(a), -Math.cos(e) * Math.cos(a), Math.sin(e)),
    };
  }

  /** How far the cloud reaches along an axis, from and to. */
  #reach(axis) {
    let [low, high] = [Infinity, -Infinity];
    for (const place of this.places) {
      const along = axis.dot(place);
      low = Math.min(low, along);
      high = Math.max(high, along);
    }
    return [low, high];
  }

  /** Pixels of one unit at zoom 1: the cloud fits into the window as it is seen now. */
  #fitScale() {
    const { right, up } = this.axes();
    const [width, height] = [right, up].map((axis) => {
      const [low, high] = this.#reach(axis);
      return Math.max(high - low, this.least);
    });
    const free = Math.max(this.height - TOP_PIXELS - BOTTOM_PIXELS, this.height / 2);
    return FILLED * Math.min(this.width / width, free / height);
  }

  pixelsPerUnit() {
    return this.scale * this.zoom;
  }

  /** Right, up and toward the viewer of a place, in pixels from the middle of the window. */
  project(place) {
    const { right, up, toward } = this.axes();
    const d = new Vector3(...place).sub(this.target);
    return [right, up, toward].map((axis) => axis.dot(d) * this.pixelsPerUnit());
  }

  update() {
    const { right, up, toward } = this.axes();
    const scale = this.pixelsPerUnit();
    const [w, h] = [this.width / scale / 2, this.height / scale / 2];
    Object.assign(this.camera, { left: -w, right: w, top: h, bottom: -h });
    this.camera.updateProjectionMatrix();
    const eye = this.target.clone().addScaledVector(toward, DISTANCE);
    this.camera.matrix.copy(new Matrix4().makeBasis(right, up, toward).setPosition(eye));
    this.camera.matrixWorld.copy(this.camera.matrix);
    this.camera.matrixWorldInverse.copy(this.camera.matrixWorld).invert();
    this.camera.matrixWorldAutoUpdate = false;
  }
}

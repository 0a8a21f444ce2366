// The eye of the 3-D view: a camera that pointer, fingers and keys turn, move and bring nearer.

import { OrbitControls, THREE } from "nicegui-scene";

import { clamp } from "./scene.js";

export const FIELD_DEG = 38;
// Direction to the eye of the first view, and the part of the view that the map fills.
const FROM = new THREE.Vector3(-0.16, -0.78, 0.6).normalize();
const FILLED = 0.88;
const KEY_DEG = 5;
const ZOOM_STEP = 1.2;
const [NEAREST, FURTHEST] = [0.05, 9];

/** A camera with its controls; the ground is the plane of x and y. */
export class Eye {
  /**
   * @param {HTMLElement} node Gets pointers and keys.
   * @param {function(): void} moved Called when the view must be drawn again.
   * @param {function(): number[][]} box Corners [x, y, z] of the box in the first view.
   */
  constructor(node, moved, box) {
    this.moved = moved;
    this.box = box;
    this.camera = new THREE.PerspectiveCamera(FIELD_DEG, 1, 0.005, 40);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, node);
    Object.assign(this.controls, {
      enableDamping: true,
      dampingFactor: 0.15,
      maxPolarAngle: 0.485 * Math.PI,
      minDistance: NEAREST,
      maxDistance: FURTHEST,
    });
    // True until the reader has moved the eye: then each size gets a first view of its own.
    this.untouched = true;
    this.controls.addEventListener("change", moved);
    this.controls.addEventListener("start", () => (this.untouched = false));
    node.addEventListener("keydown", (event) => this.pressed(event));
  }

  /** Take the size of the view. */
  fit(width, height) {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.untouched) this.reset();
  }

  /** Continue a movement that the pointer has let go. */
  update() {
    this.controls.update();
  }

  dispose() {
    this.controls.dispose();
  }

  /** Return to the first view, from the south and above, with the whole box in it. */
  reset() {
    const corners = this.box().map((corner) => new THREE.Vector3(...corner));
    const target = new THREE.Vector3(0, 0, 0);
    let distance = FURTHEST / 2;
    // Each round moves the eye over the ground and away, until the corners just fit.
    for (let round = 0; round < 12; round++) {
      this.camera.position.copy(target).addScaledVector(FROM, distance);
      this.camera.lookAt(target);
      this.camera.updateMatrixWorld();
      const seen = corners.map((corner) => corner.clone().project(this.camera));
      const [left, right] = range(seen.map(({ x }) => x));
      const [low, high] = range(seen.map(({ y }) => y));
      const reach = distance * Math.tan((FIELD_DEG * Math.PI) / 360);
      target.x += ((left + right) / 2) * reach * this.camera.aspect;
      target.y += ((low + high) / 2) * reach;
      distance *= Math.max((right - left) / 2 / FILLED, (high - low) / 2 / FILLED);
    }
    this.controls.target.copy(target);
    this.controls.update();
    this.untouched = true;
    this.moved();
  }

  pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const act = event.shiftKey ? this.slide.bind(this) : this.turn.bind(this);
    const keys = {
      ArrowLeft: () => act(-1, 0),
      ArrowRight: () => act(1, 0),
      ArrowUp: () => act(0, 1),
      ArrowDown: () => act(0, -1),
      "+": () => this.dolly(1 / ZOOM_STEP),
      "=": () => this.dolly(1 / ZOOM_STEP),
      "-": () => this.dolly(ZOOM_STEP),
      0: () => this.reset(),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    this.untouched = false;
    keys[event.key]();
    this.controls.update();
    this.moved();
  }

  /** Turn around the target by steps of KEY_DEG to the east and upwards. */
  turn(east, up) {
    const { controls, camera } = this;
    const step = (KEY_DEG * Math.PI) / 180;
    const offset = camera.position.clone().sub(controls.target);
    const distance = offset.length();
    const azimuth = Math.atan2(offset.y, offset.x) + east * step;
    const polar = Math.acos(offset.z / distance) - up * step;
    const tilt = clamp(polar, 0.01, controls.maxPolarAngle);
    const [flat, height] = [distance * Math.sin(tilt), distance * Math.cos(tilt)];
    offset.set(flat * Math.cos(azimuth), flat * Math.sin(azimuth), height);
    camera.position.copy(controls.target).add(offset);
  }

  /** Move over the ground by steps to the right and ahead. */
  slide(right, ahead) {
    const { controls, camera } = this;
    const offset = camera.position.clone().sub(controls.target);
    const step = 0.05 * offset.length();
    const forward = offset.setZ(0).normalize().negate();
    const move = new THREE.Vector3(forward.y, -forward.x, 0).multiplyScalar(right * step);
    move.addScaledVector(forward, ahead * step);
    controls.target.add(move);
    camera.position.add(move);
  }

  dolly(factor) {
    const { controls, camera } = this;
    const offset = camera.position.clone().sub(controls.target).multiplyScalar(factor);
    offset.clampLength(controls.minDistance, controls.maxDistance);
    camera.position.copy(controls.target).add(offset);
  }
}

/** Return the least and the greatest of some numbers. */
function range(values) {
  return [Math.min(...values), Math.max(...values)];
}

// The 3-D view: terrain, zones, paths, points, aircraft and the marked place, by three.js.

import { OrbitControls, THREE } from "nicegui-scene";

import { fatLine } from "./lines.js";
import { drawMark, drawPoint, drawText } from "./marks.js";
import { reliefOf } from "./relief.js";
import { clamp, colourOf, coloursOf, drawnPaths, groundAt } from "./scene.js";
import { curtain, ground, outlinesOf, segments, sides, zonesOf } from "./solids.js";

const FIELD_DEG = 38;
// The longer side of the map in the scene's units, and how far its sides reach below the land.
const SIDE = 2;
const FOOT = 0.05;
// Direction to the eye of the first view, and the part of the view that the map fills.
const FROM = new THREE.Vector3(-0.16, -0.78, 0.6).normalize();
const FILLED = 0.93;
const KEY_DEG = 5;
const ZOOM_STEP = 1.2;
// Pixels of the pictures of points, drawn twice as fine.
const SPRITE = 64;
const AIRCRAFT_PIXELS = 15;

/** A 3-D view of a decoded scene in an element that has a size of its own. */
export class TerrainView {
  /**
   * @param {HTMLElement} element Filled by the view.
   * @param {object} scene Result of readScene.
   * @throws {Error} If the browser has no WebGL.
   */
  constructor(element, scene) {
    this.element = element;
    this.data = scene;
    this.unit = SIDE / Math.max(scene.terrain.width_m, scene.terrain.height_m);
    this.place = this.place.bind(this);
    this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
    this.screen = new THREE.Vector2(1, 1);
    this.world = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(FIELD_DEG, 1, 0.005, 40);
    this.camera.up.set(0, 0, 1);
    this.layers = {};
    this.sprites = new Set();
    this.frame = 0;
    // True until the reader has moved the view: then each size gets a first view of its own.
    this.untouched = true;
    this.shown = {
      paths: drawnPaths(scene),
      zones: scene.zones,
      points: scene.points,
      aircraft: null,
      marked: null,
    };
    this.attach();
    this.redraw();
  }

  setPaths(paths) {
    this.show("paths", paths);
  }

  setZones(zones) {
    this.show("zones", zones);
  }

  setPoints(points) {
    this.show("points", points);
  }

  /** Show the aircraft at {x, y, z, heading_deg}, or none for null. */
  setAircraft(aircraft) {
    this.show("aircraft", aircraft);
  }

  /** Mark the place {x, y, z}, or none for null. */
  mark(place) {
    this.show("marked", place);
  }

  /** Build everything anew, in the colours of now. */
  redraw() {
    this.colours = coloursOf(this.element);
    this.buildLand();
    for (const name of Object.keys(this.shown)) this.build(name);
  }

  /** Return to the first view, from the south and above, with map and paths in it. */
  reset() {
    const { width_m, height_m, low_m } = this.data.terrain;
    const high_m = this.highest(false);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) =>
      this.place(i & 1 ? width_m : 0, i & 2 ? height_m : 0, i & 4 ? high_m : low_m),
    );
    const target = new THREE.Vector3(...this.place(width_m / 2, height_m / 2, low_m));
    let distance = 2 * SIDE;
    // Each round moves the eye over the ground and away, until the corners just fit.
    for (let round = 0; round < 12; round++) {
      this.camera.position.copy(target).addScaledVector(FROM, distance);
      this.camera.lookAt(target);
      this.camera.updateMatrixWorld();
      const seen = corners.map((corner) => new THREE.Vector3(...corner).project(this.camera));
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
    this.request();
  }

  dispose() {
    cancelAnimationFrame(this.frame);
    this.observer.disconnect();
    this.controls.dispose();
    for (const name of Object.keys(this.layers)) this.clear(name);
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.node.remove();
  }

  /** Return the scene's units of metres x, y, z. */
  place(x, y, z) {
    const { width_m, height_m, low_m, vertical } = this.data.terrain;
    const up = (z - low_m) * vertical * this.unit;
    return [(x - width_m / 2) * this.unit, (y - height_m / 2) * this.unit, up];
  }

  attach() {
    this.node = this.renderer.domElement;
    this.node.tabIndex = 0;
    this.node.setAttribute("role", "application");
    this.node.setAttribute(
      "aria-label",
      "Terrain in three dimensions. Arrow keys turn it, with shift they move it, plus and minus zoom, 0 resets.",
    );
    Object.assign(this.node.style, { display: "block", position: "absolute", inset: 0 });
    if (getComputedStyle(this.element).position === "static") {
      this.element.style.position = "relative";
    }
    this.element.append(this.node);
    this.controls = new OrbitControls(this.camera, this.node);
    Object.assign(this.controls, {
      enableDamping: true,
      dampingFactor: 0.15,
      maxPolarAngle: 0.485 * Math.PI,
      minDistance: 0.05,
      maxDistance: 9,
    });
    this.controls.addEventListener("change", () => this.request());
    this.controls.addEventListener("start", () => (this.untouched = false));
    this.node.addEventListener("keydown", (event) => this.pressed(event));
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.element);
    this.resize();
  }

  resize() {
    const [width, height] = [this.element.clientWidth || 1, this.element.clientHeight || 1];
    this.screen.set(width, height);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.untouched) this.reset();
    // A canvas is blank after its size has changed: draw before the browser shows it.
    this.render();
  }

  /** Draw with the next frame. */
  request() {
    this.frame ||= requestAnimationFrame(() => {
      this.frame = 0;
      // Turns on for a while after the pointer has let go; asks for a frame as long as it does.
      this.controls.update();
      this.render();
    });
  }

  render() {
    // Pictures and the aircraft keep their size on the screen.
    const pixel = (2 * Math.tan((FIELD_DEG * Math.PI) / 360)) / this.screen.y;
    for (const sprite of this.sprites) sprite.scale.setScalar(SPRITE * pixel);
    const { aircraft } = this.layers;
    for (const body of aircraft?.children ?? []) {
      const distance = body.position.distanceTo(this.camera.position);
      body.scale.setScalar(AIRCRAFT_PIXELS * pixel * distance);
    }
    this.renderer.render(this.world, this.camera);
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
    this.request();
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

  show(name, value) {
    this.shown[name] = value;
    this.build(name);
  }

  clear(name) {
    this.layers[name]?.traverse((item) => {
      this.sprites.delete(item);
      item.geometry?.dispose();
      item.material?.map?.dispose();
      item.material?.dispose();
    });
    this.layers[name]?.removeFromParent();
    this.layers[name] = new THREE.Group();
    this.world.add(this.layers[name]);
    return this.layers[name];
  }

  build(name) {
    const group = this.clear(name);
    const build = {
      paths: (path) => this.addPath(group, path),
      points: (point) => this.addPoint(group, point),
      aircraft: (aircraft) => this.addAircraft(group, aircraft),
      marked: (place) => this.addMark(group, place),
    };
    if (name === "zones") this.addZones(group, this.shown.zones);
    else for (const item of [this.shown[name]].flat()) if (item) build[name](item);
    this.request();
  }

  buildLand() {
    const { terrain } = this.data;
    const group = this.clear("land");
    const skin = new THREE.CanvasTexture(reliefOf(terrain));
    skin.colorSpace = THREE.SRGBColorSpace;
    skin.anisotropy = this.renderer.capabilities.getMaxAnisotropy();
    group.add(ground(terrain, this.place, skin), sides(terrain, this.place, -FOOT, this.colours.earth));
    const north = this.sprite((context) => {
      drawText(context, "N", 0, 0, { colour: this.colours.text, rim: this.colours.paper, bold: true });
    });
    north.position.set(0, (terrain.height_m / 2) * this.unit + 0.05, 0);
    group.add(north);
  }

  addZones(group, zones) {
    const { low_m, vertical } = this.data.terrain;
    const box = {
      bottom_m: low_m - FOOT / (vertical * this.unit),
      top_m: this.highest(true) + 0.08 / (vertical * this.unit),
    };
    const colour = this.colours.nofly;
    const body = zonesOf(zones, this.place, box, colour);
    body.renderOrder = 2;
    group.add(body, outlinesOf(zones, this.place, box, colour));
  }

  /** Return the greatest altitude of land and paths, and perhaps of the limits of zones, metres. */
  highest(withZones) {
    const { paths, points, zones } = this.shown;
    const heights = paths.flatMap((path) => path.points.map(([, , z]) => z));
    heights.push(...points.map(({ z }) => z));
    const limits = zones.flatMap(({ lower_m, upper_m }) => [lower_m, upper_m]);
    if (withZones) heights.push(...limits.filter((limit) => limit !== null));
    return heights.reduce((a, b) => Math.max(a, b), this.data.terrain.high_m);
  }

  addPath(group, path) {
    const colour = colourOf(this.colours, path.colour);
    const line = path.points.flatMap((point) => this.place(...point));
    if (line.length < 6) return;
    const opacity = path.opacity ?? 1;
    const styles = [
      // Through the hills, faintly: where the path goes on behind them.
      { colour, width: 3, opacity: 0.22 * opacity, hidden: true },
      { colour: "#ffffff", width: 6, opacity: 0.85 * opacity, lift: 0.002 },
      { colour, width: 3.2, opacity, lift: 0.002 },
    ];
    styles.forEach((style, order) => {
      const mesh = fatLine(line, style, this.screen);
      mesh.renderOrder = 3 + order + (path.colour === "trouble" ? 3 : 0);
      group.add(mesh);
    });
    if (path.curtain) {
      const below = (x, y) => groundAt(this.data.terrain, x, y);
      const hanging = curtain(path.points, below, this.place, colour);
      hanging.renderOrder = 1;
      group.add(hanging);
    }
  }

  addPoint(group, point) {
    const at = this.place(point.x, point.y, point.z);
    const picture = this.sprite((context) => {
      drawPoint(context, point.kind, 0, 0, 8, this.colours);
      const style = { colour: this.colours.text, rim: this.colours.paper, bold: true };
      if (point.kind !== "return") drawText(context, point.name, 0, -20, style);
    });
    picture.position.set(...at);
    group.add(picture);
    this.addStem(group, point);
  }

  addMark(group, place) {
    const ring = this.sprite((context) => drawMark(context, 0, 0, this.colours), 12);
    ring.position.set(...this.place(place.x, place.y, place.z));
    group.add(ring);
    this.addStem(group, place);
  }

  /** Add the line from a point down to the ground. */
  addStem(group, { x, y, z }) {
    const below = groundAt(this.data.terrain, x, y);
    if (!Number.isFinite(below)) return;
    const stem = fatLine([...this.place(x, y, z), ...this.place(x, y, below)], {
      colour: "#22272b",
      width: 1.6,
      lift: 0.002,
    }, this.screen);
    stem.renderOrder = 9;
    group.add(stem);
  }

  addAircraft(group, { x, y, z, heading_deg }) {
    const shape = new THREE.Shape([[0, 1], [0.7, -0.8], [0, -0.4], [-0.7, -0.8]].map((corner) =>
      new THREE.Vector2(...corner),
    ));
    const material = new THREE.MeshBasicMaterial({ color: "#d55e00", side: THREE.DoubleSide });
    const body = new THREE.Mesh(new THREE.ShapeGeometry(shape), material);
    const rim = new THREE.LineLoop(
      new THREE.BufferGeometry().setFromPoints(shape.getPoints()),
      new THREE.LineBasicMaterial({ color: "#ffffff" }),
    );
    body.add(rim);
    body.position.set(...this.place(x, y, z));
    body.rotation.z = (-heading_deg * Math.PI) / 180;
    body.renderOrder = 11;
    group.add(body);
    this.addStem(group, { x, y, z });
  }

  /** Return a picture that keeps its size and is seen through everything. */
  sprite(draw, order = 10) {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = 2 * SPRITE;
    const context = canvas.getContext("2d");
    context.translate(SPRITE, SPRITE);
    context.scale(2, 2);
    draw(context);
    const map = new THREE.CanvasTexture(canvas);
    map.colorSpace = THREE.SRGBColorSpace;
    const material = new THREE.SpriteMaterial({ map, sizeAttenuation: false, depthTest: false });
    const sprite = new THREE.Sprite(material);
    sprite.renderOrder = order;
    this.sprites.add(sprite);
    return sprite;
  }
}

/** Return the least and the greatest of some numbers. */
function range(values) {
  return [Math.min(...values), Math.max(...values)];
}

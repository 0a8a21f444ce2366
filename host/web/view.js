// The 3-D view: terrain, zones, paths, points, aircraft and the marked place, by three.js.

import { THREE } from "nicegui-scene";

import { Eye, FIELD_DEG } from "./eye.js";
import { fatLine } from "./lines.js";
import { drawMark, drawPoint, drawText } from "./marks.js";
import { reliefOf } from "./relief.js";
import { colourOf, coloursOf, drawnPaths, groundAt } from "./scene.js";
import { curtain, ground, outlinesOf, segments, sides, zonesOf } from "./solids.js";

// The longer side of the map in the scene's units, and how far its sides reach below the land.
const SIDE = 2;
const FOOT = 0.05;
// Pixels of the pictures of points, drawn twice as fine.
const SPRITE = 64;
const AIRCRAFT_PIXELS = 15;
// Longest time between frames of a smooth movement, and time without a frame that ends one.
const [SMOOTH_MS, REST_MS] = [50, 400];
// Part of the pixels along a side that a movement gets on a machine without a graphics card.
const COARSE = 0.6;

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
    this.screen = new THREE.Vector2(1, 1);
    this.world = new THREE.Scene();
    this.layers = {};
    this.sprites = new Set();
    this.frame = 0;
    this.moving = false;
    // Mean time that the last frames have waited for the frames before them.
    this.waited_ms = 0;
    this.shown = {
      paths: drawnPaths(scene),
      zones: scene.zones,
      points: scene.points,
      aircraft: null,
      marked: null,
    };
    this.attach();
    this.redraw();
    this.resize();
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

  /** Build everything again, in the current colours. */
  redraw() {
    this.colours = coloursOf(this.element);
    this.buildLand();
    for (const name of Object.keys(this.shown)) this.build(name);
  }

  /** Return the corners of a box around map and paths, in the scene's units. */
  box() {
    const { width_m, height_m, low_m } = this.data.terrain;
    const high_m = this.highest(false);
    return [0, 1, 2, 3, 4, 5, 6, 7].map((i) =>
      this.place(i & 1 ? width_m : 0, i & 2 ? height_m : 0, i & 4 ? high_m : low_m),
    );
  }

  dispose() {
    cancelAnimationFrame(this.frame);
    clearTimeout(this.rest);
    this.observer.disconnect();
    this.eye.dispose();
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
    this.eye = new Eye(this.node, () => this.request(true), () => this.box());
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.element);
  }

  resize() {
    const [width, height] = [this.element.clientWidth || 1, this.element.clientHeight || 1];
    this.screen.set(width, height);
    this.renderer.setSize(width, height);
    this.eye.fit(width, height);
    // A canvas is blank after its size has changed: draw before the browser shows it.
    this.render();
  }

  /** Draw with the next frame; `moving` tells a movement of the eye from another change. */
  request(moving = false) {
    this.moving ||= moving;
    if (this.frame) return;
    const asked = performance.now();
    this.frame = requestAnimationFrame(() => {
      this.frame = 0;
      this.pace(performance.now() - asked);
      // Turns on for a while after the pointer has let go; asks for a frame as long as it does.
      this.eye.update();
      this.render();
    });
  }

  /** Draw coarsely in a movement that is not smooth, and finely when it has ended. */
  pace(waited_ms) {
    this.waited_ms = (this.waited_ms + waited_ms) / 2;
    const coarse = this.moving && this.waited_ms > SMOOTH_MS;
    this.moving = false;
    if (coarse !== this.coarse) this.refine(!coarse);
    clearTimeout(this.rest);
    if (coarse) this.rest = setTimeout(() => this.request(), REST_MS);
  }

  /** Take all triangles and pixels, or few of them. */
  refine(fine) {
    this.coarse = !fine;
    this.land.userData.draw(fine);
    const ratio = Math.min(devicePixelRatio || 1, 2);
    this.renderer.setPixelRatio(fine ? ratio : COARSE * ratio);
  }

  render() {
    // Pictures and the aircraft keep their size on the screen.
    const pixel = (2 * Math.tan((FIELD_DEG * Math.PI) / 360)) / this.screen.y;
    for (const sprite of this.sprites) sprite.scale.setScalar(SPRITE * pixel);
    const { aircraft } = this.layers;
    for (const body of aircraft?.children ?? []) {
      const distance = body.position.distanceTo(this.eye.camera.position);
      body.scale.setScalar(AIRCRAFT_PIXELS * pixel * distance);
    }
    this.renderer.render(this.world, this.eye.camera);
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
    skin.anisotropy = Math.min(2, this.renderer.capabilities.getMaxAnisotropy());
    this.land = ground(terrain, this.place, skin);
    this.refine(true);
    group.add(this.land, sides(terrain, this.place, -FOOT, this.colours.earth));
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
    if (path.thin) {
      const mesh = fatLine(line, { colour, width: 1.6, opacity, lift: 0.002 }, this.screen);
      mesh.renderOrder = 3;
      group.add(mesh);
      return;
    }
    const styles = [
      // Faintly through the hills, where they hide the path.
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

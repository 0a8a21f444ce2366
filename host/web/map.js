// The map: tinted hillshade, zones, paths and the points of the flight, to pan and to zoom.

import { Canvas } from "./canvas.js";
import { drawAircraft, drawFaults, drawMark, drawPoint, drawRally, drawText } from "./marks.js";
import { reliefOf } from "./relief.js";
import { clamp, colourOf, coloursOf, drawnPaths, faded, niceStep } from "./scene.js";

const MARGIN_PIXELS = 14;
const PAN_PIXELS = 40;
const ZOOM_STEP = 1.35;
const MOST_ZOOM = 60;
// Part of the map's sides that a framed track takes.
const FRAME = 0.7;
// Pixels by metre from which the legs of a mission are drawn.
const LEGS_SCALE = 0.1;

/** A map of a decoded scene in an element that has a size of its own. */
export class TerrainMap {
  /**
   * @param {HTMLElement} element Filled by the map.
   * @param {object} scene Result of readScene.
   */
  constructor(element, scene) {
    this.element = element;
    this.terrain = scene.terrain;
    this.relief = reliefOf(scene.terrain);
    /** Functions (context, map), called last in each drawing; pixelsAt gives them places. */
    this.overlays = new Set();
    /** False leaves drags of the pointer to the page, to draw with. */
    this.panning = true;
    /** Called with metres {x, y}, or null outside, as the pointer moves without a drag. */
    this.onPoint = null;
    this.paths = drawnPaths(scene);
    this.zones = scene.zones;
    this.points = scene.points;
    this.faults = scene.faults ?? [];
    this.aircraft = this.marked = null;
    this.fitted = true;
    this.centre = { x: scene.terrain.width_m / 2, y: scene.terrain.height_m / 2 };
    this.zoom = 1;
    const label = "Map. Arrow keys pan, plus and minus zoom, 0 shows the whole map.";
    this.canvas = new Canvas(element, label, (context) => this.draw(context));
    this.pointers = new Map();
    this.listen();
  }

  setPaths(paths) {
    this.paths = paths;
    this.redraw();
  }

  setZones(zones) {
    this.zones = zones;
    this.redraw();
  }

  setPoints(points) {
    this.points = points;
    this.redraw();
  }

  /** Show the marks of faults {x, y}. */
  setFaults(faults) {
    this.faults = faults;
    this.redraw();
  }

  /** Show the aircraft at {x, y, z, heading_deg}, or none for null. */
  setAircraft(aircraft) {
    this.aircraft = aircraft;
    this.redraw();
  }

  /** Mark the place {x, y, z}, or none for null. */
  mark(place) {
    this.marked = place;
    this.redraw();
  }

  redraw() {
    this.canvas.redraw();
  }

  /** Show the whole map. */
  fit() {
    this.fitted = true;
    this.redraw();
  }

  /** Show the part of the map around a track. */
  frame({ x, y }) {
    const spans = [x, y].map((all) => {
      const known = all.filter(Number.isFinite);
      return [known.reduce((a, b) => Math.min(a, b)), known.reduce((a, b) => Math.max(a, b))];
    });
    const { width, height } = this.canvas;
    const scales = [width, height].map((side, i) => side / Math.max(spans[i][1] - spans[i][0], 1));
    this.fitted = false;
    this.zoom = clamp((FRAME * Math.min(...scales)) / this.whole(), 1, MOST_ZOOM);
    this.moveTo(...spans.map(([low, high]) => (low + high) / 2));
  }

  dispose() {
    this.canvas.dispose();
  }

  /** Return the metres {x, y} below a pointer's event. */
  metresAt(event) {
    return this.metresOf(...this.canvas.place(event));
  }

  metresOf(left, top) {
    const scale = this.scale();
    return {
      x: this.centre.x + (left - this.canvas.width / 2) / scale,
      y: this.centre.y - (top - this.canvas.height / 2) / scale,
    };
  }

  /** Return the pixels of CSS [left, top] of metres. */
  pixelsAt(x, y) {
    const scale = this.scale();
    return [
      this.canvas.width / 2 + (x - this.centre.x) * scale,
      this.canvas.height / 2 - (y - this.centre.y) * scale,
    ];
  }

  /** Return pixels by metre. */
  scale() {
    return this.whole() * (this.fitted ? 1 : this.zoom);
  }

  whole() {
    const { width, height } = this.canvas;
    const { width_m, height_m } = this.terrain;
    const [wide, high] = [width - 2 * MARGIN_PIXELS, height - 2 * MARGIN_PIXELS];
    return Math.max(Math.min(wide / width_m, high / height_m), 1e-9);
  }

  /** Zoom by a factor around a place in pixels, by default the middle. */
  zoomBy(factor, left = this.canvas.width / 2, top = this.canvas.height / 2) {
    const before = this.metresOf(left, top);
    this.free();
    this.zoom = clamp(this.zoom * factor, 0.5, MOST_ZOOM);
    const after = this.metresOf(left, top);
    this.moveTo(this.centre.x + before.x - after.x, this.centre.y + before.y - after.y);
  }

  panBy(left, top) {
    const scale = this.scale();
    this.free();
    this.moveTo(this.centre.x - left / scale, this.centre.y + top / scale);
  }

  free() {
    if (this.fitted) this.zoom = 1;
    this.fitted = false;
  }

  moveTo(x, y) {
    this.centre = {
      x: clamp(x, 0, this.terrain.width_m),
      y: clamp(y, 0, this.terrain.height_m),
    };
    this.redraw();
  }

  listen() {
    const { node } = this.canvas;
    node.style.touchAction = "none";
    node.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoomBy(ZOOM_STEP ** -clamp(event.deltaY / 100, -2, 2), ...this.canvas.place(event));
    }, { passive: false });
    node.addEventListener("pointerdown", (event) => {
      if (!this.panning) return;
      node.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, this.canvas.place(event));
    });
    node.addEventListener("pointermove", (event) => this.moved(event));
    for (const type of ["pointerup", "pointercancel"]) {
      node.addEventListener(type, (event) => this.pointers.delete(event.pointerId));
    }
    node.addEventListener("pointerleave", () => this.onPoint?.(null));
    node.addEventListener("dblclick", (event) => {
      if (this.panning) this.zoomBy(ZOOM_STEP ** 2, ...this.canvas.place(event));
    });
    node.addEventListener("keydown", (event) => this.pressed(event));
  }

  moved(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) {
      if (!this.pointers.size) this.onPoint?.(this.metresAt(event));
      return;
    }
    const now = this.canvas.place(event);
    this.pointers.set(event.pointerId, now);
    const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId);
    if (!other) {
      this.panBy(now[0] - before[0], now[1] - before[1]);
      return;
    }
    // Two fingers: the ground stays below both as nearly as a zoom can do it.
    const still = other[1];
    const distance = (place) => Math.max(Math.hypot(place[0] - still[0], place[1] - still[1]), 8);
    this.zoomBy(distance(now) / distance(before), ...still);
  }

  pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const keys = {
      ArrowLeft: () => this.panBy(PAN_PIXELS, 0),
      ArrowRight: () => this.panBy(-PAN_PIXELS, 0),
      ArrowUp: () => this.panBy(0, PAN_PIXELS),
      ArrowDown: () => this.panBy(0, -PAN_PIXELS),
      "+": () => this.zoomBy(ZOOM_STEP),
      "=": () => this.zoomBy(ZOOM_STEP),
      "-": () => this.zoomBy(1 / ZOOM_STEP),
      0: () => this.fit(),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  }

  draw(context) {
    if (this.fitted) {
      this.centre = { x: this.terrain.width_m / 2, y: this.terrain.height_m / 2 };
    }
    const colours = coloursOf(this.element);
    this.drawRelief(context);
    for (const zone of this.zones) this.drawZone(context, zone, colours);
    for (const path of this.paths) this.drawPath(context, path, colours);
    for (const zone of this.zones) this.nameZone(context, zone, colours);
    // The start above a return to it.
    for (const point of [...this.points].reverse()) {
      drawPoint(context, point.kind, ...this.pixelsAt(point.x, point.y), 8, colours);
    }
    this.drawScale(context);
    drawFaults(context, this.faults.map(({ x, y }) => this.pixelsAt(x, y)), colours);
    if (this.marked) drawMark(context, ...this.pixelsAt(this.marked.x, this.marked.y), colours);
    if (this.aircraft) {
      const { x, y, heading_deg } = this.aircraft;
      drawAircraft(context, ...this.pixelsAt(x, y), heading_deg, 12);
    }
    for (const overlay of this.overlays) overlay(context, this);
  }

  drawRelief(context) {
    const { width_m, height_m, dx_m, dy_m } = this.terrain;
    // A pixel of the relief is as wide as a cell, around its node.
    const [left, top] = this.pixelsAt(-dx_m / 2, height_m + dy_m / 2);
    const [right, bottom] = this.pixelsAt(width_m + dx_m / 2, -dy_m / 2);
    context.imageSmoothingEnabled = (right - left) / this.terrain.columns < 12;
    context.imageSmoothingQuality = "high";
    context.drawImage(this.relief, left, top, right - left, bottom - top);
  }

  drawZone(context, zone, colours) {
    this.outlineOf(context, zone);
    context.fillStyle = faded(colours.nofly, 0.26);
    context.fill("evenodd");
    Object.assign(context, { lineWidth: 1.5, strokeStyle: colours.nofly });
    context.stroke();
  }

  outlineOf(context, zone) {
    context.beginPath();
    if (zone.circle) {
      const { x, y, radius_m } = zone.circle;
      context.arc(...this.pixelsAt(x, y), radius_m * this.scale(), 0, 2 * Math.PI);
      return;
    }
    for (const ring of zone.rings) {
      ring.forEach(([x, y], i) => context[i ? "lineTo" : "moveTo"](...this.pixelsAt(x, y)));
      context.closePath();
    }
  }

  nameZone(context, zone, colours) {
    if (!zone.text) return;
    const [ring] = zone.rings;
    const middle = [0, 1].map((axis) => ring.reduce((sum, corner) => sum + corner[axis], 0));
    const [left, top] = this.pixelsAt(middle[0] / ring.length, middle[1] / ring.length);
    drawText(context, zone.text, left, top, { colour: colours.nofly, rim: "#ffffffd9" });
  }

  drawPath(context, path, colours) {
    const colour = colourOf(colours, path.colour);
    if (path.thin) {
      this.drawThin(context, path, colour);
      return;
    }
    context.save();
    context.globalAlpha = path.opacity ?? 1;
    context.beginPath();
    for (const [x, y] of path.points) context.lineTo(...this.pixelsAt(x, y));
    Object.assign(context, { lineJoin: "round", lineCap: "round" });
    Object.assign(context, { lineWidth: 6, strokeStyle: "#ffffffd9" });
    context.stroke();
    Object.assign(context, { lineWidth: 3, strokeStyle: colour });
    context.stroke();
    Object.assign(context, { lineWidth: 1.5, fillStyle: "#ffffff" });
    for (const [x, y] of (path.waypoints ?? []).slice(1, -1)) {
      context.beginPath();
      context.arc(...this.pixelsAt(x, y), 3, 0, 2 * Math.PI);
      context.fill();
      context.stroke();
    }
    context.restore();
  }

  /** Draw a line of a mission's end, or its items and rally points. */
  drawThin(context, path, colour) {
    context.save();
    context.globalAlpha = path.opacity;
    context.beginPath();
    for (const [x, y] of path.points) context.lineTo(...this.pixelsAt(x, y));
    Object.assign(context, { lineWidth: 3, strokeStyle: "#ffffff99" });
    context.stroke();
    context.setLineDash(path.dashes ?? []);
    Object.assign(context, { lineWidth: 1.5, strokeStyle: colour });
    context.stroke();
    context.setLineDash([]);
    context.beginPath();
    // From close, the legs between the items differ from the smoothed path.
    if (this.scale() > LEGS_SCALE) {
      for (const [x, y] of path.legs ?? []) context.lineTo(...this.pixelsAt(x, y));
    }
    Object.assign(context, { lineWidth: 1.2, strokeStyle: "#22272b", fillStyle: "#22272b" });
    context.stroke();
    for (const [x, y] of path.items ?? []) {
      const [left, top] = this.pixelsAt(x, y);
      context.fillRect(left - 1.5, top - 1.5, 3, 3);
    }
    for (const [x, y] of path.rally ?? []) drawRally(context, ...this.pixelsAt(x, y));
    context.restore();
  }

  /** Draw the scale and the arrow to the north, in the lower corner that hides less. */
  drawScale(context) {
    const { width, height } = this.canvas;
    const metres = niceStep(width / this.scale(), 5);
    const length = metres * this.scale();
    const [wide, high] = [length + 50, 40];
    const top = height - MARGIN_PIXELS - high;
    const corners = [MARGIN_PIXELS, width - MARGIN_PIXELS - wide];
    const hidden = corners.map((left) => this.hiddenBy(left, top, wide, high));
    const left = corners[hidden[1] < hidden[0] ? 1 : 0];
    context.fillStyle = "#ffffffd9";
    context.beginPath();
    context.roundRect(left, top, wide, high, 5);
    context.fill();
    Object.assign(context, { strokeStyle: "#22272b", fillStyle: "#22272b", lineWidth: 2 });
    const [begin, base] = [left + 10, top + high - 9];
    context.beginPath();
    for (const [x, y] of [[0, -5], [0, 0], [length, 0], [length, -5]]) {
      context.lineTo(begin + x, base + y);
    }
    context.stroke();
    const text = metres >= 1000 ? `${metres / 1000} km` : `${metres} m`;
    const plain = { colour: "#22272b", rim: "#ffffff00" };
    const north = begin + length + 22;
    drawText(context, text, begin + length / 2, base - 14, plain);
    drawText(context, "N", north, base - 2, { ...plain, bold: true });
    context.beginPath();
    for (const [x, y] of [[0, -26], [5, -11], [0, -15], [-5, -11]]) {
      context.lineTo(north + x, base + y);
    }
    context.fill();
  }

  /** Return how many points of paths and flight a box would hide. */
  hiddenBy(left, top, wide, high) {
    const places = [
      ...this.paths.flatMap(({ points }) => points),
      ...this.points.map(({ x, y }) => [x, y]),
    ];
    return places.filter(([x, y]) => {
      const [across, down] = this.pixelsAt(x, y);
      return across > left - 12 && across < left + wide + 12 && down > top - 12 && down < top + high + 12;
    }).length;
  }
}

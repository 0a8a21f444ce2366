// The altitude profile: ground, required clearance, zones and ceilings along a track.

import { Canvas } from "./canvas.js";
import { drawFaults, drawMark, drawPoint, drawText } from "./marks.js";
import { at, clamp, coloursOf, faded, insideZone, metres, nearest, niceStep, number, runs } from "./scene.js";

const [LEFT, RIGHT, TOP, BOTTOM] = [58, 16, 14, 40];
const KEY_STEPS = 200;
const PAGE_STEPS = 20;
// Greatest height above the altitudes at which a ceiling is shown, as a share of their range.
const HIGHER = 0.5;
// Colour of a track to compare, as of a kept plan on the desk.
const BESIDE = "#d55e00";

/** A profile of the first track of a decoded scene in an element that has a size of its own. */
export class Profile {
  /**
   * @param {HTMLElement} element Filled by the profile.
   * @param {object} scene Result of readScene.
   */
  constructor(element, scene) {
    this.element = element;
    this.scene = scene;
    this.zones = scene.zones;
    this.track = this.beside = null;
    this.s = null;
    /** Called with the row of at(track, s), or null, when the reader marks another place. */
    this.onMark = null;
    this.canvas = new Canvas(element, "Altitude profile", (...box) => this.draw(...box));
    this.listen();
    this.setTrack(scene.paths[0]?.track ?? null);
  }

  /**
   * Show another track of the same scene, or none.
   *
   * @param {object} track The track.
   * @param {object} beside Another track to compare, over the same width, or null.
   */
  setTrack(track, beside = null) {
    this.track = track;
    this.beside = beside;
    this.s = null;
    this.measure();
    this.describe();
    this.redraw();
  }

  setZones(zones) {
    this.zones = zones;
    this.measure();
    this.redraw();
  }

  /** Mark the place at `s` metres flown, or none for null; onMark is not called. */
  mark(s) {
    this.s = s === null || !this.track ? null : clamp(s, 0, this.track.length_m);
    this.describe();
    this.redraw();
  }

  redraw() {
    this.canvas.redraw();
  }

  dispose() {
    this.canvas.dispose();
  }

  listen() {
    const { node } = this.canvas;
    node.setAttribute("role", "slider");
    // A finger marks along the track and scrolls the page across it.
    node.style.touchAction = "pan-y";
    for (const type of ["pointermove", "pointerdown"]) {
      node.addEventListener(type, (event) => {
        if (this.track) this.choose(this.metresAt(this.canvas.place(event)[0]));
      });
    }
    node.addEventListener("keydown", (event) => this.pressed(event));
  }

  pressed(event) {
    if (!this.track || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = (this.track.length_m / KEY_STEPS) * (event.shiftKey ? 0.1 : 1);
    const now = this.s ?? 0;
    const keys = {
      ArrowLeft: now - step,
      ArrowDown: now - step,
      ArrowRight: now + step,
      ArrowUp: now + step,
      PageDown: now - PAGE_STEPS * step,
      PageUp: now + PAGE_STEPS * step,
      Home: 0,
      End: this.track.length_m,
      Escape: null,
    };
    if (!(event.key in keys)) return;
    event.preventDefault();
    this.choose(keys[event.key]);
  }

  choose(s) {
    this.mark(s);
    this.onMark?.(this.s === null ? null : at(this.track, this.s));
  }

  /** Tell assistive technology where the mark is. */
  describe() {
    const { node } = this.canvas;
    const row = this.s === null ? null : at(this.track, this.s);
    const text = row
      ? `${metres(row.s)} flown, altitude ${metres(row.z, Infinity)}, ` +
        `${metres(row.z - row.ground, Infinity)} above ground`
      : "no place marked";
    node.setAttribute("aria-valuemin", 0);
    node.setAttribute("aria-valuemax", Math.round(this.track?.length_m ?? 0));
    node.setAttribute("aria-valuenow", Math.round(this.s ?? 0));
    node.setAttribute("aria-valuetext", text);
  }

  /** Compute all that is independent of the size: range of altitudes, crossed zones, visits. */
  measure() {
    const { track } = this;
    if (!track) return;
    const heights = [...track.z, ...track.ground, ...(this.beside?.z ?? [])].filter(Number.isFinite);
    const low = heights.reduce((a, b) => Math.min(a, b));
    const high = heights.reduce((a, b) => Math.max(a, b));
    this.ceilings = this.scene.ceilings.map(({ name, altitude_m, agl }) => ({
      text: `${name} ${number(altitude_m, 0)} m`,
      heights: track.ground.map((ground) => (agl ? ground + altitude_m : altitude_m)),
    }));
    const tops = this.ceilings.map(({ heights: all }) => Math.max(...all.filter(Number.isFinite)));
    const near = tops.filter((top) => top <= high + HIGHER * (high - low));
    const top = Math.max(high, ...near);
    const margin = Math.max(1, 0.1 * (top - low));
    [this.low, this.high] = [low - margin, top + margin];
    this.crossed = this.zones
      .flatMap((zone) => zone.tiles ?? [zone])
      .map((zone) => ({
        zone,
        spans: runs(track.samples, (i) => insideZone(zone, track.x[i], track.y[i])),
      }))
      .filter(({ spans }) => spans.length);
    this.visits = this.scene.points.map((point, i, all) => {
      const ends = { 0: 0, [all.length - 1]: track.length_m };
      return { kind: point.kind, s: ends[i] ?? nearest(track, point.x, point.y).s };
    });
  }

  metresAt(left) {
    return ((left - LEFT) / (this.canvas.width - LEFT - RIGHT)) * this.track.length_m;
  }

  left(s) {
    return LEFT + (s / this.track.length_m) * (this.canvas.width - LEFT - RIGHT);
  }

  top(altitude) {
    const part = (this.high - altitude) / (this.high - this.low);
    return TOP + part * (this.canvas.height - TOP - BOTTOM);
  }

  draw(context, width, height) {
    const colours = coloursOf(this.element);
    if (!this.track) {
      const style = { colour: colours.muted, rim: colours.paper };
      drawText(context, "No path yet", width / 2, height / 2, style);
      return;
    }
    this.drawGrid(context, width, height, colours);
    context.save();
    context.beginPath();
    context.rect(LEFT, TOP, width - LEFT - RIGHT, height - TOP - BOTTOM);
    context.clip();
    this.drawZones(context, colours);
    this.fill(context, this.track.ground, () => this.low, colours.earth);
    this.fill(context, this.track.demanded, (i) => this.track.ground[i], faded(colours.band, 0.5));
    this.line(context, this.track.ground, colours.edge, 1);
    context.setLineDash([6, 4]);
    for (const { heights } of this.ceilings) this.line(context, heights, colours.text, 1);
    context.setLineDash([]);
    if (this.beside) this.line(context, this.beside.z, BESIDE, 1.5, this.beside);
    this.line(context, this.track.z, colours.line, 2.5);
    this.drawBroken(context, colours);
    context.restore();
    this.nameCeilings(context, colours);
    for (const { kind, s } of this.visits) {
      drawPoint(context, kind, this.left(s), this.top(at(this.track, s).z), 6, colours);
    }
    const faults = this.scene.faults ?? [];
    const places = faults.map(({ at_m, z }) => at_m === null ? null : [this.left(at_m), this.top(z)]);
    drawFaults(context, places, colours);
    if (this.s !== null) this.drawMarked(context, height, colours);
  }

  drawGrid(context, width, height, colours) {
    Object.assign(context, { strokeStyle: colours.grid, lineWidth: 1 });
    const style = { colour: colours.muted, rim: "#ffffff00" };
    const span = this.high - this.low;
    const rise = niceStep(span, clamp((height - TOP - BOTTOM) / 34, 2, 8));
    for (let z = Math.ceil(this.low / rise) * rise; z <= this.high; z += rise) {
      this.rule(context, LEFT, this.top(z), width - RIGHT, this.top(z));
      drawText(context, number(z, rise < 1 ? 1 : 0), LEFT - 8, this.top(z), { ...style, align: "right" });
    }
    const { length_m } = this.track;
    const [unit_m, unit] = length_m >= 2000 ? [1000, "km"] : [1, "m"];
    const run = niceStep(length_m / unit_m, clamp((width - LEFT - RIGHT) / 70, 2, 16));
    for (let s = 0; s <= (length_m / unit_m) * 1.0001; s += run) {
      const left = this.left(Math.min(s * unit_m, length_m));
      this.rule(context, left, TOP, left, height - BOTTOM);
      drawText(context, number(s, run < 1 ? 1 : 0), left, height - BOTTOM + 12, style);
    }
    drawText(context, `distance flown (${unit})`, (LEFT + width - RIGHT) / 2, height - 9, style);
    context.save();
    context.translate(11, (TOP + height - BOTTOM) / 2);
    context.rotate(-Math.PI / 2);
    drawText(context, "altitude (m)", 0, 0, style);
    context.restore();
  }

  rule(context, x0, y0, x1, y1) {
    context.beginPath();
    context.moveTo(Math.round(x0) + 0.5, Math.round(y0) + 0.5);
    context.lineTo(Math.round(x1) + 0.5, Math.round(y1) + 0.5);
    context.stroke();
  }

  /** Fill between two lines, where both have values. */
  fill(context, upper, lower, colour) {
    context.fillStyle = colour;
    const { s, samples } = this.track;
    for (const [from, to] of runs(samples, (i) => Number.isFinite(upper[i]))) {
      context.beginPath();
      for (let i = from; i < to; i++) context.lineTo(this.left(s[i]), this.top(upper[i]));
      for (let i = to - 1; i >= from; i--) context.lineTo(this.left(s[i]), this.top(lower(i)));
      context.fill();
    }
  }

  line(context, heights, colour, width, { s, samples, length_m } = this.track) {
    Object.assign(context, { strokeStyle: colour, lineWidth: width, lineJoin: "round" });
    const scale = this.track.length_m / length_m;
    for (const [from, to] of runs(samples, (i) => Number.isFinite(heights[i]))) {
      context.beginPath();
      for (let i = from; i < to; i++) context.lineTo(this.left(scale * s[i]), this.top(heights[i]));
      context.stroke();
    }
  }

  /** Draw the zones that the track crosses, seen from above, as blocks of their heights. */
  drawZones(context, colours) {
    Object.assign(context, { fillStyle: faded(colours.nofly, 0.26), strokeStyle: colours.nofly });
    context.lineWidth = 1;
    const { s, samples } = this.track;
    for (const { zone, spans } of this.crossed) {
      const [top, bottom] = [zone.upper_m ?? 2 * this.high, zone.lower_m ?? 2 * this.low - this.high];
      for (const [from, to] of spans) {
        const [left, right] = [this.left(s[from]), this.left(s[Math.min(to, samples - 1)])];
        const box = [left, this.top(top), right - left, this.top(bottom) - this.top(top)];
        context.fillRect(...box);
        context.strokeRect(...box);
      }
    }
  }

  drawBroken(context, colours) {
    Object.assign(context, { strokeStyle: colours.trouble, lineWidth: 4, lineCap: "round" });
    for (const { from_m, to_m } of this.track.broken) {
      context.beginPath();
      const inner = this.track.s.filter((s) => s > from_m && s < to_m);
      for (const s of [from_m, ...inner, to_m]) {
        context.lineTo(this.left(s), this.top(at(this.track, s).z));
      }
      context.stroke();
    }
  }

  nameCeilings(context, colours) {
    const right = this.canvas.width - RIGHT - 18;
    const style = { colour: colours.text, rim: colours.paper, align: "right" };
    const above = [];
    for (const { text, heights } of this.ceilings) {
      const last = heights.findLast(Number.isFinite);
      if (last < this.high) drawText(context, text, right, this.top(last) - 9, style);
      else above.push(text);
    }
    if (above.length) drawText(context, `↑ ${above.join(", ")}`, right, TOP + 8, style);
  }

  drawMarked(context, height, colours) {
    const row = at(this.track, this.s);
    const left = this.left(this.s);
    Object.assign(context, { strokeStyle: colours.text, lineWidth: 1 });
    this.rule(context, left, TOP, left, height - BOTTOM);
    drawMark(context, left, this.top(row.z), colours);
  }
}

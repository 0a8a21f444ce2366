// Drawing on the map: points by a click, zones by corners or by a radius, and all of them dragged.

import { coloursOf, faded, insideZone, metres } from "pathgene-views/scene.js";

const GRIP_PIXELS = 14;
const CLOSE_PIXELS = 10;

/** Hints for the page, one per tool. */
export const HINTS = {
  pan: "Drag points, zones or the ground; click a zone to edit it.",
  start: "Click where the flight starts.",
  goal: "Click where it ends.",
  via: "Click each point to pass on the way.",
  circle: "Press at the centre of the zone, drag to its edge.",
  polygon: "Click the corners; Enter or a double click closes the zone.",
};

/** Hints for the tools in a flight, which draw events that happen at once. */
export const FLYING = {
  pan: "Draw a zone in the way: it appears now, and the flight gets a new path.",
  goal: "Click where the flight ends instead.",
  circle: "Press at the centre of the zone, drag to its edge: it appears as you let go.",
  polygon: "Click the corners; Enter or a double click closes the zone, and it appears.",
};

/** Hints for the tools while a mission is checked, whose points stay as they are. */
export const CHECKING = {
  pan: "Drag zones or the ground; click a zone to edit it.",
  circle: HINTS.circle,
  polygon: HINTS.polygon,
};

/** Tools on a map. */
export class Tools {
  /**
   * @param {TerrainMap} map The map.
   * @param {function(string, object): void} emit Called with the name of an item that a user has drawn:
   *     `place` {name, number, x, y}, `via` {x, y}, `zone` and `reshape` {number, circle or
   *     polygon}, `pick` {number}, `tool` {name}.
   */
  constructor(map, emit) {
    this.map = map;
    this.emit = emit;
    this.tool = "pan";
    // In a flight, the existing points and zones stay as they are.
    this.flying = false;
    // The points are a mission's.
    this.checking = false;
    this.corners = [];
    this.pointer = null;
    this.drag = null;
    this.picked = null;
    map.overlays.add((context) => this.draw(context));
    const { node } = map.canvas;
    // Before the map's own, which pans.
    node.addEventListener("pointerdown", (event) => this.pressed(event), { capture: true });
    node.addEventListener("pointermove", (event) => this.moved(event), { capture: true });
    node.addEventListener("pointerup", (event) => this.released(event), { capture: true });
    node.addEventListener("pointercancel", () => this.cancel(), { capture: true });
    node.addEventListener("dblclick", (event) => this.doubled(event), { capture: true });
    node.addEventListener("keydown", (event) => this.key(event), { capture: true });
  }

  /** Take a tool: one of HINTS. */
  take(tool) {
    this.cancel();
    this.tool = tool;
    this.map.panning = tool === "pan";
    this.map.canvas.node.style.cursor = tool === "pan" ? "grab" : "crosshair";
  }

  /** Show the handles of a zone, or none for null. */
  pick(number) {
    this.picked = number;
    this.map.redraw();
  }

  cancel() {
    this.corners = [];
    this.drag = null;
    this.map.panning = this.tool === "pan";
    this.map.redraw();
  }

  pressed(event) {
    if (event.button !== 0 || !event.isPrimary) return;
    const place = this.map.metresAt(event);
    const spot = this.map.canvas.place(event);
    if (this.tool === "pan") {
      this.drag = this.gripAt(spot, place);
      if (this.drag) {
        this.map.panning = false;
        this.map.canvas.node.setPointerCapture(event.pointerId);
      } else if (!this.flying) {
        this.clicked = { spot, number: this.zoneAt(place) };
      }
      return;
    }
    if (this.tool === "circle") {
      this.drag = { kind: "new circle", centre: place, radius_m: 0 };
      this.map.canvas.node.setPointerCapture(event.pointerId);
    } else if (this.tool === "polygon") {
      this.corner(spot, place);
    } else if (this.tool === "via") {
      this.emit("via", place);
    } else {
      this.emit("place", { name: this.tool, number: 0, ...place });
      this.emit("tool", { name: "pan" });
    }
  }

  moved(event) {
    const place = this.map.metresAt(event);
    this.pointer = place;
    if (this.drag) {
      this.drag.moved = true;
      if (this.drag.kind === "new circle") {
        const { x, y } = this.drag.centre;
        this.drag.radius_m = Math.hypot(place.x - x, place.y - y);
      } else this.dragTo(place);
    }
    if (this.drag || this.corners.length) this.map.redraw();
    else if (this.tool === "pan" && !event.buttons) this.hover(event, place);
  }

  released(event) {
    const { drag, clicked } = this;
    [this.drag, this.clicked] = [null, null];
    this.map.panning = this.tool === "pan";
    if (drag?.kind === "new circle") {
      const { x, y } = drag.centre;
      if (drag.radius_m * this.map.scale() > 3) {
        this.emit("zone", { circle: [x, y, drag.radius_m] });
        this.emit("tool", { name: "pan" });
      }
    } else if (drag?.moved) {
      this.emit(drag.event, drag.shape ? { number: drag.number, ...drag.shape } : drag.value);
    } else if (clicked) {
      const [left, top] = this.map.canvas.place(event);
      if (Math.hypot(left - clicked.spot[0], top - clicked.spot[1]) < 4) {
        this.emit("pick", { number: clicked.number });
      }
    }
    this.map.redraw();
  }

  corner(spot, place) {
    const [first] = this.corners;
    if (first && this.corners.length > 2) {
      const [left, top] = this.map.pixelsAt(...first);
      if (Math.hypot(left - spot[0], top - spot[1]) < CLOSE_PIXELS) {
        this.close();
        return;
      }
    }
    this.corners.push([place.x, place.y]);
    this.map.redraw();
  }

  doubled(event) {
    if (this.tool !== "polygon") return;
    event.stopImmediatePropagation();
    // The second press of the double click has set a corner on the last one.
    this.corners.pop();
    this.close();
  }

  close() {
    if (this.corners.length > 2) {
      this.emit("zone", { polygon: this.corners });
      this.emit("tool", { name: "pan" });
    }
    this.cancel();
  }

  key(event) {
    if (event.key === "Escape") {
      this.cancel();
      this.emit("tool", { name: "pan" });
    } else if (event.key === "Enter" && this.corners.length) this.close();
    else if (event.key === "Backspace" && this.corners.length) {
      this.corners.pop();
      this.map.redraw();
    } else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  }

  /** Return the grip at a place: a point, a handle of the picked zone, or its inside. */
  gripAt(spot, place) {
    if (this.flying) return null;
    const near = (x, y) => {
      const [left, top] = this.map.pixelsAt(x, y);
      return Math.hypot(left - spot[0], top - spot[1]) < GRIP_PIXELS;
    };
    let via = 0;
    for (const point of this.map.points) {
      if (this.checking || point.kind === "return") continue;
      const number = point.kind === "via" ? via++ : 0;
      if (near(point.x, point.y)) return { kind: "point", event: "place", point, number };
    }
    const zone = this.map.zones[this.picked];
    if (!zone) return null;
    const common = { event: "reshape", number: this.picked, zone };
    if (zone.circle) {
      const { x, y, radius_m } = zone.circle;
      if (near(x + radius_m, y)) return { kind: "radius", ...common };
    } else {
      const corner = zone.rings[0].findIndex(([x, y]) => near(x, y));
      if (corner >= 0) return { kind: "corner", corner, ...common };
    }
    return insideZone(zone, place.x, place.y) ? { kind: "zone", from: place, ...common } : null;
  }

  dragTo(place) {
    const { drag } = this;
    if (drag.kind === "point") {
      Object.assign(drag.point, place);
      drag.value = { name: drag.point.kind, number: drag.number, ...place };
      return;
    }
    const { zone } = drag;
    const [east, north] = drag.from ? [place.x - drag.from.x, place.y - drag.from.y] : [0, 0];
    if (drag.from) drag.from = place;
    if (zone.circle) {
      const { circle } = zone;
      circle.x += east;
      circle.y += north;
      if (drag.kind === "radius") circle.radius_m = Math.hypot(place.x - circle.x, place.y - circle.y);
      drag.shape = { circle: [circle.x, circle.y, circle.radius_m] };
    } else {
      if (drag.kind === "corner") zone.rings[0][drag.corner] = [place.x, place.y];
      else zone.rings = zone.rings.map((ring) => ring.map(([x, y]) => [x + east, y + north]));
      drag.shape = { polygon: zone.rings[0], holes: zone.rings.slice(1) };
    }
  }

  zoneAt({ x, y }) {
    const number = this.map.zones.findLastIndex((zone) => insideZone(zone, x, y));
    return number < 0 ? null : number;
  }

  hover(event, place) {
    const grip = this.gripAt(this.map.canvas.place(event), place);
    const over = grip ? "move" : this.flying || this.zoneAt(place) === null ? "grab" : "pointer";
    this.map.canvas.node.style.cursor = over;
  }

  draw(context) {
    const colours = coloursOf(this.map.element);
    this.drawHandles(context, colours);
    Object.assign(context, { strokeStyle: colours.nofly, lineWidth: 2 });
    context.fillStyle = faded(colours.nofly, 0.25);
    if (this.drag?.kind === "new circle") this.drawCircle(context, colours);
    if (!this.corners.length) return;
    context.beginPath();
    const ring = this.pointer ? [...this.corners, [this.pointer.x, this.pointer.y]] : this.corners;
    for (const [x, y] of ring) context.lineTo(...this.map.pixelsAt(x, y));
    context.fill();
    context.stroke();
    for (const [x, y] of this.corners) this.handle(context, x, y, colours);
  }

  drawCircle(context, colours) {
    const { centre, radius_m } = this.drag;
    const [left, top] = this.map.pixelsAt(centre.x, centre.y);
    context.beginPath();
    context.arc(left, top, radius_m * this.map.scale(), 0, 2 * Math.PI);
    context.fill();
    context.stroke();
    context.fillStyle = colours.nofly;
    context.font = "600 12px system-ui, sans-serif";
    context.textAlign = "center";
    context.fillText(`r ${metres(radius_m)}`, left, top);
  }

  drawHandles(context, colours) {
    const zone = this.map.zones[this.picked];
    if (!zone || this.tool !== "pan" || this.flying) return;
    if (zone.circle) {
      const { x, y, radius_m } = zone.circle;
      this.handle(context, x + radius_m, y, colours);
    } else for (const [x, y] of zone.rings[0]) this.handle(context, x, y, colours);
  }

  handle(context, x, y, colours) {
    const [left, top] = this.map.pixelsAt(x, y);
    Object.assign(context, { fillStyle: "#ffffff", strokeStyle: colours.nofly, lineWidth: 2 });
    context.beginPath();
    context.rect(left - 4.5, top - 4.5, 9, 9);
    context.fill();
    context.stroke();
  }
}

// Decodes a scene, which scene.py documents, and has the functions that all views need of it.

const VOID = 65535;
const COLUMNS = ["s", "x", "y", "z", "ground", "clearance", "demanded"];

/** Return a scene with its arrays decoded: heights and tracks as Float32Array, NaN for a void. */
export function readScene(json) {
  const terrain = { ...json.terrain };
  const values = new Uint16Array(decode(terrain.heights));
  terrain.heights = Float32Array.from(values, (value) =>
    value === VOID ? NaN : terrain.low_m + terrain.step_m * value,
  );
  terrain.dx_m = terrain.width_m / (terrain.columns - 1);
  terrain.dy_m = terrain.height_m / (terrain.rows - 1);
  return { ...json, terrain, paths: json.paths.map(readPath) };
}

/** Return a path of path_scene with its track decoded. */
export function readPath(path) {
  const track = { ...path.track };
  for (const name of COLUMNS) track[name] = new Float32Array(decode(track[name]));
  return { ...path, track };
}

function decode(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;
}

/** Return the points [[x, y, z], ...] of a track. */
export function pointsOf(track) {
  return Array.from(track.s, (_, i) => [track.x[i], track.y[i], track.z[i]]);
}

/**
 * Return the paths of a scene as setPaths of the views takes them: each track with its waypoints,
 * and over it the stretches that break a limit.
 */
export function drawnPaths(scene) {
  return scene.paths.flatMap(({ track, waypoints, mission }) => {
    const points = pointsOf(track);
    const broken = track.broken.map(({ from_m, to_m }) => ({
      points: stretch(track, points, from_m, to_m),
      colour: "trouble",
      opacity: 1,
    }));
    const rest = mission ? drawnMission(mission) : [];
    const parts = partsOf(points).map((part, i) => ({
      points: part,
      waypoints: i ? [] : waypoints,
      colour: "path",
      opacity: 1,
      curtain: true,
    }));
    return [...parts, ...rest, ...broken];
  });
}

/** Return the parts of points between points of NaN, which separate flights of a mission. */
function partsOf(points) {
  const spans = runs(points.length, (i) => Number.isFinite(points[i][0]));
  return spans.map(([from, to]) => points.slice(from, to));
}

/** Return the end of a mission as an autopilot gets it, its items and its rally points. */
function drawnMission({ items, legs, way, go_around, circles, rally }) {
  const lines = [way, go_around].filter(({ length }) => length > 1);
  const thin = { colour: "path", opacity: 1, thin: true };
  return [
    ...lines.map((points) => ({ ...thin, points, dashes: [6, 3] })),
    ...circles.flatMap(({ x, y, z, radius_m, disc_m }) => [
      { ...thin, points: ring(x, y, z, radius_m) },
      { ...thin, points: ring(x, y, z, disc_m), dashes: [1.5, 4], opacity: 0.75 },
    ]),
    { ...thin, points: [], items, legs, rally },
  ];
}

/** Return the points of a level circle. */
function ring(x, y, z, radius_m) {
  return Array.from({ length: 73 }, (_, i) => {
    const angle = (2 * Math.PI * i) / 72;
    return [x + radius_m * Math.sin(angle), y + radius_m * Math.cos(angle), z];
  });
}

function stretch(track, points, from_m, to_m) {
  const place = (s) => [at(track, s)].map(({ x, y, z }) => [x, y, z]);
  // A stretch without length, as of a turn in one point, is made long enough to be seen.
  const least_m = Math.max(0, 0.004 * track.length_m - (to_m - from_m)) / 2;
  const [first, last] = [Math.max(from_m - least_m, 0), Math.min(to_m + least_m, track.length_m)];
  const inner = points.filter((_, i) => track.s[i] > first && track.s[i] < last);
  return [...place(first), ...inner, ...place(last)];
}

/** Return the height of the drawn ground at metres x, y; NaN over a void; the edge's off the map. */
export function groundAt(terrain, x, y) {
  const column = clamp(x / terrain.dx_m, 0, terrain.columns - 1);
  const row = clamp(y / terrain.dy_m, 0, terrain.rows - 1);
  const west = Math.min(Math.floor(column), terrain.columns - 2);
  const south = Math.min(Math.floor(row), terrain.rows - 2);
  const [u, v] = [column - west, row - south];
  const at = south * terrain.columns + west;
  const h = terrain.heights;
  const below = h[at] * (1 - u) + h[at + 1] * u;
  const above = h[at + terrain.columns] * (1 - u) + h[at + terrain.columns + 1] * u;
  return below * (1 - v) + above * v;
}

/** Return a track's row at `s` metres flown: each column between its neighbours. */
export function at(track, s) {
  const last = track.samples - 1;
  let [low, high] = [0, last];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (track.s[middle] <= s) low = middle;
    else high = middle;
  }
  const gap = track.s[high] - track.s[low];
  const part = gap > 0 ? clamp((s - track.s[low]) / gap, 0, 1) : 0;
  const row = {};
  for (const name of COLUMNS) {
    const [a, b] = [track[name][low], track[name][high]];
    // At a sample its own figures hold, even next to a void.
    row[name] = part === 0 ? a : part === 1 ? b : a + part * (b - a);
  }
  row.heading_deg = headingOf(track.x[high] - track.x[low], track.y[high] - track.y[low]);
  return row;
}

/** Return the heading of a step, degrees clockwise from north. */
export function headingOf(east, north) {
  return ((Math.atan2(east, north) * 180) / Math.PI + 360) % 360;
}

/** Return {s, distance_m} of the place of a track that is nearest to x, y on the map. */
export function nearest(track, x, y) {
  let best = { s: 0, distance_m: Infinity };
  for (let i = 0; i + 1 < track.samples; i++) {
    const [dx, dy] = [track.x[i + 1] - track.x[i], track.y[i + 1] - track.y[i]];
    const square = dx * dx + dy * dy || 1;
    const part = clamp(((x - track.x[i]) * dx + (y - track.y[i]) * dy) / square, 0, 1);
    const distance_m = Math.hypot(x - track.x[i] - part * dx, y - track.y[i] - part * dy);
    if (distance_m < best.distance_m) {
      best = { s: track.s[i] + part * (track.s[i + 1] - track.s[i]), distance_m };
    }
  }
  return best;
}

/** Return whether x, y is within the outline of a zone, by the even-odd rule. */
export function insideZone(zone, x, y) {
  if (zone.circle) return Math.hypot(x - zone.circle.x, y - zone.circle.y) <= zone.circle.radius_m;
  let inside = false;
  for (const ring of zone.rings) {
    for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
      const [[xa, ya], [xb, yb]] = [ring[i], ring[j]];
      if (ya > y !== yb > y && x < ((xb - xa) * (y - ya)) / (yb - ya) + xa) inside = !inside;
    }
  }
  return inside;
}

/** Return the runs [from, to) of true values of a test of the numbers below `count`. */
export function runs(count, test) {
  const found = [];
  let from = -1;
  for (let i = 0; i <= count; i++) {
    const holds = i < count && test(i);
    if (holds && from < 0) from = i;
    if (!holds && from >= 0) {
      found.push([from, i]);
      from = -1;
    }
  }
  return found;
}

export function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}

/** Return metres as a text: "36.39 km", "742 m", "30.2 m". */
export function metres(value, kilometresFrom = 2000) {
  if (!Number.isFinite(value)) return "–";
  if (Math.abs(value) >= kilometresFrom) return `${number(value / 1000, 2)} km`;
  return `${number(value, Math.abs(value) < 100 ? 1 : 0)} m`;
}

/** Return a number with `digits` decimals and commas between thousands. */
export function number(value, digits) {
  // Plus 0, as -0 has a sign.
  const rounded = Math.round(value * 10 ** digits) / 10 ** digits + 0;
  return rounded.toLocaleString("en", { minimumFractionDigits: digits, maximumFractionDigits: digits });
}

/** Return a step of 1, 2 or 5 times a power of ten that divides `span` into about `parts`. */
export function niceStep(span, parts) {
  const power = 10 ** Math.floor(Math.log10(span / parts));
  return power * [1, 2, 5, 10].find((factor) => factor * power * parts >= span * 0.999);
}

const DEFAULTS = {
  path: "#0a4f8f",
  line: "#0a4f8f",
  start: "#009e73",
  goal: "#f0b400",
  back: "#ffffff",
  nofly: "#a3246b",
  trouble: "#df1f1a",
  band: "#f0b400",
  earth: "#c7b697",
  edge: "#5b4a38",
  text: "#22272b",
  muted: "#5d666d",
  grid: "#dfe3e6",
  paper: "#ffffff",
};

/** Return the colours of an element: its CSS variables by these names, or the defaults. */
export function coloursOf(element) {
  const style = getComputedStyle(element);
  const entries = Object.entries(DEFAULTS);
  return Object.fromEntries(
    entries.map(([name, colour]) => [name, style.getPropertyValue(`--${name}`).trim() || colour]),
  );
}

/** Return a colour by its name in coloursOf, or the colour itself; the path's by default. */
export function colourOf(colours, colour) {
  return colours[colour ?? "path"] ?? colour;
}

/** Return a colour #rrggbb with an opacity, as CSS has it. */
export function faded(colour, opacity) {
  const value = parseInt(colour.slice(1), 16);
  return `rgba(${value >> 16}, ${(value >> 8) & 255}, ${value & 255}, ${opacity})`;
}

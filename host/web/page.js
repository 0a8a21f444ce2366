// The page of a plan: 3-D view, map and profile of the scene in this file, linked with each other.

import { TerrainMap } from "./map.js";
import { Profile } from "./profile.js";
import { at, metres, nearest, number, readScene } from "./scene.js";
import { TerrainView } from "./view.js";

// The pointer marks the track on the map from this distance in pixels.
const NEAR_PIXELS = 30;

const scene = readScene(JSON.parse(document.getElementById("scene").textContent));
const [{ track, mission }] = scene.paths;
const view = viewIn(document.querySelector("#relief .view"));
const map = new TerrainMap(document.querySelector("#plan .view"), scene);
const profile = new Profile(document.querySelector("#altitude .view"), scene);

profile.onMark = mark;
map.onPoint = (place) => {
  if (!place) return;
  const { s, distance_m } = nearest(track, place.x, place.y);
  if (distance_m * map.scale() < NEAR_PIXELS) mark(at(track, s));
};
for (const part of [map, profile]) part.canvas.node.title = "";

sayVerdict();
listFigures();
listFaults();
explain();
mark(at(track, lowest()));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => view?.redraw());
// For scripts and for tests.
document.documentElement.dataset.ready = "true";
globalThis.pathgene = { scene, view, map, profile, mark };

/** Return the 3-D view, or null where the browser has no WebGL: the page then says so. */
function viewIn(element) {
  try {
    return new TerrainView(element, scene);
  } catch (error) {
    const said = document.createElement("p");
    said.className = "failure";
    said.textContent = `This browser draws nothing in 3-D (${error.message}); map and profile show the same plan.`;
    element.replaceChildren(said);
    return null;
  }
}

/** Mark a row of the track in all views, with its figures; null marks nothing. */
function mark(row) {
  for (const part of [view, map]) part?.mark(row);
  profile.mark(row ? row.s : null);
  const figures = row
    ? {
        distance: metres(row.s),
        altitude: metres(row.z, Infinity),
        height: metres(row.z - row.ground, Infinity),
        clearance: metres(row.clearance, Infinity),
      }
    : {};
  for (const cell of document.querySelectorAll("#place dd")) {
    cell.textContent = figures[cell.dataset.figure] ?? "–";
  }
}

/** Return the metres flown to the least clearance. */
function lowest() {
  let best = 0;
  track.clearance.forEach((value, i) => {
    if (value < track.clearance[best] || Number.isNaN(track.clearance[best])) best = i;
  });
  return track.s[best];
}

function sayVerdict() {
  const { feasible, sentence } = scene.verdict;
  const verdict = document.getElementById("verdict");
  verdict.textContent = { true: "✓ Feasible", false: "✗ Not feasible" }[feasible] ?? "No verdict";
  verdict.classList.toggle("feasible", feasible === true);
  verdict.classList.toggle("infeasible", feasible === false);
  const line = document.getElementById("sentence");
  line.textContent = sentence;
  line.hidden = !sentence;
}

function listFigures() {
  const rows = scene.figures.map(({ key, label, text }) => {
    const [row, name, value] = ["div", "dt", "dd"].map((tag) => document.createElement(tag));
    [name.textContent, value.textContent] = [label, text];
    value.dataset.key = key;
    row.append(name, value);
    return row;
  });
  document.querySelector("#figures dl").append(...rows);
}

/** List the faults of a mission; a click on one marks its place. */
function listFaults() {
  const list = document.getElementById("faults");
  const rows = (scene.faults ?? []).map(({ sentence, at_m }) => {
    const [row, button] = ["li", "button"].map((tag) => document.createElement(tag));
    button.textContent = sentence;
    button.disabled = at_m === null;
    button.addEventListener("click", () => mark(at(track, at_m)));
    row.append(button);
    return row;
  });
  list.append(...rows);
  list.hidden = !rows.length;
}

/** Explain the colours, and name the parts that the drawing leaves out. */
function explain() {
  const { terrain } = scene;
  const legend = [
    ["line", scene.faults ? "mission as flown" : "smoothed path"],
    ["earth", "ground"],
    Number.isFinite(track.demanded.find(Number.isFinite)) && ["band", "clearance demanded"],
    scene.zones.length && ["nofly", "no-fly zone"],
    terrain.heights.some(Number.isNaN) && ["void", "void: no data, not to be flown over"],
    track.broken.length && ["trouble", "breaks a limit"],
  ].filter(Boolean);
  const entries = legend.map(([colour, text]) => {
    const entry = document.createElement("li");
    const patch = document.createElement("i");
    patch.style.background = `var(--${colour})`;
    entry.append(patch, text);
    return entry;
  });
  document.getElementById("legend").append(...entries);

  const size = (rows, columns) => `${number(columns, 0)} × ${number(rows, 0)}`;
  const notes = [
    `Altitudes are above the datum of the terrain.`,
    "Clearance is the height over the highest ground within the corridor.",
    terrain.thinned &&
      `The ground is drawn by ${size(terrain.rows, terrain.columns)} of ${size(...terrain.nodes)} nodes, ` +
        "each the highest of those around it; all figures are of the whole terrain.",
    scene.zones_left_out &&
      `The ${number(scene.zones_left_out, 0)} smallest no-fly zones are not drawn.`,
    mission && !scene.faults &&
      "Squares are the items that an autopilot gets, triangles its rally points; thin lines show " +
        "the end of the mission, with its circle and the clear disc around it.",
    "Point at the profile, or press the arrow keys on it, to mark a place in all views.",
  ];
  document.getElementById("notes").textContent = notes.filter(Boolean).join(" ");
  const factor = terrain.vertical;
  document.querySelector("#relief .note").textContent =
    factor === 1 ? "" : `heights × ${number(factor, factor % 1 ? 1 : 0)}`;
}

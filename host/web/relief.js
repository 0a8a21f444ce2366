// The tinted hillshade of a terrain: an image of the map, and the skin of the 3-D view.

// Tints from the lowest to the highest land, which only grow lighter: their order shows in grey too.
const LAND = ["#4f7268", "#7c9479", "#a9ac85", "#ccbd97", "#e3d5bb", "#f7f3ec"].map((tint) =>
  [1, 3, 5].map((place) => parseInt(tint.slice(place, place + 2), 16)),
);
const VOID = [230, 232, 234];
const HATCH = [176, 182, 187];
// The sun is in the north-west, 45 degrees high: unit vector to it, east, north, up.
const SUN = [-0.5, 0.5, Math.SQRT1_2];
// Pixels between the lines that hatch voids.
const HATCH_PIXELS = 6;
// Tints of the land that are told apart.
const TINTS = 1024;

/** Return the tint of a height, [red, green, blue], from 0 to 255; `part` from 0, low, to 1. */
export function tint(part) {
  const place = Math.min(Math.max(part, 0), 1) * (LAND.length - 1);
  const below = Math.min(Math.floor(place), LAND.length - 2);
  return LAND[below].map((value, i) => value + (place - below) * (LAND[below + 1][i] - value));
}

const SHADES = new WeakMap();

/** Return a canvas of a decoded terrain, a pixel a node, north above; drawn once for all views. */
export function reliefOf(terrain) {
  if (!SHADES.has(terrain)) SHADES.set(terrain, drawn(terrain));
  return SHADES.get(terrain);
}

function drawn(terrain) {
  const { rows, columns, heights } = terrain;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [columns, rows];
  const context = canvas.getContext("2d");
  const image = context.createImageData(columns, rows);
  const pixels = image.data;
  const factor = exaggeration(terrain);
  const span = terrain.high_m - terrain.low_m || 1;
  const tints = Array.from({ length: TINTS + 1 }, (_, i) => tint(i / TINTS));
  for (let row = 0, node = 0; row < rows; row++) {
    let pixel = 4 * (rows - 1 - row) * columns;
    for (let column = 0; column < columns; column++, node++, pixel += 4) {
      const height = heights[node];
      let colour = (row + column) % HATCH_PIXELS === 0 ? HATCH : VOID;
      let light = 1;
      if (!Number.isNaN(height)) {
        colour = tints[Math.round(((height - terrain.low_m) / span) * TINTS)];
        const east = factor * slope(terrain, row, column, 0, 1);
        const north = factor * slope(terrain, row, column, 1, 0);
        const facing = (SUN[2] - east * SUN[0] - north * SUN[1]) / Math.sqrt(east ** 2 + north ** 2 + 1);
        light = 0.45 + 0.62 * Math.max(facing, 0);
      }
      for (let i = 0; i < 3; i++) pixels[pixel + i] = colour[i] * light;
      pixels[pixel + 3] = 255;
    }
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

/** Return the slope at a node along columns or rows, metres by metre; 0 towards a void. */
function slope(terrain, row, column, up, right) {
  const { rows, columns, heights, dx_m, dy_m } = terrain;
  const before = Math.max(row - up, 0) * columns + Math.max(column - right, 0);
  const after = Math.min(row + up, rows - 1) * columns + Math.min(column + right, columns - 1);
  return (heights[after] - heights[before]) / (2 * (up ? dy_m : dx_m)) || 0;
}

/** Return the factor on slopes by which the steep tenth of the land shows as 40 degrees. */
function exaggeration(terrain) {
  const steps = [];
  const every = Math.max(1, Math.floor(Math.sqrt((terrain.rows * terrain.columns) / 10000)));
  for (let row = 0; row < terrain.rows; row += every) {
    for (let column = 0; column < terrain.columns; column += every) {
      steps.push(Math.hypot(slope(terrain, row, column, 0, 1), slope(terrain, row, column, 1, 0)));
    }
  }
  steps.sort((a, b) => a - b);
  const steep = steps[Math.floor(0.9 * (steps.length - 1))];
  return Math.min(Math.max(0.85 / Math.max(steep, 1e-3), 0.4), 12);
}

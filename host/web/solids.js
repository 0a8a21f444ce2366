// Solids of the 3-D view: the ground with its sides, zones, and the curtain below a path.

import { THREE } from "nicegui-scene";

// Opacity of the walls of a zone at their foot, and where they fade out without a limit.
const WALL = 0.42;
const SIDES = [0.62, 0.74, 0.86, 0.7];

/**
 * Return the mesh of the ground, fine at first; `userData.draw(fine)` says how it is drawn: with all
 * of its triangles, or with a ninth of them, by every third node.
 *
 * @param {object} terrain Decoded terrain of a scene.
 * @param {function(number, number, number): number[]} place Scene's units of metres x, y, z.
 * @param {THREE.Texture} skin Image of the map.
 */
export function ground(terrain, place, skin) {
  const { rows, columns, heights, dx_m, dy_m } = terrain;
  const positions = new Float32Array(3 * rows * columns);
  const uv = new Float32Array(2 * rows * columns);
  for (let row = 0, i = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++, i++) {
      const height = Number.isNaN(heights[i]) ? terrain.low_m : heights[i];
      positions.set(place(column * dx_m, row * dy_m, height), 3 * i);
      uv[2 * i] = (column + 0.5) / columns;
      uv[2 * i + 1] = (row + 0.5) / rows;
    }
  }
  const triangles = new Uint32Array(12 * rows * columns);
  let filled = 0;
  const add = (a, b, c) => {
    // The sum is NaN next to a void.
    if (Number.isNaN(heights[a] + heights[b] + heights[c])) return;
    triangles[filled++] = a;
    triangles[filled++] = b;
    triangles[filled++] = c;
  };
  const cover = (step) => {
    for (let row = 0; row + 1 < rows; row += step) {
      const up = Math.min(step, rows - 1 - row) * columns;
      for (let column = 0; column + 1 < columns; column += step) {
        const i = row * columns + column;
        const right = Math.min(step, columns - 1 - column);
        add(i, i + right, i + up);
        add(i + right, i + right + up, i + up);
      }
    }
    return filled;
  };
  const fine = cover(1);
  const all = cover(3);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute("uv", new THREE.BufferAttribute(uv, 2));
  geometry.setIndex(new THREE.BufferAttribute(triangles.subarray(0, filled), 1));
  // The eye is always above the land.
  const mesh = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ map: skin }));
  mesh.userData.draw = (isFine) => geometry.setDrawRange(isFine ? 0 : fine, isFine ? fine : all - fine);
  mesh.userData.draw(true);
  return mesh;
}

/** Return the mesh of the four sides of the ground, down to `foot` in the scene's units. */
export function sides(terrain, place, foot, colour) {
  const { rows, columns, heights, dx_m, dy_m } = terrain;
  const line = (count, node) => Array.from({ length: count }, (_, i) => node(i));
  const borders = [
    line(columns, (i) => [0, i]),
    line(rows, (i) => [i, columns - 1]),
    line(columns, (i) => [rows - 1, i]),
    line(rows, (i) => [i, 0]),
  ];
  const solid = new Solid();
  borders.forEach((nodes, side) => {
    const tint = new THREE.Color(colour).multiplyScalar(SIDES[side]);
    for (let i = 0; i + 1 < nodes.length; i++) {
      const tops = [nodes[i], nodes[i + 1]].map(([row, column]) =>
        place(column * dx_m, row * dy_m, heights[row * columns + column]),
      );
      if (tops.every(([, , z]) => Number.isFinite(z))) {
        const feet = tops.map(([x, y]) => [x, y, foot]);
        solid.wall(feet, tops, tint, 1, 1);
      }
    }
  });
  return solid.mesh(false);
}

/**
 * Return the mesh of all zones: walls from the lower limit to the upper, and lids.
 *
 * A zone without a lower limit begins below the ground; the walls of one without an upper limit
 * fade out above all else.
 */
export function zonesOf(zones, place, { bottom_m, top_m }, colour) {
  const solid = new Solid();
  const tint = new THREE.Color(colour);
  for (const zone of zones) {
    const [low, high] = [zone.lower_m ?? bottom_m, zone.upper_m ?? top_m];
    const fade = zone.upper_m === null ? 0.05 : WALL;
    for (const ring of zone.rings) {
      ring.forEach(([x, y], i) => {
        const [u, v] = ring[(i + 1) % ring.length];
        const feet = [place(x, y, low), place(u, v, low)];
        const tops = [place(x, y, high), place(u, v, high)];
        solid.wall(feet, tops, tint, WALL, fade);
      });
    }
    for (const limit of [zone.lower_m, zone.upper_m]) {
      if (limit !== null) solid.lid(zone.rings, (x, y) => place(x, y, limit), tint, WALL);
    }
  }
  return solid.mesh(true);
}

/** Return the outlines of zones at their limits, as line segments. */
export function outlinesOf(zones, place, { bottom_m, top_m }, colour) {
  const points = [];
  for (const zone of zones) {
    for (const height of [zone.lower_m ?? bottom_m, zone.upper_m ?? top_m]) {
      for (const ring of zone.rings) {
        ring.forEach(([x, y], i) => {
          const [u, v] = ring[(i + 1) % ring.length];
          points.push(...place(x, y, height), ...place(u, v, height));
        });
      }
    }
  }
  return segments(points, colour, 0.8);
}

/** Return the curtain from a path down to the ground. */
export function curtain(points, ground_m, place, colour) {
  const solid = new Solid();
  const tint = new THREE.Color(colour);
  for (let i = 0; i + 1 < points.length; i++) {
    const pair = [points[i], points[i + 1]];
    const heights = pair.map(([x, y]) => ground_m(x, y));
    if (!heights.every(Number.isFinite)) continue;
    const feet = pair.map(([x, y], j) => place(x, y, heights[j]));
    solid.wall(feet, pair.map((point) => place(...point)), tint, 0.14, 0.3);
  }
  return solid.mesh(true);
}

/** Return line segments, a pixel wide. */
export function segments(points, colour, opacity = 1) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  const material = new THREE.LineBasicMaterial({ color: colour, opacity, transparent: true });
  return new THREE.LineSegments(geometry, material);
}

/** Triangles of one colour each, with an opacity at each corner. */
class Solid {
  positions = [];
  colours = [];

  wall([a, b], [c, d], tint, low, high) {
    this.positions.push(...a, ...b, ...c, ...b, ...d, ...c);
    for (const opacity of [low, low, high, low, high, high]) {
      this.colours.push(tint.r, tint.g, tint.b, opacity);
    }
  }

  lid([outline, ...holes], place, tint, opacity) {
    const flat = (ring) => ring.map(([x, y]) => new THREE.Vector2(x, y));
    const [contour, inner] = [flat(outline), holes.map(flat)];
    const corners = [outline, ...holes].flat();
    for (const triangle of THREE.ShapeUtils.triangulateShape(contour, inner)) {
      for (const i of triangle) {
        this.positions.push(...place(...corners[i]));
        this.colours.push(tint.r, tint.g, tint.b, opacity);
      }
    }
  }

  mesh(transparent) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(this.positions, 3));
    geometry.setAttribute("color", new THREE.Float32BufferAttribute(this.colours, 4));
    const material = new THREE.MeshBasicMaterial({
      vertexColors: true,
      transparent,
      depthWrite: !transparent,
      side: THREE.DoubleSide,
    });
    return new THREE.Mesh(geometry, material);
  }
}

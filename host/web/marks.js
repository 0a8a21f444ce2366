// Marks and texts that map, profile and 3-D view draw alike.

const COLOURS = { start: "start", via: "start", goal: "goal", return: "back" };
const RIM = "#22272b";

/** Draw start (disc), via point (diamond), goal (star) or return (white disc) of a size in pixels. */
export function drawPoint(context, kind, x, y, size, colours) {
  context.save();
  context.translate(x, y);
  context.beginPath();
  if (kind === "via") corners(context, 4, size, size);
  else if (kind === "goal") corners(context, 10, 1.35 * size, 0.58 * size);
  else context.arc(0, 0, 0.8 * size, 0, 2 * Math.PI);
  Object.assign(context, { lineWidth: 1.5, strokeStyle: RIM, lineJoin: "round" });
  context.fillStyle = colours[COLOURS[kind]];
  context.fill();
  context.stroke();
  context.restore();
}

/** Draw an aircraft seen from above, its nose `heading_deg` clockwise from the top. */
export function drawAircraft(context, x, y, heading_deg, size) {
  context.save();
  context.translate(x, y);
  context.rotate((heading_deg * Math.PI) / 180);
  context.beginPath();
  for (const [east, north] of [[0, 1], [0.7, -0.8], [0, -0.4], [-0.7, -0.8]]) {
    context.lineTo(east * size, -north * size);
  }
  context.closePath();
  Object.assign(context, { lineWidth: 3, strokeStyle: "#ffffff", fillStyle: "#d55e00" });
  context.lineJoin = "round";
  context.stroke();
  context.fill();
  context.restore();
}

/** Draw the triangle of a rally point. */
export function drawRally(context, x, y) {
  context.beginPath();
  for (const [east, north] of [[0, 6], [5.2, -3], [-5.2, -3]]) context.lineTo(x + east, y - north);
  context.closePath();
  Object.assign(context, { lineWidth: 1.3, strokeStyle: RIM, fillStyle: "#ffffff" });
  context.fill();
  context.stroke();
}

/** Draw the ring of the marked place. */
export function drawMark(context, x, y, colours) {
  context.beginPath();
  context.arc(x, y, 6, 0, 2 * Math.PI);
  Object.assign(context, { lineWidth: 6.5, strokeStyle: "#ffffff", fillStyle: "#ffffff" });
  context.stroke();
  context.fill();
  Object.assign(context, { lineWidth: 3, strokeStyle: RIM });
  context.stroke();
  context.beginPath();
  context.arc(x, y, 2.2, 0, 2 * Math.PI);
  context.fillStyle = colours.trouble;
  context.fill();
}

/** Draw the marks of faults at places [left, top] or null, each with its number in the list. */
export function drawFaults(context, places, colours) {
  context.save();
  const shown = places.map((place, i) => ({ place, number: i + 1 })).filter(({ place }) => place);
  for (const { place } of shown) {
    context.beginPath();
    context.arc(...place, 4.5, 0, 2 * Math.PI);
    Object.assign(context, { lineWidth: 1.5, strokeStyle: "#ffffff", fillStyle: colours.trouble });
    context.fill();
    context.stroke();
  }
  // Numbers of neighbours share a text.
  const groups = [];
  for (const { place, number } of shown) {
    const near = groups.find(({ at: [left, top] }) => Math.hypot(place[0] - left, place[1] - top) < 16);
    if (near) near.numbers.push(number);
    else groups.push({ at: place, numbers: [number] });
  }
  for (const { at: [left, top], numbers } of groups) {
    const style = { colour: colours.trouble, rim: colours.paper, bold: true };
    drawText(context, numbers.join(", "), left, top - 14, style);
  }
  context.restore();
}

/** Draw lines of text around a place, with a rim that separates them from the background. */
export function drawText(context, text, x, y, { colour, rim, align = "center", bold = false }) {
  context.font = `${bold ? "600 " : ""}12px system-ui, sans-serif`;
  Object.assign(context, { textAlign: align, textBaseline: "middle", lineJoin: "round" });
  Object.assign(context, { lineWidth: 3.5, strokeStyle: rim, fillStyle: colour });
  const lines = text.split("\n");
  lines.forEach((line, i) => {
    const height = y + 15 * (i - (lines.length - 1) / 2);
    context.strokeText(line, x, height);
    context.fillText(line, x, height);
  });
}

function corners(context, count, outer, inner) {
  for (let i = 0; i < count; i++) {
    const angle = (2 * Math.PI * i) / count;
    const radius = i % 2 ? inner : outer;
    context.lineTo(radius * Math.sin(angle), -radius * Math.cos(angle));
  }
  context.closePath();
}

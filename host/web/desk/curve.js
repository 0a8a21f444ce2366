// The fitness of each generation: the best found and the mean, and the best of a kept plan.

import { Canvas } from "pathgene-views/canvas.js";
import { drawText } from "pathgene-views/marks.js";
import { coloursOf, faded, niceStep, number } from "pathgene-views/scene.js";

/** Colour of a kept plan. */
export const KEPT = "#d55e00";

const [LEFT, RIGHT, TOP, BOTTOM] = [44, 14, 12, 34];
// Few generations, as of the planner core, are drawn as points as well.
const FEW = 40;

/** A curve in an element that has a size of its own. */
export class Curve {
  /** @param {HTMLElement} element Filled by the curve. */
  constructor(element) {
    this.element = element;
    this.rows = [];
    this.kept = null;
    this.canvas = new Canvas(element, "Fitness by generation", (...box) => this.draw(...box));
    this.canvas.node.setAttribute("role", "img");
    this.canvas.node.tabIndex = -1;
  }

  /** Show other rows [generation, best, mean]; `kept` holds the rows of a kept plan, or null. */
  show(rows, kept = this.kept) {
    this.rows = rows;
    this.kept = kept;
    this.redraw();
  }

  redraw() {
    const last = this.rows.at(-1);
    this.canvas.node.setAttribute(
      "aria-label",
      last
        ? `Fitness by generation: after ${last[0]} generations the best is ${number(last[1], 4)}, the mean ${number(last[2], 4)}.`
        : "Fitness by generation: nothing is planned yet.",
    );
    this.canvas.redraw();
  }

  dispose() {
    this.canvas.dispose();
  }

  draw(context, width, height) {
    const colours = coloursOf(this.element);
    const all = [...this.rows, ...(this.kept ?? [])];
    if (!all.length) {
      const style = { colour: colours.muted, rim: colours.paper };
      drawText(context, "Fitness appears here\nas a plan is made", width / 2, height / 2, style);
      return;
    }
    const least = Math.min(0, ...this.rows.map(([, best]) => best).filter(Number.isFinite));
    const box = {
      last: Math.max(1, ...all.map(([generation]) => generation)),
      low: least,
      high: 1.06 * Math.max(1, ...all.map(([, best]) => best)),
    };
    const left = (generation) => LEFT + (generation / box.last) * (width - LEFT - RIGHT);
    const top = (value) =>
      height - BOTTOM - ((value - box.low) / (box.high - box.low)) * (height - TOP - BOTTOM);
    this.axes(context, box, left, top, width, height, colours);
    if (this.kept) this.line(context, this.kept, 1, left, top, KEPT, 1.5);
    this.line(context, this.rows, 2, left, top, colours.muted, 1.5);
    this.line(context, this.rows, 1, left, top, colours.line, 2.5);
    this.key(context, width, height, colours);
  }

  axes(context, { last, low, high }, left, top, width, height, colours) {
    const plain = { colour: colours.muted, rim: colours.paper };
    const step = niceStep(high - low, Math.max(2, (height - TOP - BOTTOM) / 36));
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      Object.assign(context, { strokeStyle: colours.grid, lineWidth: 1 });
      this.rule(context, LEFT, top(value), width - RIGHT, top(value));
      drawText(context, number(value, step < 1 ? 1 : 0), LEFT - 8, top(value), { ...plain, align: "right" });
    }
    const wide = niceStep(last, Math.max(2, (width - LEFT - RIGHT) / 70));
    for (let value = 0; value <= last; value += Math.max(1, wide)) {
      const text = value >= 10000 ? `${value / 1000}k` : number(value, 0);
      drawText(context, text, left(value), height - BOTTOM + 11, plain);
    }
    // Above 1 a path is flyable.
    context.lineWidth = 1;
    context.strokeStyle = faded(colours.muted, 0.6);
    this.rule(context, LEFT, top(1), width - RIGHT, top(1));
  }

  rule(context, fromLeft, fromTop, toLeft, toTop) {
    context.beginPath();
    context.moveTo(fromLeft, Math.round(fromTop) + 0.5);
    context.lineTo(toLeft, Math.round(toTop) + 0.5);
    context.stroke();
  }

  line(context, rows, column, left, top, colour, lineWidth) {
    Object.assign(context, { strokeStyle: colour, fillStyle: colour, lineWidth, lineJoin: "round" });
    context.beginPath();
    // A few thousand generations on some hundred pixels.
    const every = Math.max(1, Math.floor(rows.length / 2000));
    rows.forEach((row, i) => {
      // The next leg of a mission has a fitness of its own.
      const begins = i > 0 && row[1] < rows[i - 1][1];
      if (begins) context.moveTo(left(row[0]), top(row[column]));
      else if (i % every === 0 || i === rows.length - 1) {
        context.lineTo(left(row[0]), top(row[column]));
      }
    });
    context.stroke();
    if (rows.length > FEW) return;
    for (const row of rows) {
      context.beginPath();
      context.arc(left(row[0]), top(row[column]), lineWidth + 0.5, 0, 2 * Math.PI);
      context.fill();
    }
  }

  key(context, width, height, colours) {
    const entries = [["best", colours.line], ["mean", colours.muted]];
    if (this.kept) entries.push(["kept plan", KEPT]);
    let at = LEFT;
    for (const [text, colour] of entries) {
      Object.assign(context, { fillStyle: colour });
      context.fillRect(at, height - 12, 12, 3);
      drawText(context, text, at + 17, height - 10, { colour: colours.muted, rim: colours.paper, align: "left" });
      at += 30 + context.measureText(text).width;
    }
  }
}

// A canvas that fills its element, sharp on any screen, and draws when there is something new.

/** Canvas with a 2-D context whose unit is a pixel of CSS. */
export class Canvas {
  /**
   * @param {HTMLElement} element Filled by the canvas; it has a size of its own.
   * @param {string} label Name for assistive technology.
   * @param {function(CanvasRenderingContext2D, number, number): void} draw Draws all, in a box of
   *     width and height.
   */
  constructor(element, label, draw) {
    this.node = document.createElement("canvas");
    this.node.tabIndex = 0;
    this.node.setAttribute("aria-label", label);
    Object.assign(this.node.style, { display: "block", position: "absolute", inset: 0 });
    if (getComputedStyle(element).position === "static") element.style.position = "relative";
    element.append(this.node);
    this.element = element;
    this.draw = draw;
    this.frame = 0;
    this.context = this.node.getContext("2d");
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(element);
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.redraw = this.redraw.bind(this);
    this.dark.addEventListener("change", this.redraw);
    this.measure();
  }

  measure() {
    [this.width, this.height] = [this.element.clientWidth, this.element.clientHeight];
    const scale = devicePixelRatio || 1;
    this.node.width = Math.max(1, Math.round(this.width * scale));
    this.node.height = Math.max(1, Math.round(this.height * scale));
    Object.assign(this.node.style, { width: `${this.width}px`, height: `${this.height}px` });
  }

  /** Take a new size; the observer calls it for the first time after the owner is whole. */
  resize() {
    this.measure();
    // A canvas is blank after its size has changed: draw before the browser shows it.
    this.paint();
  }

  /** Draw with the next frame. */
  redraw() {
    this.frame ||= requestAnimationFrame(() => this.paint());
  }

  paint() {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    if (!this.width || !this.height) return;
    const scale = this.node.width / this.width;
    this.context.setTransform(scale, 0, 0, scale, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    this.draw(this.context, this.width, this.height);
  }

  /** Return the place of a pointer's event, pixels of CSS from the upper left. */
  place(event) {
    const box = this.node.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  dispose() {
    cancelAnimationFrame(this.frame);
    this.observer.disconnect();
    this.dark.removeEventListener("change", this.redraw);
    this.node.remove();
  }
}

"use strict";
// A chart of curves over any quantity, as SVG: sharp on paper and in files. Curves may turn back, as force over
// displacement does. Drag selects a range of the lower axis, a double click shows all, a click selects a time.

const CHART_HEIGHT = 340;
const CHART_MARGIN = { left: 78, right: 16, top: 14, bottom: 46 };
const SVG = "http://www.w3.org/2000/svg";
/** Shortest drag that is not a click [pixels]. */
const DRAG = 5;

/** An element of SVG with attributes and text. */
function drawn(name, attributes = {}, text) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  return element;
}

/** Round numbers within a range, about `count` of them. */
function ticksOf([low, high], count) {
  const step = roundUp((high - low) / count);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

/** The range of values in all arrays, with a margin where it is a single value. */
function rangeOf(arrays) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of arrays) {
    for (const value of values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low <= high)) return [0, 1];
  return low < high ? [low, high] : [low - (Math.abs(low) || 1), high + (Math.abs(high) || 1)];
}

/** A unit in brackets after a name, if there is one. */
function withUnit(name, unit) {
  return unit ? `${name} [${unit}]` : name;
}

class Chart {
  /** `go` is called with the time of the point that is clicked. */
  constructor(place, go) {
    this.place = place;
    this.go = go;
    this.curves = [];
    this.time = null;
    this.window = null;
    this.readout = document.createElement("output");
    this.readout.className = "readout";
    resized(place, () => this.place.clientWidth !== this.width && this.draw());
  }

  /**
   * Shows curves: `label`, `colour` (a CSS variable), arrays `x`, `y` and `time`, `dash`, and with `marks` the index
   * of the peak and the mean. `titles` are those of the axes.
   */
  show(curves, titles) {
    [this.curves, this.titles, this.window] = [curves, titles, null];
    this.draw();
  }

  /** Marks the time of the picture on each curve. */
  mark(time) {
    this.time = time;
    if (!this.dots) return;
    this.curves.forEach((curve, i) => {
      const at = curve.time.length > 1 && time >= curve.time[0] && time <= curve.time[curve.time.length - 1];
      this.dots[i].style.display = at ? "" : "none";
      if (!at) return;
      this.dots[i].setAttribute("cx", this.across(valueAt(curve.time, curve.x, time)));
      this.dots[i].setAttribute("cy", this.up(valueAt(curve.time, curve.y, time)));
    });
  }

  across(x) {
    return CHART_MARGIN.left + ((x - this.x[0]) / (this.x[1] - this.x[0])) * this.inner[0];
  }

  up(y) {
    return CHART_MARGIN.top + (1 - (y - this.y[0]) / (this.y[1] - this.y[0])) * this.inner[1];
  }

  draw() {
    this.width = this.place.clientWidth;
    const width = Math.max(this.width, 320);
    this.inner = [width - CHART_MARGIN.left - CHART_MARGIN.right, CHART_HEIGHT - CHART_MARGIN.top - CHART_MARGIN.bottom];
    this.x = this.window || rangeOf(this.curves.map((curve) => curve.x));
    const inside = ({ x, y }) => (this.window ? y.filter((_, i) => x[i] >= this.x[0] && x[i] <= this.x[1]) : y);
    const [low, high] = rangeOf(this.curves.map(inside));
    const room = 0.06 * (high - low);
    this.y = [low === 0 ? 0 : low - room, high === 0 ? 0 : high + room];
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const svg = drawn("svg", { width, height: CHART_HEIGHT, viewBox: `0 0 ${width} ${CHART_HEIGHT}`, role: "img", "aria-label": "Chart", xmlns: SVG });
    svg.style.font = "12px system-ui, 'DejaVu Sans', sans-serif";
    svg.append(drawn("rect", { width, height: CHART_HEIGHT, fill: colour("--panel") }));
    this.axes(svg, colour);
    const clip = drawn("clipPath", { id: "chart-inside" });
    clip.append(drawn("rect", { x: CHART_MARGIN.left, y: CHART_MARGIN.top, width: this.inner[0], height: this.inner[1] }));
    const lines = drawn("g", { "clip-path": "url(#chart-inside)" });
    svg.append(clip, lines);
    this.curves.forEach((curve) => lines.append(this.line(curve, colour)));
    this.curves.filter((curve) => curve.marks).forEach((curve) => lines.append(...this.marks(curve, colour)));
    this.dots = this.curves.map((curve) => drawn("circle", { r: 4, fill: "none", "stroke-width": 2, stroke: colour(curve.colour) }));
    lines.append(...this.dots);
    this.take(svg, colour);
    this.svg = svg;
    this.place.replaceChildren(svg, this.readout);
    this.readout.textContent = "";
    this.mark(this.time);
  }

  axes(svg, colour) {
    const { left, top } = CHART_MARGIN;
    const bottom = top + this.inner[1];
    const text = (attributes, words) => svg.append(drawn("text", { fill: colour("--quiet"), ...attributes }, words));
    const across = ticksOf(this.x, Math.max(2, Math.floor(this.inner[0] / 110)));
    const up = ticksOf(this.y, 5);
    const line = (x1, y1, x2, y2) => svg.append(drawn("line", { x1, y1, x2, y2, stroke: colour("--line") }));
    across.forEach((x) => line(this.across(x), top, this.across(x), bottom));
    up.forEach((y) => line(left, this.up(y), left + this.inner[0], this.up(y)));
    const words = (ticks) => (ticks.length > 1 ? labels(ticks) : ticks.map((tick) => digits(tick)));
    words(across).forEach((label, i) => text({ x: this.across(across[i]), y: bottom + 16, "text-anchor": "middle" }, label));
    words(up).forEach((label, i) => text({ x: left - 6, y: this.up(up[i]) + 4, "text-anchor": "end" }, label));
    text({ x: left + this.inner[0] / 2, y: bottom + 36, "text-anchor": "middle" }, this.titles.x);
    const middle = top + this.inner[1] / 2;
    text({ x: 13, y: middle, "text-anchor": "middle", transform: `rotate(-90 13 ${middle})` }, this.titles.y);
  }

  line({ x, y, colour: name, dash }, colour) {
    let path = "";
    for (let i = 0; i < x.length; i++) path += `${i ? "L" : "M"}${this.across(x[i]).toFixed(1)} ${this.up(y[i]).toFixed(1)}`;
    return drawn("path", { d: path, fill: "none", stroke: colour(name), "stroke-width": 1.5, "stroke-linejoin": "round", ...(dash ? { "stroke-dasharray": "7 4" } : {}) });
  }

  /** The peak as a dot, the mean as a dotted line. */
  marks({ x, y, colour: name, marks }, colour) {
    const [at, height] = [this.across(x[marks.peak]), this.up(y[marks.peak])];
    const right = at > CHART_MARGIN.left + 0.8 * this.inner[0];
    const mean = this.up(marks.mean);
    const of = { fill: colour(name) };
    return [
      drawn("circle", { cx: at, cy: height, r: 3.5, ...of, class: "peak" }),
      drawn("text", { x: at + (right ? -7 : 7), y: height + 4, "text-anchor": right ? "end" : "start", ...of }, digits(y[marks.peak], 5)),
      drawn("line", { x1: CHART_MARGIN.left, x2: CHART_MARGIN.left + this.inner[0], y1: mean, y2: mean, stroke: colour(name), "stroke-dasharray": "2 3", class: "mean" }),
      drawn("text", { x: CHART_MARGIN.left + this.inner[0] - 4, y: mean - 4, "text-anchor": "end", ...of }, `mean ${digits(marks.mean, 4)}`),
    ];
  }

  /** The curve and its point next to a place on the chart. */
  nearest(left, top) {
    let best = null;
    this.curves.forEach((curve) => {
      for (let i = 0; i < curve.x.length; i++) {
        const far = Math.hypot(this.across(curve.x[i]) - left, this.up(curve.y[i]) - top);
        if (!best || far < best.far) best = { far, curve, i };
      }
    });
    return best;
  }

  /** Reads points under the pointer, and takes drags and clicks. */
  take(svg, colour) {
    const { left, top } = CHART_MARGIN;
    const ring = drawn("circle", { r: 3, fill: "none", stroke: colour("--ink"), visibility: "hidden" });
    const band = drawn("rect", { y: top, height: this.inner[1], fill: colour("--accent"), opacity: 0.15, visibility: "hidden" });
    svg.append(band, ring);
    const at = (event) => {
      const box = svg.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    let from = null;
    svg.addEventListener("pointermove", (event) => {
      const [x, y] = at(event);
      const found = this.nearest(x, y);
      if (!found) return;
      const { curve, i } = found;
      ring.setAttribute("cx", this.across(curve.x[i]));
      ring.setAttribute("cy", this.up(curve.y[i]));
      ring.setAttribute("visibility", "visible");
      this.readout.textContent = `${curve.label}: ${digits(curve.y[i], 6)} at ${digits(curve.x[i], 6)}, time ${digits(curve.time[i], 6)}`;
      if (from === null) return;
      band.setAttribute("visibility", "visible");
      band.setAttribute("x", Math.min(from, x));
      band.setAttribute("width", Math.abs(x - from));
    });
    svg.addEventListener("pointerdown", (event) => (from = at(event)[0]));
    svg.addEventListener("pointerup", (event) => {
      const [x, y] = at(event);
      const ends = [from, x].map((place) => this.x[0] + ((place - left) / this.inner[0]) * (this.x[1] - this.x[0]));
      const isDrag = from !== null && Math.abs(x - from) > DRAG;
      from = null;
      if (isDrag) {
        this.window = [Math.min(...ends), Math.max(...ends)];
        return this.draw();
      }
      const found = this.nearest(x, y);
      if (found) this.go(found.curve.time[found.i]);
    });
    svg.addEventListener("dblclick", () => {
      this.window = null;
      this.draw();
    });
  }
}

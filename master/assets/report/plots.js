"use strict";
// Plots over time, with one cursor for all of them and a line at the time of the picture.

const PLOT_HEIGHT = 190;

/** Labels with as many digits as needed to distinguish the ticks. */
function labels(ticks) {
  const largest = Math.max(...ticks.map((tick) => Math.abs(tick)));
  const step = Math.abs(ticks[1] - ticks[0]);
  const count = step > 0 ? 3 + Math.max(0, Math.floor(Math.log10(largest / step))) : 4;
  return ticks.map((tick) => digits(tick, Math.min(count, 12)));
}

/** Room for the longest label, with letters 7 pixels wide; the same for all plots where that is enough. */
function besideTicks(_, labels) {
  return Math.max(62, ...(labels || []).map((label) => 16 + 7 * label.length));
}

/** Draws a vertical line at the time of each mark, dotted unless it is `solid`. */
function drawMarks(chart, marks, colour) {
  const { ctx, bbox } = chart;
  const { min, max } = chart.scales.x;
  ctx.save();
  ctx.lineWidth = 1;
  ctx.globalAlpha = 0.6;
  for (const { time, solid } of marks) {
    if (!(time >= min && time <= max)) continue;
    const at = Math.round(chart.valToPos(time, "x", true)) + 0.5;
    ctx.strokeStyle = colour(solid ? "--accent" : "--quiet");
    ctx.setLineDash(solid ? [] : [2, 3]);
    ctx.beginPath();
    ctx.moveTo(at, bbox.top);
    ctx.lineTo(at, bbox.top + bbox.height);
    ctx.stroke();
  }
  ctx.restore();
}

class Plots {
  /** `go` is called with the time at which a plot is clicked. */
  constructor(place, data, go) {
    this.place = place;
    this.data = data;
    this.go = go;
    this.charts = [];
    this.time = null;
  }

  /** Draws all plots in the present colours of the page. */
  draw(style) {
    this.charts.forEach((chart) => chart.plot.destroy());
    this.place.textContent = "";
    this.charts = this.data.plots.map((plot) => this.chart(plot, style));
    this.mark(this.time);
  }

  chart(plot, style) {
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    caption.textContent = plot.unit ? `${plot.title} [${plot.unit}]` : plot.title;
    figure.append(caption);
    this.place.append(figure);
    const colour = (name) => style.getPropertyValue(name).trim();
    const axis = { stroke: colour("--quiet"), grid: { stroke: colour("--line"), width: 1 }, ticks: { show: false } };
    const unit = this.data.unit ? ` [${this.data.unit}]` : "";
    const number = (_, value) => (value === null || value === undefined ? "–" : digits(value, 6));
    const lines = plot.lines.map((line, i) => ({
      label: line.label,
      stroke: colour(`--c${(plot.lines.length > 1 ? i : 1) % 8}`),
      width: i === 0 && plot.lines.length > 1 ? 2 : 1.4,
      dash: i >= 8 ? [6, 3] : undefined,
      paths: line.steps ? uPlot.paths.stepped({ align: -1 }) : undefined,
      spanGaps: line.spans,
      points: { show: this.data.time.length < 3 },
      value: number,
    }));
    const now = document.createElement("div");
    now.className = "now";
    const made = { now, data: plot };
    const options = {
      width: this.width(),
      height: PLOT_HEIGHT,
      series: [{ label: `time${unit}`, value: number }, ...lines],
      scales: { x: { time: false } },
      axes: [
        { ...axis, size: 34, space: 70, values: (_, ticks) => labels(ticks) },
        { ...axis, size: besideTicks, values: (_, ticks) => labels(ticks) },
      ],
      legend: { live: true },
      cursor: { sync: { key: "time", setSeries: false }, drag: { x: true, y: false } },
      hooks: {
        ready: [(u) => u.over.append(now)],
        draw: [(u) => drawMarks(u, plot.marks || [], colour), () => this.put(made)],
      },
    };
    const chart = new uPlot(options, [this.data.time, ...plot.lines.map((line) => line.values)], figure);
    made.plot = chart;
    chart.over.addEventListener("click", () => {
      if (chart.cursor.left >= 0) this.go(chart.posToVal(chart.cursor.left, "x"));
    });
    if (plot.note) {
      const note = document.createElement("p");
      note.className = "note";
      note.textContent = plot.note;
      figure.append(note);
    }
    return made;
  }

  width() {
    return Math.max(this.place.clientWidth - 20, 200);
  }

  fit() {
    const width = this.width();
    for (const { plot } of this.charts) if (plot.width !== width) plot.setSize({ width, height: PLOT_HEIGHT });
  }

  /** Places the line at the time of the picture. */
  mark(time) {
    this.time = time;
    this.charts.forEach((chart) => this.put(chart));
  }

  put({ plot, now }) {
    if (!plot) return;
    const { min, max } = plot.scales.x;
    const inside = this.time !== null && this.time >= min && this.time <= max;
    now.style.display = inside ? "block" : "none";
    if (inside) now.style.transform = `translateX(${plot.valToPos(this.time, "x")}px)`;
  }
}

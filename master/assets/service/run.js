"use strict";
// The page of one job: state, plots, log, orders, files.

const MOST_POINTS = 4000;
const MOST_LOG = 500;
const DRAW_EVERY = 500;
const HISTORY_EVERY = 3000;
/** Largest number of redecompositions that are marked, and of workers in a plot: those with the largest values. */
const MOST_MARKS = 1000;
const MOST_WORKERS = 6;
const FINAL = ["checked", "completed", "refused", "failed", "lost", "stopped"];
const KEYS = ["end_time", "output.field_interval", "output.history_interval", "parallel.imbalance", "parallel.low_every_at_least"];

/** Rows over time; every second one is dropped when there are too many. */
class Rows {
  constructor() {
    this.rows = [];
  }

  add(row) {
    const last = this.rows[this.rows.length - 1];
    if (last && row[0] <= last[0]) return;
    this.rows.push(row);
    if (this.rows.length > MOST_POINTS) this.rows = this.rows.filter((_, i) => i % 2 === 0);
  }

  columns() {
    const count = Math.max(0, ...this.rows.map((row) => row.length));
    return Array.from({ length: count }, (_, c) => this.rows.map((row) => row[c] ?? null));
  }
}

/** The times at which counts of redecompositions, *low* and *high*, have grown. */
class Marks {
  constructor() {
    this.counts = null;
    this.list = [];
  }

  add(time, counts) {
    const before = this.counts || counts;
    this.counts = counts;
    [true, false].forEach((solid, kind) => {
      if (counts[kind] > before[kind]) this.list.push({ time, solid });
    });
    if (this.list.length > MOST_MARKS) this.list.shift();
  }
}

/** Rows of `history.csv` as those of the stream: time, dt, energies, error; and counts of redecompositions. */
function historyRows(text) {
  const lines = text.trim().split("\n");
  const names = lines[0].split(",");
  const column = (start) => names.findIndex((name) => name.startsWith(start));
  const wanted = ["time", "dt", "kinetic", "internal", "hourglass", "contact work", "external work", "energy error"].map(column);
  const unit = (name) => (names[column(name)].match(/\[(.*)\]/) || ["", ""])[1];
  const rows = lines.slice(1).map((line) => {
    const values = line.split(",");
    return wanted.map((c) => (values[c] === "" ? null : Number(values[c])));
  });
  const counted = ["low redecompositions", "high redecompositions"].map(column);
  const counts = lines.slice(1).map((line) => counted.map((c) => Number(line.split(",")[c])));
  return { rows, counts, time: unit("time"), energy: unit("kinetic") };
}

class RunPage {
  constructor() {
    this.id = null;
    byId("run-orders").addEventListener("click", (event) => {
      const order = event.target.dataset.order;
      if (order) this.order(order);
    });
    this.picture = new LivePicture(byId("run-picture"), (times) => this.slider.set(times));
    this.slider = new TimeSlider(byId("run-time"), byId("run-time-text"), (time) => this.picture.at(time));
    byId("run-compare").addEventListener("submit", (event) => {
      event.preventDefault();
      location.hash = `#/compare/${this.id}/${event.target.querySelector("input").value}`;
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
    addEventListener("resize", () => this.plots && this.plots.fit());
  }

  async open(about, id) {
    this.id = id;
    this.about = about;
    this.energies = new Rows();
    this.loads = new Rows();
    this.marks = new Marks();
    this.units = { time: "", energy: "" };
    this.plots = null;
    this.asked = 0;
    byId("plots").replaceChildren();
    byId("run-log").replaceChildren();
    byId("run-files").replaceChildren();
    byId("run-check").hidden = true;
    byId("run-now").textContent = "";
    const job = await guarded(() => getJson(`/api/jobs/${id}`));
    if (!job || this.id !== id) return;
    this.show(job);
    this.slider.clear();
    this.picture.open(id);
    this.listen();
    this.timer = setInterval(() => this.draw(), DRAW_EVERY);
  }

  close() {
    this.id = null;
    this.picture.close();
    clearInterval(this.timer);
    if (this.source) this.source.close();
    this.source = null;
  }

  /** Reads the rows so far. The file exists once the run has made progress. */
  async history() {
    this.asked = Date.now();
    const response = await fetch(`/api/jobs/${this.id}/files/results/history.csv`).catch(() => null);
    if (!response || !response.ok) return;
    const { rows, counts, time, energy } = historyRows(await response.text());
    this.units = { time, energy };
    this.picture.setUnit(time);
    this.slider.unit = time;
    this.slider.label();
    const later = this.energies.rows;
    this.energies = new Rows();
    for (const row of [...rows, ...later]) this.energies.add(row);
    const marks = new Marks();
    rows.forEach((row, i) => marks.add(row[0], counts[i]));
    const last = rows.length ? rows[rows.length - 1][0] : -Infinity;
    marks.list.push(...this.marks.list.filter((mark) => mark.time > last));
    this.marks.list = marks.list;
    this.changed = true;
  }

  listen() {
    this.source = new EventSource(`/api/jobs/${this.id}/events`);
    this.source.addEventListener("state", (event) => this.show(JSON.parse(event.data)));
    this.source.addEventListener("event", (event) => this.log(JSON.parse(event.data).text));
    this.source.addEventListener("progress", (event) => this.progress(JSON.parse(event.data)));
    this.source.addEventListener("end", () => {
      this.source.close();
      this.picture.finish();
    });
  }

  show(job) {
    if (this.job && this.job.id === job.id && this.job.state !== job.state) this.log(`state: ${job.state} ${job.reason}`);
    this.job = job;
    document.title = `${job.id} ${job.name} – Crumple`;
    byId("run-title").replaceChildren(`Job ${job.id}: ${job.name} `, badge(job.state));
    const facts = [
      ["owner", job.owner],
      ["job file", job.job],
      ["launcher", `${job.launcher}, ${job.workers} workers, attempt ${job.attempt}`],
      ["memory", job.memory_mb ? `about ${job.memory_mb.toFixed(1)} MB` : "–"],
      ["submitted", when(job.submitted)],
      ["started", when(job.started)],
      ["ended", when(job.ended)],
    ];
    if (job.set.length) facts.push(["changes", job.set.join(", ")]);
    if (job.reason) facts.push(["reason", job.reason]);
    byId("run-facts").replaceChildren(...facts.flatMap(([key, value]) => [element("dt", key), element("dd", value)]));
    const runs = job.state === "running";
    const mine = this.about.role === "admin" || (this.about.role === "submit" && this.about.name === job.owner);
    const allowed = {
      checkpoint: runs, pause: runs, continue: runs, set: runs,
      stop: !FINAL.includes(job.state), kill: job.stopping && !job.forced,
      resume: ["checked", "completed", "failed", "lost", "stopped"].includes(job.state),
    };
    for (const button of byId("run-orders").querySelectorAll("[data-order]")) {
      button.disabled = !mine || !allowed[button.dataset.order];
      if (button.dataset.order === "kill") button.hidden = button.disabled;
    }
    const rests = FINAL.includes(job.state) || job.state === "queued";
    byId("run-report").hidden = true; // a run that continues removes its report
    if (rests) this.files();
    if (job.state !== "checking") this.check();
  }

  async check() {
    if (!byId("run-check").hidden) return;
    const id = this.id;
    const found = await getJson(`/api/jobs/${id}/check`).catch(() => null);
    if (!found || this.id !== id) return;
    byId("run-check-title").textContent = `Check: ${summaryOf(found)}`;
    showFindings(byId("run-check-findings"), found);
    byId("run-check").open = !found.usable;
    byId("run-check").hidden = false;
  }

  async files() {
    const id = this.id;
    const files = await getJson(`/api/jobs/${id}/files`).catch(() => []);
    if (this.id !== id) return;
    const url = (path) => `/api/jobs/${id}/files/${path.split("/").map(encodeURIComponent).join("/")}`;
    const items = files.slice(0, 300).map((file) => {
      const item = element("li");
      item.append(element("a", file.path, { href: url(file.path) }), ` ${(file.size / 1e3).toFixed(1)} kB`);
      return item;
    });
    byId("run-files").replaceChildren(...items);
    const report = files.find((file) => file.path === "results/report.html");
    if (files.some((file) => file.path === "results/history.csv")) this.history();
    byId("run-report").hidden = !report;
    if (report) byId("run-report").href = url(report.path);
  }

  log(text) {
    const place = byId("run-log");
    const atEnd = place.scrollTop + place.clientHeight >= place.scrollHeight - 4;
    place.append(element("li", text));
    if (place.children.length > MOST_LOG) place.firstChild.remove();
    if (atEnd) place.scrollTop = place.scrollHeight;
  }

  progress(p) {
    if (p.cycle === 0) return; // before the first reports
    const e = p.energy;
    this.energies.add([p.time, p.dt, e.kinetic, e.internal, e.hourglass, e.contact, e.external, e.error]);
    const mean = p.workers.reduce((sum, worker) => sum + worker.load, 0) / p.workers.length || 1;
    const { margin, imbalance } = p.thresholds;
    const loads = p.workers.map((worker) => worker.load / mean);
    this.loads.add([p.time, p.imbalance, imbalance, margin, ...p.workers.map((worker) => worker.share), ...loads]);
    this.marks.add(p.time, p.redecompositions);
    const [low, high] = p.redecompositions;
    byId("run-now").textContent =
      `cycle ${p.cycle}, time ${digits(p.time, 5)} ${this.units.time}, dt ${digits(p.dt, 3)}, energy error ` +
      `${(100 * e.error).toFixed(2)} %, ${p.pairs} pairs, ${low} low and ${high} high redecompositions, ${p.wall_s.toFixed(0)} s`;
    this.changed = true;
    if (!this.units.time && Date.now() > this.asked + HISTORY_EVERY) this.history();
  }

  draw() {
    if (!this.changed || this.energies.rows.length < 2) return;
    this.changed = false;
    const [time, dt, kinetic, internal, hourglass, contact, external, error] = this.energies.columns();
    const energy = { title: "Energy", unit: this.units.energy, lines: [
      { label: "kinetic", values: kinetic }, { label: "internal", values: internal }, { label: "hourglass", values: hourglass },
      { label: "contact work", values: contact }, { label: "external work", values: external },
    ] };
    const groups = [{ time, plots: [energy, { title: "Energy error", lines: [{ label: "error", values: error }] },
      { title: "Step size", unit: this.units.time, lines: [{ label: "dt", values: dt }], marks: this.marks.list }] }];
    if (this.loads.rows.length > 1) groups.push(this.ofWorkers());
    this.groups = groups;
    this.redraw();
  }

  /** Displacement and load of the workers with the thresholds of the master, as in the report. */
  ofWorkers() {
    const [time, imbalance, low, high, ...columns] = this.loads.columns();
    const count = columns.length / 2;
    const largest = (of) => {
      const lines = of.map((values, i) => ({ label: `worker ${i}`, values, most: Math.max(...values) }));
      const least = lines.map((line) => line.most).sort((a, b) => b - a)[MOST_WORKERS - 1] ?? -Infinity;
      return lines.filter((line) => line.most >= least).slice(0, MOST_WORKERS);
    };
    const marks = this.marks.list;
    const note = "Solid lines: low redecompositions (new boxes); dotted lines: high ones (new membership).";
    return { time, plots: [
      { title: "Displacement of workers", unit: "of the margin", note, marks,
        lines: [...largest(columns.slice(0, count)), { label: "limit for high", values: high }] },
      { title: "Load of workers", unit: "of the mean", note, marks,
        lines: [{ label: "imbalance", values: imbalance }, ...largest(columns.slice(count)), { label: "limit for low", values: low }] },
    ] };
  }

  /** Updates the plots in place, or makes them if their lines have changed. */
  redraw() {
    if (!this.groups) return;
    // Few points are drawn as circles, and the units come with the history.
    const shape = JSON.stringify([this.groups.map((g) => [g.time.length < 3, g.plots.map((p) => p.lines.map((line) => line.label))]), this.units, matchMedia("(prefers-color-scheme: dark)").matches]);
    if (shape !== this.shape || !this.plots) {
      this.shape = shape;
      const place = byId("plots");
      place.replaceChildren();
      const style = getComputedStyle(document.documentElement);
      this.drawn = this.groups.map((group) => {
        const own = element("div");
        place.append(own);
        const plots = new Plots(own, { ...group, unit: this.units.time }, () => {});
        plots.draw(style);
        return plots;
      });
      this.plots = { fit: () => this.drawn.forEach((plots) => plots.fit()) };
      return;
    }
    this.groups.forEach((group, g) => {
      group.plots.forEach((plot, i) => {
        const { plot: chart, data } = this.drawn[g].charts[i];
        data.marks = plot.marks;
        const { min, max } = chart.scales.x;
        const [first, last] = [chart.data[0][0], chart.data[0].at(-1)];
        const zoomed = min > first || max < last;
        chart.setData([group.time, ...plot.lines.map((line) => line.values)], !zoomed);
        if (zoomed) chart.redraw();
      });
    });
  }

  async order(name) {
    const texts = {
      checkpoint: "Write a checkpoint? The run continues.",
      pause: "Hold the run between two cycles?",
      continue: "Go on with the paused run?",
      stop: "Stop the job? A run writes its results and a checkpoint.",
      kill: "Kill the job? It was asked to stop and may still be writing. It keeps its last checkpoint only.",
      set: "Change a setting of the run:",
      resume: "Continue from the newest checkpoint. A change is key=value, such as end_time=40. Leave it empty to change nothing.",
    };
    const answer = await confirmed(name, texts[name], this.job);
    if (!answer) return;
    const path = `/api/jobs/${this.id}`;
    const done = await guarded(() => {
      if (name === "stop") return postJson(`${path}/stop`, {});
      if (name === "kill") return postJson(`${path}/stop?force=true`, {});
      if (name === "resume") return postJson(`${path}/resume`, { workers: answer.workers, set: answer.value ? [answer.value] : [] });
      if (name === "set") return postJson(`${path}/orders`, { request: "set", key: answer.key, value: Number(answer.value) });
      return postJson(`${path}/orders`, { request: name });
    });
    if (!done) return;
    if (done.answer === "done") this.log(`${done.order}: in effect in cycle ${done.cycle}`);
    if (name === "resume") {
      const { id, about } = this;
      this.close();
      this.open(about, id);
    }
  }
}

/** Asks for confirmation, and for the values that an order needs. */
function confirmed(name, text, job) {
  const dialog = byId("ask");
  byId("ask-title").textContent = name;
  byId("ask-text").textContent = text;
  byId("ask-key-row").hidden = name !== "set";
  byId("ask-value-row").hidden = name !== "set" && name !== "resume";
  byId("ask-workers-row").hidden = name !== "resume";
  byId("ask-value-label").textContent = name === "set" ? "Value" : "Change";
  byId("ask-key").replaceChildren(...KEYS.map((key) => element("option", key, { value: key })));
  byId("ask-workers").value = job.workers;
  byId("ask-value").value = "";
  byId("ask-value").required = name === "set";
  dialog.returnValue = "no";
  dialog.showModal();
  return new Promise((done) => {
    dialog.addEventListener("close", () => {
      const yes = dialog.returnValue === "yes";
      done(yes && { key: byId("ask-key").value, value: byId("ask-value").value, workers: Number(byId("ask-workers").value) });
    }, { once: true });
  });
}

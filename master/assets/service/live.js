"use strict";
// The picture of a job: its newest state, as often as the service has one.

/** Interval between two questions for a state [ms]. */
const LOOK_EVERY = 2000;

class LivePicture {
  /** `times` is called with the times of the outputs when they are known. */
  constructor(place, times = () => {}) {
    this.place = place;
    this.timesKnown = times;
    this.partner = null;
    this.time = null;
    this.view = null;
    this.job = null;
    this.tops = {};
    const control = (name, text, attributes) => element(name, text, attributes);
    this.canvas = control("canvas", undefined, { class: "canvas" });
    this.clock = control("output", "", { class: "clock", "aria-live": "off" });
    this.legend = control("div", undefined, { class: "legend" });
    this.absent = control("p", "", { class: "absent notice" });
    const stage = control("div", undefined, { class: "stage" });
    stage.append(this.canvas, this.clock, this.legend, this.absent);
    this.select = control("select");
    this.select.addEventListener("change", () => this.colour(this.select.value));
    this.boxes = {};
    const row = control("div", undefined, { class: "row" });
    const labelled = (text, input) => {
      const label = control("label");
      label.append(...(input.type === "checkbox" ? [input, ` ${text}`] : [`${text} `, input]));
      row.append(label);
      return input;
    };
    labelled("Colour", this.select);
    this.edges = labelled("Edges", control("input", undefined, { type: "checkbox" }));
    this.walls = labelled("Walls", control("input", undefined, { type: "checkbox" }));
    this.boxes = labelled("Boxes of workers", control("input", undefined, { type: "checkbox" }));
    this.edges.checked = this.walls.checked = true;
    for (const input of [this.edges, this.walls, this.boxes]) input.addEventListener("change", () => this.draw());
    const directions = control("span", undefined, { class: "views", role: "group", "aria-label": "Views" });
    for (const name of Object.keys(VIEWS)) {
      const button = control("button", name[0].toUpperCase() + name.slice(1), { type: "button", "data-view": name });
      button.addEventListener("click", () => this.view && this.view.look(name));
      directions.append(button);
    }
    row.append(directions);
    this.controls = control("div", undefined, { class: "controls" });
    this.controls.append(row);
    place.append(stage, this.controls);
    resized(stage, () => this.view && this.view.fit());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.dress());
  }

  /** Has the camera and the scales of another picture. Both call this. */
  join(other) {
    this.partner = other;
    this.tops = other.tops;
  }

  /** Follows a job. */
  open(job) {
    this.job = job;
    this.tag = null;
    this.time = null;
    for (const title of Object.keys(this.tops)) delete this.tops[title];
    this.isNew = true;
    this.model = null;
    this.unit = "";
    this.place.hidden = false;
    this.place.dataset.states = "0";
    this.say("No state yet: the first output of the run makes one.");
    this.load();
    this.timer = setInterval(() => this.load(), LOOK_EVERY);
  }

  close() {
    this.job = null;
    clearInterval(this.timer);
  }

  /** Shows the last state, and asks for no more. */
  finish() {
    clearInterval(this.timer);
    this.load();
    // The service may have kept the state before the last one.
    this.timer = setTimeout(() => this.load(), 2 * LOOK_EVERY);
  }

  /** Shows the output at a time; null is the present state. */
  at(time) {
    if (this.time === time) return;
    this.time = time;
    this.tag = null;
    this.load();
  }

  setUnit(unit) {
    this.unit = unit;
    if (this.model) this.draw();
  }

  /** Shows why there is no picture. */
  say(why) {
    this.absent.textContent = why;
    this.absent.hidden = !why;
    for (const part of [this.canvas, this.clock, this.legend, this.controls]) part.hidden = Boolean(why);
  }

  async load() {
    const { job, time } = this;
    if (!job || document.hidden || this.loading || (time !== null && this.tag)) return;
    this.loading = true;
    try {
      const headers = this.tag ? { "If-None-Match": this.tag } : {};
      const query = time === null ? "" : `?time=${time}`;
      const response = await fetch(`/api/jobs/${job}/view${query}`, { credentials: "same-origin", headers });
      if (this.job !== job || this.time !== time) return;
      if (response.status === 200) {
        const facts = await response.json();
        const bytes = await unpacked(facts.picture);
        if (this.job !== job || this.time !== time) return;
        this.tag = response.headers.get("ETag");
        this.show(decode(bytes, facts.model), facts);
      } else if (response.status === 503) {
        this.say((await response.json()).error);
      }
    } catch (error) {
      if (this.job === job && !this.tag) this.say(error.message);
    } finally {
      this.loading = false;
      if (this.job && (this.job !== job || this.time !== time)) this.load();
    }
  }

  show(model, facts) {
    this.say("");
    if (!this.view) {
      try {
        this.view = new View(this.canvas, model, facts.walls);
        this.view.turned = () => this.partner && this.partner.view && this.partner.view.lookAs(this.view);
      } catch (error) {
        clearInterval(this.timer);
        return this.say(`This browser has no WebGL, so there is no picture (${error.message}).`);
      }
    } else this.view.replace(model, facts.walls);
    this.facts = facts;
    [this.model, this.shown] = [model, model.parts.map((_, i) => (this.isNew ? true : (this.shown[i] ?? true)))];
    this.ways = colourings(model, facts);
    // The end of a scale only grows, so that equal colours are equal values.
    for (const way of this.ways.filter((w) => !w.kinds)) {
      this.tops[way.title] = Math.max(way.top, this.tops[way.title] ?? way.top);
    }
    this.select.replaceChildren(...this.ways.map((way) => element("option", way.title, { value: way.title })));
    this.walls.parentElement.hidden = !facts.walls.length;
    this.boxes.parentElement.hidden = facts.boxes.length < 2;
    this.view.fit();
    this.dress();
    if (this.partner && this.partner.model) this.partner.colour(this.partner.title);
    if (this.isNew) this.view.look("iso");
    this.isNew = false;
    this.timesKnown(facts.times);
    this.place.dataset.states = String(Number(this.place.dataset.states) + 1);
    this.place.dataset.time = String(model.frames[0].time);
  }

  dress() {
    if (!this.model) return;
    this.view.dress(getComputedStyle(document.documentElement));
    this.colour(this.title);
  }

  /** Colours by the way of this title. */
  colour(title) {
    const first = this.ways.find((way) => way.kinds || way.most > 0);
    this.way = this.ways.find((way) => way.title === title) || first;
    if (title) this.title = title;
    if (!this.way.kinds) this.way.top = this.tops[this.way.title];
    this.select.value = this.way.title;
    legend(this.legend, this.way, this.shown, () => this.draw());
    this.draw();
  }

  draw() {
    if (!this.model) return;
    this.view.edges(this.edges.checked);
    this.view.showWalls(this.walls.checked);
    this.view.mark(this.boxes.checked ? this.facts.boxes.map((box, i) => boxLines(box, this.view.boxes[0], ofKind(i))) : []);
    this.view.show(0, 0, this.way, this.shown, this.model, true);
    this.clock.textContent = `t = ${digits(this.model.frames[0].time, 5)} ${this.unit}`;
  }
}

/** Room around the model in which infinite boxes are drawn, and between two boxes, as fractions of its size. */
const BOX_MARGIN = 0.04;
const BOX_GAP = 0.004;

/** The edges of the box of a worker. Sides at infinity are drawn near the model. */
function boxLines([low, high], model, colour) {
  const size = Math.hypot(...model.low.map((a, c) => model.high[c] - a));
  const ends = [low, high].map((side, upper) =>
    side.map((at, c) => {
      const outside = upper ? model.high[c] + BOX_MARGIN * size : model.low[c] - BOX_MARGIN * size;
      return (at === null ? outside : at) + (upper ? -BOX_GAP : BOX_GAP) * size;
    }),
  );
  const corner = (number) => [0, 1, 2].map((c) => ends[(number >> c) & 1][c]);
  const points = [];
  for (let number = 0; number < 8; number++) {
    for (let c = 0; c < 3; c++) if (!((number >> c) & 1)) points.push(corner(number), corner(number | (1 << c)));
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points.flat()), 3));
  const material = new THREE.LineBasicMaterial({ color: toHex(colour) });
  return new THREE.LineSegments(geometry, material);
}

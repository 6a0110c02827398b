"use strict";
// Behaviour of the page: one time for the picture and the plots, and the actions of the controls.
//
// The fragment of the address (after `#`, joined by `&`) sets up the page: time=20, colour=worker (by its title),
// view=side, edges=0, play, and all that `fragmentOf` writes; check measures the share of the stage that the model
// covers. `data-` attributes of the root report the result: state (ready, without-picture, failed), why, errors,
// frames-per-second, covered.

/** Duration of the animation at speed 1 [ms]. */
const FILM = 8000;
/** Frames per second below which the animation is drawn with fewer pixels or faces. */
const SMOOTH = 30;
/** Interval between two looks at the rate [ms]. */
const LOOK_EVERY = 500;

const root = document.documentElement;
const byId = (id) => document.getElementById(id);
root.dataset.errors = "0";
addEventListener("error", (event) => fail(event.message));
addEventListener("unhandledrejection", (event) => fail(String(event.reason)));

function fail(why) {
  root.dataset.errors = String(Number(root.dataset.errors) + 1);
  root.dataset.why = why;
}

/** Shows on the stage why there is no picture. */
function withoutPicture(why) {
  root.dataset.why = why;
  byId("absent").textContent = why;
  byId("absent").hidden = false;
  for (const id of ["canvas", "controls", "legend"]) byId(id).hidden = true;
}

class Page {
  constructor(facts) {
    this.facts = facts;
    this.asked = new URLSearchParams(location.hash.slice(1));
    this.frame = -1;
    this.time = 0;
    this.playing = false;
    this.quality = 0;
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.second = facts.second && new SecondRun(facts.second);
    this.plotted();
  }

  /** Makes the plots. */
  plotted() {
    const { facts } = this;
    const plots = this.second ? overlaid(facts.plots, facts.second.plots, this.names()) : facts.plots;
    if (plots && plots.time.length) {
      this.plots = new Plots(byId("plots"), plots, (time) => this.go(time));
      this.plots.draw(getComputedStyle(root));
    } else {
      const note = document.createElement("p");
      note.className = "notice";
      note.textContent = "There are no plots: history.csv is missing or has no rows.";
      byId("plots").append(note);
    }
  }

  /** Names of the runs; a single one needs none. */
  names() {
    return this.second ? [this.second.facts.first_name, this.second.facts.name] : [""];
  }

  /** Makes the plot workbench and the tables of figures. */
  async histories() {
    if (typeof DecompressionStream === "undefined") return;
    const runs = [];
    for (const [i, facts] of [this.facts, this.facts.second].filter(Boolean).entries()) {
      const packed = byId(i ? "packed-histories-second" : "packed-histories");
      if (facts.histories.rows) runs.push({ name: this.names()[i], heads: facts.heads, histories: new Histories(await unpacked(packed.textContent), facts.histories, facts.time_unit) });
      packed.remove();
    }
    if (!runs.length) return;
    byId("bench").hidden = false;
    // Forces and courses of the picture are those of the first run.
    this.read = this.facts.histories.rows ? runs[0].histories : null;
    this.bench = new Workbench(runs, (time) => this.go(time));
    this.figures = new Figures(runs);
  }

  /** Says why there is no plot workbench. */
  withoutHistories(why) {
    byId("bench").hidden = true;
    const note = Object.assign(document.createElement("p"), { className: "notice", textContent: `There is no plot workbench: ${why}` });
    byId("plots").prepend(note);
  }

  whyNoPicture() {
    return "There is no picture: the run wrote no field files. Set output.field_interval to 0 or more and repeat `crumple run`, which makes this page again.";
  }

  /** Ways to colour the model. */
  colourings() {
    return colourings(this.model, this.facts);
  }

  /** Makes the picture. Throws if this is not possible. */
  async picture() {
    const { model } = this.facts;
    if (!model || !model.frames.length) {
      throw new Error(this.whyNoPicture());
    }
    if (typeof DecompressionStream === "undefined") throw new Error("This browser is too old for the picture: it cannot decompress it.");
    const packed = byId("packed");
    this.model = decode(await unpacked(packed.textContent), model);
    packed.remove();
    this.ways = this.colourings();
    this.way = this.ways.find((way) => way.kinds || way.most > 0);
    this.shown = this.model.parts.map(() => true);
    try {
      this.view = new View(byId("canvas"), this.model, this.facts.walls);
    } catch (error) {
      throw new Error(`This browser has no WebGL, so there is no picture (${error.message}). Plots and tables are complete.`);
    }
    this.times = this.model.frames.map((frame) => frame.time);
    if (this.second?.facts.model) await this.second.picture(this);
    const largest = [this.model, this.second?.model].filter(Boolean).reduce((a, b) => (b.faces > a.faces ? b : a));
    this.qualities = qualitiesOf(largest);
    this.stops = [...new Set([...this.times, ...(this.second?.times ?? [])])].sort((a, b) => a - b);
    this.begin = this.stops[0];
    this.end = this.stops[this.stops.length - 1];
    this.view.reset = () => this.look("iso");
    this.stageMarks = new StageMarks(byId("marks"), this.view, this.facts.length_unit);
    this.view.after = () => this.stageMarks.draw();
    this.arrows = this.read && new ForceArrows(this.view, this.model, this.read);
    this.nodeForces = new NodeForces(this.view, this.model);
    this.picker = new Picker(this.view, this.model, this.facts, () => this.picked());
    this.connect();
    this.dress();
    this.view.fit();
    byId("follow").checked = travels(this.view);
    this.view.following = byId("follow").checked;
    this.view.look("iso");
    this.more();
    this.setUp();
  }

  /** Adds what only one kind of page has. */
  more() {}

  connect() {
    const on = (id, event, act) => byId(id).addEventListener(event, act);
    const slider = byId("slider");
    slider.min = this.begin;
    slider.max = this.end;
    slider.disabled = this.stops.length < 2;
    byId("play").disabled = this.stops.length < 2;
    on("play", "click", () => this.play(!this.playing));
    on("slider", "input", () => this.go(Number(slider.value)));
    on("edges", "change", () => this.redraw());
    on("walls", "change", () => {
      this.view.showWalls(byId("walls").checked);
      this.redraw();
    });
    byId("walls").parentElement.hidden = !this.view.walls.length;
    byId("forces").parentElement.hidden = !this.arrows?.most;
    on("forces", "change", () => {
      this.arrows.on = byId("forces").checked;
      this.redraw();
    });
    byId("node-forces").parentElement.hidden = !this.nodeForces.most;
    on("node-forces", "change", () => {
      this.nodeForces.on = byId("node-forces").checked;
      this.redraw();
    });
    on("follow", "change", () => {
      this.view.following = byId("follow").checked;
      this.view.look("iso");
      this.redraw();
    });
    for (const button of document.querySelectorAll("[data-view]")) {
      button.addEventListener("click", () => this.look(button.dataset.view));
    }
    const select = byId("colour");
    this.ways.forEach((way, i) => select.add(new Option(way.title, i)));
    on("colour", "change", () => this.colour(this.ways[select.value]));
    for (const id of ["bottom", "top"]) {
      on(id, "change", () => {
        const [low, top] = [Number(byId("bottom").value), Number(byId("top").value)];
        if (top > low) [this.way.low, this.way.top] = [low, top];
        this.colour(this.way);
      });
    }
    on("smooth", "change", () => {
      this.view.surface.style.smooth = byId("smooth").checked;
      this.redraw();
    });
    on("parallel", "change", () => {
      this.view.flatten(byId("parallel").checked);
      this.redraw();
    });
    on("magnify", "change", () => this.magnify());
    for (const id of ["cut-axis", "cut-place", "cut-flip"]) on(id, id === "cut-place" ? "input" : "change", () => this.cut());
    on("cut-axis", "change", () => this.placeCut());
    on("find", "click", () => this.find(byId("find-kind").value, Number(byId("find-id").value)));
    on("find-id", "keydown", (event) => event.key === "Enter" && byId("find").click());
    on("picked-none", "click", () => this.picker.pick(-1, -1));
    on("picked-course", "click", () => this.course());
    on("link", "click", () => this.link());
    on("save-picture", "click", () => stageCanvas(this).toBlob((blob) => keep("picture.png", blob)));
    on("save-film", "click", () => this.film());
    on("opacity", "input", () => {
      this.view.surface.opacity.value = Number(byId("opacity").value);
      this.redraw();
    });
    for (const [id, seen] of [["parts-all", true], ["parts-none", false]]) {
      on(id, "click", () => {
        this.shown.fill(seen);
        this.partsChanged();
      });
    }
    for (const item of document.querySelectorAll("#warnings li")) this.jumpFrom(item);
    addEventListener("beforeprint", () => {
      byId("print").src = stageCanvas(this).toDataURL();
      byId("print").classList.add("made");
    });
    addEventListener("keydown", (event) => this.key(event));
    resized(byId("stage"), () => this.view.fit());
  }

  /** Colours of the page, light or dark. */
  dress() {
    if (this.plots) this.plots.draw(getComputedStyle(root));
    if (!this.view) return;
    this.view.dress(getComputedStyle(root));
    this.stageMarks.ink = getComputedStyle(root).getPropertyValue("--ink").trim();
    this.redraw();
  }

  /** Sets the controls from the fragment of the address. */
  setUp() {
    const { asked, view, model } = this;
    const way = this.ways.find((w) => w.title === asked.get("colour")) || this.way;
    const numbers = (key) => (asked.get(key) || "").split(",").map(Number);
    const [low, top] = numbers("scale");
    if (!way.kinds && top > low) [way.low, way.top] = [low, top];
    for (const id of ["edges", "walls", "smooth", "parallel", "forces", "node-forces", "follow"]) {
      const box = byId(id);
      if (asked.has(id) && !box.parentElement.hidden && (asked.get(id) === "1") !== box.checked) {
        box.checked = asked.get(id) === "1";
        box.dispatchEvent(new Event("change"));
      }
    }
    for (const [key, flags, wanted] of [["hidden", this.shown, false], ["ghosts", view.surface.style.ghosts, true]]) {
      if (asked.has(key)) numbers(key).forEach((id) => model.parts.includes(id) && (flags[model.parts.indexOf(id)] = wanted));
    }
    if (asked.has("opacity")) {
      byId("opacity").value = asked.get("opacity");
      view.surface.opacity.value = Number(byId("opacity").value);
    }
    this.colour(way);
    this.partsChanged();
    if (asked.has("magnify")) byId("magnify").value = asked.get("magnify");
    this.magnify();
    if (asked.get("view") in VIEWS) this.look(asked.get("view"));
    this.go(asked.has("time") ? Number(asked.get("time")) : this.begin);
    const [axis, place, flipped] = (asked.get("cut") || "none").split(",");
    if (["x", "y", "z"].includes(axis)) {
      byId("cut-axis").value = axis;
      this.placeCut();
      byId("cut-place").value = place;
      byId("cut-flip").checked = flipped === "1";
      this.cut();
    }
    for (const kind of ["element", "node"]) if (asked.has(kind)) this.find(kind, Number(asked.get(kind)));
    const camera = numbers("camera");
    if (camera.length === 6 && camera.every(Number.isFinite)) {
      view.place((offset, target) => {
        target.set(...camera.slice(3));
        offset.set(...camera.slice(0, 3)).sub(target);
      });
    }
    if (asked.has("check")) root.dataset.covered = this.view.covered().toFixed(4);
    if (asked.has("play")) this.play(true);
  }

  look(name) {
    this.view.look(name);
    this.redraw();
  }

  colour(way) {
    this.way = way;
    byId("colour").value = this.ways.indexOf(way);
    byId("ends-of-scale").hidden = Boolean(way.kinds);
    if (!way.kinds) [byId("bottom").value, byId("top").value] = [way.low, way.top];
    legend(byId("legend"), way, this.shown, () => this.partsChanged());
    this.redraw();
  }

  /** Shows the parts that are chosen, and the same choice in the legend and in the list. */
  partsChanged() {
    const parts = this.ways.find((way) => way.title === "part").kinds;
    partsList(byId("parts-list"), parts, this.shown, this.view.surface.style.ghosts, () => this.partsChanged());
    legend(byId("legend"), this.way, this.shown, () => this.partsChanged());
    this.redraw();
  }

  magnify() {
    const factor = Number(byId("magnify").value);
    this.view.surface.style.scale = Number.isFinite(factor) ? factor : 1;
    this.redraw();
  }

  /** Puts the section plane into the middle of the model. */
  placeCut() {
    const axis = ["x", "y", "z"].indexOf(byId("cut-axis").value);
    const slider = byId("cut-place");
    byId("cut").hidden = axis < 0;
    if (axis >= 0) {
      const { low, high } = this.view.whole;
      [slider.min, slider.max] = [low[axis], high[axis]];
      slider.value = 0.5 * (low[axis] + high[axis]);
    }
    this.cut();
  }

  /** Cuts the model at the section plane. */
  cut() {
    const axis = ["x", "y", "z"].indexOf(byId("cut-axis").value);
    const place = Number(byId("cut-place").value);
    const side = byId("cut-flip").checked ? -1 : 1;
    byId("cut-value").textContent = `${digits(place)} ${this.facts.length_unit}`;
    this.view.surface.cut(axis < 0 ? null : [...[0, 1, 2].map((c) => (c === axis ? side : 0)), side * place]);
    this.redraw();
  }

  say(words) {
    byId("words").textContent = words;
  }

  find(kind, id) {
    this.say("");
    try {
      this.picker.find(kind, id);
    } catch (error) {
      this.say(error.message);
    }
  }

  /** Shows the data of what is picked. */
  picked() {
    const { picker } = this;
    const nothing = picker.element < 0 && picker.node < 0;
    byId("picked").hidden = nothing;
    if (!nothing) {
      byId("picked-name").textContent = picker.name();
      const item = (name, text) => Object.assign(document.createElement(name), { textContent: text });
      byId("picked-data").replaceChildren(...this.dataOfPicked().flatMap(([name, text]) => [item("dt", name), item("dd", text)]));
    }
    this.view.draw();
  }

  /** Names and values of what is picked. */
  dataOfPicked() {
    return this.picker.data(this.way, this.model.frames[this.frame]);
  }

  /** Plots the course of what is picked: of the quantity that is shown. */
  course() {
    if (!this.bench) return this.say("There are no plots: history.csv is missing or has no rows.");
    const ofNode = this.picker.element < 0;
    const suits = (way) => !way.kinds && (!ofNode || way.node);
    const way = suits(this.way) ? this.way : this.ways.find(suits);
    this.bench.addCourse(`${way.title} of ${this.picker.name()}`, way.unit, Float64Array.from(this.times), this.picker.course(way));
    byId("bench").scrollIntoView({ block: "nearest" });
  }

  /** Puts the view into the address, and the address into the clipboard where the browser allows it. */
  async link() {
    history.replaceState(null, "", `#${fragmentOf(this)}`);
    try {
      await navigator.clipboard.writeText(location.href);
      this.say("The link is in the clipboard.");
    } catch {
      this.say("The link is in the address of the page.");
    }
  }

  async film() {
    this.play(false);
    const before = this.time;
    byId("save-film").disabled = true;
    try {
      const blob = await film(this, (share) => this.say(`Recording: ${Math.round(100 * share)} %`));
      keep(`film.${blob.type.split("/")[1]}`, blob);
      this.say("The film is saved.");
    } catch (error) {
      this.say(error.message);
    }
    byId("save-film").disabled = false;
    this.go(before);
  }

  /** Adds a button to a warning that names a time, an element or a node. */
  jumpFrom(item) {
    const { time, element, node } = item.dataset;
    if (time === undefined && element === undefined && node === undefined) return;
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "Show";
    button.addEventListener("click", () => {
      this.play(false);
      this.go(time === undefined ? this.end : Number(time));
      if (element !== undefined) this.find("element", Number(element));
      else if (node !== undefined) this.find("node", Number(node));
      byId("picture").scrollIntoView({ block: "nearest" });
    });
    item.append(" ", button);
  }

  /** Shows this time, limited to the first and last one. */
  go(time) {
    this.time = Math.min(Math.max(Number.isFinite(time) ? time : this.begin, this.begin ?? time), this.end ?? time);
    if (this.plots) this.plots.mark(this.time);
    if (this.bench) this.bench.chart.mark(this.time);
    if (!this.view) return;
    const { first, fraction } = frameAt(this.times, this.time);
    const changed = first !== this.frame;
    this.frame = first;
    this.view.show(first, fraction, this.way, this.shown, this.model, changed, () => this.moved());
    if (this.second?.view) this.second.go(this.time);
    if (changed && !byId("picked").hidden) this.picked();
    byId("slider").value = this.time;
    const words = `${clock(this.time, this.end - this.begin)} ${this.facts.time_unit}`;
    byId("clock").textContent = `t = ${words}`;
    byId("slider").setAttribute("aria-valuetext", words);
  }

  /** Moves what is drawn in addition to the model. */
  moved() {
    this.picker.update();
    if (this.arrows) this.arrows.update(this.time, this.model.frames[this.frame]);
    this.nodeForces.update(this.model.frames[this.frame]);
  }

  /** Draws the same time completely again. */
  redraw() {
    this.frame = -1;
    this.view.edges(byId("edges").checked);
    if (this.second?.view) this.second.follow();
    this.go(this.time);
  }

  play(on) {
    const wasOn = this.playing;
    this.playing = on;
    const button = byId("play");
    button.textContent = on ? "❚❚" : "▶";
    button.setAttribute("aria-label", on ? "Pause" : "Play");
    if (on || wasOn) this.simplify(on ? this.quality : 0);
    if (!on) return;
    if (this.time >= this.end) this.go(this.begin);
    let last = null;
    let since = null;
    let count = 0;
    const next = (now) => {
      if (!this.playing) return;
      since ??= now;
      const passed = now - (last ?? now);
      last = now;
      const film = (this.end - this.begin) / FILM;
      this.go(this.time + passed * film * Number(byId("speed").value));
      if (now - since >= LOOK_EVERY) {
        const rate = (1000 * count) / (now - since);
        root.dataset.framesPerSecond = rate.toFixed(1);
        since = now;
        count = 0;
        if (rate < SMOOTH && this.quality + 1 < this.qualities.length) {
          this.simplify(++this.quality);
          [last, since] = [null, null]; // its own time does not count
        }
      }
      count++;
      if (this.time < this.end) requestAnimationFrame(next);
      else if (this.asked.get("play") === "again") {
        this.go(this.begin);
        requestAnimationFrame(next);
      } else this.play(false);
    };
    requestAnimationFrame(next);
  }

  /** Draws with a quality of the list. */
  simplify(quality) {
    for (const view of [this.view, this.second?.view]) view?.simplify(this.qualities[quality]);
    this.redraw();
  }

  /** Selects the next or the previous output time. */
  step(by) {
    this.play(false);
    const frame = by > 0 ? this.stops.find((t) => t > this.time) : this.stops.findLast((t) => t < this.time);
    if (frame !== undefined) this.go(frame);
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const within = (selector) => event.target instanceof Element && event.target.closest(selector);
    const typing = within("input:not([type=checkbox]), select, summary");
    const pressing = within("button, input[type=checkbox]");
    if (typing || (pressing && event.key === " ")) return;
    const acts = {
      " ": () => this.play(!this.playing),
      ArrowRight: () => this.step(1),
      ArrowLeft: () => this.step(-1),
      Home: () => this.go(this.begin),
      End: () => this.go(this.end),
      e: () => byId("edges").click(),
    };
    Object.keys(VIEWS).forEach((name, i) => (acts[String(i + 1)] = () => this.look(name)));
    const act = acts[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }
}

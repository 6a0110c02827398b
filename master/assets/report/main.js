"use strict";
// Behaviour of the page: one time for the picture and the plots, and the actions of the controls.
//
// The fragment of the address (after `#`, joined by `&`) sets up the page: time=20, colour=worker (by its title),
// view=side, edges=0, play, check (measures the share of the stage that the model covers). `data-` attributes of the
// root report the result: state (ready, without-picture, failed), why, errors, frames-per-second, covered.

/** Duration of the animation at speed 1 [ms]. */
const FILM = 8000;
/** Frames per second below which the animation is drawn with a lower resolution. */
const SMOOTH = 30;

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
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    const { plots } = facts;
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

  /** Makes the picture. Throws if this is not possible. */
  async picture() {
    const { model } = this.facts;
    if (!model || !model.frames.length) {
      throw new Error(
        "There is no picture: the run wrote no field files. Set output.field_interval to 0 or more and repeat `crumple run`, which makes this page again.",
      );
    }
    if (typeof DecompressionStream === "undefined") throw new Error("This browser is too old for the picture: it cannot decompress it.");
    const packed = byId("packed");
    this.model = decode(await unpacked(packed.textContent), model);
    packed.remove();
    this.ways = colourings(this.model, this.facts);
    this.way = this.ways.find((way) => way.kinds || way.most > 0);
    this.shown = this.model.parts.map(() => true);
    try {
      this.view = new View(byId("canvas"), this.model, this.facts.walls);
    } catch (error) {
      throw new Error(`This browser has no WebGL, so there is no picture (${error.message}). Plots and tables are complete.`);
    }
    this.times = this.model.frames.map((frame) => frame.time);
    this.begin = this.times[0];
    this.end = this.times[this.times.length - 1];
    this.view.reset = () => this.look("iso");
    this.connect();
    this.dress();
    this.view.fit();
    byId("follow").checked = travels(this.view);
    this.view.following = byId("follow").checked;
    this.view.look("iso");
    this.setUp();
  }

  connect() {
    const on = (id, event, act) => byId(id).addEventListener(event, act);
    const slider = byId("slider");
    slider.min = this.begin;
    slider.max = this.end;
    slider.disabled = this.times.length < 2;
    byId("play").disabled = this.times.length < 2;
    on("play", "click", () => this.play(!this.playing));
    on("slider", "input", () => this.go(Number(slider.value)));
    on("edges", "change", () => this.redraw());
    on("walls", "change", () => this.view.showWalls(byId("walls").checked));
    byId("walls").parentElement.hidden = !this.view.walls.length;
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
    on("top", "change", () => {
      const top = Number(byId("top").value);
      if (top > this.way.low) this.way.top = top;
      this.colour(this.way);
    });
    addEventListener("keydown", (event) => this.key(event));
    resized(byId("stage"), () => this.view.fit());
  }

  /** Colours of the page, light or dark. */
  dress() {
    if (this.plots) this.plots.draw(getComputedStyle(root));
    if (!this.view) return;
    this.view.dress(getComputedStyle(root));
    this.redraw();
  }

  setUp() {
    const { asked } = this;
    const way = this.ways.find((w) => w.title === asked.get("colour"));
    if (asked.get("edges") === "0") byId("edges").checked = false;
    this.colour(way || this.way);
    if (asked.get("view") in VIEWS) this.look(asked.get("view"));
    this.go(asked.has("time") ? Number(asked.get("time")) : this.begin);
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
    byId("top-of-scale").hidden = Boolean(way.kinds);
    if (!way.kinds) byId("top").value = way.top;
    legend(byId("legend"), way, this.shown, () => this.redraw());
    this.redraw();
  }

  /** Shows this time, limited to the first and last one. */
  go(time) {
    this.time = Math.min(Math.max(Number.isFinite(time) ? time : this.begin, this.begin ?? time), this.end ?? time);
    if (this.plots) this.plots.mark(this.time);
    if (!this.view) return;
    const after = this.times.findIndex((t) => t > this.time);
    const first = after < 0 ? this.times.length - 1 : Math.max(after - 1, 0);
    const span = after < 0 ? 0 : this.times[after] - this.times[first];
    const changed = first !== this.frame;
    this.frame = first;
    this.view.show(first, span > 0 ? (this.time - this.times[first]) / span : 0, this.way, this.shown, this.model, changed);
    byId("slider").value = this.time;
    const words = `${clock(this.time, this.end - this.begin)} ${this.facts.time_unit}`;
    byId("clock").textContent = `t = ${words}`;
    byId("slider").setAttribute("aria-valuetext", words);
  }

  /** Draws the same time completely again. */
  redraw() {
    this.frame = -1;
    this.view.edges(byId("edges").checked);
    this.go(this.time);
  }

  play(on) {
    this.playing = on;
    const button = byId("play");
    button.textContent = on ? "❚❚" : "▶";
    button.setAttribute("aria-label", on ? "Pause" : "Play");
    if (!on) {
      this.view.sharpen(1);
      return;
    }
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
      if (now - since >= 1000) {
        const rate = (1000 * count) / (now - since);
        root.dataset.framesPerSecond = rate.toFixed(1);
        if (rate < SMOOTH) this.view.sharpen(0.8 * this.view.sharpness);
        since = now;
        count = 0;
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

  /** Selects the next or the previous output time. */
  step(by) {
    this.play(false);
    const frame = by > 0 ? this.times.find((t) => t > this.time) : this.times.findLast((t) => t < this.time);
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

async function begin() {
  const page = new Page(JSON.parse(byId("facts").textContent));
  window.crumple = page;
  page.dark.addEventListener("change", () => page.dress());
  if (page.plots) resized(byId("plots"), () => page.plots.fit());
  try {
    await page.picture();
    root.dataset.state = "ready";
  } catch (error) {
    withoutPicture(error.message);
    root.dataset.state = "without-picture";
  }
}

begin();

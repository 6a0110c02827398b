"use strict";
// A second run next to the first: same time, camera, colours and settings, and its plots laid over.

/** The frame at or before a time, and the share of the way to the next one. */
function frameAt(times, time) {
  const after = times.findIndex((t) => t > time);
  const first = after < 0 ? times.length - 1 : Math.max(after - 1, 0);
  const span = after < 0 ? 0 : times[after] - times[first];
  return { first, fraction: span > 0 ? Math.max(time - times[first], 0) / span : 0 };
}

class SecondRun {
  constructor(facts) {
    this.facts = facts;
    this.frame = -1;
  }

  /** Makes its picture next to that of a page. */
  async picture(page) {
    const packed = byId("packed-second");
    this.page = page;
    this.model = decode(await unpacked(packed.textContent), this.facts.model);
    packed.remove();
    this.times = this.model.frames.map((frame) => frame.time);
    this.ways = colourings(this.model, this.facts);
    byId("stages").classList.add("two");
    byId("stage-second").hidden = false;
    byId("name-first").textContent = this.facts.first_name;
    byId("name-second").textContent = this.facts.name;
    this.view = new View(byId("canvas-second"), this.model, this.facts.walls);
    this.view.turned = () => page.view.lookAs(this.view);
    page.view.turned = () => this.view.lookAs(page.view);
    resized(byId("stage-second"), () => this.view.fit());
    this.view.fit();
  }

  /** Takes the colours and settings of the page. */
  follow() {
    const { page, view, model } = this;
    this.way = this.ways.find((way) => way.title === page.way.title) || this.ways[0];
    if (!this.way.kinds && !page.way.kinds) [this.way.low, this.way.top] = [page.way.low, page.way.top];
    const { surface } = page.view;
    const partOf = (id) => page.model.parts.indexOf(id);
    this.shown = model.parts.map((id) => page.shown[partOf(id)] ?? true);
    Object.assign(view.surface.style, surface.style, { ghosts: model.parts.map((id) => surface.style.ghosts[partOf(id)] ?? false) });
    view.surface.opacity.value = surface.opacity.value;
    view.surface.cut(surface.plane ?? null);
    view.parallel = page.view.parallel;
    if (!view.parallel) view.camera.updateProjectionMatrix();
    view.dress(getComputedStyle(document.documentElement));
    view.edges(byId("edges").checked);
    view.showWalls(byId("walls").checked);
    this.frame = -1;
  }

  go(time) {
    const { first, fraction } = frameAt(this.times, time);
    const changed = first !== this.frame;
    this.frame = first;
    this.view.show(first, fraction, this.way, this.shown, this.model, changed);
  }
}

/** The plots of two runs laid over each other, at the times of both. */
function overlaid(first, second, names) {
  const time = [...new Set([...first.time, ...second.time])].sort((a, b) => a - b);
  const place = new Map(time.map((t, i) => [t, i]));
  const lines = (plots, plot, name) =>
    (plot?.lines || []).map((line) => {
      const values = new Array(time.length).fill(null);
      line.values.forEach((value, row) => (values[place.get(plots.time[row])] = value));
      return { ...line, label: `${line.label} (${name})`, values, spans: true };
    });
  const titled = (plots, title) => plots.plots.find((plot) => plot.title === title);
  const titles = [...new Set([...first.plots, ...second.plots].map((plot) => plot.title))];
  const plots = titles.map((title) => {
    const both = [titled(first, title), titled(second, title)];
    const all = [...lines(first, both[0], names[0]), ...lines(second, both[1], names[1])];
    return { ...(both[0] || both[1]), lines: all };
  });
  return { unit: first.unit, time, plots };
}

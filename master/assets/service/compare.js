"use strict";
// Two jobs in step: one camera, one time, one scale of colours, and their histories in the same plots.

const COMPARE_EVERY = 3000;

class ComparePage {
  constructor() {
    this.pictures = ["first", "second"].map((name, i) => {
      return new LivePicture(byId(`compare-picture-${name}`), (times) => this.know(i, times));
    });
    const [first, second] = this.pictures;
    first.join(second);
    second.join(first);
    this.slider = new TimeSlider(byId("compare-time"), byId("compare-time-text"), (time) => {
      this.pictures.forEach((picture) => picture.at(time));
    });
    addEventListener("resize", () => this.plots && this.plots.fit());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
  }

  async open(about, ids) {
    this.ids = ids;
    this.times = [[], []];
    this.histories = [null, null];
    this.plots = null;
    this.slider.clear();
    byId("compare-plots").replaceChildren();
    byId("compare-title").textContent = `Jobs ${ids[0]} and ${ids[1]}`;
    this.pictures.forEach((picture, i) => picture.open(ids[i]));
    await this.load();
    if (this.ids === ids) this.timer = setInterval(() => this.load(), COMPARE_EVERY);
  }

  close() {
    this.ids = null;
    clearInterval(this.timer);
    this.pictures.forEach((picture) => picture.close());
  }

  /** Takes the times of the outputs of a job. */
  know(which, times) {
    this.times[which] = times;
    this.slider.set([...new Set(this.times.flat())].sort((a, b) => a - b));
  }

  /** Reads both jobs and their histories, until both have ended. */
  async load() {
    const { ids } = this;
    const jobs = await guarded(() => Promise.all(ids.map((id) => getJson(`/api/jobs/${id}`))));
    if (!jobs || this.ids !== ids) return;
    jobs.forEach((job, i) => {
      byId(["compare-first", "compare-second"][i]).replaceChildren(element("a", `Job ${job.id}: ${job.name}`, { href: `#/job/${job.id}` }), " ", badge(job.state));
    });
    // A job that has not started has no history.
    const read = async (job) => {
      if (!job.started) return null;
      const response = await fetch(`/api/jobs/${job.id}/files/results/history.csv`);
      return response.ok ? historyRows(await response.text()) : null;
    };
    const histories = await Promise.all(jobs.map((job) => read(job).catch(() => null)));
    if (this.ids !== ids) return;
    this.histories = histories;
    this.names = jobs.map((job) => `${job.id}`);
    histories.forEach((history, i) => {
      if (!history) return;
      this.pictures[i].setUnit(history.time);
      this.slider.unit = history.time;
    });
    this.slider.label();
    this.draw();
    if (jobs.every((job) => FINAL.includes(job.state))) {
      clearInterval(this.timer);
      this.pictures.forEach((picture) => picture.finish());
    }
  }

  /** Draws the histories over the times of both. */
  draw() {
    const histories = (this.histories || []).map((history) => history || { rows: [], time: "", energy: "" });
    if (!this.ids || histories.every((history) => history.rows.length < 2)) return;
    const time = [...new Set(histories.flatMap((history) => history.rows.map((row) => row[0])))].sort((a, b) => a - b);
    const place = new Map(time.map((t, i) => [t, i]));
    const over = (history, column) => {
      const values = new Array(time.length).fill(null);
      for (const row of history.rows) values[place.get(row[0])] = row[column];
      return values;
    };
    const energy = histories.find((history) => history.rows.length).energy;
    const unit = histories.find((history) => history.rows.length).time;
    const plot = (title, column, of) => {
      const lines = histories.map((history, i) => ({ label: `job ${this.names[i]}`, values: over(history, column), spans: true }));
      return { title, unit: of, lines };
    };
    const plots = [plot("Kinetic energy", 2, energy), plot("Internal energy", 3, energy), plot("Contact work", 5, energy),
      plot("Energy error", 7), plot("Step size", 1, unit)];
    byId("compare-plots").replaceChildren();
    this.plots = new Plots(byId("compare-plots"), { time, plots, unit }, (at) => this.pictures.forEach((picture) => picture.at(at)));
    this.plots.draw(getComputedStyle(document.documentElement));
  }
}

"use strict";
// The plot workbench: any quantity of the histories, and of what is picked in the picture, over any other.

const OPERATIONS = { value: "value", integral: "integral", twice: "double integral" };

/** Fills a list with texts, and selects one of them. */
function fill(select, texts, chosen) {
  select.replaceChildren(...texts.map((text) => new Option(text, text)));
  select.value = texts.includes(chosen) ? chosen : texts[0];
}

/** Lets the user keep a file. */
function keep(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/** A field of a CSV file. */
function csvField(value) {
  const text = String(value);
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** A row of a table from texts; those of `numbers` are set as numbers. */
function tableRow(cells, name = "td") {
  const row = document.createElement("tr");
  for (const cell of cells) {
    const of = document.createElement(name);
    if (cell instanceof Node) of.append(cell);
    else of.textContent = typeof cell === "number" ? (Number.isFinite(cell) ? digits(cell, 5) : "–") : cell;
    if (typeof cell === "number") of.className = "number";
    row.append(of);
  }
  return row;
}

class Workbench {
  /** `runs` are histories with the name of their run; `go` is called with a time. */
  constructor(runs, go) {
    this.runs = runs;
    this.histories = runs[0].histories;
    this.curves = [];
    this.chart = new Chart(byId("bench-chart"), go);
    const { objects } = this.histories;
    const names = objects.map((object) => object.label);
    const lists = { of: byId("bench-object"), over: byId("bench-over-object") };
    fill(lists.of, names);
    fill(lists.over, names);
    byId("bench-object").addEventListener("change", () => this.quantities("bench-object", "bench-quantity"));
    byId("bench-over-object").addEventListener("change", () => this.quantities("bench-over-object", "bench-over"));
    fill(byId("bench-filter"), ["none", ...FILTER_CLASSES.map((c) => `CFC ${c}`)]);
    byId("bench-operation").replaceChildren(...Object.entries(OPERATIONS).map(([key, text]) => new Option(text, key)));
    byId("bench-add").addEventListener("click", () => this.add(this.chosen()));
    byId("bench-clear").addEventListener("click", () => this.clear());
    byId("bench-marks").addEventListener("change", () => this.draw());
    byId("bench-csv").addEventListener("click", () => keep("curves.csv", this.csv(), "text/csv"));
    byId("bench-svg").addEventListener("click", () => keep("curves.svg", new XMLSerializer().serializeToString(this.chart.svg), "image/svg+xml"));
    this.begin();
  }

  /** The first curve: a force over a displacement if there are both, else the kinetic energy over time. */
  begin() {
    const { objects } = this.histories;
    const force = objects.find((object) => object.kind !== "model" && magnitudeOf(object, "force"));
    const moved = movedObjects(objects)[0];
    const of = force || objects[0];
    const quantity = force ? magnitudeOf(force, "force").title : "kinetic";
    const over = force && moved ? moved : objects[0];
    byId("bench-object").value = of.label;
    this.quantities("bench-object", "bench-quantity", quantity);
    byId("bench-over-object").value = over.label;
    this.quantities("bench-over-object", "bench-over", force && moved ? magnitudeOf(moved, "displacement").title : TIME);
    this.add(this.chosen());
  }

  quantities(object, list, chosen) {
    const found = this.histories.object(byId(object).value);
    const titles = found.quantities.map((quantity) => quantity.title);
    fill(byId(list), list === "bench-over" ? [TIME, ...titles] : titles, chosen);
  }

  /** What the controls say. */
  chosen() {
    const value = (id) => byId(id).value;
    return {
      object: value("bench-object"),
      quantity: value("bench-quantity"),
      overObject: value("bench-over-object"),
      over: value("bench-over"),
      filter: value("bench-filter"),
      operation: value("bench-operation"),
    };
  }

  say(words) {
    byId("bench-words").textContent = words;
    byId("bench-words").hidden = !words;
  }

  /** Adds a curve of each run that has the quantities. */
  add(asked) {
    this.say("");
    try {
      for (const run of this.runs) {
        const curve = this.curve(run, asked);
        if (curve) this.curves.push(curve);
      }
    } catch (error) {
      this.say(error.message);
    }
    this.draw();
  }

  /** Adds a curve over time from outside of the histories. */
  addCourse(label, unit, time, values) {
    this.say("");
    const { x, y } = withoutGaps(time, values);
    if (!x.length) return this.say(`${label} has no values.`);
    this.curves.push({ label, x, y, time: x, units: { x: this.histories.timeUnit, y: unit }, titles: { x: TIME, y: label }, dash: false });
    this.draw();
  }

  curve({ name, histories }, asked) {
    const quantity = histories.quantity(histories.object(asked.object), asked.quantity);
    const over = histories.quantity(histories.object(asked.overObject), asked.over);
    if (!quantity || !over) return null;
    const of = withoutGaps(histories.time, quantity.values);
    if (!of.x.length) throw new Error(`${asked.quantity} of ${asked.object} has no values.`);
    let [unit, words, y] = [quantity.unit, quantity.title, of.y];
    const filterClass = Number(asked.filter.split(" ")[1]);
    if (filterClass) {
      const seconds = secondsOf(histories);
      y = filtered(of.x, y, filterClass, seconds);
      words += `, ${asked.filter}`;
      if (!closeEnough(of.x, filterClass, seconds)) {
        this.say(`SAE J211-1 asks for ${ROWS_PER_PERIOD * filterClass} rows per second for CFC ${filterClass}; this history has fewer.`);
      }
    }
    for (let i = 0; i < { value: 0, integral: 1, twice: 2 }[asked.operation]; i++) {
      y = integral(of.x, y);
      unit = unit && `${unit} ${histories.timeUnit}`;
    }
    if (asked.operation !== "value") words = `${OPERATIONS[asked.operation]} of ${words}`;
    const both = withoutGaps(Float64Array.from(of.kept, (row) => over.values[row]), y);
    const time = Float64Array.from(both.kept, (i) => of.x[i]);
    const overWords = over.title === TIME ? TIME : `${over.title} of ${asked.overObject}`;
    const label = `${words} of ${asked.object}${over.title === TIME ? "" : ` over ${overWords}`}${name ? ` (${name})` : ""}`;
    return { label, x: both.x, y: both.y, time, units: { x: over.unit, y: unit }, titles: { x: overWords, y: words }, dash: this.runs.length > 1 && name === this.runs[1].name, asked };
  }

  clear() {
    this.curves = [];
    this.say("");
    this.draw();
  }

  draw() {
    const withMarks = byId("bench-marks").checked;
    const shown = this.curves.map((curve, i) => {
      const marks = { peak: peakOf(curve.y), mean: meanOf(curve.x, curve.y) };
      return { ...curve, colour: `--c${1 + (i % 7)}`, figures: marks, marks: withMarks && marks };
    });
    const axis = (which) => [...new Set(this.curves.map((curve) => withUnit(curve.titles[which], curve.units[which])))].join(", ");
    this.chart.show(shown, { x: axis("x"), y: axis("y") });
    const body = byId("bench-curves").tBodies[0];
    body.replaceChildren(...shown.map((curve, i) => this.row(curve, i)));
    byId("bench-curves").hidden = !shown.length;
  }

  row({ label, colour, x, y, units, figures }, i) {
    const name = document.createElement("span");
    const chip = document.createElement("span");
    chip.className = "chip";
    chip.style.background = `var(${colour})`;
    const remove = document.createElement("button");
    remove.type = "button";
    remove.className = "remove";
    remove.textContent = "×";
    remove.setAttribute("aria-label", `Remove ${label}`);
    name.append(remove, chip, label);
    remove.addEventListener("click", () => {
      this.curves.splice(i, 1);
      this.draw();
    });
    const [low, high] = y.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    const sum = integral(x, y);
    return tableRow([name, y[figures.peak], x[figures.peak], figures.mean, low, high, sum[sum.length - 1], units.y, units.x]);
  }

  /** The curves as a table: for each its points, then a blank line. */
  csv() {
    const of = ({ label, titles, units, time, x, y }) => {
      const head = [withUnit(TIME, this.histories.timeUnit), withUnit(titles.x, units.x), withUnit(label, units.y)];
      const rows = Array.from(x, (_, i) => [time[i], x[i], y[i]].join(","));
      return [head.map(csvField).join(","), ...rows].join("\n");
    };
    return `${this.curves.map(of).join("\n\n")}\n`;
  }
}

"use strict";
// Tables of crush figures, and of head injury criteria.

class Figures {
  /** `runs` are histories with the name of their run. The lists have what the first one has. */
  constructor(runs) {
    this.runs = runs;
    const { objects } = runs[0].histories;
    const accelerated = (object) => magnitudeOf(object, "acceleration");
    fill(byId("crush-over"), movedObjects(objects).map((object) => object.label));
    fill(byId("crush-direction"), ["magnitude", "x", "y", "z"]);
    fill(byId("crush-mass"), ["all parts", ...partsOf(objects).map((object) => object.label)]);
    fill(byId("crush-filter"), ["none", ...FILTER_CLASSES.map((c) => `CFC ${c}`)]);
    fill(byId("head-filter"), ["CFC 1000", "none"]);
    for (const id of ["crush-over", "crush-direction", "crush-mass", "crush-filter"]) byId(id).addEventListener("change", () => this.crush());
    byId("head-filter").addEventListener("change", () => this.head());
    byId("crush").hidden = !forcesOf(objects).length;
    byId("head").hidden = !objects.some(accelerated);
    byId("crush-csv").addEventListener("click", () => keep("crush.csv", tableCsv(byId("crush-table")), "text/csv"));
    this.crush();
    this.head();
  }

  /** Values after the filter that a list selects. Throws if it does not suit the history. */
  after(filter, histories, time, values) {
    const filterClass = Number(filter.split(" ")[1]);
    return filterClass ? filtered(time, values, filterClass, secondsOf(histories)) : values;
  }

  /** Mass of the chosen parts at the start. */
  mass(histories) {
    const name = byId("crush-mass").value;
    const chosen = partsOf(histories.objects).filter(({ label }) => name === "all parts" || label === name);
    return chosen.map((object) => histories.quantity(object, "mass")).reduce((sum, mass) => sum + mass.values[0], 0);
  }

  /** Rows of the crush table of a run, and the units of their columns. */
  crushOf({ name, histories }) {
    const direction = byId("crush-direction").value;
    const over = histories.object(byId("crush-over").value);
    const mass = this.mass(histories);
    const rows = [];
    let units = {};
    for (const object of forcesOf(histories.objects)) {
      const force = component(histories, object, "force", direction);
      const moved = over && component(histories, over, "displacement", direction);
      const { x: time, y: values, kept } = withoutGaps(histories.time, force.values);
      if (!time.length) continue;
      const y = this.after(byId("crush-filter").value, histories, time, values);
      const x = moved ? Float64Array.from(kept, (row) => moved.values[row]) : new Float64Array(y.length).fill(NaN);
      const figures = crushOf(x, y);
      const specific = mass > 0 ? figures.energy / mass : NaN;
      rows.push([labelOf(object, name), figures.peak, figures.at, figures.mean, figures.efficiency, figures.stroke, figures.energy, specific]);
      units = { force: force.unit, length: moved?.unit };
    }
    // In consistent units, force times length has the unit of the energies.
    units.energy = histories.quantity(histories.objects[0], "kinetic")?.unit;
    units.mass = histories.quantity(partsOf(histories.objects)[0], "mass")?.unit;
    return { rows, units };
  }

  crush() {
    let found = [];
    let words = byId("crush-over").value ? "" : "There is no displacement: request one by [[output.node]], or let a wall or a rigid part move.";
    try {
      found = this.runs.map((run) => this.crushOf(run));
    } catch (error) {
      words = error.message;
    }
    byId("crush-words").textContent = words;
    const { force, length, energy, mass } = found[0]?.units ?? {};
    const specific = energy && mass ? `${energy}/${mass}` : "";
    const head = ["force", withUnit("peak", force), withUnit("at displacement", length), withUnit("mean", force), "mean/peak",
      withUnit("stroke", length), withUnit("absorbed energy", energy), withUnit("specific energy", specific)];
    byId("crush-table").tHead.replaceChildren(tableRow(head, "th"));
    byId("crush-table").tBodies[0].replaceChildren(...found.flatMap(({ rows }) => rows.map((row) => tableRow(row))));
  }

  /** Accelerations of the nodes of a run after the filter, in g, over times in seconds. */
  accelerations({ name, heads, histories }) {
    const out = [];
    // The name of a node is that of its group and its id.
    const isHead = (object) => heads.some((group) => object.name.slice(0, object.name.lastIndexOf(" ")) === group);
    for (const object of histories.objects.filter(isHead)) {
      const quantity = magnitudeOf(object, "acceleration");
      if (!quantity) continue;
      const [seconds, unit] = [secondsOf(histories), accelerationUnit(quantity.unit)];
      if (!unit) throw new Error(NO_UNITS);
      const { x, kept } = withoutGaps(histories.time, quantity.values);
      if (x.length < 2) continue;
      // Each channel is filtered, and the criterion takes the resultant.
      const channel = (axis) => Float64Array.from(kept, (row) => component(histories, object, "acceleration", axis).values[row]);
      const axes = ["x", "y", "z"].map((axis) => this.after(byId("head-filter").value, histories, x, channel(axis)));
      const values = x.map((_, i) => (Math.hypot(...axes.map((values) => values[i])) * unit) / GRAVITY);
      out.push({ label: labelOf(object, name), time: x.map((t) => t * seconds), values, peak: values[peakOf(values)] });
    }
    return out;
  }

  head() {
    let [all, words] = [[], ""];
    try {
      all = this.runs.flatMap((run) => this.accelerations(run));
    } catch (error) {
      words = error.message;
    }
    const recorded = this.runs.some(({ histories }) => histories.objects.some((object) => magnitudeOf(object, "acceleration")));
    if (!words && recorded && !all.length) words = "No node is marked as a head: set head = true in its [[output.node]].";
    const shown = all.sort((a, b) => b.peak - a.peak).slice(0, MOST_HEADS);
    if (shown.length < all.length) words = `The ${shown.length} nodes with the largest accelerations of ${all.length}.`;
    byId("head-words").textContent = words;
    const row = ({ label, time, values, peak }) => {
      const found = HEAD_WINDOWS.map((window) => headInjury(time, values, window / 1000));
      const interval = ({ from, to }) => `${digits(1000 * from, 4)} to ${digits(1000 * to, 4)}`;
      return tableRow([label, peak, found[0].value, interval(found[0]), found[1].value, interval(found[1])]);
    };
    byId("head-table").tBodies[0].replaceChildren(...shown.map(row));
  }
}

/** Maximum number of nodes in the table of head injury criteria: the search of intervals takes time. */
const MOST_HEADS = 10;
const partsOf = (objects) => objects.filter((object) => object.kind === "part");
/** The objects with a force that acts. */
const forcesOf = (objects) => objects.filter((object) => object.kind !== "model" && magnitudeOf(object, "force")?.values.some((force) => force > 0));
/** Name of an object in a table of one or two runs. */
const labelOf = (object, run) => (run ? `${object.label} (${run})` : object.label);

/** A component of a vector of an object, or its magnitude. */
function component(histories, object, word, direction) {
  const whole = magnitudeOf(object, word);
  if (direction === "magnitude") return whole;
  return histories.quantity(object, whole.title.replace(" (magnitude)", ` ${direction}`));
}

/** A table as CSV. */
function tableCsv(table) {
  return `${[...table.rows].map((row) => [...row.cells].map((cell) => csvField(cell.textContent)).join(",")).join("\n")}\n`;
}

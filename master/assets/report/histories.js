"use strict";
// All histories of the run: objects (the model, parts, walls, nodes, ...) with quantities over time.

/** Name of the time in lists of quantities. */
const TIME = "time";
/** Kind of the mass centres of rigid parts, whose displacement follows from their momentum. */
const MASS_CENTRE = "mass centre of part";

class Histories {
  /** `bytes` are unpacked; `about` describes them, and has the unit of the time. */
  constructor(bytes, about, timeUnit) {
    const read = new Columns(bytes);
    const floats = () => new Float32Array(read.chain(about.rows).buffer);
    const words = [read.chain(about.rows), read.chain(about.rows)];
    const whole = new Uint32Array(2 * about.rows);
    for (let i = 0; i < about.rows; i++) whole.set([words[0][i], words[1][i]], 2 * i);
    this.time = new Float64Array(whole.buffer);
    this.timeUnit = timeUnit;
    this.objects = about.objects.map(({ kind, name, quantities }) => {
      const all = quantities.map(([title, unit]) => ({ title, unit, values: floats() }));
      return { kind, name, label: kind === "model" ? "model" : `${kind} ${name}`, quantities: [...all, ...magnitudes(all)] };
    });
  }

  object(label) {
    return this.objects.find((object) => object.label === label);
  }

  /** A quantity of an object by its title; the time for every object. */
  quantity(object, title) {
    if (title === TIME) return { title: TIME, unit: this.timeUnit, values: this.time };
    return object?.quantities.find((quantity) => quantity.title === title);
  }
}

/** The lengths of the vectors among columns whose names end in x, y and z. */
function magnitudes(quantities) {
  const out = [];
  quantities.forEach(({ title, unit, values: x }, i) => {
    const name = title.endsWith(" x") ? title.slice(0, -2) : null;
    const [y, z] = [quantities[i + 1], quantities[i + 2]];
    if (!name || y?.title !== `${name} y` || z?.title !== `${name} z`) return;
    out.push({ title: `${name} (magnitude)`, unit, values: x.map((a, row) => Math.hypot(a, y.values[row], z.values[row])) });
  });
  return out;
}

/** The length of a vector whose name ends in a word; nothing if the object has none. */
function magnitudeOf(object, word) {
  return object.quantities.find(({ title }) => title.endsWith(`${word} (magnitude)`));
}

/**
 * The objects that move: those with a recorded displacement first, then mass centres; each the farthest first. A wall is the first of all, unless another
 * recorded displacement is more than twice as large: a node of a fold can move farther than the wall that crushes it.
 */
function movedObjects(objects) {
  const far = (object) => magnitudeOf(object, "displacement").values.reduce((most, u) => (u > most ? u : most), 0);
  const all = objects.filter((object) => magnitudeOf(object, "displacement")).map((object) => [far(object), object]);
  const derived = ({ kind }) => Number(kind === MASS_CENTRE);
  const moved = all.filter(([most]) => most > 0).sort((a, b) => derived(a[1]) - derived(b[1]) || b[0] - a[0]);
  const wall = moved.findIndex(([most, { kind }]) => kind === "wall" && 2 * most >= moved[0][0]);
  if (wall > 0) moved.unshift(...moved.splice(wall, 1));
  return moved.map(([, object]) => object);
}

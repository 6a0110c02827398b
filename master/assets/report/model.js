"use strict";
// The page of a job before its run: values of elements and nodes as colours, conditions and sets as marks, findings as
// lists. model_page/columns.rs and model_page/conditions.rs define the format of the bytes.

/** Colours of conditions, in their order. */
const MARK_COLOURS = ["#d62728", "#1f6fb4", "#2b8a3e", "#8b51a8", "#e07b00", "#a8820c", "#1593a5", "#b83a6b"];
const SET_COLOUR = "#ff00c8";
/** Diameter of a mark [pixels of the page], and size of the arrows against those of forces. */
const MARK = { size: 7, arrow: 0.4 };

const MARK_VERTEX = `
uniform float size;
void main() {
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_Position.z -= 1e-3 * gl_Position.w;
  gl_PointSize = size;
}`;
// A disc with a white rim, which is seen on all colours.
const MARK_FRAGMENT = `
uniform vec3 colour;
void main() {
  float far = length(2.0 * gl_PointCoord - 1.0);
  if (far > 1.0) discard;
  gl_FragColor = vec4(mix(colour, vec3(1.0), step(0.75, far)), 1.0);
}`;

/** The values, sets and marks of a model. */
function decodeSetup(bytes, model, setup) {
  const read = new Columns(bytes);
  const floats = (count) => new Float32Array(read.chain(count).buffer);
  const scalars = setup.scalars.map((about) => ({ ...about, values: floats(model.elements) }));
  const nodeScalars = setup.node_scalars.map((about) => ({ ...about, values: floats(model.nodes) }));
  const sets = setup.sets.map((about) => ({ ...about, nodes: read.chain(about.marks) }));
  const conditions = setup.conditions.map((about) => {
    if (about.form === "nodes") return { ...about, nodes: read.chain(about.marks) };
    return { ...about, columns: Array.from({ length: about.form === "arrows" ? 6 : 3 }, () => floats(about.marks)) };
  });
  if (read.at !== bytes.length) throw new Error(`the model has ${bytes.length} bytes, but needs ${read.at}`);
  return { scalars, nodeScalars, sets, conditions };
}

/** Discs at some points of the picture, or arrows. */
class Marks {
  constructor(view, colour) {
    const rgbOf = rgb(colour).map((c) => c / 255);
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const uniforms = { size: { value: MARK.size * ratio }, colour: { value: new THREE.Vector3(...rgbOf) } };
    const discs = new THREE.ShaderMaterial({ vertexShader: MARK_VERTEX, fragmentShader: MARK_FRAGMENT, uniforms });
    this.discs = new THREE.Points(new THREE.BufferGeometry(), discs);
    this.lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: toHex(rgb(colour)) }));
    for (const object of [this.discs, this.lines]) {
      object.frustumCulled = false;
      object.visible = false;
      view.scene.add(object);
    }
  }

  /** Shows discs at these points, or the lines between each two of them. */
  put(object, points) {
    object.geometry.dispose(); // the buffer of the last time
    object.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    object.geometry.setDrawRange(0, points.length / 3);
  }

  show(on) {
    for (const object of [this.discs, this.lines]) object.visible = on && object.geometry.getAttribute("position")?.count > 0;
  }
}

/** A cell of a table, with text or with a control. */
function cellOf(content) {
  const cell = document.createElement("td");
  cell.append(content);
  return cell;
}

/** Fills a table. A row has texts and controls. */
function fillTable(id, rows) {
  const made = rows.map((cells) => {
    const row = document.createElement("tr");
    row.append(...cells.map(cellOf));
    return row;
  });
  byId(id).tBodies[0].replaceChildren(...made);
}

class ModelPage extends Page {
  /** Before the run there are no histories. */
  plotted() {}

  async histories() {}

  whyNoPicture() {
    return this.facts.setup.why;
  }

  async picture() {
    if (!this.facts.model) {
      byId("conditions").hidden = true;
      throw new Error(this.whyNoPicture());
    }
    const packed = byId("packed-setup");
    this.setup = decodeSetup(await unpacked(packed.textContent), this.facts.model, this.facts.setup);
    packed.remove();
    await super.picture();
  }

  colourings() {
    const { model, setup } = this;
    const part = colourings(model, this.facts).find((way) => way.title === "part");
    const names = [...new Set(model.parts.map((id) => this.facts.setup.materials[id]))];
    const kinds = names.map((label, i) => ({ colour: ofKind(i), label }));
    const materials = model.parts.map((id) => kinds[names.indexOf(this.facts.setup.materials[id])]);
    const material = { title: "material", kinds, colour: (_, element) => materials[model.part[element]].colour };
    const ofElements = setup.scalars.map(({ values, ...about }) => ({ ...about, value: (_, element) => values[element] }));
    const ofNodes = setup.nodeScalars.map(({ values, ...about }) => ({ ...about, node: (_, node) => values[node] }));
    const ways = [...ofElements, ...ofNodes].filter((way) => way.range).map((way) => this.scaledWay(way));
    return [part, material, ...ways];
  }

  /** A way with a scale. Where small values are the bad ones, it begins at the smallest one. */
  scaledWay({ worst_low, ...about }) {
    const way = scaled(this.model, { ...about, worstLow: worst_low });
    if (worst_low && way.range[1] > way.range[0]) {
      // Four digits, rounded outwards.
      const short = (value, away) => Number((value * (1 + 5e-4 * away)).toPrecision(4));
      [way.low, way.top] = [short(way.least, -1), short(Math.min(way.top, way.most), 1)];
    }
    if (!(way.top > way.low)) way.top = way.low + 1;
    return way;
  }

  more() {
    this.marks = this.setup.conditions.map((condition, i) => {
      const marks = new Marks(this.view, MARK_COLOURS[i % MARK_COLOURS.length]);
      if (condition.form === "nodes") marks.put(marks.discs, this.pointsOf(condition.nodes));
      if (condition.form === "spots") marks.put(marks.discs, spotsOf(condition.columns));
      return marks;
    });
    this.sized();
    this.conditions();
    this.sets();
    this.findings();
  }

  /** Coordinates of nodes of the picture. */
  pointsOf(nodes) {
    const { grid, position } = this.model.frames[0];
    return Array.from(nodes).flatMap((n) => [0, 1, 2].map((c) => grid.origin[c] + grid.unit * position[c][n]));
  }

  /** Draws the arrows, each condition by its largest one. */
  sized() {
    const { low, high } = this.view.boxes[0];
    const size = MARK.arrow * ARROW.length * Number(byId("arrow-size").value) * Math.hypot(...low.map((a, c) => high[c] - a));
    this.setup.conditions.forEach(({ form, marks, columns }, i) => {
      if (form !== "arrows") return;
      const vectors = Array.from({ length: marks }, (_, k) => columns.map((column) => column[k]));
      const most = vectors.reduce((m, v) => Math.max(m, Math.hypot(...v.slice(3))), 0);
      const points = vectors.flatMap((v) => {
        const along = new THREE.Vector3(...v.slice(3));
        return along.length() > 0 ? arrow(new THREE.Vector3(...v.slice(0, 3)), along.multiplyScalar(size / most)) : [];
      });
      this.marks[i].put(this.marks[i].lines, points);
      this.marks[i].show(this.setup.conditions[i].on);
    });
  }

  go(time) {
    super.go(time);
    byId("clock").textContent = "before the run";
  }

  /** The list of conditions, with a box for each. */
  conditions() {
    const { conditions } = this.setup;
    this.boxes = conditions.map((condition, i) => {
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: condition.on, className: "condition" });
      box.setAttribute("aria-label", `${condition.title} ${condition.detail}`);
      box.addEventListener("change", () => this.showCondition(i, box.checked));
      this.marks[i].show(condition.on);
      return box;
    });
    fillTable("conditions-table", conditions.map(({ title, detail, count }, i) => {
      const name = document.createElement("span");
      const chip = Object.assign(document.createElement("span"), { className: "chip" });
      chip.style.background = MARK_COLOURS[i % MARK_COLOURS.length];
      name.append(chip, title);
      return [this.boxes[i], name, detail, String(count)];
    }));
    if (!conditions.length) byId("conditions-words").textContent = "The job has no boundary conditions, initial velocities or loads.";
    const all = (on) => conditions.forEach((_, i) => this.showCondition(i, on));
    byId("conditions-all").addEventListener("click", () => all(true));
    byId("conditions-none").addEventListener("click", () => all(false));
    byId("arrow-size").addEventListener("input", () => {
      this.sized();
      this.view.draw();
    });
  }

  showCondition(i, on) {
    this.setup.conditions[i].on = on;
    this.boxes[i].checked = on;
    this.marks[i].show(on);
    if (this.setup.conditions[i].form === "spots") byId("limiting-marks").checked = on;
    this.view.draw();
  }

  /** The node sets: one can be highlighted. */
  sets() {
    const { sets } = this.setup;
    byId("sets").hidden = !sets.length;
    const highlight = new Marks(this.view, SET_COLOUR);
    const select = byId("set");
    select.add(new Option("none", ""));
    sets.forEach(({ name }, i) => select.add(new Option(name, i)));
    select.addEventListener("change", () => {
      const set = sets[select.value];
      highlight.put(highlight.discs, set ? this.pointsOf(set.nodes) : []);
      highlight.show(Boolean(set));
      const hidden = set && set.count - set.nodes.length;
      byId("set-words").textContent = set ? `${set.count} nodes${hidden ? `, ${hidden} of them inside` : ""}` : "";
      this.view.draw();
    });
    this.highlight = highlight;
  }

  /** The elements with the smallest steps and the initial penetrations, each with a button that shows it. */
  findings() {
    const { limiting, penetrations } = this.facts.setup;
    const { time_unit: time, length_unit: length, part_names: names } = this.facts;
    const part = (id) => (names[id] ? `${id} ${names[id]}` : String(id));
    const show = (kind, id) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: "Show", className: "show" });
      button.addEventListener("click", () => {
        this.find(kind, id);
        byId("picture").scrollIntoView({ block: "nearest" });
      });
      return button;
    };
    byId("limiting").hidden = !limiting.length;
    fillTable("limiting-table", limiting.map((row) => [show("element", row.element), String(row.element), part(row.part), `${digits(row.step, 5)} ${time}`.trim(), digits(row.ratio, 4)]));
    const spots = this.setup.conditions.findIndex(({ form }) => form === "spots");
    byId("limiting-marks").addEventListener("change", () => this.showCondition(spots, byId("limiting-marks").checked));
    byId("penetrations").hidden = !penetrations.count;
    const { count, rows } = penetrations;
    byId("penetrations-words").textContent = count > rows.length ? `${count} nodes; the ${rows.length} deepest are listed.` : `${count} nodes.`;
    const acts = ({ unseen }) => (unseen ? "does not see it" : "tolerates it");
    fillTable("penetrations-table", rows.map((row) => [show("node", row.node), String(row.node), String(row.element), part(row.part), `${digits(row.depth)} ${length}`.trim(), acts(row)]));
  }

  /** All values of the element and the node that are picked, the conditions and the sets of the node. */
  dataOfPicked() {
    const { picker, setup } = this;
    const rows = super.dataOfPicked().filter(([name]) => !this.ways.some((way) => !way.kinds && way.title === name));
    const value = ({ title, unit, values }, at) => (Number.isFinite(values[at]) ? [[title, `${digits(values[at], 5)} ${unit}`.trim()]] : []);
    if (picker.element >= 0) {
      rows.push(["material", this.facts.setup.materials[this.model.parts[this.model.part[picker.element]]]]);
      rows.push(...setup.scalars.flatMap((scalar) => value(scalar, picker.element)));
    }
    if (picker.node >= 0) {
      rows.push(...setup.nodeScalars.flatMap((scalar) => value(scalar, picker.node)));
      const of = (list) => list.filter(({ nodes }) => nodes?.includes(picker.node));
      const conditions = of(setup.conditions).map(({ title }) => title);
      const sets = of(setup.sets).map(({ name }) => name);
      if (conditions.length) rows.push(["conditions of the node", conditions.join(", ")]);
      if (sets.length) rows.push(["sets of the node", sets.join(", ")]);
    }
    return rows;
  }
}

/** Coordinates of points in columns. */
function spotsOf(columns) {
  return Array.from(columns[0]).flatMap((_, i) => columns.map((column) => column[i]));
}

"use strict";
// Colours of values and of categories.

/** From metal grey to dark red, evenly spaced: a darker colour is a larger value, also for colour-blind readers. */
const SCALE = [
  [206, 212, 217], [236, 217, 160], [245, 180, 92], [235, 130, 62], [208, 78, 57], [165, 36, 62], [104, 12, 62],
];
const NOTHING = [120, 130, 150];
/** For the first categories: distinct for all types of colour vision (M. Okabe and K. Ito, 2008). */
const KINDS = [
  [0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66], [120, 120, 120],
];
const CLASSES = ["interior", "interface", "exterior"];

/** The colour of a fraction between 0 and 1. */
function onScale(fraction) {
  const place = Math.min(Math.max(fraction, 0), 1) * (SCALE.length - 1);
  const low = Math.min(Math.floor(place), SCALE.length - 2);
  return SCALE[low].map((c, i) => Math.round(c + (place - low) * (SCALE[low + 1][i] - c)));
}

/** The colours of a way from its low to its high end. */
function scaleOf(way) {
  return way.worstLow ? SCALE.toReversed() : SCALE;
}

/** A colour for each category: after the first eight, hues at the golden angle. */
function ofKind(number) {
  if (number < KINDS.length) return KINDS[number];
  const hue = (number * 137.508) % 360;
  const light = number % 2 ? 0.45 : 0.62;
  const channel = (n) => {
    const k = (n + hue / 30) % 12;
    return Math.round(255 * (light - 0.6 * Math.min(light, 1 - light) * Math.max(-1, Math.min(k - 3, 9 - k, 1))));
  };
  return [channel(0), channel(8), channel(4)];
}

function css(colour) {
  return `rgb(${colour.join(",")})`;
}

/** A number with this many digits, with an exponent if there would be many zeros. */
function digits(value, count = 4) {
  const short = Number(value.toPrecision(count));
  const size = Math.abs(short);
  return size > 0 && (size < 1e-4 || size >= 1e6) ? short.toExponential() : String(short);
}

/** Rounds up to 1, 2, 2.5 or 5 times a power of ten. */
function roundUp(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return Number(([1, 2, 2.5, 5, 10].find((f) => f * power >= value * (1 - 1e-9)) * power).toPrecision(6));
}

/**
 * Ways to colour the model. Each has a title, `colour(frame, element)`, which returns bytes, and either `low` and `top`,
 * the ends of its scale, with `value(frame, element)` and `paint(value)`, or `kinds`, the list for the legend. A quantity
 * of nodes has `node(frame, node)` in place of `value`.
 */
function colourings(model, facts) {
  const ways = [];
  const moves = model.frames.length > 1; // else there is no change to show
  const decoded = ([least, most]) => (number) => (number === NO_VALUE ? NaN : least + (number / (NO_VALUE - 1)) * (most - least));
  facts.scalars.forEach((scalar, s) => {
    const range = model.ranges[s];
    if (!range) return;
    const value = decoded(range);
    ways.push(scaled(model, { ...scalar, range, value: (frame, element) => value(frame.scalars[s][element]) }));
    if (scalar.title === "thickness" && moves) ways.push(thicknessChange(model, ways[ways.length - 1]));
  });
  if (moves) ways.push(displacementOf(model, facts.length_unit));
  facts.node_scalars.forEach((scalar, s) => {
    const range = model.node_ranges[s];
    const value = range && decoded(range);
    if (range) ways.push(scaled(model, { ...scalar, range, node: (frame, node) => value(frame.nodeScalars[s][node]) }));
  });
  if (model.forces.some((acting) => acting > 0)) ways.push(contactForceOf(model, facts.force_unit));
  const parts = model.parts.map((id, i) => {
    const name = facts.part_names[id];
    return { colour: ofKind(i), label: name ? `${id} ${name}` : `part ${id}`, part: i };
  });
  ways.push({ title: "part", kinds: parts, colour: (_, element) => parts[model.part[element]].colour });
  const workers = model.frames.reduce((most, f) => f.worker.reduce((a, b) => Math.max(a, b), most), 0) + 1;
  const ofWorkers = Array.from({ length: workers }, (_, i) => ({ colour: ofKind(i), label: `worker ${i}` }));
  ways.push({ title: "worker", kinds: ofWorkers, colour: (frame, element) => ofWorkers[frame.worker[element]].colour });
  const classes = CLASSES.map((label, i) => ({ colour: ofKind(i), label }));
  const ofClass = (frame, element) => (classes[frame.state[element] - 1] || { colour: NOTHING }).colour;
  ways.push({ title: "element class", kinds: classes.slice(0, 2), colour: ofClass });
  return ways;
}

/** A way with a scale: from 0, or from below it where values are negative. */
function scaled(model, way) {
  const [least, most] = way.range;
  const usual = usualOf(model, way);
  way.most = most;
  way.least = least;
  way.top = roundUp(usual[1] > 0 ? usual[1] : most);
  way.low = least < 0 ? -roundUp(usual[0] < 0 ? -usual[0] : -least) : 0;
  way.paint = (v) => (Number.isNaN(v) ? NOTHING : onScale((way.worstLow ? way.top - v : v - way.low) / (way.top - way.low || 1)));
  if (way.value) way.colour = (frame, element) => way.paint(way.value(frame, element));
  return way;
}

/** Change of the thickness since the first time of an element. */
function thicknessChange(model, thickness) {
  const first = Float32Array.from({ length: model.elements }, (_, e) => {
    const frame = model.frames.find((f) => f.state[e]);
    return frame ? thickness.value(frame, e) : NaN;
  });
  const value = (frame, element) => 100 * (thickness.value(frame, element) / first[element] - 1);
  return scaled(model, { title: "thickness change", unit: "%", value, range: rangeOfElements(model, value) });
}

/** Lowest and highest value of the elements that exist, over all times. */
function rangeOfElements(model, value) {
  let [low, high] = [0, 0];
  for (const frame of model.frames) {
    for (let e = 0; e < model.elements; e++) {
      const v = frame.state[e] ? value(frame, e) : NaN;
      if (v < low) low = v;
      if (v > high) high = v;
    }
  }
  return [low, high];
}

/** Displacement of the nodes since the first time of the page. */
function displacementOf(model, unit) {
  const place = (frame, node, c) => frame.grid.origin[c] + frame.grid.unit * frame.position[c][node];
  const [first] = model.frames;
  const node = (frame, number) => {
    let sum = 0;
    for (let c = 0; c < 3; c++) sum += (place(frame, number, c) - place(first, number, c)) ** 2;
    return Math.sqrt(sum);
  };
  let most = 0;
  for (const frame of model.frames) for (let n = 0; n < model.nodes; n++) most = Math.max(most, node(frame, n));
  return scaled(model, { title: "displacement", unit, node, range: [0, most] });
}

/** Magnitude of the contact force of the nodes; 0 where none acts. */
function contactForceOf(model, unit) {
  const size = ({ components: [x, y, z] }, i) => Math.hypot(x[i], y[i], z[i]);
  const most = model.frames.reduce((all, { forces }) => forces.nodes.reduce((m, _, i) => Math.max(m, size(forces, i)), all), 0);
  let last = {};
  // Few nodes touch: values of all nodes are made for the frame that is shown.
  const values = (frame) => {
    if (last.frame === frame) return last.values;
    last = { frame, values: new Float32Array(model.nodes) };
    frame.forces.nodes.forEach((node, i) => (last.values[node] = size(frame.forces, i)));
    return last.values;
  };
  const way = scaled(model, { title: "contact force", unit, node: (frame, number) => values(frame)[number], range: [0, most] });
  way.top = roundUp(most); // few nodes touch, so that a percentile says nothing
  return way;
}

/** 5th and 95th percentile at the last time, so that a few torn elements do not spoil the scale. */
function usualOf(model, way) {
  const last = model.frames[model.frames.length - 1];
  const count = way.node ? model.nodes : model.elements;
  const values = Float32Array.from({ length: count }, (_, i) => (way.node ? way.node(last, i) : last.state[i] ? way.value(last, i) : NaN));
  const there = values.filter((v) => !Number.isNaN(v)).sort();
  return there.length ? [0.05, 0.95].map((share) => there[Math.floor(share * (there.length - 1))]) : [0, 0];
}

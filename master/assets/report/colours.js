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
 * Ways to colour the model. Each has a title, `colour(frame, element)`, which returns bytes, and either `top`, the end
 * of its scale, or `kinds`, the list for the legend.
 */
function colourings(model, facts) {
  const ways = [];
  facts.scalars.forEach((scalar, s) => {
    const range = model.ranges[s];
    if (!range) return;
    const low = Math.min(range[0], 0);
    const value = (number) => range[0] + (number / (NO_VALUE - 1)) * (range[1] - range[0]);
    const way = { title: scalar.title, unit: scalar.unit, low, most: range[1], top: roundUp(usual(model, s, value) || range[1]) };
    way.value = (frame, element) => {
      const number = frame.scalars[s][element];
      return number === NO_VALUE ? NaN : value(number);
    };
    way.colour = (frame, element) => {
      const v = way.value(frame, element);
      return Number.isNaN(v) ? NOTHING : onScale((v - low) / (way.top - low || 1));
    };
    ways.push(way);
  });
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

/** 95th percentile of the elements at the last time, so that a few torn elements do not spoil the scale. */
function usual(model, s, value) {
  const last = model.frames[model.frames.length - 1];
  const there = last.scalars[s].filter((number, e) => number !== NO_VALUE && last.state[e]).sort();
  return there.length ? value(there[Math.floor(0.95 * (there.length - 1))]) : 0;
}

"use strict";
// Numbers from curves: filters of crash tests, integrals, peaks, means, crush figures and head injury criteria.
// A curve is two arrays of equal length, `x` and `y`, without gaps; `x` of curves over time ascends.

/** Channel frequency classes of SAE J211-1; the number is the upper end of the pass band [Hz]. */
const FILTER_CLASSES = [60, 180, 600, 1000];
/** Rows per period of the class that SAE J211-1 asks for. */
const ROWS_PER_PERIOD = 10;
/** Seconds per unit of time, metres per unit of length. */
const SECONDS = { s: 1, ms: 1e-3, us: 1e-6, "µs": 1e-6, μs: 1e-6 };
const METRES = { m: 1, cm: 1e-2, mm: 1e-3, in: 0.0254, ft: 0.3048 };
/** Standard gravity [m/s^2]. */
const GRAVITY = 9.80665;
/** Longest windows of the head injury criteria [ms]. */
const HEAD_WINDOWS = [15, 36];
/** Mirrored points at each end of a filtered signal, in periods of the class. Over four, a transient falls to 1e-15. */
const RUN_IN = 4;

/** The points of a curve at which both values are finite. */
function withoutGaps(x, y) {
  const kept = [];
  for (let i = 0; i < x.length; i++) if (Number.isFinite(x[i]) && Number.isFinite(y[i])) kept.push(i);
  return { x: Float64Array.from(kept, (i) => x[i]), y: Float64Array.from(kept, (i) => y[i]), kept };
}

/** Value of a curve at a place, linear between its points. `from` is a point that is not beyond the place. */
function valueAt(x, y, place, from = 0) {
  let i = from;
  while (i < x.length - 2 && x[i + 1] < place) i++;
  if (x.length < 2) return y[0];
  const span = x[i + 1] - x[i];
  const share = span > 0 ? (place - x[i]) / span : 0;
  return y[i] + share * (y[i + 1] - y[i]);
}

/** The values of a curve at ascending places. */
function valuesAt(x, y, places) {
  let i = 0;
  return Float64Array.from(places, (place) => {
    while (i < x.length - 2 && x[i + 1] < place) i++;
    return valueAt(x, y, place, i);
  });
}

/** The curve at equal intervals, as many as it has. Rows of a history are a step apart from where they were due. */
function evenly(x, y) {
  const count = x.length;
  const step = (x[count - 1] - x[0]) / (count - 1);
  const places = Float64Array.from({ length: count }, (_, i) => x[0] + i * step);
  return { places, step, values: valuesAt(x, y, places) };
}

/** Coefficients of one pass of a filter class at a time step [s]: Butterworth with two poles (SAE J211-1, annex C). */
function passOf(filterClass, step) {
  const corner = 2 * Math.PI * filterClass * 2.0775;
  const w = Math.tan((corner * step) / 2);
  const whole = 1 + Math.SQRT2 * w + w * w;
  const a0 = (w * w) / whole;
  return { a0, a1: 2 * a0, a2: a0, b1: (-2 * (w * w - 1)) / whole, b2: (-1 + Math.SQRT2 * w - w * w) / whole };
}

/** One pass over values, from a state of rest at the first one. */
function passed({ a0, a1, a2, b1, b2 }, values) {
  const out = new Float64Array(values.length);
  let [x1, x2, y1, y2] = Array(4).fill(values[0]);
  for (let i = 0; i < values.length; i++) {
    const y = a0 * values[i] + a1 * x1 + a2 * x2 + b1 * y1 + b2 * y2;
    [x2, x1, y2, y1] = [x1, values[i], y1, y];
    out[i] = y;
  }
  return out;
}

/**
 * The curve after the filter of a class: forward and backward, so that the phase is zero. `seconds` is the unit of
 * `x` [s]. The ends are continued by their point reflection. Throws if the rows are too far apart for the class.
 */
function filtered(x, y, filterClass, seconds) {
  if (x.length < 3) return y;
  const { places, step, values } = evenly(x, y);
  const rate = 1 / (step * seconds);
  if (!(rate > 2 * 2.0775 * filterClass)) {
    const needed = digits(1 / (ROWS_PER_PERIOD * filterClass * seconds), 3);
    throw new Error(`CFC ${filterClass} needs rows at most ${needed} apart, but they are ${digits(step, 3)} apart: reduce output.history_interval.`);
  }
  const pass = passOf(filterClass, step * seconds);
  const count = values.length;
  const more = Math.min(count - 1, Math.ceil((RUN_IN * rate) / filterClass));
  const long = new Float64Array(count + 2 * more);
  long.set(values, more);
  for (let i = 1; i <= more; i++) {
    long[more - i] = 2 * values[0] - values[i];
    long[more + count - 1 + i] = 2 * values[count - 1] - values[count - 1 - i];
  }
  const there = passed(pass, long);
  const back = passed(pass, there.reverse()).reverse();
  return valuesAt(places, back.subarray(more, more + count), x);
}

/** True if the rows are as close as the standard asks for. */
function closeEnough(x, filterClass, seconds) {
  const step = ((x[x.length - 1] - x[0]) / (x.length - 1)) * seconds;
  return step * ROWS_PER_PERIOD * filterClass <= 1 + 1e-6;
}

/** The integral from the start to each point, by trapezoids. */
function integral(x, y) {
  const out = new Float64Array(y.length);
  for (let i = 1; i < y.length; i++) out[i] = out[i - 1] + 0.5 * (y[i] + y[i - 1]) * (x[i] - x[i - 1]);
  return out;
}

/** The point with the largest magnitude of a value. */
function peakOf(y) {
  let best = 0;
  for (let i = 1; i < y.length; i++) if (Math.abs(y[i]) > Math.abs(y[best])) best = i;
  return best;
}

/** The point that is farthest from the first one along `x`. Over time this is the last point. */
function farthest(x) {
  let best = 0;
  for (let i = 1; i < x.length; i++) if (Math.abs(x[i] - x[0]) > Math.abs(x[best] - x[0])) best = i;
  return best;
}

/** Mean of a curve over `x`, from the first point to the farthest one. */
function meanOf(x, y) {
  const end = farthest(x);
  return end > 0 ? integral(x, y)[end] / (x[end] - x[0]) : y[0];
}

/**
 * Figures of a crush, from the start to the largest displacement (to the end, if no displacement is known): peak of the force and the displacement there,
 * stroke, absorbed energy, mean force (energy over stroke), and mean over peak.
 */
function crushOf(displacement, force) {
  const end = farthest(displacement);
  const peak = peakOf(Number.isFinite(displacement[end]) ? force.subarray(0, end + 1) : force);
  const stroke = Math.abs(displacement[end] - displacement[0]);
  const energy = Number.isFinite(stroke) ? Math.abs(integral(displacement, force)[end]) : NaN;
  const mean = stroke > 0 ? energy / stroke : NaN;
  const highest = Math.abs(force[peak]);
  return { peak: highest, at: Math.abs(displacement[peak] - displacement[0]), stroke, energy, mean, efficiency: mean / highest };
}

/**
 * Head injury criterion of an acceleration [g] over time [s]: the largest value of duration times mean^2.5, over all
 * intervals of at most `longest` [s] (FMVSS 208). Returns its value and the ends of its interval [s].
 */
function headInjury(time, acceleration, longest) {
  if (time.length < 2) return { value: NaN, from: NaN, to: NaN };
  const { places, step, values } = evenly(time, acceleration);
  const sums = integral(places, values);
  const most = Math.min(Math.floor(longest / step + 1e-9), values.length - 1);
  // (integral / duration^0.6)^2.5 is the criterion: one power per duration instead of one per interval.
  let best = { value: 0, from: 0, to: 0 };
  for (let long = 1; long <= most; long++) {
    const share = 1 / (long * step) ** 0.6;
    for (let i = 0; i + long < sums.length; i++) {
      const value = (sums[i + long] - sums[i]) * share;
      if (value > best.value) best = { value, from: i, to: i + long };
    }
  }
  return { value: best.value ** 2.5, from: places[best.from], to: places[best.to] };
}

/** Metres per second squared of a unit such as mm/ms^2; undefined if it is not known. */
function accelerationUnit(unit) {
  const [, length, time] = /^(\S+)\/(\S+)\^2$/.exec(unit) || [];
  return METRES[length] && SECONDS[time] ? METRES[length] / SECONDS[time] ** 2 : undefined;
}

const NO_UNITS = "Filters and HIC need units that the page knows, such as \"mm, ms, kg\": set `units` in the job.";

/** Seconds per unit of the time of histories. Throws if it is not known. */
function secondsOf({ timeUnit }) {
  if (!SECONDS[timeUnit]) throw new Error(NO_UNITS);
  return SECONDS[timeUnit];
}

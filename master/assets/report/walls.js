"use strict";
// Rigid walls: planes, rectangles, cylinders and spheres, with lines on them. Infinite sides are drawn as far as the model sweeps.
// Moving walls have a path.

/** Margin around the model, as a fraction of its size. */
const WALL_MARGIN = 0.12;
const GRID_LINES = 10;
const SIDES_OF_CYLINDER = 48;

/** A surface and its lines; nothing for a wall without direction. */
function wallObjects(wall, box) {
  const direction = wall.axis || wall.normal;
  const round = !direction && wall.radius > 0;
  if (!round && !(direction && Math.hypot(...direction) > 0)) return null;
  const { at, s, t, steps } = round ? sphere(wall) : wall.axis ? cylinder(wall, box) : plane(wall, box);
  const between = ([a, b], count) => Array.from({ length: count + 1 }, (_, i) => a + ((b - a) * i) / count);
  const along = between(s, steps[0]);
  const across = between(t, steps[1]);
  const corners = [];
  const lines = [];
  for (let i = 0; i < steps[0]; i++) {
    for (let j = 0; j < steps[1]; j++) {
      const [a, b] = [at(along[i], across[j]), at(along[i + 1], across[j])];
      const [c, d] = [at(along[i + 1], across[j + 1]), at(along[i], across[j + 1])];
      corners.push(a, b, c, a, c, d);
      lines.push(a, b, a, d);
      if (i === steps[0] - 1) lines.push(b, c);
      if (j === steps[1] - 1) lines.push(c, d);
    }
  }
  const geometry = (points) => {
    const made = new THREE.BufferGeometry();
    return made.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points.flat()), 3));
  };
  const paint = { transparent: true, depthWrite: false, side: THREE.DoubleSide, opacity: 0.16 };
  return [
    new THREE.Mesh(geometry(corners), new THREE.MeshBasicMaterial(paint)),
    new THREE.LineSegments(geometry(lines), new THREE.LineBasicMaterial({ transparent: true, opacity: 0.4 })),
  ];
}

/** Two directions perpendicular to a third one of length 1. */
function square(direction, edge) {
  const first = new THREE.Vector3(...(edge || (Math.abs(direction.z) < 0.9 ? [0, 0, 1] : [1, 0, 0])));
  first.addScaledVector(direction, -first.dot(direction)).normalize();
  return [first, new THREE.Vector3().crossVectors(direction, first)];
}

/** Extent of the model along a direction, with the margin. */
function reach(box, axis) {
  const corners = Array.from({ length: 8 }, (_, k) => new THREE.Vector3(...box.low.map((a, c) => (k & (1 << c) ? box.high[c] : a))));
  const places = corners.map((corner) => corner.dot(axis));
  const margin = WALL_MARGIN * corners[0].distanceTo(corners[7]);
  return [Math.min(...places) - margin, Math.max(...places) + margin];
}

function plane({ point, normal, edge, lengths }, box) {
  const n = new THREE.Vector3(...normal).normalize();
  const [first, second] = square(n, edge);
  const start = new THREE.Vector3(...point);
  const range = (axis, length) => {
    const from = start.dot(axis);
    const [low, high] = reach(box, axis);
    if (!edge) return [low, high];
    return [from, length > 0 ? from + length : Math.max(high, from)];
  };
  const height = start.dot(n);
  const at = (s, t) => [0, 1, 2].map((c) => n.getComponent(c) * height + first.getComponent(c) * s + second.getComponent(c) * t);
  return { at, s: range(first, lengths?.[0]), t: range(second, lengths?.[1]), steps: [GRID_LINES, GRID_LINES] };
}

function cylinder({ point, axis, radius, length }, box) {
  const along = new THREE.Vector3(...axis).normalize();
  const [first, second] = square(along);
  const start = new THREE.Vector3(...point);
  const from = start.dot(along);
  const s = length > 0 ? [0, length] : reach(box, along).map((place) => place - from);
  const at = (distance, turn) =>
    start
      .clone()
      .addScaledVector(along, distance)
      .addScaledVector(first, radius * Math.cos(turn))
      .addScaledVector(second, radius * Math.sin(turn))
      .toArray();
  return { at, s, t: [0, 2 * Math.PI], steps: [GRID_LINES, SIDES_OF_CYLINDER] };
}

function sphere({ point, radius }) {
  const at = (height, turn) => {
    const [x, y, z] = [Math.cos(height) * Math.cos(turn), Math.cos(height) * Math.sin(turn), Math.sin(height)];
    return [point[0] + radius * x, point[1] + radius * y, point[2] + radius * z];
  };
  return { at, s: [-Math.PI / 2, Math.PI / 2], t: [0, 2 * Math.PI], steps: [SIDES_OF_CYLINDER / 2, SIDES_OF_CYLINDER] };
}

/** Displacement of a wall along its path at a time. */
function gone({ times, moved }, time) {
  const later = times.findIndex((t) => t >= time);
  const next = later < 0 ? times.length - 1 : later;
  const first = Math.max(next - 1, 0);
  const span = times[next] - times[first];
  const share = span > 0 ? Math.min((time - times[first]) / span, 1) : 1;
  return moved[first].map((a, c) => a + share * (moved[next][c] - a));
}

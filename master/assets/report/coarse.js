"use strict";
// A coarser picture while it plays: near nodes share a place, so that faces between them vanish.

/** Fewest faces of a coarser picture. */
const FEWEST_FACES = 8000;
/** Shares of the pixels of a line and of the faces, from the best picture on. */
const QUALITIES = [[1, 1], [0.8, 1], [0.8, 0.5], [0.8, 0.25], [0.8, 0.12], [0.65, 0.12], [0.5, 0.12]];

/** Least share of the faces of a model: small ones keep all. */
const leastShare = (model) => Math.min(FEWEST_FACES / model.faces, 1);

/** The qualities that differ for a model. */
function qualitiesOf(model) {
  const least = leastShare(model);
  const all = QUALITIES.map(([pixels, faces]) => [pixels, Math.max(faces, least)]);
  return all.filter(([pixels, faces], i) => !i || pixels !== all[i - 1][0] || faces !== all[i - 1][1]);
}

/**
 * Stand-ins of nodes: one node for all of a part in each cube of a grid at the first time. The cubes are large enough to
 * leave about this share of the faces.
 */
function standIns(model, share) {
  const { grid, position } = model.frames[0];
  const at = (node, c) => grid.unit * position[c][node];
  // Faces as large as the mean one.
  let area = 0;
  let count = 0;
  for (let f = 0; f < model.faces; f++) {
    const [a, b, c] = model.corners.subarray(4 * f, 4 * f + 3);
    if (b === c) continue;
    const [u, v] = [b, c].map((end) => [0, 1, 2].map((k) => at(end, k) - at(a, k)));
    area += Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
    count++;
  }
  const side = Math.sqrt(area / (count || 1) / share) || 1;
  // A part that moves away takes its nodes along. Those of two parts are of the first one.
  const partOf = new Uint16Array(model.nodes).fill(model.parts.length);
  for (let k = 4 * model.faces - 1; k >= 0; k--) partOf[model.corners[k]] = model.part[model.owners[0][k >> 2] - 1];
  // One number for a cube and a part.
  const sides = [0, 1, 2].map((c) => 1 + Math.floor(position[c].reduce((most, x) => Math.max(most, x), 0) * grid.unit / side));
  const cubeOf = (node) => [0, 1, 2].reduce((number, c) => number * sides[c] + Math.floor(at(node, c) / side), partOf[node]);
  // The node nearest to the middle of a cube leaves planes plane.
  const best = new Map();
  for (let node = 0; node < model.nodes; node++) {
    const cube = cubeOf(node);
    const off = Math.hypot(...[0, 1, 2].map((c) => ((at(node, c) / side) % 1) - 0.5));
    if (!(best.get(cube)?.off <= off)) best.set(cube, { node, off });
  }
  return Uint32Array.from({ length: model.nodes }, (_, node) => best.get(cubeOf(node)).node);
}

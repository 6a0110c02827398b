"use strict";
// Elements and nodes that are picked in the picture or found by their id: their outline, data and course.

/** Largest motion of the pointer that is a click [pixels]. */
const STILL = 4;
/** Distance at which a line element is hit [pixels]. */
const NEAR_LINE = 6;
/** Size of the cross at a node, as a fraction of the height of the picture. */
const CROSS = 0.02;

class Picker {
  /** `changed` is called when something else is picked. */
  constructor(view, model, facts, changed) {
    Object.assign(this, { view, model, facts, changed });
    this.element = -1;
    this.node = -1;
    this.outline = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0x0050ff, depthTest: false }));
    this.outline.renderOrder = 1;
    this.outline.frustumCulled = false;
    this.outline.visible = false;
    view.scene.add(this.outline);
    let from = null;
    view.canvas.addEventListener("pointerdown", (event) => (from = [event.clientX, event.clientY]));
    view.canvas.addEventListener("pointerup", (event) => {
      if (!from || Math.hypot(event.clientX - from[0], event.clientY - from[1]) > STILL) return;
      const box = view.canvas.getBoundingClientRect();
      this.at(event.clientX - box.left, event.clientY - box.top);
    });
  }

  /** Picks what is seen at a place of the canvas [pixels]. */
  at(left, top) {
    const { canvas, camera, surface } = this.view;
    const point = (depth) => new THREE.Vector3((2 * left) / canvas.clientWidth - 1, 1 - (2 * top) / canvas.clientHeight, depth).unproject(camera);
    const near = point(-1);
    const far = point(1).sub(near);
    const fraction = surface.uniforms.between.value;
    const seen = (x) => !surface.plane || surface.plane[0] * x.x + surface.plane[1] * x.y + surface.plane[2] * x.z <= surface.plane[3];
    let best = null;
    const take = (share, patches, i, hit) => {
      if ((!best || share < best.share) && seen(hit)) best = { share, patches, i, hit };
    };
    const { areas, lines, points } = surface;
    for (let i = 0; i < areas.seen.length; i++) {
      if (areas.seen[i] < 0) continue;
      const corners = [0, 1, 2, 3].map((c) => new THREE.Vector3(...areas.place(4 * i + c, fraction)));
      for (const [a, b, c] of [[0, 1, 2], [0, 2, 3]]) {
        const share = crossing(near, far, corners[a], corners[b], corners[c]);
        if (share !== null) take(share, areas, i, near.clone().addScaledVector(far, share));
      }
    }
    const thin = [lines, points].flatMap((patches) => Array.from(patches.seen, (element, i) => ({ patches, element, i })));
    for (const { patches, i } of thin.filter(({ element }) => element >= 0)) {
      const { corners } = patches;
      const ends = [0, corners - 1].map((c) => new THREE.Vector3(...patches.place(corners * i + c, fraction)));
      const [a, b] = ends.map((end) => this.view.pixels(end));
      const along = Math.min(Math.max(((left - a.x) * (b.x - a.x) + (top - a.y) * (b.y - a.y)) / ((b.x - a.x) ** 2 + (b.y - a.y) ** 2 || 1), 0), 1);
      if (Math.hypot(a.x + along * (b.x - a.x) - left, a.y + along * (b.y - a.y) - top) > NEAR_LINE) continue;
      const hit = ends[0].clone().addScaledVector(ends[1].clone().sub(ends[0]), along);
      take(hit.clone().sub(near).dot(far) / far.lengthSq(), patches, i, hit);
    }
    if (!best) return this.pick(-1, -1);
    const { patches, i, hit } = best;
    const corners = Array.from({ length: patches.corners }, (_, c) => patches.corners * i + c);
    const distance = (corner) => hit.distanceToSquared(new THREE.Vector3(...patches.place(corner, fraction)));
    const corner = corners.reduce((a, b) => (distance(b) < distance(a) ? b : a));
    this.pick(patches.seen[i], patches.node[corner]);
  }

  /** Picks by the index of an element and of a node; -1 is none. */
  pick(element, node) {
    [this.element, this.node] = [element, node];
    this.update();
    this.changed();
  }

  /** Picks by kind (element or node) and id. Throws if the picture has none of this id. */
  find(kind, id) {
    const index = this.model[kind === "node" ? "nodeIds" : "elementIds"].indexOf(id);
    if (index < 0) throw new Error(`The picture has no ${kind} ${id}: it is inside of solids, or there is none.`);
    this.pick(kind === "node" ? -1 : index, kind === "node" ? index : -1);
    const middle = this.middle();
    if (!middle) throw new Error(`The ${kind} ${id} does not exist at this time, or its part is hidden.`);
    this.view.approach(middle, this.normal(), this.size());
  }

  /** The corners of the picked element in space, face by face. */
  faces() {
    const fraction = this.view.surface.uniforms.between.value;
    return this.corners().map(([patches, corners]) => corners.map((corner) => new THREE.Vector3(...patches.place(corner, fraction))));
  }

  /** The normal of the largest face of the picked element; null for a node or a line. */
  normal() {
    const across = (places) => (places.length > 2 ? new THREE.Vector3().crossVectors(places[2].clone().sub(places[0]), places.at(-1).clone().sub(places[1])) : new THREE.Vector3());
    const normals = this.faces().map(across).sort((a, b) => b.length() - a.length());
    return normals[0]?.length() > 0 ? normals[0].normalize() : null;
  }

  /** The largest distance of a corner of the picked element from its first one; 0 for a node. */
  size() {
    const places = this.faces().flat();
    return Math.max(0, ...places.map((place) => place.distanceTo(places[0])));
  }

  /** Corners of the picked element, or one of the picked node: patches and corner numbers. */
  corners() {
    const found = [];
    for (const patches of this.view.surface.all) {
      const { corners, seen, node } = patches;
      for (let i = 0; i < seen.length; i++) {
        if (seen[i] < 0) continue;
        const first = corners * i;
        if (this.element >= 0) {
          if (seen[i] === this.element) found.push([patches, Array.from({ length: corners }, (_, c) => first + c)]);
          continue;
        }
        for (let k = first; k < first + corners; k++) if (node[k] === this.node) return [[patches, [k]]];
      }
    }
    return found;
  }

  /** The middle of what is picked; nothing if it is not seen. */
  middle() {
    const places = this.faces().flat();
    return places.length ? places.reduce((sum, place) => sum.add(place), new THREE.Vector3()).divideScalar(places.length).toArray() : null;
  }

  /** Draws the outline at the present time. */
  update() {
    const nothing = this.element < 0 && this.node < 0;
    this.outline.visible = false;
    if (nothing) return;
    const fraction = this.view.surface.uniforms.between.value;
    const points = [];
    for (const [patches, corners] of this.corners()) {
      const places = corners.map((corner) => patches.place(corner, fraction));
      if (places.length > 1) places.forEach((place, i) => points.push(...place, ...places[(i + 1) % places.length]));
      else {
        const half = CROSS * this.view.height();
        for (let c = 0; c < 3; c++) for (const side of [-half, half]) points.push(...places[0].map((x, d) => (d === c ? x + side : x)));
      }
    }
    this.outline.visible = points.length > 0;
    this.outline.geometry.dispose(); // the buffer of the last time
    this.outline.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
  }

  /** Name of the picked element or node. */
  name() {
    return this.element >= 0 ? `element ${this.model.elementIds[this.element]}` : `node ${this.model.nodeIds[this.node]}`;
  }

  /** Nodes of the picked element that the picture has. */
  nodesOf(element) {
    const { owners, corners, faces } = this.model;
    const nodes = new Set();
    for (let f = 0; f < faces; f++) {
      if (owners[0][f] === element + 1 || owners[1][f] === element + 1) for (let c = 4 * f; c < 4 * f + 4; c++) nodes.add(corners[c]);
    }
    return [...nodes];
  }

  /** Value of a way of colouring in a frame; not a number for a category, or for a node in a quantity of elements. */
  value(way, frame) {
    if (way.kinds) return NaN;
    if (this.element < 0) return way.node ? way.node(frame, this.node) : NaN;
    return frame.state[this.element] ? faceValue(way, frame, this.element, way.node ? this.nodesOf(this.element) : []) : NaN;
  }

  /** Data of what is picked, at a frame: pairs of name and value. */
  data(way, frame) {
    const { model, facts } = this;
    const rows = [];
    if (this.element >= 0) {
      const id = model.parts[model.part[this.element]];
      rows.push(["part", facts.part_names[id] ? `${id} ${facts.part_names[id]}` : String(id)]);
    }
    const value = this.value(way, frame);
    if (Number.isFinite(value)) rows.push([way.title, `${digits(value, 5)} ${way.unit}`.trim()]);
    if (this.node >= 0) {
      const place = [0, 1, 2].map((c) => digits(frame.grid.origin[c] + frame.grid.unit * frame.position[c][this.node], 6));
      rows.push([this.element >= 0 ? "nearest node" : "coordinates", `${this.element >= 0 ? `${model.nodeIds[this.node]} at ` : ""}(${place.join(", ")})`]);
    }
    return rows;
  }

  /** The course of a way of colouring over the times of the picture. */
  course(way) {
    return this.model.frames.map((frame) => this.value(way, frame));
  }
}

/** Share of a ray, from `near` along `far`, at which it goes through a triangle; null if it does not. */
function crossing(near, far, a, b, c) {
  const [ab, ac] = [b.clone().sub(a), c.clone().sub(a)];
  const across = new THREE.Vector3().crossVectors(far, ac);
  const whole = ab.dot(across);
  if (whole === 0) return null;
  const from = near.clone().sub(a);
  const u = from.dot(across) / whole;
  if (u < 0 || u > 1) return null;
  const over = new THREE.Vector3().crossVectors(from, ab);
  const v = far.dot(over) / whole;
  if (v < 0 || u + v > 1) return null;
  const share = ac.dot(over) / whole;
  return share >= 0 ? share : null;
}

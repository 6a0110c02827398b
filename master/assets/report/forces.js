"use strict";
// Contact forces as arrows: the force on each part, at the middle of the part.

const ARROW_COLOUR = 0xb01060;

class ForceArrows {
  constructor(view, model, histories) {
    Object.assign(this, { view, model, histories, on: false });
    this.parts = model.parts.flatMap((id, index) => {
      const object = histories.objects.find(({ kind, name }) => kind === "contact of part" && Number(name.split(" ")[0]) === id);
      const force = object && ["x", "y", "z"].map((axis) => histories.quantity(object, `force ${axis}`));
      return force?.every(Boolean) ? [{ force, nodes: nodesOfPart(model, index) }] : [];
    });
    this.most = 0;
    for (const { force } of this.parts) {
      force[0].values.forEach((_, row) => (this.most = Math.max(this.most, Math.hypot(...force.map((f) => f.values[row])) || 0)));
    }
    this.object = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: ARROW_COLOUR, depthTest: false }));
    this.object.renderOrder = 1;
    this.object.frustumCulled = false;
    view.scene.add(this.object);
  }

  /** Draws the forces at a time, on the model in this frame. */
  update(time, frame) {
    this.object.visible = this.on;
    if (!this.on) return;
    const { low, high } = this.view.boxes[0];
    const unit = (ARROW.length * Math.hypot(...low.map((a, c) => high[c] - a))) / this.most;
    const points = [];
    for (const { force, nodes } of this.parts) {
      const value = new THREE.Vector3(...force.map((f) => valueAt(this.histories.time, f.values, time)));
      if (!(value.length() > 0)) continue;
      const from = new THREE.Vector3(...[0, 1, 2].map((c) => frame.grid.origin[c] + (frame.grid.unit * nodes.reduce((sum, n) => sum + frame.position[c][n], 0)) / nodes.length));
      points.push(...arrow(from, value.multiplyScalar(unit)));
    }
    this.object.geometry.dispose(); // the buffer of the last time
    this.object.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    this.object.geometry.setDrawRange(0, points.length / 3);
  }
}

/** Contact forces on single nodes, as the field files have them. */
class NodeForces {
  constructor(view, model) {
    Object.assign(this, { view, model, on: false });
    this.most = model.frames.reduce((most, { forces: { components: [x, y, z] } }) => x.reduce((m, _, i) => Math.max(m, Math.hypot(x[i], y[i], z[i])), most), 0);
    this.object = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: ARROW_COLOUR, depthTest: false }));
    this.object.renderOrder = 1;
    this.object.frustumCulled = false;
    view.scene.add(this.object);
  }

  /** Draws the forces of a frame. */
  update(frame) {
    this.object.visible = this.on;
    if (!this.on) return;
    const { low, high } = this.view.boxes[0];
    const unit = (ARROW.length * Math.hypot(...low.map((a, c) => high[c] - a))) / this.most;
    const { nodes, components } = frame.forces;
    const points = Array.from(nodes).flatMap((node, i) => {
      const from = new THREE.Vector3(...[0, 1, 2].map((c) => frame.grid.origin[c] + frame.grid.unit * frame.position[c][node]));
      return arrow(from, new THREE.Vector3(...components.map((column) => unit * column[i])));
    });
    this.object.geometry.dispose(); // the buffer of the last time
    this.object.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
    this.object.geometry.setDrawRange(0, points.length / 3);
  }
}

/** The nodes of the faces of a part. */
function nodesOfPart(model, part) {
  const nodes = new Set();
  for (let f = 0; f < model.faces; f++) {
    if (model.part[model.owners[0][f] - 1] === part) for (let c = 4 * f; c < 4 * f + 4; c++) nodes.add(model.corners[c]);
  }
  return [...nodes];
}

"use strict";
// Contact forces as arrows: the force on each part, at the middle of the part.

/** Length of the largest arrow and of its head, as fractions of the size of the model and of the arrow. */
const ARROW = { length: 0.3, head: 0.2 };
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
      const along = value.multiplyScalar(unit);
      const to = from.clone().add(along);
      points.push(...from, ...to);
      for (const side of square(along.clone().normalize())) {
        for (const sign of [-1, 1]) points.push(...to, ...to.clone().addScaledVector(along, -ARROW.head).addScaledVector(side, 0.4 * sign * ARROW.head * along.length()));
      }
    }
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

"use strict";
// The faces of the model as triangles and lines, between two of its times.

const VERTEX = `
attribute vec3 next;
attribute vec3 colour;
attribute vec3 place;
uniform float between;
varying vec3 seen;
varying vec3 tint;
varying vec3 where;
void main() {
  vec4 at = modelViewMatrix * vec4(mix(position, next, between), 1.0);
  seen = at.xyz;
  tint = colour;
  where = place;
  gl_Position = projectionMatrix * at;
}`;

// Flat shading: the normal of a face follows from the derivatives of the position between pixels. The light is next to
// the camera. `where` is the position in the face: for quads both coordinates run from 0 to 1; for triangles the third
// one is 1.
const FRAGMENT = `
uniform float edges;
uniform float lit;
uniform vec3 edgeColour;
varying vec3 seen;
varying vec3 tint;
varying vec3 where;
void main() {
  vec3 shade = tint;
  if (lit > 0.5) {
    vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
    if (normal.z < 0.0) normal = -normal;
    shade *= 0.42 + 0.58 * clamp(dot(normal, normalize(vec3(-0.35, 0.5, 0.8))), 0.0, 1.0);
  }
  if (edges > 0.5) {
    vec3 far = where.z > 0.5 ? vec3(where.xy, 1.0 - where.x - where.y) : vec3(where.xy, 1.0);
    vec3 wide = fwidth(far) + 1e-9;
    vec3 pixels = far / wide;
    float least = min(pixels.x, pixels.y);
    if (where.z > 0.5) least = min(least, pixels.z);
    else least = min(least, min((1.0 - where.x) / wide.x, (1.0 - where.y) / wide.y));
    // If faces are only a few pixels wide, edges would hide them.
    float room = smoothstep(3.0, 12.0, 1.0 / max(wide.x, wide.y));
    shade = mix(shade, edgeColour, 0.65 * room * (1.0 - smoothstep(0.35, 1.1, least)));
  }
  gl_FragColor = vec4(shade, 1.0);
}`;

const NOBODY = 0;

class Surface {
  constructor(model) {
    this.model = model;
    const areas = [];
    const lines = [];
    for (let f = 0; f < model.faces; f++) (model.corners[4 * f + 1] === model.corners[4 * f + 2] ? lines : areas).push(f);
    const uniforms = (lit) => ({ between: { value: 0 }, edges: { value: lit }, lit: { value: lit }, edgeColour: { value: new THREE.Vector3() } });
    const material = (lit) =>
      new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: uniforms(lit), side: THREE.DoubleSide });
    this.areas = new Patches(model, areas, 4, (geometry) => new THREE.Mesh(geometry, material(1)));
    this.lines = new Patches(model, lines, 2, (geometry) => new THREE.LineSegments(geometry, material(0)));
    this.all = [this.areas, this.lines];
    this.objects = this.all.map((patches) => patches.object);
  }

  /** Shows the frame, interpolated to the next one; only parts for which `shown` is true. */
  show(frame, next, way, shown) {
    for (const patches of this.all) patches.show(frame, next, way, shown);
  }

  between(fraction) {
    for (const patches of this.all) patches.object.material.uniforms.between.value = fraction;
  }

  edges(on, colour) {
    const { edges, edgeColour } = this.areas.object.material.uniforms;
    edges.value = on ? 1 : 0;
    edgeColour.value.set(...colour.map((c) => c / 255));
  }
}

/** Faces with this number of corners. Faces share no corners, because every face has its own colour. */
class Patches {
  constructor(model, faces, corners, object) {
    this.model = model;
    this.faces = Uint32Array.from(faces);
    this.corners = corners;
    const count = corners * faces.length;
    this.node = new Uint32Array(count);
    const place = new Float32Array(3 * count);
    faces.forEach((f, i) => {
      const of = model.corners.subarray(4 * f, 4 * f + 4);
      const triangle = of[2] === of[3];
      const places = triangle ? [0, 0, 1, 1, 0, 1, 0, 1, 1, 0, 1, 1] : [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0];
      for (let c = 0; c < corners; c++) {
        this.node[corners * i + c] = of[c];
        place.set(places.slice(3 * c, 3 * c + 3), 3 * (corners * i + c));
      }
    });
    const changing = (array, size, normalised) => {
      const attribute = new THREE.BufferAttribute(array, size, normalised);
      attribute.setUsage(35048); // DYNAMIC_DRAW
      return attribute;
    };
    this.geometry = new THREE.BufferGeometry();
    this.now = changing(new Float32Array(3 * count), 3);
    this.next = changing(new Float32Array(3 * count), 3);
    this.colour = changing(new Uint8Array(4 * count), 4, true);
    this.index = changing(new Uint32Array((corners === 4 ? 6 : 2) * faces.length), 1);
    this.geometry.setAttribute("position", this.now);
    this.geometry.setAttribute("next", this.next);
    this.geometry.setAttribute("colour", this.colour);
    this.geometry.setAttribute("place", new THREE.BufferAttribute(place, 3));
    this.geometry.setIndex(this.index);
    this.object = object(this.geometry);
    this.object.frustumCulled = false;
    this.object.visible = faces.length > 0;
  }

  show(frame, next, way, shown) {
    if (!this.faces.length) return;
    this.put(this.now, frame);
    this.put(this.next, next);
    const { owners, part } = this.model;
    const { corners, faces } = this;
    const index = this.index.array;
    let used = 0;
    for (let i = 0; i < faces.length; i++) {
      const one = owners[0][faces[i]];
      const other = owners[1][faces[i]];
      const hasOne = frame.state[one - 1] > 0;
      const hasOther = other !== NOBODY && frame.state[other - 1] > 0;
      if (hasOne === hasOther) continue;
      const element = (hasOne ? one : other) - 1;
      if (!shown[part[element]]) continue;
      const first = corners * i;
      const colour = way.colour(frame, element);
      for (let c = first; c < first + corners; c++) this.colour.array.set(colour, 4 * c);
      index[used++] = first;
      index[used++] = first + 1;
      if (corners === 2) continue;
      index[used++] = first + 2;
      if (this.node[first + 2] === this.node[first + 3]) continue;
      index[used++] = first;
      index[used++] = first + 2;
      index[used++] = first + 3;
    }
    this.geometry.setDrawRange(0, used);
    this.index.needsUpdate = true;
    this.colour.needsUpdate = true;
  }

  put(attribute, frame) {
    const { origin, unit } = frame.grid;
    for (let c = 0; c < 3; c++) {
      const column = frame.position[c];
      for (let i = 0; i < this.node.length; i++) attribute.array[3 * i + c] = origin[c] + unit * column[this.node[i]];
    }
    attribute.needsUpdate = true;
  }
}

/** Lowest and highest corner of the elements that exist in a frame. */
function boxOf(model, frame) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let f = 0; f < model.faces; f++) {
    const there = [0, 1].some((side) => model.owners[side][f] && frame.state[model.owners[side][f] - 1]);
    for (let k = 4 * f; there && k < 4 * f + 4; k++) {
      for (let c = 0; c < 3; c++) {
        const x = frame.grid.origin[c] + frame.grid.unit * frame.position[c][model.corners[k]];
        low[c] = Math.min(low[c], x);
        high[c] = Math.max(high[c], x);
      }
    }
  }
  return low[0] <= high[0] ? { low, high } : { low: [0, 0, 0], high: [1, 1, 1] };
}

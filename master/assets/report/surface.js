"use strict";
// The faces of the model as triangles, lines and points, between two of its times.

const VERTEX = `
attribute vec3 next;
attribute vec3 colour;
attribute vec3 place;
uniform float between;
#ifdef POINTS
uniform float size;
#endif
varying vec3 seen;
varying vec3 tint;
varying vec3 where;
#ifdef CUT
uniform vec4 plane;
varying float beyond;
#endif
void main() {
  vec3 world = mix(position, next, between);
#ifdef CUT
  beyond = dot(plane.xyz, world) - plane.w;
#endif
  vec4 at = modelViewMatrix * vec4(world, 1.0);
  seen = at.xyz;
  tint = colour;
  where = place;
  gl_Position = projectionMatrix * at;
#ifdef POINTS
  gl_PointSize = size;
#endif
}`;

// Flat shading: the normal of a face follows from the derivatives of the position between pixels. The light is next to
// the camera. `where` is the position in the face: for quads both coordinates run from 0 to 1; for triangles the third
// one is 1.
const FRAGMENT = `
uniform float edges;
uniform float lit;
uniform vec3 edgeColour;
uniform float opacity;
varying vec3 seen;
varying vec3 tint;
varying vec3 where;
#ifdef CUT
varying float beyond;
#endif
void main() {
#ifdef CUT
  if (beyond > 0.0) discard;
#endif
  vec3 shade = tint;
#ifdef POINTS
  vec2 off = 2.0 * gl_PointCoord - 1.0;
  float height = 1.0 - dot(off, off);
  if (height < 0.0) discard;
  shade *= 0.5 + 0.5 * sqrt(height);
#endif
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
  gl_FragColor = vec4(shade, opacity);
}`;

const NOBODY = 0;
/** Width of a point [pixels of the page]. */
const POINT_SIZE = 7;

/** Groups of a geometry: opaque parts, and parts that one can look through. */
const [OPAQUE, GHOST] = [0, 1];

class Surface {
  constructor(model) {
    this.model = model;
    /** Parts that are transparent, colours that run smoothly between nodes, and the factor on displacements. */
    this.style = { ghosts: model.parts.map(() => false), smooth: false, scale: 1 };
    const [areas, lines, points] = [[], [], []];
    for (let f = 0; f < model.faces; f++) {
      const [a, b, c] = model.corners.subarray(4 * f, 4 * f + 3);
      (b !== c ? areas : a !== b ? lines : points).push(f);
    }
    const between = { value: 0 };
    this.uniforms = {
      between, edges: { value: 1 }, edgeColour: { value: new THREE.Vector3() }, plane: { value: new Float32Array(4) },
      size: { value: POINT_SIZE * devicePixelRatio },
    };
    this.opacity = { value: 0.25 };
    const material = (lit, opacity, more) => {
      // Objects of uniforms are shared, so that one value reaches all materials.
      const uniforms = { ...this.uniforms, edges: lit ? this.uniforms.edges : { value: 0 }, lit: { value: lit }, opacity };
      return new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, side: THREE.DoubleSide, ...more });
    };
    const materials = (lit) => [material(lit, { value: 1 }), material(lit, this.opacity, { transparent: true, depthWrite: false })];
    this.areas = new Patches(model, areas, 4, (geometry) => new THREE.Mesh(geometry, materials(1)));
    this.lines = new Patches(model, lines, 2, (geometry) => new THREE.LineSegments(geometry, materials(0)));
    const spots = [material(0, { value: 1 }), material(0, this.opacity, { transparent: true, depthWrite: false })];
    for (const one of spots) Object.assign(one, { defines: { POINTS: "" } });
    this.points = new Patches(model, points, 1, (geometry) => new THREE.Points(geometry, spots));
    this.all = [this.areas, this.lines, this.points];
    /** Stand-ins of nodes by the share of the faces. */
    this.standIns = new Map();
    this.objects = this.all.map((patches) => patches.object);
  }

  /** Shows the frame, interpolated to the next one; only parts for which `shown` is true. */
  show(frame, next, way, shown) {
    for (const patches of this.all) patches.show(frame, next, way, shown, this.style);
  }

  /** Draws about this share of the faces, from the next `show` on. */
  coarsen(share) {
    if (share < 1 && !this.standIns.has(share)) this.standIns.set(share, standIns(this.model, share));
    for (const patches of [this.areas, this.lines]) patches.standIn(this.standIns.get(share) ?? null);
  }

  between(fraction) {
    this.uniforms.between.value = fraction;
  }

  edges(on, colour) {
    this.uniforms.edges.value = on ? 1 : 0;
    this.uniforms.edgeColour.value.set(...colour.map((c) => c / 255));
  }

  /** Hides what is beyond a plane (normal, and its distance along the normal); null shows all. */
  cut(plane) {
    this.plane = plane;
    if (plane) this.uniforms.plane.value.set(plane);
    for (const { material } of this.objects) {
      for (const one of material) {
        // A discard costs time even if it is not taken, so it is compiled only if needed.
        if ("CUT" in one.defines === Boolean(plane)) continue;
        const { CUT, ...others } = one.defines;
        one.defines = plane ? { ...others, CUT: "" } : others;
        one.needsUpdate = true;
      }
    }
  }
}

/** Value of a quantity on a face: that of its element, or the mean of its nodes. */
function faceValue(way, frame, element, nodes) {
  if (!way.node) return way.value(frame, element);
  let sum = 0;
  for (const node of nodes) sum += way.node(frame, node);
  return sum / nodes.length;
}

/** Faces with this number of corners. Faces share no corners, because every face has its own colour. */
class Patches {
  constructor(model, faces, corners, object) {
    this.model = model;
    this.faces = Uint32Array.from(faces);
    this.corners = corners;
    const count = corners * faces.length;
    this.node = new Uint32Array(count);
    /** The node at whose place a corner is drawn. */
    this.drawn = this.node;
    /** Element of each face that is seen, else -1. */
    this.seen = new Int32Array(faces.length).fill(-1);
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
    this.index = changing(new Uint32Array((corners === 4 ? 6 : corners) * faces.length), 1);
    this.geometry.setAttribute("position", this.now);
    this.geometry.setAttribute("next", this.next);
    this.geometry.setAttribute("colour", this.colour);
    this.geometry.setAttribute("place", new THREE.BufferAttribute(place, 3));
    this.geometry.setIndex(this.index);
    this.object = object(this.geometry);
    this.object.frustumCulled = false;
    this.object.visible = faces.length > 0;
  }

  /** The nodes of a face, each once. */
  nodes(i) {
    const first = this.corners * i;
    const isTriangle = this.corners === 4 && this.node[first + 2] === this.node[first + 3];
    return this.node.subarray(first, first + this.corners - (isTriangle ? 1 : 0));
  }

  /** Draws corners at the places of other nodes; null draws them at their own. */
  standIn(nodes) {
    this.drawn = nodes ? this.node.map((node) => nodes[node]) : this.node;
  }

  show(frame, next, way, shown, { ghosts, smooth, scale }) {
    if (!this.faces.length) return;
    this.put(this.now, frame, scale);
    this.put(this.next, next, scale);
    const { owners, part } = this.model;
    const { corners, faces, seen } = this;
    const runs = smooth && !way.kinds;
    const sums = runs && !way.node ? new Float32Array(2 * this.model.nodes) : null;
    for (let i = 0; i < faces.length; i++) {
      const one = owners[0][faces[i]];
      const other = owners[1][faces[i]];
      const hasOne = frame.state[one - 1] > 0;
      const hasOther = other !== NOBODY && frame.state[other - 1] > 0;
      const element = hasOne === hasOther ? -1 : (hasOne ? one : other) - 1;
      seen[i] = element >= 0 && shown[part[element]] ? element : -1;
      if (seen[i] < 0) continue;
      if (sums) {
        const value = way.value(frame, element);
        for (const node of Number.isFinite(value) ? this.nodes(i) : []) {
          sums[2 * node] += value;
          sums[2 * node + 1]++;
        }
      }
      if (runs) continue;
      const colour = way.node ? way.paint(faceValue(way, frame, element, this.nodes(i))) : way.colour(frame, element);
      const first = corners * i;
      for (let c = first; c < first + corners; c++) this.colour.array.set(colour, 4 * c);
    }
    const atNode = way.node ? (node) => way.node(frame, node) : (node) => sums[2 * node] / sums[2 * node + 1];
    for (let k = 0; runs && k < this.node.length; k++) {
      if (seen[Math.floor(k / corners)] >= 0) this.colour.array.set(way.paint(atNode(this.node[k])), 4 * k);
    }
    this.used = this.fillIndex(0, (element) => !ghosts[part[element]]);
    const end = this.fillIndex(this.used, (element) => ghosts[part[element]]);
    this.geometry.clearGroups();
    this.geometry.addGroup(0, this.used, OPAQUE);
    if (end > this.used) this.geometry.addGroup(this.used, end - this.used, GHOST);
    this.index.needsUpdate = true;
    this.colour.needsUpdate = true;
  }

  /** Adds the seen faces of these elements to the index, from a place on, and returns its end. */
  fillIndex(from, takes) {
    const { corners, drawn, seen } = this;
    const index = this.index.array;
    const shapes = corners === 4 ? [[0, 1, 2], [0, 2, 3]] : [[0, 1]];
    let used = from;
    for (let i = 0; i < seen.length; i++) {
      if (seen[i] < 0 || !takes(seen[i])) continue;
      const first = corners * i;
      if (corners === 1) index[used++] = first;
      else for (const [p, q, r] of shapes) {
        const [a, b, c] = [drawn[first + p], drawn[first + q], drawn[first + r]];
        if (a === b || b === c || a === c) continue;
        index[used++] = first + p;
        index[used++] = first + q;
        if (corners === 4) index[used++] = first + r;
      }
    }
    return used;
  }

  /** Coordinates in a frame, with the displacements since the first one times `scale`. */
  put(attribute, frame, scale) {
    const { origin, unit } = frame.grid;
    const { drawn } = this;
    const first = this.model.frames[0];
    for (let c = 0; c < 3; c++) {
      const column = frame.position[c];
      for (let i = 0; i < drawn.length; i++) attribute.array[3 * i + c] = origin[c] + unit * column[drawn[i]];
      if (scale === 1) continue;
      const start = first.position[c];
      for (let i = 0; i < drawn.length; i++) {
        const x = first.grid.origin[c] + first.grid.unit * start[drawn[i]];
        attribute.array[3 * i + c] = x + scale * (attribute.array[3 * i + c] - x);
      }
    }
    attribute.needsUpdate = true;
  }

  /** The present place of a corner. */
  place(corner, fraction) {
    return [0, 1, 2].map((c) => {
      const now = this.now.array[3 * corner + c];
      return now + fraction * (this.next.array[3 * corner + c] - now);
    });
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

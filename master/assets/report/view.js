"use strict";
// The stage: camera, walls, and drawing on demand.

/** Direction to the camera of each view. z is up; in the view from above, y is up. */
const VIEWS = { iso: [-0.75, -1.1, 0.7], front: [-1, 0, 0], side: [0, -1, 0], top: [0, -1e-4, 1] };
/** Width of the legend [pixels]. */
const LEGEND = 120;
/** Distance of the camera from an element that is found, over the size of the element. */
const APPROACH = 15;

class View {
  /** Throws if there is no WebGL. */
  constructor(canvas, model, walls) {
    this.software = drawnBySoftware();
    const options = { alpha: false, antialias: !this.software, powerPreference: "high-performance" };
    const context = canvas.getContext("webgl2", options);
    if (!context) throw new Error("no context");
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.canvas = canvas;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(28, 1, 0.1, 10);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => {
      if (!this.showing) this.draw();
      if (!this.led) this.turned();
    });
    this.led = false;
    this.showing = false; // it is drawn at the end
    /** Brings the camera back to its first place. */
    this.reset = () => this.look("iso");
    takeKeys(this);
    /** Called when the camera has moved. */
    this.turned = () => {};
    this.surface = null;
    this.walls = [];
    this.marks = [];
    this.replace(model, walls);
    this.following = 0;
    this.moved = [0, 0, 0];
    this.drawn = 0;
    this.sharpness = 1;
    this.free = 1;
    this.parallel = false;
    /** Called after each drawing. */
    this.after = () => {};
  }

  /** Shows another model from the same place of the camera. */
  replace(model, walls) {
    this.remove([...(this.surface ? this.surface.objects : []), ...this.walls.flat()]);
    this.surface = new Surface(model);
    this.scene.add(...this.surface.objects);
    this.boxes = model.frames.map((frame) => boxOf(model, frame));
    this.middles = this.boxes.map(({ low, high }) => low.map((a, c) => 0.5 * (a + high[c])));
    this.whole = whole(this.boxes);
    const drawn = walls.map((wall) => [wallObjects(wall, this.whole), wall.path]).filter(([objects]) => objects);
    this.walls = drawn.map(([objects]) => objects);
    this.paths = drawn.map(([, path]) => path);
    this.walls.forEach((objects) => this.scene.add(...objects));
    // The model is in front of its walls. A camera behind a wall would look through it.
    this.mirrored = walls.some(({ normal }) => normal?.[0] > 0.5) && !walls.some(({ normal }) => normal?.[0] < -0.5);
  }

  remove(objects) {
    for (const object of objects) {
      this.scene.remove(object);
      object.geometry.dispose();
      [object.material].flat().forEach((material) => material.dispose());
    }
  }

  /** Shows these objects in place of those of the call before. */
  mark(objects) {
    this.remove(this.marks);
    this.marks = objects;
    if (objects.length) this.scene.add(...objects);
    this.draw();
  }

  /** Sets the colours of the page. */
  dress(style) {
    const parsed = (name) => rgb(style.getPropertyValue(name));
    this.renderer.setClearColor(toHex(parsed("--sky")), 1);
    this.edgeColour = parsed("--edge");
    for (const wall of this.walls) {
      for (const object of wall) object.material.color.setHex(toHex(parsed("--wall")));
    }
  }

  /** Has the camera at the same place as another view. */
  lookAs(other) {
    this.led = true; // the other one knows
    this.camera.position.copy(other.camera.position);
    this.controls.target.copy(other.controls.target);
    [this.camera.near, this.camera.far] = [other.camera.near, other.camera.far];
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.led = false;
    this.draw();
  }

  /** Changes where the camera is, as the offset from its target, and the target. */
  place(change) {
    const { target } = this.controls;
    const offset = this.camera.position.clone().sub(target);
    change(offset, target);
    this.camera.position.copy(target).add(offset);
    this.controls.update();
  }

  /** Has lines of view in parallel, or through one point. */
  flatten(parallel) {
    this.parallel = parallel;
    // The point under the cursor is found with a camera in perspective only.
    this.controls.zoomToCursor = !parallel;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Height of what is seen at the target of the camera. */
  height() {
    const distance = this.camera.position.distanceTo(this.controls.target);
    return 2 * distance * Math.tan((0.5 * this.camera.fov * Math.PI) / 180);
  }

  /** Replaces the projection of the camera by a parallel one, of the same size at its target. */
  project() {
    const { camera, canvas } = this;
    const half = 0.5 * this.height();
    const shift = (2 * half * (camera.view?.offsetX ?? 0)) / (canvas.clientHeight || 1);
    const distance = camera.position.distanceTo(this.controls.target);
    const deep = Math.max(...this.boxes[0].high.map((a, c) => a - this.whole.low[c]), ...this.whole.high.map((a, c) => a - this.whole.low[c]), half);
    camera.projectionMatrix.makeOrthographic(shift - half * camera.aspect, shift + half * camera.aspect, half, -half, distance - 20 * deep, distance + 20 * deep);
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
  }

  /** Looks from a named direction at the whole space that the model sweeps. */
  look(name) {
    const direction = new THREE.Vector3(...VIEWS[name]);
    if (name === "iso" && this.mirrored) direction.x = -direction.x;
    direction.normalize();
    const { low, high } = this.following ? this.boxes[0] : this.whole;
    const middle = new THREE.Vector3(...low.map((a, c) => 0.5 * (a + high[c])));
    // Far enough to see all corners of the box.
    const right = new THREE.Vector3().crossVectors(this.camera.up, direction).normalize();
    const above = new THREE.Vector3().crossVectors(direction, right);
    const slope = Math.tan((0.5 * this.camera.fov * Math.PI) / 180);
    let distance = 0;
    for (let corner = 0; corner < 8; corner++) {
      const at = new THREE.Vector3(...low.map((a, c) => (corner & (1 << c) ? high[c] : a))).sub(middle);
      const across = Math.abs(at.dot(right)) / (this.camera.aspect * this.free);
      distance = Math.max(distance, at.dot(direction) + Math.max(across, Math.abs(at.dot(above))) / slope);
    }
    const size = Math.hypot(...low.map((a, c) => high[c] - a)) || 1;
    distance = 1.08 * Math.max(distance, 1e-3 * size);
    this.camera.position.copy(middle).addScaledVector(direction, distance);
    this.camera.near = 1e-3 * size;
    this.camera.far = 50 * size;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(middle);
    this.moved = [0, 0, 0];
    this.controls.update();
    this.draw();
  }

  /**
   * Moves the camera such that it looks at a point, along a normal if there is one, and near enough that something of this
   * size is seen.
   */
  approach(point, normal, size) {
    this.place((offset, target) => {
      target.set(...point);
      const distance = size > 0 ? Math.min(offset.length(), APPROACH * size) : offset.length();
      if (normal) offset.copy(normal).multiplyScalar(offset.dot(normal) < 0 ? -1 : 1);
      offset.setLength(Math.max(distance, 2 * this.camera.near));
    });
  }

  /** The place of a point on the canvas [pixels]. */
  pixels(point) {
    const { x, y } = point.clone().project(this.camera);
    return { x: 0.5 * (1 + x) * this.canvas.clientWidth, y: 0.5 * (1 - y) * this.canvas.clientHeight };
  }

  /** Shows the model between two frames. `moved` is called before it is drawn. */
  show(first, fraction, way, shown, model, changed, moved = () => {}) {
    const frames = model.frames;
    const last = frames.length - 1;
    const next = Math.min(first + 1, last);
    if (changed) this.surface.show(frames[first], frames[next], way, shown);
    this.surface.between(fraction);
    const time = frames[first].time + fraction * (frames[next].time - frames[first].time);
    this.walls.forEach((objects, number) => {
      const path = this.paths[number];
      if (path) objects.forEach((object) => object.position.set(...gone(path, time)));
    });
    if (this.following) {
      const middle = this.middles[first].map((a, c) => a + fraction * (this.middles[next][c] - a) - this.middles[0][c]);
      const step = new THREE.Vector3(...middle.map((a, c) => a - this.moved[c]));
      this.moved = middle;
      this.camera.position.add(step);
      this.controls.target.add(step);
    }
    moved();
    this.showing = true;
    this.controls.update();
    this.showing = false;
    this.draw();
  }

  edges(on) {
    this.surface.edges(on, this.edgeColour);
  }

  /** Fits the canvas. */
  fit() {
    const { clientWidth, clientHeight } = this.canvas;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setPixelRatio(this.sharpness * Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    // The legend is on the right. The model is in the middle of the remaining width.
    const legend = clientWidth > 4 * LEGEND ? LEGEND : 0;
    this.free = 1 - legend / clientWidth;
    this.camera.setViewOffset(clientWidth, clientHeight, 0.5 * legend, 0, clientWidth, clientHeight);
    this.draw();
  }

  /** Draws with this quality: at once with its pixels, from the next `show` on with its faces. */
  simplify([pixels, faces]) {
    this.surface.coarsen(Math.max(faces, leastShare(this.surface.model)));
    if (pixels === this.sharpness) return;
    this.sharpness = pixels;
    this.fit();
  }

  draw() {
    if (this.parallel) this.project();
    this.renderer.render(this.scene, this.camera);
    this.drawn++;
    this.after();
  }

  /** Share of the pixels that are not background. */
  covered() {
    this.draw();
    const gl = this.renderer.getContext();
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let other = 0;
    for (let i = 4; i < pixels.length; i += 4) if (pixels[i] !== pixels[0] || pixels[i + 1] !== pixels[1]) other++;
    return other / (width * height);
  }

  showWalls(on) {
    for (const wall of this.walls) for (const object of wall) object.visible = on;
    this.draw();
  }
}

/** True without a graphics card. Smoothing would then cost half of each frame, so it is omitted. */
function drawnBySoftware() {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return false;
  const more = context.getExtension("WEBGL_debug_renderer_info");
  const name = String(context.getParameter(more ? more.UNMASKED_RENDERER_WEBGL : context.RENDERER));
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/** The box around all boxes; only the first box if an exploding model would make it too large. */
function whole(boxes) {
  const size = ({ low, high }) => Math.hypot(...low.map((a, c) => high[c] - a));
  const all = {
    low: [0, 1, 2].map((c) => Math.min(...boxes.map((box) => box.low[c]))),
    high: [0, 1, 2].map((c) => Math.max(...boxes.map((box) => box.high[c]))),
  };
  return size(all) > 8 * size(boxes[0]) ? boxes[0] : all;
}

/** True if the model travels so far that the camera must follow it. */
function travels(view) {
  const { low, high } = view.boxes[0];
  const size = Math.hypot(...low.map((a, c) => high[c] - a));
  const last = view.middles[view.middles.length - 1];
  return Math.hypot(...last.map((a, c) => a - view.middles[0][c])) > size;
}

/** Bytes of a colour in style sheet notation (#rrggbb). */
function rgb(text) {
  const number = parseInt(text.trim().slice(1), 16);
  return [(number >> 16) & 255, (number >> 8) & 255, number & 255];
}

function toHex([r, g, b]) {
  return (r << 16) | (g << 8) | b;
}

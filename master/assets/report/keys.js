"use strict";
// The camera of a 3D view by keys.

const VIEW_KEYS =
  "3D model. Arrow keys or drag: rotate. Plus and minus or scroll: zoom. Shift with arrow keys or drag with the right button: move. Home: reset.";
/** Angle of one press [rad]. */
const TURN = Math.PI / 36;
/** Ratio of distances of one press. */
const ZOOM = 1.15;
/** Step of one press, as a fraction of the height of the picture. */
const PAN = 0.05;
/** Least angle between the direction of view and the vertical [rad]. */
const UPRIGHT = 0.01;

/** Lets the canvas of a view have the focus and take keys. */
function takeKeys(view) {
  const { canvas } = view;
  canvas.tabIndex = 0;
  // An application gets the arrow keys also from a screen reader.
  canvas.setAttribute("role", "application");
  canvas.setAttribute("aria-label", VIEW_KEYS);
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (way && event.shiftKey) move(view, ...way);
    else if (way) turn(view, ...way);
    else if (event.key === "+" || event.key === "=") view.place((offset) => offset.divideScalar(ZOOM));
    else if (event.key === "-") view.place((offset) => offset.multiplyScalar(ZOOM));
    else if (event.key === "Home") view.reset();
    else return;
    event.preventDefault();
    event.stopPropagation(); // elsewhere on a page these keys may select a time
  });
}

/** The direction to the right in the picture, when the camera is at `offset` from what it looks at. */
const rightOf = (up, offset) => new THREE.Vector3().crossVectors(up, offset).normalize();

/** Turns the camera around the model: to the right, and up. */
function turn(view, right, up) {
  view.place((offset) => {
    const vertical = view.camera.up;
    const before = offset.angleTo(vertical);
    const after = Math.min(Math.max(before - up * TURN, UPRIGHT), Math.PI - UPRIGHT);
    offset.applyAxisAngle(rightOf(vertical, offset), after - before);
    offset.applyAxisAngle(vertical, right * TURN);
  });
}

/** Moves the camera in the plane of the picture. */
function move(view, right, up) {
  view.place((offset, target) => {
    const height = 2 * offset.length() * Math.tan((0.5 * view.camera.fov * Math.PI) / 180);
    const across = rightOf(view.camera.up, offset);
    const above = new THREE.Vector3().crossVectors(offset, across).normalize();
    target.addScaledVector(across, right * PAN * height).addScaledVector(above, up * PAN * height);
  });
}

"use strict";
// What stands on the stage in addition to the legend: triad and scale bar; and the list of parts.

/** Size of the canvas of triad and scale bar, and length of an axis and of the longest bar [pixels]. */
const STAGE_MARKS = { width: 240, height: 92, axis: 30, bar: 110 };
const AXES = [["x", "#c4342b"], ["y", "#2b8a3e"], ["z", "#2f6fd0"]];

/** Largest of 1, 2 or 5 times a power of ten that is not above a value. */
function roundDown(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return Number(([5, 2, 1].find((f) => f * power <= value * (1 + 1e-9)) * power).toPrecision(6));
}

class StageMarks {
  constructor(canvas, view, unit) {
    Object.assign(this, { canvas, view, unit });
    const ratio = window.devicePixelRatio || 1;
    canvas.width = STAGE_MARKS.width * ratio;
    canvas.height = STAGE_MARKS.height * ratio;
    canvas.style.width = `${STAGE_MARKS.width}px`;
    canvas.style.height = `${STAGE_MARKS.height}px`;
    this.pen = canvas.getContext("2d");
    this.pen.scale(ratio, ratio);
    this.ink = "#000";
    this.last = "";
  }

  /** Draws what has changed since the last time. */
  draw() {
    const { camera, canvas } = this.view;
    const { width, height, axis, bar } = STAGE_MARKS;
    const turned = camera.matrixWorldInverse.elements;
    const perPixel = this.view.height() / (canvas.clientHeight || 1);
    const length = roundDown(bar * perPixel);
    const state = [this.ink, length / perPixel, ...turned.slice(0, 11)].map((x) => (typeof x === "number" ? x.toPrecision(4) : x)).join();
    if (state === this.last) return;
    this.last = state;
    this.length = length;
    const { pen } = this;
    pen.clearRect(0, 0, width, height);
    pen.font = "12px system-ui, sans-serif";
    pen.lineWidth = 2;
    const [x0, y0] = [axis + 12, height - axis - 12];
    // Axes that point away from the camera first.
    const axes = AXES.map(([name, colour], c) => ({ name, colour, at: [0, 1, 2].map((row) => turned[4 * c + row]) }));
    for (const { name, colour, at } of axes.sort((a, b) => a.at[2] - b.at[2])) {
      pen.strokeStyle = pen.fillStyle = colour;
      pen.beginPath();
      pen.moveTo(x0, y0);
      pen.lineTo(x0 + axis * at[0], y0 - axis * at[1]);
      pen.stroke();
      pen.fillText(name, x0 + 1.25 * axis * at[0] - 3, y0 - 1.25 * axis * at[1] + 4);
    }
    const [left, down] = [2 * axis + 36, height - 14];
    pen.strokeStyle = pen.fillStyle = this.ink;
    pen.beginPath();
    pen.moveTo(left, down - 5);
    pen.lineTo(left, down);
    pen.lineTo(left + length / perPixel, down);
    pen.lineTo(left + length / perPixel, down - 5);
    pen.stroke();
    pen.fillText(`${digits(length)} ${this.unit}`.trim(), left + 4, down - 8);
  }
}

/** An open eye, or one that is crossed out. */
function eyeIcon(open) {
  const icon = drawn("svg", { viewBox: "0 0 20 12", width: 20, height: 12, fill: "none", stroke: "currentColor", "stroke-width": 1.4 });
  icon.append(drawn("path", { d: "M1 6Q10 -3 19 6Q10 15 1 6Z" }), drawn("circle", { cx: 10, cy: 6, r: 2.4, fill: "currentColor" }));
  if (!open) icon.append(drawn("path", { d: "M3 11L17 1" }));
  return icon;
}

/** The list of parts: an eye hides or shows a part, a second box makes it transparent. */
function partsList(place, parts, shown, ghosts, changed) {
  place.replaceChildren(
    ...parts.map(({ colour, label, part }) => {
      const item = document.createElement("li");
      const eye = document.createElement("button");
      const dress = () => {
        eye.replaceChildren(eyeIcon(shown[part]));
        eye.setAttribute("aria-pressed", String(shown[part]));
        item.classList.toggle("hidden-part", !shown[part]);
      };
      eye.type = "button";
      eye.className = "eye";
      eye.setAttribute("aria-label", `Show ${label}`);
      eye.addEventListener("click", () => {
        shown[part] = !shown[part];
        dress();
        changed();
      });
      dress();
      const chip = document.createElement("span");
      chip.className = "chip";
      chip.style.background = css(colour);
      const ghost = document.createElement("input");
      ghost.type = "checkbox";
      ghost.checked = ghosts[part];
      ghost.addEventListener("change", () => {
        ghosts[part] = ghost.checked;
        changed();
      });
      const name = document.createElement("span");
      name.className = "name";
      name.append(chip, label);
      const through = document.createElement("label");
      through.append(ghost, " transparent");
      item.append(eye, name, through);
      return item;
    }),
  );
}

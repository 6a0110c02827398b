"use strict";
// What leaves the page: a link to the view, a picture and a film.

/** Frames per second of a film. */
const FILM_RATE = 30;
const FILM_KINDS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];

/** The stage as a canvas: the model with triad, scale bar, time and legend. */
function stageCanvas(page, canvas = document.createElement("canvas")) {
  const views = [page.view, page.second?.view].filter(Boolean);
  views.forEach((view) => view.draw()); // their pixels are valid until the browser shows them
  const [wide, height] = [page.view.canvas.clientWidth, page.view.canvas.clientHeight];
  const width = wide * views.length;
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const pen = canvas.getContext("2d");
  views.forEach((view, i) => pen.drawImage(view.canvas, i * wide, 0, wide, height));
  const marks = page.stageMarks.canvas;
  pen.drawImage(marks, 0, height - STAGE_MARKS.height, STAGE_MARKS.width, STAGE_MARKS.height);
  const style = getComputedStyle(document.documentElement);
  const ink = style.getPropertyValue("--ink").trim();
  pen.fillStyle = ink;
  pen.font = "17px system-ui, sans-serif";
  pen.fillText(byId("clock").textContent, 13, 28);
  page.names().forEach((name, i) => pen.fillText(name, i * wide + 13, 52));
  legendOn(pen, page.way, width, ink);
  return canvas;
}

/** Draws the legend at the right of a canvas. */
function legendOn(pen, way, width, ink) {
  const left = width - 120;
  pen.font = "600 13px system-ui, sans-serif";
  pen.textAlign = "right";
  pen.fillText(withUnit(way.title, way.unit), width - 12, 24);
  pen.textAlign = "left";
  pen.font = "13px system-ui, sans-serif";
  if (way.kinds) {
    way.kinds.forEach(({ colour, label }, i) => {
      pen.fillStyle = css(colour);
      pen.fillRect(left, 36 + 18 * i, 12, 12);
      pen.fillStyle = ink;
      pen.fillText(label, left + 18, 47 + 18 * i);
    });
    return;
  }
  const [top, long] = [36, 170];
  const fade = pen.createLinearGradient(0, top + long, 0, top);
  scaleOf(way).forEach((colour, i) => fade.addColorStop(i / (SCALE.length - 1), css(colour)));
  pen.fillStyle = fade;
  pen.fillRect(left, top, 16, long);
  pen.fillStyle = ink;
  for (let i = 0; i <= 4; i++) pen.fillText(digits(way.low + (i / 4) * (way.top - way.low)), left + 22, top + long * (1 - i / 4) + 4);
}

/** Records the whole animation at the chosen speed; `each` is called with the share that is done. */
async function film(page, each) {
  if (typeof MediaRecorder === "undefined") throw new Error("This browser cannot record films.");
  const type = FILM_KINDS.find((kind) => MediaRecorder.isTypeSupported(kind));
  if (!type) throw new Error("This browser cannot record films.");
  const canvas = stageCanvas(page);
  const stream = canvas.captureStream(FILM_RATE);
  const recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: 8e6 });
  const pieces = [];
  recorder.addEventListener("dataavailable", (event) => pieces.push(event.data));
  const ended = new Promise((done) => recorder.addEventListener("stop", done));
  recorder.start();
  const frames = Math.ceil((FILM * FILM_RATE) / 1000 / Number(byId("speed").value));
  for (let frame = 0; frame <= frames; frame++) {
    page.go(page.begin + (frame / frames) * (page.end - page.begin));
    stageCanvas(page, canvas);
    each(frame / frames);
    await new Promise((done) => setTimeout(done, 1000 / FILM_RATE));
  }
  recorder.stop();
  await ended;
  stream.getTracks().forEach((track) => track.stop());
  return new Blob(pieces, { type: type.split(";")[0] });
}

/** The fragment of an address that shows the page as it is now. */
function fragmentOf(page) {
  const { view, model } = page;
  const on = (id) => byId(id).checked;
  const ids = (flags, wanted) => model.parts.filter((_, i) => flags[i] === wanted).join(",");
  const short = (x) => Number(x.toPrecision(7));
  const said = new URLSearchParams();
  said.set("time", short(page.time));
  said.set("colour", page.way.title);
  if (!page.way.kinds) said.set("scale", `${page.way.low},${page.way.top}`);
  said.set("camera", [...view.camera.position.toArray(), ...view.controls.target.toArray()].map(short).join(","));
  for (const id of ["edges", "walls"]) if (!on(id)) said.set(id, "0");
  for (const id of ["smooth", "parallel", "forces", "node-forces"]) if (on(id)) said.set(id, "1");
  said.set("follow", on("follow") ? "1" : "0");
  if (byId("magnify").value !== "1") said.set("magnify", byId("magnify").value);
  if (byId("cut-axis").value !== "none") said.set("cut", [byId("cut-axis").value, byId("cut-place").value, on("cut-flip") ? 1 : 0].join(","));
  if (ids(page.shown, false)) said.set("hidden", ids(page.shown, false));
  if (ids(view.surface.style.ghosts, true)) {
    said.set("ghosts", ids(view.surface.style.ghosts, true));
    said.set("opacity", byId("opacity").value);
  }
  const { element, node } = page.picker;
  if (element >= 0) said.set("element", model.elementIds[element]);
  else if (node >= 0) said.set("node", model.nodeIds[node]);
  return said.toString();
}

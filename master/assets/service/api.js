"use strict";
// Requests to the service. All text of users goes into the page by `textContent`.

/** A refusal of the service. */
class Refused extends Error {
  constructor(status, why) {
    super(why);
    this.status = status;
  }
}

const byId = (id) => document.getElementById(id);

async function ask(path, options = {}) {
  const response = await fetch(path, { credentials: "same-origin", ...options });
  if (response.ok) return response;
  const body = await response.json().catch(() => ({}));
  throw new Refused(response.status, body.error || `the service answered ${response.status}`);
}

const getJson = async (path) => (await ask(path)).json();

async function postJson(path, body) {
  const options = { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  return (await ask(path, options)).json();
}

/** Sends files with the progress of the transfer. */
function sendForm(path, form, progress) {
  return new Promise((done, failed) => {
    const request = new XMLHttpRequest();
    request.open("POST", path);
    request.responseType = "json";
    request.upload.onprogress = (event) => progress(event.loaded / event.total);
    request.onerror = () => failed(new Refused(0, "the service does not answer"));
    request.onload = () => {
      if (request.status === 201) done(request.response);
      else failed(new Refused(request.status, (request.response || {}).error || `the service answered ${request.status}`));
    };
    request.send(form);
  });
}

function show(why) {
  const place = byId("message");
  place.hidden = !why;
  place.textContent = why || "";
}

/** Makes an element with text and attributes. */
function element(name, text, attributes = {}) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

const when = (seconds) => (seconds ? new Date(1000 * seconds).toLocaleString() : "–");

function badge(state) {
  return element("span", state, { class: `state state-${state}` });
}

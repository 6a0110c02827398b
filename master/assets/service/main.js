"use strict";
// Which page is shown, and the session.

const views = { jobs: new JobList(), new: new NewJob(), run: new RunPage(), compare: new ComparePage() };
let current = null;
let about = null;

/** Carries out a request, and shows a refusal. Without a session it shows the login. */
async function guarded(request) {
  try {
    const answer = await request();
    show("");
    return answer;
  } catch (error) {
    if (error.status === 401) login();
    show(error.message);
    return null;
  }
}

function reveal(name) {
  for (const id of ["login", "jobs", "new", "run", "compare"]) byId(id).hidden = id !== name;
}

function login() {
  if (current) views[current].close();
  current = null;
  about = null;
  byId("who").hidden = true;
  byId("leave").hidden = true;
  reveal("login");
  byId("token").focus();
}

async function begin(token) {
  const options = { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify({ token }) };
  return guarded(() => ask("/login", options));
}

async function route() {
  const given = location.hash.match(/^#token=([0-9a-f]{64})$/);
  if (given) {
    history.replaceState(null, "", "/#/");
    await begin(given[1]);
  }
  if (!about) about = await guarded(() => getJson("/api/about"));
  if (!about) return;
  byId("who").textContent = `${about.name} (${about.role})`;
  byId("who").hidden = false;
  byId("leave").hidden = false;
  const job = location.hash.match(/^#\/job\/(\d+)$/);
  const pair = location.hash.match(/^#\/compare\/(\d+)\/(\d+)$/);
  const name = job ? "run" : pair ? "compare" : location.hash === "#/new" ? "new" : "jobs";
  if (current) views[current].close();
  current = name;
  document.title = "Crumple";
  reveal(name);
  views[name].open(about, pair ? [Number(pair[1]), Number(pair[2])] : job && Number(job[1]));
}

byId("login-form").addEventListener("submit", async (event) => {
  event.preventDefault();
  const done = await begin(byId("token").value.trim());
  byId("token").value = "";
  if (done) route();
});
byId("leave").addEventListener("click", async () => {
  await guarded(() => ask("/logout", { method: "POST" }));
  login();
});
addEventListener("hashchange", route);
route();

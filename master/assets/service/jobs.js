"use strict";
// The list of jobs, and the form for a new one.

const STATES = ["checking", "checked", "queued", "starting", "running", "completed", "refused", "failed", "lost", "stopped"];
const REFRESH = 2000;

class JobList {
  constructor() {
    this.timer = null;
    for (const state of STATES) byId("filter-state").append(element("option", state, { value: state }));
    byId("filter").addEventListener("submit", (event) => {
      event.preventDefault();
      this.load();
    });
    byId("jobs-more").addEventListener("click", () => this.load(this.next));
  }

  open() {
    this.load();
    this.timer = setInterval(() => {
      if (!document.hidden && !this.paged) this.load();
    }, REFRESH);
  }

  close() {
    clearInterval(this.timer);
  }

  async load(before) {
    const query = new URLSearchParams({ limit: "50" });
    if (byId("filter-state").value) query.set("state", byId("filter-state").value);
    if (byId("filter-name").value) query.set("name", byId("filter-name").value);
    if (before) query.set("before", before);
    this.paged = Boolean(before);
    const page = await guarded(() => getJson(`/api/jobs?${query}`));
    if (!page) return;
    const rows = page.jobs.map((job) => this.row(job));
    const focused = document.activeElement && document.activeElement.dataset.job;
    if (before) byId("jobs-rows").append(...rows);
    else byId("jobs-rows").replaceChildren(...rows);
    if (focused) byId("jobs-rows").querySelector(`[data-job="${focused}"]`)?.focus();
    byId("jobs-count").textContent = page.total === 1 ? "1 job" : `${page.total} jobs`;
    this.next = page.next;
    byId("jobs-more").hidden = !page.next;
  }

  row(job) {
    const row = element("tr");
    const link = element("a", `${job.id}`, { href: `#/job/${job.id}`, "data-job": job.id });
    const cells = [link, job.name, badge(job.state), job.workers, job.owner, when(job.submitted), job.reason];
    for (const cell of cells) {
      const place = element("td");
      place.append(cell);
      row.append(place);
    }
    return row;
  }
}

class NewJob {
  constructor() {
    byId("new-form").addEventListener("submit", (event) => {
      event.preventDefault();
      this.send(event.submitter && event.submitter.value === "check");
    });
  }

  open(about) {
    const names = Object.keys(about.launchers);
    byId("new-launcher").replaceChildren(...names.map((name) => element("option", name, { value: name })));
    if (names.includes("threads")) byId("new-launcher").value = "threads";
    byId("new-workers").max = Math.max(...Object.values(about.launchers));
    byId("new-check").hidden = true;
  }

  close() {
    if (this.source) this.source.close();
    this.source = null;
  }

  /** Shows the findings of a job here when it is checked, so that its files can be corrected and sent again. */
  follow(id) {
    this.close();
    const source = new EventSource(`/api/jobs/${id}/events`);
    this.source = source;
    byId("new-check-title").textContent = "The files are being checked …";
    byId("new-check-job").textContent = `Job ${id}`;
    byId("new-check-job").href = `#/job/${id}`;
    byId("new-check-findings").replaceChildren();
    byId("new-check").hidden = false;
    source.addEventListener("state", async (event) => {
      if (JSON.parse(event.data).state === "checking" || this.source !== source) return;
      source.close();
      const found = await guarded(() => getJson(`/api/jobs/${id}/check`));
      if (!found || this.source !== source) return;
      const result = found.usable ? "The job can run" : "The job cannot run";
      byId("new-check-title").textContent = `${result}: ${summaryOf(found)}`;
      showFindings(byId("new-check-findings"), found);
      byId("new-check-title").focus();
    });
    source.addEventListener("error", () => {
      // The browser tries again by itself, except after a refusal.
      if (source.readyState === EventSource.CLOSED && this.source === source) {
        byId("new-check-title").textContent = "The state of the check is not known: the service refuses to tell it. Sign in again.";
      }
    });
  }

  async send(checkOnly) {
    const form = new FormData();
    const lines = byId("new-set").value.split("\n").map((line) => line.trim());
    const options = {
      name: byId("new-name").value,
      workers: Number(byId("new-workers").value),
      launcher: byId("new-launcher").value,
      priority: Number(byId("new-priority").value),
      set: lines.filter((line) => line),
      check_only: checkOnly,
    };
    form.append("options", JSON.stringify(options));
    const plain = [...byId("new-files").files].map((file) => [file, file.name]);
    // A folder comes with its own name, which is no part of the job.
    const inside = (file) => file.webkitRelativePath.split("/").slice(1).join("/");
    const folder = [...byId("new-folder").files].map((file) => [file, inside(file)]);
    const files = [...plain, ...folder].filter(([, name]) => !name.split("/").some((part) => part.startsWith(".")));
    if (files.length === 0) return show("Choose the files of the job.");
    for (const [file, name] of files) form.append("file", file, name);
    const bar = byId("new-progress");
    bar.hidden = false;
    const job = await guarded(() => sendForm("/api/jobs", form, (share) => (bar.value = share)));
    bar.hidden = true;
    if (!job) return;
    if (checkOnly) this.follow(job.id);
    else location.hash = `#/job/${job.id}`;
  }
}

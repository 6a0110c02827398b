"use strict";
// Starts the page: that of a run, or that of a job before its run.

async function begin() {
  const facts = JSON.parse(byId("facts").textContent);
  const page = facts.setup ? new ModelPage(facts) : new Page(facts);
  window.crumple = page;
  page.dark.addEventListener("change", () => page.dress());
  if (page.plots) resized(byId("plots"), () => page.plots.fit());
  try {
    await page.histories();
  } catch (error) {
    page.withoutHistories(error.message);
  }
  try {
    await page.picture();
    root.dataset.state = "ready";
  } catch (error) {
    withoutPicture(error.message);
    root.dataset.state = "without-picture";
  }
}

begin();

"use strict";
// What `crumple check` found in a job: errors and warnings with their lines.

const GROUPS = [["error", "errors"], ["warning", "warnings"]];

const countOf = (count, name) => `${count} ${count === 1 ? name : `${name}s`}`;

/** One line that counts the findings. */
function summaryOf({ findings, more }) {
  const counts = GROUPS.map(([name]) => [findings.filter((finding) => finding.severity === name).length, name]);
  const words = counts.filter(([count]) => count).map(([count, name]) => countOf(count, name));
  if (more) words.push(`${more} more`);
  return words.length ? words.join(", ") : "no errors, no warnings";
}

/** The line of the input with a mark under the column, as in a terminal. */
function sourceOf({ line, text, mark }) {
  const margin = " ".repeat(String(line).length);
  const source = element("pre", undefined, { class: "source" });
  source.append(element("span", `${line} | `, { class: "quiet" }), text);
  if (mark) source.append("\n", element("span", `${margin} | `, { class: "quiet" }), " ".repeat(mark.start), element("span", "^".repeat(mark.length), { class: "mark" }));
  return source;
}

function itemOf({ severity, message, help, place, set }) {
  const item = element("li", undefined, { class: `finding finding-${severity}`, tabindex: "0" });
  item.append(element("p", message));
  if (place) {
    item.append(element("p", `${place.file}, line ${place.line}, column ${place.column}`, { class: "place" }));
    // A line as a whole is the place of what the file does not have.
    if (place.mark) item.append(sourceOf(place));
  }
  if (set) item.append(element("p", `change ${set}`, { class: "place" }));
  if (help) item.append(element("p", `help: ${help}`, { class: "quiet" }));
  return item;
}

/** Shows findings in a place. */
function showFindings(place, found) {
  const groups = GROUPS.flatMap(([severity, title]) => {
    const of = found.findings.filter((finding) => finding.severity === severity);
    if (!of.length) return [];
    const list = element("ol", undefined, { class: "findings" });
    list.append(...of.map(itemOf));
    return [element("h4", title[0].toUpperCase() + title.slice(1)), list];
  });
  if (found.more) groups.push(element("p", `${found.more} more findings are not listed.`, { class: "notice" }));
  const text = element("details");
  text.append(element("summary", "Text of the check"), element("pre", found.text, { class: "text", tabindex: "0" }));
  place.replaceChildren(...groups, text);
}

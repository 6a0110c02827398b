"use strict";
// What stands on the stage: the legend of the colours, and the time.

/** A scale with ticks, or a list of categories. The entries of parts hide and show them. */
function legend(place, way, shown, changed) {
  const make = (name, className, text) => {
    const element = document.createElement(name);
    if (className) element.className = className;
    if (text !== undefined) element.textContent = text;
    return element;
  };
  place.textContent = "";
  place.append(make("div", "title", way.unit ? `${way.title} [${way.unit}]` : way.title));
  if (!way.kinds) {
    const scale = make("div", "scale");
    const bar = make("div", "bar");
    bar.style.background = `linear-gradient(to top, ${scaleOf(way).map(css).join(",")})`;
    scale.append(bar);
    for (let i = 4; i >= 0; i--) {
      const above = i === 4 && way.most > way.top + 1e-6 * Math.abs(way.top);
      const below = i === 0 && way.least < way.low - 1e-6 * Math.abs(way.low);
      scale.append(make("span", "tick", (above ? "≥ " : below ? "≤ " : "") + digits(way.low + (i / 4) * (way.top - way.low))));
    }
    const least = way.least < 0 ? `least ${digits(way.least)}, ` : "";
    place.append(scale, make("p", "most", `${least}largest ${digits(way.most)}`));
    return;
  }
  const list = make("ul");
  for (const kind of way.kinds) {
    const item = make("li");
    const chip = make("span", "chip");
    chip.style.background = css(kind.colour);
    const label = kind.part === undefined ? make("span", "", "") : make("button");
    label.append(chip, kind.label);
    if (kind.part !== undefined) {
      label.type = "button";
      label.title = "hide or show";
      label.setAttribute("aria-pressed", String(shown[kind.part]));
      label.addEventListener("click", () => {
        shown[kind.part] = !shown[kind.part];
        label.setAttribute("aria-pressed", String(shown[kind.part]));
        changed();
      });
    }
    item.append(label);
    list.append(item);
  }
  place.append(list);
}

/** A time with as many digits as the time span needs. */
function clock(time, span) {
  if (!(span > 0)) return digits(time);
  const places = 3 - Math.floor(Math.log10(span));
  return places > 7 ? time.toExponential(3) : time.toFixed(Math.max(places, 0));
}

/** Calls a function when the size of an element changes, after the layout of the page. */
function resized(element, act) {
  new ResizeObserver(() => requestAnimationFrame(act)).observe(element);
}

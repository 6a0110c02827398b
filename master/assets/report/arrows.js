"use strict";
// Arrows of lines.

/** Length of the largest arrow and of its head, as fractions of the size of the model and of the arrow. */
const ARROW = { length: 0.3, head: 0.2 };

/** Coordinates of the lines of an arrow, two points each. */
function arrow(from, along) {
  const to = from.clone().add(along);
  const points = [...from, ...to];
  for (const side of square(along.clone().normalize())) {
    for (const sign of [-1, 1]) points.push(...to, ...to.clone().addScaledVector(along, -ARROW.head).addScaledVector(side, 0.4 * sign * ARROW.head * along.length()));
  }
  return points;
}

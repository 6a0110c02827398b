"use strict";
// A slider over the times of the outputs; its last place is the present state.

class TimeSlider {
  /** `go` is called with a time, or null for the present state. */
  constructor(slider, text, go) {
    this.slider = slider;
    this.text = text;
    this.times = [];
    this.unit = "";
    slider.addEventListener("input", () => {
      this.label();
      go(this.chosen());
    });
  }

  /** The chosen time; null for the present state. */
  chosen() {
    return this.times[Number(this.slider.value)] ?? null;
  }

  clear() {
    this.set([]);
  }

  /** Takes the times of the outputs, and keeps what is chosen. */
  set(times) {
    const time = this.times.length ? this.chosen() : null;
    this.times = times;
    this.slider.max = times.length;
    this.slider.value = time === null ? times.length : times.findIndex((t) => t >= time);
    this.slider.disabled = times.length < 2;
    this.label();
  }

  label() {
    const time = this.chosen();
    const words = time === null ? "newest" : `${digits(time, 5)} ${this.unit}`;
    this.text.textContent = words;
    this.slider.setAttribute("aria-valuetext", words);
  }
}

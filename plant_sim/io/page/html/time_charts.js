// SPDX-License-Identifier: Apache-2.0
// Charts over time that show one stretch and one cursor together.
"use strict";

voltlap.TimeCharts = class {
  #times;
  #end;
  #laps;
  #window;
  #charts;
  #from;
  #to;
  #cursor = null;
  #pending = false;
  #shortest;

  /**
   * @param root     element that the charts are put into
   * @param times    Float64Array, seconds, increasing
   * @param end_s    where the time axis ends
   * @param laps     [{end_s}], drawn as faint lines
   * @param window_s length of a lap, for running means; null for none
   * @param specs    the charts
   * @param listener {view(from, to), cursor(index or null)}, told of each change
   */
  constructor({ root, times, end_s, laps, window_s, specs, listener, describedBy }) {
    this.#times = times;
    this.#end = end_s;
    this.#laps = laps;
    this.#window = window_s;
    this.#from = 0;
    this.#to = end_s;
    this.#shortest = Math.min(end_s, 10 * (times.length > 1 ? times[1] - times[0] : 1));
    this.listener = listener;
    // The page is laid out once: first all places, then all charts.
    this.#charts = specs.map((spec) => new voltlap.TimeChart(root, spec, this, describedBy));
    for (const chart of this.#charts) chart.open();
    listener.view(this.#from, this.#to);
  }

  get times() {
    return this.#times;
  }
  get end() {
    return this.#end;
  }
  get laps() {
    return this.#laps;
  }
  get window() {
    return this.#window;
  }
  get view() {
    return [this.#from, this.#to];
  }
  get cursor() {
    return this.#cursor;
  }
  get showsMeans() {
    return this.#window !== null && this.#to - this.#from > 8 * this.#window;
  }

  /** Shows the stretch from..to in every chart; it is kept inside the run and not shorter than ten samples. */
  show(from, to) {
    const length = Math.min(Math.max(to - from, this.#shortest), this.#end);
    const start = Math.min(Math.max((from + to - length) / 2, 0), this.#end - length);
    if (start === this.#from && start + length === this.#to) return;
    this.#from = start;
    this.#to = start + length;
    if (this.#pending) return;
    this.#pending = true;
    requestAnimationFrame(() => {
      this.#pending = false;
      for (const chart of this.#charts) chart.showView();
      this.listener.view(this.#from, this.#to);
      this.setCursor(this.#cursor);
    });
  }

  showAll() {
    this.show(0, this.#end);
  }

  /** Zooms by a factor (below 1: closer) about a time that stays where it is. */
  zoom(factor, about) {
    this.show(about - (about - this.#from) * factor, about + (this.#to - about) * factor);
  }

  move(seconds) {
    const length = this.#to - this.#from;
    const from = Math.min(Math.max(this.#from + seconds, 0), this.#end - length);
    this.show(from, from + length);
  }

  /** Time in seconds, or null to take the cursor away; `owner` is the chart that shows it as a tooltip. */
  setCursor(time, owner = null) {
    this.#cursor = time === null ? null : Math.min(Math.max(time, this.#times[0]), this.#times[this.#times.length - 1]);
    const index = this.#cursor === null ? null : voltlap.indexAt(this.#times, this.#cursor + 1e-6);
    for (const chart of this.#charts) chart.showCursor(index, chart === owner);
    this.listener.cursor(index);
  }

  /** Arrow keys step over the view in hundredths; the view follows the cursor. */
  stepCursor(hundredths, owner) {
    const length = this.#to - this.#from;
    const time = (this.#cursor ?? (this.#from + this.#to) / 2) + (hundredths / 100) * length;
    if (time < this.#from || time > this.#to) this.move((hundredths / 100) * length);
    this.setCursor(time, owner);
  }

  redraw() {
    for (const chart of this.#charts) chart.draw();
  }
};

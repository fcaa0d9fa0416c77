// SPDX-License-Identifier: Apache-2.0
// Charts over time or distance that show one stretch and one cursor together.
//
// A frame says what the charts draw along their axis: {axis, layers, begin, end, laps, window, at}
//   axis    one of voltlap.axes; one with inView(from, to) is another in each view
//   layers  [{name, color, x, values(series), breaks}]: curves of the same signal over each other. x increases; values
//           may end before it does. With one layer alone each signal keeps its own colour. breaks: indices, in order,
//           of points that are not joined to the one before: nothing was recorded in between
//   end     where the axis ends; begin: where it begins, 0 without; laps: places of faint lines on it
//   window  length of a lap, for running means, or null
//   at      from a time of the run to a place on the axis; null where layers begin at different times
"use strict";

/** The unit in which a stretch of time has few digits: s below ten minutes, min below three hours, h above. */
voltlap.elapsedUnit = (span_s) => {
  if (span_s < 600) return { name: "s", seconds: 1 };
  return span_s < 10800 ? { name: "min", seconds: 60 } : { name: "h", seconds: 3600 };
};

/** Digits behind the point that tell `step_s` apart. */
voltlap.elapsedDigits = (step_s, unit) =>
  Math.min(6, Math.max(0, Math.ceil(-Math.log10(step_s / unit.seconds) - 1e-9)));

/** A time in a view from..to, to a thousandth of it: "12.34 h". */
voltlap.elapsed = (time_s, from, to) => {
  const unit = voltlap.elapsedUnit(to - from);
  return voltlap.quantity(time_s / unit.seconds, voltlap.elapsedDigits((to - from) / 300, unit), unit.name);
};

/** The stretch itself: "0 to 344.05 h". */
voltlap.elapsedStretch = (from, to) => {
  const begin = from === 0 ? "0" : voltlap.elapsed(from, from, to).split(" ")[0];
  return `${begin} to ${voltlap.elapsed(to, from, to)}`;
};

voltlap.elapsedAxis = {
  inView: (from, to) => {
    const unit = voltlap.elapsedUnit(to - from);
    return {
      name: () => `time, ${unit.name}`,
      steps: [-2, -1, 0, 1, 2, 3, 4].flatMap((power) => [1, 2, 5].map((k) => k * 10 ** power * unit.seconds)),
      text: (value, step) => (value / unit.seconds).toFixed(voltlap.elapsedDigits(step, unit)),
    };
  },
  shortest: 1,
};

voltlap.axes = {
  time: {
    name: () => "time, min:s",
    steps: [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 18000, 36000, 86400],
    text: (value, step) => voltlap.clock(value, step < 1 ? 1 : 0),
    shortest: 1,
  },
  distance: {
    name: (end) => (end > 3000 ? "distance, km" : "distance, m"),
    steps: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000, 100000],
    text: (value, step, end) =>
      end > 3000 ? (value / 1000).toFixed(step >= 1000 ? 0 : step >= 100 ? 1 : step >= 10 ? 2 : 3) : value.toFixed(0),
    shortest: 10,
  },
};

voltlap.TimeCharts = class {
  #frame;
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
   * @param axis     in place of min:s
   * @param breaks   of the only layer: see above
   * @param frame    in place of all these: see above
   * @param specs    the charts
   * @param listener {view(from, to), cursor(index or null)}, told of each change
   */
  constructor({ root, times, end_s, laps, window_s, specs, listener, describedBy, frame, axis, breaks }) {
    this.#setFrame(
      frame ?? {
        axis: { ...(axis ?? voltlap.axes.time), shortest: 10 * (times.length > 1 ? times[1] - times[0] : 1) },
        layers: [{ x: times, values: (series) => series.values, breaks }],
        end: end_s,
        laps: laps.map((lap) => lap.end_s),
        window: window_s,
        at: (time) => time,
      },
    );
    this.listener = listener;
    // The page is laid out once: first all places, then all charts.
    this.#charts = specs.map((spec) => new voltlap.TimeChart(root, spec, this, describedBy));
    for (const chart of this.#charts) chart.open();
    listener.view(this.#from, this.#to);
  }

  #setFrame(frame) {
    this.#frame = frame;
    this.#from = this.begin;
    this.#to = frame.end;
    this.#shortest = Math.min(frame.end - this.begin, frame.axis.shortest);
  }

  /** Draws another frame, all of it. */
  showFrame(frame) {
    this.#setFrame(frame);
    this.redraw();
    this.listener.view(this.#from, this.#to);
    this.setCursor(null);
  }

  get frame() {
    return this.#frame;
  }
  get begin() {
    return this.#frame.begin ?? 0;
  }
  get end() {
    return this.#frame.end;
  }
  get view() {
    return [this.#from, this.#to];
  }
  get cursor() {
    return this.#cursor;
  }
  get showsMeans() {
    const { window } = this.#frame;
    return window !== null && this.#to - this.#from > 8 * window;
  }

  /** Shows the stretch from..to in every chart; it is kept inside the run and not shorter than ten samples. */
  show(from, to) {
    const length = Math.min(Math.max(to - from, this.#shortest), this.end - this.begin);
    const start = Math.min(Math.max((from + to - length) / 2, this.begin), this.end - length);
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
    this.show(this.begin, this.end);
  }

  /** Zooms by a factor (below 1: closer) about a time that stays where it is. */
  zoom(factor, about) {
    this.show(about - (about - this.#from) * factor, about + (this.#to - about) * factor);
  }

  move(seconds) {
    const length = this.#to - this.#from;
    const from = Math.min(Math.max(this.#from + seconds, this.begin), this.end - length);
    this.show(from, from + length);
  }

  /** A place on the axis, or null to take the cursor away; `owner` is the chart that shows it as a tooltip. */
  setCursor(place, owner = null) {
    const { x } = this.#frame.layers[0];
    const last = this.#frame.at === null ? this.end : x[x.length - 1];
    this.#cursor = place === null ? null : Math.min(Math.max(place, this.#frame.at === null ? 0 : x[0]), last);
    const index = this.#cursor === null ? null : voltlap.indexAt(x, this.#cursor + 1e-6);
    for (const chart of this.#charts) chart.showCursor(index, chart === owner);
    this.listener.cursor(index, this.#cursor);
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

// SPDX-License-Identifier: Apache-2.0
// A signal with times of its own for voltlap.TimeChart, thinned to what a view can show: of each pixel column the
// first, lowest, highest and last point are drawn, so that no spike is lost. What is not known is not drawn: the line
// ends before a gap and begins anew behind it.
"use strict";

voltlap.OwnTimes = class {
  #times;
  #values;
  #begins; // indices of points that are not joined to the one before, in order
  #stepped;

  /**
   * @param times   Float64Array, never decreasing; values: as many
   * @param begins  indices of points that are not joined to the one before
   * @param stepped a value lasts until the next
   */
  constructor(times, values, begins, stepped) {
    this.#times = times;
    this.#values = values;
    this.#begins = begins;
    this.#stepped = stepped;
  }

  /** Index of the first begin after point i. */
  #beginAfter(i) {
    let low = 0,
      high = this.#begins.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.#begins[middle] <= i) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** Value at a time as it is drawn; null where the signal is not known. */
  valueAt(time) {
    const times = this.#times;
    const last = times.length - 1;
    if (last < 0 || time < times[0]) return null;
    const i = voltlap.indexAt(times, time);
    if (times[i] === time) return this.#values[i];
    if (i === last || this.#begins[this.#beginAfter(i)] === i + 1) return null;
    if (this.#stepped) return this.#values[i];
    const part = (time - times[i]) / (times[i + 1] - times[i]);
    return this.#values[i] + part * (this.#values[i + 1] - this.#values[i]);
  }

  /** x, value, x, value ... of a view; NaN where the line ends. It reaches both edges of the view. */
  points(from, to, width) {
    const times = this.#times;
    const out = [];
    if (!times.length) return Float64Array.from(out);
    const atEdge = (time) => {
      const value = this.valueAt(time);
      if (value !== null) out.push(time, value);
    };
    if (times[0] < from) atEdge(from);
    const first = times[0] >= from ? 0 : voltlap.indexAt(times, from) + 1;
    const columns = Math.max(Math.floor(width), 100);
    const step = (to - from) / columns;
    let next = this.#beginAfter(first - 1);
    let i = first;
    while (i < times.length && times[i] <= to) {
      if (this.#begins[next] === i) {
        if (out.length) out.push(times[i], NaN);
        next += 1;
      }
      i = this.#column(i, from + (Math.floor((times[i] - from) / step) + 1) * step, to, this.#begins[next], out);
    }
    atEdge(to);
    return Float64Array.from(out);
  }

  /** Draws the points from i that lie before `end` and before the next begin; the index behind them. */
  #column(i, end, to, begin = Infinity, out) {
    const times = this.#times;
    const values = this.#values;
    let low = i,
      high = i,
      j = i + 1;
    for (; j < times.length && j < begin && times[j] < end && times[j] <= to; j += 1) {
      if (values[j] < values[low]) low = j;
      if (values[j] > values[high]) high = j;
    }
    let drawn = -1;
    for (const k of [i, Math.min(low, high), Math.max(low, high), j - 1]) {
      if (k > drawn) out.push(times[k], values[k]);
      drawn = Math.max(drawn, k);
    }
    return j;
  }
};

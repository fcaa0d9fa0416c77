// SPDX-License-Identifier: Apache-2.0
// Signals over time: how to read what HtmlSeries wrote (encoding: io/page/html_series.hpp), and what charts draw.
"use strict";

/** @returns {Float64Array} the samples in the signal's unit */
voltlap.decode = ({ resolution, deltas }, length) => {
  const bytes = atob(deltas);
  const values = new Float64Array(length);
  let at = 0,
    sum = 0;
  for (let i = 0; i < length; i += 1) {
    let value = 0,
      weight = 1,
      byte;
    do {
      byte = bytes.charCodeAt(at);
      at += 1;
      value += (byte & 0x7f) * weight;
      weight *= 128;
    } while (byte & 0x80);
    sum += value % 2 ? -(value + 1) / 2 : value / 2;
    values[i] = sum * resolution;
  }
  return values;
};

/** Value at `time` of the straight lines between samples; the first or last sample's beyond them. */
voltlap.valueAt = (times, values, time) => {
  const i = voltlap.indexAt(times, time);
  const next = Math.min(i + 1, times.length - 1);
  const part = times[next] > times[i] ? Math.min(Math.max((time - times[i]) / (times[next] - times[i]), 0), 1) : 0;
  return values[i] + part * (values[next] - values[i]);
};

/** Index of the last time that is not after `time`, at least 0. */
voltlap.indexAt = (times, time) => {
  let low = 0,
    high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
};

/** Samples as x, value, x, value ..., with the true extreme {x, value} put in where it belongs; values may end early. */
voltlap.withExtreme = (xs, values, extreme = null) => {
  const at = extreme ? voltlap.indexAt(xs, extreme.x) + (extreme.x >= xs[0] ? 1 : 0) : -1;
  const points = new Float64Array(2 * (Math.min(xs.length, values.length) + (extreme ? 1 : 0)));
  for (let i = 0, j = 0; j < points.length / 2; j += 1) {
    if (j === at) {
      points.set([extreme.x, extreme.value], 2 * j);
    } else {
      points[2 * j] = xs[i];
      points[2 * j + 1] = values[i];
      i += 1;
    }
  }
  return points;
};

/** Running mean over the window, at 300 times; nothing where the window does not fit. */
voltlap.runningMeans = (times, values, window) => {
  const sums = new Float64Array(values.length + 1);
  for (let i = 0; i < values.length; i += 1) sums[i + 1] = sums[i] + values[i];
  const first = times[0] + window / 2;
  const last = times[times.length - 1] - window / 2;
  const count = last > first ? 300 : 0;
  return Array.from({ length: count }, (unused, k) => {
    const time = first + ((last - first) * k) / (count - 1);
    const a = voltlap.indexAt(times, time - window / 2);
    const b = voltlap.indexAt(times, time + window / 2);
    return [time, (sums[b + 1] - sums[a]) / (b + 1 - a)];
  });
};

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

/** Samples as time, value, time, value ..., with the true extreme put in where it belongs. */
voltlap.withExtreme = (times, { values, extreme }) => {
  const at = extreme ? voltlap.indexAt(times, extreme.time_s) + (extreme.time_s >= times[0] ? 1 : 0) : -1;
  const points = new Float64Array(2 * (times.length + (extreme ? 1 : 0)));
  for (let i = 0, j = 0; j < points.length / 2; j += 1) {
    if (j === at) {
      points.set([extreme.time_s, extreme.value], 2 * j);
    } else {
      points[2 * j] = times[i];
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

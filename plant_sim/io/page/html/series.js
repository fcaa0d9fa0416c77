// SPDX-License-Identifier: Apache-2.0
// Signals over time: how to read what HtmlSeries wrote (encoding: io/page/html_series.hpp), and the parts that a chart
// is drawn of.
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

/** x, value, x, value ... with a point without a value before each break, so that the line ends there. */
voltlap.broken = (points, breaks) => {
  if (!breaks?.length) return points;
  const out = new Float64Array(points.length + 2 * breaks.length);
  let from = 0,
    at = 0;
  for (const index of [...breaks, points.length / 2]) {
    out.set(points.subarray(2 * from, 2 * index), at);
    at += 2 * (index - from);
    if (at < out.length) out.set([points[2 * index], NaN], at);
    at += 2;
    from = index;
  }
  return out;
};

/** Samples as x, value, x, value ..., with the true extreme {x, value} put in its place; values may end before x. */
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

voltlap.strokes = {
  signal: { width: 1.5 },
  reference: { width: 5 },
  pale: { width: 1 },
  limit: { width: 1.3, type: [5, 3] },
  second: { width: 1.1, type: [3, 3] },
};

/** What is drawn, bottom to top: {name, data(), color, stroke, z, samples or means of which series}. */
voltlap.chartLines = (spec, { layers, window, at }) => {
  if (spec.family?.fits({ layers })) return spec.family.lines({ layers, at });
  const signals = spec.series.filter(({ role }) => !role);
  if (at === null) {
    const curves = layers.flatMap((layer) =>
      signals.map((one, i) => ({
        name: `${one.name}, ${layer.name}`,
        data: voltlap.withExtreme(layer.x, layer.values(one)),
        color: layer.color,
        stroke: voltlap.strokes[i ? "second" : "signal"],
        z: 5 - i,
        role: "samples",
      })),
    );
    return [...curves, ...layers.flatMap((layer) => voltlap.meanLines(spec, layer, window, layer.color))];
  }
  const [layer] = layers;
  const lines = spec.series.map((one, i) => {
    const extreme = one.extreme ? { x: at(one.extreme.time_s), value: one.extreme.value } : null;
    return {
      name: one.name,
      data: one.points ? null : voltlap.broken(voltlap.withExtreme(layer.x, layer.values(one), extreme), layer.breaks),
      points: one.points,
      step: one.step,
      color: voltlap.color(one.color),
      stroke: voltlap.strokes[one.role ?? "signal"],
      z: { reference: 2, limit: 6 }[one.role] ?? 5 - i,
      role: one.role ?? "samples",
      mark: one.extreme?.text ? { ...one.extreme, x: extreme.x } : null,
    };
  });
  return [...lines, ...voltlap.meanLines(spec, layer, window)];
};

/** The running means of a chart's signals; in one colour, or each in its own. */
voltlap.meanLines = (spec, layer, window, color = null) => {
  if (!spec.means || window === null) return [];
  return spec.series.filter(({ role }) => !role).map((one) => ({
    name: `${one.name}, mean over a lap`,
    data: voltlap.runningMeans(layer.x, layer.values(one), window),
    color: color ?? voltlap.color(one.color),
    stroke: { width: 2.2 },
    z: 7,
    role: "means",
  }));
};

/** Opacity of a line by its role, and whether the running means are shown. */
voltlap.opacity = (role, on) => {
  if (role === "means") return Number(on);
  if (role === "reference") return on ? 0 : 0.4;
  if (role === "member") return 0.8;
  if (role === "pale") return on ? 0.12 : 0.5;
  return on && role === "samples" ? 0.22 : 1;
};

/** Whole steps of an axis from..to, at most so many (two at least). */
voltlap.ticks = (steps, from, to, most) => {
  const step = steps.find((one) => (to - from) / one <= Math.max(2, most)) ?? steps[steps.length - 1];
  const ticks = [];
  for (let k = Math.ceil(from / step - 1e-6); k * step <= to + 1e-6; k += 1) ticks.push(k * step);
  return { step, ticks };
};

/** What stands behind a series' name in the legend. */
voltlap.rangeText = ({ range }) => (range ? voltlap.element("small", {}, `${range} `) : "");

/** A chart in words, for those who do not see it. */
voltlap.chartLabel = ({ title, series, unit }) =>
  `${title}, ${series.map(({ name }) => name).join(", ")}${unit ? `, in ${unit}` : ""}`;

/** Faint lines at the ends of laps, events, and a line across. */
voltlap.markLines = (spec, { laps, at }, text) => {
  const { color } = voltlap;
  const lines = laps.map((place) => ({ xAxis: place }));
  for (const { time_s, text: label } of at ? (spec.events ?? []) : []) {
    const style = { color: color("bad"), fontWeight: 600 };
    lines.push({
      xAxis: at(time_s),
      lineStyle: { ...style, width: 2 },
      label: { ...text, ...style, show: true, formatter: label, distance: 3 },
    });
  }
  if (spec.ruler) {
    const style = { color: color("bad"), type: [6, 4], width: 1.3 };
    lines.push({
      yAxis: spec.ruler.value,
      lineStyle: style,
      label: {
        ...text,
        color: style.color,
        show: true,
        formatter: spec.ruler.text,
        position: "insideStartTop",
      },
    });
  }
  if (!lines.length) return undefined;
  return {
    silent: true,
    symbol: "none",
    label: { show: false },
    data: lines,
    animation: false,
    z: 1,
    lineStyle: { color: color("line"), width: 1, type: "solid" },
  };
};

/** A true extreme as a point with its value beside it. */
voltlap.markPoint = (extreme, borderColor, end, text) => {
  const { color } = voltlap;
  const part = extreme.x / end;
  return {
    silent: true,
    symbol: "circle",
    symbolSize: 7,
    animation: false,
    z: 9,
    itemStyle: { color: color("surface"), borderColor, borderWidth: 2 },
    label: {
      ...text,
      color: color("text"),
      fontWeight: 600,
      formatter: extreme.text,
      distance: 6,
      position: part > 0.94 ? "left" : part < 0.06 || extreme.below ? "right" : "top",
      offset: extreme.offset ?? (part > 0.94 && !extreme.below ? [4, -9] : [0, 0]),
      textBorderColor: color("surface"),
      textBorderWidth: 3,
    },
    data: [{ coord: [extreme.x, extreme.value], value: extreme.value }],
  };
};

/** A number at an axis whose steps are round: sums of them are not. */
voltlap.axisNumber = (value) => Number(value.toFixed(4)).toLocaleString("en");

/** The axis of a chart's values. */
voltlap.valueAxis = ({ low, high, interval, axis, title, unit }, reach, text) => ({
  type: "value",
  min: reach?.low ?? low,
  max: reach?.high ?? high,
  scale: true,
  splitNumber: 4,
  name: [axis ?? title, unit].filter(Boolean).join(", "),
  nameLocation: "middle",
  nameRotate: 90,
  nameGap: 46,
  nameTextStyle: text,
  axisLabel: { ...text, hideOverlap: true, ...(reach ? { formatter: voltlap.axisNumber } : {}) },
  splitLine: { lineStyle: { color: voltlap.color("grid") } },
  interval: reach?.interval ?? interval,
});

/** What each curve of a series has at a place, highest first. */
voltlap.layerValues = (layers, series, place) =>
  layers
    .map((layer) => ({ layer, to: layer.x[Math.min(layer.x.length, layer.values(series).length) - 1] }))
    .filter(({ layer, to }) => place >= layer.x[0] && place <= to)
    .map(({ layer }) => ({ layer, value: voltlap.valueAt(layer.x, layer.values(series), place) }))
    .sort((a, b) => b.value - a.value);

voltlap.levelArea = ({ low, high, color }) => {
  const itemStyle = { color: voltlap.color(color), opacity: 0.22 };
  return { silent: true, animation: false, z: 0, itemStyle, data: [[{ yAxis: low }, { yAxis: high }]] };
};

/** One curve of a family drawn broad, on top of the others; empty at first. */
voltlap.emphasisSeries = () => ({
  type: "line",
  name: "emphasis",
  data: [],
  dimensions: ["x", "value"],
  showSymbol: false,
  silent: true,
  animation: false,
  z: 8,
  lineStyle: { width: 3 },
});

/** Stretches of time as coloured columns with a solid foot: [from, to, colour]. */
voltlap.bandSeries = (bands, { at }) => {
  return {
    type: "custom",
    name: "bands",
    silent: true,
    animation: false,
    z: 0,
    clip: true,
    encode: { x: [0, 1] },
    dimensions: ["from", "to", "reason"],
    data: bands.map((band) => [at(band.from_s), at(band.to_s), band.reason]),
    renderItem: (params, api) => {
      const area = params.coordSys;
      const fill = voltlap.color(bands[params.dataIndex].color);
      const left = Math.max(api.coord([api.value(0), 0])[0], area.x);
      const right = Math.min(api.coord([api.value(1), 0])[0], area.x + area.width);
      const column = (y, height, opacity) => ({
        type: "rect",
        shape: { x: left, y, width: Math.max(right - left, 1), height },
        style: { fill, opacity },
      });
      return { type: "group", children: [column(area.y, area.height, 0.2), column(area.y + area.height - 6, 6, 1)] };
    },
  };
};

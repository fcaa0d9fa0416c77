// SPDX-License-Identifier: Apache-2.0
// The scale of a chart of errors: what the errors are that count, not what a single row or a cut-off end is. What runs
// beyond it is marked at the edge and told in words.
"use strict";

/** A round number that is no less, and half of which is one. */
voltlap.roundUp = (value) => {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 3, 4, 5, 6, 8, 10].map((k) => k * power).find((one) => one >= value * (1 - 1e-9));
};

/** What 99.9 % of the time that counts lies within, at least four times the RMS; never more than the largest error. */
voltlap.errorReach = ({ rms_mv, max_mv, most_mv }) => {
  const high = voltlap.roundUp(Math.min(max_mv, Math.max(most_mv, 4 * rms_mv)));
  return { low: -high, high, interval: high / 2 };
};

/** Round steps around the values of those rows that the model follows at all. */
voltlap.reachAround = (follows, ...columns) => {
  let low = Infinity,
    high = -Infinity;
  for (const values of columns) {
    for (let i = 0; i < values.length; i += 1) {
      if (!follows(i)) continue;
      low = Math.min(low, values[i]);
      high = Math.max(high, values[i]);
    }
  }
  if (!(low <= high)) return undefined;
  const interval = voltlap.roundUp(Math.max(high - low, 1e-3) / 5);
  const whole = (count) => Number((count * interval).toFixed(4));
  const first = Math.floor(low / interval + 1e-9);
  return { low: whole(first), high: whole(Math.max(Math.ceil(high / interval - 1e-9), first + 1)), interval };
};

/** Rows whose error is not that of a glitch or an open contactor. */
voltlap.followed = (error_mv, reach) => {
  const most = Math.max(150, 2 * reach.high);
  return (i) => Math.abs(error_mv[i]) <= most;
};

/** Runs of samples beyond a scale: [{from, to, value}], value the farthest; runs closer than `apart` are one. */
voltlap.runsBeyond = (xs, values, { low, high }, apart) => {
  const runs = [];
  for (let i = 0; i < values.length; i += 1) {
    const value = values[i];
    if (!(value > high || value < low)) continue;
    const last = runs[runs.length - 1];
    if (last && last.value > high === value > high && xs[i] - last.to <= apart) {
      last.to = xs[i];
      if (Math.abs(value) > Math.abs(last.value)) last.value = value;
    } else {
      runs.push({ from: xs[i], to: xs[i], value });
    }
  }
  return runs;
};

/** Arrows at the edge of a chart where its signal runs beyond the scale. */
voltlap.beyondSeries = (runs, { high }, color, size = 6) => ({
  type: "custom",
  name: "beyond",
  silent: true,
  animation: false,
  z: 8,
  encode: { x: [0, 1] },
  dimensions: ["from", "to", "value"],
  data: runs.map(({ from, to, value }) => [from, to, value]),
  renderItem: (params, api) => {
    const { x, y, width, height } = params.coordSys;
    const up = api.value(2) > high;
    const inside = (at) => Math.min(Math.max(api.coord([at, 0])[0], x), x + width);
    const left = inside(api.value(0)),
      right = inside(api.value(1));
    const edge = up ? y : y + height;
    const foot = edge + (up ? size : -size);
    const middle = (left + right) / 2;
    if (api.coord([api.value(1), 0])[0] < x || api.coord([api.value(0), 0])[0] > x + width) return null;
    const style = { fill: color };
    const points = [[middle, edge], [middle - 0.75 * size, foot], [middle + 0.75 * size, foot]];
    const bar = { x: left, y: up ? y : y + height - 2, width: Math.max(right - left, 1), height: 2 };
    return {
      type: "group",
      children: [{ type: "polygon", shape: { points }, style }, { type: "rect", shape: bar, style }],
    };
  },
});

/** The runs of all series of a chart. */
voltlap.beyondReach = ({ reach, series }, { frame, begin, end }) =>
  series.flatMap(({ values }) => voltlap.runsBeyond(frame.layers[0].x, values, reach, (end - begin) / 100));

/** How far it goes beyond the scale, and a button that changes the scale. */
voltlap.beyondLegend = ({ reach, digits, unit }, runs, whole, change) => {
  const { element, quantity } = voltlap;
  const values = runs.map(({ value }) => value);
  const ends = [];
  if (Math.max(...values) > reach.high) ends.push(`▲ to ${quantity(Math.max(...values), digits, unit)}`);
  if (Math.min(...values) < reach.low) ends.push(`▼ to ${quantity(Math.min(...values), digits, unit)}`);
  const button = element("button", { type: "button", class: "scale-button" }, whole ? "Fit the scale" : "Show all");
  button.addEventListener("click", change);
  return element("li", { class: "beyond" }, `${whole ? "farthest" : "beyond the scale"}: ${ends.join(", ")} `, button);
};

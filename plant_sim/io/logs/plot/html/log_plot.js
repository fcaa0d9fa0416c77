// SPDX-License-Identifier: Apache-2.0
// Signals of a recording over time: a chart for each unit, one stretch for all.
"use strict";

(() => {
  const { data } = voltlap;
  const byId = (id) => document.getElementById(id);
  const { begin_s, end_s } = data;

  const steps = [-4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6].flatMap((power) => [1, 2, 5].map((k) => k * 10 ** power));
  const decimalsOf = (step) => Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const axis = {
    name: () => "time, s",
    steps,
    text: (value, step) => value.toFixed(decimalsOf(step)),
    shortest: Math.min(1e-3, end_s - begin_s),
  };

  /** Seconds with the digits that the view can show. */
  const seconds = (time, from, to) => time.toFixed(Math.min(6, Math.max(1, decimalsOf((to - from) / 1000))));

  const seriesOf = (packed, unit) => {
    const times = voltlap.decode(packed.time, packed.points).map((time) => time + packed.first_s);
    const values = voltlap.decode(packed.value, packed.points).map((value) => value + packed.low);
    const begins = Array.from(voltlap.decode(packed.begin, packed.begins), Math.round);
    const signal = new voltlap.OwnTimes(times, values, begins, packed.stepped);
    return {
      name: packed.name,
      color: packed.color,
      range: packed.range.replaceAll("-", "−"),
      step: packed.stepped ? "end" : undefined,
      points: (from, to, width) => signal.points(from, to, width),
      textAt: (time) => {
        const value = signal.valueAt(time);
        if (value === null) return "not known";
        const number = voltlap.quantity(value, packed.digits, unit).trim();
        const state = packed.states.find(([at]) => Math.abs(at - value) < 1e-9);
        return state ? `${state[1]} (${number})` : number;
      },
    };
  };

  const specOf = ({ title, axis: quantity, unit, series }, k) => ({
    id: `chart-${k}`,
    title,
    axis: unit ? quantity : "value",
    unit,
    digits: 0,
    series: series.map((one) => seriesOf(one, unit)),
  });

  const draw = () => {
    byId("telemetry").hidden = false;
    const when = (i, place) => `${seconds(place, ...charts.view)} s`;
    const view = (from, to) => {
      byId("whole").disabled = from <= begin_s && to >= end_s;
      byId("view").textContent = `${seconds(from, from, to)} to ${seconds(to, from, to)} s`;
    };
    const cursor = (i, place) => {
      byId("cursor").textContent = i === null ? "" : when(i, place);
    };
    const charts = new voltlap.TimeCharts({
      root: byId("charts"),
      frame: {
        axis,
        layers: [{ x: Float64Array.of(begin_s, end_s), values: () => [] }],
        begin: begin_s,
        end: end_s,
        laps: [],
        window: null,
        at: (time) => time,
      },
      specs: data.charts.map(specOf),
      describedBy: "hint",
      listener: { view, cursor, when, stepLap: () => {} },
    });
    byId("whole").addEventListener("click", () => charts.showAll());
    voltlap.onThemeChange(() => charts.redraw());
    voltlap.tellReady();
  };

  voltlap.searchable(byId("search"), byId("signals"), byId("found"));
  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

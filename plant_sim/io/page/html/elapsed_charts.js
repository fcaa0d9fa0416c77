// SPDX-License-Identifier: Apache-2.0
// Curves of one row of times in charts that share stretch and cursor, with the page's line of words above them: the
// elements `strips`, `view`, `cursor`, `whole` of the page.
"use strict";

/** A chart of those of its curves [name, colour, column, role] that `decoded` has. */
voltlap.elapsedSpec = (decoded, id, title, axis, unit, digits, curves) => ({
  id,
  title,
  axis,
  unit,
  digits,
  series: curves
    .map(([name, color, column, role]) => ({ name, color, role, values: decoded(column) }))
    .filter(({ values }) => values),
});

/** The charts of `specs` over `times`; no view is shorter than `shortest` seconds. */
voltlap.elapsedCharts = (times, specs, shortest) => {
  const $ = (id) => document.getElementById(id);
  const begin = times[0],
    end = times[times.length - 1];
  let shown = [begin, end];
  const charts = new voltlap.TimeCharts({
    root: $("strips"),
    frame: {
      axis: { ...voltlap.elapsedAxis, shortest },
      layers: [{ x: times, values: (series) => series.values }],
      begin,
      end,
      laps: [],
      window: null,
      at: (time) => time,
    },
    specs,
    describedBy: "hint",
    listener: {
      view: (from, to) => {
        shown = [from, to];
        $("view").textContent = voltlap.elapsedStretch(from, to);
        $("whole").disabled = from <= begin && to >= end;
      },
      cursor: (i) => {
        $("cursor").textContent = i === null ? "" : voltlap.elapsed(times[i], ...shown);
      },
      when: (i) => voltlap.elapsed(times[i], ...shown),
      stepLap: () => {},
    },
  });
  $("whole").addEventListener("click", () => charts.showAll());
  voltlap.onThemeChange(() => charts.redraw());
  return charts;
};

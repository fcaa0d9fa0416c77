// SPDX-License-Identifier: Apache-2.0
// The report of a replay: firmware and log over each other in charts that share stretch and cursor.
"use strict";

(() => {
  const { data, tellReady } = voltlap,
    $ = (id) => document.getElementById(id);
  const decoded = (name) => data.columns[name] && voltlap.decode(data.columns[name], data.points);

  /** A chart of those of its curves that there are. */
  const chart = (id, title, axis, unit, digits, curves) => ({
    id,
    title,
    axis,
    unit,
    digits,
    series: curves
      .map(([name, color, column, role]) => ({ name, color, role, values: decoded(column) }))
      .filter(({ values }) => values),
  });

  const specs = () =>
    [
      chart("chart-soc", "State of charge", "SOC", "%", 2, [
        ["firmware", "blue", "soc_pct"],
        ["log", "orange", "logged_soc_pct"],
        [data.second, "purple", "second_soc_pct"],
      ]),
      chart("chart-current", "Current and limits, discharge positive", "current", "A", 1, [
        ["the log's unit allows", "grey", "logged_discharge_limit_a", "reference"],
        ["the log's unit takes", "grey", "logged_charge_limit_a", "reference"],
        ["log", "blue", "current_a"],
        ["firmware allows", "orange", "discharge_limit_a"],
        ["firmware takes", "green", "charge_limit_a"],
        [`allowed, ${data.second}`, "purple", "second_discharge_limit_a"],
        [`taken, ${data.second}`, "grey", "second_charge_limit_a"],
      ]),
      chart("chart-cells", "Lowest and highest cell", "voltage", "V", 3, [
        ["lowest", "blue", "cell_min_v"],
        ["highest", "orange", "cell_max_v"],
      ]),
      chart("chart-temperature", "Hottest thermistor", "temperature", "°C", 1, [["log", "blue", "temperature_max_c"]]),
      chart("chart-active", "Contactors by the firmware: 1 is closed", "closed", "", 0, [
        ["firmware", "blue", "active"],
      ]),
    ].filter((spec) => spec.series.length > 0);

  const draw = () => {
    if (data.points > 1) {
      $("telemetry").hidden = false;
      const times = decoded("time_s");
      const begin = times[0],
        end = times[times.length - 1];
      let shown = [begin, end];
      const charts = new voltlap.TimeCharts({
        root: $("strips"),
        frame: {
          axis: { ...voltlap.elapsedAxis, shortest: 0.5 },
          layers: [{ x: times, values: (series) => series.values }],
          begin,
          end,
          laps: [],
          window: null,
          at: (time) => time,
        },
        specs: specs(),
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
      for (const button of $("disagreements").querySelectorAll("button")) {
        button.addEventListener("click", () => {
          const from = Number(button.dataset.begin),
            to = Number(button.dataset.end);
          charts.show(from - 5, to + 5);
          $("telemetry").scrollIntoView();
        });
      }
      voltlap.onThemeChange(() => charts.redraw());
    }
    tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

// SPDX-License-Identifier: Apache-2.0
// The report of a replay: firmware and log over each other in charts that share stretch and cursor.
"use strict";

(() => {
  const { data, tellReady } = voltlap,
    $ = (id) => document.getElementById(id);
  const decoded = (name) => data.columns[name] && voltlap.decode(data.columns[name], data.points);

  const chart = (...what) => voltlap.elapsedSpec(decoded, ...what);

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
      const charts = voltlap.elapsedCharts(decoded("time_s"), specs(), 0.5);
      for (const button of $("disagreements").querySelectorAll("button")) {
        button.addEventListener("click", () => {
          const from = Number(button.dataset.begin),
            to = Number(button.dataset.end);
          charts.show(from - 5, to + 5);
          $("telemetry").scrollIntoView();
        });
      }
    }
    tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

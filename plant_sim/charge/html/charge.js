// SPDX-License-Identifier: Apache-2.0
// The report of a charge: curves over time that share stretch and cursor.
"use strict";

(() => {
  const { data, tellReady } = voltlap,
    $ = (id) => document.getElementById(id);
  const decoded = (name) => voltlap.decode(data.columns[name], data.points);

  const chart = (...what) => voltlap.elapsedSpec(decoded, ...what);

  const specs = () => [
    chart("chart-cells", "Lowest and highest cell", "voltage", "V", 4, [
      ["lowest", "blue", "cell_min_v"],
      ["highest", "orange", "cell_max_v"],
    ]),
    chart("chart-spread", "Highest less lowest cell, open", "spread", "mV", 1, [["spread", "blue", "spread_mv"]]),
    chart("chart-current", "Current into the pack", "current", "A", 1, [
      ["asked of the charger", "grey", "asked_a", "reference"],
      ["flows", "blue", "current_a"],
    ]),
    chart("chart-soc", "Charge of the emptiest and the fullest cell", "charge", "%", 2, [
      ["emptiest", "blue", "soc_min_pct"],
      ["fullest", "orange", "soc_max_pct"],
    ]),
    chart("chart-bled", "Cells that are bled", "cells", "", 0, [["bled", "blue", "cells_bled"]]),
    chart("chart-temperature", "Hottest cell", "temperature", "°C", 1, [["cell", "blue", "temperature_c"]]),
  ];

  const draw = () => {
    if (data.points > 1) {
      $("telemetry").hidden = false;
      voltlap.elapsedCharts(decoded("time_s"), specs(), 60);
    }
    tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

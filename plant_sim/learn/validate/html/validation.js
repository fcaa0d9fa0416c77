// SPDX-License-Identifier: Apache-2.0
// The validation report: for each recording its voltage with the model's, the error, current and temperature.
"use strict";

(() => {
  const { data } = voltlap;

  const specs = (file, column, bands, reach) => {
    const shared = { bands };
    const everywhere = () => true;
    const list = [
      {
        ...shared,
        reach: voltlap.reachAround(voltlap.followed(column.error_mv, reach), column.model_v, column.voltage_v),
        id: "chart-voltage",
        title: "Voltage",
        axis: "voltage",
        unit: "V",
        digits: 3,
        series: [
          { name: "model", color: "blue", values: column.model_v },
          { name: "recorded", color: "orange", role: "reference", values: column.voltage_v },
        ],
      },
      {
        ...shared,
        id: "chart-error",
        title: "Error, model minus recording",
        axis: "error",
        unit: "mV",
        digits: 1,
        reach,
        bandNames: bands.length ? [{ color: "grey", text: "does not count" }] : [],
        series: [{ name: "error", color: "purple", values: column.error_mv }],
      },
      {
        ...shared,
        id: "chart-current",
        title: "Current, discharge positive",
        axis: "current",
        unit: "A",
        digits: 1,
        series: [{ name: "recorded", color: "green", values: column.current_a }],
      },
    ];
    if (file.has_temperature) {
      list.push({
        ...shared,
        reach: voltlap.reachAround(everywhere, column.model_c, column.temperature_c),
        id: "chart-temperature",
        title: "Temperature",
        axis: "temperature",
        unit: "°C",
        digits: 1,
        series: [
          { name: "model", color: "blue", values: column.model_c },
          { name: "recorded", color: "orange", role: "reference", values: column.temperature_c },
        ],
      });
    }
    return list;
  };

  const draw = () => {
    document.getElementById("telemetry").hidden = false;
    const charts = new voltlap.RecordingCharts({
      recordings: data.files,
      error: data.error,
      specs,
      when: (column, i) => `, SOC ${(100 * column.soc[i]).toFixed(1)} %`,
    });
    voltlap.onThemeChange(() => charts.redraw());
    voltlap.tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

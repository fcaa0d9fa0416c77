// SPDX-License-Identifier: Apache-2.0
// The report of an identification: recordings against the model, what is left over, parameters with their intervals.
"use strict";

(() => {
  const { data, tellReady } = voltlap,
    $ = (id) => document.getElementById(id);
  let residuals = [];
  let parameters = [];

  const specs = (recording, column, bands, reach) => [
    {
      id: "chart-voltage",
      title: "Cell voltage",
      axis: "voltage",
      unit: "V",
      digits: 4,
      bands,
      reach: voltlap.reachAround(voltlap.followed(column.error_mv, reach), column.model_v, column.measured_v),
      series: [
        { name: "model", color: "blue", values: column.model_v },
        { name: "measured", color: "orange", role: "reference", values: column.measured_v },
      ],
    },
    {
      id: "chart-error",
      title: "Model less measured",
      axis: "error",
      unit: "mV",
      digits: 2,
      bands,
      bandNames: bands.length ? [{ color: "grey", text: "does not count" }] : [],
      reach,
      series: [{ name: "error", color: "purple", values: column.error_mv }],
    },
    {
      id: "chart-current",
      title: "Current",
      axis: "current",
      unit: "A",
      digits: 1,
      bands,
      series: [{ name: "discharge positive", color: "green", values: column.current_a }],
    },
  ];

  const showResiduals = ({ histogram, by_soc, rms_mv }) => {
    $("residuals").replaceChildren();
    const bins = histogram.seconds.map((seconds, i) => [histogram.low_mv + (i + 0.5) * histogram.width_mv, seconds]);
    const curve = (name, color, values) => ({ name, color, points: by_soc.soc.map((soc, i) => [soc, values[i]]) });
    residuals = [
      new voltlap.SocChart($("residuals"), {
        id: "chart-histogram",
        title: "How often which error",
        note: `RMS ${rms_mv.toFixed(2)} mV, over the rows that count. The outer bins hold all that lies beyond.`,
        x: { name: "error, mV" },
        y: { name: "time", unit: "s", digits: 0, low: 0 },
        curves: [{ name: "time at this error", color: "purple", step: true, points: bins }],
      }),
      new voltlap.SocChart($("residuals"), {
        id: "chart-by-soc",
        title: "Error by SOC",
        x: { name: "SOC", low: 0, high: 1 },
        y: { name: "error", unit: "mV", digits: 2 },
        curves: [curve("mean", "blue", by_soc.mean_mv), curve("RMS", "orange", by_soc.rms_mv)],
      }),
    ];
  };

  const placeName = ({ temperature_c, current_a }) =>
    [
      `${temperature_c.toFixed(1)} °C${data.temperature_told ? "" : " (assumed)"}`,
      ...(current_a > 0 ? [`${current_a.toFixed(0)} A`] : []),
    ].join(", ");

  /** Name, unit, factor and digits of a table by its key, such as r0_ohm. */
  const meaning = (key) => {
    if (key === "em_v") return { name: "Em", unit: "V", factor: 1, digits: 4, low: undefined };
    const name = key.split("_")[0];
    return key.endsWith("_ohm")
      ? { name: name.toUpperCase(), unit: "mΩ", factor: 1000, digits: 4, low: 0 }
      : { name, unit: "s", factor: 1, digits: 1, low: 0 };
  };

  const curveOf = (place, key, pale) => {
    const table = place.parameters[key];
    const { factor } = meaning(key);
    const scaled = (value) => (value === null ? null : factor * value);
    return {
      name: placeName(place),
      color: pale ? "grey" : "blue",
      pale,
      points: table.soc.map((soc, i) => [
        soc,
        factor * table.value[i],
        scaled(table.ci95_low[i]),
        scaled(table.ci95_high[i]),
      ]),
    };
  };

  /** Half of the interval of Em, which is too narrow to be seen as bars. */
  const ocvInterval = (place) => {
    const { soc, ci95_low, ci95_high } = place.parameters.em_v;
    return {
      id: "chart-em_v-interval",
      title: "Em, half of the 95 % interval",
      x: { name: "SOC", low: 0, high: 1 },
      y: { name: "interval", unit: "mV", digits: 2, low: 0 },
      curves: [
        {
          name: placeName(place),
          color: "blue",
          points: soc.map((at, i) => [at, ci95_low[i] === null ? null : 500 * (ci95_high[i] - ci95_low[i])]),
        },
      ],
    };
  };

  /** Words under a chart whose values have no intervals. */
  const noteOf = ({ ci95_low }) => (ci95_low.every((one) => one === null) ? "95 % intervals: not settled" : undefined);

  const showPlace = (chosen) => {
    const place = data.places[chosen];
    $("parameters").replaceChildren();
    parameters = Object.keys(place.parameters).flatMap((key) => {
      const { name, unit, digits, low } = meaning(key);
      const others = data.places.filter((other) => other !== place && other.parameters[key]);
      const spec = {
        id: `chart-${key}`,
        title: name,
        note: noteOf(place.parameters[key]),
        x: { name: "SOC", low: 0, high: 1 },
        y: { name, unit, digits, low },
        curves: [...others.map((other) => curveOf(other, key, true)), curveOf(place, key, false)],
      };
      const settled = noteOf(place.parameters[key]) === undefined;
      return (key === "em_v" && settled ? [spec, ocvInterval(place)] : [spec]).map(
        (one) => new voltlap.SocChart($("parameters"), one),
      );
    });
  };

  const draw = () => {
    $("telemetry").hidden = false;
    const { recordings, error } = data;
    const charts = new voltlap.RecordingCharts({ recordings, error, specs, shown: showResiduals });
    $("parameter-charts").hidden = false;
    $("place").append(...data.places.map((place, i) => new Option(placeName(place), i)));
    $("place").value = data.reference;
    $("place").addEventListener("change", () => showPlace(Number($("place").value)));
    showPlace(data.reference);
    voltlap.onThemeChange(() => {
      charts.redraw();
      for (const chart of [...residuals, ...parameters]) chart.draw();
    });
    tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

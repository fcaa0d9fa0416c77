// SPDX-License-Identifier: Apache-2.0
// The validation report: for each recording its voltage with the model's, the error, current and temperature.
"use strict";

(() => {
  const { data, clock, element } = voltlap;
  const groups = [];

  /** Stretches of samples that do not count. */
  const uncounted = (times, counts) => {
    const bands = [];
    for (let i = 1; i < times.length; i += 1) {
      if (counts[i]) continue;
      const last = bands[bands.length - 1];
      if (last && last.last === i - 1) Object.assign(last, { to_s: times[i], last: i });
      else bands.push({ from_s: times[i - 1], to_s: times[i], reason: 0, last: i, color: "grey" });
    }
    return bands;
  };

  /** Whole steps around all values: the stretches behind a chart would pull its axis to zero. */
  const around = (step, ...columns) => {
    let low = Infinity,
      high = -Infinity;
    for (const values of columns) {
      for (const value of values) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }
    const whole = (count) => Number((count * step).toFixed(3));
    return { low: whole(Math.floor(low / step)), high: whole(Math.ceil(high / step)) };
  };

  const specs = (file, column, bands, k) => {
    const shared = { bands };
    const list = [
      {
        ...shared,
        ...around(0.2, column.model_v, column.voltage_v),
        id: `chart-voltage-${k}`,
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
        id: `chart-error-${k}`,
        title: "Error, model minus recording",
        axis: "error",
        unit: "mV",
        digits: 1,
        bandNames: bands.length ? [{ color: "grey", text: "does not count" }] : [],
        series: [{ name: "error", color: "purple", values: column.error_mv }],
      },
      {
        ...shared,
        id: `chart-current-${k}`,
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
        ...around(5, column.model_c, column.temperature_c),
        id: `chart-temperature-${k}`,
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

  const drawFile = (file, k) => {
    const column = Object.fromEntries(
      Object.entries(file.columns).map(([name, packed]) => [name, voltlap.decode(packed, file.samples)]),
    );
    const root = element("div", { class: "strips" });
    const cursorText = element("span", { class: "cursor-text" });
    const whole = element("button", { type: "button" }, "Whole recording");
    const viewText = element("span", { class: "view", role: "status" });
    const bar = element("div", { class: "toolbar", role: "toolbar", "aria-label": "Stretch of the recording" });
    bar.append(whole, viewText, cursorText);
    document.getElementById("recordings").append(element("h3", {}, file.name), bar, root);
    const times = column.time_s;
    const end_s = times[times.length - 1];
    const when = (i) => `${clock(times[i], 1)}, SOC ${(100 * column.soc[i]).toFixed(1)} %`;
    const view = (from, to) => {
      whole.disabled = from <= 0 && to >= end_s;
      viewText.textContent = `${clock(from)} to ${clock(to)}`;
    };
    const cursor = (i) => {
      cursorText.textContent = i === null ? "" : when(i);
    };
    const charts = new voltlap.TimeCharts({
      root,
      times,
      end_s,
      laps: [],
      window_s: null,
      specs: specs(file, column, uncounted(times, column.counts), k),
      describedBy: "hint",
      listener: { view, cursor, when, stepLap: () => {} },
    });
    whole.addEventListener("click", () => charts.showAll());
    groups.push(charts);
  };

  const draw = () => {
    document.getElementById("telemetry").hidden = false;
    data.files.forEach(drawFile);
    voltlap.onThemeChange(() => groups.forEach((charts) => charts.redraw()));
    requestAnimationFrame(() => requestAnimationFrame(tellReady));
  };

  /** Everything is on the screen. */
  const tellReady = () => {
    performance.mark("voltlap-ready");
    document.documentElement.dataset.ready = performance.now().toFixed(0);
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

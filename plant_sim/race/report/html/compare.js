// SPDX-License-Identifier: Apache-2.0
// The comparison's report: runs over each other by distance, and what the controls above the charts do.
"use strict";

(() => {
  const { data } = voltlap,
    $ = (id) => document.getElementById(id);
  const runs = data.runs.map(({ name, columns }) => ({
    name,
    column: Object.fromEntries(
      Object.entries(columns).map(([key, packed]) => [key, voltlap.decode(packed, packed.samples)]),
    ),
  }));
  const end = Math.max(...runs.map(({ column }) => column.distance_m.at(-1) ?? 0), 1);
  const lap_m = data.lap_m;
  const laps = lap_m ? Array.from({ length: Math.ceil(end / lap_m - 1e-6) }, (_, i) => i) : [];

  /** A chart of channels, each of them named. */
  const chart = (id, title, axis, unit, digits, channels, more = {}) => ({
    id: `chart-${id}`,
    title,
    axis,
    unit,
    digits,
    series: channels.map(([name, channel]) => ({ name, channel })),
    ...more,
  });

  const specs = () => [
    chart("delta", "Time behind the first run", "time behind", "s", 3, [["time behind", "delta_s"]]),
    chart("speed", "Speed", "speed", "m/s", 2, [["speed", "speed_mps"]], { low: 0, means: true }),
    chart(
      "power",
      "Power at the pack's terminals",
      "power",
      "kW",
      2,
      [["mean of 500 ms", "power_mean_500ms_kw"]],
      { means: true },
    ),
    chart("soc", "State of charge", "SOC", "%", 2, [["state of charge", "soc_pct"]]),
    chart("cell-voltage", "Weakest cell", "voltage", "V", 3, [["lowest cell voltage", "cell_voltage_min_v"]], {
      means: true,
    }),
    chart("battery", "Hottest cell", "temperature", "°C", 1, [["hottest cell", "battery_temperature_c"]]),
    chart("motor", "Motor winding", "temperature", "°C", 1, [["motor winding", "motor_temperature_c"]]),
  ];

  /** Time behind; of one lap, from its start. */
  let shownLap = -1;
  const behind = ({ distance_m, delta_s }) => {
    if (shownLap < 0 || !delta_s.length) return delta_s;
    const before = voltlap.valueAt(distance_m.subarray(0, delta_s.length), delta_s, shownLap * lap_m);
    return delta_s.map((value) => value - before);
  };

  const frame = () => ({
    axis: voltlap.axes.distance,
    layers: runs.map(({ name, column }, i) => ({
      name,
      color: voltlap.color(`run-${i + 1}`),
      x: column.distance_m,
      values: ({ channel }) => (channel === "delta_s" ? behind(column) : column[channel]),
    })),
    end,
    laps: laps.length <= 60 ? laps.map((lap) => lapEnd(lap)) : [],
    window: lap_m, // null where laps have no place on the course
    at: null,
  });

  const lapEnd = (lap) => Math.min((lap + 1) * lap_m, end);
  const lapOf = (from, to) =>
    laps.findIndex((lap) => Math.abs(lap * lap_m - from) < 0.5 && Math.abs(lapEnd(lap) - to) < 0.5);

  const where = (place) =>
    lap_m
      ? `lap ${Math.min(Math.floor(place / lap_m), laps.length - 1) + 1}, ${(place % lap_m).toFixed(0)} m`
      : `${place.toFixed(0)} m`;

  const draw = () => {
    let charts = null;
    const showLap = (lap) => charts.show(lap * lap_m, lapEnd(lap));
    const stepLap = (step) => {
      if (!laps.length) return;
      const [from, to] = charts.view;
      const shown = lapOf(from, to);
      const next = shown < 0 ? Math.floor((from + to) / 2 / lap_m) : shown + step;
      showLap(Math.min(Math.max(next, 0), laps.length - 1));
    };
    const select = $("lap");
    select.append(new Option("all laps", ""), ...laps.map((lap) => new Option(`lap ${lap + 1}`, lap)));
    select.addEventListener("change", () => (select.value === "" ? charts.showAll() : showLap(Number(select.value))));
    $("previous").addEventListener("click", () => stepLap(-1));
    $("next").addEventListener("click", () => stepLap(1));
    for (const control of [select, $("previous"), $("next")]) control.hidden = laps.length < 2;
    runs.forEach(({ name }, i) => {
      const key = voltlap.element("span", { class: "key", style: `--key: var(--run-${i + 1})` });
      $("keys").append(voltlap.element("span", { class: "run-name" }, key, name));
    });
    const view = (from, to) => {
      const whole = from <= 0 && to >= end;
      const lap = whole ? -1 : lapOf(from, to);
      const places = `${(from / 1000).toFixed(2)} to ${(to / 1000).toFixed(2)} km`;
      const said = lap < 0 ? "" : `lap ${lap + 1}, time behind from its start, `;
      $("view").textContent = whole ? `whole run, ${places}` : `${said}${places}`;
      $("whole").disabled = whole;
      select.value = lap < 0 ? "" : lap;
      if (lap === shownLap) return;
      shownLap = lap;
      charts?.redraw();
    };
    const when = (i, place) => where(place);
    const cursor = (i, place) => {
      $("cursor").textContent = i === null ? "" : where(place);
    };
    charts = new voltlap.TimeCharts({
      root: $("strips"),
      frame: frame(),
      specs: specs(),
      describedBy: "hint",
      listener: { view, cursor, when, stepLap },
    });
    $("whole").addEventListener("click", () => charts.showAll());
    voltlap.onThemeChange(() => charts.showFrame(frame()));
    voltlap.tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

// SPDX-License-Identifier: Apache-2.0
// The endurance report: which signals stand in which chart, and what the controls above the charts do.
"use strict";

(() => {
  const { data, clock, quantity } = voltlap,
    $ = (id) => document.getElementById(id);
  const column = Object.fromEntries(
    Object.entries(data.columns).map(([name, packed]) => [name, voltlap.decode(packed, data.samples)]),
  );
  const times = Float64Array.from({ length: data.samples }, (_, i) => data.first_s + i * data.period_s);
  const percent = (values) => values.map((value) => 100 * value);
  const least = (values) => values.reduce((low, value) => Math.min(low, value), Infinity);
  const most = (values) => values.reduce((high, value) => Math.max(high, value), -Infinity);

  /** The run's own extreme of a signal, as a marked point. */
  const extreme = (name, digits, unit, scale = 1, below = false) => {
    const { time_s, value } = data.extremes[name];
    return { time_s, value: value * scale, text: quantity(value * scale, digits, unit), below };
  };

  /** Stretches in which one and the same limit held the driver back. */
  const limitBands = () => {
    const bands = [];
    const reasons = column.limit_reason;
    for (let i = 0; i < reasons.length; i += 1) {
      if (reasons[i] === 0) continue;
      const last = bands[bands.length - 1];
      if (last && last.reason === reasons[i] && last.last === i - 1) {
        last.to_s = times[i];
        last.last = i;
      } else {
        bands.push({
          from_s: times[i] - data.period_s,
          to_s: times[i],
          reason: reasons[i],
          last: i,
          color: `limit-${reasons[i]}`,
        });
      }
    }
    return bands;
  };
  const words = (name) => name.replaceAll("_", " ");

  /** The axis follows the current; a limit far above it would press the curve flat, and stands in words instead. */
  const currentChart = () => {
    const peak = Math.max(data.extremes.pack_current_a.value, 1);
    const lowest = least(column.discharge_limit_a);
    const shown = lowest <= 1.6 * peak;
    const high = 1.15 * Math.max(peak, shown ? Math.min(most(column.discharge_limit_a), 1.6 * peak) : 0);
    const interval = [5, 10, 20, 25, 50, 100, 200, 250, 500, 1000].find((step) => high / step <= 5) ?? 2000;
    return {
      id: "chart-current",
      title: "Battery current",
      axis: "current",
      unit: "A",
      digits: 1,
      means: true,
      interval,
      low: Math.floor(Math.min(0, least(column.pack_current_a)) / interval) * interval,
      high: Math.ceil(high / interval) * interval,
      series: [
        { name: "current", color: "blue", values: column.pack_current_a, extreme: extreme("pack_current_a", 1, "A") },
        {
          name: "discharge limit",
          color: "orange",
          role: "limit",
          values: column.discharge_limit_a,
          remark: (i) => (column.limit_reason[i] ? `, ${words(data.limits[column.limit_reason[i]].name)} binds` : ""),
        },
      ],
      bands: limitBands(),
      bandNames: data.limits.flatMap(({ name, active_s }, i) =>
        i > 0 && active_s > 0 ? [{ color: `limit-${i}`, text: `${words(name)}, ${active_s.toFixed(1)} s` }] : [],
      ),
      note: shown
        ? data.limits.some(({ active_s }) => active_s > 0)
          ? ""
          : "no limit held back"
        : `limit above the scale: ${lowest.toFixed(0)} A or more`,
    };
  };

  const specs = () => [
    {
      id: "chart-speed",
      title: "Speed",
      means: true,
      axis: "speed",
      unit: "m/s",
      digits: 2,
      low: 0,
      events: data.failure === null ? [] : [{ time_s: data.end_s, text: "failed" }],
      series: [
        { name: "driven", color: "blue", values: column.speed_mps, extreme: extreme("speed_mps", 2, "m/s") },
        { name: "target", color: "orange", role: "reference", values: column.target_mps },
      ],
    },
    {
      id: "chart-pedals",
      title: "Pedals",
      means: true,
      axis: "pedal travel",
      unit: "%",
      digits: 1,
      low: 0,
      high: 100,
      interval: 25,
      series: [
        { name: "accelerator", color: "green", values: percent(column.accelerator) },
        { name: "brake", color: "orange", values: percent(column.brake) },
      ],
    },
    currentChart(),
    {
      id: "chart-pack-voltage",
      title: "Pack voltage",
      means: true,
      axis: "voltage",
      unit: "V",
      digits: 2,
      series: [
        {
          name: "at the terminals",
          color: "blue",
          values: column.pack_voltage_v,
          extreme: extreme("pack_voltage_v", 1, "V", 1, true),
        },
      ],
    },
    {
      id: "chart-cell-voltage",
      title: "Weakest cell",
      means: true,
      axis: "voltage",
      unit: "V",
      digits: 3,
      series: [
        {
          name: "lowest cell voltage",
          color: "purple",
          values: column.cell_voltage_min_v,
          extreme: extreme("cell_voltage_min_v", 3, "V", 1, true),
          remark: data.cells_alike ? undefined : (i) => `, cell ${column.cell_weakest[i].toFixed(0)}`,
        },
      ],
    },
    {
      id: "chart-soc",
      title: "State of charge",
      axis: "SOC",
      unit: "%",
      digits: 2,
      series: [
        { name: "plant", color: "blue", values: percent(column.soc), extreme: extreme("soc", 1, "%", 100) },
        { name: "BMS estimate", color: "orange", role: "reference", values: percent(column.bms_soc) },
      ],
    },
    {
      id: "chart-temperature",
      title: "Battery and motor",
      axis: "temperature",
      unit: "°C",
      digits: 1,
      series: [
        {
          name: "hottest cell",
          color: "orange",
          values: column.battery_temperature_c,
          extreme: extreme("battery_temperature_c", 1, "°C"),
        },
        { name: "motor winding", color: "purple", values: column.motor_temperature_c },
      ],
    },
    {
      id: "chart-rotors",
      title: "Brake rotors",
      means: true,
      axis: "temperature",
      unit: "°C",
      digits: 1,
      series: [
        { name: "front", color: "orange", values: column.front_rotor_c },
        { name: "rear", color: "purple", values: column.rear_rotor_c },
      ],
    },
  ];

  /** Laps with the one that was not completed. */
  const laps = [...data.laps];
  const driven_s = laps.length ? laps[laps.length - 1].end_s : 0;
  if (data.course && data.end_s > driven_s + data.period_s)
    laps.push({ lap: laps.length + 1, start_s: driven_s, end_s: data.end_s });
  const fastest_s = data.laps.length ? least(data.laps.map(({ start_s, end_s }) => end_s - start_s)) : null;

  /** Index of the lap at a time; the last one from its end on. */
  const lapAt = (time) => {
    const found = laps.findIndex(({ end_s }) => time < end_s);
    return found < 0 ? laps.length - 1 : found;
  };
  const lapOf = (from, to) =>
    laps.findIndex(({ start_s, end_s }) => Math.abs(start_s - from) < 0.05 && Math.abs(end_s - to) < 0.05);
  const isWhole = (from, to) => from <= 0 && to >= data.end_s;

  /** Metres since the start of the lap; a lap in time (standing start) begins where the car was then. */
  const positions = () => {
    if (data.by_position) return column.distance_m.map((distance) => distance % data.course.length_m);
    const starts = laps.map((lap) => (lap.start_s > 0 ? column.distance_m[voltlap.indexAt(times, lap.start_s)] : 0));
    return column.distance_m.map((distance, i) => Math.max(distance - starts[lapAt(times[i])], 0));
  };

  const stretchText = (from, to) => {
    if (isWhole(from, to)) return `whole run, 0:00 to ${clock(data.end_s)}`;
    const digits = to - from < 60 ? 1 : 0;
    const lap = laps[lapOf(from, to)];
    return `${lap ? `lap ${lap.lap}, ` : ""}${clock(from, digits)} to ${clock(to, digits)}`;
  };

  /** The map, or why there is none. */
  const drawMap = (position) => {
    const card = $("map-card");
    if (data.course) return new voltlap.TrackMap({ card, course: data.course, position, speed: column.speed_mps });
    const words = "A recorded drive gives speed over time. It has no course that could be drawn.";
    card.append(voltlap.element("h3", {}, "Course"), voltlap.element("p", { class: "note" }, words));
    return null;
  };

  /** List, buttons and table rows that choose a lap; `showLap` takes an index, `stepLap` a number of laps. */
  const connectLaps = (showLap, stepLap, showAll) => {
    const select = $("lap");
    select.append(new Option("all laps", ""), ...laps.map((lap, i) => new Option(`lap ${lap.lap}`, i)));
    select.addEventListener("change", () => (select.value === "" ? showAll() : showLap(Number(select.value))));
    $("previous").addEventListener("click", () => stepLap(-1));
    $("next").addEventListener("click", () => stepLap(1));
    for (const control of [select, $("previous"), $("next")]) control.hidden = laps.length < 2;
    for (const row of document.querySelectorAll("#laps tr[data-lap]")) {
      const says = { type: "button", title: "Show this lap in the charts" };
      const button = voltlap.element("button", says, row.dataset.lap);
      button.addEventListener("click", () => {
        showLap(Number(row.dataset.lap) - 1);
        $("telemetry").scrollIntoView();
      });
      row.cells[0].replaceChildren(button);
    }
  };

  /** Shows in list and table which lap the charts show; -1 for none. */
  const markLap = (at) => {
    $("lap").value = at >= 0 ? at : "";
    for (const row of document.querySelectorAll("#laps tr[data-lap]")) {
      row.classList.toggle("current", at >= 0 && Number(row.dataset.lap) === laps[at].lap);
    }
  };

  const drawTime = () => {
    $("telemetry").hidden = false;
    const along = data.course ? positions() : column.distance_m;
    const map = drawMap(along);
    const when = (i) => {
      const lap = data.course ? [`lap ${laps[lapAt(times[i])].lap}`] : [];
      return [clock(times[i], 1), ...lap, `${along[i].toFixed(0)} m`].join(", ");
    };
    let charts = null;
    const showLap = (i) => charts.show(laps[i].start_s, laps[i].end_s);
    const stepLap = (step) => {
      if (!laps.length) return;
      const [from, to] = charts.view;
      const shown = $("lap").value;
      const next = shown === "" ? lapAt((from + to) / 2) : Number(shown) + step;
      showLap(Math.min(Math.max(next, 0), laps.length - 1));
    };
    connectLaps(showLap, stepLap, () => charts.showAll());
    const view = (from, to) => {
      const text = stretchText(from, to);
      const whole = isWhole(from, to);
      $("view").textContent = text;
      $("whole").disabled = whole;
      markLap(whole && laps.length > 1 ? -1 : lapOf(from, to));
      map?.show(voltlap.indexAt(times, from), voltlap.indexAt(times, to), `Mean speed, ${text}`);
    };
    const cursor = (i) => {
      $("cursor").textContent = i === null ? "" : when(i);
      map?.showCar(i);
    };
    charts = new voltlap.TimeCharts({
      root: $("strips"),
      times,
      end_s: data.end_s,
      laps: laps.length <= 60 ? data.laps : [],
      window_s: fastest_s,
      specs: specs(),
      describedBy: "hint",
      listener: { view, cursor, when, stepLap },
    });
    $("whole").addEventListener("click", () => charts.showAll());
    voltlap.onThemeChange(() => {
      charts.redraw();
      map?.draw();
    });
  };

  const draw = () => {
    if (data.samples > 0) drawTime();
    else $("no-samples").hidden = false;
    if (data.energy_kwh.battery_chemical > 0) {
      $("flow-card").hidden = false;
      const flow = new voltlap.EnergyFlow({ box: $("chart-energy"), terms: data.energy_kwh });
      voltlap.onThemeChange(() => flow.draw());
    }
    voltlap.searchable($("search"), $("parameters"), $("found"));
    voltlap.tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

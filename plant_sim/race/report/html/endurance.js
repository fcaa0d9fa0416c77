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
  const kilo = (values) => values.map((value) => value / 1000);
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

  /** The rules' measure is the moving mean over 500 ms; the line is the rules', whatever the firmware keeps to. */
  const powerChart = () => ({
    id: "chart-power",
    title: "Power at the pack's terminals",
    axis: "power",
    unit: "kW",
    digits: 2,
    interval: 20,
    low: Math.floor(Math.min(0, least(column.power_w)) / 20e3) * 20,
    high: Math.ceil(Math.max(95e3, 1.1 * data.extremes.power_w.value) / 20e3) * 20,
    ruler: { value: 80, text: "80 kW, Formula SAE EV.3.3" },
    series: [
      {
        name: "power",
        color: "blue",
        role: "pale",
        values: kilo(column.power_w),
        extreme: { ...extreme("power_w", 1, "kW", 1e-3), text: "" },
      },
      {
        name: "mean of 500 ms",
        color: "orange",
        values: kilo(column.power_mean_w),
        extreme: extreme("power_mean_w", 1, "kW", 1e-3),
      },
    ],
  });

  const accelerationChart = () => ({
    id: "chart-acceleration",
    title: "Acceleration",
    axis: "acceleration",
    unit: "m/s²",
    digits: 2,
    series: [
      { name: "longitudinal", color: "blue", values: column.longitudinal_mps2 },
      ...(data.course ? [{ name: "lateral, right positive", color: "orange", values: column.lateral_mps2 }] : []),
    ],
  });

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
        {
          name: "driven",
          color: "blue",
          values: column.speed_mps,
          extreme: extreme("speed_mps", 2, "m/s"),
          remark: (i) => `, ${(3.6 * column.speed_mps[i]).toFixed(1)} km/h`,
        },
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
    powerChart(),
    currentChart(),
    accelerationChart(),
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
        ...(data.cells_alike ? [] : [{ name: "coldest cell", color: "blue", values: column.cell_temperature_min_c }]),
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
  const laps = data.laps.map((lap) => ({ ...lap, completed: true }));
  const driven_s = laps.length ? laps[laps.length - 1].end_s : 0;
  if (data.course && data.end_s > driven_s + data.period_s)
    laps.push({ lap: laps.length + 1, start_s: driven_s, end_s: data.end_s, completed: false });
  const frames = new voltlap.RunFrames({
    times,
    distance: column.course_m,
    laps,
    end_s: data.end_s,
    lap_m: data.by_position && data.course ? data.course.length_m : null,
  });

  /** Index of the lap at a time; the last one from its end on. */
  const lapAt = (time) => {
    const found = laps.findIndex(({ end_s }) => time < end_s);
    return found < 0 ? laps.length - 1 : found;
  };
  /** Metres since the start of the lap; a lap in time (standing start) begins where the car was then. */
  const positions = () => {
    if (data.by_position) return column.course_m.map((distance) => distance % data.course.length_m);
    const starts = laps.map((lap) => (lap.start_s > 0 ? column.course_m[voltlap.indexAt(times, lap.start_s)] : 0));
    return column.course_m.map((distance, i) => Math.max(distance - starts[lapAt(times[i])], 0));
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

  /** What the controls choose: axis "time" or "distance", and the laps over each other or null for the run. */
  const state = { axis: "time", overlay: null };
  const nearly = (a, b) => Math.abs(a - b) < 0.05;
  const lapOf = (from, to) =>
    frames.places(state.axis).findIndex(({ start, end }) => nearly(start, from) && nearly(end, to));

  /** "12:03 to 13:20", "1.25 to 2.1 km" */
  const placesText = (from, to) => {
    if (state.axis === "time") {
      const digits = to - from < 60 ? 1 : 0;
      return `${clock(from, digits)} to ${clock(to, digits)}`;
    }
    return to > 3000 ? `${(from / 1000).toFixed(2)} to ${(to / 1000).toFixed(2)} km` : `${from.toFixed(0)} to ${to.toFixed(0)} m`;
  };

  const stretchText = (from, to, end) => {
    const whole = from <= 0 && to >= end;
    if (state.overlay) {
      const names = state.overlay.map((i) => laps[i].lap);
      const said = names.length > 4 ? `${names.length} laps` : `lap ${names.join(", ")}`;
      return `${said} over each other${whole ? "" : `, ${placesText(from, to)}`}`;
    }
    if (whole) return `whole run, ${placesText(0, end)}`;
    const lap = laps[lapOf(from, to)];
    return `${lap ? `lap ${lap.lap}, ` : ""}${placesText(from, to)}`;
  };

  /** Buttons that choose the axis and lay laps over each other; `changed` draws what they chose. */
  const connectFrame = (changed) => {
    const pressed = () => {
      for (const axis of ["time", "distance"]) $(`over-${axis}`).setAttribute("aria-pressed", state.axis === axis);
      $("overlay").setAttribute("aria-pressed", state.overlay !== null);
      $("laps-over").hidden = state.overlay === null;
      for (const id of ["lap", "previous", "next"]) $(id).hidden = laps.length < 2 || state.overlay !== null;
      $("whole").textContent = state.overlay ? "Whole lap" : "Whole run";
    };
    const choose = (change) => {
      Object.assign(state, change);
      pressed();
      changed();
    };
    for (const axis of ["time", "distance"]) $(`over-${axis}`).addEventListener("click", () => choose({ axis }));
    const picker = new voltlap.LapPicker({
      root: $("laps-over"),
      names: laps.map(({ lap }) => `${lap}`),
      color: (i) => frames.color(i),
      chosen: frames.usual,
      changed: (overlay) => choose({ overlay }),
    });
    $("overlay").hidden = laps.length < 2;
    $("overlay").addEventListener("click", () => choose({ overlay: state.overlay ? null : picker.chosen }));
    return () => choose({ overlay: null });
  };

  const drawTime = () => {
    $("telemetry").hidden = false;
    const along = data.course ? positions() : column.distance_m;
    const map = drawMap(along);
    const frame = () => (state.overlay ? frames.overlay(state.axis, state.overlay) : frames.whole(state.axis));
    const when = (i, place) => {
      if (state.overlay) return `${state.axis === "time" ? clock(place, 1) : `${place.toFixed(0)} m`} into the lap`;
      const lap = data.course ? [`lap ${laps[lapAt(times[i])].lap}`] : [];
      return [clock(times[i], 1), ...lap, `${along[i].toFixed(0)} m`].join(", ");
    };
    let charts = null;
    const showLap = (i) => {
      if (state.overlay) leaveOverlay();
      const { start, end } = frames.places(state.axis)[i];
      charts.show(start, end);
    };
    const stepLap = (step) => {
      if (!laps.length || state.overlay) return;
      const [from, to] = charts.view;
      const shown = $("lap").value;
      const middle = times[voltlap.indexAt(charts.frame.layers[0].x, (from + to) / 2)];
      const next = shown === "" ? lapAt(middle) : Number(shown) + step;
      showLap(Math.min(Math.max(next, 0), laps.length - 1));
    };
    const leaveOverlay = connectFrame(() => charts.showFrame(frame()));
    connectLaps(showLap, stepLap, () => charts.showAll());
    const view = (from, to) => {
      const { end, layers } = charts ? charts.frame : frame();
      const text = stretchText(from, to, end);
      const whole = from <= 0 && to >= end;
      $("view").textContent = text;
      $("whole").disabled = whole;
      markLap(state.overlay || (whole && laps.length > 1) ? -1 : lapOf(from, to));
      if (state.overlay) map?.show(0, times.length - 1, "Mean speed of all laps");
      else map?.show(voltlap.indexAt(layers[0].x, from), voltlap.indexAt(layers[0].x, to), `Mean speed, ${text}`);
    };
    const cursor = (i, place) => {
      $("cursor").textContent = i === null ? "" : when(i, place);
      map?.showCar(i === null ? null : i + (charts.frame.layers[0].first ?? 0));
    };
    charts = new voltlap.TimeCharts({
      root: $("strips"),
      frame: frame(),
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

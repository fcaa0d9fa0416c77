// SPDX-License-Identifier: Apache-2.0
// The endurance report: what the controls above the charts do.
"use strict";

(() => {
  const { data, clock } = voltlap,
    { column, times, specs } = voltlap.endurance,
    $ = (id) => document.getElementById(id);

  /** Laps with the one that was not completed. */
  const laps = data.laps.map((lap) => ({ ...lap, completed: true }));
  const driven_s = laps.length ? laps[laps.length - 1].end_s : 0;
  if (data.course && data.end_s > driven_s + data.period_s)
    laps.push({ lap: laps.length + 1, start_s: driven_s, end_s: data.end_s, completed: false });
  const frames = new voltlap.RunFrames({
    times,
    thinTimes: voltlap.cellTemperatures.times,
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
    const [scale, digits, unit] = to > 3000 ? [1000, 2, "km"] : [1, 0, "m"];
    return `${(from / scale).toFixed(digits)} to ${(to / scale).toFixed(digits)} ${unit}`;
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

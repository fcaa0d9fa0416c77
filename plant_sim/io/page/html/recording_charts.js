// SPDX-License-Identifier: Apache-2.0
// Recordings against a model: all of them at a glance, and one with its charts. The page has elements #overview,
// #recording (a select), #whole, #view, #cursor and #strips.
"use strict";

voltlap.RecordingCharts = class {
  #recordings;
  #specs;
  #shown;
  #when;
  #charts = null;
  #overview = null;

  /**
   * @param recordings [{name, note, end_s, rms_mv, max_mv, most_mv, samples, begins, columns}]
   * @param error      {rms_mv, max_mv, most_mv} of all of them together
   * @param first      index of the one that is shown first
   * @param specs      (recording, column, bands, reach) gives its charts
   * @param shown      called with the recording that is shown; may be left out
   * @param when       (column, index) gives words behind the time of the cursor; may be left out
   */
  constructor({ recordings, error, first, specs, shown, when }) {
    this.#recordings = recordings;
    this.#specs = specs;
    this.#shown = shown ?? (() => {});
    this.#when = when ?? (() => "");
    const select = document.getElementById("recording");
    select.append(...recordings.map(({ name }, i) => new Option(name, i)));
    select.addEventListener("change", () => this.show(Number(select.value)));
    document.getElementById("whole").addEventListener("click", () => this.#charts.showAll());
    if (recordings.length > 1) this.#drawOverview(error);
    this.show(first ?? 0);
  }

  static #column({ columns, samples }, name) {
    return voltlap.decode(columns[name], samples);
  }

  #drawOverview(error) {
    const { element, quantity, SmallMultiples } = voltlap;
    const root = document.getElementById("overview");
    const reach = voltlap.errorReach(error);
    const items = this.#recordings.map((one) => ({
      name: one.name,
      note: [`RMS ${quantity(one.rms_mv, 2, "mV")}, largest ${quantity(one.max_mv, 0, "mV")}`, one.note]
        .filter(Boolean)
        .join("; "),
      end_s: one.end_s,
      read: () => ({
        times: voltlap.RecordingCharts.#column(one, "time_s"),
        values: voltlap.RecordingCharts.#column(one, "error_mv"),
        breaks: one.begins,
      }),
    }));
    const alike = items.every((item) => SmallMultiples.end(items, item) === SmallMultiples.end(items, items[0]));
    const lengths = alike ? "" : ", each over its own length";
    const note = `Error in mV over time, all on one scale${lengths}; arrows: beyond it. Choose one to see its charts.`;
    const grid = element("div", { class: "multiples" });
    root.hidden = false;
    root.append(element("p", { class: "note" }, note), grid);
    const open = (i) => {
      this.show(i);
      document.getElementById("hint").scrollIntoView();
    };
    this.#overview = new SmallMultiples({ root: grid, items, reach, open });
  }

  /** Stretches of samples that do not count. */
  static bands(times, counts, breaks) {
    const bands = [];
    for (let i = 1; i < times.length; i += 1) {
      if (counts[i]) continue;
      const last = bands[bands.length - 1];
      const from_s = breaks.includes(i) ? times[i] : times[i - 1];
      if (last && last.last === i - 1 && from_s <= last.to_s) Object.assign(last, { to_s: times[i], last: i });
      else bands.push({ from_s, to_s: times[i], reason: 0, last: i, color: "grey" });
    }
    return bands;
  }

  show(chosen) {
    const $ = (id) => document.getElementById(id);
    const recording = this.#recordings[chosen];
    const column = Object.fromEntries(
      Object.keys(recording.columns).map((name) => [name, voltlap.RecordingCharts.#column(recording, name)]),
    );
    const times = column.time_s;
    const bands = voltlap.RecordingCharts.bands(times, column.counts, recording.begins);
    $("recording").value = chosen;
    this.#overview?.mark(chosen);
    $("strips").replaceChildren();
    let view = [0, recording.end_s];
    const when = (i) => `${voltlap.elapsed(times[i], ...view)}${this.#when(column, i)}`;
    this.#charts = new voltlap.TimeCharts({
      root: $("strips"),
      times,
      end_s: recording.end_s,
      laps: [],
      window_s: null,
      axis: voltlap.elapsedAxis,
      breaks: recording.begins,
      specs: this.#specs(recording, column, bands, voltlap.errorReach(recording)),
      describedBy: "hint",
      listener: {
        view: (from, to) => {
          view = [from, to];
          $("view").textContent = voltlap.elapsedStretch(from, to);
          $("whole").disabled = from <= 0 && to >= recording.end_s;
        },
        cursor: (i) => {
          $("cursor").textContent = i === null ? "" : when(i);
        },
        when,
        stepLap: () => {},
      },
    });
    this.#shown(recording);
  }

  redraw() {
    this.#charts.redraw();
    this.#overview?.redraw();
  }
};

// SPDX-License-Identifier: Apache-2.0
// A run along its time or its distance, whole or lap over lap, as frames of voltlap.TimeCharts.
"use strict";

voltlap.RunFrames = class {
  static lapsMost = 40;

  #times;
  #thin;
  #distance;
  #laps;
  #end_s;
  #lap_m;

  /**
   * @param times    Float64Array, s
   * @param thinTimes of signals that have fewer samples: frames hold their layers as `thin`
   * @param distance Float64Array, m along the course since the start
   * @param laps     [{lap, start_s, end_s}]
   * @param end_s    end of the run
   * @param lap_m    length of a lap where laps are counted by position; null where they are not
   */
  constructor({ times, thinTimes, distance, laps, end_s, lap_m }) {
    this.#times = times;
    this.#thin = { time: thinTimes, distance: thinTimes.map((time) => voltlap.valueAt(times, distance, time)) };
    this.#distance = distance;
    this.#laps = laps;
    this.#end_s = end_s;
    this.#lap_m = lap_m;
  }

  #x(axis) {
    return axis === "time" ? this.#times : this.#distance;
  }

  #at(axis, time) {
    return axis === "time" ? time : voltlap.valueAt(this.#times, this.#distance, time);
  }

  /** Where each lap begins and ends on an axis: [{lap, start, end}]. */
  places(axis) {
    const byPosition = axis === "distance" && this.#lap_m !== null;
    return this.#laps.map(({ lap, start_s, end_s, completed }) => ({
      lap,
      start: byPosition ? (lap - 1) * this.#lap_m : start_s > 0 ? this.#at(axis, start_s) : 0,
      end: byPosition && completed ? lap * this.#lap_m : this.#at(axis, end_s),
    }));
  }

  /** The colours of laps run from the first to the last. */
  color(i) {
    return voltlap.TrackMap.color(this.#laps.length > 1 ? i / (this.#laps.length - 1) : 0);
  }

  whole(axis) {
    const places = this.places(axis);
    const end = axis === "time" ? this.#end_s : Math.max(this.#at(axis, this.#end_s), places.at(-1)?.end ?? 0, 1);
    const completed = places.filter((place, i) => this.#laps[i].completed);
    const lengths = completed.map((place) => place.end - place.start);
    const frame = {
      axis: voltlap.axes[axis],
      layers: [{ x: this.#x(axis), values: (series) => series.values }],
      end,
      laps: places.length <= 60 ? completed.map((place) => place.end) : [],
      window: lengths.length ? Math.min(...lengths) : null,
      at: (time) => this.#at(axis, time),
    };
    return { ...frame, thin: { ...frame, layers: [{ ...frame.layers[0], x: this.#thin[axis] }] } };
  }

  /** The chosen laps (indices) over each other, each from its own start. */
  overlay(axis, chosen) {
    const places = this.places(axis);
    const layersAt = (x) =>
      chosen.map((i) => {
        const { lap, start, end } = places[i];
        const first = voltlap.indexAt(x, start) + (x[voltlap.indexAt(x, start)] < start ? 1 : 0);
        const last = Math.max(voltlap.indexAt(x, end), first) + 1;
        return {
          name: `lap ${lap}`,
          color: this.color(i),
          first,
          x: x.subarray(first, last).map((place) => place - start),
          values: (series) => series.values.subarray(first, last),
        };
      });
    const end = Math.max(...chosen.map((i) => places[i].end - places[i].start));
    const frame = { axis: voltlap.axes[axis], layers: layersAt(this.#x(axis)), end, laps: [], window: null, at: null };
    return { ...frame, thin: { ...frame, layers: layersAt(this.#thin[axis]) } };
  }

  /** The laps that are shown at first: all, or evenly some of very many. */
  get usual() {
    const every = Math.ceil(this.#laps.length / voltlap.RunFrames.lapsMost);
    return this.#laps.map((lap, i) => i).filter((i) => i % every === 0);
  }
};

/** Boxes that choose some of the laps; `changed` is told the indices, at least one. */
voltlap.LapPicker = class {
  #boxes;
  #changed;

  constructor({ root, names, color, chosen, changed }) {
    const { element } = voltlap;
    this.#changed = changed;
    this.#boxes = names.map((name, i) => {
      const box = element("input", { type: "checkbox", "aria-label": `lap ${name}` });
      box.checked = chosen.includes(i);
      box.addEventListener("change", () => this.#tell(box));
      root.append(element("label", { class: "chip", style: `--key: ${color(i)}` }, box, name));
      return box;
    });
    const all = element("button", { type: "button" }, "all");
    all.addEventListener("click", () => this.choose(names.map((name, i) => i)));
    root.prepend(all);
    const ends = element("button", { type: "button" }, "first and last");
    ends.addEventListener("click", () => this.choose([0, names.length - 1]));
    root.prepend(ends);
  }

  get chosen() {
    return this.#boxes.flatMap((box, i) => (box.checked ? [i] : []));
  }

  choose(indices) {
    this.#boxes.forEach((box, i) => {
      box.checked = indices.includes(i);
    });
    this.#changed(this.chosen);
  }

  /** The last lap cannot be taken away: there would be nothing to draw. */
  #tell(box) {
    if (!this.chosen.length) box.checked = true;
    this.#changed(this.chosen);
  }
};

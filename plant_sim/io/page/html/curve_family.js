// SPDX-License-Identifier: Apache-2.0
// Many curves of one kind in one chart, such as the temperature of each cell: thin lines, coloured by their place in
// the row, and the one under the pointer told by name. A frame's `thin` layers hold their samples.
"use strict";

voltlap.CurveFamily = class {
  /** Beyond this many curves over each other only the chart's own series are drawn: highest and lowest. */
  static curvesMost = 400;

  #name;
  #values;
  #color;
  #marks;

  /**
   * @param name   of curve i
   * @param values [Float64Array] at the times of the thin layers
   * @param color  of curve i
   * @param marks  {curve: extreme}, as of a series
   */
  constructor({ name, values, color, marks }) {
    this.#name = name;
    this.#values = values;
    this.#color = color;
    this.#marks = marks;
  }

  get size() {
    return this.#values.length;
  }

  /** When the curves are drawn over each other. */
  get remark() {
    const most = Math.floor(voltlap.CurveFamily.curvesMost / this.size);
    return `of ${most} lap${most === 1 ? "" : "s"} or fewer each curve is drawn`;
  }

  fits({ layers }) {
    return layers.length * this.size <= voltlap.CurveFamily.curvesMost;
  }

  /** The curves of a frame: {i, layer, name, color}; laps over each other have each their own colour. */
  #curves({ layers, at }) {
    return layers.flatMap((layer) =>
      this.#values.map((values, i) => ({
        i,
        layer,
        name: at === null ? `${this.#name(i)}, ${layer.name}` : this.#name(i),
        color: at === null ? layer.color : this.#color(i),
        values: layer.values({ values }),
      })),
    );
  }

  /** As voltlap.chartLines. */
  lines(frame) {
    const width = this.size * frame.layers.length > 40 ? 0.9 : 1.2;
    return this.#curves(frame).map(({ i, layer, name, color, values }) => {
      const extreme = frame.at === null ? undefined : this.#marks[i];
      return {
        name,
        data: voltlap.withExtreme(layer.x, values),
        color,
        stroke: { width },
        z: 4,
        role: "member",
        mark: extreme ? { ...extreme, x: frame.at(extreme.time_s) } : null,
      };
    });
  }

  /** Every curve that is there at a place, highest first: {name, color, value, layer, values}. */
  at(frame, place) {
    return this.#curves(frame)
      .filter(({ layer, values }) => {
        const to = layer.x[Math.min(layer.x.length, values.length) - 1];
        return frame.at !== null || (place >= layer.x[0] && place <= to);
      })
      .map((curve) => ({ ...curve, value: voltlap.valueAt(curve.layer.x, curve.values, place) }))
      .sort((a, b) => b.value - a.value);
  }

  /** The one of `curves` (from at()) that is nearest to a value. */
  static nearest(curves, value) {
    return curves.reduce((best, one) => (Math.abs(one.value - value) < Math.abs(best.value - value) ? one : best));
  }

  /** A bar from the first to the last of them, for a legend. */
  legend() {
    const colors = this.#values.map((unused, i) => this.#color(i));
    const style = `--ramp: linear-gradient(90deg, ${colors.join(",")})`;
    const bar = voltlap.element("i", { class: "ramp-bar", style });
    return voltlap.element("li", {}, `${this.#name(0)} `, bar, ` ${this.#name(this.size - 1)}`);
  }
};

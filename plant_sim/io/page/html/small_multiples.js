// SPDX-License-Identifier: Apache-2.0
// Many recordings at a glance: a grid of small charts on one scale, each a button that opens its recording.
"use strict";

voltlap.SmallMultiples = class {
  #charts = [];
  #items;
  #reach;

  /**
   * @param root  element that the grid is put into
   * @param items [{name, note, end_s, read()}]; read() gives {times, values, breaks} when the chart is drawn
   * @param reach {low, high}, the scale of all
   * @param open  called with the index of the item that was chosen
   */
  constructor({ root, items, reach, open }) {
    const { element } = voltlap;
    this.#items = items;
    this.#reach = reach;
    const places = items.map(({ name, note }, i) => {
      const canvas = element("span", { class: "small-canvas", id: `small-${i}` });
      const title = element("span", { class: "small-name" }, name);
      const words = element("small", {}, note);
      const button = element("button", { type: "button", class: "small", title: `Open ${name}` }, title, words, canvas);
      button.addEventListener("click", () => open(i));
      root.append(button);
      return canvas;
    });
    this.#charts = places.map((place) => echarts.init(place, null, { renderer: "canvas" }));
    this.redraw();
    let width = root.clientWidth;
    new ResizeObserver(() => {
      if (root.clientWidth === width) return;
      width = root.clientWidth;
      for (const chart of this.#charts) chart.resize();
    }).observe(root);
    this.mark = (chosen) =>
      [...root.children].forEach((button, i) => button.setAttribute("aria-current", String(i === chosen)));
  }

  /** Where the time axis of an item ends: all alike, unless one lasts so long that others would be a stroke. */
  static end(items, item) {
    const longest = Math.max(...items.map(({ end_s }) => end_s));
    const shortest = Math.min(...items.map(({ end_s }) => end_s));
    return longest <= 4 * shortest ? longest : item.end_s;
  }

  redraw() {
    this.#items.forEach((item, i) => this.#draw(item, this.#charts[i]));
  }

  #draw(item, chart) {
    const { color } = voltlap;
    const { low, high } = this.#reach;
    const { times, values, breaks } = item.read();
    const text = { color: color("muted"), fontFamily: voltlap.font(), fontSize: 11 };
    const end = voltlap.SmallMultiples.end(this.#items, item);
    const axis = voltlap.elapsedAxis.inView(0, end);
    const { step, ticks } = voltlap.ticks(axis.steps, 0, end, Math.min(3, (chart.getWidth() - 54) / 50));
    const unit = voltlap.elapsedUnit(end).name;
    const formatter = (value) => `${axis.text(value, step)}${value === ticks[ticks.length - 1] ? ` ${unit}` : ""}`;
    const runs = voltlap.runsBeyond(times, values, this.#reach, end / 40);
    chart.setOption(
      {
        animation: false,
        textStyle: text,
        grid: { left: 40, right: 14, top: 8, bottom: 20 },
        xAxis: {
          type: "value",
          min: 0,
          max: end,
          axisLine: { lineStyle: { color: color("line") }, onZero: false },
          splitLine: { show: false },
          axisTick: { customValues: ticks },
          axisLabel: { ...text, customValues: ticks, formatter },
        },
        yAxis: {
          type: "value",
          min: low,
          max: high,
          interval: high,
          axisLabel: { ...text, formatter: voltlap.axisNumber },
          splitLine: { lineStyle: { color: color("grid") } },
        },
        series: [
          {
            type: "line",
            name: item.name,
            data: voltlap.broken(voltlap.withExtreme(times, values), breaks),
            dimensions: ["x", "value"],
            showSymbol: false,
            silent: true,
            animation: false,
            lineStyle: { color: color("purple"), width: 1, join: "round" },
          },
          voltlap.beyondSeries(runs, this.#reach, color("open"), 4),
        ],
      },
      { notMerge: true },
    );
  }
};

// SPDX-License-Identifier: Apache-2.0
// One chart over time, a member of voltlap.TimeCharts.
//
// A chart is {id, title, axis, unit, digits, low, high, interval, means, series, bands, bandNames, level, events,
// note};
// a level {low, high, color, text} is a stretch of the value axis that is coloured all along.
// A series is {name, color, role, values, extreme, remark}: values at the shared times; role "reference" is drawn broad
// and pale under the others, "limit" dashed; a true extreme {time_s, value, text, below} may fall between two samples.
// With `means` a view of many laps draws the samples pale and their running mean over a lap on top.
"use strict";

voltlap.TimeChart = class {
  static left = 66;
  static right = 18;
  static top = 20;
  static bottom = 36;

  static #strokes = { signal: { width: 1.5 }, reference: { width: 5 }, limit: { width: 1.3, type: [5, 3] } };

  #spec;
  #group;
  #plot;
  #chart;
  #surface;
  #line;
  #selection;
  #tip;
  #meanNote;
  #outputs = [];

  constructor(root, spec, group, describedBy) {
    this.#spec = spec;
    this.#group = group;
    this.#build(root, describedBy);
    new voltlap.ChartGestures(this, group, this.#surface);
  }

  open() {
    this.#chart = echarts.init(this.#plot.querySelector(".canvas"), null, { renderer: "canvas" });
    this.draw();
    let width = this.#plot.clientWidth;
    new ResizeObserver(() => {
      if (this.#plot.clientWidth === width) return;
      width = this.#plot.clientWidth;
      this.#chart.resize();
      this.showView();
    }).observe(this.#plot);
  }

  static #key({ color, role = "" }) {
    return voltlap.element("span", { class: `key ${role}`, style: `--key: var(--${color})` });
  }

  #build(root, describedBy) {
    const { element } = voltlap;
    const spec = this.#spec;
    const legend = element("ul", { class: "legend" });
    for (const series of spec.series) {
      const output = element("output");
      this.#outputs.push(output);
      legend.append(element("li", {}, voltlap.TimeChart.#key(series), `${series.name} `, output));
    }
    for (const band of [...(spec.bandNames ?? []), ...(spec.level ? [spec.level] : [])]) {
      legend.append(
        element("li", {}, element("span", { class: "key block", style: `--key: var(--${band.color})` }), band.text),
      );
    }
    this.#meanNote = element("li", { hidden: "" }, "bold: mean over a lap");
    legend.append(this.#meanNote);
    if (spec.note) legend.append(element("li", {}, spec.note));
    this.#line = element("div", { class: "cursor-line" });
    this.#selection = element("div", { class: "selection" });
    this.#tip = element("div", { class: "tip" });
    this.#surface = element("div", {
      class: "surface",
      tabindex: "0",
      role: "group",
      "aria-roledescription": "chart over time",
      "aria-label": `${spec.title}, ${spec.series.map((series) => series.name).join(", ")}, in ${spec.unit}`,
      "aria-describedby": describedBy,
    });
    this.#plot = element(
      "div",
      { class: "plot" },
      element("div", { class: "canvas", id: spec.id }),
      this.#selection,
      this.#line,
      this.#surface,
      this.#tip,
    );
    root.append(
      element("section", { class: "card" }, element("header", {}, element("h3", {}, spec.title), legend), this.#plot),
    );
  }

  get #meanSeries() {
    return this.#spec.means && this.#group.window !== null ? this.#spec.series.filter(({ role }) => !role) : [];
  }

  draw() {
    const { color } = voltlap;
    const spec = this.#spec;
    const text = { color: color("muted"), fontFamily: voltlap.font(), fontSize: 11.5 };
    const lines = this.#group.laps.map((lap) => ({ xAxis: lap.end_s }));
    for (const { time_s, text: label } of spec.events ?? []) {
      const style = { color: color("bad"), fontWeight: 600 };
      lines.push({
        xAxis: time_s,
        lineStyle: { ...style, width: 2 },
        label: { ...text, ...style, show: true, formatter: label, distance: 3 },
      });
    }
    const series = spec.series.map((one, i) => ({
      type: "line",
      name: one.name,
      data: voltlap.withExtreme(this.#group.times, one),
      dimensions: ["time_s", "value"],
      showSymbol: false,
      silent: true,
      sampling: "minmax",
      animation: false,
      z: { reference: 2, limit: 6 }[one.role] ?? 5 - i,
      lineStyle: {
        color: color(one.color),
        opacity: this.#opacity(i),
        join: "round",
        ...voltlap.TimeChart.#strokes[one.role ?? "signal"],
      },
      markArea: i === 0 && spec.level ? this.#levelArea(spec.level) : undefined,
      markPoint: one.extreme?.text ? this.#mark(one.extreme, one.color, text) : undefined,
      markLine:
        i === 0 && lines.length
          ? {
              silent: true,
              symbol: "none",
              label: { show: false },
              data: lines,
              animation: false,
              z: 1,
              lineStyle: { color: color("line"), width: 1, type: "solid" },
            }
          : undefined,
    }));
    this.#meanSeries.forEach((one, i) => {
      series.push({
        type: "line",
        name: `${one.name}, mean over a lap`,
        data: voltlap.runningMeans(this.#group.times, one.values, this.#group.window),
        showSymbol: false,
        silent: true,
        animation: false,
        z: 7,
        lineStyle: { color: color(one.color), opacity: this.#opacity(spec.series.length + i), width: 2.2 },
      });
    });
    if (spec.bands?.length) series.push(this.#bandSeries());
    this.#chart.setOption(
      {
        animation: false,
        textStyle: text,
        grid: {
          left: voltlap.TimeChart.left,
          right: voltlap.TimeChart.right,
          top: voltlap.TimeChart.top,
          bottom: voltlap.TimeChart.bottom,
        },
        xAxis: {
          type: "value",
          min: 0,
          max: this.#group.end,
          name: "time, min:s",
          nameLocation: "middle",
          nameGap: 22,
          nameTextStyle: text,
          axisLine: { lineStyle: { color: color("line") }, onZero: false },
          splitLine: { show: false },
          ...this.#viewAxis(text),
        },
        yAxis: {
          type: "value",
          min: spec.low,
          max: spec.high,
          scale: true,
          splitNumber: 4,
          name: `${spec.axis ?? spec.title}, ${spec.unit}`,
          nameLocation: "middle",
          nameRotate: 90,
          nameGap: 46,
          nameTextStyle: text,
          axisLabel: { ...text, hideOverlap: true },
          splitLine: { lineStyle: { color: color("grid") } },
          interval: spec.interval,
        },
        dataZoom: [
          {
            type: "inside",
            disabled: true,
            xAxisIndex: 0,
            filterMode: spec.bands?.length ? "weakFilter" : "filter",
            ...this.#viewRange(),
          },
        ],
        series,
      },
      { notMerge: true },
    );
    this.#showMeanNote();
  }

  #viewRange() {
    const [startValue, endValue] = this.#group.view;
    return { startValue, endValue };
  }

  /** Ticks at whole steps of the clock. */
  #viewAxis(text) {
    const [from, to] = this.#group.view;
    const step = voltlap.TimeChart.#step(to - from, this.width);
    const ticks = [];
    for (let k = Math.ceil(from / step - 1e-6); k * step <= to + 1e-6; k += 1) ticks.push(k * step);
    const formatter = (value) => voltlap.clock(value, step < 1 ? 1 : 0);
    return {
      axisTick: { customValues: ticks },
      axisLabel: { ...text, hideOverlap: true, formatter, customValues: ticks },
    };
  }

  /** Of line i, means last: samples are pale under their mean, which is there only in a view of many laps. */
  #opacity(i) {
    const on = this.#meanSeries.length > 0 && this.#group.showsMeans;
    const samples = this.#spec.series;
    if (i >= samples.length) return Number(on);
    if (samples[i].role === "reference") return on ? 0 : 0.4;
    return on && !samples[i].role ? 0.22 : 1;
  }

  #mark(extreme, name, text) {
    const { color } = voltlap;
    const part = extreme.time_s / this.#group.end;
    return {
      silent: true,
      symbol: "circle",
      symbolSize: 7,
      animation: false,
      z: 9,
      itemStyle: { color: color("surface"), borderColor: color(name), borderWidth: 2 },
      label: {
        ...text,
        color: color("text"),
        fontWeight: 600,
        formatter: extreme.text,
        distance: 6,
        position: part > 0.94 ? "left" : part < 0.06 || extreme.below ? "right" : "top",
        offset: part > 0.94 && !extreme.below ? [4, -9] : [0, 0],
        textBorderColor: color("surface"),
        textBorderWidth: 3,
      },
      data: [{ coord: [extreme.time_s, extreme.value], value: extreme.value }],
    };
  }

  #levelArea({ low, high, color }) {
    const itemStyle = { color: voltlap.color(color), opacity: 0.22 };
    return { silent: true, animation: false, z: 0, itemStyle, data: [[{ yAxis: low }, { yAxis: high }]] };
  }

  /** Stretches of time as coloured columns with a solid foot: [from, to, colour]. */
  #bandSeries() {
    const bands = this.#spec.bands;
    return {
      type: "custom",
      name: "bands",
      silent: true,
      animation: false,
      z: 0,
      clip: true,
      encode: { x: [0, 1] },
      dimensions: ["from_s", "to_s", "reason"],
      data: bands.map((band) => [band.from_s, band.to_s, band.reason]),
      renderItem: (params, api) => {
        const area = params.coordSys;
        const fill = voltlap.color(bands[params.dataIndex].color);
        const left = Math.max(api.coord([api.value(0), 0])[0], area.x);
        const right = Math.min(api.coord([api.value(1), 0])[0], area.x + area.width);
        const column = (y, height, opacity) => ({
          type: "rect",
          shape: { x: left, y, width: Math.max(right - left, 1), height },
          style: { fill, opacity },
        });
        return { type: "group", children: [column(area.y, area.height, 0.2), column(area.y + area.height - 6, 6, 1)] };
      },
    };
  }

  /** Ticks at whole seconds, minutes or hours, about one for 90 pixels. */
  static #step(seconds, width) {
    const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 18000, 36000];
    return steps.find((step) => seconds / step <= Math.max(2, width / 80)) ?? 86400;
  }

  /** Pixels of the time axis. */
  get width() {
    return this.#plot.clientWidth - voltlap.TimeChart.left - voltlap.TimeChart.right;
  }

  showView() {
    if (this.width <= 0) return;
    const lines = this.#spec.series.length + this.#meanSeries.length;
    const series = Array.from({ length: lines }, (_, i) => ({ lineStyle: { opacity: this.#opacity(i) } }));
    this.#chart.setOption({ xAxis: this.#viewAxis({}), dataZoom: [this.#viewRange()], series });
    this.#showMeanNote();
  }

  #showMeanNote() {
    this.#meanNote.hidden = this.#meanSeries.length === 0 || !this.#group.showsMeans;
  }

  #xOf(time) {
    const [from, to] = this.#group.view;
    return voltlap.TimeChart.left + ((time - from) / (to - from)) * this.width;
  }

  /** Time under a horizontal position of the window, kept inside the view. */
  timeAt(clientX) {
    const [from, to] = this.#group.view;
    const x = clientX - this.#plot.getBoundingClientRect().left - voltlap.TimeChart.left;
    return Math.min(Math.max(from + (x / this.width) * (to - from), from), to);
  }

  /** Style of a part that covers the plot's height, `width` pixels from `x` on. */
  #column(x, width) {
    const height = this.#plot.clientHeight - voltlap.TimeChart.top - voltlap.TimeChart.bottom;
    const place = `top:${voltlap.TimeChart.top}px;height:${height}px;width:${width}px`;
    return `display:block;${place};transform:translateX(${x}px)`;
  }

  /** The stretch between two positions of the window, as the mouse selects it. */
  showSelection(a, b) {
    const left = Math.min(a, b) - this.#plot.getBoundingClientRect().left;
    this.#selection.style.cssText = this.#column(left, Math.abs(a - b));
  }

  hideSelection() {
    this.#selection.style.cssText = "";
  }

  showCursor(index, withTip) {
    const [from, to] = this.#group.view;
    const time = this.#group.cursor;
    const visible = index !== null && time >= from && time <= to;
    this.#spec.series.forEach((series, i) => {
      this.#outputs[i].textContent = index === null ? "" : this.#valueText(series, index);
    });
    this.#line.style.cssText = visible ? this.#column(this.#xOf(time), 1) : "";
    if (visible && withTip) this.#showTip(index);
    else this.#tip.style.display = "none";
  }

  #valueText(series, index) {
    const number = voltlap.quantity(series.values[index], this.#spec.digits, this.#spec.unit);
    return series.remark ? `${number}${series.remark(index)}` : number;
  }

  #showTip(index) {
    const { element } = voltlap;
    const x = this.#xOf(this.#group.cursor);
    this.#tip.replaceChildren(element("div", { class: "when" }, this.#group.listener.when(index)));
    for (const series of this.#spec.series) {
      this.#tip.append(
        element(
          "div",
          {},
          voltlap.TimeChart.#key(series),
          `${series.name} `,
          element("b", {}, this.#valueText(series, index)),
        ),
      );
    }
    this.#tip.style.display = "block";
    const width = this.#tip.offsetWidth;
    const room = this.#plot.clientWidth;
    const left = x + 14 + width < room ? x + 14 : Math.max(0, x - 14 - width);
    this.#tip.style.transform = `translateX(${left}px)`;
  }
};

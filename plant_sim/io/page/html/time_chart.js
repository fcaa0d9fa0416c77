// SPDX-License-Identifier: Apache-2.0
// One chart over time or distance, a member of voltlap.TimeCharts.
//
// A chart is {id, title, axis, unit, digits, low, high, interval, means, series, bands, bandNames, level, ruler,
// events, note, family, tall, reach}; a level {low, high, color, text} is a stretch of the value axis that is coloured
// all along, a ruler {value, text} a line across. A reach {low, high} is the scale of a chart whose values may run
// beyond it: where they do an arrow stands at the edge, the legend says how far, and a button shows all of it.
// A series is {name, color, role, values, extreme, remark}: values at the shared times; role "reference" is drawn broad
// and pale under the others, "pale" thin and pale, "limit" dashed; a true extreme {time_s, value, text, below} may fall
// between two samples.
// A family (voltlap.CurveFamily) is drawn in place of the series, which only say its highest and lowest; both are at
// the times of the frame's thin layers.
// With `means` a view of many laps draws the samples pale and their running mean over a lap on top.
// Curves over each other are those of series without a role, the second series dashed.
// A series with times of its own (voltlap.OwnTimes) has points(from, to, width), textAt(place) and step in place of
// values; `range` stands behind its name.
"use strict";

voltlap.TimeChart = class {
  static left = 66;
  static right = 18;
  static top = 20;
  static bottom = 36;

  static #tipRows = 6;

  #spec;
  #group;
  #plot;
  #chart;
  #surface;
  #line;
  #selection;
  #tip;
  #meanNote;
  #legend;
  #pointerY = null;
  #whole = false;
  #emphasised;
  #lines = [];
  #outputs = [];

  constructor(root, spec, group, describedBy) {
    this.#spec = spec;
    this.#group = group;
    this.#build(root, describedBy);
    this.#surface.addEventListener("pointermove", ({ clientY }) => (this.#pointerY = clientY));
    this.#surface.addEventListener("pointerdown", ({ clientY }) => (this.#pointerY = clientY));
    this.#surface.addEventListener("keydown", () => (this.#pointerY = null));
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

  static #key({ color, role = "", paint = `var(--${color})` }) {
    return voltlap.element("span", { class: `key ${role}`, style: `--key: ${paint}` });
  }

  #build(root, describedBy) {
    const { element } = voltlap;
    const spec = this.#spec;
    this.#legend = element("ul", { class: "legend" });
    this.#meanNote = element("li", { hidden: "" }, "bold: mean over a lap");
    this.#line = element("div", { class: "cursor-line" });
    this.#selection = element("div", { class: "selection" });
    this.#tip = element("div", { class: "tip" });
    this.#surface = element("div", {
      class: "surface",
      tabindex: "0",
      role: "group",
      "aria-roledescription": "chart over time or distance",
      "aria-label": voltlap.chartLabel(spec),
      "aria-describedby": describedBy,
    });
    this.#plot = element(
      "div",
      { class: `plot${spec.tall ? " tallest" : ""}` },
      element("div", { class: "canvas", id: spec.id }),
      this.#selection,
      this.#line,
      this.#surface,
      this.#tip,
    );
    root.append(
      element(
        "section",
        { class: "card" },
        element("header", {}, element("h3", {}, spec.title), this.#legend),
        this.#plot,
      ),
    );
  }

  get #overlaid() {
    return this.#group.frame.at === null;
  }

  /** The frame with the samples of this chart. */
  get #frame() {
    return this.#spec.family ? this.#group.frame.thin : this.#group.frame;
  }

  get #showsFamily() {
    return this.#spec.family?.fits(this.#frame) ?? false;
  }

  /** The signals that curves over each other show. */
  get #signals() {
    return this.#spec.series.filter(({ role }) => !role);
  }

  #fillLegend() {
    const { element } = voltlap;
    const spec = this.#spec;
    this.#outputs = [];
    this.#legend.replaceChildren();
    if (this.#showsFamily && !this.#overlaid) this.#legend.append(spec.family.legend());
    if (this.#overlaid && this.#showsFamily) {
      this.#legend.append(element("li", {}, "each cell, in the colour of its lap"));
      return;
    }
    if (this.#overlaid) {
      this.#signals.forEach(({ name }, i) => {
        const key = { color: "muted", role: i > 0 ? "limit" : "" };
        this.#legend.append(element("li", {}, voltlap.TimeChart.#key(key), name));
      });
      if (spec.family) this.#legend.append(element("li", {}, spec.family.remark));
      this.#legend.append(this.#meanNote);
      return;
    }
    for (const series of spec.series) {
      const output = element("output");
      this.#outputs.push(output);
      const key = this.#showsFamily ? [] : [voltlap.TimeChart.#key(series)];
      this.#legend.append(element("li", {}, ...key, `${series.name} `, voltlap.rangeText(series), output));
    }
    for (const band of [...(spec.bandNames ?? []), ...(spec.level ? [spec.level] : [])]) {
      const key = element("span", { class: "key block", style: `--key: var(--${band.color})` });
      this.#legend.append(element("li", {}, key, band.text));
    }
    this.#legend.append(this.#meanNote);
    const beyond = this.#beyond;
    const change = () => {
      this.#whole = !this.#whole;
      this.draw();
    };
    if (beyond.length) this.#legend.append(voltlap.beyondLegend(spec, beyond, this.#whole, change));
    if (spec.note) this.#legend.append(element("li", {}, spec.note));
  }

  /** The runs of samples beyond the chart's reach. */
  get #beyond() {
    return this.#spec.reach ? voltlap.beyondReach(this.#spec, this.#group) : [];
  }

  get #axis() {
    const { axis } = this.#group.frame;
    return axis.inView ? axis.inView(...this.#group.view) : axis;
  }

  /** Of a line with times of its own what the view can show. */
  #dataOf(line) {
    return line.points ? line.points(...this.#group.view, this.width) : line.data;
  }

  #lineStyle(line) {
    // Samples are pale under their mean, which is there only in a view of many laps.
    const on = this.#lines.some(({ role }) => role === "means") && this.#group.showsMeans;
    return { opacity: voltlap.opacity(line.role, on) };
  }

  draw() {
    const { color } = voltlap;
    const { left, right, top, bottom } = voltlap.TimeChart;
    const spec = this.#spec;
    const text = { color: color("muted"), fontFamily: voltlap.font(), fontSize: 11.5 };
    const { end, layers } = this.#group.frame;
    const reach = this.#whole ? null : spec.reach;
    this.#fillLegend();
    this.#lines = voltlap.chartLines(spec, this.#frame);
    this.#emphasised = undefined;
    const series = this.#lines.map((line, i) => ({
      type: "line",
      name: line.name,
      data: this.#dataOf(line),
      step: line.step,
      dimensions: ["x", "value"],
      showSymbol: false,
      silent: true,
      // By index, which draws slopes and over breaks where the times of a recording are uneven.
      sampling: line.role === "means" || line.points || layers[0].breaks ? undefined : "minmax",
      animation: false,
      z: line.z,
      lineStyle: { color: line.color, join: "round", ...line.stroke, ...this.#lineStyle(line) },
      markArea: i === 0 && spec.level ? voltlap.levelArea(spec.level) : undefined,
      markPoint: line.mark ? voltlap.markPoint(line.mark, line.color, end, text) : undefined,
      markLine: i === 0 ? voltlap.markLines(spec, this.#group.frame, text) : undefined,
    }));
    if (this.#showsFamily) series.push(voltlap.emphasisSeries());
    if (reach) series.push(voltlap.beyondSeries(this.#beyond, reach, color("open")));
    if (this.#showsBands) series.push(voltlap.bandSeries(spec.bands, this.#group.frame));
    this.#chart.setOption(
      {
        animation: false,
        textStyle: text,
        grid: { left, right, top, bottom, outerBoundsMode: "none" },
        xAxis: {
          type: "value",
          min: this.#group.begin,
          max: end,
          nameLocation: "middle",
          nameGap: 22,
          nameTextStyle: text,
          axisLine: { lineStyle: { color: color("line") }, onZero: false },
          splitLine: { show: false },
          ...this.#viewAxis(text),
        },
        yAxis: voltlap.valueAxis(spec, reach, text),
        dataZoom: [
          {
            type: "inside",
            disabled: true,
            xAxisIndex: 0,
            filterMode: this.#showsBands || reach ? "weakFilter" : "filter",
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

  /** Ticks at whole steps of the axis, about one for 80 pixels. */
  #viewAxis(text) {
    const [from, to] = this.#group.view;
    const { end } = this.#group.frame;
    const axis = this.#axis;
    const { step, ticks } = voltlap.ticks(axis.steps, from, to, this.width / 80);
    const formatter = (value) => axis.text(value, step, end);
    return {
      name: axis.name(end),
      axisTick: { customValues: ticks },
      axisLabel: { ...text, hideOverlap: true, formatter, customValues: ticks },
    };
  }

  get #showsBands() {
    return this.#spec.bands?.length > 0 && !this.#overlaid;
  }

  /** Pixels of the axis. */
  get width() {
    return this.#plot.clientWidth - voltlap.TimeChart.left - voltlap.TimeChart.right;
  }

  showView() {
    if (this.width <= 0) return;
    const series = this.#lines.map((line) => ({
      lineStyle: this.#lineStyle(line),
      ...(line.points ? { data: this.#dataOf(line) } : {}),
    }));
    this.#chart.setOption({ xAxis: this.#viewAxis({}), dataZoom: [this.#viewRange()], series });
    this.#showMeanNote();
  }

  #showMeanNote() {
    this.#meanNote.hidden = !this.#lines.some(({ role }) => role === "means") || !this.#group.showsMeans;
  }

  #xOf(time) {
    const [from, to] = this.#group.view;
    return voltlap.TimeChart.left + ((time - from) / (to - from)) * this.width;
  }

  /** Place on the axis under a horizontal position of the window, kept inside the view. */
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
    const own = index === null || !this.#spec.family ? index : voltlap.indexAt(this.#frame.layers[0].x, time);
    this.#outputs.forEach((output, i) => {
      output.textContent = index === null ? "" : this.#valueText(this.#spec.series[i], own);
    });
    this.#line.style.cssText = visible ? this.#column(this.#xOf(time), 1) : "";
    if (visible && withTip) this.#showTip(index);
    else this.#hideTip();
  }

  #hideTip() {
    this.#tip.style.display = "none";
    this.#emphasise(null);
  }

  #valueText(series, index) {
    if (series.textAt) return series.textAt(this.#group.cursor);
    const { x, breaks } = this.#frame.layers[0];
    if (breaks?.includes(index + 1) && this.#group.cursor > x[index]) return "not recorded";
    const number = voltlap.quantity(series.values[index], this.#spec.digits, this.#spec.unit);
    return series.remark ? `${number}${series.remark(index)}` : number;
  }

  /** The value of each curve at the cursor, highest first; of many only the highest and the lowest. */
  #tipOfLayers(row) {
    const { layers } = this.#frame;
    const place = this.#group.cursor;
    for (const series of this.#signals) {
      const values = voltlap.layerValues(layers, series, place);
      const few = values.length <= voltlap.TimeChart.#tipRows;
      const shown = few ? values : [values[0], values[values.length - 1]];
      if (this.#signals.length > 1) this.#tip.append(voltlap.element("div", { class: "when" }, series.name));
      for (const { layer, value } of shown) {
        row({ paint: layer.color }, layer.name, voltlap.quantity(value, this.#spec.digits, this.#spec.unit));
      }
      if (!few) this.#tip.append(voltlap.element("div", { class: "when" }, `${values.length - 2} between`));
    }
  }

  /** The curve under the pointer, the highest and the lowest. */
  #tipOfFamily(row) {
    const { family, digits, unit } = this.#spec;
    const curves = family.at(this.#frame, this.#group.cursor);
    if (!curves.length) return;
    const show = (curve) => row({ paint: curve.color }, curve.name, voltlap.quantity(curve.value, digits, unit));
    if (this.#pointerY !== null) {
      const y = this.#pointerY - this.#plot.getBoundingClientRect().top;
      const value = this.#chart.convertFromPixel({ yAxisIndex: 0 }, y);
      const nearest = voltlap.CurveFamily.nearest(curves, value);
      show(nearest);
      this.#emphasise(nearest);
    }
    this.#tip.append(voltlap.element("div", { class: "when" }, "highest and lowest"));
    show(curves[0]);
    if (curves.length > 1) show(curves[curves.length - 1]);
  }

  /** Draws one curve of the family broad; null: none. */
  #emphasise(curve) {
    if (!this.#showsFamily || curve?.name === this.#emphasised) return;
    this.#emphasised = curve?.name;
    const data = curve ? voltlap.withExtreme(curve.layer.x, curve.values) : [];
    const series = [{ name: "emphasis", data, lineStyle: { color: curve?.color } }];
    this.#chart.setOption({ series }, { lazyUpdate: true });
  }

  #showTip(index) {
    const { element } = voltlap;
    const x = this.#xOf(this.#group.cursor);
    this.#tip.replaceChildren(element("div", { class: "when" }, this.#group.listener.when(index, this.#group.cursor)));
    const row = (key, name, value) =>
      this.#tip.append(element("div", {}, voltlap.TimeChart.#key(key), `${name} `, element("b", {}, value)));
    if (this.#showsFamily) this.#tipOfFamily(row);
    else if (this.#overlaid) this.#tipOfLayers(row);
    else for (const series of this.#spec.series) row(series, series.name, this.#valueText(series, index));
    this.#tip.style.display = "block";
    const width = this.#tip.offsetWidth;
    const room = this.#plot.clientWidth;
    const left = x + 14 + width < room ? x + 14 : Math.max(0, x - 14 - width);
    this.#tip.style.transform = `translateX(${left}px)`;
  }
};

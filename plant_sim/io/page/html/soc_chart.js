// SPDX-License-Identifier: Apache-2.0
// A chart over something other than time: curves with error bars, or columns.
"use strict";

voltlap.SocChart = class {
  #spec;
  #chart;

  /**
   * @param root element that the chart is put into
   * @param spec {id, title, note, x: {name, low, high}, y: {name, unit, digits, low}, curves}; a curve is {name, color,
   *             pale, step, whole, points: [[x, y, low, high], ...]}, low and high null for no bar
   */
  constructor(root, spec) {
    const { element } = voltlap;
    this.#spec = spec;
    const legend = element("ul", { class: "legend" });
    for (const curve of spec.curves.filter(({ pale }) => !pale)) {
      const key = element("span", { class: "key", style: `--key: var(--${curve.color})` });
      legend.append(element("li", {}, key, curve.name));
    }
    const canvas = element("div", { class: "canvas", id: spec.id, role: "img", "aria-label": spec.title });
    root.append(
      element(
        "section",
        { class: "card" },
        element("header", {}, element("h3", {}, spec.title), legend),
        element("div", { class: "plot tall" }, canvas),
        ...(spec.note ? [element("p", { class: "note" }, spec.note)] : []),
      ),
    );
    this.#chart = echarts.init(canvas, null, { renderer: "canvas" });
    this.draw();
    let width = canvas.clientWidth;
    new ResizeObserver(() => {
      if (canvas.clientWidth === width) return;
      width = canvas.clientWidth;
      this.#chart.resize();
    }).observe(canvas);
  }

  draw() {
    const { color, font, quantity, sensible } = voltlap;
    const { x, y, curves } = this.#spec;
    const text = { color: color("muted"), fontFamily: font(), fontSize: 11.5 };
    const axis = (more) => ({
      type: "value",
      scale: true,
      nameLocation: "middle",
      nameTextStyle: text,
      axisLabel: { ...text, hideOverlap: true },
      axisLine: { lineStyle: { color: color("line") }, onZero: false },
      splitLine: { lineStyle: { color: color("grid") } },
      ...more,
    });
    this.#chart.setOption(
      {
        animation: false,
        textStyle: text,
        grid: { left: 62, right: 16, top: 18, bottom: 38 },
        tooltip: {
          trigger: "axis",
          confine: true,
          backgroundColor: color("surface"),
          borderColor: color("line"),
          textStyle: { ...text, color: color("text"), fontSize: 12.5 },
          formatter: (items) =>
            [
              `${x.name} ${sensible(items[0].value[0], 3)}`,
              ...items
                .filter(({ seriesType }) => seriesType === "line")
                .map(({ seriesName, value }) => {
                  const between = value[2] == null ? "" : ` (${sensible(value[2], 4)} to ${sensible(value[3], 4)})`;
                  return `${seriesName} <b>${quantity(value[1], y.digits, y.unit)}</b>${between}`;
                }),
            ].join("<br>"),
        },
        xAxis: axis({ name: x.name, nameGap: 22, min: x.low, max: x.high, splitLine: { show: false } }),
        yAxis: axis({ name: `${y.name}, ${y.unit}`, nameGap: 46, nameRotate: 90, min: y.low, splitNumber: 4 }),
        series: curves.flatMap((curve) => this.#series(curve)),
      },
      { notMerge: true },
    );
  }

  #series(curve) {
    const { color } = voltlap;
    const line = {
      type: "line",
      name: curve.name,
      data: curve.points,
      step: curve.step ? "middle" : false,
      showSymbol: !curve.step && !curve.pale && curve.points.length < 60,
      symbolSize: 5,
      animation: false,
      silent: true,
      z: curve.pale ? 2 : 4,
      itemStyle: { color: color(curve.color) },
      lineStyle: { color: color(curve.color), width: curve.pale ? 1 : 1.8, opacity: curve.pale ? 0.45 : 1 },
      areaStyle: curve.step ? { color: color(curve.color), opacity: 0.25 } : undefined,
    };
    const barred = curve.points.filter((point) => point[2] != null);
    if (curve.pale || barred.length === 0) return [line];
    return [line, this.#bars(curve, barred)];
  }

  /** Intervals; what goes beyond the axis ends at its edge, unless the curve's are to be seen whole. */
  #bars(curve, points) {
    return {
      type: "custom",
      name: `${curve.name}, interval`,
      data: points,
      dimensions: ["x", "y", "low", "high"],
      encode: { x: 0, y: curve.whole ? [1, 2, 3] : 1 },
      silent: true,
      clip: true,
      animation: false,
      z: 3,
      renderItem: (params, api) => {
        const [px, low] = api.coord([api.value(0), api.value(2)]);
        const high = api.coord([api.value(0), api.value(3)])[1];
        const { y, height } = params.coordSys;
        const inside = (at) => Math.min(Math.max(at, y), y + height);
        const style = { stroke: voltlap.color(curve.color), lineWidth: 1.2, opacity: 0.75 };
        const stroke = (x1, y1, x2, y2) => ({ type: "line", shape: { x1, y1, x2, y2 }, style });
        return {
          type: "group",
          children: [
            stroke(px, inside(low), px, inside(high)),
            stroke(px - 3, inside(low), px + 3, inside(low)),
            stroke(px - 3, inside(high), px + 3, inside(high)),
          ],
        };
      },
    };
  }
};

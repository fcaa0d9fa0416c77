// SPDX-License-Identifier: Apache-2.0
// The course in the plane, coloured by the mean speed of what the charts show, with the car at the cursor.
"use strict";

voltlap.TrackMap = class {
  /** Viridis, dark end lifted and bright end cut so that both stand out from a white and a black page. */
  static scale = ["#54409a", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b"];

  #course;
  #position;
  #speed;
  #chart;
  #plot;
  #car;
  #subtitle;
  #x = [];
  #y = [];
  #mean = [];
  #low;
  #high;

  /**
   * @param card     element to fill
   * @param course   {name, length_m, distance_m, x_m, y_m}
   * @param position Float64Array, metres since the start of the lap, for each sample
   * @param speed    Float64Array, m/s
   */
  constructor({ card, course, position, speed }) {
    this.#course = course;
    this.#position = position;
    this.#speed = speed;
    const sorted = speed.slice().sort(); // the slow start does not stretch the colours
    this.#low = sorted[Math.floor(0.02 * sorted.length)];
    this.#high = Math.max(sorted[sorted.length - 1], this.#low + 0.1);
    this.#build(card);
    this.#chart = echarts.init(this.#plot.querySelector(".canvas"), null, { renderer: "canvas" });
    new ResizeObserver(() => {
      this.#chart.resize();
      this.draw();
    }).observe(this.#plot);
  }

  #build(card) {
    const { element } = voltlap;
    const course = this.#course;
    const last = course.x_m.length - 1;
    const gap = Math.hypot(course.x_m[last] - course.x_m[0], course.y_m[last] - course.y_m[0]);
    const open = gap > 0.01 * course.length_m;
    this.#subtitle = element("p", { class: "note", role: "status" });
    this.#car = element("div", { class: "car" });
    this.#plot = element(
      "div",
      { class: "map-plot", role: "img", "aria-label": `Course ${course.name}, coloured by speed` },
      element("div", { class: "canvas", id: "chart-track" }),
      this.#car,
    );
    const bar = element("i", { style: `background: linear-gradient(90deg, ${voltlap.TrackMap.scale.join(",")})` });
    const scale = element(
      "div",
      { class: "scale" },
      `${this.#low.toFixed(1)} m/s`,
      bar,
      `${this.#high.toFixed(1)} m/s`,
    );
    const caption =
      `Drawn from the straights and turns of the course as listed, ${course.length_m.toFixed(0)} m, ` +
      "and turned to fit; nothing else was adjusted." +
      (open ? ` The list does not close: its end lies ${gap.toFixed(0)} m from its start. A lap joins the two.` : "");
    card.append(
      element("header", {}, element("h3", {}, "Speed on the course")),
      this.#subtitle,
      this.#plot,
      scale,
      element("p", { class: "note" }, caption),
    );
  }

  /** Mean speed over each piece of the course, of the samples first..last; `words` say what they are. */
  show(first, last, words) {
    const pieces = this.#course.distance_m.length - 1;
    const sum = new Float64Array(pieces);
    const count = new Uint32Array(pieces);
    for (let i = first; i <= last; i += 1) {
      const piece = Math.min(voltlap.indexAt(this.#course.distance_m, this.#position[i]), pieces - 1);
      sum[piece] += this.#speed[i];
      count[piece] += 1;
    }
    this.#mean = Array.from(sum, (total, i) => (count[i] ? total / count[i] : null));
    this.#fillGaps();
    this.#subtitle.textContent = words;
    this.draw();
  }

  /** A fast car passes short pieces between two samples: they take the speed of the piece before. */
  #fillGaps() {
    const longest = 4;
    const mean = this.#mean;
    for (let i = 1, gap = 0; i < mean.length; i += 1) {
      gap = mean[i] === null ? gap + 1 : 0;
      if (mean[i] !== null || gap > longest || !mean.slice(i, i + longest).some((value) => value !== null)) continue;
      mean[i] = mean[i - 1];
    }
  }

  showCar(index) {
    if (index === null || !this.#x.length) {
      this.#car.style.display = "none";
      return;
    }
    const course = this.#course;
    const piece = Math.min(voltlap.indexAt(course.distance_m, this.#position[index]), this.#x.length - 2);
    const length = course.distance_m[piece + 1] - course.distance_m[piece];
    const part = Math.min(Math.max((this.#position[index] - course.distance_m[piece]) / length, 0), 1);
    const at = (values) => values[piece] + part * (values[piece + 1] - values[piece]);
    const [x, y] = this.#chart.convertToPixel({ xAxisIndex: 0, yAxisIndex: 0 }, [at(this.#x), at(this.#y)]);
    this.#car.style.cssText = `display:block;transform:translate(${x}px,${y}px)`;
  }

  /** Turns the course so that it lies along the longer side of the plot. No mirror: right turns stay right. */
  #turn(tall) {
    const { x_m: xs, y_m: ys } = this.#course;
    const n = xs.length;
    const mean = (values) => values.reduce((total, value) => total + value, 0) / n;
    const mx = mean(xs);
    const my = mean(ys);
    let xx = 0,
      yy = 0,
      xy = 0;
    for (let i = 0; i < n; i += 1) {
      xx += (xs[i] - mx) ** 2;
      yy += (ys[i] - my) ** 2;
      xy += (xs[i] - mx) * (ys[i] - my);
    }
    const angle = 0.5 * Math.atan2(2 * xy, xx - yy) - (tall ? Math.PI / 2 : 0);
    const c = Math.cos(angle);
    const s = Math.sin(angle);
    this.#x = xs.map((x, i) => (x - mx) * c + (ys[i] - my) * s);
    this.#y = xs.map((x, i) => -(x - mx) * s + (ys[i] - my) * c);
  }

  /** Axis ranges with the same metres a pixel both ways. */
  #ranges(width, height) {
    const range = (values) => [Math.min(...values), Math.max(...values)];
    const [x0, x1] = range(this.#x);
    const [y0, y1] = range(this.#y);
    const metres = Math.max((x1 - x0) / width, (y1 - y0) / height, 1e-6);
    const around = (a, b, pixels) => [(a + b - metres * pixels) / 2, (a + b + metres * pixels) / 2];
    return { x: around(x0, x1, width), y: around(y0, y1, height) };
  }

  static color(part) {
    const scale = voltlap.TrackMap.scale;
    const at = Math.min(Math.max(part, 0), 1) * (scale.length - 1);
    const i = Math.min(Math.floor(at), scale.length - 2);
    const rest = at - i;
    const channel = (hex, k) => parseInt(hex.slice(1 + 2 * k, 3 + 2 * k), 16);
    const mixed = [0, 1, 2].map((k) => channel(scale[i], k) * (1 - rest) + channel(scale[i + 1], k) * rest);
    return `rgb(${mixed.map(Math.round).join(",")})`;
  }

  draw() {
    const width = this.#plot.clientWidth;
    const height = this.#plot.clientHeight;
    const margin = 14;
    if (width <= 2 * margin || height <= 2 * margin) return;
    this.#turn(height > width);
    const ranges = this.#ranges(width - 2 * margin, height - 2 * margin);
    const { color } = voltlap;
    const pieces = this.#mean.map((value, i) => [this.#x[i], this.#y[i], this.#x[i + 1], this.#y[i + 1], value]);
    this.#chart.setOption(
      {
        animation: false,
        grid: { left: margin, right: margin, top: margin, bottom: margin },
        xAxis: { type: "value", show: false, min: ranges.x[0], max: ranges.x[1] },
        yAxis: { type: "value", show: false, min: ranges.y[0], max: ranges.y[1] },
        tooltip: {
          backgroundColor: color("surface"),
          borderColor: color("line"),
          textStyle: { color: color("text"), fontSize: 12.5, fontFamily: voltlap.font() },
          formatter: ({ dataIndex }) => this.#tip(dataIndex),
          confine: true,
        },
        series: [this.#line(pieces), this.#start()],
      },
      { notMerge: true },
    );
  }

  #tip(piece) {
    const { distance_m } = this.#course;
    const value = this.#mean[piece];
    const where = `${distance_m[piece].toFixed(0)} to ${distance_m[piece + 1].toFixed(0)} m`;
    return value === null
      ? `${where}: not driven in this stretch`
      : `${where}: <b>${voltlap.quantity(value, 1, "m/s")}</b>`;
  }

  #line(pieces) {
    const none = voltlap.color("track");
    const span = this.#high - this.#low;
    return {
      type: "custom",
      name: "speed on the course",
      data: pieces,
      dimensions: ["x", "y", "x_end", "y_end", "speed_mps"],
      encode: { x: [0, 2], y: [1, 3] },
      renderItem: (params, api) => {
        const value = pieces[params.dataIndex][4];
        const [x1, y1] = api.coord([api.value(0), api.value(1)]);
        const [x2, y2] = api.coord([api.value(2), api.value(3)]);
        const stroke = value === null ? none : voltlap.TrackMap.color((value - this.#low) / span);
        return {
          type: "line",
          shape: { x1, y1, x2, y2 },
          style: { stroke, lineWidth: value === null ? 4 : 7, lineCap: "round" },
        };
      },
    };
  }

  /** Where a lap begins, and which way it goes. */
  #start() {
    const { color } = voltlap;
    const text = color("text");
    return {
      type: "custom",
      name: "start",
      silent: true,
      data: [[this.#x[0], this.#y[0], this.#x[1], this.#y[1]]],
      z: 3,
      renderItem: (params, api) => {
        const [x, y] = api.coord([api.value(0), api.value(1)]);
        const [x2, y2] = api.coord([api.value(2), api.value(3)]);
        const turn = Math.atan2(y2 - y, x2 - x);
        const c = Math.cos(turn);
        const s = Math.sin(turn);
        const corner = (along, across) => [x + along * c - across * s, y + along * s + across * c];
        return {
          type: "polygon",
          shape: { points: [corner(10, 0), corner(-5, 8), corner(-5, -8)] },
          style: { fill: text, stroke: color("surface"), lineWidth: 2 },
        };
      },
    };
  }
};

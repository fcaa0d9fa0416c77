// SPDX-License-Identifier: Apache-2.0
// What the reader does with a chart over time: mouse, wheel, fingers, keys. The plain wheel and a finger that moves up
// or down stay the page's own.
"use strict";

voltlap.ChartGestures = class {
  #chart;
  #group;
  #surface;
  #pointers = new Map();
  #drag = null;

  constructor(chart, group, surface) {
    this.#chart = chart;
    this.#group = group;
    this.#surface = surface;
    this.#listen();
  }

  #listen() {
    const surface = this.#surface;
    const group = this.#group;
    surface.addEventListener("pointerdown", (event) => this.#down(event));
    surface.addEventListener("pointermove", (event) => this.#moved(event));
    surface.addEventListener("pointerup", (event) => this.#up(event));
    surface.addEventListener("pointercancel", (event) => this.#up(event, true));
    surface.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse" && !this.#drag) group.setCursor(null);
    });
    surface.addEventListener("dblclick", () => group.showAll());
    surface.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey && !event.metaKey) return; // the plain wheel scrolls the page
        event.preventDefault();
        group.zoom(
          Math.exp(Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY) / 300, 0.5)),
          this.#chart.timeAt(event.clientX),
        );
      },
      { passive: false },
    );
    surface.addEventListener("keydown", (event) => this.#pressed(event));
    surface.addEventListener("blur", () => group.setCursor(null));
  }

  #down(event) {
    this.#pointers.set(event.pointerId, event.clientX);
    if (event.pointerType === "mouse" && event.button !== 0) return;
    this.#surface.setPointerCapture(event.pointerId);
    if (event.pointerType === "mouse") this.#drag = { x: event.clientX, pan: event.shiftKey, view: this.#group.view };
  }

  #moved(event) {
    if (this.#pointers.size === 2 && this.#pointers.has(event.pointerId)) {
      this.#pinch(event);
    } else if (this.#drag?.pan) {
      const [from, to] = this.#drag.view;
      const shift = ((this.#drag.x - event.clientX) / this.#chart.width) * (to - from);
      const start = Math.min(Math.max(from + shift, this.#group.begin), this.#group.end - (to - from));
      this.#group.show(start, start + to - from);
    } else {
      if (this.#drag) this.#chart.showSelection(this.#drag.x, event.clientX);
      this.#group.setCursor(this.#chart.timeAt(event.clientX), this.#chart);
    }
  }

  /** Two fingers keep the times that they lie on. */
  #pinch(event) {
    const other = [...this.#pointers].find(([id]) => id !== event.pointerId)[1];
    const before = this.#pointers.get(event.pointerId);
    this.#pointers.set(event.pointerId, event.clientX);
    const apart = Math.abs(event.clientX - other);
    const was = Math.abs(before - other);
    if (apart > 8 && was > 8) this.#group.zoom(was / apart, this.#chart.timeAt(other));
  }

  #up(event, cancelled = false) {
    this.#pointers.delete(event.pointerId);
    const drag = this.#drag;
    this.#drag = null;
    this.#chart.hideSelection();
    if (event.pointerType !== "mouse" && !cancelled)
      this.#group.setCursor(this.#chart.timeAt(event.clientX), this.#chart);
    if (cancelled || !drag || drag.pan || Math.abs(event.clientX - drag.x) < 5) return;
    const times = [this.#chart.timeAt(drag.x), this.#chart.timeAt(event.clientX)].sort((a, b) => a - b);
    this.#group.show(times[0], times[1]);
  }

  #pressed(event) {
    const group = this.#group;
    const [from, to] = group.view;
    const centre = group.cursor ?? (from + to) / 2;
    const step = event.shiftKey ? 10 : 1;
    const actions = {
      ArrowLeft: () => group.stepCursor(-step, this.#chart),
      ArrowRight: () => group.stepCursor(step, this.#chart),
      Home: () => group.setCursor(from, this.#chart),
      End: () => group.setCursor(to, this.#chart),
      "+": () => group.zoom(0.7, centre),
      "=": () => group.zoom(0.7, centre),
      "-": () => group.zoom(1 / 0.7, centre),
      PageUp: () => group.listener.stepLap(-1),
      PageDown: () => group.listener.stepLap(1),
      Escape: () => group.showAll(),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }
};

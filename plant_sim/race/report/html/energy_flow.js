// SPDX-License-Identifier: Apache-2.0
// The energy ledger as a flow from the cells to where it ended. Every flow is a ledger term or a sum of some.
"use strict";

voltlap.EnergyFlow = class {
  /**
   * What each stage hands on: to the leaves, sums of ledger terms, and to the next stage. What a part stores stands
   * with its losses, so that no sum turns negative when it gives a little back.
   */
  static stages = [
    {
      name: "cells",
      leaves: { "cells, R0": ["battery_r0_heat"], "cells, RC branches": ["battery_rc_heat", "battery_rc_stored"] },
    },
    {
      name: "pack",
      leaves: {
        "contactors, cables": ["contactor_heat"],
        "DC link": ["bleed_heat", "dc_link_stored"],
        "low voltage": ["low_voltage"],
      },
    },
    {
      name: "inverter",
      leaves: {
        "inverter heat": ["inverter_heat"],
        "motor heat": ["motor_heat"],
        "driveline heat": ["driveline_heat"],
      },
    },
    {
      name: "wheels",
      leaves: {
        "front brakes": ["brake_front"],
        "rear brakes": ["brake_rear"],
        "rolling drag": ["rolling"],
        "air drag": ["aero"],
        "tyre slip": ["tyre_slip"],
        cornering: ["cornering"],
        climbing: ["climb"],
        "left in motion": ["kinetic"],
      },
    },
  ];
  static small = 0.004;

  #terms;
  #chart;
  #box;
  #labels = voltlap.element("div", { class: "flow-labels", "aria-hidden": "true" });

  constructor({ box, terms }) {
    this.#box = box;
    this.#terms = terms;
    this.#chart = echarts.init(box, null, { renderer: "canvas" });
    box.append(this.#labels);
    new ResizeObserver(() => {
      this.#chart.resize();
      this.draw();
    }).observe(box);
  }

  #sum(terms) {
    return terms.reduce((total, term) => total + this.#terms[term], 0);
  }

  /** Leaves of a stage, with the small ones of the stage as one. */
  #leaves({ name, leaves }) {
    const all = Object.entries(leaves)
      .map(([leaf, terms]) => ({ name: leaf, value: this.#sum(terms) }))
      .filter(({ value }) => value !== 0);
    const isSmall = ({ value }) => Math.abs(value) < voltlap.EnergyFlow.small * this.#terms.battery_chemical;
    const small = all.filter(isSmall);
    if (small.length < 2) return all;
    return [
      ...all.filter((leaf) => !isSmall(leaf)),
      { name: `rest at the ${name}`, value: small.reduce((total, { value }) => total + value, 0) },
    ];
  }

  /** A leaf below zero gave energy back: its flow runs the other way, so that every width is a real amount. */
  #graph() {
    const { stages } = voltlap.EnergyFlow;
    const nodes = [];
    const links = [];
    const through = stages.map((_, i) =>
      this.#sum(stages.slice(i).flatMap(({ leaves }) => Object.values(leaves).flat())),
    );
    stages.forEach((stage, i) => {
      nodes.push({ name: stage.name, amount: through[i], stage: true });
      for (const { name, value } of this.#leaves(stage)) {
        nodes.push({ name, amount: value });
        links.push(
          value > 0 ? { source: stage.name, target: name, value } : { source: name, target: stage.name, value: -value },
        );
      }
      if (i + 1 < stages.length && through[i + 1] > 0)
        links.push({ source: stage.name, target: stages[i + 1].name, value: through[i + 1] });
    });
    // Leaves of the last stage come first: the main flow stays at the top and the losses leave it downwards. Stages
    // come before all leaves: one that gives back begins on the left, below the cells.
    nodes.reverse();
    const joined = nodes.filter(({ name }) => links.some((link) => link.source === name || link.target === name));
    return { nodes: [...joined.filter(({ stage }) => stage), ...joined.filter(({ stage }) => !stage)], links };
  }

  draw() {
    if (this.#box.clientWidth === 0) return;
    const { color, quantity } = voltlap;
    const { nodes, links } = this.#graph();
    const source = this.#terms.battery_chemical;
    const narrow = this.#box.clientWidth < 520;
    const text = { color: color("text"), fontFamily: voltlap.font(), fontSize: 12.5 };
    this.#labels.classList.toggle("narrow", narrow);
    const amount = (value, digits) => `${quantity(value, digits, "kWh")}, ${((100 * value) / source).toFixed(1)} %`;
    this.#chart.setOption(
      {
        animation: false,
        tooltip: {
          confine: true,
          backgroundColor: color("surface"),
          borderColor: color("line"),
          textStyle: text,
          formatter: ({ dataType, data, name }) =>
            dataType === "edge"
              ? `${data.source} → ${data.target}: <b>${amount(data.value, 4)}</b>`
              : `${name}: <b>${amount(data.amount, 4)}</b>`,
        },
        series: [
          {
            type: "sankey",
            left: 8,
            right: narrow ? 116 : 252,
            top: 42,
            bottom: 8,
            nodeWidth: 10,
            nodeGap: narrow ? 27 : 16,
            nodeAlign: "justify",
            draggable: false,
            layoutIterations: 0,
            emphasis: { focus: "adjacency" },
            lineStyle: { color: "source", opacity: 0.25, curveness: 0.5 },
            label: { show: false },
            data: nodes.map((node) => ({
              ...node,
              itemStyle: { color: color(node.stage ? "blue" : "orange"), borderWidth: 0 },
            })),
            links,
          },
        ],
      },
      { notMerge: true },
    );
    this.#label((node) => {
      if (node.stage) return [node.name, narrow ? node.amount.toFixed(2) : quantity(node.amount, 3, "kWh")];
      return narrow ? [node.name, quantity(node.amount, 3, "kWh")] : [`${node.name}  ${amount(node.amount, 3)}`];
    });
  }

  /** Name and amount at each node: of a stage above it, of a leaf beside it; moved where two would overlap. */
  #label(linesOf) {
    const series = this.#chart.getModel().getSeriesByIndex(0);
    const { x: left, y: top } = series.layoutInfo;
    const labels = series.getGraph().nodes.map((graphNode) => {
      const node = series.getRawData().getRawDataItem(graphNode.dataIndex);
      const { x, y, dx, dy } = graphNode.getLayout();
      const lines = linesOf(node).map((line) => voltlap.element("span", {}, line));
      const part = voltlap.element("div", { class: "flow-label", "data-name": node.name }, ...lines);
      return { node, part, box: { x: left + x, y: top + y, width: dx, height: dy } };
    });
    this.#labels.replaceChildren(...labels.map(({ part }) => part));
    const placed = voltlap.EnergyFlow.#places(
      labels.map(({ node, part, box }) => {
        const { offsetWidth: width, offsetHeight: height } = part;
        return node.stage
          ? { x: box.x - 5, y: box.y - height - 3, width, height }
          : { x: box.x + box.width + 5, y: box.y + (box.height - height) / 2, width, height };
      }),
      { width: this.#box.clientWidth, height: this.#box.clientHeight },
    );
    placed.forEach(({ x, y }, i) => (labels[i].part.style.transform = `translate(${x}px, ${y}px)`));
    this.#lead(labels, placed);
  }

  /**
   * Boxes {x, y, width, height} near where they want to be, inside `room`, none over another: those that want to be
   * higher choose first, each takes the nearest free place, up or down.
   */
  static #places(wanted, room) {
    const gap = 1;
    const placed = [];
    const beside = (a, b) => a.x >= b.x + b.width + gap || b.x >= a.x + a.width + gap;
    const above = (a, b) => a.y + a.height + gap <= b.y;
    const over = (a, b) => !beside(a, b) && !above(a, b) && !above(b, a);
    const order = wanted.map((unused, i) => i).sort((a, b) => wanted[a].y - wanted[b].y);
    for (const i of order) {
      const { width, height } = wanted[i];
      const inside = (y) => Math.max(0, Math.min(y, room.height - height));
      const x = Math.max(0, Math.min(wanted[i].x, room.width - width));
      const at = (y) => ({ x, y: inside(y), width, height });
      const others = placed.filter(Boolean);
      const candidates = [wanted[i].y, ...others.flatMap((b) => [b.y + b.height + gap, b.y - height - gap])].map(at);
      const free = candidates.filter((one) => !others.some((other) => over(one, other)));
      const far = (one) => Math.abs(one.y - wanted[i].y);
      placed[i] = free.reduce((best, one) => (far(one) < far(best) ? one : best), free[0] ?? at(wanted[i].y));
    }
    return placed;
  }

  /** Thin lines from the nodes to the labels that had to move away. */
  #lead(labels, placed) {
    const style = { stroke: voltlap.color("muted"), lineWidth: 1, opacity: 0.7 };
    const lines = labels.flatMap(({ node, box }, i) => {
      const from = box.y + box.height / 2;
      const to = placed[i].y + placed[i].height / 2;
      if (node.stage || Math.abs(from - to) < placed[i].height / 2) return [];
      const shape = { x1: box.x + box.width, y1: from, x2: placed[i].x - 1, y2: to };
      return [{ type: "line", shape, style, silent: true, z: 5 }];
    });
    this.#chart.setOption({ graphic: lines });
  }
};

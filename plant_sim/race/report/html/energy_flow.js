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
    { name: "inverter", leaves: { inverter: ["inverter_heat"], motor: ["motor_heat"], driveline: ["driveline_heat"] } },
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

  constructor({ box, terms }) {
    this.#box = box;
    this.#terms = terms;
    this.#chart = echarts.init(box, null, { renderer: "canvas" });
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
    // Leaves of the last stage come first: the main flow stays at the top and the losses leave it downwards.
    nodes.reverse();
    return {
      nodes: nodes.filter(({ name }) => links.some((link) => link.source === name || link.target === name)),
      links,
    };
  }

  draw() {
    if (this.#box.clientWidth === 0) return;
    const { color, quantity } = voltlap;
    const { nodes, links } = this.#graph();
    const source = this.#terms.battery_chemical;
    const narrow = this.#box.clientWidth < 520;
    const text = { color: color("text"), fontFamily: voltlap.font(), fontSize: narrow ? 10.5 : 12.5 };
    const amount = (value, digits) => `${quantity(value, digits, "kWh")}, ${((100 * value) / source).toFixed(1)} %`;
    const label = { ...text, textBorderColor: color("surface"), textBorderWidth: 3, lineHeight: narrow ? 13 : 15 };
    this.#chart.setOption(
      {
        animation: false,
        tooltip: {
          confine: true,
          backgroundColor: color("surface"),
          borderColor: color("line"),
          textStyle: { ...text, fontSize: 12.5 },
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
            data: nodes.map((node) => ({
              ...node,
              itemStyle: { color: color(node.stage ? "blue" : "orange"), borderWidth: 0 },
              label: node.stage
                ? {
                    ...label,
                    position: "top",
                    align: "left",
                    offset: [-5, 0],
                    formatter: `${node.name}\n${narrow ? node.amount.toFixed(2) : quantity(node.amount, 3, "kWh")}`,
                  }
                : {
                    ...label,
                    position: "right",
                    formatter: narrow
                      ? `${node.name}\n${quantity(node.amount, 3, "kWh")}`
                      : `${node.name}  ${amount(node.amount, 3)}`,
                  },
            })),
            links,
          },
        ],
      },
      { notMerge: true },
    );
  }
};

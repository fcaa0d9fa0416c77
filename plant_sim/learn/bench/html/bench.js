// SPDX-License-Identifier: Apache-2.0
// The report of a battery test campaign: one test at a time in charts that share stretch and cursor.
"use strict";

(() => {
  const { data, clock, element, tellReady } = voltlap,
    $ = (id) => document.getElementById(id);
  const colors = ["blue", "orange", "green", "purple", "grey"];

  /** Samples of a test by column name, read when it is shown. */
  const read = (test) =>
    Object.fromEntries(
      Object.entries(test.columns).map(([name, packed]) => [name, voltlap.decode(packed, test.samples)]),
    );

  const perCell = (test, column, quantity) =>
    Array.from({ length: test.cells }, (_, i) => ({
      name: data.rehearsal ? "nominal cell" : `cell ${i + 1}`,
      color: colors[i % colors.length],
      values: column[`cell_${i + 1}_${quantity}`],
    }));

  const specs = (test, column) => [
    {
      id: "chart-voltage",
      title: "Cell voltage",
      axis: "voltage",
      unit: "V",
      digits: 4,
      series: perCell(test, column, "voltage_v"),
    },
    {
      id: "chart-current",
      title: "Current",
      axis: "current",
      unit: "A",
      digits: 1,
      series: [{ name: "discharge positive", color: "blue", values: column.current_a }],
    },
    {
      id: "chart-temperature",
      title: "Temperature",
      axis: "temperature",
      unit: "°C",
      digits: 1,
      series: [
        { name: "air in the box", color: "grey", role: "reference", values: column.ambient_c },
        ...perCell(test, column, "temperature_c"),
      ],
    },
  ];

  let charts = null;

  const showRests = (test) => {
    $("rests").tBodies[0].replaceChildren(
      ...test.rests.map(([end_s, soc, length_s, rise], i) => {
        const button = element("button", { type: "button", title: "Show this rest in the charts" }, `${i + 1}`);
        button.addEventListener("click", () => {
          charts.show(end_s - length_s - 60, end_s);
          $("telemetry").scrollIntoView();
        });
        const cells = [(100 * soc).toFixed(1), (length_s / 60).toFixed(1), (1000 * rise).toFixed(2).replace("-", "−")];
        return element(
          "tr",
          {},
          element("th", { scope: "row" }, button),
          ...cells.map((text) => element("td", {}, text)),
        );
      }),
    );
  };

  const show = (test) => {
    const column = read(test);
    const times = column.time_s;
    $("strips").replaceChildren();
    charts = new voltlap.TimeCharts({
      root: $("strips"),
      times,
      end_s: test.end_s,
      laps: [],
      window_s: null,
      specs: specs(test, column),
      describedBy: "hint",
      listener: {
        view: (from, to) => {
          $("view").textContent = `${clock(from)} to ${clock(to)}`;
          $("whole").disabled = from <= 0 && to >= test.end_s;
        },
        cursor: (i) => {
          $("cursor").textContent = i === null ? "" : clock(times[i]);
        },
        when: (i) => clock(times[i]),
        stepLap: () => {},
      },
    });
    showRests(test);
  };

  const draw = () => {
    if (data.tests.length > 0) {
      $("telemetry").hidden = false;
      $("test").append(...data.tests.map((test, i) => new Option(test.name, i)));
      $("test").addEventListener("change", () => show(data.tests[Number($("test").value)]));
      $("whole").addEventListener("click", () => charts.showAll());
      show(data.tests[0]);
      voltlap.onThemeChange(() => charts.redraw());
    }
    voltlap.searchable($("search"), $("parameters"), $("found"));
    tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

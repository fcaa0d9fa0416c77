// SPDX-License-Identifier: Apache-2.0
// The report of an explanation: errors over time before and after, and against current, SOC, temperature and speed.
"use strict";

(() => {
  const { data, clock, tellReady } = voltlap,
    $ = (id) => document.getElementById(id);
  const read = (packed) => voltlap.decode(packed, data.samples);

  /** Before in orange, after in blue on top; one curve where nothing changes. */
  const curves = (channel, before, after) =>
    channel.changed
      ? [
          { name: "with what was found", color: "blue", ...after },
          { name: "as the model was given", color: "orange", ...before },
        ]
      : [{ name: "log minus simulation", color: "blue", ...before }];

  /** A few rows far beyond all others would leave the rest a line. */
  const cutOff = ({ ends, unit }) => ({
    low: -ends.most,
    high: ends.most,
    note: `a few rows go on beyond the picture, up to ${ends.largest} ${unit}`,
  });

  const errorChart = (channel, k) => ({
    id: `chart-error-${k}`,
    title: channel.title[0].toUpperCase() + channel.title.slice(1),
    axis: "error",
    unit: channel.unit,
    digits: channel.digits,
    ...(channel.ends ? cutOff(channel) : {}),
    series: curves(channel, { values: read(channel.before) }, { values: read(channel.after) }),
    level: { low: -channel.floor, high: channel.floor, color: "grey", text: "its noise" },
    bands: channel.unused.map(([from_s, to_s]) => ({ from_s, to_s, reason: 0, color: "purple" })),
    bandNames: channel.unused.length ? [{ color: "purple", text: "not used" }] : [],
  });

  const currentChart = () => ({
    id: "chart-current",
    title: "Current, discharge positive",
    axis: "current",
    unit: "A",
    digits: 1,
    series: [{ name: "recorded", color: "green", values: read(data.current_a) }],
  });

  const drawTimes = () => {
    const times = read(data.time_s);
    const soc = read(data.soc);
    const when = (i) => `${clock(times[i], 1)}, SOC ${(100 * soc[i]).toFixed(1)} %`;
    const charts = new voltlap.TimeCharts({
      root: $("strips"),
      times,
      end_s: data.end_s,
      laps: [],
      window_s: null,
      specs: [...data.channels.map(errorChart), currentChart()],
      describedBy: "hint",
      listener: {
        view: (from, to) => {
          $("view").textContent = `${clock(from)} to ${clock(to)}`;
          $("whole").disabled = from <= 0 && to >= data.end_s;
        },
        cursor: (i) => {
          $("cursor").textContent = i === null ? "" : when(i);
        },
        when,
        stepLap: () => {},
      },
    });
    $("whole").addEventListener("click", () => charts.showAll());
    voltlap.onThemeChange(() => charts.redraw());
  };

  let against = [];

  const showAgainst = (channel) => {
    $("against").replaceChildren();
    against = channel.against.map(
      ({ name, before, after }, k) =>
        new voltlap.SocChart($("against"), {
          id: `chart-against-${k}`,
          title: `Against ${name.split(",")[0]}`,
          x: { name },
          y: { name: "error", unit: channel.unit, digits: channel.digits },
          curves: curves(channel, { points: before, whole: true }, { points: after, whole: true }).reverse(),
        }),
    );
  };

  const draw = () => {
    if (data.channels.length) {
      $("telemetry").hidden = false;
      drawTimes();
      $("channel").append(...data.channels.map(({ title }, i) => new Option(title, i)));
      $("channel").addEventListener("change", () => showAgainst(data.channels[Number($("channel").value)]));
      showAgainst(data.channels[0]);
      voltlap.onThemeChange(() => against.forEach((chart) => chart.draw()));
    }
    tellReady();
  };

  // The sentence and the numbers are painted first.
  requestAnimationFrame(() => setTimeout(draw));
})();

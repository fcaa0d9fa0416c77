// SPDX-License-Identifier: Apache-2.0
// The chart of each cell's temperature, where cells differ.
"use strict";

(() => {
  const { data, quantity } = voltlap;
  const { column, times } = voltlap.endurance;
  const { columns, samples, first_s, period_s } = data.cells;
  const cellName = (i) => `cell ${i + 1}`;

  /** Times of the cells' samples, fewer than those of the other charts. */
  const cellTimes = Float64Array.from({ length: samples }, (_, i) => first_s + i * period_s);

  /** At each sample the cell with the most of `better`, and its value. */
  const envelope = (cells, better) => {
    const cell = new Uint16Array(samples);
    const values = Float64Array.from({ length: samples }, (_, k) => {
      for (let i = 1; i < cells.length; i += 1) if (better(cells[i][k], cells[cell[k]][k])) cell[k] = i;
      return cells[cell[k]][k];
    });
    return { cell, values };
  };

  const spec = () => {
    const cells = columns.map((packed) => voltlap.decode(packed, samples));
    const hottest = envelope(cells, (a, b) => a > b);
    const coldest = envelope(cells, (a, b) => a < b);
    const { time_s, value } = data.extremes.battery_temperature_c;
    const most = column.cell_hottest[voltlap.indexAt(times, time_s)] - 1;
    const least = coldest.cell[samples - 1];
    const marked = (i, at) => `${cellName(i)}, ${quantity(at, 1, "°C")}`;
    const end = coldest.values[samples - 1];
    // Its own curve has fewer samples and coarser steps: a mark beyond the axis that fits them would not be drawn.
    const top = Math.min(value, hottest.values.reduce((a, b) => Math.max(a, b)));
    const marks = {
      [least]: { time_s: cellTimes[samples - 1], value: end, text: marked(least, end), below: true, offset: [0, 9] },
      [most]: { time_s, value: top, text: marked(most, value) },
    };
    return {
      id: "chart-cells",
      title: `Temperature of each of ${cells.length} cells`,
      axis: "temperature",
      unit: "°C",
      digits: 1,
      tall: true,
      family: new voltlap.CurveFamily({
        name: cellName,
        values: cells,
        color: (i) => voltlap.TrackMap.color(cells.length > 1 ? i / (cells.length - 1) : 0),
        marks,
      }),
      series: [
        { name: "hottest", color: "orange", ...hottest, remark: (i) => `, ${cellName(hottest.cell[i])}` },
        { name: "coldest", color: "blue", ...coldest, remark: (i) => `, ${cellName(coldest.cell[i])}` },
      ],
      note: period_s > data.period_s ? `a sample every ${period_s.toFixed(1)} s` : "",
    };
  };

  voltlap.cellTemperatures = { times: cellTimes, specs: () => (data.cells_alike || !samples ? [] : [spec()]) };
})();

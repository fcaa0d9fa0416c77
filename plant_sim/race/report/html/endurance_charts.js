// SPDX-License-Identifier: Apache-2.0
// Which signals of an endurance stand in which chart of its report.
"use strict";

(() => {
  const { data, quantity } = voltlap;
  const column = Object.fromEntries(
    Object.entries(data.columns).map(([name, packed]) => [name, voltlap.decode(packed, data.samples)]),
  );
  const times = Float64Array.from({ length: data.samples }, (_, i) => data.first_s + i * data.period_s);
  const percent = (values) => values.map((value) => 100 * value);
  const kilo = (values) => values.map((value) => value / 1000);
  const least = (values) => values.reduce((low, value) => Math.min(low, value), Infinity);
  const most = (values) => values.reduce((high, value) => Math.max(high, value), -Infinity);

  /** The run's own extreme of a signal, as a marked point. */
  const extreme = (name, digits, unit, scale = 1, below = false) => {
    const { time_s, value } = data.extremes[name];
    return { time_s, value: value * scale, text: quantity(value * scale, digits, unit), below };
  };

  /** Stretches in which one and the same limit held the driver back. */
  const limitBands = () => {
    const bands = [];
    const reasons = column.limit_reason;
    for (let i = 0; i < reasons.length; i += 1) {
      if (reasons[i] === 0) continue;
      const last = bands[bands.length - 1];
      if (last && last.reason === reasons[i] && last.last === i - 1) {
        last.to_s = times[i];
        last.last = i;
      } else {
        bands.push({
          from_s: times[i] - data.period_s,
          to_s: times[i],
          reason: reasons[i],
          last: i,
          color: `limit-${reasons[i]}`,
        });
      }
    }
    return bands;
  };
  const words = (name) => name.replaceAll("_", " ");

  /** The axis follows the current; a limit far above it would press the curve flat, and stands in words instead. */
  const currentChart = () => {
    const peak = Math.max(data.extremes.pack_current_a.value, 1);
    const lowest = least(column.discharge_limit_a);
    const shown = lowest <= 1.6 * peak;
    const high = 1.15 * Math.max(peak, shown ? Math.min(most(column.discharge_limit_a), 1.6 * peak) : 0);
    const interval = [5, 10, 20, 25, 50, 100, 200, 250, 500, 1000].find((step) => high / step <= 5) ?? 2000;
    return {
      id: "chart-current",
      title: "Battery current",
      axis: "current",
      unit: "A",
      digits: 1,
      means: true,
      interval,
      low: Math.floor(Math.min(0, least(column.pack_current_a)) / interval) * interval,
      high: Math.ceil(high / interval) * interval,
      series: [
        { name: "current", color: "blue", values: column.pack_current_a, extreme: extreme("pack_current_a", 1, "A") },
        {
          name: "discharge limit",
          color: "orange",
          role: "limit",
          values: column.discharge_limit_a,
          remark: (i) => (column.limit_reason[i] ? `, ${words(data.limits[column.limit_reason[i]].name)} binds` : ""),
        },
      ],
      bands: limitBands(),
      bandNames: data.limits.flatMap(({ name, active_s }, i) =>
        i > 0 && active_s > 0 ? [{ color: `limit-${i}`, text: `${words(name)}, ${active_s.toFixed(1)} s` }] : [],
      ),
      note: shown
        ? data.limits.some(({ active_s }) => active_s > 0)
          ? ""
          : "no limit held back"
        : `limit above the scale: ${lowest.toFixed(0)} A or more`,
    };
  };

  /** The rules limit the moving mean over 500 ms; a limit that would press the curve flat stands in words instead. */
  const powerChart = () => {
    const limit = 80;
    const peak = Math.max(data.extremes.power_w.value / 1000, 1);
    const shown = peak > 0.5 * limit;
    const high = shown ? Math.max(1.15 * peak, 1.2 * limit) : 1.15 * peak;
    const interval = [1, 2, 5, 10, 20, 50].find((step) => high / step <= 6) ?? 100;
    return {
      id: "chart-power",
      title: "Power at the pack's terminals",
      means: true,
      axis: "power",
      unit: "kW",
      digits: 2,
      interval,
      low: Math.floor(Math.min(0, least(column.power_w) / 1000) / interval) * interval,
      high: Math.ceil(high / interval) * interval,
      ruler: shown ? { value: limit, text: "80 kW, Formula SAE EV.3.3" } : undefined,
      note: shown ? "" : "limit of the rules above the scale: 80 kW (EV.3.3)",
      series: [
        {
          name: "power",
          color: "blue",
          role: "pale",
          values: kilo(column.power_w),
          extreme: { ...extreme("power_w", 1, "kW", 1e-3), text: "" },
        },
        {
          name: "mean of 500 ms",
          color: "orange",
          values: kilo(column.power_mean_w),
          extreme: extreme("power_mean_w", 1, "kW", 1e-3),
        },
      ],
    };
  };

  const accelerationChart = () => ({
    id: "chart-acceleration",
    title: "Acceleration",
    means: true,
    axis: "acceleration",
    unit: "m/s²",
    digits: 2,
    series: [
      { name: "longitudinal", color: "blue", values: column.longitudinal_mps2 },
      ...(data.course ? [{ name: "lateral, right positive", color: "orange", values: column.lateral_mps2 }] : []),
    ],
  });

  /** Which cell it is, where they are not all alike. */
  const cellRemark = (numbers) => (data.cells_alike ? undefined : (i) => `, cell ${numbers[i].toFixed(0)}`);
  const coldestCell = data.cells_alike
    ? []
    : [
        {
          name: "coldest cell",
          color: "blue",
          values: column.cell_temperature_min_c,
          remark: cellRemark(column.cell_coldest),
        },
      ];

  const specs = () => [
    {
      id: "chart-speed",
      title: "Speed",
      means: true,
      axis: "speed",
      unit: "m/s",
      digits: 2,
      low: 0,
      events: data.failure === null ? [] : [{ time_s: data.end_s, text: "failed" }],
      series: [
        {
          name: "driven",
          color: "blue",
          values: column.speed_mps,
          extreme: extreme("speed_mps", 2, "m/s"),
          remark: (i) => `, ${(3.6 * column.speed_mps[i]).toFixed(1)} km/h`,
        },
        { name: "target", color: "orange", role: "reference", values: column.target_mps },
      ],
    },
    {
      id: "chart-pedals",
      title: "Pedals",
      means: true,
      axis: "pedal travel",
      unit: "%",
      digits: 1,
      low: 0,
      high: 100,
      interval: 25,
      series: [
        { name: "accelerator", color: "green", values: percent(column.accelerator) },
        { name: "brake", color: "orange", values: percent(column.brake) },
      ],
    },
    powerChart(),
    currentChart(),
    accelerationChart(),
    {
      id: "chart-pack-voltage",
      title: "Pack voltage",
      means: true,
      axis: "voltage",
      unit: "V",
      digits: 2,
      series: [
        {
          name: "at the terminals",
          color: "blue",
          values: column.pack_voltage_v,
          extreme: extreme("pack_voltage_v", 1, "V", 1, true),
        },
      ],
    },
    {
      id: "chart-cell-voltage",
      title: "Weakest cell",
      means: true,
      axis: "voltage",
      unit: "V",
      digits: 3,
      series: [
        {
          name: "lowest cell voltage",
          color: "purple",
          values: column.cell_voltage_min_v,
          extreme: extreme("cell_voltage_min_v", 3, "V", 1, true),
          remark: cellRemark(column.cell_weakest),
        },
      ],
    },
    {
      id: "chart-soc",
      title: "State of charge",
      axis: "SOC",
      unit: "%",
      digits: 2,
      series: [
        { name: "plant", color: "blue", values: percent(column.soc), extreme: extreme("soc", 1, "%", 100) },
        ...(data.bms_counts
          ? [{ name: "BMS estimate", color: "orange", role: "reference", values: percent(column.bms_soc) }]
          : []),
      ],
    },
    {
      id: "chart-temperature",
      title: "Battery and motor",
      axis: "temperature",
      unit: "°C",
      digits: 1,
      series: [
        {
          name: "hottest cell",
          color: "orange",
          values: column.battery_temperature_c,
          extreme: extreme("battery_temperature_c", 1, "°C"),
          remark: cellRemark(column.cell_hottest),
        },
        ...coldestCell,
        { name: "motor winding", color: "purple", values: column.motor_temperature_c },
      ],
      note: data.cells_alike ? "all cells alike" : "",
    },
    ...voltlap.cellTemperatures.specs(),
    {
      id: "chart-rotors",
      title: "Brake rotors",
      means: true,
      axis: "temperature",
      unit: "°C",
      digits: 1,
      series: [
        { name: "front", color: "orange", values: column.front_rotor_c },
        { name: "rear", color: "purple", values: column.rear_rotor_c },
      ],
    },
  ];

  voltlap.endurance = { column, times, specs };
})();

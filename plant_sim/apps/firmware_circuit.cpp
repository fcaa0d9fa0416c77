// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_circuit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/firmware_units.hpp"
#include "car/battery/branch_reduction.hpp"

namespace voltlap::plant {
namespace {

/// What is faster than the filter's steps follows at once, and what is slower than a day not at all.
Duration filter_time(double tau_s) {
  const double low = bms::check::kBranchTimeMin.ms(), high = bms::check::kBranchTimeMax.ms();
  const double ms = std::clamp(1e3 * tau_s, low, high);
  return Duration::from_ms(static_cast<std::int32_t>(std::lround(ms)));
}

/// The currents over which the tables are read.
struct Axis {
  double low, reference, high;
  [[nodiscard]] double span() const { return high - low; }
};

/// Straight between the ends of the axis [1e-6 of the reference per unit], no steeper than the firmware takes.
std::int32_t slope_of(double from, double to, double reference, const Axis& axis) {
  if (!(axis.span() > 0.0) || !(reference > 0.0)) return 0;
  double slope = 1e6 * (to - from) / reference / axis.span();
  for (const double away : {axis.low - axis.reference, axis.high - axis.reference}) {
    const double change = slope * away;
    const double allowed =
        std::clamp(change, 1.0 * bms::check::kPartChangeMinPpm, 1.0 * bms::check::kPartChangeMaxPpm);
    if (change != allowed) slope *= 0.999 * allowed / change;
  }
  const double most = bms::check::kPartSlopeMaxPpm;
  return static_cast<std::int32_t>(std::clamp(slope, -most, most));
}

bms::PartSlopes slopes_of(const CircuitOf<2>& low, const CircuitOf<2>& high, const CircuitOf<2>& here,
                          const Axis& axis) {
  const auto slope = [&](double from, double to, double of) { return slope_of(from, to, of, axis); };
  return {slope(low.r0_ohm, high.r0_ohm, here.r0_ohm), slope(low.r_ohm[0], high.r_ohm[0], here.r_ohm[0]),
          slope(low.r_ohm[1], high.r_ohm[1], here.r_ohm[1]), slope(low.tau_s[0], high.tau_s[0], here.tau_s[0]),
          slope(low.tau_s[1], high.tau_s[1], here.tau_s[1])};
}

/// In the middle of the charge, over the currents of the cell's tables; beyond them nothing is known.
void fill_slopes(const VehicleParameters& car, const CellTables& tables, bms::BranchTable& out) {
  constexpr double kMiddle = 0.5;
  const CellParameters& cell = car.cell;
  const auto at = [&](double c, double a) { return two_branches(tables.circuit(kMiddle, c, a), tables.branches()); };
  const auto axis = [](const std::vector<double>& points, double reference, double per_unit) {
    const double low = points.empty() ? reference : points.front(), high = points.empty() ? reference : points.back();
    return Axis{per_unit * low, per_unit * reference, per_unit * high};
  };
  const double parallel = car.battery.cells_in_parallel, here_c = cell.reference_temperature_c,
               here_a = cell.reference_current_a;
  const Axis current = axis(cell.current_breakpoints_a, here_a, parallel);
  const CircuitOf<2> here = at(here_c, here_a);
  out.per_ampere = slopes_of(at(here_c, current.low / parallel), at(here_c, current.high / parallel), here, current);
  out.current_reference = units<Current>(current.reference, 1e3);
  out.current_min = units<Current>(current.low, 1e3);
  out.current_max = units<Current>(current.high, 1e3);
}

/// Where the parts are read over the temperature: at the points of the cell's tables, and, where a law holds between
/// them, in the middle of the longest ways; where these are too many, evenly over their range.
std::vector<double> warmth_points(const CellParameters& cell) {
  constexpr double kRounding = 0.1;  // K, of the firmware's temperatures
  const std::vector<double>& own = cell.temperature_breakpoints_c;
  const double least = 0.1 * bms::check::kWarmthStepMin.raw() + kRounding, span = own.back() - own.front();
  std::vector<double> out;
  if (own.size() > bms::kMaxWarmthPoints) {
    const double parts = std::clamp(std::floor(span / least), 1.0, bms::kMaxWarmthPoints - 1.0);
    for (double k = 0.0; k <= parts && (k == 0.0 || span >= least); ++k) out.push_back(own.front() + span * k / parts);
    return out;
  }
  for (const double c : own) {
    if (out.empty() || c >= out.back() + least) out.push_back(c);
  }
  while (cell.kinetic_law && out.size() > 1 && out.size() < bms::kMaxWarmthPoints) {
    std::size_t longest = 1;
    for (std::size_t k = 2; k < out.size(); ++k) {
      if (out[k] - out[k - 1] > out[longest] - out[longest - 1]) longest = k;
    }
    const double low = out[longest - 1], high = out[longest];
    if (high - low < 2.0 * least) break;
    out.insert(out.begin() + static_cast<std::ptrdiff_t>(longest), 0.5 * (low + high));
  }
  return out;
}

/// What a part is of itself at the reference [1e-6], as far as the firmware's numbers go beside what the current makes
/// of it at most.
std::int32_t warmth_share(double value, double reference, std::int32_t per_ampere, const bms::BranchTable& table) {
  if (!(reference > 0.0)) return 1'000'000;
  namespace check = bms::check;
  const auto range = [&](Current end) { return (end - table.current_reference).raw(); };
  const auto by_current = static_cast<double>(
      check::most_by_slope(per_ampere, range(table.current_min), range(table.current_max)));
  const double most = std::floor(1e6 * static_cast<double>(check::kPartShareMaxPpm) / by_current);
  return static_cast<std::int32_t>(
      std::lround(std::clamp(1e6 * value / reference, static_cast<double>(check::kPartShareMinPpm), most)));
}

/// In the middle of the charge, under the greatest current of the tables: what a part is off by counts there most. A
/// charge transfer bends the more the colder it is, and laws of current and of temperature apart know one curve of it.
void fill_warmth(const CellParameters& cell, const CellTables& tables, bms::BranchTable& out) {
  constexpr double kMiddle = 0.5;
  const double load = cell.current_breakpoints_a.empty() ? cell.reference_current_a : cell.current_breakpoints_a.back();
  const auto at = [&](double c) {
    return two_branches(tables.circuit(kMiddle, c, load), tables.branches());
  };
  const CircuitOf<2> here = at(cell.reference_temperature_c);
  const bms::PartSlopes& by = out.per_ampere;
  std::size_t i = 0;
  for (const double c : warmth_points(cell)) {
    const CircuitOf<2> there = at(c);
    out.warmth_at[i] = celsius(c);
    out.warmth[i] = {warmth_share(there.r0_ohm, here.r0_ohm, by.series, out),
                     warmth_share(there.r_ohm[0], here.r_ohm[0], by.branch1, out),
                     warmth_share(there.r_ohm[1], here.r_ohm[1], by.branch2, out),
                     warmth_share(there.tau_s[0], here.tau_s[0], by.time1, out),
                     warmth_share(there.tau_s[1], here.tau_s[1], by.time2, out)};
    ++i;
  }
  out.warmth_count = static_cast<std::uint8_t>(i);
}

}  // namespace

void fill_branches(const VehicleParameters& car, const CellTables& tables, bms::Config& config) {
  std::vector<double> soc;
  for (int i = 0; i < config.resistance.count; ++i) soc.push_back(1e-6 * config.resistance.soc[i].raw());
  const BranchReduction reduction = reduce_branches(car.cell, soc);
  bms::BranchTable& out = config.branches;
  for (std::size_t i = 0; i < soc.size(); ++i) {
    const CircuitOf<2>& circuit = reduction.circuits[i];
    const double scale = 1e-6 * config.resistance.resistance[i].raw() / total_ohm(circuit);
    out.series[i] = units<Resistance>(scale * circuit.r0_ohm, 1e6);
    out.branch1[i] = units<Resistance>(scale * circuit.r_ohm[0], 1e6);
    out.branch2[i] = units<Resistance>(scale * circuit.r_ohm[1], 1e6);
    out.time1[i] = filter_time(circuit.tau_s[0]);
    out.time2[i] = filter_time(circuit.tau_s[1]);
  }
  fill_slopes(car, tables, out);
  fill_warmth(car.cell, tables, out);
  const double heat_capacity = car.cell.mass_kg * car.cell.heat_capacity_j_per_kg_k * car.battery.cells_in_parallel;
  config.heat_capacity_j_per_k = static_cast<std::int32_t>(std::lround(heat_capacity));
}

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// A cell that can be reckoned by hand: OCV 3 V + 1 V SOC, 10 mOhm, branches too small to see; 10 Ah.
#pragma once
#include <cmath>
#include <vector>

#include "core/parameters.hpp"
#include "io/logs/cell_log.hpp"

struct StraightCell {
  static constexpr double kCapacity = 10.0, kR0 = 0.010;
  static constexpr std::size_t kRest = 120;

  static voltlap::plant::CellParameters cell() {
    voltlap::plant::CellParameters out;
    out.name = "straight";
    out.capacity_ah = kCapacity;
    out.voltage_min_v = 3.0;
    out.voltage_max_v = 4.0;
    out.mass_kg = 0.5;
    out.heat_capacity_j_per_kg_k = 1000.0;
    out.surface_area_m2 = 0.05;
    out.convection_w_per_m2_k = 10.0;
    out.reference_temperature_c = 25.0;
    out.soc_breakpoints = {0.0, 1.0};
    out.temperature_breakpoints_c = {15.0, 25.0, 35.0};
    out.current_breakpoints_a = {0.0, 10.0, 20.0, 30.0, 40.0};
    out.ocv_soc = {0.0, 1.0};
    out.ocv_v = {3.0, 4.0};
    out.r0_ohm.value = {kR0, kR0};
    for (std::size_t k = 0; k < 2; ++k) {
      out.branches[k].r_ohm.value = {1e-7, 1e-7};
      out.branches[k].tau_s.value = {1.0, 1.0};
    }
    return out;
  }

  /// Rests two minutes, then draws each current for a second, from full; `r0` by current.
  template <class R0>
  static voltlap::plant::CellLog record(const std::vector<double>& currents_a, const R0& r0,
                                        double capacity_ah = kCapacity) {
    voltlap::plant::CellLog log;
    log.path = "straight.csv";
    double soc = 1.0;
    for (std::size_t row = 0; row < currents_a.size() + kRest; ++row) {
      const double i = row < kRest ? 0.0 : currents_a[row - kRest];
      soc -= i / 3600.0 / capacity_ah;
      log.time_s.push_back(static_cast<double>(row));
      log.current_a.push_back(i);
      log.voltage_v.push_back(3.0 + soc - r0(i) * i);
    }
    log.gap.assign(log.rows(), false);
    return log;
  }
  static voltlap::plant::CellLog record(const std::vector<double>& currents_a, double capacity_ah = kCapacity) {
    return record(currents_a, [](double) { return kR0; }, capacity_ah);
  }
  /// From full to half full with 20 A.
  static std::vector<double> half() { return std::vector<double>(900, 20.0); }
};

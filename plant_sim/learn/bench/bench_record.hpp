// SPDX-License-Identifier: Apache-2.0
// What one test leaves behind: the table as logged, the truth beside it, and when pulses and rests were.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "learn/bench/program.hpp"

namespace voltlap::plant {

struct CellRecord {
  std::vector<double> voltage_v, temperature_c;                      ///< as read
  std::vector<double> true_voltage_v, true_soc, true_temperature_c;  ///< as it was
  CellVariation variation{};
  double initial_soc = 0.0, capacity_ah = 0.0;
};

/// A load or a rest. Times are those of the table.
struct BenchPhase {
  double begin_s = 0.0, end_s = 0.0;
  bool load = false;
  double charge_ah = 0.0;  ///< drawn, true
  double soc = 0.0;        ///< mean of the cells at its end, true
};

enum class TestEnd { kVoltage, kTemperature, kProgram, kInterrupted };

struct BenchRecord {
  BenchTest test;
  std::vector<double> time_s, current_a, ambient_c;  ///< as logged
  std::vector<double> true_current_a;
  std::vector<CellRecord> cells;
  std::vector<BenchPhase> phases;
  TestEnd end = TestEnd::kProgram;
  std::size_t end_cell = 0;  ///< from 1; the cell that ended the test
  double charge_ah = 0.0;    ///< drawn in all, true

  [[nodiscard]] double duration_s() const { return phases.empty() ? 0.0 : phases.back().end_s; }
  [[nodiscard]] std::size_t count(bool load) const {
    std::size_t found = 0;
    for (const BenchPhase& phase : phases) found += phase.load == load ? 1U : 0U;
    return found;
  }
};

}  // namespace voltlap::plant

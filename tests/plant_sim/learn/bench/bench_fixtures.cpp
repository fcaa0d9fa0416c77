// SPDX-License-Identifier: Apache-2.0
#include "bench_fixtures.hpp"

#include "fixtures.hpp"

namespace voltlap::plant::test {

BenchPlan shipped_plan(const std::string& name, const std::vector<std::string>& settings) {
  return load_plan(DataFolder(VOLTLAP_SOURCE_DIR "/plant_sim/data"), name, settings);
}

BenchPlan ideal_plan(const std::vector<std::string>& settings) {
  std::vector<std::string> all = {"test.temperature_c=30",
                                  "test.current_a=200",
                                  "instruments.noise=false",
                                  "instruments.quantisation=false",
                                  "instruments.systematic=false",
                                  "cells.capacity_spread=0",
                                  "cells.resistance_spread=0",
                                  "cells.soc_spread=0",
                                  "box.mode=bath",
                                  "sampling.log_hz=8"};
  all.insert(all.end(), settings.begin(), settings.end());
  return shipped_plan("pulse_15", all);
}

CellParameters straight_cell() {
  CellParameters cell = constant_cell();
  cell.ocv_polynomial_v = {3.0, 1.2};
  return cell;
}

BenchRecord run_equal(const BenchPlan& plan, const CellParameters& cell) {
  const auto count = static_cast<std::size_t>(plan.cells.count);
  return run_bench_test(plan, tests_of(plan).front(), {cell, std::vector<CellVariation>(count), false},
                        draw_errors(plan.instruments, count, 1), 1);
}

}  // namespace voltlap::plant::test

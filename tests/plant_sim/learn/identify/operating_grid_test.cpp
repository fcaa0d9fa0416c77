// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/operating_grid.hpp"

#include <algorithm>
#include <vector>

#include "known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(OperatingGrid) {
  KnownCell cell;
};

TEST(OperatingGrid, RecordingsStandAtTheirTemperatureAndCurrent) {
  const CellLog low = cell.record(cell.pulse_plan(20.0, 500, 0.0)), high = cell.record(cell.pulse_plan(60.0, 500, 0.0));
  const OperatingGrid grid = operating_grid({high, low, low}, {26.0, 25.0, 40.0});
  LONGS_EQUAL(2, grid.temperatures_c.size());
  LONGS_EQUAL(2, grid.currents_a.size());
  CHECK((grid.temperature_of == std::vector<std::size_t>{0, 0, 1}));
  CHECK((grid.current_of == std::vector<std::size_t>{1, 0, 0}));
}

TEST(OperatingGrid, ResistorsCurrentThatFallsInItsLastPulseIsStillOneCurrent) {
  std::vector<CellLog> logs;
  for (const double current : {20.0, 60.0}) {
    std::vector<double> plan = cell.pulse_plan(current, 500, 0.0);
    const auto drawn = std::count(plan.begin(), plan.end(), current);
    auto left = drawn * 8 / 100;
    for (auto row = plan.rbegin(); left > 0; ++row) {
      if (*row == 0.0) continue;
      *row *= 0.6;
      --left;
    }
    logs.push_back(cell.record(plan));
  }
  LONGS_EQUAL(2, operating_grid(logs, {25.0, 25.0}).currents_a.size());
}

TEST(OperatingGrid, OneDriveOfManyCurrentsMakesAllOneCurrent) {
  std::vector<double> drive = cell.pulse_plan(20.0, 500, 0.0);
  for (std::size_t row = 0; row < drive.size(); row += 2) drive[row] *= 3.0;
  const OperatingGrid grid =
      operating_grid({cell.record(cell.pulse_plan(60.0, 500, 0.0)), cell.record(drive)}, {25.0, 25.0});
  LONGS_EQUAL(1, grid.currents_a.size());
  DOUBLES_EQUAL(0.0, grid.currents_a[0], 0.0);
}
TEST(OperatingGrid, ShortPulsesOfOtherCurrentsInADischargeMakeItATestOfSeveral) {
  std::vector<double> plan = cell.pulse_plan(33.0, 500, 0.0);
  for (std::size_t pulse = 0; pulse < 8; ++pulse)
    std::fill_n(plan.begin() + static_cast<std::ptrdiff_t>(700 + 900 * pulse), 3,
                35.0 + 38.0 * static_cast<double>(pulse));
  DOUBLES_EQUAL(0.0, operating_grid({cell.record(plan)}, {25.0}).currents_a[0], 0.0);
  DOUBLES_EQUAL(33.0, operating_grid({cell.record(cell.pulse_plan(33.0, 500, 0.0))}, {25.0}).currents_a[0], 1e-9);
}

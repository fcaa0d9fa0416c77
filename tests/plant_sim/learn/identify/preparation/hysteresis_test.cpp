// SPDX-License-Identifier: Apache-2.0
// An open-circuit voltage that depends on the direction, told by a slow charge and discharge beside pulses.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "learn/identify/identify.hpp"
#include "plant_sim/core/scratch.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// One state of this size, after a charge in the beginning, that follows the direction within an ampere-hour.
CellLog with_hysteresis(double size_v, CellLog log) {
  double state = -size_v;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    state += (size_v - (log.current_a[row] > 0.0 ? 1.0 : -1.0) * state) * log.current_a[row] / 3600.0;
    log.voltage_v[row] -= state;
  }
  return log;
}

/// A rest, a slow discharge and a slow charge.
std::vector<double> slow_pair(double current_a, int hours) {
  std::vector<double> out(300, 0.0);
  out.insert(out.end(), static_cast<std::size_t>(hours) * 3600, current_a);
  out.insert(out.end(), static_cast<std::size_t>(hours) * 3600, -current_a);
  return out;
}

}  // namespace

TEST_GROUP(Hysteresis) {
  KnownCell cell;
  IdentifyOptions options;
  void setup() override {
    options.branches = 2;
    options.hold = CurrentHold::kNext;  // as KnownCell records
  }
};

TEST(Hysteresis, IsAStateThatThePulsesAndTheSlowTestHaveTogether) {
  // One state of 20 mV, after a charge in the beginning, that follows the direction within some per cent of the charge.
  constexpr double kSize = 0.02;
  const CellLog log = with_hysteresis(kSize, cell.record(slow_pair(1.5, 20))),
                pulses = with_hysteresis(kSize, cell.record(cell.pulse_plan(33.0, 600, 0.0)));
  const IdentifyResult r = identify({pulses, log}, options);
  DOUBLES_EQUAL(kSize, r.hysteresis_v, 6e-3);
  DOUBLES_EQUAL(1e3 * kSize, r.model.laws.hysteresis_mv, 2.0);
  CHECK(r.model.laws.hysteresis_per_soc >= 20.0 && r.model.laws.hysteresis_per_soc <= 40.0);  // 1 Ah of 30
  DOUBLES_EQUAL(1.0, (r.model.r(8, 1) + r.model.r(8, 2)) / (KnownCell::r1(0.5) + KnownCell::r2(0.5)), 0.05);
  CHECK(r.rms_v < 2e-3);
  // Alone the slow test holds no current that could tell the circuit: refused with the reason.
  STRCMP_CONTAINS("Hysteresis", complaint([&] { (void)identify({log}, options); }).c_str());
}

TEST(Hysteresis, ThatSlowBranchesMightBeIsTakenWhereItIsDecisivelyBetter) {
  // Three times what a step takes of the slow current is a whole circuit of some cells: less may be a hysteresis.
  constexpr double kSize = 0.006, kSlow_a = 3.0;
  for (const double size : {kSize, 0.0}) {
    const CellLog pulses = with_hysteresis(size, cell.record(cell.pulse_plan(33.0, 600, 0.0)));
    const IdentifyResult r = identify({pulses, with_hysteresis(size, cell.record(slow_pair(kSlow_a, 10)))}, options);
    DOUBLES_EQUAL(1e3 * size, r.model.laws.hysteresis_mv, 2.0);
    CHECK(r.rms_v < 2e-3);
  }
}

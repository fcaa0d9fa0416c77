// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/first_estimates.hpp"

#include <cmath>
#include <random>

#include "plant_sim/core/scratch.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(FirstEstimates) {
  KnownCell cell;
  MeasuredRun run_of(const std::vector<double>& plan) {
    RunOptions options;
    options.capacity_ah = cell.capacity_ah;
    return make_run(cell.record(plan), options);
  }
};

TEST(FirstEstimates, PulsesAndRestsAreFound) {
  const auto found = segments(run_of(cell.pulse_plan(30.0, 900)));
  // 4 + 6 + 4 pulses (5 % above 80, 10 % between, 5 % below 20, the last shorter) between rests.
  LONGS_EQUAL(2 * 14 + 1, found.size());
  CHECK(found[0].kind == PulseSegment::Kind::kRest);
  CHECK(found[1].kind == PulseSegment::Kind::kDischarge);
  DOUBLES_EQUAL(0.05 * 3600.0, found[1].duration_s, 2.0);
}

TEST(FirstEstimates, StepGivesTheSeriesResistance) {
  const auto steps = resistance_steps(run_of(cell.pulse_plan(30.0, 900)));
  CHECK(steps.size() > 20);
  for (const StepEstimate& step : steps) {
    // One second of the fast branch is in it: a little more than R0.
    CHECK(step.resistance_ohm > KnownCell::r0(step.soc));
    CHECK(step.resistance_ohm < 1.1 * KnownCell::r0(step.soc));
  }
}

TEST(FirstEstimates, RestGivesTheOcvWithinThreeOfItsSigmas) {
  for (const int rest : {300, 900, 3600}) {
    for (const OcvKnowledge& known : ocv_from_rests(run_of(cell.pulse_plan(30.0, rest)))) {
      DOUBLES_EQUAL(KnownCell::em(known.soc), known.voltage_v, 3.0 * known.sigma_v);
      if (rest == 3600) CHECK(known.sigma_v < 1e-3);
    }
  }
}

TEST(FirstEstimates, SlowTestGivesTheOcvBetweenItsTwoBranches) {
  std::vector<double> plan(60, 0.0);
  plan.insert(plan.end(), 20 * 3600, 1.5);
  plan.insert(plan.end(), 20 * 3600, -1.5);
  CellLog log = cell.record(plan);
  const SlowTest slow = ocv_from_slow_test(log);
  DOUBLES_EQUAL(30.0, slow.capacity_ah, 0.01);
  CHECK(slow.ocv.size() > 35);
  for (const OcvKnowledge& known : slow.ocv) {
    if (known.soc > 0.05 && known.soc < 0.98) DOUBLES_EQUAL(KnownCell::em(known.soc), known.voltage_v, 2e-3);
  }
}

TEST(FirstEstimates, FastDischargeIsNoSlowTest) {
  std::vector<double> plan(60, 0.0);
  plan.insert(plan.end(), 3500, 30.0);
  const CellLog log = cell.record(plan);
  STRCMP_CONTAINS("C/10", complaint([&] { (void)ocv_from_slow_test(log); }).c_str());
}

namespace {

/// Pulls of a car at 100 Hz: the current takes most of a second to rise and to fall, to a height of its own.
std::vector<double> pulls(int count) {
  constexpr int kRamp = 80, kHold = 150;  // rows
  std::vector<double> plan(200, 0.0);
  for (int pull = 0; pull < count; ++pull) {
    const double most = 150.0 + 25.0 * (pull % 4);
    for (int k = 1; k <= kRamp; ++k) plan.push_back(most * k / kRamp);
    plan.insert(plan.end(), kHold, most);
    for (int k = kRamp; k-- > 0;) plan.push_back(most * k / kRamp);
    plan.insert(plan.end(), kHold, 0.0);
  }
  return plan;
}

}  // namespace

TEST(FirstEstimates, AStepIsAChangeOverATimeNotBetweenTwoRows) {
  cell.row_s = 0.01;
  const auto steps = resistance_steps(run_of(pulls(6)));
  CHECK(steps.size() >= 12);
  for (const StepEstimate& step : steps) {
    CHECK(step.resistance_ohm > 0.95 * KnownCell::r0(step.soc));
    CHECK(step.resistance_ohm < 1.3 * KnownCell::r0(step.soc));
  }
}

TEST(FirstEstimates, CurrentAndVoltageInTurnOnABusHaveSteps) {
  cell.row_s = 0.01;
  CellLog log = cell.record(pulls(6));
  for (std::size_t row = 1; row < log.rows(); row += 2) log.voltage_v[row] = std::nan("");
  RunOptions options;
  options.capacity_ah = cell.capacity_ah;
  CHECK(resistance_steps(make_run(log, options)).size() >= 12);
}

TEST(FirstEstimates, NoiseOfTheCurrentEndsNoRest) {
  CellLog log = cell.record(cell.pulse_plan(30.0, 900));
  const std::size_t found = segments(run_of(cell.pulse_plan(30.0, 900))).size();
  std::mt19937 generator(7);
  std::normal_distribution<double> noise(0.0, 0.2);  // 0.7 % of the pulses: beyond a hundredth in a sixth of the rows
  for (double& i : log.current_a) i += noise(generator);
  RunOptions options;
  options.capacity_ah = cell.capacity_ah;
  CHECK(segments(make_run(log, options)).size() < found + 5);
}

// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/charge_noise.hpp"

#include <cmath>

#include "learn/identify/identify.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(ChargeNoise) {
  static constexpr double kRest = 0.02, kLoad = 0.2;  // A
  KnownCell cell;
  CellLog log;

  void setup() override {
    cell.noise_v = 3e-4;
    log = cell.record(cell.pulse_plan(33.0, 640, 0.0));
    std::mt19937 generator(3);
    std::normal_distribution<double> noise(0.0, 1.0);
    for (double& current : log.current_a) current += (current > 1.0 ? kLoad : kRest) * noise(generator);
  }
};

TEST(ChargeNoise, IsThatOfRestAndLoadApart) {
  const CurrentNoise found = current_noise(log);
  DOUBLES_EQUAL(1.0, found.rest_a2_s / (kRest * kRest), 0.05);
  DOUBLES_EQUAL(1.0, found.load_a2_s / (kLoad * kLoad), 0.10);
}

TEST(ChargeNoise, CurrentWithoutNoiseHasNone) {
  const CurrentNoise found = current_noise(cell.record(cell.pulse_plan(33.0, 640, 0.0)));
  DOUBLES_EQUAL(0.0, found.rest_a2_s + found.load_a2_s, 1e-12);
}

TEST(ChargeNoise, OcvsIntervalHoldsTheWalkOfTheCountedCharge) {
  std::vector<std::string> notes;
  const std::vector<CellLog> logs{log};
  const std::vector<PreparedLog> prepared = prepare(logs, {{}, {}, {}, CurrentHold::kNext}, notes);
  std::vector<MeasuredRun> runs = runs_of(prepared);
  FitPriors priors;
  priors.resistance_scale = 1.4e-3;
  const FullFit full = full_fit(runs, priors, {2, {}, 1e-7, {}, {}}, notes);
  const double capacity = prepared[0].run.capacity_ah;
  // Nearly all comes from the load: sd = sqrt(T q (1 - q)) of a bridge, sqrt(T q) of a walk, q = 1 - SOC.
  const double walked = kLoad * kLoad * capacity * 3600.0 / 33.0 + kRest * kRest * runs[0].time_s.tail(1)(0);
  const Eigen::VectorXd bridge = charge_noise_variance(prepared, runs, false, full),
                        open = charge_noise_variance(prepared, runs, true, full);
  const SocGrid grid = ocv_grid();
  for (Eigen::Index node = 0; node < grid.size(); ++node) {
    const double s = grid.at(node);
    if (s < 0.1 || s > 0.9) continue;
    const double slope = (KnownCell::em(s + 1e-3) - KnownCell::em(s - 1e-3)) / 2e-3;
    const double by_soc = slope / (3600.0 * capacity) * std::sqrt(walked);
    DOUBLES_EQUAL(1.0, std::sqrt(bridge(node)) / (by_soc * std::sqrt(s * (1.0 - s))), 0.1);
    DOUBLES_EQUAL(1.0, std::sqrt(open(node)) / (by_soc * std::sqrt(1.0 - s)), 0.1);
  }
}

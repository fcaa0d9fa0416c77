// SPDX-License-Identifier: Apache-2.0
// How full a log begins whose first rows draw next to nothing: after a night, or for a moment amid a drive.
#include "explain/balances/start_under_load.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <random>
#include <string>

#include "explain/balances/model.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A drawn deep drive of pulls and coasting, from a rest of five seconds; its voltage is by `truth`.
struct Drive {
  Recording log;
  VectorXd soc;
};

Drive driven(const World& truth, unsigned seed) {
  constexpr Index kRows = 12'000;
  constexpr double kRow_s = 0.1;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> seconds(2.0, 20.0), pull(100.0, 330.0);
  Drive out;
  out.log.time_s = VectorXd::LinSpaced(kRows, 0.0, kRow_s * static_cast<double>(kRows - 1));
  VectorXd& current = out.log.signals["current"];
  current = VectorXd::Zero(kRows);
  double until_s = 5.0, amperes = 0.0;
  for (Index row = 0; row < kRows; ++row) {
    while (out.log.time_s(row) >= until_s) until_s += seconds(random), amperes = amperes > 2.0 ? 1.5 : pull(random);
    current(row) = amperes;
  }
  out.log.signals["voltage"] = VectorXd::Constant(kRows, 4.0);
  ComparisonOptions stated;
  stated.hold = CurrentHold::kLinear;
  Comparison blank = comparison_of(truth, out.log, stated);
  blank.facts.starts_at_rest = false;
  blank.facts.initial_soc = 0.95;
  blank.facts.voltage_v.resize(0);
  blank.facts.temperature_c.resize(0);
  blank.facts.charged_before_a = 0.0;
  const Prediction of_truth = predict(truth, blank);
  out.log.signals["voltage"] = of_truth.channels[0];
  out.log.signals["temperature_1"] = of_truth.battery.temperature_c;
  out.soc = of_truth.battery.soc;
  return out;
}

Recording from(const Recording& log, Index row) {
  Recording out = log;
  out.time_s = log.time_s.tail(log.time_s.size() - row);
  for (auto& [role, values] : out.signals) values = VectorXd(values.tail(values.size() - row));
  return out;
}

World world() { return load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world; }

}  // namespace

TEST_GROUP(StartUnderLoad){};

TEST(StartUnderLoad, AMomentWithoutCurrentAmidADriveIsNoRest) {
  const World model = world();
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Drive drive = driven(model, seed);
    std::mt19937 random(seed + 1000);
    Index row = std::uniform_int_distribution<Index>(2'000, 7'000)(random);
    const VectorXd& current = *drive.log.find("current");
    while (!(current(row) < 2.0 && current(row - 1) > 2.0)) ++row;  // it has just begun to roll
    const Comparison cut = comparison_of(model, from(drive.log, row), {});
    const Prediction found = predict(model, cut);
    const double off = found.battery.soc(0) - drive.soc(row);
    CHECK_TEXT(std::abs(off) < 0.05, ("seed " + std::to_string(seed) + ": " + std::to_string(off)).c_str());
    const VectorXd left = cut.channels[0].measured - found.channels[0];
    CHECK_TEXT(left.tail(3'000).cwiseAbs().maxCoeff() < 0.03, ("seed " + std::to_string(seed)).c_str());
  }
}

TEST(StartUnderLoad, ARestOfSecondsTellsTheChargeHoweverWrongTheModelIs) {
  const World model = world();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    World truth = model;
    std::mt19937 random(seed);
    const auto drawn = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    truth.car.cell.effects.series_ohm += drawn(0.0, 4e-4);
    truth.car.cell.capacity_ah *= drawn(0.85, 1.15);
    const Comparison whole = comparison_of(model, driven(truth, seed).log, {});
    CHECK_TEXT(whole.facts.starts_at_rest, ("seed " + std::to_string(seed)).c_str());
    DOUBLES_EQUAL(0.95, predict(model, whole).battery.soc(0), 0.003);
  }
}

}  // namespace voltlap::plant

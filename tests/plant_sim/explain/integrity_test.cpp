// SPDX-License-Identifier: Apache-2.0
// A thermistor whose noise stops is frozen, be it for some seconds; one that moves by whole kelvins only may stand.
#include "explain/gate/integrity.hpp"

#include <CppUTest/TestHarness.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "explain/balances/model.hpp"

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr Index kRows = 6000, kFirst = 2000;  // 10 Hz

Model leaf() {
  return load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {});
}

/// Warms by 6 K in ten minutes; noise and resolution in kelvin.
VectorXd thermistor(double noise, double step) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  VectorXd out(kRows);
  for (Index row = 0; row < kRows; ++row) {
    const double warm = 25.0 + 6.0 * static_cast<double>(row) / kRows + noise * normal(random);
    out(row) = std::round(warm / step) * step;
  }
  return out;
}

Gated gated(const VectorXd& temperature) {
  Recording log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  log.signals["current"] = (20.0 * log.time_s.array().sin() + 30.0).matrix();
  log.signals["voltage"] = (3.9 - 0.002 * log.signals["current"].array()).matrix();
  log.signals["temperature_1"] = temperature;
  return integrity_gate(log, leaf());
}

VectorXd held(VectorXd values, Index rows) {
  values.segment(kFirst, rows).setConstant(values(kFirst));
  return values;
}

double frozen_s(const Gated& log) {
  for (const GateFinding& finding : log.findings) {
    if (finding.cause == "frozen_signal" && finding.channel == "temperature_1") return finding.value;
  }
  return 0.0;
}

}  // namespace

TEST_GROUP(Integrity){};

TEST(Integrity, AThermistorThatStandsForSevenSecondsIsFrozen) {
  const Gated log = gated(held(thermistor(0.05, 0.05), 70));
  DOUBLES_EQUAL(6.9, frozen_s(log), 0.31);  // a reading or two beside it may be the same
  CHECK(std::isnan(log.log.signals.at("temperature_1")(kFirst + 30)));
  CHECK(std::isfinite(log.log.signals.at("temperature_1")(kFirst + 80)));
}

TEST(Integrity, ASoundThermistorIsNotFrozen) {
  DOUBLES_EQUAL(0.0, frozen_s(gated(thermistor(0.05, 0.05))), 0.0);
}

TEST(Integrity, TwoSecondsAreNotFrozen) {
  DOUBLES_EQUAL(0.0, frozen_s(gated(held(thermistor(0.05, 0.05), 20))), 0.0);
}

TEST(Integrity, AThermistorOfWholeKelvinsMayStandForAMinute) {
  DOUBLES_EQUAL(0.0, frozen_s(gated(held(thermistor(0.05, 1.0), 600))), 0.0);
}

TEST(Integrity, AThermistorWhoseNoiseIsFinerThanItsStepsMayStandWhereItIsWarm) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  VectorXd warms(kRows);  // 6 K in five minutes, then no more: it stands ten times as long as on any step before
  for (Index row = 0; row < kRows; ++row) {
    const double kelvin = 6.5 * std::min(1.0, 2.0 * static_cast<double>(row) / kRows) + 0.05 * normal(random);
    warms(row) = 25.0 + 0.5 * std::round(kelvin / 0.5);
  }
  DOUBLES_EQUAL(0.0, frozen_s(gated(warms)), 0.0);
}

TEST(Integrity, AThermistorWithoutNoiseMayStandWhereItIsWarm) {
  VectorXd warms(kRows);  // by hundredths, faster at first: it stands for longest where next to nothing warms it
  for (Index row = 0; row < kRows; ++row) {
    const double kelvin = 6.0 * (1.0 - std::exp(-6.0 * static_cast<double>(row) / kRows));
    warms(row) = 25.0 + 0.01 * std::round(kelvin / 0.01);
  }
  warms.tail(600).setConstant(warms(kRows - 1));
  DOUBLES_EQUAL(0.0, frozen_s(gated(warms)), 0.0);
}

TEST(Integrity, AThermistorThatGoesToAndFroBetweenTwoStepsMayHaveStoodBefore) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  VectorXd warms(kRows);  // it stands for two and a half minutes, then is where noise of 0.05 K changes the reading
  for (Index row = 0; row < kRows; ++row) warms(row) = std::round((row < 1500 ? 31.2 : 31.5) + 0.05 * normal(random));
  DOUBLES_EQUAL(0.0, frozen_s(gated(warms)), 0.0);
}

TEST(Integrity, AFewRowsWithoutAValueAreNoFindingWhereReferencesHaveNone) {
  const auto lost = [](double count, bool worth_telling) {
    return std::vector<GateFinding>{{"dropped_or_late_frames", "soc", "count", count, "1", worth_telling}};
  };
  const std::vector<std::vector<GateFinding>> whole(3);
  LONGS_EQUAL(0, unusual_findings(lost(17.0, false), whole).size());
  LONGS_EQUAL(1, unusual_findings(lost(400.0, true), whole).size());
  LONGS_EQUAL(0, unusual_findings(lost(400.0, true), {lost(300.0, true)}).size());
}

TEST(Integrity, BeforeAFirstReadingNothingIsMissing) {
  const auto found_in = [](Index first, Index hole) {
    VectorXd warms = VectorXd::LinSpaced(kRows, 25.0, 31.0);
    warms.head(first).setConstant(std::numeric_limits<double>::quiet_NaN());
    warms.segment(1000, hole).setConstant(std::numeric_limits<double>::quiet_NaN());
    const std::vector<GateFinding> findings = gated(warms).findings;
    return std::count_if(findings.begin(), findings.end(),
                         [](const GateFinding& finding) { return finding.cause == "dropped_or_late_frames"; });
  };
  LONGS_EQUAL(0, found_in(0, 0));
  LONGS_EQUAL(0, found_in(40, 0));  // 4 s
  LONGS_EQUAL(1, found_in(40, 5));
  LONGS_EQUAL(1, found_in(600, 0));
}

TEST(Integrity, AVoltageWhoseNoiseStopsAtRestIsFrozen) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Recording log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  log.signals["current"] = VectorXd::Zero(kRows);
  log.signals["current"].head(1000).setConstant(30.0);
  VectorXd volts(kRows);
  for (Index row = 0; row < kRows; ++row) volts(row) = 3.8 + 1e-4 * std::round(5.0 * normal(random));
  log.signals["voltage"] = held(volts, 80);
  const Gated out = integrity_gate(log, leaf());
  LONGS_EQUAL(1, std::count_if(out.findings.begin(), out.findings.end(), [](const GateFinding& finding) {
                return finding.cause == "frozen_signal" && finding.channel == "voltage";
              }));
}

TEST(Integrity, AVoltageOfCoarseStepsIsNotFrozenByACurrentThatMovesItLess) {
  Recording log;
  log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
  log.signals["current"] = (20.0 * log.time_s.array().sin() + 30.0).matrix();
  const auto volts = 4.1 - 0.001 * log.time_s.array() - 0.002 * log.signals["current"].array();
  log.signals["voltage"] = (0.1 * (volts / 0.1).round()).matrix();
  const Gated out = integrity_gate(log, leaf());
  CHECK(std::none_of(out.findings.begin(), out.findings.end(),
                     [](const GateFinding& finding) { return finding.cause == "frozen_signal"; }));
}

// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/recording/quantised_temperature.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(QuantisedTemperature) {
  CellLog log;
  std::vector<double> truth;

  /// Pulses of 100 A that warm a cell by some 4 K in a room that drifts by 1 K; heat leaves with 600 s.
  void setup() override {
    log = KnownCell().record(KnownCell().pulse_plan(100.0, 640, 0.0));
    double warmth = 0.0;
    for (std::size_t row = 0; row < log.rows(); ++row) {
      warmth += 4e-6 * log.current_a[row] * log.current_a[row] - warmth / 600.0;
      truth.push_back(25.2 + warmth + static_cast<double>(row) / static_cast<double>(log.rows()));
    }
  }
  void read_in_steps(double step, double noise) {
    std::mt19937 generator(1);
    std::normal_distribution<double> error(0.0, 1.0);
    log.temperature_c.clear();
    for (const double t : truth) log.temperature_c.push_back(step * std::round((t + noise * error(generator)) / step));
  }
  [[nodiscard]] double rms() const {
    double sum = 0.0;
    for (std::size_t row = 0; row < log.rows(); ++row) sum += std::pow(log.temperature_c[row] - truth[row], 2);
    return std::sqrt(sum / static_cast<double>(log.rows()));
  }
};

TEST(QuantisedTemperature, WholeDegreesBecomeTheCurveThatMadeThem) {
  read_in_steps(1.0, 0.1);
  const double read = rms();
  smooth_quantised_temperature(log);
  CHECK(read > 0.28);
  CHECK_TEXT(rms() < 0.08, std::to_string(rms()).c_str());
  LONGS_EQUAL(1, log.repairs.size());
  STRCMP_CONTAINS("steps of 1 K", log.repairs.front().c_str());
}

TEST(QuantisedTemperature, FineReadingsStayAsTheyAre) {
  read_in_steps(0.01, 0.05);
  const std::vector<double> before = log.temperature_c;
  smooth_quantised_temperature(log);
  CHECK(before == log.temperature_c);
  LONGS_EQUAL(0, log.repairs.size());
}

TEST(QuantisedTemperature, ReadingsThatDoNotFollowTheCurrentStayAsTheyAre) {
  // A box that is heated and cooled in turn, whatever the cell does.
  for (std::size_t row = 0; row < log.rows(); ++row)
    truth[row] = 25.0 + 5.0 * std::sin(static_cast<double>(row) / 150.0);
  read_in_steps(1.0, 0.0);
  const std::vector<double> before = log.temperature_c;
  smooth_quantised_temperature(log);
  CHECK(before == log.temperature_c);
  LONGS_EQUAL(0, log.repairs.size());
}

TEST(QuantisedTemperature, ALogWithoutTemperatureOrWithOneReadingOnlyIsLeft) {
  smooth_quantised_temperature(log);
  CHECK(log.temperature_c.empty());
  log.temperature_c.assign(log.rows(), 25.0);
  smooth_quantised_temperature(log);
  CHECK(std::all_of(log.temperature_c.begin(), log.temperature_c.end(), [](double t) { return t == 25.0; }));
}

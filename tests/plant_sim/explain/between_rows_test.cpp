// SPDX-License-Identifier: Apache-2.0
// Currents that are switched between the rows of a log: rows that are further apart make the same of them.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "explain/balances/balances.hpp"
#include "explain/balances/counted_charge.hpp"
#include "explain/balances/model.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

World leaf() {
  return load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
}

}  // namespace

TEST_GROUP(BetweenRows){};

TEST(BetweenRows, mean_square_of_two_levels_is_told_by_their_mean) {
  std::mt19937 random(1);
  const auto drawn = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int k = 0; k < 1000; ++k) {
    const double low = drawn(-50.0, 50.0), high = low + drawn(0.0, 300.0), part = drawn(0.0, 1.0);
    const double mean = (1.0 - part) * low + part * high;
    const double square = (1.0 - part) * low * low + part * high * high;
    const CurrentRange usual{low, high};
    for (const auto& [before, now] : {std::pair{low, high}, {high, low}, {low, low}, {high, high}})
      DOUBLES_EQUAL(square, switched_square(before, now, mean, usual), 1e-6);
    // Never less than the square of the mean; beyond what is usual it is that of a straight line.
    CHECK(switched_square(low, low, low - 10.0, usual) >= std::pow(low - 10.0, 2));
  }
}

TEST(BetweenRows, a_current_that_is_switched_between_rows_heats_as_it_does_in_fine_ones) {
  const World model = leaf();
  const auto rise = [&](int rows_a_second) {  // 300 A for 0.6 s of each 1.2 s, switched in the middle between two rows
    Recording log;
    const Index rows = 600 * rows_a_second;
    log.time_s = VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1) / rows_a_second);
    LogFacts facts;
    facts.initial_soc = 0.8;
    facts.stopped.assign(static_cast<std::size_t>(rows), false);
    facts.current_a = VectorXd::Zero(rows);
    for (Index row = 0; row < rows; ++row) {
      if (std::fmod(log.time_s(row) + 0.05, 1.2) < 0.6) facts.current_a(row) = 300.0;
    }
    log.signals["current"] = facts.current_a;
    return battery_response(model, log, facts).temperature_c(rows - 1) - facts.initial_temperature_c;
  };
  const double fine_k = rise(200), coarse_k = rise(10);
  CHECK(fine_k > 2.0);
  DOUBLES_EQUAL(1.0, coarse_k / fine_k, 0.01);
}

TEST(BetweenRows, rows_that_are_seconds_apart_make_the_same_of_a_counted_current_as_fine_ones) {
  // A car that pulls and lets go at any time. What high currents make of resistances and time constants was lost
  // between the rows: slow branches drifted by 4 mV, and cells were 0.8 K too cold.
  const World model = leaf();
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    const auto drawn = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    constexpr Index kFine = 60000;  // 10 min at 100 Hz
    VectorXd fine_a(kFine);
    for (Index k = 0; k < kFine;) {
      const double level_a = drawn(0.0, 1.0) < 0.5 ? drawn(5.0, 15.0) : drawn(80.0, 300.0);
      const Index end = std::min(kFine, k + static_cast<Index>(100.0 * drawn(0.5, 4.0)));
      for (; k < end; ++k) fine_a(k) = level_a;
    }
    const Index every = std::array<Index, 4>{10, 20, 50, 100}[seed % 4];
    const auto response = [&](Index step) {
      Recording log;
      LogFacts facts;
      const Index rows = kFine / step;
      facts.initial_soc = 0.9;
      facts.stopped.assign(static_cast<std::size_t>(rows), false);
      log.time_s = facts.current_a = facts.counted_a = VectorXd::Zero(rows);
      for (Index row = 0; row < rows; ++row) {
        log.time_s(row) = 0.01 * static_cast<double>(step * row);
        facts.current_a(row) = fine_a(step * row);
        facts.counted_a(row) = row == 0 ? 0.0 : fine_a.segment(step * (row - 1) + 1, step).mean();
      }
      log.signals["current"] = facts.current_a;
      return battery_response(model, log, facts);
    };
    const BatteryResponse fine = response(1), coarse = response(every);
    const Index rows = kFine / every, last = rows / 4;
    double off_v = 0.0;
    for (Index row = rows - last; row < rows; ++row)
      off_v += (coarse.voltage_v(row) - fine.voltage_v(every * row)) / static_cast<double>(last);
    const double fine_k = fine.temperature_c(every * (rows - 1)) - fine.temperature_c(0);
    const double coarse_k = coarse.temperature_c(rows - 1) - coarse.temperature_c(0);
    const std::string text = "seed " + std::to_string(seed) + ", every " + std::to_string(every) + "th row: " +
                             std::to_string(off_v) + " V, " + std::to_string(coarse_k / fine_k);
    CHECK_TEXT(std::abs(off_v) < 1e-3, text.c_str());
    CHECK_TEXT(std::abs(coarse_k / fine_k - 1.0) < 0.01, text.c_str());
  }
}

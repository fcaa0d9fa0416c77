// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "io/logs/cell_log.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// A cell of 10 mOhm whose voltage falls with the charge drawn: pulses of 20 A for 20 s, one row a second.
struct Pulses {
  double time_scale = 1.0, current_scale = 1.0, temperature = 25.0;
  bool counter = false;

  [[nodiscard]] MeasuredTable table(int rows = 400) const {
    MeasuredTable out;
    out.path = "pulses.csv";
    out.columns = {"t", "i", "v", "temp", "q"};
    out.values.resize(5);
    double drawn = 0.0;
    for (int k = 0; k < rows; ++k) {
      const double current = (k / 20) % 2 == 1 ? 20.0 : 0.0;
      drawn += current / 3600.0;
      out.values[0].push_back(k * time_scale);
      out.values[1].push_back(current * current_scale);
      out.values[2].push_back(4.1 - 0.1 * drawn - 0.01 * current);
      out.values[3].push_back(temperature);
      out.values[4].push_back(drawn);
      out.lines.push_back(static_cast<std::size_t>(k) + 2);
    }
    return out;
  }
  [[nodiscard]] RoleMap map(const char* unit = "") const {
    RoleMap out;
    out.source = "a map";
    out.roles["time"] = {"t", 1.0, 0.0, DischargeSign::kAuto, unit};
    out.roles["current"] = {"i", 1.0, 0.0, DischargeSign::kAuto, unit};
    out.roles["voltage"] = {"v"};
    out.roles["temperature_1"] = {"temp"};
    if (counter) out.roles["charge_ah"] = {"q", 1.0, 0.0, DischargeSign::kAuto, unit};
    return out;
  }
  [[nodiscard]] CellLog log(const char* unit = "") const { return cell_log_of(table(), map(unit), {}); }
  [[nodiscard]] std::string refusal(const char* unit) const {
    return complaint([&] { (void)log(unit); });
  }
};

bool said(const CellLog& log, const char* words) {
  return std::any_of(log.repairs.begin(), log.repairs.end(),
                     [&](const std::string& repair) { return repair.find(words) != std::string::npos; });
}

}  // namespace

TEST_GROUP(PlausibleUnits){};

TEST(PlausibleUnits, RightOnesAreLeftAlone) {
  const CellLog log = Pulses{}.log();
  LONGS_EQUAL(1, log.repairs.size());
  CHECK(said(log, "time has no unit"));
  DOUBLES_EQUAL(20.0, log.current_a[30], 0.0);
}

TEST(PlausibleUnits, PartsThatAreJoinedStandAMinuteApartInWhateverUnitTheTimeWas) {
  const Pulses pulses{.time_scale = 1e3};
  MeasuredTable table = pulses.table();
  const double restart = table.values[0][200];
  for (std::size_t row = 200; row < 400; ++row) table.values[0][row] -= restart;
  const CellLog log = cell_log_of(table, pulses.map(), {});
  CHECK(said(log, "time is in ms"));
  DOUBLES_EQUAL(60.0, log.time_s[200] - log.time_s[199], 1e-6);
  DOUBLES_EQUAL(1.0, log.time_s[201] - log.time_s[200], 1e-6);
  DOUBLES_EQUAL(199.0, log.time_s[199], 1e-6);
}

TEST(PlausibleUnits, MilliamperesAreFoundAndSaidOrRefusedWhereAmperesWereTold) {
  const Pulses pulses{.current_scale = 1e3};
  const CellLog log = pulses.log();
  DOUBLES_EQUAL(20.0, log.current_a[30], 1e-9);
  CHECK(said(log, "current is in mA"));
  STRCMP_CONTAINS("for each cell", pulses.refusal("A").c_str());
}

TEST(PlausibleUnits, KelvinBecomesDegreesAndFahrenheitIsSaid) {
  const CellLog kelvin = Pulses{.temperature = 303.15}.log();
  DOUBLES_EQUAL(30.0, kelvin.temperature_c[0], 1e-9);
  CHECK(said(kelvin, "in K"));
  CHECK(said(Pulses{.temperature = 77.0}.log(), "degF"));
  STRCMP_CONTAINS("degF", Pulses{.temperature = 900.0}.refusal("").c_str());
}

TEST(PlausibleUnits, TimeFollowsFromTheCounterAndFromTheChargeThatACellCanHold) {
  const CellLog minutes = Pulses{.time_scale = 1.0 / 60, .counter = true}.log();
  DOUBLES_EQUAL(399.0, minutes.time_s.back(), 1e-6);
  CHECK(said(minutes, "time is in min"));
  const CellLog milli = Pulses{.time_scale = 1e3}.log();
  DOUBLES_EQUAL(399.0, milli.time_s.back() - milli.time_s.front(), 1e-6);
  CHECK(said(milli, "time is in ms"));
  const Pulses told_minutes{.time_scale = 1.0 / 60, .counter = true};
  STRCMP_CONTAINS("the time", told_minutes.refusal("s").c_str());
  STRCMP_CONTAINS("time (ms", Pulses{.time_scale = 1e3}.refusal("s").c_str());
}

TEST(PlausibleUnits, ImpossibleCurrentsAreMaskedAndCountedAndManyRefused) {
  const Pulses pulses;
  MeasuredTable table = pulses.table();
  table.values[1][100] = 1e308;
  const CellLog log = cell_log_of(table, pulses.map(), {});
  LONGS_EQUAL(399, log.rows());
  CHECK(said(log, "1 of 400 rows have an impossible current, such as 1e+308 A"));
  for (std::size_t row = 0; row < 40; ++row) table.values[1][10 * row] = -1e20;
  STRCMP_CONTAINS("40 of 400 rows", complaint([&] { (void)cell_log_of(table, pulses.map(), {}); }).c_str());
}

TEST(PlausibleUnits, SingleRowThatTheVoltageDoesNotFollowIsLeftOut) {
  const Pulses pulses;
  MeasuredTable table = pulses.table();
  table.values[1][110] = 4000.0;
  const CellLog log = cell_log_of(table, pulses.map(), {});
  LONGS_EQUAL(399, log.rows());
  CHECK(said(log, "a single row of 4000 A"));
  table.values[2][110] -= 0.01 * 4000.0 / 20.0;  // an answer: it was there
  LONGS_EQUAL(400, cell_log_of(table, pulses.map(), {}).rows());
}

TEST(PlausibleUnits, RowsInAnotherOrderAreSortedAndPartsOfARestartedClockJoined) {
  const Pulses pulses;
  const MeasuredTable table = pulses.table();
  const auto reordered = [&](auto&& row_of) {
    MeasuredTable out = table;
    for (std::size_t column = 0; column < out.values.size(); ++column) {
      for (std::size_t k = 0; k < 400; ++k) out.values[column][k] = table.values[column][row_of(k)];
    }
    return cell_log_of(out, pulses.map(), {});
  };
  const CellLog plain = cell_log_of(table, pulses.map(), {});
  const CellLog newest_first = reordered([](std::size_t k) { return 399 - k; });
  const CellLog halves = reordered([](std::size_t k) { return (k + 200) % 400; });
  const CellLog shuffled = reordered([](std::size_t k) { return 37 * k % 400; });
  for (const CellLog* log : {&newest_first, &halves, &shuffled}) {
    CHECK(log->time_s == plain.time_s && log->voltage_v == plain.voltage_v && said(*log, "sorted by time"));
    CHECK(std::none_of(log->gap.begin(), log->gap.end(), [](bool gap) { return gap; }));
  }
  MeasuredTable restarted = table;
  for (std::size_t k = 200; k < 400; ++k) restarted.values[0][k] -= 200.0;
  CHECK(said(cell_log_of(restarted, pulses.map(), {}), "1 restarts of the clock"));
}

TEST(PlausibleUnits, WhatIsNotFiniteInIsNeverNotFiniteOut) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given == nullptr ? std::random_device{}() : static_cast<unsigned>(std::stoul(given));
  std::mt19937 draw(seed);
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const double wild[] = {std::nan(""), kInf, -kInf, 1e308, -1e308, 1e20, -1e12, 5e-324, 0.0, 1e9};
  for (int k = 0; k < 300; ++k) {
    const Pulses pulses{.counter = (draw() & 1U) != 0};
    MeasuredTable table = pulses.table();
    const std::size_t spoilt = draw() % 30;
    for (std::size_t n = 0; n < spoilt; ++n)
      table.values[draw() % 5][draw() % 400] = wild[draw() % std::size(wild)];
    if (draw() % 10 == 0) {
      std::vector<double>& whole = table.values[draw() % 5];
      std::fill(whole.begin(), whole.end(), wild[draw() % std::size(wild)]);
    }
    CellLog log;
    const std::string refused = complaint([&] { log = cell_log_of(table, pulses.map(), {}); });
    if (refused != "no error") continue;
    const std::string about = fmt::format("VOLTLAP_TEST_SEED={}, draw {}", seed, k);
    for (const auto* values : {&log.time_s, &log.current_a, &log.temperature_c, &log.charge_ah}) {
      CHECK_TEXT(std::all_of(values->begin(), values->end(), [](double v) { return std::isfinite(v); }), about.c_str());
      CHECK_TEXT(values->empty() || values->size() == log.rows(), about.c_str());
    }
    for (const double v : log.voltage_v) CHECK_TEXT(!std::isinf(v), about.c_str());
    for (const CurrentHold hold : {CurrentHold::kPrevious, CurrentHold::kNext, CurrentHold::kLinear}) {
      for (const double q : charge_drawn_ah(log, hold)) CHECK_TEXT(std::isfinite(q), about.c_str());
    }
  }
}

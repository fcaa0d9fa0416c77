// SPDX-License-Identifier: Apache-2.0
#include "io/logs/cell_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// A cell of 4 V and 10 mOhm under a square wave of 10 A, one row a second.
struct Square {
  double sign = 1.0, volts = 1.0;
  [[nodiscard]] MeasuredTable table(int rows = 60) const {
    MeasuredTable out;
    out.path = "square.csv";
    out.columns = {"t", "i", "v"};
    out.values.resize(3);
    for (int k = 0; k < rows; ++k) {
      const double current = (k / 10) % 2 == 1 ? 10.0 : 0.0;
      out.values[0].push_back(k);
      out.values[1].push_back(sign * current);
      out.values[2].push_back(volts * (4.0 - 0.01 * current));
      out.lines.push_back(static_cast<std::size_t>(k) + 2);
    }
    return out;
  }
};

RoleMap map_with(DischargeSign sign) {
  RoleMap map;
  map.source = "test map";
  map.roles["time"] = {"t"};
  map.roles["current"] = {"i", 1.0, 0.0, sign};
  map.roles["voltage"] = {"v"};
  return map;
}

bool has_repair(const CellLog& log, const char* words) {
  for (const std::string& repair : log.repairs) {
    if (repair.find(words) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TEST_GROUP(CellLog) {
  RoleMap automatic = map_with(DischargeSign::kAuto);
  CellLog log_of(const MeasuredTable& table) {
    return cell_log_of(table, automatic, {});
  }
};

TEST(CellLog, GoodTableNeedsNoRepair) {
  const CellLog log = log_of(Square{}.table());
  LONGS_EQUAL(60, log.rows());
  LONGS_EQUAL(1, log.repairs.size());
  STRCMP_EQUAL("time has no unit: taken as s", log.repairs[0].c_str());
  DOUBLES_EQUAL(10.0, log.current_a[15], 0.0);
}

TEST(CellLog, SignOfTheCurrentIsFoundAndSaid) {
  const CellLog log = log_of(Square{-1.0}.table());
  DOUBLES_EQUAL(10.0, log.current_a[15], 0.0);
  CHECK(has_repair(log, "sign of the current turned"));
}

TEST(CellLog, AVoltageThatComesARowLateTurnsNoSign) {
  // A current that changes with every row, and a voltage that answers to the row before: step by step it rises with it.
  for (const double sign : {1.0, -1.0}) {
    MeasuredTable table = Square{}.table();
    for (auto& values : table.values) values.clear();
    table.lines.clear();
    std::mt19937 random(5);
    double now = 0.0, drawn = 0.0;
    for (int k = 0; k < 600; ++k) {
      const double before = now;
      now = static_cast<double>(random() % 400) / 10.0;
      drawn += now;
      table.values[0].push_back(k);
      table.values[1].push_back(sign * now);
      table.values[2].push_back(4.0 - 0.002 * before - drawn / 4e4);
      table.lines.push_back(static_cast<std::size_t>(k) + 2);
    }
    const CellLog log = log_of(table);
    CHECK(*std::max_element(log.current_a.begin(), log.current_a.end()) > 30.0);
  }
}

TEST(CellLog, SignIsFoundWhereCurrentAndVoltageComeInTurn) {
  // 100 Hz, a voltage in every other row; it begins under load and ends at rest, so that its drift tells nothing.
  for (const double sign : {1.0, -1.0}) {
    MeasuredTable table = Square{}.table();
    for (auto& values : table.values) values.clear();
    for (int k = 0; k < 3000; ++k) {
      const double i = k / 250 % 2 == 0 ? 10.0 : 0.0;
      table.values[0].push_back(0.01 * k);
      table.values[1].push_back(sign * i);
      table.values[2].push_back(k % 2 == 0 ? std::nan("") : 3.9 - 0.01 * i);
    }
    table.lines.resize(3000);
    DOUBLES_EQUAL(10.0, log_of(table).current_a[100], 0.0);
  }
}

TEST(CellLog, TheForgottenNumberInSeriesIsNamed) {
  const MeasuredTable table = Square{1.0, 28.0}.table();
  STRCMP_CONTAINS("--cells-in-series 26 (cells of 4.4 V at most) to 32",
                  complaint([&] { (void)log_of(table); }).c_str());
}

TEST(CellLog, ChargeWhereDischargeWasDeclaredIsRefused) {
  const MeasuredTable table = Square{-1.0}.table();
  const std::string message = complaint([&] { (void)cell_log_of(table, map_with(DischargeSign::kPositive), {}); });
  STRCMP_CONTAINS("discharge was declared", message.c_str());
  DOUBLES_EQUAL(10.0, cell_log_of(table, map_with(DischargeSign::kNegative), {}).current_a[15], 0.0);
}

TEST(CellLog, MillivoltsAreBroughtToVoltsAndSaid) {
  const CellLog log = log_of(Square{1.0, 1000.0}.table());
  DOUBLES_EQUAL(4.0, log.voltage_v[0], 1e-12);
  CHECK(has_repair(log, "mV"));
}

TEST(CellLog, VoltageOfAPackNeedsTheNumberOfCells) {
  const MeasuredTable table = Square{1.0, 28.0}.table();
  STRCMP_CONTAINS("--cells-in-series", complaint([&] { (void)log_of(table); }).c_str());
  const CellLog log = cell_log_of(table, automatic, {-1e300, 1e300, 28, 2});
  DOUBLES_EQUAL(4.0, log.voltage_v[0], 1e-12);
  DOUBLES_EQUAL(5.0, log.current_a[15], 1e-12);
}

TEST(CellLog, RepeatedAndBackwardTimesAndHolesAreLeftOutAndCounted) {
  MeasuredTable table = Square{}.table();
  table.values[0][20] = table.values[0][19];
  table.values[0][30] = table.values[0][28] + 0.5;
  table.values[1][40] = std::nan("");
  const CellLog log = log_of(table);
  LONGS_EQUAL(57, log.rows());
  CHECK(has_repair(log, "1 rows that repeat a time"));
  CHECK(has_repair(log, "1 rows with a time that goes back"));
  CHECK(has_repair(log, "1 rows without a time or current"));
  for (std::size_t row = 1; row < log.rows(); ++row) CHECK(log.time_s[row] > log.time_s[row - 1]);
}

TEST(CellLog, VoltageHoleKeepsItsCurrent) {
  MeasuredTable table = Square{}.table();
  table.values[2][15] = std::nan("");
  const CellLog log = log_of(table);
  LONGS_EQUAL(60, log.rows());
  CHECK(std::isnan(log.voltage_v[15]));
  CHECK(has_repair(log, "1 rows without a voltage are not used"));
}

TEST(CellLog, ClockThatStartsAgainIsJoinedWithAGap) {
  MeasuredTable table = Square{}.table();
  for (std::size_t row = 30; row < 60; ++row) table.values[0][row] -= 30.0;
  const CellLog log = log_of(table);
  LONGS_EQUAL(60, log.rows());
  CHECK(log.gap[30]);
  CHECK(has_repair(log, "restarts of the clock"));
}

TEST(CellLog, AHoleUnderCurrentIsSaidAndOneAtRestIsNot) {
  const struct {
    std::size_t row;
    bool said;
  } holes[] = {{20, true}, {15, true}, {25, false}};  // 10 A to rest; 10 A; rest
  for (const auto& hole : holes) {
    MeasuredTable table = Square{}.table();
    for (std::size_t row = hole.row; row < 60; ++row) table.values[0][row] += 300.0;
    const CellLog log = log_of(table);
    CHECK_EQUAL(hole.said, has_repair(log, "the current is taken as held"));
    CHECK_FALSE(log.gap[hole.row]);
    for (std::size_t row = hole.row; row < 60; ++row) table.values[0][row] += 400.0;
    CHECK(log_of(table).gap[hole.row]);
  }
}

TEST(CellLog, GapTakesItsChargeFromTheCounter) {
  MeasuredTable table = Square{}.table();
  table.columns.emplace_back("q");
  table.values.emplace_back();
  double counter = 0.0;
  for (std::size_t row = 0; row < 60; ++row) {
    if (row >= 25) table.values[0][row] = static_cast<double>(row) + 1000.0;
    if (row == 25) counter += 0.5;  // drawn while nothing was recorded; rows on both sides rest
    counter += table.values[1][row] / 3600.0;
    table.values[3].push_back(counter);
  }
  automatic.roles["charge_ah"] = {"q"};
  const CellLog log = log_of(table);
  CHECK(log.gap[25]);
  const std::vector<double> drawn = charge_drawn_ah(log, CurrentHold::kNext);
  DOUBLES_EQUAL(0.5, drawn[25] - drawn[24], 1e-9);
}

TEST(CellLog, TwoCountersThatBeginAnewMakeTheNetCharge) {
  MeasuredTable table = Square{}.table();
  table.columns.insert(table.columns.end(), {"chg", "dis"});
  table.values.resize(5);
  double in = 0.0, out = 0.0;
  for (std::size_t row = 0; row < 60; ++row) {
    if (row == 40) in = out = 0.0;  // another step of the tester
    out += table.values[1][row] / 3600.0;
    in += 1e-4;
    table.values[3].push_back(in);
    table.values[4].push_back(out);
  }
  automatic.roles["charged_ah"] = {"chg"};
  automatic.roles["discharged_ah"] = {"dis"};
  const CellLog log = log_of(table);
  LONGS_EQUAL(60, log.charge_ah.size());
  // 10 A in rows 10 to 19, 30 to 39 and 50 to 59; row 0 is where it begins.
  DOUBLES_EQUAL(30 * 10.0 / 3600.0 - 59 * 1e-4, log.charge_ah.back() - log.charge_ah.front(), 1e-9);
}

TEST(CellLog, AThinnedCurrentFollowsTheCounter) {
  // +-0.2 A around nothing, of which one row a minute was written: always one with +0.2 A.
  MeasuredTable table = Square{}.table(120);
  table.columns.emplace_back("q");
  table.values.emplace_back();
  double counter = 0.0;
  for (std::size_t row = 0; row < 120; ++row) {
    table.values[0][row] = 60.0 * static_cast<double>(row);
    if (row >= 60) {
      table.values[1][row] = 0.2;
      table.values[2][row] = 3.6;
    }
    counter += row < 60 ? table.values[1][row] * 60.0 / 3600.0 : (row % 2 == 0 ? 1e-5 : -1e-5);
    table.values[3].push_back(counter);
  }
  automatic.roles["charge_ah"] = {"q"};
  const CellLog log = log_of(table);
  CHECK(has_repair(log, "the counter's mean is taken"));
  const std::vector<double> drawn = charge_drawn_ah(log, CurrentHold::kNext);
  DOUBLES_EQUAL(drawn[60], drawn[119], 2e-5);
  DOUBLES_EQUAL(30 * 10.0 / 60.0, drawn[59] - drawn[0], 1e-9);
}

TEST(CellLog, NoiseOfASteadyCurrentTellsNoSign) {
  // A slow discharge, declared as such, whose noise happens to fall with the voltage.
  MeasuredTable table = Square{}.table(400);
  for (std::size_t row = 0; row < 400; ++row) {
    const double t = static_cast<double>(row);
    table.values[1][row] = row < 10 ? 0.0 : 0.08 - 1e-6 * t;
    table.values[2][row] = 3.6 - 1e-4 * t;
  }
  const CellLog log = cell_log_of(table, map_with(DischargeSign::kPositive), {});
  CHECK(log.current_a[200] > 0.0);
}

TEST(CellLog, OneStepThatAnEmptyCellFallsThroughTellsNoSign) {
  // Steps of 0.2 A over 10 mOhm, and one row late in a discharge before which the voltage fell by half a volt.
  MeasuredTable table = Square{}.table(400);
  for (std::size_t row = 0; row < 400; ++row) {
    table.values[1][row] *= 0.02;
    table.values[2][row] = (row < 200 ? 3.6 : 3.1) - 0.01 * table.values[1][row];
  }
  table.values[2][199] = 3.6;  // under load; at rest in row 200
  const CellLog log = cell_log_of(table, map_with(DischargeSign::kPositive), {});
  CHECK(log.current_a[15] > 0.0);
}

TEST(CellLog, ACounterOfAnotherScaleChangesNoCurrent) {
  // Rows 6 apart in minutes that nobody named: the counter moves 60 times as much as current and seconds say.
  MeasuredTable table = Square{}.table(120);
  table.columns.emplace_back("q");
  table.values.emplace_back();
  double counter = 0.0;
  for (std::size_t row = 0; row < 120; ++row) {
    table.values[0][row] = 6.0 * static_cast<double>(row);
    counter += table.values[1][row] * 6.0 / 60.0 + 1e-4;  // a counter that drifts is a fine one
    table.values[3].push_back(counter);
  }
  automatic.roles["charge_ah"] = {"q"};
  const CellLog log = log_of(table);
  DOUBLES_EQUAL(10.0, log.current_a[15], 1e-9);
  CHECK_FALSE(has_repair(log, "the counter's mean is taken"));
  CHECK(has_repair(log, "time is in min"));
}

TEST(CellLog, HoldIsFoundFromACounter) {
  MeasuredTable table = Square{}.table(2000);
  table.columns.emplace_back("q");
  for (const CurrentHold hold : {CurrentHold::kPrevious, CurrentHold::kNext, CurrentHold::kLinear}) {
    std::vector<double> counter{0.0};
    // Charge of each interval in the way the hold says.
    for (std::size_t row = 1; row < 2000; ++row) {
      const double a = table.values[1][row - 1], b = table.values[1][row];
      const double mean = hold == CurrentHold::kPrevious ? a : hold == CurrentHold::kNext ? b : 0.5 * (a + b);
      counter.push_back(counter.back() + mean / 3600.0);
    }
    table.values.resize(3);
    table.values.push_back(counter);
    automatic.roles["charge_ah"] = {"q"};
    const auto evidence = hold_from_counter(log_of(table));
    LONGS_EQUAL(1, evidence.size());
    CHECK(evidence[0].hold == hold);
  }
  CHECK(hold_from_counter(cell_log_of(Square{}.table(), map_with(DischargeSign::kAuto), {})).empty());
}

TEST(CellLog, WindowKeepsItsRowsOnly) {
  const CellLog log = cell_log_of(Square{}.table(), automatic, {10.0, 39.0, 1, 1});
  LONGS_EQUAL(30, log.rows());
  CHECK(has_repair(log, "30 of 60 rows"));
  STRCMP_CONTAINS("usable rows",
                  complaint([&] { (void)cell_log_of(Square{}.table(), automatic, {1e6, 2e6, 1, 1}); }).c_str());
}

TEST(CellLog, WhereThePublishedVoltageDoesNotFallTheBusIsTaken) {
  MeasuredTable table = Square{}.table();
  table.columns.emplace_back("bus");
  table.values.push_back(table.values[2]);
  for (std::size_t row = 0; row < table.rows(); ++row) table.values[2][row] = 4.0;  // published, of the same battery
  RoleMap map = map_with(DischargeSign::kPositive);
  map.roles["pack_voltage"] = map.roles["voltage"];
  map.roles["bus_voltage"] = {"bus"};
  map.roles.erase("voltage");
  const CellLog by_bus = cell_log_of(table, map, {});
  CHECK(has_repair(by_bus, "bus_voltage is taken"));
  DOUBLES_EQUAL(3.9, by_bus.voltage_v[15], 1e-9);
  // A pack voltage that falls is the battery's, whatever the bus does.
  std::swap(table.values[2], table.values[3]);
  CHECK_FALSE(has_repair(cell_log_of(table, map, {}), "bus_voltage is taken"));
}

// SPDX-License-Identifier: Apache-2.0
// Which cells of a table were read before their row, and when.
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "explain/balances/held_cells.hpp"

#include <CppUTest/TestHarness.h>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index kRows = 3000;
constexpr double kRow_s = 0.1;

/// A drive whose load goes on and off; each cell is read once in `turn_rows`, or at each row where that is 0.
struct Table {
  Recording log;
  std::vector<VectorXd> read_s;  ///< by cell and row: when it was read in truth

  Table(std::mt19937& draw, double turn_rows, bool pack) {
    std::uniform_real_distribution<double> part(0.0, 1.0);
    const int cells = std::uniform_int_distribution<int>(6, 40)(draw);
    const double noise_v = part(draw) < 0.5 ? 0.0 : 1e-3, step_v = part(draw) < 0.5 ? 1e-4 : 1e-3;
    std::normal_distribution<double> noise(0.0, 1.0);
    log.time_s = VectorXd::LinSpaced(kRows, 0.0, kRow_s * (kRows - 1));
    VectorXd current = VectorXd::Zero(kRows);
    for (Index row = 1; row < kRows; ++row)
      current(row) = part(draw) < 0.15 ? 200.0 * part(draw) : current(row - 1) * 0.999;
    add("current", current);
    const auto volts = [&](Index row, double ohm) {
      return 4.0 - 1e-4 * static_cast<double>(row) - ohm * current(row);
    };
    if (pack) {
      VectorXd sum = VectorXd::Zero(kRows);
      for (Index row = 0; row < kRows; ++row)
        sum(row) = std::round((cells * volts(row, 2e-3) + 0.02 * noise(draw)) * 100.0) / 100.0;
      add("pack_voltage", sum);
    }
    for (int cell = 0; cell < cells; ++cell) {
      const double ohm = 2e-3 * (cell == 0 ? 1.8 : 0.95 + 0.1 * part(draw)), phase = part(draw) * turn_rows;
      VectorXd held = VectorXd::Zero(kRows), when = log.time_s;
      double last = -1e9;
      for (Index row = 0; row < kRows; ++row) {
        const double turn = turn_rows > 0.0 ? std::floor((static_cast<double>(row) - phase) / turn_rows)
                                            : static_cast<double>(row);
        const bool fresh = row == 0 || turn > last;
        last = turn;
        held(row) = fresh ? std::round((volts(row, ohm) + noise_v * noise(draw)) / step_v) * step_v : held(row - 1);
        when(row) = fresh ? log.time_s(row) : when(row - 1);
      }
      add("cell_voltage_" + std::to_string(cell + 1), held);
      read_s.push_back(when);
    }
  }

  void add(const std::string& role, const VectorXd& values) {
    log.signals[role] = values;
    log.read_s[role] = log.time_s;
  }
};

}  // namespace

TEST_GROUP(HeldCells) {
  std::mt19937 draw;
  unsigned seed = 1;
  std::string said;
  void setup() override {
    if (const char* given = std::getenv("VOLTLAP_TEST_SEED")) seed = static_cast<unsigned>(std::atoi(given));
    draw.seed(seed);
    said = "VOLTLAP_TEST_SEED=" + std::to_string(seed);
  }
};

TEST(HeldCells, CellsOfTheirRowStayWhatTheyAre) {
  for (int k = 0; k < 20; ++k) {
    Table table(draw, 0.0, k % 2 == 0);
    settle_held_cells(table.log);
    CHECK_TEXT(table.log.cells_at_rows && !table.log.cells_apart && !table.log.pack_is_nearer, said.c_str());
    CHECK_TEXT(table.log.age_s.empty(), said.c_str());
  }
}

TEST(HeldCells, CellsThatAreReadInTurnAreFoundWithTheTimeOfEach) {
  for (int k = 0; k < 20; ++k) {
    const double turn = std::uniform_real_distribution<double>(2.5, 25.0)(draw);
    const std::string where = said + ", turn of " + std::to_string(turn) + " rows";
    Table table(draw, turn, k % 2 == 0);
    settle_held_cells(table.log);
    CHECK_TEXT(table.log.cells_apart, where.c_str());
    CHECK_EQUAL_TEXT(k % 2 == 0, table.log.pack_is_nearer, where.c_str());
    double near = 0.0, all = 0.0;
    for (std::size_t cell = 0; cell < table.read_s.size(); ++cell) {
      const VectorXd& found = table.log.read_s.at("cell_voltage_" + std::to_string(cell + 1));
      for (Index row = 100; row < kRows; ++row) {
        all += 1.0;
        near += std::abs(found(row) + 0.5 * kRow_s - table.read_s[cell](row)) < 1.01 * kRow_s ? 1.0 : 0.0;
        CHECK_TEXT(found(row) <= table.log.time_s(row), where.c_str());
      }
    }
    // One that was read again and is the same does not say so.
    CHECK_TEXT(near > 0.75 * all, (where + ", known " + std::to_string(near / all)).c_str());
  }
}

TEST(HeldCells, FramesOfTheirOwnTimesAreLeftAlone) {
  Table table(draw, 8.0, true);
  table.log.read_s["cell_voltage_2"] = table.read_s[1];
  settle_held_cells(table.log);
  CHECK_FALSE(table.log.cells_at_rows || table.log.cells_apart || table.log.pack_is_nearer);
  CHECK(table.log.age_s.empty());
}

TEST(HeldCells, CoarseStepsOfASlowDischargeAreNoTurn) {
  Table table(draw, 0.0, true);
  for (auto& [role, values] : table.log.signals) {
    for (Index row = 0; row < kRows; ++row) {
      if (role == "current") values(row) = 10.0;
      if (role.starts_with("cell_")) values(row) = std::round((4.0 - 1e-4 * static_cast<double>(row)) * 100.0) / 100.0;
    }
  }
  settle_held_cells(table.log);
  CHECK(table.log.age_s.empty());
}

}  // namespace voltlap::plant

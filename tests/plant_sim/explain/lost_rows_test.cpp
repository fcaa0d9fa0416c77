// SPDX-License-Identifier: Apache-2.0
// Which voltages are left out beside rows of the current that a logger lost.
#include "explain/model/lost_rows.hpp"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Rows of 10 ms, some lost; a cell read every 30 ms, which the rows hold; a load that is switched in the first half.
struct Lossy {
  plant::Recording log;
  VectorXd current_a;
  std::vector<bool> lost_before;
};
Lossy lossy(unsigned seed, double share) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  constexpr Index kRows = 4000;
  constexpr double kRow_s = 0.01, kTurn_s = 0.03;
  std::vector<double> time_s, current, read_s;
  Lossy out;
  bool lost = false;
  const double first_s = kTurn_s * part(random);
  for (Index row = 0; row < kRows; ++row) {
    const double t = kRow_s * static_cast<double>(row);
    if (row > 0 && part(random) < share) {
      lost = true;
      continue;
    }
    time_s.push_back(t);
    current.push_back(row < kRows / 2 && (row / 2) % 2 == 0 ? 100.0 : row < kRows / 2 ? 20.0 : 0.0);
    read_s.push_back(first_s + kTurn_s * std::floor((t - first_s) / kTurn_s));
    out.lost_before.push_back(lost);
    lost = false;
  }
  const auto vector = [](const std::vector<double>& of) {
    return VectorXd(Eigen::Map<const VectorXd>(of.data(), static_cast<Index>(of.size())));
  };
  out.log.time_s = vector(time_s);
  out.current_a = vector(current);
  out.log.signals["cell_voltage_1"] = out.log.signals["temperature_1"] = VectorXd::Constant(out.current_a.size(), 3.7);
  out.log.read_s["cell_voltage_1"] = out.log.read_s["temperature_1"] = vector(read_s);
  return out;
}

/// Was the reading that a row holds read while a row was missing?
bool read_where_lost(const Lossy& of, Index row) {
  const double t = of.log.read_s.at("cell_voltage_1")(row);
  Index after = row;
  while (after > 0 && of.log.time_s(after - 1) >= t) --after;
  return of.lost_before[static_cast<std::size_t>(after)] && of.log.time_s(after) > t;
}

}  // namespace

TEST_GROUP(LostRows){};

TEST(LostRows, AReadingIsLeftOutExactlyWhereARowIsMissingAmidALoadThatChanges) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    const Lossy drawn = lossy(seed, 0.002 * seed);
    plant::Recording log = drawn.log;
    explain::leave_out_lost_rows(log, drawn.current_a);
    for (Index row = 0; row < log.rows(); ++row) {
      const bool driven = log.time_s(row) < 19.8, rests = log.time_s(row) > 20.2;
      if (!driven && !rests) continue;
      const bool left_out = std::isnan(log.signals.at("cell_voltage_1")(row));
      CHECK_EQUAL(driven && read_where_lost(drawn, row), left_out);
      CHECK(std::isfinite(log.signals.at("temperature_1")(row)));
    }
  }
}

TEST(LostRows, RowsThatComeAsTheyLikeLoseNothing) {
  Lossy drawn = lossy(1, 0.4);
  explain::leave_out_lost_rows(drawn.log, drawn.current_a);
  CHECK(drawn.log.signals.at("cell_voltage_1").array().isFinite().all());
}

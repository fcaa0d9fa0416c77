// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/count_hint.hpp"

#include "plant_sim/learn/validate/straight_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// Half a minute of load, a few seconds of less, until seven tenths of the charge are drawn.
std::vector<double> drive() {
  std::vector<double> out;
  for (int k = 0; k < 30; ++k) {
    out.insert(out.end(), 30, 25.0);
    out.insert(out.end(), 10, 5.0);
  }
  return out;
}

}  // namespace

TEST_GROUP(CountHint) {
  const CellModel model{StraightCell::cell()};
  std::optional<std::string> hint(CellLog log, double current, double voltage, const CellCounts& counts) {
    for (double& i : log.current_a) i *= current;
    for (double& v : log.voltage_v) v *= voltage;
    const double rms_v = validate(model.cell(), log, {}).rms_v;
    return count_hint(model, log, {}, counts, rms_v);
  }
};

TEST(CountHint, AForgottenNumberInParallelIsNamed) {
  for (const int n : {2, 5, 8, 13}) {
    const auto said = hint(StraightCell::record(drive()), n, 1.0, {1, 1});
    CHECK(said.has_value());
    STRCMP_CONTAINS(("--cells-in-parallel " + std::to_string(n) + " ").c_str(), said->c_str());
  }
}

TEST(CountHint, AWrongNumberInSeriesIsNamed) {
  const auto said = hint(StraightCell::record(drive()), 1.0, 28.0 / 24.0, {24, 1});
  CHECK(said.has_value());
  STRCMP_CONTAINS("--cells-in-series 28 ", said->c_str());
}

TEST(CountHint, ASoundRecordingAndOneThatNoNumberMendsAreNotSpokenOf) {
  CHECK_FALSE(hint(StraightCell::record(drive()), 1.0, 1.0, {1, 1}).has_value());
  CellLog other = StraightCell::record(drive());
  for (std::size_t row = 0; row < other.rows(); ++row) other.voltage_v[row] += row / 60 % 2 == 0 ? 0.6 : -0.6;
  CHECK_FALSE(hint(other, 1.0, 1.0, {1, 1}).has_value());
}

// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/mean_cell.hpp"

#include <cmath>

#include "core/errors.hpp"
#include "known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(MeanCell) {
  IdentifyOptions options;
  void setup() override { options.branches = 2; }

  /// Cells in series: the plan ends with the smallest, at its SOC 0.
  [[nodiscard]] CellIdentification identified(double capacity_ah, double more_v, double start_soc = 1.0) const {
    KnownCell smallest, cell;
    cell.capacity_ah = capacity_ah;
    cell.noise_v = 2e-4;
    const auto plan = smallest.pulse_plan(33.0, 700, 0.0);
    CellLog log = cell.record(plan, start_soc);
    for (std::size_t row = 0; row < log.rows(); ++row) log.voltage_v[row] -= more_v / 33.0 * log.current_a[row];
    return identify_cell({log}, {30.0}, options);
  }
};

TEST(MeanCell, MeanAndSpreadAreThoseOfTheCellsOnOneScaleOfSoc) {
  constexpr double kMore = 3.3e-3;  // V at 33 A: 0.1 mOhm
  const MeanCell mean =
      mean_cell({identified(30.0, 0.0), identified(30.9, kMore), identified(30.6, 0.5 * kMore, 0.995)},
                {"a", "b", "c"});
  DOUBLES_EQUAL(30.0, mean.capacity_ah[0], 0.05);
  DOUBLES_EQUAL(30.9, mean.capacity_ah[1], 0.1);
  DOUBLES_EQUAL(30.6, mean.capacity_ah[2], 0.1);
  DOUBLES_EQUAL(0.4583, mean.capacity_spread_ah, 0.06);
  const CircuitModel& model = mean.identified.points[0].result.model;
  DOUBLES_EQUAL(KnownCell::r0(0.5) + 0.05e-3, model.r(8, 0), 0.02e-3);
  const Eigen::VectorXd& spread = mean.spread[0];
  DOUBLES_EQUAL(0.05e-3 / model.r(8, 0), spread(model.em.size() + 8), 0.01);
  for (const double soc : {0.1, 0.3, 0.5, 0.8}) {
    CHECK(model.ocv.value(spread.head(model.em.size()), soc) < 2e-3);
    DOUBLES_EQUAL(KnownCell::em(soc), model.ocv.value(model.em, soc), 3e-3);
  }
}

TEST(MeanCell, CellsOfOtherTestsAreRefused) {
  CellIdentification two = identified(30.0, 0.0);
  two.temperatures_c.push_back(40.0);
  CHECK_THROWS(InputError, mean_cell({identified(30.0, 0.0), two}, {"a", "b"}));
}

TEST(MeanCell, CellIsNamedByTheEndOfItsFile) {
  STRCMP_EQUAL("cell12", cell_of_file("some/30c_200a_cell12.csv.gz").c_str());
  STRCMP_EQUAL("", cell_of_file("cell_12/hppc.csv").c_str());
}

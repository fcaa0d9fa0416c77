// SPDX-License-Identifier: Apache-2.0
// Short form of ./voltlap known-truth: the full fit on the bench's data, with its marks.
#include <cmath>

#include "comparison.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::known_truth;

namespace {

Case noisy() {
  return {{"instruments.systematic=false", "box.mode=bath"}, "pulse_long_rests"};
}

Tally tally_of(const Case& one, int seeds) {
  Tally tally;
  for (int k = 0; k < seeds; ++k)
    tally.add(run_case(one, static_cast<std::uint64_t>(k) + 1, 0, static_cast<std::size_t>(k) % 4));
  return tally;
}

/// What 95 % may look like with few seeds: two standard errors less. `spread`: of the share that one seed covers, which
/// 200 seeds show (its nodes err together, so that seeds count, not nodes).
double least_covered(double spread, int seeds) { return 0.95 - 2.0 * spread / std::sqrt(seeds); }

}  // namespace

TEST_GROUP(KnownTruth){};

TEST(KnownTruth, ExcitedNodesAreWithinTheMarksAndNineTenthsOfAllAreExcited) {
  const Tally tally = tally_of(noisy(), 8);
  const Tally::Row all = tally.all();
  LONGS_EQUAL(8, tally.by_evidence);
  CHECK(all.excited >= 0.9 * all.nodes);
  CHECK_TEXT(all.within >= 0.99 * all.excited, text_of(tally).c_str());
  CHECK_TEXT(all.covered >= least_covered(0.032, 8) * all.excited, text_of(tally).c_str());
}

TEST(KnownTruth, IntervalsCoverCurvesThatTablesOfStraightLinesCannotFollow) {
  Case one = noisy();
  one.cell = VOLTLAP_KNOWN_CELLS "/rough.toml";
  const Tally tally = tally_of(one, 6);
  CHECK_TEXT(tally.all().covered_all >= least_covered(0.043, 6) * tally.all().nodes, text_of(tally).c_str());
}

TEST(KnownTruth, MeanSquareErrorIsTheInstrumentsNoise) {
  // As shipped: eight readings a row, each with 1.5 mV of noise and a step of 1.5 mV; under load the noise of the
  // current through R0 comes on top, for a fiftieth of the time.
  const double floor = (1.5e-3 * 1.5e-3) * (1.0 + 1.0 / 12.0) / 8.0;
  const Tally tally = tally_of(noisy(), 2);
  DOUBLES_EQUAL(1.0, tally.mean_square_v2 / tally.outcomes / floor, 0.05);
}

TEST(KnownTruth, LastingErrorsOfTheInstrumentsWidenTheIntervalsUntilTheyCover) {
  Case one = noisy();
  one.settings[0] = "instruments.systematic=true";
  const Tally::Row untold = tally_of(one, 6).all();
  one.limits_stated = true;
  const Tally::Row told = tally_of(one, 6).all();
  CHECK(untold.covered_all < 0.8 * untold.nodes);
  CHECK(told.covered_all >= 0.9 * told.nodes);
}

// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/preparation/steep_ends.hpp"

#include "learn/identify/fit/model_selection.hpp"
#include "learn/identify/preparation/prepared_log.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"
#include "plant_sim/learn/identify/laws_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// Pulses to the end, of a cell whose voltage falls by 1.5 V over the last hundredth.
MeasuredRun steep_run(double soc_error) {
  KnownCell cell;
  const std::vector<double> plan = cell.pulse_plan(33.0, 600, 0.0);
  CellLog log = cell.record(plan);
  double soc = 1.0;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    soc -= log.current_a[row] / (3600.0 * cell.capacity_ah);
    log.voltage_v[row] -= 1.5 * std::exp(-(soc + soc_error) / 0.01);
  }
  RunOptions options;
  options.capacity_ah = span_ah(log, 0, CurrentHold::kNext);
  return averaged(make_run(log, options));
}

FitPriors priors_for() {
  FitPriors priors;
  priors.resistance_scale = 2e-3;
  return priors;
}

}  // namespace

TEST_GROUP(SteepEnds) {};

TEST(SteepEnds, CountLessWhereTwoRecordingsDisagreeThereAndAsBeforeElsewhere) {
  const std::vector<MeasuredRun> before{steep_run(0.0), steep_run(0.004)};
  std::vector<MeasuredRun> runs = before;
  discount_steep_ends(runs, priors_for());
  double least = 1.0;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    for (Eigen::Index row = 0; row < runs[k].rows(); ++row) {
      if (before[k].weight_s(row) <= 0.0) continue;
      const double share = runs[k].weight_s(row) / before[k].weight_s(row);
      if (runs[k].soc(row) > 0.3) DOUBLES_EQUAL(1.0, share, 1e-12);
      least = std::min(least, share);
    }
  }
  CHECK(least < 0.2);
}

TEST(SteepEnds, OfACellThatIsNotSteepChangeNothing) {
  LawsCell cell;
  const CellLog log = cell.record(cell.pulses({1.0}), 25.0);
  RunOptions options;
  options.capacity_ah = span_ah(log, 0, CurrentHold::kNext);
  std::vector<MeasuredRun> runs{averaged(make_run(log, options))};
  const Eigen::VectorXd before = runs[0].weight_s;
  discount_steep_ends(runs, priors_for());
  DOUBLES_EQUAL(0.0, (runs[0].weight_s - before).cwiseAbs().maxCoeff(), 0.0);
}

TEST_GROUP(PlainCircuit) {
  /// Of a cell's pulses.
  static PlainScore score(const CellLog& log, double resistance_ohm) {
    RunOptions options;
    options.capacity_ah = span_ah(log, 0, CurrentHold::kNext);
    FitPriors priors;
    priors.resistance_scale = resistance_ohm;
    priors.noise_v2_s = 1e-6;
    return score_plain({averaged(make_run(log, options))}, Eigen::Vector2d(15.0, 250.0), priors);
  }
};

TEST(PlainCircuit, IsEnoughForACellWhoseResistancesAreTheSameForAllSoc) {
  LawsCell cell;
  cell.tau1_s = 15.0;
  const PlainScore found = score(cell.record(cell.pulses({1.0, 2.0}), 25.0), cell.r0_ohm);
  CHECK_TEXT(found.is_enough, (StringFromFormat("%g %g", found.plain_v, found.tables_v)).asCharString());
}

TEST(PlainCircuit, IsNotEnoughWhereTheyRiseTowardsEmpty) {
  KnownCell cell;
  const PlainScore found = score(cell.record(cell.pulse_plan(33.0, 600, 0.0)), 2e-3);
  CHECK_FALSE(found.is_enough);
  CHECK(found.plain_v > found.tables_v);
}

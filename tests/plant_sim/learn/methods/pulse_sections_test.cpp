// SPDX-License-Identifier: Apache-2.0
#include "learn/methods/pulse_sections.hpp"

#include <cmath>

#include "core/errors.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(PulseSections) {
  KnownCell cell;
  [[nodiscard]] MeasuredRun run_of(const std::vector<double>& plan) const {
    RunOptions options;
    options.capacity_ah = cell.capacity_ah;
    return make_run(cell.record(plan), options);
  }
  [[nodiscard]] static NodeTable truth_at(double before, double after) {
    NodeTable table{{before, after}, Eigen::MatrixXd(2, kParameterColumns)};
    for (Eigen::Index node = 0; node < 2; ++node) {
      const double s = table.soc[static_cast<std::size_t>(node)];
      table.values.row(node) << KnownCell::em(s), std::log(KnownCell::r0(s)), std::log(KnownCell::r1(s)),
          std::log(KnownCell::r2(s)), std::log(KnownCell::tau1(s)), std::log(KnownCell::tau2(s));
    }
    return table;
  }
};

TEST(PulseSections, EachPulseIsASectionThatEndsWhereTheNextBegins) {
  const MeasuredRun run = run_of(cell.pulse_plan(33.0, 500, 0.0));
  const auto sections = pulse_sections(run);
  LONGS_EQUAL(4 + 6 + 4, sections.size());
  DOUBLES_EQUAL(1.0, sections.front().soc_before, 1e-9);
  DOUBLES_EQUAL(0.95, sections.front().soc_after, 2e-3);
  for (std::size_t k = 1; k < sections.size(); ++k) {
    LONGS_EQUAL(sections[k - 1].last - 1, sections[k].first);
    DOUBLES_EQUAL(0.0, run.current_a(sections[k].first), 0.0);
    CHECK(run.current_a(sections[k].first + 1) > 0.0);
    CHECK(run.current_a(sections[k].load_end - 1) > 0.0);
    DOUBLES_EQUAL(0.0, run.current_a(sections[k].load_end), 0.0);
  }
}

TEST(PulseSections, ShortPulsesBelongToTheSectionOfTheStepBehindThem) {
  std::vector<double> plan(100, 0.0);
  for (int k = 0; k < 5; ++k) {
    plan.insert(plan.end(), 10, 60.0);
    plan.insert(plan.end(), 100, 0.0);
    plan.insert(plan.end(), 10, -45.0);
    plan.insert(plan.end(), 100, 0.0);
    plan.insert(plan.end(), 320, 33.0);
    plan.insert(plan.end(), 300, 0.0);
  }
  LONGS_EQUAL(5, pulse_sections(run_of(plan)).size());
}

TEST(PulseSections, DriveWithoutRestsAndPulsesBothWaysAreRefused) {
  std::vector<double> drive;
  for (int k = 0; k < 2000; ++k) drive.push_back(20.0 + 15.0 * std::sin(0.1 * k));
  CHECK_THROWS(InputError, pulse_sections(run_of(drive)));
  std::vector<double> both(100, 0.0);
  for (int k = 0; k < 6; ++k) {
    both.insert(both.end(), 300, k % 3 == 2 ? -33.0 : 33.0);
    both.insert(both.end(), 300, 0.0);
  }
  CHECK_THROWS(InputError, pulse_sections(run_of(both)));
}

TEST(PulseSections, TimeConstantsOfARelaxationAreFound) {
  MeasuredRun rest = run_of(std::vector<double>(1500, 0.0));
  for (Eigen::Index k = 0; k < rest.rows(); ++k) {
    const auto t = static_cast<double>(k);
    rest.voltage_v(k) = 3.7 - 0.02 * std::exp(-t / 20.0) - 0.03 * std::exp(-t / 180.0);
  }
  const Eigen::Vector2d taus = relaxation_taus(rest, 0, rest.rows());
  DOUBLES_EQUAL(20.0, taus(0), 1.0);
  DOUBLES_EQUAL(180.0, taus(1), 5.0);
}

TEST(PulseSections, FreeValuesOfASectionAreRecoveredAndFixedOnesStay) {
  const MeasuredRun run = run_of(cell.pulse_plan(33.0, 900, 0.0));
  const PulseSection section = pulse_sections(run)[6];  // 60 to 50 %: nodes of the truth
  const NodeTable truth = truth_at(section.soc_before, section.soc_after);
  NodeTable start = truth;
  start.values.rightCols(5).array() += 0.2;
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> free =
      Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>::Constant(2, kParameterColumns, true);
  free.col(kEm) = false;
  const MeasuredRun part = part_of(run, section.first, section.last);
  // What the pulses before have left on the branches.
  Eigen::VectorXd before;
  NodeTable all{{1.0, section.soc_before}, Eigen::MatrixXd(2, kParameterColumns)};
  all.values.row(0) = all.values.row(1) = truth.values.row(0);
  (void)simulate(all.model(), part_of(run, 0, section.first + 1), Eigen::Vector2d::Zero(), &before);
  const NodeTable found = fit_section(part, start, free, before).table;
  DOUBLES_EQUAL(truth.values(0, kEm), found.values(0, kEm), 0.0);
  DOUBLES_EQUAL(truth.values(0, kLnR0), found.values(0, kLnR0), 0.02);
  DOUBLES_EQUAL(truth.values(1, kLnR1), found.values(1, kLnR1), 0.2);
  DOUBLES_EQUAL(truth.values(1, kLnTau2), found.values(1, kLnTau2), 0.2);
}

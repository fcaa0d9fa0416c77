// SPDX-License-Identifier: Apache-2.0
// References that foresee each other are believed, those that do not are believed less, and a cause whose signature no
// shape has keeps its weight.
#include "discrepancy/trust.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double kRows = 1000.0;

/// Two shapes of the cells' voltage (0: at once, 1: late) and a cause that is nearly the first and one that is neither.
Design design_of_four() {
  Design out;
  out.comparison.channels.push_back({"voltage", Balance::kVoltage, "V", VectorXd()});
  out.base.battery.temperature_c = VectorXd::Constant(3, 25.0);
  for (int k = 0; k < 4; ++k) {
    Column column;
    column.cause = k < 2 ? -1 : k - 2;
    column.kin = k == 1 ? 5 : 1;  // the open-circuit voltage; the resistance
    column.usual = 1.0;
    column.effect.assign(1, VectorXd::Ones(3));
    out.columns.push_back(column);
  }
  return out;
}

/// A log whose residual is these amounts of the columns.
BlockSum said(const VectorXd& amounts) {
  BlockSum out = empty_sum(4);
  out.gram = MatrixXd::Identity(4, 4);
  out.gram(0, 2) = out.gram(2, 0) = 0.9;
  out.gram *= kRows;
  out.score = out.gram * amounts;
  out.energy = amounts.dot(out.score) + kRows;
  out.rows = kRows;
  return out;
}

}  // namespace

TEST_GROUP(Trust) {
  Design design = design_of_four();
  Knowledge knowledge;
  System system;
  std::vector<BlockSum> log{said(VectorXd::Zero(4))};

  /// Amounts of the shape at once and of the late one in three references; all are expected to be 0.01.
  TrustProblem problem(const std::vector<std::pair<double, double>>& amounts) {
    system.prior_variance = VectorXd::Constant(4, 9.0);
    for (int cause = 0; cause < 2; ++cause) {
      Candidate candidate;
      candidate.cause = cause;
      candidate.rows = {cause + 2};
      system.candidates.push_back(candidate);
    }
    const MatrixXd shapes = VectorXd({{1e-4, 1e-4, 0.0, 0.0}}).asDiagonal();
    knowledge.of_all = {VectorXd::Zero(4), shapes, {}};
    for (const auto& [at_once, late] : amounts) {
      knowledge.designs.push_back(&design);
      knowledge.said.push_back({said(VectorXd({{at_once, late, 0.0, 0.0}}))});
      knowledge.of_the_others.push_back(knowledge.of_all);
    }
    return {design, log, knowledge, system};
  }
};

TEST(Trust, ReferencesThatForeseeEachOtherAreWidenedLeast) {
  const auto widening = widening_by_references(problem({{0.01, 0.01}, {-0.01, 0.0}, {0.0, -0.01}}));
  DOUBLES_EQUAL(3.0, widening[0][1], 0.0);
  DOUBLES_EQUAL(3.0, widening[0][5], 0.0);
}

TEST(Trust, WhatReferencesDoNotForeseeIsWidenedWhereItIs) {
  const auto widening = widening_by_references(problem({{0.2, 0.01}, {-0.2, 0.0}, {0.15, -0.01}}));
  CHECK(widening[0][1] > 3.0);
  DOUBLES_EQUAL(3.0, widening[0][5], 0.0);
}

TEST(Trust, ACauseThatNoShapeHasKeepsItsWeightWhereShapesAreWidened) {
  const TrustProblem asked = problem({{0.2, 0.01}, {-0.2, 0.0}, {0.15, -0.01}});
  Trust trust = full_trust(1);
  const VectorXd before = remaining(log[0], usual_shapes(design, knowledge, trust)).information.diagonal();
  trust.widening = widening_by_references(asked);
  const VectorXd after = remaining(log[0], usual_shapes(design, knowledge, trust)).information.diagonal();
  CHECK(after(2) < 0.8 * before(2));
  DOUBLES_EQUAL(before(3), after(3), 1e-9 * before(3));
  Usual nothing_seen;
  nothing_seen.seen = VectorXd::Zero(4);
  CHECK(evidence_of_references(asked, nothing_seen, trust) < 0.2 * evidence_of_references(asked, nothing_seen, full_trust(1)));
}

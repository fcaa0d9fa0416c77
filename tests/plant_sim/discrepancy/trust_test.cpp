// SPDX-License-Identifier: Apache-2.0
// References that foresee each other are believed, a channel in which they seem to show causes counts less, and a cause
// whose signature no shape has keeps its weight.
#include "discrepancy/trust.hpp"

#include <CppUTest/TestHarness.h>

#include <array>

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

  /// Amounts of the shape at once, of the late one and of the cause that no shape has in three references; those of the
  /// shapes are expected to be 0.01.
  TrustProblem problem(const std::vector<std::array<double, 3>>& amounts) {
    system.prior_variance = VectorXd::Constant(4, 9.0);
    for (int cause = 0; cause < 2; ++cause) {
      Candidate candidate;
      candidate.cause = cause;
      candidate.rows = {cause + 2};
      system.candidates.push_back(candidate);
    }
    const MatrixXd shapes = VectorXd({{1e-4, 1e-4, 0.0, 0.0}}).asDiagonal();
    knowledge.of_all = {VectorXd::Zero(4), shapes, {}};
    for (const auto& [at_once, late, cause] : amounts) {
      knowledge.designs.push_back(&design);
      knowledge.said.push_back({said(VectorXd({{at_once, late, 0.0, cause}}))});
      knowledge.of_the_others.push_back(knowledge.of_all);
    }
    return {design, log, knowledge, system};
  }

  static Usual nothing_seen() {
    Usual out;
    out.seen = VectorXd::Zero(4);
    return out;
  }
};

TEST(Trust, ReferencesThatForeseeEachOtherInflateNothing) {
  const TrustProblem asked = problem({{0.01, 0.01, 0.0}, {-0.01, 0.0, 0.0}, {0.0, -0.01, 0.0}});
  DOUBLES_EQUAL(1.0, inflation_by_references(asked, nothing_seen())[0], 0.0);
}

TEST(Trust, AReferenceThatSeemsToShowACauseInflatesTheNoiseUntilItShowsNone) {
  const TrustProblem asked = problem({{0.01, 0.01, 0.3}, {-0.01, 0.0, 0.0}, {0.0, -0.01, 0.0}});
  const Usual usual = nothing_seen();
  const std::vector<double> inflation = inflation_by_references(asked, usual);
  CHECK(inflation[0] > 3.0);
  CHECK(evidence_of_references(asked, usual, inflation) < 0.3 * evidence_of_references(asked, usual, {1.0}));
}

TEST(Trust, WhatReferencesShowOfAllCellsIsNotShownOfOthers) {
  const TrustProblem asked = problem({{0.01, 0.01, 0.3}, {-0.01, 0.0, 0.0}, {0.0, -0.01, 0.0}});
  system.candidates[1].of_all_cells = true;
  const Usual usual = nothing_seen();
  CHECK(evidence_of_references(asked, usual, {1.0}) > 10.0);
  DOUBLES_EQUAL(0.0, evidence_of_references(asked, usual, {1.0}, -1, Asked::kNotOfAllCells), 0.0);
}

TEST(Trust, ACauseThatNoShapeHasKeepsItsWeight) {
  problem({{0.2, 0.01, 0.0}, {-0.2, 0.0, 0.0}, {0.15, -0.01, 0.0}});
  const VectorXd left = remaining(log[0], usual_shapes(design, log, knowledge, {1.0})).information.diagonal();
  CHECK(left(2) < 0.5 * kRows);  // nearly a shape that changes from log to log
  DOUBLES_EQUAL(kRows, left(3), 1e-9 * kRows);
}

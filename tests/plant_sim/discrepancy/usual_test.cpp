// SPDX-License-Identifier: Apache-2.0
// What references say of the members of a group: as many as a few logs can say, and not more than chance lets them.
#include "discrepancy/usual.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_GROUP(Usual) {
  Design design;
  Score score;
  std::vector<Reference> references;

  /// Four cells with one shape each, known to a tenth in a log; in three references it differs by these standard errors.
  double inflation(const VectorXd& apart) {
    Group cells;
    cells.stem = "cell_voltage_";
    cells.members = {"cell_voltage_1", "cell_voltage_2", "cell_voltage_3", "cell_voltage_4"};
    design.comparison.groups = {cells};
    Shape shape;
    shape.spread = 1.0;
    shape.repeats = 1e-4;
    design.shapes = {{shape}};
    const GroupScore known{MatrixXd::Constant(1, 1, 100.0), MatrixXd::Zero(1, 4), VectorXd::Zero(4), 100.0};
    score.groups = {known};
    references.clear();
    for (const double by : apart) {
      Score theirs = score;
      theirs.groups[0].score.setConstant(10.0 * by);
      references.push_back({&design, theirs});
    }
    return group_spread(design, score, references).group_inflation[0];
  }
};

TEST(Usual, MembersThatRepeatCountInFull) {
  DOUBLES_EQUAL(1.0, inflation(VectorXd({{0.0, 0.0, 0.0}})), 0.0);
}

TEST(Usual, WhatChanceLetsAFewReferencesShowIsNoSurprise) {
  DOUBLES_EQUAL(1.0, inflation(VectorXd({{1.6, -1.6, 0.0}})), 0.0);
}

TEST(Usual, MembersThatDoNotRepeatCountLess) {
  CHECK(inflation(VectorXd({{6.0, -6.0, 0.0}})) > 3.0);
}

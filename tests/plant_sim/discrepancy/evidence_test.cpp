// SPDX-License-Identifier: Apache-2.0
// Sets are weighed by what they explain, and only where the residual has room for their effect.
#include "discrepancy/evidence.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_GROUP(Evidence) {
  /// One cause that fits with ten typical sizes.
  static System of_one_cause() {
    System out;
    Candidate cause;
    cause.cause = 0;
    cause.rows = {0};
    out.candidates.push_back(cause);
    out.information = MatrixXd::Constant(1, 1, 1e4);
    out.score = VectorXd::Constant(1, 1e5);
    out.prior_variance = VectorXd::Constant(1, 9.0);
    return out;
  }
};

TEST(Evidence, AnEffectThatTheResidualHasNoRoomForIsNoExplanation) {
  System system = of_one_cause();
  CHECK(best_evidence(system) > 1e5);
  system.bounds.push_back({MatrixXd::Constant(1, 1, 2.0), 250.0});  // the effect's square is 200
  CHECK(best_evidence(system) > 1e5);
  system.bounds[0].most = 150.0;
  DOUBLES_EQUAL(0.0, best_evidence(system), 0.0);
  LONGS_EQUAL(0, weigh_sets(system, 10).size());
}

TEST(Evidence, IsTemperedByWhatTheBestSetGainsNotByWhatManyColumnsTakeOfTheNoise) {
  constexpr int kColumns = 12;
  System system;
  system.information = 100.0 * MatrixXd::Identity(kColumns + 1, kColumns + 1);
  system.score = VectorXd::Constant(kColumns + 1, 10.0);  // one standard error each
  system.prior_variance = VectorXd::Constant(kColumns + 1, 9.0);
  for (int cause = 0; cause < 2; ++cause) {
    Candidate candidate;
    candidate.cause = cause;
    for (int k = cause == 0 ? 0 : 1; k < (cause == 0 ? 1 : kColumns + 1); ++k) candidate.rows.push_back(k);
    system.candidates.push_back(candidate);
  }
  constexpr double kError = 0.01;
  const double gain = 1.0 / (1.0 + 1.0 / 900.0);
  DOUBLES_EQUAL(100.0 / (1.0 + kError * gain), tempered(system, 0.0, kError).information(0, 0), 1e-9);
  system.score(0) = 1e3;  // a hundred standard errors
  DOUBLES_EQUAL(100.0 / (1.0 + kError * 1e4 * gain), tempered(system, 0.0, kError).information(0, 0), 1e-9);
}

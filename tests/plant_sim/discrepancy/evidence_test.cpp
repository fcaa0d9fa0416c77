// SPDX-License-Identifier: Apache-2.0
// Sets are weighed by what they explain, and only where the residual has room for their effect.
#include "discrepancy/evidence.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>

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

TEST(Evidence, OfASizeThatHasTheWrongSignThereIsNone) {
  System system = of_one_cause();
  system.candidates[0].signs = {1};
  CHECK(best_evidence(system) > 1e5);
  system.candidates[0].signs = {-1};
  DOUBLES_EQUAL(0.0, best_evidence(system), 0.0);
  LONGS_EQUAL(0, weigh_sets(system, 10).size());
  system.score(0) *= -1.0;
  CHECK(best_evidence(system) > 1e5);
}

TEST(Evidence, OfAnEffectThatIsToldSmallIsNotLessForBeingSmall) {
  const auto at_six_errors = [](double information) {
    System system = of_one_cause();
    system.information(0, 0) = information;
    system.score(0) = 6.0 * std::sqrt(information);
    return best_evidence(system);
  };
  // 18 for what it explains, ln 20 for where in twenty errors it lies, ln 40 for which cause it is.
  const double known = 18.0 / (1.0 + 1.0 / 400.0) - 0.5 * std::log(401.0) - std::log(40.0);
  DOUBLES_EQUAL(known, at_six_errors(1e4), 1e-9);
  DOUBLES_EQUAL(known, at_six_errors(1e8), 1e-9);
  // Known badly, the cause's own sizes bound it: half a typical size each error, three typical sizes the prior.
  DOUBLES_EQUAL(18.0 / (1.0 + 1.0 / 36.0) - 0.5 * std::log(37.0) - std::log(40.0), at_six_errors(4.0), 1e-9);
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
  const double gain = 1.0 / (1.0 + 1.0 / 400.0);  // of a size that may be twenty standard errors
  DOUBLES_EQUAL(100.0 / (1.0 + kError * gain), tempered(system, 0.0, kError).information(0, 0), 1e-9);
  system.score(0) = 1e3;  // a hundred standard errors
  DOUBLES_EQUAL(100.0 / (1.0 + kError * 1e4 * gain), tempered(system, 0.0, kError).information(0, 0), 1e-9);
}

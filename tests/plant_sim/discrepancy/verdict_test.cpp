// SPDX-License-Identifier: Apache-2.0
// A larger set is the answer only when it is ahead by what sound logs seldom show.
#include "discrepancy/verdict.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>

using namespace voltlap::plant;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_GROUP(Verdict) {
  /// Members of the answer where two causes together are ahead of the first alone by `ahead`.
  static Decision decided(double ahead) {
    System system;
    system.information = 100.0 * MatrixXd::Identity(2, 2);
    system.score = VectorXd({{100.0, 30.0}});
    system.prior_variance = VectorXd::Constant(2, 9.0);
    for (int cause = 0; cause < 2; ++cause) {
      Candidate candidate;
      candidate.cause = cause;
      candidate.rows = {cause};
      system.candidates.push_back(candidate);
    }
    return choose(system, {{{0, 1}, 40.0 + ahead, true}, {{0}, 40.0, true}, {{1}, 2.0, true}});
  }
};

TEST(Verdict, ASecondCauseThatASoundLogCouldShowIsLeftOut) {
  const Decision decision = decided(kLarger - 0.1);
  LONGS_EQUAL(1, decision.members.size());
  LONGS_EQUAL(0, decision.members[0]);
  DOUBLES_EQUAL(kLarger - 0.1, decision.next_gain, 1e-9);
}

TEST(Verdict, ASecondCauseThatIsFarAheadIsPartOfTheAnswer) {
  LONGS_EQUAL(2, decided(kLarger + 0.1).members.size());
}

TEST(Verdict, TwiceTheEvidenceOfLn20IsAsked) {
  DOUBLES_EQUAL(2.0 * std::log(20.0), kLarger, 1e-6);
}

/// Many causes of which one stands out by some standard errors.
static System of_causes(bool of_all_cells) {
  constexpr int kCauses = 12;
  System system;
  system.information = 100.0 * MatrixXd::Identity(kCauses, kCauses);
  system.score = VectorXd::Zero(kCauses);
  system.prior_variance = VectorXd::Constant(kCauses, 9.0);
  for (int cause = 0; cause < kCauses; ++cause) {
    Candidate candidate;
    candidate.cause = cause;
    candidate.rows = {cause};
    candidate.of_all_cells = of_all_cells;
    system.candidates.push_back(candidate);
  }
  return system;
}

static void is_answered_at_one_in_200(System system, double freedom) {
  constexpr int kDraws = 8000;
  int answered = 0, close = 0;
  for (double errors = 3.0; errors < 6.0; errors += 0.05) {
    system.score(0) = 10.0 * errors;
    const auto sets = weigh_sets(system, 10);
    const Decision decision = decide(system, sets, kDraws, 1);
    const double null = null_probability(system, sets[0].evidence, freedom, kDraws, 1);
    if (sets[0].evidence <= 0.0 || (null > 1.0 / 260.0 && null < 1.0 / 150.0)) continue;  // 8000 draws tell no more
    CHECK_EQUAL(null <= 1.0 / 200.0, !decision.members.empty());
    answered += decision.members.empty() ? 0 : 1;
    close += null > 1.0 / 200.0 && null < 1.0 / 100.0 ? 1 : 0;
  }
  CHECK(answered > 0);
  CHECK(close > 0);
}

TEST(Verdict, AnAnswerIsGivenWhereChanceReachesItInOneSoundLogOf200) {
  is_answered_at_one_in_200(of_causes(false), 20.0);
}

TEST(Verdict, ChanceReachesFurtherInTheVoltageAndChargeThatAllCellsShare) {
  is_answered_at_one_in_200(of_causes(true), 14.0);
}

// SPDX-License-Identifier: Apache-2.0
// What is said of what stands out of the noise and makes no error smaller.
#include "discrepancy/findings.hpp"

#include <CppUTest/TestHarness.h>

#include "judged_log.hpp"

using namespace voltlap::plant;

TEST_GROUP_BASE(Findings, JudgedLog) {
  /// The verdict where the shape is a fiftieth of the noise, and the error `times` that of the only reference.
  Explanation said_of(double times, Balance of = Balance::kVoltage) {
    decision.members = {2};
    decision.anonymous = true;
    sets = {{{2}, 20.0, false}};
    system.candidates[2].balance = of;
    const Judged judged = judged_of(0.0, 0.02 * kNoise);
    Design sound;
    sound.comparison.channels = design.comparison.channels;
    sound.residual = {design.residual[0] / times, design.residual[1]};
    Explanation out;
    out.with_references = true;
    put_verdict(judged, {{&sound, {}}}, {}, out);
    return out;
  }
};

TEST(Findings, AnErrorLikeTheReferencesIsTheirs) {
  CHECK(said_of(1.9).verdict == Verdict::kNoDiscrepancy);
}

TEST(Findings, AnErrorTwiceThatOfAnyReferenceIsNotNothing) {
  const Explanation said = said_of(2.1);
  CHECK(said.verdict == Verdict::kUnknown);
  CHECK(said.unknown_in == Balance::kVoltage);
  STRCMP_CONTAINS("voltage error is 2.1 times that of any reference", said.sentence.c_str());
}

TEST(Findings, AnErrorInAnotherBalanceIsNotWhatStandsOut) {
  CHECK(said_of(2.1, Balance::kHeat).verdict == Verdict::kNoDiscrepancy);
}

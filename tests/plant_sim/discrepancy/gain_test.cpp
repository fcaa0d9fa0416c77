// SPDX-License-Identifier: Apache-2.0
// What pays: a set that makes the plain error smaller, not only the weighed one.
#include "discrepancy/gain.hpp"

#include <CppUTest/TestHarness.h>

#include "judged_log.hpp"

using namespace voltlap::plant;

TEST_GROUP_BASE(Pays, JudgedLog) {
  Pays pays_of(double amount, double usually, std::size_t candidate, const std::vector<std::size_t>& beside = {}) {
    return pays(judged_of(amount, usually), {candidate}, beside);
  }

  bool plainly(double amount, double usually, std::size_t candidate, const std::vector<std::size_t>& beside = {}) {
    return pays_of(amount, usually, candidate, beside) == Pays::kPlainly;
  }
};

TEST(Pays, AnEffectAsLargeAsTheNoisePaysAndAFiftiethOfItDoesNot) {
  CHECK(plainly(kNoise, 0.0, 0));
  CHECK(pays_of(0.02 * kNoise, 0.0, 0) == Pays::kNot);
}

TEST(Pays, WhatReferencesKnowIsTakenAwayFirst) {
  const double much = 10.0 * kNoise;  // beside it the effect is one in a hundred of the squares
  CHECK_FALSE(plainly(kNoise, much, 0));
  usual.mean(2) = much;
  CHECK(plainly(kNoise, much, 0));
}

TEST(Pays, BetweenTwoSensorsNoErrorOfAModelStands) {
  CHECK(plainly(0.0, 0.0, 1));
}

TEST(Pays, AShapeWithoutANameHasToPayToo) {
  CHECK_FALSE(plainly(0.0, 0.02 * kNoise, 2));
  CHECK(plainly(0.0, kNoise, 2));
}

TEST(Pays, BesideAnotherCauseOnlyWhatThatOneLeavesCounts) {
  // Ten parts of one beside two of the other: alone the small one is lost, beside the large one it pays.
  CHECK_FALSE(plainly(10.0 * kNoise, 2.0 * kNoise, 2));
  CHECK(plainly(10.0 * kNoise, 2.0 * kNoise, 2, {0}));
  CHECK_FALSE(plainly(10.0 * kNoise, 0.02 * kNoise, 2, {0}));
}

TEST(Pays, AFastEffectInASlowErrorPaysOnceTheSlowIsFilteredOut) {
  const double slow = 10.0 * kNoise, fast = 0.2 * kNoise;  // one in 2500 of the squares
  known["voltage"] = {kNoise, slow, 30.0, 0.0};
  CHECK(pays_of(fast, slow, 0) == Pays::kInNoise);
  CHECK(pays_of(0.02 * kNoise, slow, 0) == Pays::kNot);
}

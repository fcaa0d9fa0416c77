// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/search.hpp"

#include <CppUTest/TestHarness.h>

#include <utility>
#include <vector>

#include "wave_family.hpp"

namespace voltlap::explain {
namespace {

std::vector<plant::Cause> cause_of(plant::Balance balance) {
  plant::Cause cause{};
  cause.name = "wave";
  cause.balance = balance;
  cause.parameters = {{"size", "1", -100.0, 100.0, 1.0}};
  return {cause};
}

/// The set of that cause alone, where `low` to `high` is believed of its size.
Set alone(double wave, double low, double high) {
  SimulatedChannel made(1);
  made.add_white(0.1);
  made.add(wave * made.wave());
  const Family family = family_of(made, "voltage");
  std::vector<plant::Cause> causes = cause_of(plant::Balance::kVoltage);
  causes[0].parameters[0].low = low;
  causes[0].parameters[0].high = high;
  Search search(family, causes);
  return search.of({0});
}

bool stands(double wave, double slow, const char* channel, plant::Balance balance, unsigned seed,
            std::vector<double> asked = {}) {
  SimulatedChannel made(seed);
  made.add_white(0.1);
  made.add_slow(slow);
  made.add(wave * made.wave());
  Family family = family_of(made, channel);
  family.asked = std::move(asked);
  const std::vector<plant::Cause> causes = cause_of(balance);
  Search search(family, causes);
  const Set& set = search.of({0});
  CHECK_TEXT(set.lead.decisive, "the minutes that were not fitted tell it for sure");
  return set.stands && is_of_use(family, set);
}

}  // namespace

TEST_GROUP(Search){};

TEST(Search, ASmallPartOfALargeErrorIsNoAnswer) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CHECK(stands(3.0, 0.5, "voltage", plant::Balance::kVoltage, seed));
    CHECK_FALSE(stands(3.0, 20.0, "voltage", plant::Balance::kVoltage, seed));
  }
}

TEST(Search, WhatIsNotWorthAWordIsNoAnswerHoweverSure) {
  CHECK(stands(1.5, 0.1, "voltage", plant::Balance::kVoltage, 1));
  CHECK_FALSE(stands(0.8, 0.1, "voltage", plant::Balance::kVoltage, 1));  // RMS 0.57 practical sizes
}

TEST(Search, MoreIsAskedWhereNoSoundLogTellsHowWellTheModelDoes) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CHECK(stands(1.8, 0.1, "speed", plant::Balance::kForce, seed));  // RMS 1.3 practical sizes
    CHECK_FALSE(stands(1.8, 0.1, "speed", plant::Balance::kForce, seed, {2.0}));
    CHECK(stands(3.0, 0.1, "speed", plant::Balance::kForce, seed, {2.0}));
  }
}

TEST(Search, ASizeThatIsALargePartOfWhatCanBeIsFollowedAlongItsBend) {
  CHECK_FALSE(alone(3.0, -20.0, 20.0).bends);
  CHECK(alone(3.0, -20.0, 20.0).stands);
  for (const Set& set : {alone(3.0, -20.0, 8.0), alone(-3.0, -8.0, 20.0)}) {
    CHECK(set.bends);
    CHECK_TEXT(set.stands, "possible as a straight line all the same");
  }
  CHECK_FALSE_TEXT(alone(3.0, -20.0, 1.0).stands, "larger than can be");
  CHECK(alone(3.0, -20.0, 1.0).bends);
}

TEST(Search, BesideAnotherCauseAsMuchIsAskedAsAlone) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SimulatedChannel made(seed);
    made.add_white(0.1);
    made.add(3.0 * made.wave() + 1.8 * made.late_wave());  // RMS of the second 1.3 practical sizes
    Family family = family_of(made, "speed");
    Suspect other = family.suspects[0];
    other.cause = 1;
    other.name = "other";
    other.columns = {2};
    family.suspects.push_back(other);
    std::vector<plant::Cause> causes = cause_of(plant::Balance::kForce);
    causes.push_back(causes[0]);
    for (const double asked : {1.0, 2.0}) {
      family.asked = {asked};
      Search search(family, causes);
      CHECK_EQUAL(asked < 1.5, is_worth_more(family, search.of({0, 1}), search.of({0})));
    }
  }
}

TEST(Search, WhatIsWrongWithTheVoltageAloneExplainsNoTemperature) {
  CHECK_FALSE(stands(3.0, 0.5, "temperature", plant::Balance::kVoltage, 1));
  CHECK(stands(3.0, 0.5, "temperature", plant::Balance::kHeat, 1));
}

}  // namespace voltlap::explain

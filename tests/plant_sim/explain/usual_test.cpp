// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/usual.hpp"

#include <CppUTest/TestHarness.h>

#include <algorithm>
#include <vector>

#include "simulated_channel.hpp"

namespace voltlap::explain {
namespace {

/// One channel, and a cause that is its wave.
Family family_of(const SimulatedChannel& channel) {
  Family out;
  out.problem = channel.problem();
  Suspect suspect;
  suspect.cause = 0;
  suspect.name = "wave";
  suspect.columns = {1};
  out.suspects = {suspect};
  out.channel = {"temperature"};
  out.practical = {1.0};
  out.typical = VectorXd::Ones(3);
  return out;
}

SimulatedChannel noisy(unsigned seed, double white, double slow, double wave) {
  SimulatedChannel out(seed);
  out.add_white(white);
  out.add_slow(slow);
  out.add(wave * out.wave());
  return out;
}

Unlike unlike(const Family& family, const Family& reference) {
  Set set;
  set.members = {0};
  set.linear = set.fit = fit_of(family.problem, {1});
  return unlike_of(family, set, 0,
                   Asked({[&](const std::vector<Suspect>&) -> const Family& { return reference; }}));
}

}  // namespace

TEST_GROUP(Usual){};

TEST(Usual, CriticalValuesOfStudentsT) {
  // Abramowitz and Stegun, Table 26.10.
  DOUBLES_EQUAL(5.041, critical_t(1e-3, 8.0), 2e-3);
  DOUBLES_EQUAL(4.587, critical_t(1e-3, 10.0), 2e-3);
  DOUBLES_EQUAL(3.850, critical_t(1e-3, 20.0), 1e-2);
  CHECK(critical_t(1e-4, 8.0) > critical_t(1e-3, 8.0));
}

TEST(Usual, SlowNoiseIsAtMostWhatSoundLogsHave) {
  Family log = family_of(noisy(1, 0.2, 2.0, 0.0));
  const Family quiet = family_of(noisy(2, 0.2, 0.0, 0.0)), loud = family_of(noisy(3, 0.2, 4.0, 0.0));
  bound_noise(log, {});
  CHECK_TEXT(std::isinf(log.problem.most_slow[0]), "steps of a thermistor leave what nothing bounds");
  Family volts = log;
  volts.channel = {"voltage"};
  bound_noise(volts, {});
  DOUBLES_EQUAL_TEXT(2.0, volts.problem.most_slow[0], 1e-12,
                     "practical sizes: what is slower and larger is an error");
  bound_noise(log, {[&](const std::vector<Suspect>&) -> const Family& { return quiet; }});
  CHECK(log.problem.most_slow[0] <= 0.3);
  CHECK(slow_noise(log.problem, fit_of(log.problem, {}), 0) <= 0.3);
  bound_noise(log, {[&](const std::vector<Suspect>&) -> const Family& { return loud; }});
  CHECK_TEXT(log.problem.most_slow[0] > 1.0, "sound logs have much more of it");
}

TEST(Usual, AReferenceThatHardlyTellsACauseShowsNoHabitOfIt) {
  const Family log = family_of(noisy(1, 0.3, 0.0, 2.0));
  std::vector<double> spread;
  for (unsigned seed = 1; seed <= 41; ++seed) {
    const Unlike one = unlike(log, family_of(noisy(seed, 100.0, 0.0, 0.0)));  // tells the wave to 2.9
    spread.push_back(one.habit.spread);
    CHECK(std::abs(one.habit.mean) < 0.1);
  }
  std::nth_element(spread.begin(), spread.begin() + 20, spread.end());
  CHECK_TEXT(spread[20] < 0.4, "its own error is no spread");
}

TEST(Usual, WhatAReferenceShowsClearlyIsUsual) {
  const Family log = family_of(noisy(1, 0.3, 0.0, 2.0));
  CHECK(unlike(log, family_of(noisy(2, 0.3, 0.0, 0.0))).is);
  CHECK_FALSE(unlike(log, family_of(noisy(3, 0.3, 0.0, 2.2))).is);
}

TEST(Usual, ASizeThatWasFollowedIsHeldAgainstReferencesAsItWasFollowed) {
  Family log = family_of(noisy(1, 0.3, 0.0, 2.0));
  log.suspects[0].form.at = {0.0};
  log.suspects[0].form.linear = log.suspects[0].form.refined = {0};
  log.typical *= 15.0;
  const Family quiet = family_of(noisy(2, 0.3, 0.0, 0.0));
  const Asked asked({[&](const std::vector<Suspect>&) -> const Family& { return quiet; }});
  Set set;
  set.members = {0};
  set.linear = set.fit = fit_of(log.problem, {1});
  const double straight = unlike_of(log, set, 0, asked).t;
  set.values = {{15.0 * 6.0}};  // three times what the straight line says
  set.sigma = {{15.0 * 1e-3}};
  CHECK(unlike_of(log, set, 0, asked).t > 2.5 * straight);
  log.suspects[0].form.linear = {};  // of several numbers, or none, there is no one size
  DOUBLES_EQUAL(straight, unlike_of(log, set, 0, asked).t, 1e-12);
}

}  // namespace voltlap::explain

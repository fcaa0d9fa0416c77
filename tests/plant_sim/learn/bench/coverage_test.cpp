// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/coverage.hpp"

#include <numeric>

#include "bench_fixtures.hpp"
#include "fixtures.hpp"
#include "learn/bench/campaign.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Coverage) {
  CellParameters cell = vtm16e().cell;
  BenchRecord record = Campaign(ideal_plan(), cell, 1).rehearse(0);
};

TEST(Coverage, EverySecondOfATestIsSomewhere) {
  Coverage map(cell);
  map.add(record);
  double load = 0.0, rest = 0.0, pulses = 0.0;
  for (std::size_t s = 0; s < map.soc().size(); ++s) {
    for (std::size_t t = 0; t < map.temperature_c().size(); ++t) {
      for (std::size_t c = 0; c < map.current_a().size(); ++c) {
        load += map.load_s(s, t, c);
        rest += map.rest_s(s, t, c);
      }
    }
  }
  for (const BenchPhase& phase : record.phases) pulses += phase.load ? phase.end_s - phase.begin_s : 0.0;
  DOUBLES_EQUAL(pulses, load, 1e-6);
  DOUBLES_EQUAL(record.duration_s(), load + rest, 1e-6);
}

TEST(Coverage, ATestAt30DegreesAnd200AmperesVisitsThatColumnAlone) {
  Coverage map(cell);
  map.add(record);
  for (std::size_t s = 0; s < map.soc().size(); ++s) {
    for (std::size_t t = 0; t < 3; ++t) {
      for (std::size_t c = 0; c < 5; ++c) {
        const bool there = map.load_s(s, t, c) > 0.0;
        if (t != 1 || c < 1 || c > 2) CHECK_FALSE(there);
        if (t == 1 && c == 2 && s > 2) CHECK(there);
      }
    }
  }
  CHECK(map.visited() >= 16 && map.visited() < 32);
}

TEST(Coverage, RestsAreSurveyedWithTheTimeConstantsOfTheirPlace) {
  RestSurvey survey(cell);
  survey.add(record);
  const RestSummary rests = survey.summary();
  LONGS_EQUAL(record.count(true), rests.count);
  CHECK(rests.shortest_s >= 120.0 && rests.shortest_s <= rests.median_s && rests.median_s <= rests.longest_s);
  DOUBLES_EQUAL(33.0, rests.taus[0].min_s, 2.0);
  DOUBLES_EQUAL(1072.0, rests.taus[1].max_s, 200.0);
  CHECK(rests.shorter_than_last_tau > 0);
}

TEST(Coverage, LongRestsOutlastTheSlowBranch) {
  RestSurvey survey(cell);
  survey.add(Campaign(ideal_plan({"rest.rule=fixed", "rest.seconds=3600"}), cell, 1).rehearse(0));
  LONGS_EQUAL(0, survey.summary().shorter_than_last_tau);
  DOUBLES_EQUAL(3600.0, survey.summary().median_s, 1e-6);
}

// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/program.hpp"

#include <cmath>
#include <numeric>
#include <set>

#include "bench_fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Program){};

TEST(Program, PulseTimeIsThatOfEquation51WithThe3600WhereItBelongs) {
  DOUBLES_EQUAL(50.0 * 3600.0 * 0.05 / 400.0, pulse_time_s(50.0, 0.05, 400.0), 1e-12);
  DOUBLES_EQUAL(22.5, pulse_time_s(50.0, 0.05, 400.0), 1e-12);
  DOUBLES_EQUAL(55.0 * 3600.0 * 0.1 / 35.0, pulse_time_s(55.0, 0.1, 35.0), 1e-12);
}

TEST(Program, PulsesTakeFivePercentAboveEightyAndBelowTwentyAndTenBetween) {
  const std::vector<double> expected = {0.05, 0.05, 0.05, 0.05, 0.1,  0.1,  0.1,
                                        0.1,  0.1,  0.1,  0.05, 0.05, 0.05, 0.05};
  const std::vector<double> steps = pulse_steps(shipped_plan("pulse_15").schedule);
  LONGS_EQUAL(expected.size(), steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) DOUBLES_EQUAL(expected[i], steps[i], 1e-9);
}

TEST(Program, FinerStepsBelowTenPercentReplaceTheCoarseOnes) {
  const auto steps = pulse_steps(shipped_plan("pulse_15", {"schedule.fine_step=0.02"}).schedule);
  LONGS_EQUAL(12 + 5, steps.size());
  for (std::size_t i = 12; i < steps.size(); ++i) DOUBLES_EQUAL(0.02, steps[i], 1e-9);
  DOUBLES_EQUAL(1.0, std::accumulate(steps.begin(), steps.end(), 0.0), 1e-9);
}

TEST(Program, ACoarsePulseEndsWhereTheFineOnesBegin) {
  const auto steps =
      pulse_steps(shipped_plan("pulse_15", {"schedule.fine_step=0.01", "schedule.fine_below=0.07"}).schedule);
  LONGS_EQUAL(13 + 7, steps.size());
  DOUBLES_EQUAL(0.03, steps[12], 1e-9);
  DOUBLES_EQUAL(0.01, steps[13], 1e-9);
}

TEST(Program, EveryPulseIsFollowedByARestAndTheLastOneIsRepeated) {
  const BenchPlan plan = shipped_plan("pulse_15");
  const BenchTest test = tests_of(plan)[4];
  STRCMP_EQUAL("22c_400a", test.name.c_str());
  const Program program = program_of(plan, test);
  LONGS_EQUAL(28, program.once.size());
  for (std::size_t i = 0; i < program.once.size(); ++i) CHECK(program.once[i].is_load() == (i % 2 == 0));
  DOUBLES_EQUAL(22.5, program.once[0].duration_s, 1e-9);
  DOUBLES_EQUAL(45.0, program.once[8].duration_s, 1e-9);
  LONGS_EQUAL(2, program.again.size());
  DOUBLES_EQUAL(22.5, program.again[0].duration_s, 1e-9);
}

TEST(Program, CapacityOfTheScheduleGoesFrom55AhAt35AmperesTo50At400) {
  const TestSection test = shipped_plan("pulse_15").test;
  DOUBLES_EQUAL(55.0, schedule_capacity_ah(test, 35.0), 1e-12);
  DOUBLES_EQUAL(50.0, schedule_capacity_ah(test, 400.0), 1e-12);
  DOUBLES_EQUAL(52.5, schedule_capacity_ah(test, 217.5), 1e-12);
  DOUBLES_EQUAL(50.0, schedule_capacity_ah(test, 500.0), 1e-12);
}

TEST(Program, EveryTemperatureWithEveryCurrentIsATest) {
  const auto tests = tests_of(shipped_plan("pulse_15"));
  LONGS_EQUAL(15, tests.size());
  std::set<std::string> names;
  for (const BenchTest& test : tests) names.insert(test.name);
  LONGS_EQUAL(15, names.size());
  CHECK(names.contains("40c_35a"));
}

TEST(Program, RandomOrderNeverRepeatsAndNeverChangesBySeven) {
  const LoadSection load = shipped_plan("random_resistors").load;
  const auto order = resistor_order(load, 2000);
  std::set<int> seen(order.begin(), order.end());
  LONGS_EQUAL(8, seen.size());
  LONGS_EQUAL(1, *seen.begin());
  int largest = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    CHECK(order[i] != order[i - 1]);
    largest = std::max(largest, std::abs(order[i] - order[i - 1]));
  }
  LONGS_EQUAL(6, largest);
}

TEST(Program, BothRandomPlansShareOneOrderAndAnotherSeedGivesAnother) {
  const auto constant = resistor_order(shipped_plan("random_resistors").load, 50);
  const auto free = resistor_order(shipped_plan("random_resistors_free").load, 50);
  const auto other = resistor_order(shipped_plan("random_resistors", {"load.resistor_seed=1"}).load, 50);
  CHECK(constant == free);
  CHECK(constant != other);
}

TEST(Program, AGivenOrderIsKeptAndEndsTheTest) {
  const BenchPlan plan = shipped_plan("random_resistors", {"load.resistors=[3, 8, 1]"});
  const Program program = program_of(plan, tests_of(plan).front());
  LONGS_EQUAL(6, program.once.size());
  DOUBLES_EQUAL(0.3 / 8.0, program.once[2].value, 1e-12);
  LONGS_EQUAL(0, program.again.size());
}

TEST(Program, HppcPointHasADischargeAPauseAndASmallerCharge) {
  const BenchPlan plan = shipped_plan("hppc");
  const Program program = program_of(plan, tests_of(plan).front());
  LONGS_EQUAL(60, program.once.size());
  DOUBLES_EQUAL(18.4, program.once[0].value, 1e-12);
  DOUBLES_EQUAL(0.1 * 55.2 * 3600.0 / 18.4, program.once[0].duration_s, 1e-9);
  DOUBLES_EQUAL(100.0, program.once[2].value, 1e-12);
  DOUBLES_EQUAL(10.0, program.once[2].duration_s, 1e-12);
  DOUBLES_EQUAL(40.0, program.once[3].duration_s, 1e-12);
  DOUBLES_EQUAL(-75.0, program.once[4].value, 1e-12);
}

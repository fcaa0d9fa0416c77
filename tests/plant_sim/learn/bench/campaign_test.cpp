// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/campaign.hpp"

#include <cmath>

#include "bench_fixtures.hpp"
#include "fixtures.hpp"
#include "learn/bench/forecast.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(Campaign) {
  CellParameters cell = vtm16e().cell;

  Campaign campaign(std::uint64_t seed, const std::vector<std::string>& settings = {}) const {
    std::vector<std::string> all = {"test.temperature_c=[22, 40]", "test.current_a=[100, 400]"};
    all.insert(all.end(), settings.begin(), settings.end());
    return {shipped_plan("pulse_15", all), cell, seed};
  }
};

TEST(Campaign, OneSeedGivesTheSameTableAndAnotherDoesNot) {
  const BenchRecord a = campaign(1).run(1), b = campaign(1).run(1), c = campaign(2).run(1);
  CHECK(a.cells[2].voltage_v == b.cells[2].voltage_v && a.current_a == b.current_a);
  CHECK(a.cells[2].voltage_v != c.cells[2].voltage_v);
}

TEST(Campaign, ATestDoesNotDependOnThoseBeforeIt) {
  const Campaign all = campaign(1);
  const BenchRecord alone = all.run(3);
  for (std::size_t i = 0; i < 3; ++i) (void)all.run(i);
  CHECK(alone.cells[0].voltage_v == all.run(3).cells[0].voltage_v);
}

TEST(Campaign, CellsAreTheSameInAllTestsButForTheirStateOfCharge) {
  const Campaign all = campaign(4);
  const BenchRecord a = all.run(0), b = all.run(1);
  for (std::size_t i = 0; i < 4; ++i) {
    DOUBLES_EQUAL(a.cells[i].capacity_ah, b.cells[i].capacity_ah, 0.0);
    DOUBLES_EQUAL(a.cells[i].variation.resistance_scale, b.cells[i].variation.resistance_scale, 0.0);
    CHECK(a.cells[i].initial_soc != b.cells[i].initial_soc);
  }
  CHECK(a.cells[0].capacity_ah != a.cells[1].capacity_ah);
}

TEST(Campaign, SpreadOfTheCellsIsThatOfThePlan) {
  double capacity = 0.0, resistance = 0.0, soc = 0.0;
  constexpr int kSeeds = 60;
  const std::vector<std::string> brief = {"test.temperature_c=30", "test.current_a=400", "schedule.soc=[1, 0.5]",
                                          "schedule.step=0.5",     "rest.rule=fixed",    "rest.seconds=1"};
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    for (const CellRecord& c : campaign(seed, brief).run(0).cells) {
      capacity += std::pow(c.capacity_ah / 55.2 - 1.0, 2);
      resistance += std::pow(c.variation.resistance_scale - 1.0, 2);
      soc += std::pow(c.initial_soc - 1.0, 2);
    }
  }
  const auto spread = [](double squares) { return std::sqrt(squares / (4.0 * kSeeds)); };
  DOUBLES_EQUAL(0.022, spread(capacity), 0.15 * 0.022);
  DOUBLES_EQUAL(0.03, spread(resistance), 0.15 * 0.03);
  DOUBLES_EQUAL(0.004, spread(soc), 0.15 * 0.004);
}

TEST(Campaign, GivenCellsAreTakenAsTheyAre) {
  const BenchRecord record =
      campaign(7, {"cells.capacity_scale=[1, 0.95, 1.02, 1]", "cells.resistance_scale=[1, 1, 1.1, 1]",
                   "cells.soc_offset=[0, 0, 0, -0.02]"})
          .run(0);
  DOUBLES_EQUAL(0.95 * 55.2, record.cells[1].capacity_ah, 1e-9);
  DOUBLES_EQUAL(1.1, record.cells[2].variation.resistance_scale, 0.0);
  DOUBLES_EQUAL(0.98, record.cells[3].initial_soc, 1e-12);
}

TEST(Campaign, NoiseDoesNotChangeTheCellsThatTheSeedDrew) {
  const BenchRecord noisy = campaign(3).run(0), quiet = campaign(3, {"instruments.noise=false"}).run(0);
  DOUBLES_EQUAL(noisy.cells[1].capacity_ah, quiet.cells[1].capacity_ah, 0.0);
  DOUBLES_EQUAL(noisy.cells[1].initial_soc, quiet.cells[1].initial_soc, 0.0);
}

TEST(Campaign, ForecastTellsTheDurationOfARunWithinItsMargin) {
  for (const char* plan : {"pulse_15", "random_resistors", "random_resistors_free", "hppc"}) {
    const BenchPlan loaded = shipped_plan(plan);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Campaign all(loaded, cell, seed);
      const std::size_t test = seed * (all.tests().size() - 1) / 3;
      const double planned = all.rehearse(test).duration_s(), run = all.run(test).duration_s();
      CHECK(std::abs(run / planned - 1.0) < kForecastMargin);
    }
  }
}

TEST(Campaign, ForecastOfThe15TestsCountsPulsesRestsAndDays) {
  const Forecast planned = forecast({shipped_plan("pulse_15"), cell, 1});
  LONGS_EQUAL(15, planned.tests.size());
  for (const TestForecast& test : planned.tests) {
    CHECK(test.pulses >= 14 && test.rests == test.pulses + 1);
    CHECK(test.end == TestEnd::kVoltage);
    CHECK(test.duration_s > 2.0 * 3600.0 && test.duration_s < 6.0 * 3600.0);
  }
  DOUBLES_EQUAL(planned.bench_s + 14.0 * 14.0 * 3600.0, planned.calendar_s, 1e-6);
  const std::string text = forecast_text({shipped_plan("pulse_15"), cell, 1}, planned);
  for (const char* part :
       {"22c_35a", "40c_400a", "low bank, 0.43 ohm", "8 of the high bank", "of 240 nodes visited", "tau2"}) {
    STRCMP_CONTAINS(part, text.c_str());
  }
}

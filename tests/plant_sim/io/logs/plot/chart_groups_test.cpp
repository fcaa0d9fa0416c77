// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/chart_groups.hpp"

#include <algorithm>
#include <cstdlib>
#include <random>

#include <fmt/format.h>

#include "courses.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(ChartGroups) {
  std::vector<SignalHead> heads;
  std::vector<SignalCourse> courses;
  void add(const std::string& unit, double low, double high) {
    heads.push_back({fmt::format("S{}", heads.size()), unit, "", {}});
    courses.push_back(course_of_values({low, high}));
  }
  std::vector<ChartGroup> groups() const {
    std::vector<std::size_t> chosen(heads.size());
    for (std::size_t k = 0; k < chosen.size(); ++k) chosen[k] = k;
    return chart_groups(chosen, heads, courses);
  }
};

TEST(ChartGroups, OneUnitIsOneChartHoweverItIsSpelled) {
  add("degC", 20, 40);
  add("C", 25, 45);
  add("A", -100, 200);
  const auto found = groups();
  LONGS_EQUAL(2, found.size());
  STRCMP_EQUAL("Current", found[0].title.c_str());
  STRCMP_EQUAL("Temperature", found[1].title.c_str());
  STRCMP_EQUAL("°C", found[1].unit.c_str());
  LONGS_EQUAL(2, found[1].signals.size());
}

TEST(ChartGroups, CellsAndThePackDoNotShareAnAxis) {
  add("V", 350, 400);
  add("V", 3.4, 4.1);
  add("V", 3.5, 4.2);
  const auto found = groups();
  LONGS_EQUAL(2, found.size());
  STRCMP_CONTAINS("3.4 to 4.2 V", found[1].title.c_str());
}

TEST(ChartGroups, EverySignalOfADrawnChoiceIsInOneReadableChart) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given != nullptr ? static_cast<unsigned>(std::atoi(given)) : std::random_device{}();
  std::mt19937 random(seed);
  const char* units[] = {"V", "A", "", "degC", "gids", "%"};
  for (int k = 0; k < 200; ++k) {
    const double size = std::pow(10.0, static_cast<double>(random() % 60) / 10.0 - 2.0);
    add(units[random() % 6], random() % 2 == 0 ? 0.0 : -size, size);
  }
  std::vector<int> seen(heads.size(), 0);
  for (const ChartGroup& group : groups()) {
    CHECK(group.signals.size() <= 6);
    for (const std::size_t k : group.signals) ++seen[k];
  }
  if (std::any_of(seen.begin(), seen.end(), [](int times) { return times != 1; }))
    FAIL(fmt::format("VOLTLAP_TEST_SEED={}: a signal is in no chart or in two", seed).c_str());
}

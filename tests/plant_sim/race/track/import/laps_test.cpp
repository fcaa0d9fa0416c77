// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/laps.hpp"

#include <cmath>

#include "drawn_course.hpp"
#include "race/track/import/smooth_path.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr double kReach_m = 6.0;

PointList rounds(const Track& course, double rounds) {
  std::mt19937_64 draw(1);
  const int whole = static_cast<int>(std::ceil(rounds));
  PointList points = surveyed(course, 1.0, 0.0, draw, whole);
  points.resize(static_cast<std::size_t>(static_cast<double>(points.size()) * rounds / whole));
  return points;
}

}  // namespace

TEST_GROUP(Laps){};

TEST(Laps, WholeLapsOfDrawnCoursesAreFoundWithTheirLength) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937_64 draw(seed);
    const Track course = drawn_closed_course(draw);
    const std::vector<Lap> laps = find_laps(rounds(course, 4.4), kReach_m);
    LONGS_EQUAL_TEXT(4, laps.size(), ("seed " + std::to_string(seed)).c_str());
    for (const Lap& lap : laps) {
      DOUBLES_EQUAL_TEXT(course.length_m(), lap.length_m, 3.0, ("seed " + std::to_string(seed)).c_str());
    }
  }
}

TEST(Laps, ACourseThatIsNotDrivenRoundAgainHasNone) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937_64 draw(seed);
    const Track course = drawn_closed_course(draw);
    LONGS_EQUAL_TEXT(0, find_laps(rounds(course, 0.9), kReach_m).size(), ("seed " + std::to_string(seed)).c_str());
  }
}

TEST(Laps, AHairpinBackBesideTheWayIsNoLap) {
  PointList there_and_back;
  for (int i = 0; i < 200; ++i) there_and_back.push_back({1.0 * i, 0.0});
  for (int i = 0; i < 200; ++i) there_and_back.push_back({199.0 - i, 5.0});
  LONGS_EQUAL(0, find_laps(there_and_back, kReach_m).size());
}

TEST(Laps, AFigureOfEightCrossesItselfOnceALap) {
  PointList eight;
  for (int i = 0; i < 3 * 400; ++i) {
    const double t = 2.0 * M_PI * i / 400.0;
    eight.push_back({60.0 * std::sin(t), 30.0 * std::sin(2.0 * t)});
  }
  const std::vector<Lap> laps = find_laps(eight, kReach_m);
  CHECK(laps.size() == 2 || laps.size() == 3);
  const double once = distances_along({eight.begin(), eight.begin() + 401}, false).back();
  DOUBLES_EQUAL(once, laps[0].length_m, 2.0);
}

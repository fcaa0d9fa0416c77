// SPDX-License-Identifier: Apache-2.0
// What an import makes of a course through noise, over drawn courses. docs/tracks.md has the figures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drawn_course.hpp"
#include "fixtures.hpp"
#include "race/track/import/course_import.hpp"
#include "race/track/lap_solver.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

/// Shares by which an import misses its source.
struct Error {
  double lap_time, length, tightest;
};

double lap_time(const Track& track, bool closed) {
  return solve_lap(vtm16e(), track, closed ? LapStart::kFlying : LapStart::kStanding).lap_time_s();
}

Error error_of(const Track& course, const PointList& points, bool closed = true) {
  const TemporaryFile file("noise.csv", points_file(points));
  ImportOptions options;
  if (!closed) options.closure = Closure::kOpen;
  const Track found = import_course(file.path(), options).track;
  const CourseSummary was = summarise(course), is = summarise(found);
  return {lap_time(found, closed) / lap_time(course, closed) - 1.0, is.length_m / was.length_m - 1.0,
          is.tightest_radius_m / was.tightest_radius_m - 1.0};
}

/// Mean, root mean square and the largest of the errors of lap time; each other error within its bound.
struct Spread {
  double mean = 0.0, rms = 0.0, worst = 0.0;
  std::size_t hairpins = 0;  ///< courses whose tightest radius came out a fifth tighter than it is

  void add(const Error& error, double of) {
    mean += error.lap_time / of;
    rms = std::sqrt(rms * rms + error.lap_time * error.lap_time / of);
    worst = std::max(worst, std::abs(error.lap_time));
    hairpins += error.tightest < -0.2;
  }
};

template <class Points>
Spread spread_over(unsigned draws, double length_bound, const Points& points_of) {
  Spread spread;
  for (unsigned seed = 1; seed <= draws; ++seed) {
    std::mt19937_64 draw(seed);
    const Track course = drawn_closed_course(draw);
    const Error error = error_of(course, points_of(course, draw));
    const std::string which = fmt::format("seed {}: length {:+.5f}", seed, error.length);
    CHECK_TEXT(std::abs(error.length) < length_bound, which.c_str());
    spread.add(error, draws);
  }
  return spread;
}

}  // namespace

TEST_GROUP(Noise){};

TEST(Noise, ExactPointsGiveTheLapTimeAndTheTightestRadiusOfTheirCourse) {
  for (const double spacing : {0.25, 1.0}) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
      std::mt19937_64 draw(seed);
      const Track course = drawn_closed_course(draw);
      const Error error = error_of(course, surveyed(course, spacing, 0.0, draw));
      const std::string which = fmt::format("seed {}, {} m apart: lap time {:+.5f}, length {:+.5f}, tightest {:+.4f}",
                                            seed, spacing, error.lap_time, error.length, error.tightest);
      CHECK_TEXT(std::abs(error.lap_time) < 0.0015, which.c_str());
      CHECK_TEXT(std::abs(error.length) < 0.0002, which.c_str());
      CHECK_TEXT(std::abs(error.tightest) < 0.05, which.c_str());
    }
  }
}

TEST(Noise, SurveyedCoursesKeepTheirLapTimeThroughThirtyCentimetresOfNoise) {
  const Spread spread = spread_over(40, 0.002, [](const Track& course, std::mt19937_64& draw) {
    return surveyed(course, 0.25, 0.3, draw);
  });
  CHECK_TEXT(std::abs(spread.mean) < 0.005, fmt::format("mean {:+.5f}", spread.mean).c_str());
  CHECK_TEXT(spread.rms < 0.01, fmt::format("rms {:.5f}", spread.rms).c_str());
  CHECK_TEXT(spread.worst < 0.025, fmt::format("worst {:.5f}", spread.worst).c_str());
  CHECK_TEXT(spread.hairpins <= 1, fmt::format("{} false hairpins", spread.hairpins).c_str());
}

TEST(Noise, SurveyedCoursesKeepTheirLapTimeThroughThreeCentimetresOfNoise) {
  const Spread spread = spread_over(40, 0.0005, [](const Track& course, std::mt19937_64& draw) {
    return surveyed(course, 0.25, 0.03, draw);
  });
  CHECK_TEXT(spread.rms < 0.0035, fmt::format("rms {:.5f}", spread.rms).c_str());
  CHECK_TEXT(spread.worst < 0.01, fmt::format("worst {:.5f}", spread.worst).c_str());
}

TEST(Noise, EightLapsOfAGpsWithAMetreOfNoiseAreUsable) {
  const Spread spread = spread_over(12, 0.006, [](const Track& course, std::mt19937_64& draw) {
    return recorded(vtm16e(), course, 10.0, 1.0, 8.4, draw);
  });
  CHECK_TEXT(std::abs(spread.mean) < 0.02, fmt::format("mean {:+.5f}", spread.mean).c_str());
  CHECK_TEXT(spread.rms < 0.025, fmt::format("rms {:.5f}", spread.rms).c_str());
  CHECK_TEXT(spread.hairpins <= 3, fmt::format("{} false hairpins", spread.hairpins).c_str());
}

TEST(Noise, MichiganByExactPointsIsMichigan) {
  for (const int year : {2014, 2015}) {
    for (const double spacing : {0.25, 0.5, 1.0}) {
      std::mt19937_64 draw(1);
      const Error error = error_of(michigan(year), surveyed(michigan(year), spacing, 0.0, draw), false);
      const std::string which = fmt::format("{}, {} m: lap time {:+.5f}, length {:+.5f}", year, spacing,
                                            error.lap_time, error.length);
      CHECK_TEXT(std::abs(error.lap_time) < 0.001 && std::abs(error.length) < 0.0005, which.c_str());
    }
  }
}

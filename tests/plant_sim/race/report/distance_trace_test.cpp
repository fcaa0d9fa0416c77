// SPDX-License-Identifier: Apache-2.0
#include "race/report/distance_trace.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <random>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(DistanceTrace) {
  std::vector<double> voltages{3.9, 3.8}, temperatures{25.0, 26.0};

  TimeSample sample(double time_s, double course_m) {
    TimeSample out{};
    out.time_s = time_s;
    out.course_m = course_m;
    out.cell_voltage_v = &voltages;
    out.cell_temperature_c = &temperatures;
    return out;
  }
};

TEST(DistanceTrace, PlacesAreEvenAndTimesLieOnTheDrawnDrive) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> speed(0.0, 40.0);
    DistanceTrace trace;
    std::vector<double> time_s{0.0}, at_m{0.0};
    for (int i = 1; i <= 500; ++i) {
      time_s.push_back(0.1 * i);
      at_m.push_back(at_m.back() + 0.1 * speed(random));
      trace.add(sample(time_s.back(), at_m.back()));
    }
    trace.close(50.0, std::nullopt);
    const auto& distance = trace.columns()[0];
    const std::string words = "seed " + std::to_string(seed);
    for (std::size_t i = 0, k = 1; i < distance.size(); ++i) {
      const double even_m = DistanceTrace::kStep_m * static_cast<double>(i);
      if (i + 1 < distance.size()) DOUBLES_EQUAL_TEXT(even_m, distance[i], 1e-9, words.c_str());
      while (at_m[k] < distance[i] && k + 1 < at_m.size()) ++k;
      CHECK_TRUE_TEXT(trace.columns()[1][i] >= time_s[k - 1] - 1e-9, words.c_str());
      CHECK_TRUE_TEXT(trace.columns()[1][i] <= time_s[k] + 1e-9, words.c_str());
    }
    DOUBLES_EQUAL_TEXT(at_m.back(), distance.back(), 1e-9, words.c_str());
  }
}

TEST(DistanceTrace, FinishLineStandsExactlyWhereItIsCrossed) {
  DistanceTrace trace;
  for (int i = 1; i <= 11; ++i) trace.add(sample(0.1 * i, 10.0 * 0.1 * i));
  trace.close(0.987, 9.87);
  DOUBLES_EQUAL(9.87, trace.columns()[0].back(), 0.0);
  DOUBLES_EQUAL(0.987, trace.columns()[1].back(), 0.0);
  LONGS_EQUAL(5, trace.columns()[0].size());  // 0, 2.5, 5, 7.5, the line; 10 m lies behind it
}

TEST(DistanceTrace, LongRunIsThinnedEvenly) {
  DistanceTrace trace;
  for (int i = 1; i <= 3 * static_cast<int>(DistanceTrace::kPointsMax); ++i) trace.add(sample(0.1 * i, 5.0 * i));
  const auto& distance = trace.columns()[0];
  CHECK(distance.size() <= DistanceTrace::kPointsMax + 1);
  for (std::size_t i = 1; i < distance.size(); ++i) DOUBLES_EQUAL(20.0, distance[i] - distance[i - 1], 1e-6);
}

TEST(DistanceTrace, JsonHasEveryChannelAsLongAsTheFirst) {
  DistanceTrace trace;
  TimeSample one = sample(0.1, 20.0);
  one.lateral_mps2 = std::numeric_limits<double>::quiet_NaN();
  trace.add(one);
  trace.close(0.1, std::nullopt);
  const nlohmann::json json = nlohmann::json::parse(trace_json(trace));
  for (const TraceChannel& channel : trace_channels()) LONGS_EQUAL(9, json.at(channel.name).size());
  CHECK(json["lateral_mps2"][0].is_null());
  CHECK(nlohmann::json::parse(trace_json(DistanceTrace()))["distance_m"].empty());
}

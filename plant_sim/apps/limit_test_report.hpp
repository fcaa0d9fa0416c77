// SPDX-License-Identifier: Apache-2.0
// What limit-test has measured, beside its marks: a table and JSON.
#pragma once
#include <string>
#include <vector>

#include "apps/limit_race.hpp"
#include "apps/limit_states.hpp"

namespace voltlap::plant {

/// Marks: the integers within so much of the bisection; of the limits that a voltage sets this share ends within the
/// bound, at most so far inside it and beyond it.
inline constexpr double kMarkBisection = 0.005, kMarkInside_v = 0.030, kMarkBeyond_v = 0.020, kMarkShare = 0.99;

struct LimitRaceRow {
  std::string car;
  double temperature_c, resistance;
  bms::LimitMethod method;
  LimitRaceResult race;
};

struct LimitTestResult {
  std::uint64_t seed = 0;
  std::vector<LimitMoment> moments;
  std::vector<LimitRaceRow> races;
};

[[nodiscard]] std::string limit_test_text(const LimitTestResult& result);
[[nodiscard]] std::string limit_test_json(const LimitTestResult& result);

}  // namespace voltlap::plant

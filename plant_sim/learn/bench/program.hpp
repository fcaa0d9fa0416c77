// SPDX-License-Identifier: Apache-2.0
// What the bench does in one test, as a list of segments (reference study, 2016, chapter 5 and section 7.2).
//
//   t_pulse = 3600 Capacity dSOC / I      Capacity [Ah], dSOC [1], I nominal [A]      (Eq. 5.1, with the 3600 where
//   it belongs)
#pragma once
#include <vector>

#include "learn/bench/plan.hpp"

namespace voltlap::plant {

enum class BenchSegmentKind {
  kRest,      ///< by the plan's rest rule
  kWait,      ///< open circuit for duration_s
  kResistor,  ///< value is a resistance [ohm]
  kCurrent,   ///< value is a current [A], discharge positive
};

struct BenchSegment {
  BenchSegmentKind kind = BenchSegmentKind::kRest;
  double value = 0.0;
  double duration_s = 0.0;

  [[nodiscard]] bool is_load() const {
    return kind == BenchSegmentKind::kResistor || kind == BenchSegmentKind::kCurrent;
  }
};

struct Program {
  std::vector<BenchSegment> once;
  std::vector<BenchSegment> again;  ///< repeated until the stop rule ends the test; empty: the test ends by itself
};

/// One test of the plan's grid.
struct BenchTest {
  std::string name;  ///< "30c_200a"
  double temperature_c = 0.0;
  double current_a = 0.0;  ///< nominal; 0 in a random test
  std::string load;        ///< in words
};

[[nodiscard]] double pulse_time_s(double capacity_ah, double soc_step, double current_a);

/// SOC that each pulse takes, from the top of the schedule to its end.
[[nodiscard]] std::vector<double> pulse_steps(const ScheduleSection& schedule);

/// How many resistors each pulse of a random test has: as given, or drawn: never the same twice in a row, no larger
/// difference than the plan allows.
[[nodiscard]] std::vector<int> resistor_order(const LoadSection& load, std::size_t pulses);

[[nodiscard]] std::vector<BenchTest> tests_of(const BenchPlan& plan);
[[nodiscard]] Program program_of(const BenchPlan& plan, const BenchTest& test);

}  // namespace voltlap::plant

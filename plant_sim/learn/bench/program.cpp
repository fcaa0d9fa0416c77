// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/demand.hpp"
#include "learn/bench/resistor_bank.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSecondsPerHour = 3600.0;
constexpr double kSocTolerance = 1e-9;
constexpr std::size_t kDrawnPulses = 256;  // far more than any cell lasts

BenchSegment rest() {
  return {BenchSegmentKind::kRest, 0.0, 0.0};
}

BenchSegment load_segment(const BenchPlan& plan, double current_a, double duration_s) {
  if (plan.load.kind == "cycler") return {BenchSegmentKind::kCurrent, current_a, duration_s};
  return {BenchSegmentKind::kResistor, choose_bank(plan.load, plan.cells.count, current_a).resistance_ohm,
          duration_s};
}

Program pulse_program(const BenchPlan& plan, double current_a) {
  const double capacity = schedule_capacity_ah(plan.test, current_a);
  Program program;
  for (const double step : pulse_steps(plan.schedule)) {
    program.once.push_back(load_segment(plan, current_a, pulse_time_s(capacity, step, current_a)));
    program.once.push_back(rest());
  }
  program.again.assign(program.once.end() - 2, program.once.end());
  return program;
}

Program random_program(const BenchPlan& plan) {
  Program program;
  for (const int n : resistor_order(plan.load, kDrawnPulses)) {
    program.once.push_back({BenchSegmentKind::kResistor, high_bank(plan.load, plan.cells.count, n).resistance_ohm,
                            plan.schedule.pulse_s});
    program.once.push_back(rest());
  }
  return program;
}

/// To the next SOC, rest, short discharge, pause, short charge, rest.
void add_hppc_point(const BenchPlan& plan, double current_a, double soc_step, std::vector<BenchSegment>& into) {
  const ScheduleSection& schedule = plan.schedule;
  const double capacity = schedule_capacity_ah(plan.test, schedule.set_current_a);
  into.push_back({BenchSegmentKind::kCurrent, schedule.set_current_a,
                  pulse_time_s(capacity, soc_step, schedule.set_current_a)});
  into.push_back(rest());
  into.push_back({BenchSegmentKind::kCurrent, current_a, schedule.pulse_s});
  into.push_back({BenchSegmentKind::kWait, 0.0, schedule.pulse_rest_s});
  if (schedule.charge_ratio > 0.0) {
    into.push_back({BenchSegmentKind::kCurrent, -schedule.charge_ratio * current_a, schedule.pulse_s});
  }
  into.push_back(rest());
}

Program hppc_program(const BenchPlan& plan, double current_a) {
  Program program;
  const std::vector<double> steps = pulse_steps(plan.schedule);
  for (const double step : steps) add_hppc_point(plan, current_a, step, program.once);
  add_hppc_point(plan, current_a, steps.back(), program.again);
  return program;
}

}  // namespace

double pulse_time_s(double capacity_ah, double soc_step, double current_a) {
  VOLTLAP_DEMAND(capacity_ah > 0.0 && soc_step > 0.0 && current_a > 0.0);
  return kSecondsPerHour * capacity_ah * soc_step / current_a;
}

std::vector<double> pulse_steps(const ScheduleSection& schedule) {
  VOLTLAP_DEMAND(schedule.soc.size() > 1 && schedule.step.size() + 1 >= schedule.soc.size());
  std::vector<double> steps;
  for (std::size_t region = 0; region + 1 < schedule.soc.size(); ++region) {
    const double end = schedule.soc[region + 1];
    for (double soc = schedule.soc[region]; soc > end + kSocTolerance;) {
      const bool fine = schedule.fine_step > 0.0 && soc <= schedule.fine_below + kSocTolerance;
      double step = std::min(fine ? schedule.fine_step : schedule.step[region], soc - end);
      const bool crosses = schedule.fine_step > 0.0 && !fine && soc - step < schedule.fine_below - kSocTolerance;
      if (crosses) step = soc - schedule.fine_below;
      VOLTLAP_DEMAND(step > 0.0);
      steps.push_back(step);
      soc -= step;
    }
  }
  return steps;
}

std::vector<int> resistor_order(const LoadSection& load, std::size_t pulses) {
  std::vector<int> order;
  for (const double n : load.resistors) order.push_back(static_cast<int>(n));
  if (!order.empty()) return order;
  VOLTLAP_DEMAND(load.resistors_max > 1 && load.difference_max > 0);  // else no order ever has enough pulses
  std::mt19937_64 random(static_cast<std::uint64_t>(load.resistor_seed));
  while (order.size() < pulses) {
    // The engine's own numbers: a distribution of the library may differ from one library to the next.
    const int n = 1 + static_cast<int>(random() % static_cast<std::uint64_t>(load.resistors_max));
    const bool allowed = order.empty() || (n != order.back() && std::abs(n - order.back()) <= load.difference_max);
    if (allowed) order.push_back(n);
  }
  return order;
}

std::vector<BenchTest> tests_of(const BenchPlan& plan) {
  std::vector<BenchTest> tests;
  for (const double temperature : plan.test.temperature_c) {
    if (plan.kind == "random") {
      tests.push_back({fmt::format("{}c_random", temperature), temperature, 0.0,
                       fmt::format("1 to {} of the high bank", plan.load.resistors_max)});
      continue;
    }
    for (const double current : plan.test.current_a) {
      const bool cycler = plan.load.kind == "cycler";
      tests.push_back({fmt::format("{}c_{}a", temperature, current), temperature, current,
                       cycler ? fmt::format("cycler, {} A", current)
                              : choose_bank(plan.load, plan.cells.count, current).name()});
    }
  }
  return tests;
}

Program program_of(const BenchPlan& plan, const BenchTest& test) {
  if (plan.kind == "random") return random_program(plan);
  return plan.kind == "hppc" ? hppc_program(plan, test.current_a) : pulse_program(plan, test.current_a);
}

}  // namespace voltlap::plant

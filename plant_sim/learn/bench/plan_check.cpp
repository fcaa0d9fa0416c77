// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/plan_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"
#include "learn/bench/resistor_bank.hpp"

namespace voltlap::plant {
namespace {

class PlanCheck {
 public:
  PlanCheck(const BenchPlan& plan, const std::map<std::string, std::string>& origin, const std::string& file)
      : plan_(plan), origin_(origin), file_(file) {}

  void all() const {
    capacity();
    loads();
    schedule();
    rests();
    cells();
    box();
    sampling();
  }

 private:
  void that(bool ok, const std::string& key, const std::string& found, const std::string& expected,
            const std::string& what_to_do) const {
    if (ok) return;
    const auto known = origin_.find(key);
    throw InputError(known != origin_.end() ? known->second : fmt::format("{}, {}", file_, key), found, expected,
                     what_to_do);
  }

  void capacity() const {
    const TestSection& test = plan_.test;
    if (plan_.kind == "random") return;
    const bool curve = !test.capacity_at_a.empty();
    that(curve ? test.capacity_ah.size() == test.capacity_at_a.size() : test.capacity_ah.size() == 1,
         "test.capacity_ah", fmt::format("{} values", test.capacity_ah.size()),
         curve ? fmt::format("{}, one for each of test.capacity_at_a", test.capacity_at_a.size())
               : std::string("1 value"),
         "Give one capacity, or as many as test.capacity_at_a has currents");
    that(std::is_sorted(test.capacity_at_a.begin(), test.capacity_at_a.end(), std::less_equal<>()),
         "test.capacity_at_a", "currents out of order", "each greater than the one before",
         "Put them in order, with their capacities");
  }

  void loads() const {
    if (plan_.kind == "hppc") {
      that(plan_.load.kind == "cycler", "load.kind", "\"resistor\" in a plan of kind \"hppc\"", "\"cycler\"",
           "A resistor bank cannot charge; set load.kind = \"cycler\"");
    }
    if (plan_.kind == "random") {
      that(plan_.load.kind == "resistor", "load.kind", "\"cycler\" in a plan of kind \"random\"", "\"resistor\"",
           "Set load.kind = \"resistor\"");
    }
    if (plan_.load.kind == "resistor") banks();
  }

  void banks() const {
    const LoadSection& load = plan_.load;
    that(load.high_bank_ohm > 0.0 && load.high_bank_count > 0 && load.nominal_cell_v > 0.0, "load.high_bank_ohm",
         "no resistor bank",
         "load.high_bank_ohm, load.high_bank_count and load.nominal_cell_v with load.kind = \"resistor\"",
         "Add them, or set load.kind = \"cycler\"");
    if (plan_.kind == "random") return random_order();
    for (const double current : plan_.test.current_a) {
      const BankChoice choice = choose_bank(load, plan_.cells.count, current);
      constexpr double kReach = 0.25;  // beyond it the nominal current means nothing
      that(std::abs(choice.nominal_a - current) <= kReach * current, "test.current_a", fmt::format("{} A", current),
           fmt::format("a current that the banks can draw; nearest: {:.0f} A with {}", choice.nominal_a,
                       choice.name()),
           "Change the current or the banks");
    }
  }

  void random_order() const {
    const LoadSection& load = plan_.load;
    that(load.resistors_max <= load.high_bank_count, "load.resistors_max", fmt::format("{}", load.resistors_max),
         fmt::format("at most {}, the size of the high bank", load.high_bank_count), "Correct one of them");
    for (const double n : load.resistors) {
      that(n == std::floor(n) && n <= load.high_bank_count, "load.resistors", fmt::format("{}", n),
           fmt::format("whole numbers from 1 to {}", load.high_bank_count), "Correct the order");
    }
  }

  void schedule() const {
    if (plan_.kind == "random") return;
    const auto& soc = plan_.schedule.soc;
    that(soc.size() >= 2 && std::is_sorted(soc.rbegin(), soc.rend(), std::less_equal<>()), "schedule.soc",
         fmt::format("{} values", soc.size()), "two or more, each less than the one before",
         "Begin at the highest SOC");
    that(plan_.schedule.step.size() + 1 == soc.size(), "schedule.step",
         fmt::format("{} values", plan_.schedule.step.size()),
         fmt::format("{}, one for each stretch of schedule.soc", soc.size() - 1), "Give one step for each stretch");
  }

  void rests() const {
    const RestSection& rest = plan_.rest;
    that(rest.rule != "fixed" || rest.seconds > 0.0, "rest.seconds", fmt::format("{} s", rest.seconds),
         "more than 0 with rest.rule = \"fixed\"", "Give the length of the rests");
    that(rest.max_s > rest.window_s, "rest.max_s", fmt::format("{} s", rest.max_s),
         fmt::format("more than rest.window_s ({} s)", rest.window_s),
         "Make the window shorter or the rest longer");
    that(rest.window_s * plan_.sampling.rate_hz >= 4.0, "rest.window_s", fmt::format("{} s", rest.window_s),
         fmt::format("at least four readings at {} Hz", plan_.sampling.rate_hz), "Make the window longer");
  }

  void cells() const {
    const auto count = static_cast<std::size_t>(plan_.cells.count);
    const auto one_each = [&](const char* key, const std::vector<double>& values) {
      that(values.empty() || values.size() == count, key, fmt::format("{} values", values.size()),
           fmt::format("{}, one for each of cells.count", count), "Give one value a cell, or leave the line out");
    };
    one_each("cells.capacity_scale", plan_.cells.capacity_scale);
    one_each("cells.resistance_scale", plan_.cells.resistance_scale);
    one_each("cells.soc_offset", plan_.cells.soc_offset);
  }

  void box() const {
    const BoxSection& box = plan_.box;
    if (box.mode != "controlled") return;
    for (const double set : plan_.test.temperature_c) {
      that(set > box.air_min_c && set < box.air_max_c, "test.temperature_c", fmt::format("{} degC", set),
           fmt::format("between the air's {} and {} degC (box.air_min_c, box.air_max_c)", box.air_min_c,
                       box.air_max_c),
           "The box can neither heat nor cool cells beyond its air: change the limits or the temperature");
    }
  }

  void sampling() const {
    const double every = plan_.sampling.rate_hz / plan_.sampling.log_hz;
    that(every >= 1.0 && std::abs(every - std::round(every)) < 1e-9 * every, "sampling.log_hz",
         fmt::format("{} Hz", plan_.sampling.log_hz),
         fmt::format("{} Hz (sampling.rate_hz) or an even part of it", plan_.sampling.rate_hz),
         "Choose such a rate");
  }

  const BenchPlan& plan_;
  const std::map<std::string, std::string>& origin_;
  const std::string& file_;
};

}  // namespace

void check_plan(const BenchPlan& plan, const std::map<std::string, std::string>& origin, const std::string& file) {
  PlanCheck(plan, origin, file).all();
}

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// One row for every key of a bench plan: unit, range, which kinds of plan have it, where the value lives, what it
// is.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "learn/bench/plan.hpp"

namespace voltlap::plant {

/// Where a key's value lives; the alternative is also its type.
using PlanAccess = std::variant<double& (*)(BenchPlan&), int& (*)(BenchPlan&), bool& (*)(BenchPlan&),
                                std::string& (*)(BenchPlan&), std::vector<double>& (*)(BenchPlan&)>;

struct PlanRow {
  std::string_view key;
  std::string_view unit;   ///< of a number; for a word its choices ("bath|controlled|free"), empty for free text
  double low, high;        ///< inclusive; of a list, each element
  std::string_view kinds;  ///< kinds of plan that have the key, as in "pulse random"
  bool required;
  PlanAccess access;
  std::string_view meaning;
};

[[nodiscard]] std::span<const PlanRow> plan_rows();
/// The row of a key, or nullptr.
[[nodiscard]] const PlanRow* find_plan_row(std::string_view key);
/// What a value must be, in words: "a number in s from 0 to 86400".
[[nodiscard]] std::string plan_expectation(const PlanRow& row);

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// What a single row of the plan's table cannot say: values that must fit to each other.
#pragma once
#include <map>
#include <string>

#include "learn/bench/plan.hpp"

namespace voltlap::plant {

/// `origin`: for each key that was given, where it stands; `file` stands for keys that were not. Throws InputError.
void check_plan(const BenchPlan& plan, const std::map<std::string, std::string>& origin, const std::string& file);

}  // namespace voltlap::plant

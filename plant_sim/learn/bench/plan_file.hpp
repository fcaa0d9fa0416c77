// SPDX-License-Identifier: Apache-2.0
// Plan files (TOML) and `--set key=value` become a BenchPlan. Precedence: --set, the file, the plan it names as
// `base`.
#pragma once
#include <string>
#include <vector>

#include "core/parameter_file.hpp"
#include "learn/bench/plan.hpp"

namespace voltlap::plant {

/// Throws InputError with file and line for a missing file, bad TOML, an unknown key (with the nearest one), a key
/// that this kind of plan does not have, a wrong type, a value out of range, a missing key, and values that do not
/// fit.
[[nodiscard]] BenchPlan load_plan(const DataFolder& data, const std::string& name_or_path,
                                  const std::vector<std::string>& settings = {});

}  // namespace voltlap::plant

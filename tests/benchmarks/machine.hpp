// SPDX-License-Identifier: Apache-2.0
// On what the numbers were measured.
#pragma once
#include <string>

namespace voltlap::benchmarks {

struct Machine {
  std::string cpu;
  int cores = 0;
  std::string governor, frequency;  ///< "unknown" where the system does not tell
  std::string compiler, build_type, flags, version;
};

[[nodiscard]] Machine this_machine();

}  // namespace voltlap::benchmarks

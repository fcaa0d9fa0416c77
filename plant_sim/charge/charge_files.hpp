// SPDX-License-Identifier: Apache-2.0
// The result files of a charge.
#pragma once
#include <string>
#include <vector>

#include "charge/charge_run.hpp"

namespace voltlap::plant {

/// What a charge was run with.
struct ChargeDescription {
  std::string vehicle;
  std::vector<std::string> settings;
  std::uint64_t seed = 1;
  double from_soc = 0.1, to_soc = 1.0;
  bool drawn_cells = true;
  double wall_s = 0.0;  ///< real time that the run took
};

[[nodiscard]] std::string charge_json(const ChargeDescription& run, const VehicleParameters& car,
                                      const ChargeResult& result);
/// Head and rows, every 10 s.
[[nodiscard]] std::string charge_csv(const std::vector<ChargeSample>& samples);

}  // namespace voltlap::plant

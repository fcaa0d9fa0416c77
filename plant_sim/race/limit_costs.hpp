// SPDX-License-Identifier: Apache-2.0
// What each limit cost: the same race once more with that limit lifted as far as the firmware and the rules allow, and
// the difference.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/parameters.hpp"
#include "race/endurance_result.hpp"

namespace voltlap::plant {

struct LiftedKey {
  std::string key;
  double value;         ///< in the run without the limit
  double from = 0.0;    ///< in the run that is reported
  std::string unit{};
};

struct LimitCost {
  std::string reason;     ///< a limit_reason_name, or "all" for all of them together
  double active_s = 0.0;  ///< how long it bound in the run that is reported
  std::vector<LiftedKey> lifted{};
  std::string failure{};     ///< what the run without it fails of; empty: it finished, and the costs hold
  double time_s = 0.0;       ///< total time with the limit minus without
  double soc_points = 0.0;   ///< end SOC with the limit minus without [percentage points]
};

/// Below this it is not worth a run.
inline constexpr double kLimitTrifle_s = 0.5;

/// The keys that lift a limit, with their values; empty when no key does, or when all are there already.
[[nodiscard]] std::vector<LiftedKey> lifted_keys(std::size_t reason, const VehicleParameters& car);

/// `key=value`, as for --set.
[[nodiscard]] std::vector<std::string> settings_of(const std::vector<LiftedKey>& lifted);

/// Runs the race with more settings; the reason is for the progress line.
using Rerun = std::function<EnduranceResult(const std::string& reason, const std::vector<std::string>& settings)>;

/// A row for each reason that bound for more than a trifle, and one for all when there are several. Ends early, with
/// what it has, when a run was interrupted.
[[nodiscard]] std::vector<LimitCost> limit_costs(const EnduranceResult& result, const VehicleParameters& car,
                                                 const Rerun& rerun);

/// "lifted, the race is 0.23 s faster and ends with 0.20 points of SOC less", or of what it fails then.
[[nodiscard]] std::string cost_text(const LimitCost& cost);
/// "bms.discharge_current_max_a 90 -> 1000 A, ...", with the rule that sets how far.
[[nodiscard]] std::string lifted_text(const LimitCost& cost);

/// Two lines each, with a heading; empty when there are none.
[[nodiscard]] std::string limit_costs_text(const std::vector<LimitCost>& costs);

}  // namespace voltlap::plant

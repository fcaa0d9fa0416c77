// SPDX-License-Identifier: Apache-2.0
// Why the firmware refuses a configuration, in keys and values of the car: the one condition that fails.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "bms/config.hpp"
#include "core/parameters.hpp"
#include "master/config.hpp"

namespace voltlap::plant {

/// How a key must stand to a bound.
enum class Order { kBelow, kAtMost, kAbove, kAtLeast };

/// `key` must be in this order to another key, or to a number that the firmware holds.
struct Refusal {
  std::string_view key;
  Order order = Order::kBelow;
  std::string_view other{};  ///< a key; empty: a number
  double bound = 0.0;        ///< as the firmware holds it, in the unit of `key`
  double step = 0.0;         ///< how finely the firmware counts `key`
  std::string sentence{};    ///< "bms.x = 60 degC is not below bms.y = 60 degC"
  std::string_view reason{}; ///< a rule's id, or why; may be empty
};

/// For each key that was given: "file:line" or "--set key".
using Origins = std::map<std::string, std::string>;

/// What the firmware's own check finds wrong first; nothing when it accepts.
[[nodiscard]] std::optional<Refusal> refusal(const VehicleParameters& car, const bms::Config& config);
[[nodiscard]] std::optional<Refusal> refusal(const VehicleParameters& car, const master::Config& config);

/// Throws InputError when there is one.
void refuse(const std::optional<Refusal>& refusal, const VehicleParameters& car, const Origins& origins);

}  // namespace voltlap::plant

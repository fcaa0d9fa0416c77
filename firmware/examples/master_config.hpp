// SPDX-License-Identifier: Apache-2.0
// The master controller of the example car vtm16e: the defaults of master/config.hpp are its numbers, each with its
// source there. What differs in your car is a line here.
#pragma once
#include "master/config.hpp"

namespace voltlap::master {

inline constexpr Config kMasterConfig = [] {
  Config c{};
  return c;
}();
static_assert(config_check(kMasterConfig) == ConfigError::kNone, "this firmware refuses the configuration");

}  // namespace voltlap::master

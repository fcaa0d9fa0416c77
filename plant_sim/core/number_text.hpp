// SPDX-License-Identifier: Apache-2.0
// Numbers as a person reads them: no exponent, no minus before a zero.
#pragma once
#include <fmt/format.h>

#include <cmath>
#include <string>

namespace voltlap::plant {

/// A value of which `decimals` are shown, 0 where all of them would be zeros: "0.00", never "-0.00".
[[nodiscard]] inline double shown(double value, int decimals) {
  return std::abs(value) < 0.5 * std::pow(10.0, -decimals) ? 0.0 : value;
}

/// Four digits without an exponent; what is smaller than a thousandth is said to be: "<0.001", ">-0.001".
[[nodiscard]] inline std::string short_number(double value) {
  constexpr double kLeast = 1e-3, kWhole = 1e3;
  if (!std::isfinite(value) || value == 0.0) return fmt::format("{:g}", std::abs(value));
  if (std::abs(value) < kLeast) return value > 0.0 ? "<0.001" : ">-0.001";
  return std::abs(value) >= kWhole ? fmt::format("{:.0f}", value) : fmt::format("{:.4g}", value);
}

}  // namespace voltlap::plant

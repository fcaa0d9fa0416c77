// SPDX-License-Identifier: Apache-2.0
// Numbers as a person reads them: no exponent, no minus before a zero, words where there is no number.
#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace voltlap::plant {

/// In the place of a number that the data do not give.
inline constexpr const char* kNotSettled = "not settled";

/// A value of which `decimals` are shown, 0 where all of them would be zeros: "0.00", never "-0.00".
[[nodiscard]] inline double shown(double value, int decimals) {
  return std::abs(value) < 0.5 * std::pow(10.0, -decimals) ? 0.0 : value;
}

/// `digits` significant ones without an exponent: 17434 with three is "17400". What is smaller than a millionth is said
/// to be: "<0.000001".
[[nodiscard]] inline std::string significant(double value, int digits) {
  constexpr int kDecimals = 6;
  if (!std::isfinite(value)) return kNotSettled;
  const double least = std::pow(10.0, -kDecimals);
  if (value == 0.0) return "0";
  if (std::abs(value) < least) return value > 0.0 ? "<0.000001" : ">-0.000001";
  const int decimals = digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(value))));
  const double step = std::pow(10.0, -decimals), rounded = decimals < 0 ? std::round(value / step) * step : value;
  std::string out = fmt::format("{:.{}f}", rounded, std::clamp(decimals, 0, kDecimals));
  if (out.find('.') != std::string::npos) out.erase(out.find_last_not_of('0') + 1);
  if (out.back() == '.') out.pop_back();
  return out;
}

/// Four digits without an exponent; what is smaller than a thousandth is said to be: "<0.001", ">-0.001".
[[nodiscard]] inline std::string short_number(double value) {
  constexpr double kLeast = 1e-3, kWhole = 1e3;
  if (!std::isfinite(value)) return kNotSettled;
  if (value == 0.0) return "0";
  if (std::abs(value) < kLeast) return value > 0.0 ? "<0.001" : ">-0.001";
  return std::abs(value) >= kWhole ? fmt::format("{:.0f}", value) : fmt::format("{:.4g}", value);
}

/// "0.4 to 39.6"; in words where one of its ends is no number.
[[nodiscard]] inline std::string interval_words(double low, double high) {
  if (!std::isfinite(low) || !std::isfinite(high)) return kNotSettled;
  return short_number(low) + " to " + short_number(high);
}

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
#include "io/logs/wrapped_signal.hpp"

#include <algorithm>
#include <vector>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr unsigned kShortest = 8, kLongest = 63;  // bits
constexpr std::size_t kLeastSamples = 3, kLeastCrossings = 5;
constexpr std::size_t kMostBetween = 1000;  // one sample of so many may lie in the middle: a glitch
constexpr std::uint64_t kSmallStep = 64;    // part of the range
constexpr std::uint64_t kCodes = 3;         // below all ones: not available, error, ...
constexpr std::uint64_t kSingleSteps = 4;   // around all ones

/// The steps between the lowest and the highest quarter, counted around the end.
std::vector<std::uint64_t> crossing_steps(std::span<const std::uint64_t> raw, std::uint64_t quarter,
                                          std::uint64_t mask) {
  std::vector<std::uint64_t> out;
  for (std::size_t k = 1; k < raw.size(); ++k) {
    const auto [low, high] = std::minmax(raw[k - 1], raw[k]);
    if (low < quarter && high >= 3 * quarter) out.push_back((low - high) & mask);
  }
  return out;
}

std::uint64_t median_of(std::vector<std::uint64_t> steps) {
  VOLTLAP_DEMAND(!steps.empty());
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

}  // namespace

WrapVerdict wrapped_signal(std::span<const std::uint64_t> raw, unsigned length,
                           const std::function<bool(std::uint64_t raw, bool is_signed)>& fits) {
  WrapVerdict out;
  if (length < kShortest || length > kLongest) return out;
  const std::uint64_t mask = (std::uint64_t{1} << length) - 1, quarter = std::uint64_t{1} << (length - 2);
  std::size_t low = 0, between = 0;
  out.lowest = mask;
  for (const std::uint64_t value : raw) {
    VOLTLAP_DEMAND(value <= mask);
    out.largest = std::max(out.largest, value);
    if (value < quarter) {
      ++low;
    } else if (value < 3 * quarter) {
      ++between;
    } else {
      ++out.negative;
      out.lowest = std::min(out.lowest, value);
    }
  }
  if (low == 0 || out.negative < kLeastSamples || between * kMostBetween > raw.size()) return out;
  const bool fits_signed = fits(out.lowest, true), fits_unsigned = fits(out.largest, false);
  const std::vector<std::uint64_t> steps = crossing_steps(raw, quarter, mask);
  out.crossings = steps.size();
  if (!fits_signed || steps.empty()) return out;
  const std::uint64_t usual = median_of(steps);
  const bool often = steps.size() >= kLeastCrossings;
  if (out.lowest >= mask - kCodes) {
    if (!fits_unsigned && often && usual <= kSingleSteps) out.wrapping = Wrapping::kSigned;
    return out;
  }
  const bool gradual = often && usual <= 4 * quarter / kSmallStep;
  out.wrapping = !fits_unsigned || gradual ? Wrapping::kSigned : Wrapping::kDoubtful;
  return out;
}

}  // namespace voltlap::plant

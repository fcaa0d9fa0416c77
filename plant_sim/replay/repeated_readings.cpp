// SPDX-License-Identifier: Apache-2.0
#include "replay/repeated_readings.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

/// Rows in which the value is another one than before.
std::vector<std::size_t> changes_of(const Channel& channel) {
  std::vector<std::size_t> out;
  for (std::size_t k = 1; k < channel.size(); ++k) {
    if (channel.value[k] != channel.value[k - 1]) out.push_back(k);
  }
  return out;
}

double share_of_changes(const Channel& channel) {
  if (channel.size() < 2) return 0.0;
  return static_cast<double>(changes_of(channel).size()) / static_cast<double>(channel.size());
}

/// Between two changes readings that were the same lie evenly; before the first and after the last, at the period.
std::vector<std::size_t> rows_of_readings(const std::vector<std::size_t>& changes, double period, std::size_t rows) {
  std::vector<std::size_t> out;
  const auto first = static_cast<double>(changes.front()), last = static_cast<double>(changes.back());
  for (double row = first - period * std::floor(first / period); row < first - 0.5; row += period) {
    out.push_back(static_cast<std::size_t>(std::lround(row)));
  }
  if (out.empty() || out.front() != 0) out.insert(out.begin(), 0);
  for (std::size_t j = 0; j + 1 < changes.size(); ++j) {
    const auto from = static_cast<double>(changes[j]), length = static_cast<double>(changes[j + 1]) - from;
    const double parts = std::max(1.0, std::round(length / period));
    for (double k = 0.0; k < parts; ++k) {
      out.push_back(static_cast<std::size_t>(std::lround(from + length * k / parts)));
    }
  }
  for (double row = last; row < static_cast<double>(rows) - 0.5; row += period) {
    out.push_back(static_cast<std::size_t>(std::lround(row)));
  }
  return out;
}

}  // namespace

std::optional<Channel> without_repeats(const Channel& channel, const Channel& live) {
  constexpr std::size_t kFewest = 5, kLeastRows = 3;
  constexpr double kLeast_s = 0.8, kShortest = 0.1, kAlike = 0.9, kLivelier = 2.0, kJitter = 0.2;
  const std::vector<std::size_t> changes = changes_of(channel);
  if (changes.size() < kFewest) return std::nullopt;
  std::vector<double> rows;
  for (std::size_t j = 1; j < changes.size(); ++j) rows.push_back(static_cast<double>(changes[j] - changes[j - 1]));
  const double period = quantile(rows, kShortest);
  const double row_s = median(differences(channel.time_s));
  if (period < static_cast<double>(kLeastRows) || period * row_s < kLeast_s) return std::nullopt;
  const auto on_time = std::count_if(rows.begin(), rows.end(), [&](double n) {
    return std::abs(n - period * std::round(n / period)) <= std::min(1.0, kJitter * period);
  });
  if (static_cast<double>(on_time) < kAlike * static_cast<double>(rows.size())) return std::nullopt;
  if (share_of_changes(live) < kLivelier * share_of_changes(channel)) return std::nullopt;
  Channel out;
  out.role = channel.role;
  out.source = channel.source;
  for (const std::size_t row : rows_of_readings(changes, period, channel.size())) {
    out.time_s.push_back(channel.time_s[row]);
    out.value.push_back(channel.value[row]);
  }
  return out;
}

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// How late frames were sent, over any number of them: counted by the microsecond up to a tenth of a second.
#pragma once
#include <cstdint>
#include <vector>

namespace voltlap::plant {

class Lateness {
 public:
  void add(std::int64_t late_ns);

  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// The lateness [ms] that this share of the frames does not exceed, to the microsecond; beyond 100 ms the worst.
  [[nodiscard]] double quantile_ms(double share) const;
  [[nodiscard]] double worst_ms() const { return 1e-6 * static_cast<double>(worst_ns_); }
  /// Intervals between two frames that were not what they should have been by more than this [ms].
  static constexpr double kSpacing_ms = 1.0;
  [[nodiscard]] std::uint64_t spacings_off() const { return spacings_off_; }

 private:
  static constexpr std::int64_t kBin_ns = 1000, kBins = 100'000;
  std::vector<std::uint64_t> bins_ = std::vector<std::uint64_t>(kBins + 1, 0);
  std::uint64_t count_ = 0, spacings_off_ = 0;
  std::int64_t worst_ns_ = 0, before_ns_ = 0;
};

}  // namespace voltlap::plant

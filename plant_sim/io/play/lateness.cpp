// SPDX-License-Identifier: Apache-2.0
#include "io/play/lateness.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/demand.hpp"

namespace voltlap::plant {

void Lateness::add(std::int64_t late_ns) {
  const std::int64_t bin = std::clamp<std::int64_t>((late_ns + kBin_ns - 1) / kBin_ns, 0, kBins);
  ++bins_[static_cast<std::size_t>(bin)];
  worst_ns_ = std::max(worst_ns_, late_ns);
  // Both frames are as late as each other: the interval is right.
  const double off_ms = 1e-6 * static_cast<double>(std::abs(late_ns - before_ns_));
  if (count_ > 0 && off_ms > kSpacing_ms) ++spacings_off_;
  before_ns_ = late_ns;
  ++count_;
}

double Lateness::quantile_ms(double share) const {
  VOLTLAP_DEMAND(share >= 0.0 && share <= 1.0);
  const double rank = std::ceil(share * static_cast<double>(count_));
  const auto wanted = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(rank));
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    below += bins_[bin];
    if (below >= wanted) return std::min(worst_ms(), 1e-6 * static_cast<double>(kBin_ns) * static_cast<double>(bin));
  }
  return worst_ms();
}

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// What the single samples say together: extremes, sums, and whether everything that must be there is there.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// `start` is when the node began: a sample that never came has waited since then.
void summarise(const Config& config, const Measured& measured, Instant start, Pack& pack);

/// When the sample was last good; one that never was has kept the all-zero time, and has waited since `start`.
template <class T>
[[nodiscard]] Instant waiting_since(const Sample<T>& sample, Instant start) {
  const bool ever_good = sample.time.ms() != 0 || sample.good();
  return ever_good ? sample.time : start;
}

/// |pack voltage - sum of cells| above config.voltage_mismatch of the pack voltage, each cell beside the pack voltage
/// of its own step. Both must be good.
[[nodiscard]] bool voltages_disagree(const Config& config, const Pack& pack);

}  // namespace voltlap::bms

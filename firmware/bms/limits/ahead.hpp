// SPDX-License-Identifier: Apache-2.0
// Limits from what each cell can do for a time, by its own filter: the least of them for Config::limit_horizon. Cells
// are looked at in turn, as their filters are stepped, and the one that limits a discharge in every step, so that none
// carries all. Needs SocMethod::kEkf.
#pragma once
#include "bms/limits/horizon.hpp"
#include "bms/limits/method.hpp"

namespace voltlap::bms {

/// The cells of this step.
void look_ahead(const Config& config, State& state);

void lower_discharge_ahead(const Config& config, const State& state, Limit& limit);
void lower_charge_ahead(const Config& config, const State& state, Limit& limit);

/// How much warmer than what the filters take for the pack's temperature a cell should be [0.1 K]: it has warmed as the
/// coldest thermistor has since the start, times its share of the resistance. Many cells have no thermistor.
[[nodiscard]] std::int32_t own_warmth(const State& state, std::size_t cell);

/// The least over the cells, and the cell that it is of.
struct AheadLimit {
  Current value{};
  std::uint8_t cell = kNoCell;
};
[[nodiscard]] AheadLimit ahead_limit(const Config& config, const State& state, Direction direction,
                                     std::size_t horizon);

}  // namespace voltlap::bms

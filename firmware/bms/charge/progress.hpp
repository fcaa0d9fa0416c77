// SPDX-License-Identifier: Apache-2.0
// Whether a charge comes to its end: what flows into the pack and how the cells come together, judged in windows, so
// that nothing that only moves (a current in the smallest step of the charger, on and off) goes on for ever.
//
//   charging   In ten minutes the pack gains kLeast, a thousandth of its capacity per hour, or half of what the charger
//              may give, whichever of the first two is more and never above the last. Less is full, when the highest
//              cell stood at its voltage, and else ends the charge; cells that are too hot have an hour to cool.
//   all of it  is no more than five quarters of the capacity, so that charging ends in any case
//   bleeding   three hours of shunts bring the spread 1.5 mV nearer, and never 10 mV further apart; of three rounds of
//              charge and bleeds one brings it 0.5 mV nearer
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// So far below its voltage the highest cell counts as held: 2 mV, or what two steps of the charger make of it.
[[nodiscard]] CellVoltage held_within(Resistance resistance);

void begin_progress(Instant now, ChargeProgress& progress);
/// In every step of charging.
void count_progress(const Config& config, Duration elapsed, State& state);

enum class Gain : std::uint8_t { kSome, kFull, kNone };
[[nodiscard]] Gain judge_progress(const Config& config, Instant now, State& state);

/// After every whole look: the cells come together, or it is too early to say that they do not.
[[nodiscard]] bool come_nearer(CellVoltage spread, Charge& charge);

}  // namespace voltlap::bms

// SPDX-License-Identifier: Apache-2.0
// What the stages of the charge remember. All-zero memory: not on a charger, nothing was looked at.
#pragma once
#include <cstdint>

#include "base/persistence.hpp"
#include "base/time.hpp"
#include "base/units.hpp"
#include "bms/curve_tables.hpp"
#include "can_dbc/car.hpp"

namespace voltlap::bms {

/// What the charger said last.
struct ChargerReport {
  Current output{};
  bool faulty = false;       ///< hardware, temperature or input
  bool not_connected = false;  ///< no battery seen, or no command heard
};

/// Written by charge: what has flowed into the pack since it was last judged.
struct ChargeProgress {
  Instant since{};
  std::int64_t gained = 0;       ///< [mA ms] of the window
  std::int64_t total = 0;        ///< [mA ms] since charging was entered
  bool reached = false;          ///< the highest cell stood at its voltage, under little current
  std::uint8_t cooling = 0;      ///< windows without a gain because of the cells' temperature
};

/// Written by charge: whether the cells come together.
struct BalancingProgress {
  CellVoltage least{};           ///< smallest spread since the shunts were first on in this round
  std::int32_t least_at_ms = 0;  ///< bled_ms then
  bool known = false;
  CellVoltage round{};           ///< smallest spread after a charge
  bool round_known = false;
  std::uint8_t fruitless = 0;    ///< rounds of charge and bleeds in a row that brought the cells no nearer
};

/// Written by charge.
struct Charge {
  can::ChargePhase phase = can::ChargePhase::kNone;
  can::ChargeReason reason = can::ChargeReason::kNone;
  Instant entered{};            ///< the phase; when it is none and `lingers`: the end of the charge
  Instant steered{};            ///< the hold
  std::int32_t hold_ua = 0;     ///< [uA] what the highest cell's voltage allows
  Current asked{};              ///< of the charger, whole steps of it
  std::int32_t bled_ms = 0;     ///< time with some shunt on, in this charge
  ChargeProgress progress{};
  BalancingProgress balancing{};
  can::ChargeReason last = can::ChargeReason::kNone;  ///< given up for this: filled once more, then it ends
  std::uint8_t off_cell = kNoCell;  ///< that stands farthest from the others, where balancing was given up
  Instant did{};                ///< when it last charged or bled
  Persistence held{}, not_connected{}, not_asked{}, no_current{};
  bool wants_contactors = false;
  bool after_charging = false;  ///< the rest that goes on follows a charge, not a bleed
  bool lingers = false;         ///< the switch is off, and the charger is still told so
  bool at_once = false;         ///< for one step: what is told has stopped something
};

/// Written by cell_look: cells at rest, without current and without a bleed.
struct CellLook {
  std::int32_t sum[kMaxCells] = {};  ///< [0.1 mV] of the samples so far
  std::uint8_t samples[kMaxCells] = {};
  CellVoltage cell[kMaxCells] = {};  ///< mean of the last whole look
  CellVoltage lowest{}, highest{};
  CellVoltage floor{};               ///< no cell is bled below: where the lowest stood after the last charge
  bool known = false;
  bool rested = false;               ///< for one step: a look is complete that follows a bleed, not a charge
  std::int32_t mean[kMaxCells] = {};  ///< [0.1 mV / 256] of the last samples, while current flows
  CellVoltage highest_now{};         ///< of these means
  Instant bled{};                    ///< when some shunt was last on
};

}  // namespace voltlap::bms

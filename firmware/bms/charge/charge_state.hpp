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

/// Written by charge.
struct Charge {
  can::ChargePhase phase = can::ChargePhase::kNone;
  can::ChargeReason reason = can::ChargeReason::kNone;
  Instant entered{};            ///< the phase; when it is none and `lingers`: the end of the charge
  Instant steered{};            ///< the hold
  std::int32_t hold_ua = 0;     ///< [uA] what the highest cell's voltage allows
  Current asked{};              ///< of the charger, whole steps of it
  std::int32_t bled_ms = 0;     ///< time with some shunt on, in this charge
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
  bool known = false;
  std::int32_t mean[kMaxCells] = {};  ///< [0.1 mV / 256] of the last samples, while current flows
  CellVoltage highest_now{};         ///< of these means
  Instant bled{};                    ///< when some shunt was last on
};

}  // namespace voltlap::bms

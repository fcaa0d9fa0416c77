// SPDX-License-Identifier: Apache-2.0
// The current sensor: its offset is learned while every contactor is open, and its reading is held against the sag of
// the pack's voltage and against the inverter's power, sign included.
//
//   offset:   mean of the reading while nothing can flow; the first 16 readings, then slowly (10 s)
//   sag:      R = -cov(x, z) / cov(x, x) over 4 s, current and pack voltage less their means over 1.6 s: a slow change,
//             as of a pack that runs empty under a limit that follows, has no part in it
//   power:    P = K omega I_phase (below 60 % of the DC link in induced voltage), against V I, both over 0.5 s
#pragma once
#include <cstdint>

#include "base/time.hpp"
#include "base/units.hpp"
#include "bms/config.hpp"
#include "bms/covariance.hpp"

namespace voltlap::bms {

struct State;

/// Written by current_check.
struct CurrentCheck {
  // offset
  Current offset{};               ///< taken off the reading in ingest
  Current reading{};              ///< mean with open contactors
  std::int64_t reading_rest = 0;  ///< [mA / 65536] of the mean, so that it arrives however slowly it moves
  std::uint8_t readings = 0;      ///< of the first ones
  bool offset_known = false;
  bool offset_too_large = false;  ///< now: it reads more than an offset, and nothing can flow
  // sag
  std::int32_t current = 0;       ///< [mA] mean
  std::int32_t voltage = 0;       ///< [0.1 mV] mean
  Covariance answer{};            ///< of the pack
  LastShare fast{}, memory{}, power{};
  bool begun = false;
  bool reversed = false;          ///< the voltage rises with the current
  bool frozen = false;            ///< the voltage moves, the current does not
  // power [mW]
  std::int64_t shaft = 0, battery = 0;
  bool power_wrong = false;       ///< says nothing unless it is judged
  bool power_judged = false;      ///< there is enough power to judge by
};

/// With every reading; `raw`: before the offset is taken off.
void learn_current_offset(Current raw, Instant now, State& state);

/// Once a step, after ingest.
void check_current(const Config& config, Instant now, Duration elapsed, State& state);

}  // namespace voltlap::bms

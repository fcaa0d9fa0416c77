// SPDX-License-Identifier: Apache-2.0
// Whether the car hangs on a charger: what every stage outside of the charge asks.
#pragma once
#include "bms/state.hpp"

namespace voltlap::bms {

/// The charger is plugged and its switch is on, as the car reports it.
[[nodiscard]] inline bool on_charger(const Measured& m) { return m.io.good() && m.io.value.charge_switch; }

/// What is asked may flow: contactors are closed for the charge.
[[nodiscard]] inline bool charges(const State& s) { return s.contactors.state == can::BmsState::kCharging; }

}  // namespace voltlap::bms

// SPDX-License-Identifier: Apache-2.0
#include "bms/charge/balancing.hpp"

#include "base/require.hpp"
#include "bms/charge/on_charger.hpp"

namespace voltlap::bms {
namespace {

// BMS-050, EV.7.3
bool allowed(const Config& config, const State& s) {
  const Sample<Current>& current = s.measured.current;
  const bool resting = current.good() && current.value <= config.balancing_current_max &&
                       -current.value <= config.balancing_current_max;
  return on_charger(s.measured) && charges(s) && s.charge.phase == can::ChargePhase::kBleeding &&
         s.measured.io.value.shutdown_closed && resting && s.pack.cells_good && s.pack.temperatures_good &&
         !s.faults.open && !too_hot_to_bleed(config, s);
}

bool to_bleed(const Config& config, const CellLook& look, std::size_t i) {
  const CellVoltage level = look.lowest + CellVoltage::from_raw(config.balancing_difference.raw() / 2);
  return look.known && look.cell[i] > level && look.cell[i] > look.floor && look.cell[i] > config.balancing_voltage_min;
}

}  // namespace

bool too_hot_to_bleed(const Config& config, const State& s) { return s.pack.temperature_max >= config.derating_start; }

bool some_to_bleed(const Config& config, const CellLook& look) {
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    if (to_bleed(config, look, i)) return true;
  }
  return false;
}

void request_balancing(const Config& config, State& state) {
  VOLTLAP_REQUIRE(config.cells_in_series <= kMaxCells);
  const bool allow = allowed(config, state);
  if (!allow && state.cells_bled == 0) return;  // as nearly always
  state.cells_bled = 0;
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    state.balancing[i] = allow && to_bleed(config, state.look, i);
    if (state.balancing[i]) ++state.cells_bled;
  }
  if (state.cells_bled == 0) state.charge.at_once = true;
}

}  // namespace voltlap::bms

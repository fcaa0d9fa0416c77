// SPDX-License-Identifier: Apache-2.0
#include "bms/balancing.hpp"

#include "base/require.hpp"

namespace voltlap::bms {
namespace {

// BMS-050, EV.7.3
bool allowed(const Config& config, const State& s) {
  const bool shutdown_closed = s.measured.io.good() && s.measured.io.value.shutdown_closed;
  const Sample<Current>& current = s.measured.current;
  const bool resting = current.good() && current.value <= config.balancing_current_max &&
                       -current.value <= config.balancing_current_max;
  return shutdown_closed && resting && s.pack.cells_good && s.pack.temperatures_good && !s.faults.open &&
         s.contactors.state != can::BmsState::kInvalid;
}

}  // namespace

void request_balancing(const Config& config, State& state) {
  VOLTLAP_REQUIRE(config.cells_in_series <= kMaxCells);
  const bool allow = allowed(config, state);
  const CellVoltage level = state.pack.cell_min + config.balancing_difference;
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    const CellVoltage voltage = state.measured.cell[i].value;
    state.balancing[i] = allow && voltage > config.balancing_voltage_min && voltage > level;
  }
}

}  // namespace voltlap::bms

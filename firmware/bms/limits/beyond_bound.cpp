// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/beyond_bound.hpp"

#include "base/require.hpp"
#include "bms/charge/on_charger.hpp"
#include "bms/estimate/cell_model.hpp"

namespace voltlap::bms {
namespace {

/// Of a current that took a cell from its open voltage beyond a bound, what would have taken it to the bound [mA]. The
/// signs of both differences are those of the current.
Current shown(std::int64_t ma, std::int64_t to_bound, std::int64_t to_reading) {
  if (to_bound <= 0) return Current{};
  VOLTLAP_REQUIRE(to_bound < to_reading && ma > 0);
  return Current::saturated(ma * to_bound / to_reading);
}

void note(Instant now, Current most, std::uint8_t cell, ShownLimit& limit) {
  const bool lower = !limit.holds || most < limit.most;
  limit = {lower ? most : limit.most, now, lower ? cell : limit.cell, true};
}

/// A cell in both directions; the current that flows says which of them it may be beyond.
void look_at(const Config& config, Instant now, std::uint8_t cell, State& s) {
  const std::int32_t ma = s.measured.cell_current[cell].raw();
  const CellFilter& filter = s.soc.filter.cell[cell].filter;
  std::uint8_t interval = filter.interval;
  const std::int64_t open = ocv_at(s.soc.filter.model, filter.s, interval).voltage;
  const std::int64_t read = filter_voltage(s.measured.cell[cell].value);
  if (ma > 0 && s.measured.cell[cell].value < config.cell_voltage_min) {
    note(now, shown(ma, open - filter_voltage(config.cell_voltage_min), open - read), cell, s.ahead.shown_discharge);
  } else if (ma < 0 && config.cell_voltage_max < s.measured.cell[cell].value) {
    note(now, shown(-std::int64_t{ma}, filter_voltage(config.cell_voltage_max) - open, read - open), cell,
         s.ahead.shown_charge);
  }
}

void end_when_over(Instant now, ShownLimit& limit) {
  limit.holds = limit.holds && now - limit.seen < kHeldBeyond;
}

}  // namespace

// BMS-047
void note_beyond_bound(const Config& config, State& s) {
  const Instant now = s.measured.current.time;
  end_when_over(now, s.ahead.shown_discharge);
  end_when_over(now, s.ahead.shown_charge);
  if (!s.soc.valid || charges(s) || !s.pack.cells_good || !s.measured.current.good()) return;
  if (config.cell_voltage_min <= s.pack.cell_min && s.pack.cell_max <= config.cell_voltage_max) return;
  for (std::uint16_t k = 0; k < config.cells_in_series; ++k) look_at(config, now, static_cast<std::uint8_t>(k), s);
}

void lower_discharge_beyond_bound(const State& s, Limit& limit) {
  const ShownLimit& shown = s.ahead.shown_discharge;
  if (shown.holds) lower(limit, shown.most, can::LimitReason::kCellVoltage, shown.cell);
}

void lower_charge_beyond_bound(const State& s, Limit& limit) {
  const ShownLimit& shown = s.ahead.shown_charge;
  if (shown.holds) lower(limit, shown.most, can::LimitReason::kCellVoltage, shown.cell);
}

}  // namespace voltlap::bms

// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/ahead.hpp"

#include "base/require.hpp"
#include "bms/bms_step.hpp"
#include "bms/charge/on_charger.hpp"
#include "bms/estimate/soc_ekf.hpp"
#include "bms/limits/beyond_bound.hpp"

namespace voltlap::bms {
namespace {

using can::LimitReason;

constexpr std::int64_t kWarmestTimes = 4;  // chosen: more than a cell that resists four times as much

std::size_t horizon_of(const Config& config) {
  std::size_t i = 0;
  while (i + 1 < kLimitHorizonCount && !(kLimitHorizons[i] == config.limit_horizon)) ++i;
  return i;
}

/// The horizons that do not limit take turns, one direction at a time: they are for who reads them, and can wait.
std::uint8_t next_of(std::uint8_t other, std::size_t binding) {
  std::size_t next = other;
  do {
    next = (next + 1) % (2 * kLimitHorizonCount);
  } while (next / 2 == binding);
  return static_cast<std::uint8_t>(next);
}

/// A cell before currents.
class Look {
 public:
  Look(const Config& config, State& s)
      : s_(s),
        low_{Direction::kDischarge, config.cell_voltage_min, config.discharge_current_max.raw()},
        high_{Direction::kCharge, config.cell_voltage_max,
              max(config.charge_current_max, config.charger_current_max).raw(), !charges(s)} {}

  void at(std::size_t cell, std::size_t index, const Horizon& horizon, bool discharge, bool charge) {
    const CellFilter& filter = s_.soc.filter.cell[cell].filter;
    const HorizonCell here{s_.soc.filter, filter, horizon, prudent_fade(filter), own_warmth(s_, cell)};
    CellAhead& out = s_.ahead.cell[cell];
    if (discharge) out.discharge[index] = current_until(here, low_, out.discharge[index]);
    if (charge) out.charge[index] = current_until(here, high_, out.charge[index]);
  }

  [[nodiscard]] const SocFilter& filter() const { return s_.soc.filter; }

 private:
  State& s_;
  HorizonBound low_, high_;
};

/// As many cells as the filter steps, in a round of their own.
void look_beside(const Config& config, Look& look, Ahead& ahead) {
  const std::size_t index = ahead.other / 2;
  const Horizon horizon = make_horizon(config, look.filter(), kLimitHorizons[index], ahead.heat);
  const bool out = ahead.other % 2 == 0;
  for (std::size_t turn = cells_in_turn(config.cells_in_series); turn > 0; --turn) {
    look.at(ahead.other_cell, index, horizon, out, !out);
    if (++ahead.other_cell < config.cells_in_series) continue;
    ahead.other_cell = 0;
    ahead.other = next_of(ahead.other, horizon_of(config));
    return;
  }
}

std::int32_t mean_scale(const Config& config, const SocFilter& filter) {
  std::int64_t sum = 0;
  for (std::size_t k = 0; k < config.cells_in_series; ++k) sum += filter.cell[k].filter.rho;
  return static_cast<std::int32_t>(sum / config.cells_in_series);
}

}  // namespace

std::int32_t own_warmth(const State& s, std::size_t cell) {
  const SocFilter& f = s.soc.filter;
  const std::int32_t others = (s.pack.temperature_min - f.heat_began).raw(), pack = (f.heat_of - f.heat_began).raw();
  if (!f.heat_known || others <= 0 || s.ahead.scale <= 0) return 0;
  const std::int64_t own = std::int64_t{f.cell[cell].filter.rho} * others / s.ahead.scale;
  return static_cast<std::int32_t>(min(own, kWarmestTimes * others) - pack);
}

AheadLimit ahead_limit(const Config& config, const State& s, Direction direction, std::size_t horizon) {
  VOLTLAP_REQUIRE(config.cells_in_series > 0 && horizon < kLimitHorizonCount);
  AheadLimit out;
  for (std::size_t k = 0; k < config.cells_in_series; ++k) {
    const CellAhead& cell = s.ahead.cell[k];
    const std::int32_t ma = direction == Direction::kDischarge ? cell.discharge[horizon] : cell.charge[horizon];
    if (k > 0 && ma >= out.value.raw()) continue;
    out = {Current::from_raw(ma), static_cast<std::uint8_t>(k)};
  }
  return out;
}

void look_ahead(const Config& config, State& s) {
  if (config.limit_method != LimitMethod::kAhead || !s.soc.valid) return;
  note_beyond_bound(config, s);
  const SocFilter& filter = s.soc.filter;
  const std::size_t cells = config.cells_in_series, binding = horizon_of(config);
  // The others give way to what a step may have to do beside: the start of the filters, what comes 10 times a second,
  // divisions among it for what 0.1 K changes.
  const bool has_time = s.ahead.began && s.steps % kSlowSteps != 0;
  if (!has_time) s.ahead.heat = heat_change(filter);
  const Horizon now = make_horizon(config, filter, kLimitHorizons[binding], s.ahead.heat);
  Look look(config, s);
  for (std::size_t turn = cells_in_turn(config.cells_in_series); turn > 0; --turn) {
    look.at((filter.next + cells - turn) % cells, binding, now, true, true);
  }
  look.at(ahead_limit(config, s, Direction::kDischarge, binding).cell, binding, now, true, true);
  if (s.ahead.other / 2 == binding) s.ahead.other = next_of(s.ahead.other, binding);
  s.ahead.began = true;
  if (has_time) look_beside(config, look, s.ahead);
  // A round has ended with the last cell.
  if (filter.next < cells_in_turn(config.cells_in_series)) s.ahead.scale = mean_scale(config, filter);
}

// BMS-045
void lower_discharge_ahead(const Config& config, const State& s, Limit& limit) {
  const AheadLimit least = ahead_limit(config, s, Direction::kDischarge, horizon_of(config));
  lower(limit, least.value, LimitReason::kCellVoltage, least.cell);
  lower_discharge_beyond_bound(s, limit);
}

// BMS-045
void lower_charge_ahead(const Config& config, const State& s, Limit& limit) {
  const AheadLimit least = ahead_limit(config, s, Direction::kCharge, horizon_of(config));
  lower(limit, least.value, LimitReason::kCellVoltage, least.cell);
  lower_charge_beyond_bound(s, limit);
}

}  // namespace voltlap::bms

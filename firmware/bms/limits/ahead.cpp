// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/ahead.hpp"

#include "base/require.hpp"
#include "bms/charge/on_charger.hpp"
#include "bms/estimate/soc_ekf.hpp"

namespace voltlap::bms {
namespace {

using can::LimitReason;

constexpr std::int64_t kWarmestTimes = 4;  // chosen: more than a cell that resists four times as much

std::size_t horizon_of(const Config& config) {
  std::size_t i = 0;
  while (i + 1 < kLimitHorizonCount && !(kLimitHorizons[i] == config.limit_horizon)) ++i;
  return i;
}

std::uint8_t next_of(std::size_t horizon) {
  return static_cast<std::uint8_t>(horizon + 1 < kLimitHorizonCount ? horizon + 1 : 0);
}

void look(const Config& config, std::size_t cell, std::size_t index, const Horizon& horizon, State& s) {
  const CellFilter& filter = s.soc.filter.cell[cell].filter;
  const HorizonCell here{s.soc.filter, filter, horizon, prudent_fade(filter), own_warmth(s, cell)};
  CellAhead& out = s.ahead.cell[cell];
  const HorizonBound low{Direction::kDischarge, config.cell_voltage_min, config.discharge_current_max.raw()};
  const Current most_in = max(config.charge_current_max, config.charger_current_max);
  const HorizonBound high{Direction::kCharge, config.cell_voltage_max, most_in.raw(), !charges(s)};
  out.discharge[index] = current_until(here, low, out.discharge[index]);
  out.charge[index] = current_until(here, high, out.charge[index]);
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
  return static_cast<std::int32_t>((own > kWarmestTimes * others ? kWarmestTimes * others : own) - pack);
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
  const SocFilter& filter = s.soc.filter;
  const std::size_t cells = config.cells_in_series, binding = horizon_of(config), other = s.ahead.other;
  const Horizon now = make_horizon(config, filter, kLimitHorizons[binding]);
  const Horizon beside = make_horizon(config, filter, kLimitHorizons[other]);
  for (std::size_t turn = cells_in_turn(config.cells_in_series); turn > 0; --turn) {
    const std::size_t cell = (filter.next + cells - turn) % cells;
    look(config, cell, binding, now, s);
    if (other != binding) look(config, cell, other, beside, s);
  }
  look(config, ahead_limit(config, s, Direction::kDischarge, binding).cell, binding, now, s);
  // A round has ended with the last cell.
  if (filter.next >= cells_in_turn(config.cells_in_series)) return;
  s.ahead.other = next_of(other);
  s.ahead.scale = mean_scale(config, filter);
}

// BMS-045
void lower_discharge_ahead(const Config& config, const State& s, Limit& limit) {
  const AheadLimit least = ahead_limit(config, s, Direction::kDischarge, horizon_of(config));
  lower(limit, least.value, LimitReason::kCellVoltage, least.cell);
}

// BMS-045
void lower_charge_ahead(const Config& config, const State& s, Limit& limit) {
  const AheadLimit least = ahead_limit(config, s, Direction::kCharge, horizon_of(config));
  lower(limit, least.value, LimitReason::kCellVoltage, least.cell);
}

}  // namespace voltlap::bms

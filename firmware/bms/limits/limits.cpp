// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/limits.hpp"

#include "base/ramp.hpp"
#include "base/require.hpp"
#include "bms/charge/on_charger.hpp"
#include "bms/faults.hpp"
#include "bms/limits/ahead.hpp"
#include "bms/limits/energy_to_go.hpp"
#include "bms/limits/equation.hpp"
#include "bms/limits/table.hpp"

namespace voltlap::bms {
namespace {

using can::LimitReason;

bool measurements_good(const Config& config, const State& s) {
  return s.pack.cells_good && s.pack.temperatures_good && s.measured.current.good() && soc_ready(config, s.soc) &&
         s.cell_resistance > Resistance{};
}

// BMS-004, BMS-044
/// Why there is no limit but zero; kNone when there is one.
LimitReason blocked_by(const Config& config, const State& s) {
  if (s.faults.open || is_set(s.faults, can::BmsFault::kForeignFrames)) return LimitReason::kFault;
  if (!measurements_good(config, s)) return LimitReason::kMeasurementLost;
  const bool closed = s.contactors.state == can::BmsState::kTsActive || charges(s);
  return closed ? LimitReason::kNone : LimitReason::kContactorsOpen;
}

// BMS-042: linear from the maximum at derating_start to zero at the trip.
Current derated_by_heat(const Config& config, const State& s, Current full) {
  const Temperature span = config.temperature_trip - config.derating_start;
  return share_of_limit(full, (config.temperature_trip - s.pack.temperature_max).raw(), span.raw());
}

// BMS-059: of a charger at derating_start already, for a cell may be warmer than every thermistor.
constexpr Temperature kChargeBand = Temperature::from_raw(100);  // 10 K; chosen
Current derated_on_charger(const Config& config, const State& s, Current full) {
  return share_of_limit(full, (config.derating_start - s.pack.temperature_max).raw(), kChargeBand.raw());
}

}  // namespace

// BMS-040. BMS-051: nothing is drawn on a charger.
Limit discharge_ceiling(const Config& config, const State& s) {
  LimitReason block = blocked_by(config, s);
  if (block == LimitReason::kNone && charges(s)) block = LimitReason::kCharging;
  if (block != LimitReason::kNone) return Limit{Current{}, block, kNoCell};
  Limit limit{config.discharge_current_max, LimitReason::kConfigMaximum, kNoCell};
  lower(limit, derated_by_heat(config, s, config.discharge_current_max), LimitReason::kTemperature);
  if (s.soc.valid && s.soc.value < config.soc_derating_start) {
    lower(limit, share_of_limit(config.discharge_current_max, s.soc.value.raw(), config.soc_derating_start.raw()),
          LimitReason::kSocLow);
  }
  lower_discharge_by_energy(s, limit);
  switch (config.limit_method) {
    case LimitMethod::kEquation: lower_discharge_by_equation(config, s, limit); break;
    case LimitMethod::kTable: lower_discharge_by_table(config, s, limit); break;
    case LimitMethod::kAhead: lower_discharge_ahead(config, s, limit); break;
  }
  VOLTLAP_REQUIRE(Current{} <= limit.value && limit.value <= config.discharge_current_max);
  return limit;
}

// BMS-041: no charging of a frozen cell.
Limit charge_ceiling(const Config& config, const State& s) {
  const LimitReason block = blocked_by(config, s);
  if (block != LimitReason::kNone) return Limit{Current{}, block, kNoCell};
  const Current full = charges(s) ? config.charger_current_max : config.charge_current_max;
  Limit limit{full, LimitReason::kConfigMaximum, kNoCell};
  const bool on_charger = charges(s);
  lower(limit, on_charger ? derated_on_charger(config, s, full) : derated_by_heat(config, s, full),
        LimitReason::kTemperature);
  if (s.pack.temperature_min < config.charge_temperature_min) lower(limit, Current{}, LimitReason::kTemperature);
  switch (config.limit_method) {
    case LimitMethod::kEquation: lower_charge_by_equation(config, s, limit); break;
    case LimitMethod::kTable: lower_charge_by_table(config, s, limit); break;
    case LimitMethod::kAhead: lower_charge_ahead(config, s, limit); break;
  }
  VOLTLAP_REQUIRE(Current{} <= limit.value && limit.value <= full);
  return limit;
}

// BMS-043: falls at once, rises slowly.
Limit follow(const Config& config, Limit previous, Limit ceiling, Duration elapsed) {
  const Ramp<Current> ramp{config.limit_rise_per_s};
  const Current value = ramp.toward(ceiling.value, previous.value, elapsed);
  return value == ceiling.value ? ceiling : Limit{value, previous.reason, previous.cell};
}

void update_limits(const Config& config, Duration elapsed, State& state) {
  follow_caps(config, elapsed, state);
  look_ahead(config, state);
  spread_charge(config, elapsed, state);
  state.limits.discharge = follow(config, state.limits.discharge, discharge_ceiling(config, state), elapsed);
  state.limits.charge = follow(config, state.limits.charge, charge_ceiling(config, state), elapsed);
}

}  // namespace voltlap::bms

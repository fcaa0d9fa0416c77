// SPDX-License-Identifier: Apache-2.0
#include "bms/limits/table.hpp"

#include "base/interpolate.hpp"
#include "bms/charge/on_charger.hpp"

namespace voltlap::bms {
namespace {

using can::LimitReason;

// Shares of the maximum [ppm], straight between the points. Chosen, after the profiles that teams publish.
constexpr std::size_t kPoints = 4;
constexpr Temperature kTemperature[kPoints] = {Temperature::from_raw(-200), Temperature::from_raw(0),
                                               Temperature::from_raw(100), Temperature::from_raw(200)};
constexpr Ratio kDischargeByTemperature[kPoints] = {Ratio::from_raw(100'000), Ratio::from_raw(400'000),
                                                    Ratio::from_raw(700'000), Ratio::from_raw(1'000'000)};
constexpr Ratio kChargeByTemperature[kPoints] = {Ratio::from_raw(0), Ratio::from_raw(100'000),
                                                 Ratio::from_raw(500'000), Ratio::from_raw(1'000'000)};
constexpr Soc kSoc[kPoints] = {Soc::from_raw(0), Soc::from_raw(200'000), Soc::from_raw(800'000),
                               Soc::from_raw(1'000'000)};
constexpr Ratio kDischargeBySoc[kPoints] = {Ratio::from_raw(100'000), Ratio::from_raw(1'000'000),
                                            Ratio::from_raw(1'000'000), Ratio::from_raw(1'000'000)};
constexpr Ratio kChargeBySoc[kPoints] = {Ratio::from_raw(1'000'000), Ratio::from_raw(1'000'000),
                                         Ratio::from_raw(1'000'000), Ratio::from_raw(0)};

constexpr std::int64_t kWhole = 1'000'000;
constexpr std::int64_t kFallTime_ms = 1'000;    // from all to nothing, while a cell is beyond its bound
constexpr std::int64_t kRiseTime_ms = 10'000;   // and back
constexpr CellVoltage kClear = CellVoltage::from_raw(500);  // 50 mV inside the bound a cap comes back

/// As many points as both have.
template <class X, std::size_t points>
Ratio share_at(const X (&x)[points], const Ratio (&share)[points], X at) {
  return interpolate(x, share, points, at);
}

Ratio moved(Ratio cap, CellVoltage inside, Duration elapsed) {
  std::int64_t next = cap.raw();
  if (inside < CellVoltage{}) next -= kWhole * elapsed.ms() / kFallTime_ms;
  if (inside >= kClear) next += kWhole * elapsed.ms() / kRiseTime_ms;
  return Ratio::saturated(next < 0 ? 0 : (next > kWhole ? kWhole : next));
}

}  // namespace

void follow_caps(const Config& config, Duration elapsed, State& s) {
  if (config.limit_method != LimitMethod::kTable || !s.pack.cells_good) return;
  s.caps.discharge = moved(s.caps.discharge, s.pack.cell_min - config.cell_voltage_min, elapsed);
  s.caps.charge = moved(s.caps.charge, config.cell_voltage_max - s.pack.cell_max, elapsed);
}

// BMS-046
void lower_discharge_by_table(const Config& config, const State& s, Limit& limit) {
  const Current most = config.discharge_current_max;
  const Ratio by_cold = share_at(kTemperature, kDischargeByTemperature, s.pack.temperature_min);
  lower(limit, share_of_limit(most, by_cold.raw(), kWhole), LimitReason::kTemperature);
  if (s.soc.valid) {
    lower(limit, share_of_limit(most, share_at(kSoc, kDischargeBySoc, s.soc.value).raw(), kWhole),
          LimitReason::kSocLow);
  }
  lower(limit, share_of_limit(most, s.caps.discharge.raw(), kWhole), LimitReason::kCellVoltage, s.pack.weakest_cell);
}

// BMS-046
void lower_charge_by_table(const Config& config, const State& s, Limit& limit) {
  const Current most = charges(s) ? config.charger_current_max : config.charge_current_max;
  const Ratio by_cold = share_at(kTemperature, kChargeByTemperature, s.pack.temperature_min);
  lower(limit, share_of_limit(most, by_cold.raw(), kWhole), LimitReason::kTemperature);
  // A charger fills the pack: its voltage ends that, not a share.
  const bool shared = s.soc.valid && !charges(s);
  const Ratio by_soc = shared ? share_at(kSoc, kChargeBySoc, s.soc.value) : Ratio::from_raw(kWhole);
  lower(limit, share_of_limit(most, by_soc.raw(), kWhole), LimitReason::kCellVoltage);
  lower(limit, share_of_limit(most, s.caps.charge.raw(), kWhole), LimitReason::kCellVoltage);
}

}  // namespace voltlap::bms

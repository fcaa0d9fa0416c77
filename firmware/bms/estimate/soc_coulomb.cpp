// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_coulomb.hpp"

#include "base/interpolate.hpp"
#include "base/require.hpp"
#include "bms/estimate/cell_model.hpp"

namespace voltlap::bms {
namespace {

constexpr std::int64_t kHalfUnitsPerMah = 2LL * 3'600'000LL;  // 1 mAh = 3.6e6 mA ms
constexpr std::int64_t kFullPpm = 1'000'000;
// A million and the units of a mAh have 100'000 in common. Without it a full pack of 2000 Ah, 1.44e13 units, times a
// million is beyond 64 bits; with it the largest product is 1.44e14.
constexpr std::int64_t kCommon = 100'000;
static_assert(kHalfUnitsPerMah % kCommon == 0 && kFullPpm % kCommon == 0);

std::int64_t capacity(const Config& config) { return config.capacity_mah * kHalfUnitsPerMah; }

// BMS-084: five points beyond either end, so that a count that is off is back soon.
std::int64_t held(const Config& config, std::int64_t charge) {
  const std::int64_t full = capacity(config), beyond = full / 20;
  return charge < -beyond ? -beyond : (charge > full + beyond ? full + beyond : charge);
}

Soc as_soc(const Config& config, std::int64_t charge) {
  const std::int64_t full = capacity(config);
  const std::int64_t inside = charge < 0 ? 0 : (charge > full ? full : charge);
  return Soc::saturated(divide_rounded(inside * (kFullPpm / kCommon), full / kCommon));
}

/// Mean of what a record said of the cells.
Soc restored_soc(const Config& config, const SocFilter& filter) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < config.cells_in_series; ++i) sum += filter.cell[i].filter.s;
  return reported_soc(sum / config.cells_in_series);
}

/// At rest from the OCV, under load from a record.
void start(const Config& config, const SocInput& input, SocEstimate& state) {
  const bool rests = at_rest(config, input.current);
  if (!input.cells_good || !input.current.good() || !(rests || state.filter.restored)) return;
  state.value = rests ? soc_from_ocv(config, input.cells) : restored_soc(config, state.filter);
  state.charge = divide_rounded(state.value.raw() * (capacity(config) / kCommon), kFullPpm / kCommon);
  state.last_current = input.current;
  state.valid = true;
}

}  // namespace

bool at_rest(const Config& config, const Sample<Current>& current) {
  return current.good() && current.value <= config.soc_start_current && -current.value <= config.soc_start_current;
}

// BMS-087
bool count_charge(const Config& config, const Sample<Current>& current, SocEstimate& state) {
  if (!current.good()) return false;
  const std::int64_t elapsed_ms = (current.time - state.last_current.time).ms();
  if (elapsed_ms <= 0) return false;
  const std::int64_t before = state.last_current.value.raw(), longest_ms = config.measurement_lost_time.ms();
  state.charge -=
      elapsed_ms <= longest_ms ? (before + current.value.raw()) * elapsed_ms : 2 * before * longest_ms;
  state.last_current = current;
  return true;
}

Soc soc_from_ocv(const Config& config, const Sample<CellVoltage>* cells) {
  VOLTLAP_REQUIRE(cells != nullptr && config.cells_in_series > 0);
  std::int64_t sum = 0;
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    sum += interpolate(config.ocv.voltage, config.ocv.soc, config.ocv.count, cells[i].value).raw();
  }
  return Soc::saturated(divide_rounded(sum, config.cells_in_series));
}

// BMS-089
void recount_at_rest(const Config& config, const CellVoltage* cells, SocEstimate& state) {
  VOLTLAP_REQUIRE(cells != nullptr && config.cells_in_series > 0);
  if (config.soc_method != SocMethod::kCoulomb || !state.valid) return;
  const auto soc_at = [&](CellVoltage v) {
    return interpolate(config.ocv.voltage, config.ocv.soc, config.ocv.count, v);
  };
  constexpr CellVoltage kDoubt = CellVoltage::from_raw(15);
  std::int64_t sum = 0, doubt = 0;
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    sum += soc_at(cells[i]).raw();
    doubt += soc_at(cells[i]).raw() - soc_at(cells[i] - kDoubt).raw();
  }
  if (doubt > std::int64_t{5'000} * config.cells_in_series) return;
  state.value = Soc::saturated(divide_rounded(sum, config.cells_in_series));
  state.charge = divide_rounded(state.value.raw() * (capacity(config) / kCommon), kFullPpm / kCommon);
}

// BMS-003: SOC within 0.5 points over an endurance with an ideal current sensor.
void soc_coulomb(const Config& config, const SocInput& input, SocEstimate& state) {
  VOLTLAP_REQUIRE(config.capacity_mah > 0);
  if (!state.valid) {
    start(config, input, state);
    return;
  }
  if (!count_charge(config, input.current, state)) return;
  state.charge = held(config, state.charge);
  state.value = as_soc(config, state.charge);
  VOLTLAP_REQUIRE(Soc{} <= state.value && state.value <= Soc::from_raw(kFullPpm));
}

}  // namespace voltlap::bms

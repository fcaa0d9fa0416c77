// SPDX-License-Identifier: Apache-2.0
#include "bms/plausibility.hpp"

#include "base/require.hpp"

namespace voltlap::bms {
namespace {

Instant earlier(Instant a, Instant b) { return (a - b).ms() < 0 ? a : b; }

void summarise_cells(const Config& config, const Measured& measured, Instant start, Pack& pack) {
  std::int64_t sum = 0, by_pack = 0;
  pack.cells_good = true;
  pack.weakest_cell = kNoCell;
  pack.oldest_cell = waiting_since(measured.cell[0], start);
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    const Sample<CellVoltage>& cell = measured.cell[i];
    pack.oldest_cell = earlier(pack.oldest_cell, waiting_since(cell, start));
    if (!cell.good()) {
      pack.cells_good = false;
      continue;
    }
    const bool first = pack.weakest_cell == kNoCell;
    if (first || cell.value < pack.cell_min) {
      pack.cell_min = cell.value;
      pack.weakest_cell = static_cast<std::uint8_t>(i);
    }
    pack.cell_max = first ? cell.value : max(pack.cell_max, cell.value);
    sum += cell.value.raw();
    by_pack += measured.cell_pack[i].raw();
  }
  pack.cell_sum = PackVoltage::saturated(sum);
  pack.sum_by_pack = PackVoltage::saturated(by_pack / config.cells_in_series);
}

void summarise_temperatures(const Config& config, const Measured& measured, Instant start, Pack& pack) {
  pack.temperatures_good = true;
  pack.hottest_sensor = kNoCell;
  pack.oldest_temperature = waiting_since(measured.temperature[0], start);
  for (std::uint16_t i = 0; i < config.temperature_sensors; ++i) {
    const Sample<Temperature>& sensor = measured.temperature[i];
    pack.oldest_temperature = earlier(pack.oldest_temperature, waiting_since(sensor, start));
    if (!sensor.good()) {
      pack.temperatures_good = false;
      continue;
    }
    const bool first = pack.hottest_sensor == kNoCell;
    pack.temperature_min = first ? sensor.value : min(pack.temperature_min, sensor.value);
    if (first || sensor.value > pack.temperature_max) {
      pack.temperature_max = sensor.value;
      pack.hottest_sensor = static_cast<std::uint8_t>(i);
    }
  }
}

}  // namespace

void summarise(const Config& config, const Measured& measured, Instant start, Pack& pack) {
  VOLTLAP_REQUIRE(config.cells_in_series > 0 && config.cells_in_series <= kMaxCells);
  VOLTLAP_REQUIRE(config.temperature_sensors > 0 && config.temperature_sensors <= kMaxTemperatures);
  summarise_cells(config, measured, start, pack);
  summarise_temperatures(config, measured, start, pack);
  VOLTLAP_REQUIRE(pack.weakest_cell == kNoCell || pack.cell_min <= pack.cell_max);
  VOLTLAP_REQUIRE(pack.hottest_sensor == kNoCell || pack.temperature_min <= pack.temperature_max);
  const bool whole = measured.current.good() && measured.pack_voltage.good();
  if (pack.cells_good && pack.temperatures_good && whole) pack.complete_once = true;
}

bool voltages_disagree(const Config& config, const Pack& pack) {
  const std::int64_t by_pack = pack.sum_by_pack.raw();
  const std::int64_t difference = by_pack - pack.cell_sum.raw();
  const std::int64_t size = difference < 0 ? -difference : difference;
  return size * 1'000'000 > by_pack * config.voltage_mismatch.raw();
}

}  // namespace voltlap::bms

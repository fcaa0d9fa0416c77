// SPDX-License-Identifier: Apache-2.0
// A pack of cells that are known in double precision, their filters and their limits, ten milliseconds at a time.
#pragma once
#include "bms/limits/ahead.hpp"

#include "bms/estimate/soc_ekf.hpp"
#include "bms/limits/limits.hpp"
#include "estimate/filter_bench.hpp"

namespace voltlap::bms::test {

struct AheadBench : public Utest {
  Config config = filtered_config();
  State state{};
  std::vector<TrueCell> cells = std::vector<TrueCell>(24);
  std::uint32_t ms = 0;

  void setup() override {
    config.limit_method = LimitMethod::kAhead;
    config.cell_voltage_min = CellVoltage::from_raw(34'000);
    config.cell_voltage_trip_low = CellVoltage::from_raw(30'000);
    state.pack.cells_good = state.pack.temperatures_good = true;
    state.pack.temperature_min = state.pack.temperature_max = Temperature::from_raw(250);
    state.cell_resistance = Resistance::from_raw(2'000);
    state.contactors.state = can::BmsState::kTsActive;
    CHECK(config_check(config) == ConfigError::kNone);
  }
  void step(double amperes) {
    ms += 10;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      cells[i].advance(amperes, 0.01);
      const auto raw = static_cast<std::int32_t>(std::lround(1e4 * cells[i].voltage(config)));
      state.measured.cell[i] = {CellVoltage::from_raw(raw), Instant::from_ms(ms), Quality::kGood};
      state.measured.cell_current[i] = amps(amperes);
    }
    note_extremes();
    state.measured.current = {amps(amperes), Instant::from_ms(ms), Quality::kGood};
    soc_ekf(config, {state.measured.cell, true, state.measured.current, state.measured.cell_current,
                     Instant::from_ms(ms), Temperature::from_raw(250), true}, state.soc);
    update_limits(config, Duration::from_ms(10), state);
    ++state.steps;
  }
  void note_extremes() {
    state.pack.cell_min = state.pack.cell_max = state.measured.cell[0].value;
    for (std::size_t i = 1; i < cells.size(); ++i) {
      state.pack.cell_min = min(state.pack.cell_min, state.measured.cell[i].value);
      state.pack.cell_max = max(state.pack.cell_max, state.measured.cell[i].value);
    }
  }
  [[nodiscard]] Current discharge(std::size_t horizon) const {
    return ahead_limit(config, state, Direction::kDischarge, horizon).value;
  }
};

}  // namespace voltlap::bms::test

// SPDX-License-Identifier: Apache-2.0
// The stage of the charge alone: a pack of 24 cells that is charged, of which each thing can be set.
#pragma once
#include "bms/charge/charge.hpp"
#include "bms/charge/charge_config.hpp"
#include "charge_bench.hpp"

namespace voltlap::bms::test {

struct ChargeStage : public Utest {
  Config config = charge_config();
  State s;
  Charge& c = s.charge;
  std::uint32_t now_ms = 10'000'000;

  ChargeStage() {
    Measured& m = s.measured;
    m.io.quality = m.master.quality = m.charger.quality = m.current.quality = Quality::kGood;
    m.io.value.shutdown_closed = m.io.value.charge_switch = true;
    s.pack.cells_good = s.pack.temperatures_good = true;
    s.pack.temperature_min = s.pack.temperature_max = Temperature::from_raw(250);
    s.contactors.state = can::BmsState::kCharging;
    s.cell_resistance = Resistance::from_raw(2'000);
    s.limits.charge.value = config.charger_current_max;
    s.limits.charge.reason = can::LimitReason::kConfigMaximum;
    all_cells(39'000);
    c.phase = can::ChargePhase::kCharging;
    c.wants_contactors = true;
    c.entered = c.did = c.progress.since = now();
    c.steered = now() + Duration::from_ms(-100);
  }

  [[nodiscard]] Instant now() const { return Instant::from_ms(now_ms); }
  /// Readings, and what has been made of them.
  void all_cells(std::int32_t v) {
    for (std::size_t i = 0; i < 24; ++i) {
      s.measured.cell[i] = {CellVoltage::from_raw(v), Instant{}, Quality::kGood};
      s.look.mean[i] = 256 * v;
    }
  }
  /// The highest cell stands so far [0.1 mV] below the voltage that it is charged to.
  void room(std::int32_t left) { s.look.mean[7] = 256 * (charge_voltage(config).raw() - left); }
  void charging(std::int32_t ma) { s.measured.current.value = Current::from_raw(-ma); }
  void run(bool slow = false, std::int32_t elapsed_ms = 10) {
    run_charge(config, now(), Duration::from_ms(elapsed_ms), slow, s);
  }
  /// A step that is no later for the hold than a tenth of a second.
  void steer() {
    c.steered = now() + Duration::from_ms(-100);
    run(true);
  }
  void expect(can::ChargePhase phase, can::ChargeReason why) const {
    LONGS_EQUAL(static_cast<int>(phase), static_cast<int>(c.phase));
    LONGS_EQUAL(static_cast<int>(why), static_cast<int>(c.reason));
  }
};

}  // namespace voltlap::bms::test

// SPDX-License-Identifier: Apache-2.0
#include "bms/transmit.hpp"

#include "bench.hpp"
#include "can_dbc/charger.hpp"
#include "can_dbc/orion.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

TEST_GROUP(Transmit) {
  codec::Sealer sealer;
  TxQueue tx;
  Output out;
  template <class M>
  M sent() {
    M m;
    for (const Frame& f : tx) {
      if (can::decode(f, m)) return m;
    }
    FAIL("not sent");
    return m;
  }
};

TEST(Transmit, SendsFiveSealedFramesAStepAndTheSixthEveryHundredMilliseconds) {
  int slow = 0;
  for (std::uint32_t t = 0; t < 1000; t += 10) {
    tx.clear();
    out.now = Instant::from_ms(t);
    transmit(out, sealer, tx);
    CHECK(tx.size() == 5 || tx.size() == 6);
    if (tx.size() == 6) ++slow;
    for (const Frame& f : tx) {
      CHECK(codec::sealed_ok(f));
      CHECK(can::sender_of(f.id) == can::Node::kBms);
    }
  }
  LONGS_EQUAL(10, slow);
}

TEST(Transmit, LimitIsNeverRoundedUp) {
  out.now = Instant::from_ms(60);
  for (std::int32_t ma : {0, 1, 99, 100, 149, 150, 199, 200, 999, 1000, 1999}) {
    tx.clear();
    out.limits.discharge.value = Current::from_raw(ma);
    out.limits.charge.value = Current::from_raw(ma);
    transmit(out, sealer, tx);
    LONGS_EQUAL(ma / 100 * 100, sent<can::BmsLimits>().discharge_limit_ma);
    LONGS_EQUAL(ma / 100 * 100, sent<can::BmsLimits>().charge_limit_ma);
    LONGS_EQUAL(ma / 1000 * 1000, sent<can::LimitBroadcast>().pack_dcl_ma);
  }
}

TEST(Transmit, UnknownStateOfChargeIsSentAsInvalid) {
  transmit(out, sealer, tx);
  CHECK_FALSE(sent<can::BmsStatus>().soc_ok);
  tx.clear();
  out.soc_valid = true;
  out.soc = Soc::from_raw(654'320);
  transmit(out, sealer, tx);
  LONGS_EQUAL(654'320, sent<can::BmsStatus>().soc_ppm);
}

TEST(Transmit, DischargeIsPositiveAndRegenerationNegativeOnTheOrionFrameToo) {
  out.current = amps(-12.3);
  out.pack_voltage = PackVoltage::from_raw(936'000);
  transmit(out, sealer, tx);
  LONGS_EQUAL(-12'300, sent<can::PackBroadcast>().pack_current_ma);
  LONGS_EQUAL(936'000, sent<can::PackBroadcast>().pack_voltage_100uv);
}

TEST(Transmit, OneCellAStepComesRoundInOrder) {
  Bench bench;
  bench.idle();
  std::uint8_t expected = static_cast<std::uint8_t>(bench.tick().cell.cell);
  for (int i = 0; i < 60; ++i) {
    expected = static_cast<std::uint8_t>((expected + 1) % 24);
    LONGS_EQUAL(expected, bench.tick().cell.cell);
  }
}

TEST(Transmit, OffAChargerNothingOfAChargeIsSent) {
  for (std::uint32_t t = 0; t < 2000; t += 10) {
    tx.clear();
    out.now = Instant::from_ms(t);
    transmit(out, sealer, tx);
    for (const Frame& f : tx) {
      CHECK(f.id != can::ChargerCommand::kId && f.id != can::ChargeStatus::kId);
      CHECK(f.id < can::BalancingCommand::kBaseId || f.id > can::BalancingCommand::kBaseId + 2);
    }
  }
}

TEST(Transmit, OnAChargerEveryShuntHasItsBitAndWhatStopsIsToldAtOnce) {
  out.charge.on = true;
  out.charge.bled[0] = 1U << 23U;
  out.charge.bled[3] = 5U;
  out.charge.asked = amps(12.3);
  out.charge.voltage_max = PackVoltage::from_raw(1'008'000);
  out.charge.spread = CellVoltage::from_raw(123);
  out.charge.spread_known = true;
  for (std::uint32_t t = 0; t < 500; t += 10) {
    out.now = Instant::from_ms(t);
    tx.clear();
    transmit(out, sealer, tx);
    if (t == 80) CHECK(sent<can::ChargerCommand>().current_max_ma == 12'300);
    if (t == 80) CHECK(sent<can::ChargerCommand>().control == can::ChargerControl::kCharge);
  }
  out.state = can::BmsState::kCharging;
  tx.clear();
  transmit(out, sealer, tx);
  CHECK((sent<can::PackBroadcast>().relay_state & 1U << 7U) != 0);
  tx.clear();
  out.now = Instant::from_ms(30);
  transmit(out, sealer, tx);
  const can::BalancingCommand first = sent<can::BalancingCommand>();
  LONGS_EQUAL(0, first.group);
  LONGS_EQUAL(1 << 23, first.cells[0]);
  tx.clear();
  out.now = Instant::from_ms(40);
  transmit(out, sealer, tx);
  const can::BalancingCommand second = sent<can::BalancingCommand>();
  LONGS_EQUAL(1, second.group);
  LONGS_EQUAL(5, second.cells[1]);
  tx.clear();
  out.now = Instant::from_ms(110);  // nothing is due
  out.charge = ChargeReport{};
  out.charge.on = out.charge.at_once = true;
  transmit(out, sealer, tx);
  LONGS_EQUAL(5 + 4, tx.size());
  CHECK(sent<can::ChargerCommand>().control == can::ChargerControl::kOff);
  LONGS_EQUAL(0, sent<can::ChargerCommand>().voltage_max_100uv);
}

TEST(Transmit, OutputComesBackFromTheFrames) {
  out.now = Instant::from_ms(60);
  out.contactors.air_minus = out.contactors.precharge = true;
  out.waits_for = can::WaitsFor::kSoc;
  out.suspect = 17;
  out.suspect_why = can::SuspectWhy::kRate;
  out.current_offset = Current::from_raw(-500);
  out.current_offset_known = true;
  out.limits.discharge = {amps(300), can::LimitReason::kCellVoltage, 5};
  out.limits.charge = {amps(40), can::LimitReason::kTemperature, 6};
  out.state = can::BmsState::kPrecharge;
  out.faults = 1U << 19U | 1U << 2U;
  out.weakest_cell = 11;
  out.soc = Soc::from_raw(655'000);
  out.soc_valid = true;
  out.temperature_max = Temperature::from_raw(480);
  out.temperature_min = Temperature::from_raw(-70);
  transmit(out, sealer, tx);
  const auto contactors = sent<can::ContactorCommand>();
  CHECK(!contactors.air_plus_close && contactors.air_minus_close && contactors.precharge_close);
  CHECK(contactors.waits_for == can::WaitsFor::kSoc && contactors.suspect_why == can::SuspectWhy::kRate);
  LONGS_EQUAL(17, contactors.suspect);
  CHECK(contactors.current_offset_ok);
  LONGS_EQUAL(-500, contactors.current_offset_ma);
  const auto limits = sent<can::BmsLimits>();
  LONGS_EQUAL(300'000, limits.discharge_limit_ma);
  LONGS_EQUAL(40'000, limits.charge_limit_ma);
  CHECK(limits.discharge_reason == can::LimitReason::kCellVoltage);
  CHECK(limits.charge_reason == can::LimitReason::kTemperature);
  LONGS_EQUAL(5, limits.limiting_cell);
  const auto status = sent<can::BmsStatus>();
  CHECK(status.state == can::BmsState::kPrecharge && status.soc_ok);
  LONGS_EQUAL(1U << 19U | 1U << 2U, status.faults);
  LONGS_EQUAL(11, status.weakest_cell);
  LONGS_EQUAL(655'000, sent<can::PackBroadcast>().pack_soc_ppm);
  const auto slow = sent<can::LimitBroadcast>();
  LONGS_EQUAL(300'000, slow.pack_dcl_ma);
  LONGS_EQUAL(40'000, slow.pack_ccl_ma);
  LONGS_EQUAL(480, slow.high_temperature_dc);
  LONGS_EQUAL(-70, slow.low_temperature_dc);
}

// The bits of RelayState, as the comment of can_dbc/orion.dbc has them.
TEST(Transmit, EachBitOfTheOrionsRelayStateMeansOneThing) {
  const auto bits = [this] {
    tx.clear();
    transmit(out, sealer, tx);
    return static_cast<unsigned>(sent<can::PackBroadcast>().relay_state);
  };
  constexpr unsigned kAlwaysOn = 1U << 5U;
  LONGS_EQUAL(kAlwaysOn, bits());
  out.limits.discharge.value = Current::from_raw(1);
  LONGS_EQUAL(kAlwaysOn | 1U << 0U, bits());
  out.limits.discharge.value = Current{};
  out.limits.charge.value = Current::from_raw(1);
  LONGS_EQUAL(kAlwaysOn | 1U << 1U, bits());
  out.limits.charge.value = Current{};
  for (unsigned fault = 0; fault < 21; ++fault) {
    out.faults = 1U << fault;
    LONGS_EQUAL(kAlwaysOn | 1U << 3U, bits());
  }
  out.faults = 0;
  for (const can::BmsState state : {can::BmsState::kIdle, can::BmsState::kPrecharge, can::BmsState::kTsActive,
                                    can::BmsState::kOpen, can::BmsState::kFault, can::BmsState::kCharging}) {
    out.state = state;
    const unsigned ready = state == can::BmsState::kTsActive ? 1U << 6U : 0U;
    const unsigned charging = state == can::BmsState::kCharging ? 1U << 7U : 0U;
    LONGS_EQUAL(kAlwaysOn | ready | charging, bits());
  }
}

TEST(Transmit, CellThatIsNotMeasuredIsSentAsZeroVolt) {
  out.cell.cell = 9;
  out.cell.voltage = CellVoltage::from_raw(37'123);
  out.cell.open_voltage = CellVoltage::from_raw(38'001);
  out.cell.resistance = Resistance::from_raw(15'430);
  for (const bool good : {true, false}) {
    tx.clear();
    out.cell.good = good;
    out.cell.balancing = good;
    transmit(out, sealer, tx);
    const auto cell = sent<can::CellBroadcast>();
    LONGS_EQUAL(9, cell.cell_id);
    CHECK_EQUAL(good, cell.cell_balancing);
    LONGS_EQUAL(15'430, cell.cell_resistance_uohm);
    LONGS_EQUAL(good ? 37'123 : 0, cell.cell_voltage_100uv);
    LONGS_EQUAL(good ? 38'001 : 0, cell.cell_open_voltage_100uv);
  }
}

TEST(Transmit, ASpreadThatNobodyHasMeasuredIsNone) {
  out.charge.on = true;
  out.charge.spread = CellVoltage::from_raw(123);
  out.now = Instant::from_ms(70);
  transmit(out, sealer, tx);
  CHECK_FALSE(sent<can::ChargeStatus>().spread_ok);
}

TEST(Transmit, ChargeComesBackFromItsFrames) {
  out.charge.on = true;
  out.charge.phase = can::ChargePhase::kBleeding;
  out.charge.reason = can::ChargeReason::kFault;
  out.charge.asked = amps(12.3);
  out.charge.voltage_max = PackVoltage::from_raw(1'008'000);
  out.charge.spread = CellVoltage::from_raw(123);
  out.charge.spread_known = true;
  out.charge.cells_bled = 7;
  out.now = Instant::from_ms(70);
  transmit(out, sealer, tx);
  const auto status = sent<can::ChargeStatus>();
  CHECK(status.phase == can::ChargePhase::kBleeding && status.reason == can::ChargeReason::kFault);
  LONGS_EQUAL(7, status.cells_bled);
  LONGS_EQUAL(123, status.spread_100uv);
  LONGS_EQUAL(12'300, status.current_asked_ma);
  for (const Frame& f : tx) CHECK(f.id != can::ChargerCommand::kId);  // every 500 ms, at 80
  tx.clear();
  out.now = Instant::from_ms(80);
  transmit(out, sealer, tx);
  const auto command = sent<can::ChargerCommand>();
  LONGS_EQUAL(1'008'000, command.voltage_max_100uv);
  LONGS_EQUAL(12'300, command.current_max_ma);
  out.charge.asked = Current{};
  tx.clear();
  transmit(out, sealer, tx);
  CHECK(sent<can::ChargerCommand>().control == can::ChargerControl::kOff);
  LONGS_EQUAL(0, sent<can::ChargerCommand>().voltage_max_100uv);
}

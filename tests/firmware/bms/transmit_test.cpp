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

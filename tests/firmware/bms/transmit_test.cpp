// SPDX-License-Identifier: Apache-2.0
#include "bms/transmit.hpp"

#include "bench.hpp"
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

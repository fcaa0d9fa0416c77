// SPDX-License-Identifier: Apache-2.0
#include "app/bms_node.hpp"

#include "codec/seal.hpp"
#include "firmware/bms/bench.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(BmsNode) {
  app::BmsNode node{bms::test::pack_config()};
  TxQueue tx{};
};

TEST(BmsNode, WithoutAFrameItSendsOpenContactorsAndNoCurrent) {
  can::ContactorCommand contactors;
  can::BmsLimits limits;
  for (std::uint32_t ms = 0; ms < 1'000; ms += 10) {
    tx.clear();
    node.tick(Instant::from_ms(ms), FrameView{}, tx);
    for (const Frame& frame : tx) {
      CHECK(codec::sealed_ok(frame));
      (void)(decode(frame, contactors) || decode(frame, limits));
    }
    CHECK_FALSE(contactors.air_plus_close || contactors.air_minus_close || contactors.precharge_close);
    LONGS_EQUAL(0, limits.discharge_limit_ma);
    LONGS_EQUAL(0, limits.charge_limit_ma);
  }
}

TEST(BmsNode, SendsFiveFramesATickAndTheLimitsEvery100Ms) {
  std::size_t slow = 0;
  for (std::uint32_t ms = 0; ms < 1'000; ms += 10) {
    tx.clear();
    node.tick(Instant::from_ms(ms), FrameView{}, tx);
    CHECK(tx.size() == 5 || tx.size() == 6);
    slow += tx.size() - 5;
  }
  LONGS_EQUAL(10, static_cast<long>(slow));
}

TEST(BmsNode, QueueIsAddedTo) {
  CHECK(tx.push(Frame{}));
  node.tick(Instant{}, FrameView{}, tx);
  CHECK(tx.size() >= 6);
}

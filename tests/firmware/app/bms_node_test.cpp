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

// BMS-090
TEST(BmsNode, ABoardThatFailedItsSelfTestClosesNothingAndSaysWhyWhateverIsAskedOfIt) {
  bms::test::Bench bench;
  node.refuse(can::WaitsFor::kSelfTestMemory);
  for (int tick = 0; tick < 500; ++tick) {
    bench.request(tick > 100);
    bench.master.reset_request = tick / 50 % 2 == 1;
    const Instant now = bench.now();
    bench.tick();
    tx.clear();
    node.tick(now, bench.sent(), tx);
    CHECK(bms::test::all_open(node.output()));
    CHECK(node.output().waits_for == can::WaitsFor::kSelfTestMemory);
    CHECK(node.output().state == can::BmsState::kFault);
    LONGS_EQUAL(0, node.output().limits.discharge.value.raw());
    LONGS_EQUAL(0, node.output().limits.charge.value.raw());
  }
}

// SPDX-License-Identifier: Apache-2.0
#include "examples/self_test.hpp"

#include "firmware/app/bench.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using examples::SelfTest;

namespace {

class Contradicts final : public port::SecondClock {
 public:
  bool right = true;
  bool agrees() override { return right; }
};

}  // namespace

TEST_GROUP(SelfTest) {
  app::BmsNode bms{bms::test::pack_config()};
  app::MasterNode master{master::Config{}};
  can::WaitsFor judged(bool memory_good, std::uint32_t residue) {
    const SelfTest tested(memory_good, residue);
    tested.judge(bms);
    tested.judge(master);
    return bms.state().self_test;
  }
};

TEST(SelfTest, AWholeBoardRefusesNothing) {
  CHECK(judged(true, port::kImageWhole) == can::WaitsFor::kNone);
  CHECK_FALSE(master.refused());
}

// BMS-090
TEST(SelfTest, MemoryThatIsBadIsNamed) {
  CHECK(judged(false, port::kImageWhole) == can::WaitsFor::kSelfTestMemory);
  CHECK(master.refused());
}

// BMS-091
TEST(SelfTest, EveryResidueThatDiffersInABitIsRefusedByBothNodes) {
  for (unsigned bit = 0; bit < 32; ++bit) {
    bms = app::BmsNode{bms::test::pack_config()};
    master = app::MasterNode{master::Config{}};
    CHECK(judged(true, port::kImageWhole ^ 1U << bit) == can::WaitsFor::kSelfTestFlash);
    CHECK(master.refused());
  }
}

TEST(SelfTest, ABoardWithoutASecondClockLosesNone) {
  Contradicts clock;
  CHECK_FALSE(examples::clock_is_lost(nullptr));
  CHECK_FALSE(examples::clock_is_lost(&clock));
  clock.right = false;
  CHECK(examples::clock_is_lost(&clock));
}

// DIA-005
TEST(SelfTest, ARefusalWhileDrivingEndsTorqueAndOpensTheContactorsInTheSameStepAndForGood) {
  app::test::Loop loop;
  loop.start_to_ready();
  loop.pedal(1'000);
  loop.run(500);
  CHECK(loop.command.phase_current_ma > 0 && loop.contactors.air_plus_close);
  loop.bms.refuse(can::WaitsFor::kSelfTestClock);
  loop.master.refuse();
  for (int tick = 0; tick < 500; ++tick) {
    loop.io.reset_button = tick / 40 % 2 == 1;
    loop.io.ts_on_button = tick / 60 % 2 == 1;
    loop.tick();
    LONGS_EQUAL(0, loop.command.phase_current_ma);
    CHECK_FALSE(loop.command.enable);
    CHECK_FALSE(loop.contactors.air_plus_close || loop.contactors.air_minus_close || loop.contactors.precharge_close);
    CHECK(loop.contactors.waits_for == can::WaitsFor::kSelfTestClock);
    LONGS_EQUAL(0, loop.bms_limits.discharge_limit_ma);
  }
}

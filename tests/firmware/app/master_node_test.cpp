// SPDX-License-Identifier: Apache-2.0
#include "app/master_node.hpp"

#include <utility>

#include "firmware/app/bench.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(MasterNode) {
  app::MasterNode node{master::Config{}};
  TxQueue tx{};
};

TEST(MasterNode, WithoutAFrameItSendsZeroAndDisabled) {
  can::InverterCommand command;
  can::MasterStatus status;
  for (std::uint32_t ms = 0; ms < 1'000; ms += 10) {
    tx.clear();
    node.tick(Instant::from_ms(ms), FrameView{}, tx);
    LONGS_EQUAL(2, static_cast<long>(tx.size()));
    CHECK(decode(tx[0], command) && decode(tx[1], status));
    LONGS_EQUAL(0, command.phase_current_ma);
    CHECK_FALSE(command.enable);
    CHECK(status.drive_state == can::DriveState::kLvOn);
    CHECK_FALSE(status.ts_request);
  }
}

// MST-062, and that a whole one drives: ClosedLoop.StartsUpToReadyToDriveThroughPrecharge.
TEST(MasterNode, ABoardThatFailedItsSelfTestGivesNoTorqueWhateverIsAskedOfIt) {
  app::test::Loop loop;
  loop.master.refuse();
  for (int tick = 0; tick < 1'000; ++tick) {
    loop.io.ts_on_button = tick / 20 % 3 == 1;
    loop.io.rtd_button = tick / 30 % 3 == 1;
    loop.io.reset_button = tick / 70 % 2 == 1;
    loop.brake(tick % 100 < 50 ? 20'000 : 0);
    loop.pedal(tick % 100 < 50 ? 0 : 1'000);
    loop.command.enable = true;  // as before any command
    loop.tick();
    CHECK_TEXT(loop.command.enable, "the inverter hears nothing");
    CHECK_FALSE(loop.master_status.ts_request);
    CHECK(loop.in(can::DriveState::kFault));
    CHECK(loop.master.output().faults.has(master::MasterFault::kConfigInvalid));
    CHECK_FALSE(loop.contactors.air_plus_close || loop.contactors.precharge_close);
  }
}

// DIA-003
TEST(MasterNode, ItRestsOnlyWhileNothingIsWantedAndTheBmsHoldsNothingClosed) {
  app::test::Loop loop;
  loop.run(500);
  CHECK(loop.master.rests());
  loop.io.ts_on_button = true;
  loop.run(20);
  loop.io.ts_on_button = false;
  int restless = 0;
  for (int tick = 0; tick < 300; ++tick) {
    loop.tick();
    if (loop.contactors.air_plus_close || loop.contactors.air_minus_close || loop.contactors.precharge_close) {
      CHECK_FALSE(loop.master.rests());
      ++restless;
    }
  }
  CHECK(restless > 200);
  loop.io.shutdown_closed = false;
  loop.run(3'000);
  CHECK(loop.master.rests());
}

// DIA-003: by what the BMS says of its contactors, while the master itself wants nothing.
TEST(MasterNode, ItRestsBesideABmsThatHoldsNothingClosedOrIsNotHeard) {
  using can::BmsState;
  for (const auto& [said, rests] : {std::pair{BmsState::kIdle, true}, {BmsState::kPrecharge, false},
                                    {BmsState::kTsActive, false}, {BmsState::kOpen, true}, {BmsState::kFault, true}}) {
    app::MasterNode listening{master::Config{}};
    codec::Sealer sealer;
    Instant now{};
    for (int k = 0; k < 5; ++k) {
      can::BmsStatus status;
      status.state = said;
      Frame frame;
      encode(status, frame);
      sealer.seal(frame);
      now = now + Duration::from_ms(10);
      listening.tick(now, FrameView{&frame, 1}, tx);
      tx.clear();
    }
    CHECK_EQUAL(rests, listening.rests());
    CHECK_EQUAL(said == BmsState::kFault, listening.output().drive_state == can::DriveState::kFault);
    for (int k = 0; k < 20; ++k) {
      now = now + Duration::from_ms(10);
      listening.tick(now, FrameView{}, tx);
      tx.clear();
    }
    CHECK(listening.rests());
  }
}

// DIA-003
TEST(MasterNode, ItDoesNotRestOnceItAsksForTheTractiveSystem) {
  app::test::Loop loop;
  loop.run(500);
  loop.io.ts_on_button = true;
  CHECK(loop.until([&] { return loop.in(can::DriveState::kTsRequested); }, 100) >= 0);
  CHECK(loop.bms_status.state == can::BmsState::kIdle);
  CHECK_FALSE(loop.master.rests());
}

TEST(MasterNode, FramesThatAreNotItsOwnChangeNothing) {
  Frame strange;
  strange.id = 0x7FF;
  strange.dlc = 8;
  node.tick(Instant::from_ms(0), FrameView{&strange, 1}, tx);
  strange.id = can::Pedals::kId | Frame::kExtendedFlag;
  node.tick(Instant::from_ms(10), FrameView{&strange, 1}, tx);
  CHECK_FALSE(node.output().enable);
}

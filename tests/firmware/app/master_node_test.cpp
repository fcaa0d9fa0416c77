// SPDX-License-Identifier: Apache-2.0
#include "app/master_node.hpp"

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

TEST(MasterNode, FramesThatAreNotItsOwnChangeNothing) {
  Frame strange;
  strange.id = 0x7FF;
  strange.dlc = 8;
  node.tick(Instant::from_ms(0), FrameView{&strange, 1}, tx);
  strange.id = can::Pedals::kId | Frame::kExtendedFlag;
  node.tick(Instant::from_ms(10), FrameView{&strange, 1}, tx);
  CHECK_FALSE(node.output().enable);
}

// SPDX-License-Identifier: Apache-2.0
#include "io/bus/in_process_bus.hpp"

#include <stdexcept>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

Frame frame(std::uint32_t id) {
  Frame f;
  f.id = id;
  f.dlc = 8;
  return f;
}

struct Log : FrameSink {
  std::vector<std::uint32_t> ids, ticks;
  std::vector<Sender> senders;
  void on_frame(std::uint32_t tick, Sender sender, const Frame& f) override {
    ids.push_back(f.id);
    ticks.push_back(tick);
    senders.push_back(sender);
  }
};

}  // namespace

TEST_GROUP(InProcessBus) {
  InProcessBus bus;
};

TEST(InProcessBus, AFrameReachesEveryOtherNodeInOrderAndNotItsSender) {
  bus.send(Sender::kPlant, frame(1));
  bus.send(Sender::kPlant, frame(2));
  bus.send(Sender::kBms, frame(3));
  const FrameView master = bus.receive(Sender::kMaster);
  LONGS_EQUAL(3, master.count);
  for (std::uint32_t i = 0; i < 3; ++i) LONGS_EQUAL(i + 1, master.first[i].id);
  LONGS_EQUAL(2, bus.receive(Sender::kBms).count);
  LONGS_EQUAL(1, bus.receive(Sender::kPlant).count);
}

TEST(InProcessBus, EveryFrameIsHandedOutOnce) {
  bus.send(Sender::kPlant, frame(1));
  LONGS_EQUAL(1, bus.receive(Sender::kBms).count);
  LONGS_EQUAL(0, bus.receive(Sender::kBms).count);
  bus.send(Sender::kPlant, frame(2));
  const FrameView next = bus.receive(Sender::kBms);
  LONGS_EQUAL(1, next.count);
  LONGS_EQUAL(2, next.first[0].id);
}

TEST(InProcessBus, SinksSeeEveryFrameWithTickAndSender) {
  Log log;
  bus.attach(log);
  bus.begin_tick(7);
  bus.send(Sender::kMaster, frame(5));
  bus.begin_tick(8);
  bus.send(Sender::kPlant, frame(6));
  LONGS_EQUAL(2, log.ids.size());
  LONGS_EQUAL(5, log.ids[0]);
  LONGS_EQUAL(7, log.ticks[0]);
  CHECK(log.senders[0] == Sender::kMaster);
  LONGS_EQUAL(8, log.ticks[1]);
}

TEST(InProcessBus, CountsFramesAndTheFullestTick) {
  for (std::uint32_t tick = 0; tick < 3; ++tick) {
    bus.begin_tick(tick);
    for (std::uint32_t i = 0; i <= tick; ++i) bus.send(Sender::kPlant, frame(i));
  }
  bus.begin_tick(3);
  LONGS_EQUAL(6, bus.frames_sent());
  LONGS_EQUAL(3, bus.frames_in_tick_max());
}

TEST(InProcessBus, ANodeThatNeverReceivesIsAnErrorAndNotALostFrame) {
  bool thrown = false;
  try {
    for (std::uint32_t i = 0; i < 1000; ++i) bus.send(Sender::kPlant, frame(i));
  } catch (const std::length_error&) {
    thrown = true;
  }
  CHECK(thrown);
}

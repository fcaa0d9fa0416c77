// SPDX-License-Identifier: Apache-2.0
#include "io/bus/in_process_loop.hpp"

#include <vector>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

/// Each node sends one frame and writes down what it was handed.
struct Nodes : Ecus {
  std::vector<std::uint32_t> bms_heard, master_heard;
  std::uint32_t now_ms = 0;

  void bms(Instant now, FrameView rx, TxQueue& tx) override {
    now_ms = now.ms();
    bms_heard.clear();
    for (const Frame& f : rx) bms_heard.push_back(f.id);
    CHECK(tx.push({0x0C0, 8, {}}));
  }
  void master(Instant, FrameView rx, TxQueue& tx) override {
    master_heard.clear();
    for (const Frame& f : rx) master_heard.push_back(f.id);
    CHECK(tx.push({0x0C2, 8, {}}));
  }
};

}  // namespace

TEST_GROUP(InProcessLoop) {
  Nodes nodes;
  InProcessLoop loop{nodes};
  TxQueue plant;

  void setup() override { CHECK(plant.push({0x0B0, 8, {}})); }
};

TEST(InProcessLoop, EachNodeHearsWhatTheOthersSentSinceItsLastTurn) {
  for (std::uint32_t tick = 0; tick < 3; ++tick) {
    loop.begin_tick(tick);
    const FrameView back = loop.exchange(plant);
    LONGS_EQUAL(2, back.count);
    LONGS_EQUAL(0x0C0, back.first[0].id);
    LONGS_EQUAL(0x0C2, back.first[1].id);
    LONGS_EQUAL(tick * 10, nodes.now_ms);
    const std::vector<std::uint32_t> first = {0x0B0}, later = {0x0C2, 0x0B0}, master = {0x0B0, 0x0C0};
    CHECK((tick == 0 ? first : later) == nodes.bms_heard);
    CHECK(master == nodes.master_heard);
  }
  LONGS_EQUAL(9, loop.frames_sent());
  LONGS_EQUAL(3, loop.frames_in_tick_max());
}

TEST(InProcessLoop, NobodyOutsideAsksForAnything) {
  const Interventions& asked = loop.begin_tick(0);
  CHECK(!asked.driver.accelerator_ok && !asked.driver.brake_ok && asked.faults.empty());
  CHECK(asked.driver.ts_on == can::SwitchOverride::kAutomatic);
  CHECK(loop.lost().empty());
  CHECK(loop.stop_asked() == StopAsked::kNo);
}

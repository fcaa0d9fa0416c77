// SPDX-License-Identifier: Apache-2.0
#include "io/bus/harness_bus.hpp"

#include <unistd.h>

#include <cstring>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

struct Nodes : SuppliedEcus {
  std::vector<std::uint32_t> bms_heard, master_heard;
  std::vector<Sender> lost;
  std::int32_t off_ms = 0;

  void bms(Instant, FrameView rx, TxQueue& tx) override {
    bms_heard.clear();
    for (const Frame& f : rx) bms_heard.push_back(f.id);
    CHECK(tx.push({0x0C0, 8, {}}));
  }
  void master(Instant, FrameView rx, TxQueue& tx) override {
    master_heard.clear();
    for (const Frame& f : rx) master_heard.push_back(f.id);
    CHECK(tx.push({0x0C2, 8, {}}));
  }
  void lose(Sender node) override { lost.push_back(node); }
  void reset(Sender, Instant, Duration off) override { off_ms = off.ms(); }
};

struct Row {
  std::uint32_t id;
  unsigned who;
};

}  // namespace

/// What the harness says is in the pipe before the car reads it: a pipe holds 64 kB.
TEST_GROUP(HarnessBus) {
  int to_car[2] = {-1, -1}, from_car[2] = {-1, -1};
  Nodes nodes;
  TxQueue plant;

  void setup() override {
    LONGS_EQUAL(0, pipe(to_car));
    LONGS_EQUAL(0, pipe(from_car));
    CHECK(plant.push({0x0B0, 8, {}}));
  }
  void teardown() override {
    for (const int end : {to_car[0], to_car[1], from_car[0], from_car[1]}) {
      if (end >= 0) close(end);
    }
  }
  void say(std::vector<Row> rows, std::uint32_t flag = 0) {
    std::vector<std::uint8_t> bytes(8 + 16 * rows.size());
    const auto count = static_cast<std::uint32_t>(rows.size());
    std::memcpy(bytes.data(), &count, 4);
    std::memcpy(bytes.data() + 4, &flag, 4);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::memcpy(bytes.data() + 8 + 16 * i, &rows[i].id, 4);
      bytes[8 + 16 * i + 4] = 8;
      bytes[8 + 16 * i + 5] = static_cast<std::uint8_t>(rows[i].who);
    }
    LONGS_EQUAL(bytes.size(), write(to_car[1], bytes.data(), bytes.size()));
  }
  void request(const Frame& frame) {
    std::uint8_t bytes[24] = {1};
    std::memcpy(bytes + 8, &frame.id, 4);
    bytes[12] = frame.dlc;
    std::memcpy(bytes + 16, frame.data, 8);
    LONGS_EQUAL(24, write(to_car[1], bytes, sizeof bytes));
  }
  std::vector<std::uint32_t> heard() {
    std::uint32_t head[2] = {};
    LONGS_EQUAL(8, read(from_car[0], head, 8));
    std::vector<std::uint32_t> ids;
    for (std::uint32_t i = 0; i < head[0]; ++i) {
      std::uint8_t record[16];
      LONGS_EQUAL(16, read(from_car[0], record, 16));
      ids.push_back(record[0] | record[1] << 8U);
    }
    return ids;
  }
};

TEST(HarnessBus, WithoutGatewayOneBatchATickHasEveryFrame) {
  HarnessBus bus(nodes, to_car[0], from_car[1]);
  say({});
  bus.begin_tick(0);
  LONGS_EQUAL(2, bus.exchange(plant).count);
  CHECK((std::vector<std::uint32_t>{0x0B0, 0x0C0, 0x0C2}) == heard());
  CHECK((std::vector<std::uint32_t>{0x0B0}) == nodes.bms_heard);
  CHECK((std::vector<std::uint32_t>{0x0B0, 0x0C0}) == nodes.master_heard);
}

TEST(HarnessBus, AsAGatewayTheHarnessSaysWhoHearsWhat) {
  HarnessBus bus(nodes, to_car[0], from_car[1]);
  say({}, 1);
  say({{0x0B0, 2}}, 1);              // the plant's frame: only the BMS
  say({{0x0C0, 4}, {0x123, 4}}, 1);  // the BMS's: only the master, and one more
  say({{0x0C2, 1}}, 1);
  bus.begin_tick(0);
  LONGS_EQUAL(1, bus.exchange(plant).count);
  CHECK((std::vector<std::uint32_t>{0x0B0}) == nodes.bms_heard);
  CHECK((std::vector<std::uint32_t>{0x0C0, 0x123}) == nodes.master_heard);
  CHECK((std::vector<std::uint32_t>{0x0B0}) == heard());
  CHECK((std::vector<std::uint32_t>{0x0C0}) == heard());
  CHECK((std::vector<std::uint32_t>{0x0C2}) == heard());
}

TEST(HarnessBus, RequestsOfTheHarnessActInTheTickTheyBegin) {
  HarnessBus bus(nodes, to_car[0], from_car[1]);
  can::MemberReset reset;
  reset.member = can::Member::kBms;
  reset.off_ms = 250;
  Frame frame;
  encode(reset, frame);
  request(frame);
  bus.begin_tick(0);
  LONGS_EQUAL(250, nodes.off_ms);
  can::MemberLost lost;
  lost.member = can::Member::kMaster;
  encode(lost, frame);
  request(frame);
  bus.begin_tick(1);
  CHECK(nodes.lost == std::vector<Sender>{Sender::kMaster});
  LONGS_EQUAL(1, bus.lost().size());
  can::PlantFault fault;
  fault.fault = can::PlantFaultKind::kAirPlusWelded;
  encode(fault, frame);
  request(frame);
  LONGS_EQUAL(1, bus.begin_tick(2).faults.size());
  say({});
  LONGS_EQUAL(0, bus.begin_tick(3).faults.size());
}

TEST(HarnessBus, TheEndOfThePipeEndsTheRun) {
  HarnessBus bus(nodes, to_car[0], from_car[1]);
  close(to_car[1]);
  to_car[1] = -1;
  bus.begin_tick(0);
  CHECK(bus.stop_asked() == StopAsked::kFinished);
  LONGS_EQUAL(0, bus.exchange(plant).count);
}

TEST(HarnessBus, AnEndInsideABatchIsAFailure) {
  HarnessBus bus(nodes, to_car[0], from_car[1]);
  const std::uint32_t head[2] = {3, 0};
  LONGS_EQUAL(8, write(to_car[1], head, 8));
  close(to_car[1]);
  to_car[1] = -1;
  CHECK_THROWS(BusFailure, bus.begin_tick(0));
}

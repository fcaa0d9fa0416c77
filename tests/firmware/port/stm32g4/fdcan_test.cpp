// SPDX-License-Identifier: Apache-2.0
#include "port/stm32g4/fdcan.hpp"

#include <array>
#include <vector>

#include "fake_fdcan.hpp"
#include "firmware/port/stm32/frames.hpp"

using namespace voltlap;
using namespace voltlap::port::stm32g4;
using port::stm32::test::check_same;
using port::stm32::test::frame_of;
using port::stm32::test::queue_of;

TEST_GROUP(FdCan) {
  test::FakeFdCan fake;
  port::stm32::test::Attached attached{&fake.block, sizeof fake.block, fake};
  FdCan can{fake.block, fake.ram};
  FdCan::Config config{170'000'000, 500'000, 875};

  template <std::size_t N>
  CanError init(const can::MessageRow (&rows)[N]) { return can.init(config, rows, N); }
  void start() { CHECK(init(can::kMasterRx) == CanError::kNone); }

  /// The interrupts as the vector table would take them, until the bus is idle.
  std::vector<Frame> run_bus() {
    std::vector<Frame> out;
    for (int i = 0; i < 200; ++i) {
      const auto frame = fake.transmit_one();
      if (!frame) break;
      out.push_back(*frame);
      if (fake.interrupt()) can.on_interrupt();
    }
    return out;
  }
  void arrive(const Frame& frame) {
    CHECK(fake.arrive(frame));
    CHECK(fake.interrupt());
    can.on_interrupt();
  }
  bool next_step(const TxQueue& frames) {
    Frame none;
    can.receive(&none, 0);
    return can.send(frames);
  }
  std::vector<Frame> received() {
    std::vector<Frame> out(200);
    out.resize(can.receive(out.data(), out.size()));
    return out;
  }
};

TEST(FdCan, AShortedBusIsToldAndTheControllerGoesOnBoardWhenItIsMended) {
  fake.bus_recessive = false;
  CHECK(init(can::kMasterRx) == CanError::kNotOnBus);
  CHECK(!fake.arrive(frame_of(0x0B0)));
  fake.bus_recessive = true;
  fake.block.cccr.write(0);  // which the hardware does: INIT was asked to fall, and falls with the 11 bits
  CHECK(!fake.in_init());
  arrive(frame_of(0x0B0));
  LONGS_EQUAL(1, received().size());
}

TEST(FdCan, ExactlyTheIdentifiersOfTheTableArePassed) {
  CHECK(init(can::kBmsRx) == CanError::kNone);
  std::size_t passed = 0;
  for (std::uint32_t id = 0; id < 0x800; ++id) {
    bool wanted = false;
    for (const can::MessageRow& row : can::kBmsRx) wanted = wanted || row.id == id;
    CHECK_EQUAL(wanted, fake.arrive(frame_of(id)));
    CHECK(!fake.arrive(frame_of(id), true));                             // a remote frame of it
    CHECK(!fake.arrive(frame_of(Frame::kExtendedFlag | id)));            // an extended one with its bits low,
    CHECK(!fake.arrive(frame_of(Frame::kExtendedFlag | id << 18)));      // and high
    can.on_interrupt();
    if (wanted) ++passed;
    if (passed % 64 == 63) received();
  }
  for (const can::MessageRow& row : can::kBmsRx) {
    if ((row.id & Frame::kExtendedFlag) == 0) continue;
    arrive(frame_of(row.id));
    ++passed;
    CHECK(!fake.arrive(frame_of(row.id ^ 1U)));
    CHECK(!fake.arrive(frame_of(row.id & 0x7FFU)));
  }
  LONGS_EQUAL(sizeof can::kBmsRx / sizeof can::kBmsRx[0], passed);
  LONGS_EQUAL(passed, can.counts().received);
}

TEST(FdCan, FramesArriveByteForByteInTheirOrder) {
  start();
  std::vector<Frame> sent;
  std::uint8_t mark = 0;
  for (const std::uint8_t dlc : std::array<std::uint8_t, 5>{8, 0, 1, 5, 7}) {
    sent.push_back(frame_of(0x0B0 + mark % 5U, mark, dlc));
    arrive(sent.back());
    ++mark;
  }
  const auto got = received();
  LONGS_EQUAL(sent.size(), got.size());
  for (std::size_t i = 0; i < sent.size(); ++i) check_same(sent[i], got[i]);
  LONGS_EQUAL(0, received().size());
}

TEST(FdCan, BytesBeyondTheLengthAreZeroWhateverTheMailboxHolds) {
  start();
  Frame f = frame_of(0x0B0, 3, 8);
  f.dlc = 3;  // the wire carries three; the registers keep what stood in them
  arrive(f);
  const auto got = received();
  LONGS_EQUAL(0, got[0].data[3] | got[0].data[7]);
}

TEST(FdCan, TwentyFourFramesGoOutInTheOrderOfTheQueueThroughThreeMailboxes) {
  start();
  std::vector<std::uint32_t> ids;
  for (std::uint32_t i = 0; i < TxQueue::kCapacity; ++i) {
    ids.push_back(i % 5 == 4 ? Frame::kExtendedFlag | 0x1806E5F4U : 0x700U - 13U * i);  // later ones more urgent
  }
  const TxQueue queue = queue_of(ids);
  CHECK(can.send(queue));
  const auto out = run_bus();
  LONGS_EQUAL(queue.size(), out.size());
  for (std::size_t i = 0; i < out.size(); ++i) check_same(queue[i], out[i]);
  LONGS_EQUAL(24, can.counts().sent);
  LONGS_EQUAL(0, can.counts().dropped);
}

TEST(FdCan, WhatIsOlderThanAStepNeverGoesOut) {
  start();
  CHECK(can.send(queue_of(std::array<std::uint32_t, 5>{0x10, 0x11, 0x12, 0x13, 0x14})));
  check_same(frame_of(0x10, 0), *fake.transmit_one());  // the bus carries one, and is taken then
  CHECK(!next_step(queue_of(std::array<std::uint32_t, 2>{0x20, 0x21})));
  const auto out = run_bus();
  LONGS_EQUAL(2, out.size());
  check_same(frame_of(0x20, 0), out[0]);
  check_same(frame_of(0x21, 1), out[1]);
  LONGS_EQUAL(4, can.counts().dropped);
  CHECK(next_step(TxQueue{}));
}

TEST(FdCan, AFifoThatRunsOverIsCountedAndKeepsTheOldest) {
  start();
  for (std::uint8_t i = 0; i < 5; ++i) CHECK(fake.arrive(frame_of(0x0B0, i)));
  can.on_interrupt();
  LONGS_EQUAL(1, can.counts().overruns);
  const auto got = received();
  LONGS_EQUAL(3, got.size());
  for (std::uint8_t i = 0; i < 3; ++i) check_same(frame_of(0x0B0, i), got[i]);
  arrive(frame_of(0x0B0, 6));
  LONGS_EQUAL(1, can.counts().overruns);
}

TEST(FdCan, AnInboxThatNobodyEmptiesIsCountedAndKeepsTheOldest) {
  start();
  for (std::uint8_t i = 0; i < 130; ++i) arrive(frame_of(0x0B0, i));
  LONGS_EQUAL(2, can.counts().inbox_full);
  const auto got = received();
  LONGS_EQUAL(128, got.size());
  check_same(frame_of(0x0B0, 0), got[0]);
}

TEST(FdCan, ANodeTakesAsManyAsItHasRoomFor) {
  start();
  for (std::uint8_t i = 0; i < 5; ++i) arrive(frame_of(0x0B0, i));
  Frame two[2];
  LONGS_EQUAL(2, can.receive(two, 2));
  LONGS_EQUAL(3, received().size());
}

TEST(FdCan, SendingBeforeItIsUpIsRefused) {
  CHECK(!can.send(queue_of(std::array<std::uint32_t, 1>{0x10})));
  CHECK(can.send(TxQueue{}));
}

TEST(FdCan, InitWritesTheBitTimingAndLeavesInitialisation) {
  start();
  CHECK(!fake.in_init());
  const std::uint32_t t = fake.bit_timing();
  const std::uint32_t quanta = 1 + (t >> 8 & 0xFFU) + 1 + (t & 0x7FU) + 1;
  UNSIGNED_LONGS_EQUAL(340, quanta * ((t >> 16 & 0x1FFU) + 1));  // 170 MHz over 500 kbit/s
}

TEST(FdCan, InitIsRefusedWithItsReason) {
  config.clock_hz = 170'000'001;
  CHECK(init(can::kMasterRx) == CanError::kBitTiming);
  config.clock_hz = 170'000'000;
  fake.clocked = false;
  CHECK(init(can::kMasterRx) == CanError::kNoInit);
  fake.clocked = true;
  can::MessageRow many[29] = {};
  for (std::uint32_t i = 0; i < 29; ++i) many[i].id = 0x100 + 2 * i;  // each its own run
  CHECK(init(many) == CanError::kFilters);
  can::MessageRow charger[9] = {};
  for (std::uint32_t i = 0; i < 9; ++i) charger[i].id = Frame::kExtendedFlag | (0x100 + 2 * i);
  CHECK(init(charger) == CanError::kFilters);
  CHECK(!can.send(queue_of(std::array<std::uint32_t, 1>{0x10})));
}

TEST(FdCan, ALongAndAShortIdentifierComeThroughFifosOfTheirOwn) {
  CHECK(init(can::kBmsRx) == CanError::kNone);
  for (std::uint8_t i = 0; i < 3; ++i) CHECK(fake.arrive(frame_of(0x0B0, i)));
  CHECK(fake.arrive(frame_of(0x98FF50E5U, 3)));
  can.on_interrupt();
  LONGS_EQUAL(4, received().size());
  LONGS_EQUAL(0, can.counts().overruns);
}

TEST(FdCan, BusOffIsCountedLeftByRecessiveBitsAndSendsNothingOldAfterwards) {
  start();
  CHECK(can.send(queue_of(std::array<std::uint32_t, 5>{0x10, 0x11, 0x12, 0x13, 0x14})));
  fake.go_bus_off();
  const TxQueue one = queue_of(std::array<std::uint32_t, 1>{0x30});
  CHECK(!next_step(one));
  CHECK(can.bus_is_off());
  CHECK(!fake.in_init());  // the recovery has begun
  LONGS_EQUAL(6, can.counts().dropped);
  for (int step = 0; step < 5; ++step) CHECK(!next_step(one));
  LONGS_EQUAL(1, can.counts().bus_off);
  fake.recessive_bits();
  CHECK(next_step(one));
  LONGS_EQUAL(1, can.counts().recovered);
  const auto out = run_bus();
  LONGS_EQUAL(1, out.size());
  check_same(frame_of(0x30, 0), out[0]);
}

TEST(FdCan, TwoNodesOnOneBoardSendInOneStep) {
  start();
  std::vector<std::uint32_t> ids;
  for (std::uint32_t i = 0; i < TxQueue::kCapacity; ++i) ids.push_back(0x100 + i);
  CHECK(next_step(queue_of(ids)));
  CHECK(can.send(queue_of(ids)));
  LONGS_EQUAL(2 * TxQueue::kCapacity, run_bus().size());
  LONGS_EQUAL(0, can.counts().dropped);
}

TEST(FdCan, ReceptionInTheMidstOfASendLeavesTheFramesOfThatAlone) {
  start();
  CHECK(can.send(queue_of(std::array<std::uint32_t, 5>{0x10, 0x11, 0x12, 0x13, 0x14})));
  CHECK(fake.transmit_one().has_value());  // a buffer is free, and the interrupt of that is pending
  const std::uint32_t sending = ir::kTc | ir::kTcf;
  fake.block.ie.clear(sending);  // as send() does
  arrive(frame_of(0x0B0));
  UNSIGNED_LONGS_EQUAL(3, can.counts().sent);
  fake.block.ie.set(sending);
  LONGS_EQUAL(1, received().size());
}

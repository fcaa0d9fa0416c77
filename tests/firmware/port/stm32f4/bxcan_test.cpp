// SPDX-License-Identifier: Apache-2.0
#include "port/stm32f4/bxcan.hpp"

#include <array>
#include <vector>

#include "fake_bxcan.hpp"
#include "firmware/port/stm32/frames.hpp"

using namespace voltlap;
using namespace voltlap::port::stm32f4;
using port::stm32::test::check_same;
using port::stm32::test::frame_of;
using port::stm32::test::queue_of;

TEST_GROUP(BxCan) {
  test::FakeBxCan fake;
  port::stm32::test::Attached attached{&fake.block, sizeof fake.block, fake};
  BxCan can{fake.block, fake.block};
  BxCan::Config config{42'000'000, 500'000, 875, 0, 14};

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
      if (fake.transmit_interrupt()) can.on_transmit_interrupt();
    }
    return out;
  }
  void arrive(const Frame& frame) {
    CHECK(fake.arrive(frame));
    CHECK(fake.receive_interrupt());
    can.on_receive_interrupt();
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

TEST(BxCan, InitWritesTheBitTimingWhileInInitialisationAndLeavesIt) {
  start();
  CHECK(!fake.in_init());
  UNSIGNED_LONGS_EQUAL((6 - 1) | (11 - 1) << 16 | (2 - 1) << 20 | (2 - 1) << 24, fake.bit_timing());
}

TEST(BxCan, InitIsRefusedWithItsReason) {
  config.clock_hz = 41'000'001;
  CHECK(init(can::kMasterRx) == CanError::kBitTiming);
  config.clock_hz = 42'000'000;
  config.banks = 1;
  CHECK(init(can::kMasterRx) == CanError::kFilters);
  config.banks = 29;
  CHECK(init(can::kMasterRx) == CanError::kFilters);
  config.banks = 14;
  fake.clocked = false;
  CHECK(init(can::kMasterRx) == CanError::kNoInit);
  TxQueue one;
  CHECK(one.push(frame_of(0x123)));
  CHECK(!can.send(one));
}

TEST(BxCan, AShortedBusIsToldAndTheControllerGoesOnBoardWhenItIsMended) {
  fake.bus_recessive = false;
  CHECK(init(can::kMasterRx) == CanError::kNotOnBus);
  CHECK(!fake.arrive(frame_of(0x0B0)));
  fake.bus_recessive = true;
  CHECK((fake.block.msr.read() & msr::kInak) == 0);
  arrive(frame_of(0x0B0));
  LONGS_EQUAL(1, received().size());
}

TEST(BxCan, ExactlyTheIdentifiersOfTheTableArePassed) {
  config.banks = 28;
  CHECK(init(can::kBmsRx) == CanError::kNone);
  std::size_t passed = 0;
  for (std::uint32_t id = 0; id < 0x800; ++id) {
    bool wanted = false;
    for (const can::MessageRow& row : can::kBmsRx) wanted = wanted || row.id == id;
    CHECK_EQUAL(wanted, fake.arrive(frame_of(id)));
    CHECK(!fake.arrive(frame_of(id), true));                             // a remote frame of it
    CHECK(!fake.arrive(frame_of(Frame::kExtendedFlag | id)));            // an extended one with its bits low,
    CHECK(!fake.arrive(frame_of(Frame::kExtendedFlag | id << 18)));      // and high
    can.on_receive_interrupt();
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

TEST(BxCan, TheFiltersOfTheBmsTakeFourBanks) {
  config.banks = 4;
  CHECK(init(can::kBmsRx) == CanError::kNone);
  config.banks = 3;
  CHECK(init(can::kBmsRx) == CanError::kFilters);
}

TEST(BxCan, EveryMessageOfTheBusFitsTheBanksOfOneOfTwoControllers) {
  CHECK(init(can::kMessages) == CanError::kNone);
}

TEST(BxCan, TheBanksOfTheOtherControllerStayAsTheyAre) {
  fake.block.fmr.write(1);
  fake.block.bank[20].r1.write(0xABCD);
  fake.block.fa1r.write(1U << 20);
  fake.block.fmr.write(0);
  start();
  UNSIGNED_LONGS_EQUAL(0xABCD, fake.block.bank[20].r1.read());
  CHECK((fake.block.fa1r.read() >> 20 & 1U) != 0);
}

TEST(BxCan, FramesArriveByteForByteInTheirOrder) {
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

TEST(BxCan, BytesBeyondTheLengthAreZeroWhateverTheMailboxHolds) {
  start();
  Frame f = frame_of(0x0B0, 3, 8);
  f.dlc = 3;  // the wire carries three; the registers keep what stood in them
  arrive(f);
  const auto got = received();
  LONGS_EQUAL(0, got[0].data[3] | got[0].data[7]);
}

TEST(BxCan, TwentyFourFramesGoOutInTheOrderOfTheQueueThroughThreeMailboxes) {
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

TEST(BxCan, WhatIsOlderThanAStepNeverGoesOut) {
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

TEST(BxCan, AFifoThatRunsOverIsCountedAndKeepsTheOldest) {
  start();
  for (std::uint8_t i = 0; i < 5; ++i) CHECK(fake.arrive(frame_of(0x0B0, i)));
  can.on_receive_interrupt();
  LONGS_EQUAL(1, can.counts().overruns);
  const auto got = received();
  LONGS_EQUAL(3, got.size());
  for (std::uint8_t i = 0; i < 3; ++i) check_same(frame_of(0x0B0, i), got[i]);
  arrive(frame_of(0x0B0, 6));
  LONGS_EQUAL(1, can.counts().overruns);
}

TEST(BxCan, AnInboxThatNobodyEmptiesIsCountedAndKeepsTheOldest) {
  start();
  for (std::uint8_t i = 0; i < 130; ++i) arrive(frame_of(0x0B0, i));
  LONGS_EQUAL(2, can.counts().inbox_full);
  const auto got = received();
  LONGS_EQUAL(128, got.size());
  check_same(frame_of(0x0B0, 0), got[0]);
}

TEST(BxCan, ANodeTakesAsManyAsItHasRoomFor) {
  start();
  for (std::uint8_t i = 0; i < 5; ++i) arrive(frame_of(0x0B0, i));
  Frame two[2];
  LONGS_EQUAL(2, can.receive(two, 2));
  LONGS_EQUAL(3, received().size());
}

TEST(BxCan, AReleaseThatNeverComesEndsTheInterruptAllTheSame) {
  start();
  CHECK(fake.arrive(frame_of(0x0B0)));
  fake.release_sticks = true;
  can.on_receive_interrupt();
  CHECK(can.counts().received <= 3);
}

TEST(BxCan, BusOffIsCountedLeftByRecessiveBitsAndSendsNothingOldAfterwards) {
  start();
  CHECK(can.send(queue_of(std::array<std::uint32_t, 5>{0x10, 0x11, 0x12, 0x13, 0x14})));
  fake.go_bus_off();
  const TxQueue one = queue_of(std::array<std::uint32_t, 1>{0x30});
  CHECK(!next_step(one));
  CHECK(can.bus_is_off());
  LONGS_EQUAL(1, can.counts().bus_off);
  LONGS_EQUAL(6, can.counts().dropped);
  CHECK(!next_step(one));  // out of initialisation again
  for (int step = 0; step < 5; ++step) CHECK(!next_step(one));  // no recessive bits: still off, asked for once
  LONGS_EQUAL(1, can.counts().bus_off);
  fake.recessive_bits();
  CHECK(next_step(one));
  CHECK(!can.bus_is_off());
  LONGS_EQUAL(1, can.counts().recovered);
  const auto out = run_bus();
  LONGS_EQUAL(1, out.size());
  check_same(frame_of(0x30, 0), out[0]);
  fake.go_bus_off();
  CHECK(!next_step(one));
  LONGS_EQUAL(2, can.counts().bus_off);
}

TEST(BxCan, SendingBeforeItIsUpIsRefused) {
  CHECK(!can.send(queue_of(std::array<std::uint32_t, 1>{0x10})));
  CHECK(can.send(TxQueue{}));
}

TEST(BxCan, TwoNodesOnOneBoardSendInOneStep) {
  start();
  std::vector<std::uint32_t> ids;
  for (std::uint32_t i = 0; i < TxQueue::kCapacity; ++i) ids.push_back(0x100 + i);
  CHECK(next_step(queue_of(ids)));
  CHECK(can.send(queue_of(ids)));
  LONGS_EQUAL(2 * TxQueue::kCapacity, run_bus().size());
  LONGS_EQUAL(0, can.counts().dropped);
}

TEST(BxCan, AnInterruptThatWasPendingInTheMidstOfASendLeavesItsFramesAlone) {
  start();
  CHECK(can.send(queue_of(std::array<std::uint32_t, 5>{0x10, 0x11, 0x12, 0x13, 0x14})));
  CHECK(fake.transmit_one().has_value());
  fake.block.ier.clear(ier::kTmeie);  // as send() does
  can.on_transmit_interrupt();
  UNSIGNED_LONGS_EQUAL(3, can.counts().sent);
  fake.block.ier.set(ier::kTmeie);
  can.on_transmit_interrupt();
  UNSIGNED_LONGS_EQUAL(4, can.counts().sent);
}

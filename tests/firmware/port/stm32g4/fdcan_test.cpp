// SPDX-License-Identifier: Apache-2.0
#include "port/stm32g4/fdcan.hpp"

#include <array>
#include <vector>

#include "fake_fdcan.hpp"
#include "firmware/port/stm32/controller_bench.hpp"

using namespace voltlap;
using namespace voltlap::port::stm32g4;
using port::stm32::test::check_same;
using port::stm32::test::frame_of;
using port::stm32::test::queue_of;

struct FdCanPart {
  using Fake = port::stm32g4::test::FakeFdCan;
  using Driver = FdCan;
  static FdCan make(Fake& fake) { return {fake.block, fake.ram}; }
  static FdCan::Config config() { return {170'000'000, 500'000, 875}; }
  static bool take_interrupts(Fake& fake, FdCan& can) {
    if (!fake.interrupt()) return false;
    can.on_interrupt();
    return true;
  }
};

TEST_GROUP_BASE(FdCan, port::stm32::test::ControllerBench<FdCanPart>){};

VOLTLAP_CONTROLLER_TESTS(FdCan)

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

// SPDX-License-Identifier: Apache-2.0
#include "port/stm32f4/bxcan.hpp"

#include "port/stm32/heard.hpp"

#include <array>
#include <vector>

#include "fake_bxcan.hpp"
#include "firmware/port/stm32/controller_bench.hpp"

using namespace voltlap;
using namespace voltlap::port::stm32f4;
using port::stm32::test::check_same;
using port::stm32::test::frame_of;
using port::stm32::test::queue_of;

struct BxCanPart {
  using Fake = port::stm32f4::test::FakeBxCan;
  using Driver = BxCan;
  static BxCan make(Fake& fake) { return {fake.block, fake.block}; }
  static BxCan::Config config() { return {42'000'000, 500'000, 875, 0, 14}; }
  static bool take_interrupts(Fake& fake, BxCan& can) {
    const bool receives = fake.receive_interrupt(), transmits = fake.transmit_interrupt();
    if (receives) can.on_receive_interrupt();
    if (transmits) can.on_transmit_interrupt();
    return receives || transmits;
  }
};

TEST_GROUP_BASE(BxCan, port::stm32::test::ControllerBench<BxCanPart>){};

VOLTLAP_CONTROLLER_TESTS(BxCan)

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

TEST(BxCan, TheFiltersOfTheBmsTakeSixBanks) {
  config.banks = 6;
  CHECK(init(can::kBmsRx) == CanError::kNone);
  config.banks = 5;
  CHECK(init(can::kBmsRx) == CanError::kFilters);
}

TEST(BxCan, EveryMessageOfTheBusFitsTheBanksOfOneOfTwoControllers) {
  CHECK(init(can::kMessages) == CanError::kNone);
}

// DIA-006
TEST(BxCan, EachNodeHearsATestersQuestionsToItselfAndThoseToNoOther) {
  constexpr std::uint32_t kToBms = diagnostic_id(kBmsAddress, kTesterAddress);
  constexpr std::uint32_t kToMaster = diagnostic_id(kMasterAddress, kTesterAddress);
  for (const unsigned nodes : {1U, 2U, 3U}) {
    const port::stm32::HeardRows heard = port::stm32::heard_by((nodes & 1U) != 0, (nodes & 2U) != 0);
    CHECK(can.init(config, heard.rows, heard.count) == CanError::kNone);
    CHECK_EQUAL((nodes & 1U) != 0, fake.arrive(frame_of(kToBms)));
    CHECK_EQUAL((nodes & 2U) != 0, fake.arrive(frame_of(kToMaster)));
    CHECK(!fake.arrive(frame_of(kToMaster + 1)));
    received();
  }
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

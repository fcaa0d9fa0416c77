// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/systick.hpp"

#include "fake_registers.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::port::stm32;

TEST_GROUP(SysTick) {
  SysTickRegisters block;
  SysTick clock{block};
  void teardown() override { test::on_wait_for_interrupt({}); }
};

TEST(SysTick, AMillisecondIsAsManyCountsAsTheClockSays) {
  CHECK(clock.start(168'000'000));
  UNSIGNED_LONGS_EQUAL(167'999, block.rvr.read());
  UNSIGNED_LONGS_EQUAL(7, block.csr.read());
}

TEST(SysTick, AClockThatItCannotCountIsRefused) {
  CHECK(!clock.start(0));
  CHECK(!clock.start(1'000));
  CHECK(!clock.start(168'000'500));
  UNSIGNED_LONGS_EQUAL(0, block.csr.read());
}

TEST(SysTick, SleepEndsAtItsInstantAndAtOnceWhenThatHasPassed) {
  CHECK(clock.start(168'000'000));
  int wakes = 0;
  test::on_wait_for_interrupt([&] {
    if (++wakes % 3 == 0) clock.on_interrupt();  // others wake it as well
  });
  clock.sleep_until(Instant::from_ms(10));
  UNSIGNED_LONGS_EQUAL(10, clock.now().ms());
  LONGS_EQUAL(30, wakes);
  clock.sleep_until(Instant::from_ms(4));
  LONGS_EQUAL(30, wakes);
}

TEST(SysTick, SleepGoesAcrossTheWrap) {
  CHECK(clock.start(168'000'000));
  test::on_wait_for_interrupt([&] { clock.on_interrupt(); });
  clock.sleep_until(Instant::from_ms(5));
  clock.sleep_until(Instant::from_ms(0xFFFF'FFF0U));  // in the past by the shorter way round
  UNSIGNED_LONGS_EQUAL(5, clock.now().ms());
}

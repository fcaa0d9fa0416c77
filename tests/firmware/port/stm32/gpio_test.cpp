// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/gpio.hpp"

#include "fake_registers.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::port;
using namespace voltlap::port::stm32;

namespace {

/// BSRR reads as 0, sets with its low half and resets with its high one; setting wins (RM0090 8.4.7).
class FakePort final : public test::Model {
 public:
  GpioRegisters block{};
  std::uint32_t moder = 0, otyper = 0, pupdr = 0, odr = 0, level = 0;
  bool was_driven_wrongly = false;  ///< an output was on before anyone asked for it

  std::uint32_t read(std::size_t offset) override {
    switch (offset) {
      case 0x00: return moder;
      case 0x04: return otyper;
      case 0x0C: return pupdr;
      case 0x10: return level;
      case 0x14: return odr;
      default: return 0;
    }
  }
  void write(std::size_t offset, std::uint32_t value) override {
    switch (offset) {
      case 0x00: moder = value; break;
      case 0x04: otyper = value; break;
      case 0x0C: pupdr = value; break;
      case 0x14: odr = value; break;
      case 0x18: odr = (odr & ~(value >> 16)) | (value & 0xFFFFU); break;
      default: break;
    }
    if (output(3) && high(3)) was_driven_wrongly = true;
    if (output(4) && !high(4)) was_driven_wrongly = true;
  }
  [[nodiscard]] bool output(unsigned pin) const { return (moder >> (2 * pin) & 3U) == 1; }
  [[nodiscard]] bool high(unsigned pin) const { return (odr >> pin & 1U) != 0; }
};

}  // namespace

TEST_GROUP(BoardPins) {
  FakePort port;
  test::Attached attached{&port.block, sizeof port.block, port};
  Pins pins() {
    Pins p;
    p.drive[static_cast<int>(Drive::kAirPlus)] = {&port.block, 3, false};
    p.drive[static_cast<int>(Drive::kPrecharge)] = {&port.block, 4, true};
    p.sense[static_cast<int>(Sense::kShutdownClosed)] = {&port.block, 8, false};
    p.sense[static_cast<int>(Sense::kResetButton)] = {&port.block, 9, true};
    return p;
  }
};

TEST(BoardPins, InitNeverDrivesARelayOnItsWayAndPullsSensesToWhatOpens) {
  BoardPins board(pins());
  port.odr = 1U << 3;  // whatever the boot loader left
  CHECK(board.init());
  CHECK(!port.was_driven_wrongly);
  CHECK(port.output(3) && port.output(4) && !port.high(3) && port.high(4));
  UNSIGNED_LONGS_EQUAL(2, port.pupdr >> 16 & 3U);
  UNSIGNED_LONGS_EQUAL(1, port.pupdr >> 18 & 3U);
}

TEST(BoardPins, DrivesAndSensesFollowTheirPolarity) {
  BoardPins board(pins());
  CHECK(board.init());
  board.set(Drive::kAirPlus, true);
  board.set(Drive::kPrecharge, true);
  CHECK(port.high(3) && !port.high(4));
  board.set(Drive::kAirPlus, false);
  board.set(Drive::kPrecharge, false);
  CHECK(!port.high(3) && port.high(4));
  port.level = 1U << 8;
  CHECK(board.get(Sense::kShutdownClosed) && board.get(Sense::kResetButton));
  port.level = 1U << 9;
  CHECK(!board.get(Sense::kShutdownClosed) && !board.get(Sense::kResetButton));
}

TEST(BoardPins, WhatTheBoardDoesNotHaveIsFalseAndIgnored) {
  BoardPins board(pins());
  CHECK(board.init());
  board.set(Drive::kRtdSound, true);
  CHECK(!board.get(Sense::kTsOnButton));
}

TEST(BoardPins, APinNamedTwiceOrBeyondThePortIsRefusedAndNothingDriven) {
  Pins twice = pins();
  twice.sense[0].number = 3;
  CHECK(!BoardPins(twice).init());
  Pins beyond = pins();
  beyond.drive[0].number = 16;
  CHECK(!BoardPins(beyond).init());
  UNSIGNED_LONGS_EQUAL(0, port.moder);
}

// SPDX-License-Identifier: Apache-2.0
// No frame that is missing, repeated, damaged or impossible keeps the torque on, and the time it takes.
#include "firmware/app/bench.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::app::test;

namespace {

// What torque may not outlive. MotorTemperatures come every 100 ms and have 500 ms.
struct Row {
  std::uint32_t id;
  const char* name;
  std::int32_t timeout_ms;
};
constexpr Row kCarrying[] = {
    {can::Pedals::kId, "Pedals", 50},
    {can::InverterStatus::kId, "InverterStatus", 50},
    {can::VehicleIo::kId, "VehicleIo", 50},
    {can::BmsLimits::kId, "BmsLimits", 50},
    {can::BmsStatus::kId, "BmsStatus", 50},
    {can::MotorTemperatures::kId, "MotorTemperatures", 500},
};

}  // namespace

TEST_GROUP(LostFrames) {
  /// Time from the last good frame to zero torque. The first tick of a fault comes one cycle after that frame.
  static std::int32_t ms_to_zero(Loop& loop, std::int32_t first_ms) {
    const std::int32_t took = loop.until([&loop] { return loop.command.phase_current_ma == 0; }, 2'000);
    return took < 0 ? took : took + first_ms;
  }
  /// To the tick after one with motor temperatures, so that their age is known too.
  static void align(Loop& loop) {
    while (loop.now_ms % 100 != 60) loop.tick();
  }
};

// MST-060
TEST(LostFrames, SilenceOfAnyMessageEndsTheTorqueWithItsTimeout) {
  for (const Row& row : kCarrying) {
    Loop loop;
    loop.start_to_full_pedal();
    align(loop);
    CHECK_TEXT(loop.command.phase_current_ma > 500'000, row.name);
    loop.silent.insert(row.id);
    expect_time(row.name, ms_to_zero(loop, kTickMs), row.timeout_ms, row.timeout_ms);
  }
}

// MST-060
TEST(LostFrames, RepeatedFramesEndTheTorqueLikeSilence) {
  for (const Row& row : kCarrying) {
    Loop loop;
    loop.start_to_full_pedal();
    align(loop);
    Frame old;
    loop.tamper = [&](Frame& frame) {
      if (frame.id != row.id) return;
      if (old.dlc == 0) old = frame;
      frame = old;
    };
    // The first frame of the replay is still new: the age counts from it.
    const std::int32_t first = row.timeout_ms == 50 ? 0 : -90;
    expect_time(row.name, ms_to_zero(loop, first), row.timeout_ms, row.timeout_ms);
  }
}

// MST-060
TEST(LostFrames, DamagedFramesEndTheTorqueLikeSilence) {
  for (const Row& row : kCarrying) {
    Loop loop;
    loop.start_to_full_pedal();
    align(loop);
    loop.tamper = [&row](Frame& frame) {
      if (frame.id == row.id) frame.data[2] = static_cast<std::uint8_t>(frame.data[2] ^ 0x10U);
    };
    expect_time(row.name, ms_to_zero(loop, kTickMs), row.timeout_ms, row.timeout_ms);
  }
}

// MST-060
TEST(LostFrames, AllZeroPayloadsEndTheTorqueLikeSilence) {
  for (const Row& row : kCarrying) {
    Loop loop;
    loop.start_to_full_pedal();
    align(loop);
    loop.tamper = [&row](Frame& frame) {
      if (frame.id != row.id) return;
      for (std::uint8_t& byte : frame.data) byte = 0;
    };
    expect_time(row.name, ms_to_zero(loop, kTickMs), row.timeout_ms, row.timeout_ms);
  }
}

// MST-060
TEST(LostFrames, SealedFramesFullOfOnesStopTheTorqueAtOnce) {
  for (const Row& row : kCarrying) {
    // Ones are possible values there: bits that are set, and -0.1 degC. The code of the inverter's state is below.
    if (row.id == can::VehicleIo::kId || row.id == can::MotorTemperatures::kId) continue;
    Loop loop;
    loop.start_to_full_pedal();
    align(loop);
    loop.tamper = [&row](Frame& frame) {
      if (frame.id != row.id) return;
      const std::uint8_t counter = codec::counter_of(frame);
      for (std::uint8_t& byte : frame.data) byte = 0xFF;
      codec::seal(frame, counter);
    };
    expect_time(row.name, ms_to_zero(loop, 0), 0, 0);
  }
}

TEST(LostFrames, UnknownStateOfTheInverterStopsTheTorqueAtOnce) {
  Loop loop;
  loop.start_to_full_pedal();
  loop.inverter_follows = false;
  loop.inverter.state = static_cast<can::InverterState>(15);
  loop.tick();
  LONGS_EQUAL(0, loop.command.phase_current_ma);
  CHECK_FALSE(loop.command.enable);
}

// MST-011
TEST(LostFrames, KilledBmsEndsTheTorqueAfter50Ms) {
  Loop loop;
  loop.start_to_full_pedal();
  CHECK(loop.command.phase_current_ma > 500'000);
  loop.bms_dead = true;
  expect_time("BMS killed to zero torque", ms_to_zero(loop, kTickMs), 50, 50);
  CHECK_FALSE(loop.command.enable);
  const std::int32_t took = loop.until([&loop] { return loop.in(can::DriveState::kLvOn); }, 1'000);
  expect_time("BMS killed to low voltage", took + 60, 100, 110);
  loop.bms_dead = false;
  loop.run(5'000);
  LONGS_EQUAL(0, loop.command.phase_current_ma);
}

// MST-020
TEST(LostFrames, TorqueComesBackOnlyFromAReleasedPedal) {
  Loop loop;
  loop.start_to_full_pedal();
  loop.silent.insert(can::Pedals::kId);
  loop.run(100);
  loop.silent.clear();
  loop.run(1'000);
  LONGS_EQUAL(0, loop.command.phase_current_ma);
  loop.pedal(0);
  loop.run(20);
  loop.pedal(1000);
  loop.run(500);
  LONGS_EQUAL(550'000, loop.command.phase_current_ma);
}

// BMS-021
TEST(LostFrames, LostMasterOpensTheContactors) {
  Loop loop;
  loop.start_to_full_pedal();
  loop.silent.insert(can::MasterStatus::kId);
  const std::int32_t took = loop.until([&loop] { return !loop.contactors.air_plus_close; }, 1'000);
  expect_time("master lost to open contactors", took + kTickMs, 100, 110);
}

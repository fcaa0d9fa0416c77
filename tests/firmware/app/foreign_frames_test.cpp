// SPDX-License-Identifier: Apache-2.0
// A second sender on the bus, or old frames that are played again: both nodes name it, the torque is gone within 100 ms
// and comes back only from a released pedal.
#include "firmware/app/bench.hpp"

#include <deque>
#include <map>
#include <string>

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::app::test;

namespace {

constexpr std::uint32_t kKept = 64;  // frames that a replay goes back

// The cycle tells how soon "again and again" can be seen.
struct Row {
  std::uint32_t id;
  const char* name;
  std::int32_t within_ms;
};
constexpr Row kRows[] = {
    {can::Pedals::kId, "Pedals", 100},
    {can::WheelSpeeds::kId, "WheelSpeeds", 100},
    {can::InverterStatus::kId, "InverterStatus", 100},
    {can::VehicleIo::kId, "VehicleIo", 100},
    {can::PackSensor::kId, "PackSensor", 100},
    {can::BmsLimits::kId, "BmsLimits", 100},
    {can::BmsStatus::kId, "BmsStatus", 100},
    {can::MasterStatus::kId, "MasterStatus", 100},
    {can::CellVoltages::kBaseId + 2, "CellVoltages", 100},
    {can::MotorTemperatures::kId, "MotorTemperatures", 200},
    {can::Temperatures::kBaseId, "Temperatures", 200},
};

enum class Place { kBehind, kBefore, kInstead };

/// The frames of one message pass here, and somebody else's with them. All others pass untouched.
class Trouble {
 public:
  explicit Trouble(std::uint32_t id) : id_(id) {}
  /// A second sender so many counts ahead; `change` makes its contents of the true ones.
  void second_sender(std::uint8_t ahead, Place place, std::function<void(Frame&)> change) {
    make_ = [ahead, change](const Frame& frame, const std::deque<Frame>&, std::uint32_t) {
      Frame other = frame;
      change(other);
      codec::seal(other, static_cast<std::uint8_t>(codec::counter_of(frame) + ahead));
      return other;
    };
    begin(place);
  }
  /// The last `period` frames before now, over and over.
  void replay(std::uint32_t period, Place place) {
    make_ = [period](const Frame&, const std::deque<Frame>& kept, std::uint32_t n) {
      return kept[kept.size() - period + n % period];
    };
    begin(place);
  }
  void end() { active_ = false; }
  void pass(const Frame& frame, std::vector<Frame>& frames) {
    if (frame.id != id_ || !active_) {
      frames.push_back(frame);
      if (frame.id != id_) return;
      kept_.push_back(frame);
      if (kept_.size() > kKept) kept_.pop_front();
      return;
    }
    const Frame other = make_(frame, kept_, count_++);
    if (place_ == Place::kBefore) frames.push_back(other);
    if (place_ != Place::kInstead) frames.push_back(frame);
    if (place_ != Place::kBefore) frames.push_back(other);
  }
  std::uint32_t count() const { return count_; }

 private:
  void begin(Place place) {
    place_ = place;
    active_ = true;
    count_ = 0;
  }

  std::uint32_t id_;
  Place place_ = Place::kBehind;
  bool active_ = false;
  std::uint32_t count_ = 0;
  std::deque<Frame> kept_;
  std::function<Frame(const Frame&, const std::deque<Frame>&, std::uint32_t)> make_;
};

void change_first_byte(Frame& frame) { frame.data[0] = static_cast<std::uint8_t>(frame.data[0] ^ 0x55U); }
void full_throttle(Frame& frame) {
  can::Pedals m;
  CHECK(can::decode(frame, m));
  m.apps1_100uv = 45'000;
  m.apps2_100uv = 22'500;
  can::encode(m, frame);
}

}  // namespace

TEST_GROUP(ForeignFrames) {
  /// At full pedal, with contents that move, so that no two frames are equal, and 64 frames of the message kept.
  struct Scene {
    Loop car;
    Trouble trouble;
    std::int32_t turn = 0;
    explicit Scene(std::uint32_t id) : trouble(id) {}
    void tick() {
      ++turn;
      car.pack.pack_current_ma += turn % 7;
      car.inverter_follows = true;
      car.bus = [this](const Frame& frame, std::vector<Frame>& frames) { trouble.pass(frame, frames); };
      car.tick();
      car.bus = [](const Frame& frame, std::vector<Frame>& frames) { frames.push_back(frame); };
    }
    void run(std::int32_t ms) {
      for (std::int32_t t = 0; t < ms; t += kTickMs) tick();
    }
    /// Runs for 1 s. Milliseconds from the first foreign frame to the last tick with torque.
    std::int32_t ms_with_torque(std::int32_t ms = 1'000) {
      std::int32_t since = 0, last = 0;
      for (std::int32_t t = 0; t < ms; t += kTickMs) {
        tick();
        if (trouble.count() == 0) continue;
        since += kTickMs;
        if (car.command.phase_current_ma != 0) last = since;
      }
      return last;
    }
  };
  static Scene at_full_pedal(std::uint32_t id) {
    Scene scene(id);
    scene.car.start_to_full_pedal();
    scene.run(7'000);  // 64 frames of the slowest message
    CHECK(scene.car.command.phase_current_ma == 550'000);
    return scene;
  }
  static bool named(const Loop& car) {
    const auto bms = static_cast<unsigned>(can::BmsFault::kForeignFrames);
    const auto master = static_cast<unsigned>(can::MasterFault::kForeignFrames);
    return (car.bms_status.faults >> bms & 1U) != 0 || (car.master_status.faults >> master & 1U) != 0;
  }
};

// BMS-004, MST-061
TEST(ForeignFrames, SecondSenderOfAnyMessageAtAnyOffsetEndsTheTorqueInTime) {
  for (const Row& row : kRows) {
    const Scene ready = at_full_pedal(row.id);
    std::int32_t longest = 0;
    for (const Place place : {Place::kBehind, Place::kBefore, Place::kInstead}) {
      for (unsigned ahead = place == Place::kInstead ? 1 : 0; ahead < 256; ++ahead) {
        Scene scene = ready;
        scene.trouble.second_sender(static_cast<std::uint8_t>(ahead), place, change_first_byte);
        longest = std::max(longest, scene.ms_with_torque(500));
        const std::string what = std::string(row.name) + ", " + std::to_string(ahead) + " ahead";
        CHECK_TEXT(longest <= row.within_ms, what.c_str());
        LONGS_EQUAL_TEXT(0, scene.car.command.phase_current_ma, what.c_str());
      }
    }
    expect_time((std::string("MST-061 second sender of ") + row.name).c_str(), longest, 0, row.within_ms);
  }
}

// BMS-004, MST-061
TEST(ForeignFrames, ReplayOfAnyMessageEndsTheTorqueInTime) {
  for (const Row& row : kRows) {
    const Scene ready = at_full_pedal(row.id);
    std::int32_t longest = 0;
    for (const Place place : {Place::kBehind, Place::kInstead}) {
      for (std::uint32_t period = place == Place::kInstead ? 2 : 1; period <= kKept; ++period) {
        Scene scene = ready;
        scene.trouble.replay(period, place);
        longest = std::max(longest, scene.ms_with_torque(1'000));
        const std::string what = std::string(row.name) + ", period " + std::to_string(period);
        CHECK_TEXT(longest <= row.within_ms, what.c_str());
        CHECK_TEXT(named(scene.car), what.c_str());
      }
    }
    expect_time((std::string("MST-061 replay of ") + row.name).c_str(), longest, 0, row.within_ms);
  }
}

// MST-061, MST-020
TEST(ForeignFrames, TorqueComesBackOnlyFromAReleasedPedalAfterARoundOfTheCounter) {
  for (const std::uint32_t id : {can::Pedals::kId, can::WheelSpeeds::kId}) {
    Scene scene = at_full_pedal(id);
    scene.trouble.second_sender(40, Place::kBehind, change_first_byte);
    scene.run(200);
    CHECK(named(scene.car));
    scene.trouble.end();
    scene.run(2'500);
    CHECK(named(scene.car));
    scene.car.pedal(0);  // too soon
    scene.run(20);
    scene.car.pedal(1000);
    scene.run(200);
    CHECK_FALSE(named(scene.car));  // 256 frames of 10 ms
    scene.run(3'000);
    LONGS_EQUAL(0, scene.car.command.phase_current_ma);
    CHECK(scene.car.in(can::DriveState::kReadyToDrive));
    scene.car.pedal(0);
    scene.run(20);
    scene.car.pedal(1000);
    scene.run(200);
    LONGS_EQUAL(550'000, scene.car.command.phase_current_ma);
  }
}

// MST-061: what the BMS alone hears ends the torque through its limits and its named fault.
TEST(ForeignFrames, CellsWithASecondSenderTakeTheLimitsAndAskForAReleasedPedal) {
  Scene scene = at_full_pedal(can::CellVoltages::kBaseId);
  scene.trouble.second_sender(3, Place::kBehind, change_first_byte);
  scene.run(100);
  LONGS_EQUAL(0, scene.car.bms_limits.discharge_limit_ma);
  LONGS_EQUAL(0, scene.car.bms_limits.charge_limit_ma);
  CHECK(scene.car.bms_limits.discharge_reason == can::LimitReason::kFault);
  CHECK(scene.car.contactors.air_plus_close);  // the cells are lost for 500 ms before that
  CHECK_FALSE(scene.car.master.state().request.armed);
  CHECK((scene.car.bms_status.faults >> static_cast<unsigned>(can::BmsFault::kForeignFrames) & 1U) != 0);
}

// MST-061: the true pedal is released, and the second sender says full throttle.
TEST(ForeignFrames, FullThrottleOfASecondSenderDrivesNothingForLong) {
  Scene ready = at_full_pedal(can::Pedals::kId);
  ready.car.pedal(0);
  ready.run(200);
  std::int32_t longest = 0;
  int driven = 0;
  for (const Place place : {Place::kBehind, Place::kBefore}) {
    for (unsigned ahead = 0; ahead < 256; ++ahead) {
      Scene scene = ready;
      scene.trouble.second_sender(static_cast<std::uint8_t>(ahead), place, full_throttle);
      const std::int32_t took = scene.ms_with_torque();
      longest = std::max(longest, took);
      driven += took > 0 ? 1 : 0;
    }
  }
  expect_time("MST-061 full throttle of a second sender", longest, 0, 40);
  CHECK(driven <= 3);  // one ahead behind the true frame; none or one ahead before it
}

TEST(ForeignFrames, SafeWordOfASecondSenderOpensTheContactors) {
  for (unsigned ahead = 0; ahead < 256; ++ahead) {
    Scene scene = at_full_pedal(can::VehicleIo::kId);
    scene.trouble.second_sender(static_cast<std::uint8_t>(ahead), Place::kBehind, [](Frame& frame) {
      can::VehicleIo m;
      CHECK(can::decode(frame, m));
      m.shutdown_closed = false;
      can::encode(m, frame);
    });
    scene.run(200);
    CHECK_FALSE(scene.car.contactors.air_plus_close || scene.car.contactors.air_minus_close);
    if (ahead == 10) ahead = 250;
  }
}

// SPDX-License-Identifier: Apache-2.0
// Frames that are lost, singly and in bursts, and frames that are late: the car drives on.
#include "firmware/app/bench.hpp"

#include <cstdlib>
#include <map>
#include <random>
#include <string>

#include "CppUTest/TestHarness.h"

using namespace voltlap;
using namespace voltlap::app::test;

namespace {

unsigned drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10)) : std::random_device{}();
}

constexpr int kSlowInARow = 3, kAnyNumber = 1'000'000;

/// Every message that one of the nodes listens to in a car of 24 cells, with the frames that may be lost in a row.
std::vector<std::pair<std::uint32_t, int>> messages() {
  std::vector<std::pair<std::uint32_t, int>> out;
  for (const can::MessageRow& row : can::kMessages) {
    const bool cells = row.id >= can::CellVoltages::kBaseId && row.id < can::CellVoltages::kBaseId + 8;
    const bool sensors = row.id >= can::Temperatures::kBaseId && row.id < can::Temperatures::kBaseId + 2;
    const bool heard = codec::find_row(can::kBmsRx, codec::row_count(can::kBmsRx), row.id) != codec::kNoRow ||
                       codec::find_row(can::kMasterRx, codec::row_count(can::kMasterRx), row.id) != codec::kNoRow;
    if (heard && (row.id < can::CellVoltages::kBaseId || cells || sensors)) {
      out.emplace_back(row.id, row.cycle_ms == kTickMs ? 5 : kSlowInARow);
    }
  }
  return out;
}

/// Loses `count` frames of one message, or of all when `id` is 0.
struct Burst {
  std::uint32_t id = 0;
  std::map<std::uint32_t, int> left{};
  explicit Burst(std::uint32_t which, bool all = false) {
    for (const auto& [message, count] : messages()) {
      if (all || message == which) left[message] = count;
    }
  }
  void operator()(const Frame& frame, std::vector<Frame>& frames) {
    const auto found = left.find(frame.id);
    if (found == left.end() || found->second == 0) return frames.push_back(frame);
    --found->second;
  }
};

/// Loses a share of all frames, and delays some by a tick; frames of one message stay in their order. Of a message that
/// comes ten times a second at most three in a row: five, or four and a late one, are the 500 ms of BMS-014. By chance
/// five are lost once in a hundred hours at 5 %.
class Noise {
 public:
  Noise(unsigned seed, double lost, double late) : random_(seed), lost_(lost), late_(late) {}
  void operator()(const Frame& frame, std::vector<Frame>& frames) {
    if (frame.id == can::PackSensor::kId) {  // the first of a tick
      frames.insert(frames.end(), held_.begin(), held_.end());
      held_.clear();
    }
    int& gap = in_a_row_[frame.id];
    if (uniform_(random_) < lost_ && gap < most_in_a_row(frame.id)) {
      ++gap;
      return;
    }
    gap = 0;
    (uniform_(random_) < late_ ? held_ : frames).push_back(frame);
  }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  double lost_, late_;
  std::vector<Frame> held_;
  std::map<std::uint32_t, int> in_a_row_;

  static int most_in_a_row(std::uint32_t id) {
    static const std::vector<std::pair<std::uint32_t, int>> kAll = messages();
    for (const auto& [message, count] : kAll) {
      if (message == id && count == kSlowInARow) return count;
    }
    return kAnyNumber;
  }
};

}  // namespace

TEST_GROUP(Gaps) {
  Loop ready;
  void setup() override { ready.start_to_full_pedal(); }

  static bool stopped(const Loop& car) {
    return !car.contactors.air_plus_close || !car.contactors.air_minus_close ||
           !car.in(can::DriveState::kReadyToDrive) || car.bms.state().faults.latched != 0 ||
           car.master.state().pedals.latched.any() || !car.master.state().request.armed;
  }
  /// Longest time without torque while the pedal is down; the car must not stop.
  static std::int32_t longest_ms_without_torque(Loop & car, std::int32_t ms, const std::string& what) {
    std::int32_t longest = 0, now = 0;
    for (std::int32_t t = 0; t < ms; t += kTickMs) {
      car.tick();
      CHECK_TEXT(!stopped(car), (what + ", after " + std::to_string(t) + " ms").c_str());
      now = car.command.phase_current_ma > 0 ? 0 : now + kTickMs;
      longest = std::max(longest, now);
    }
    return longest;
  }
};

// MST-020, BMS-020, BMS-021, BMS-014
TEST(Gaps, BurstOfFiveFramesOrThreeSlowerOnesOfAnyMessageStopsNothing) {
  std::int32_t longest = 0;
  for (const auto& [id, count] : messages()) {
    Loop car = ready;
    car.bus = Burst{id};
    const std::string what = std::to_string(count) + " frames of " + std::to_string(id);
    longest = std::max(longest, longest_ms_without_torque(car, 3'000, what));
    LONGS_EQUAL_TEXT(550'000, car.command.phase_current_ma, what.c_str());
    LONGS_EQUAL_TEXT(0, static_cast<long>(car.bms_status.faults), what.c_str());
    LONGS_EQUAL_TEXT(0, car.master_status.faults, what.c_str());
  }
  expect_time("MST-050: longest time without torque in a burst of one message", longest, kTickMs, 50);
}

TEST(Gaps, BurstOfAllMessagesAtOnceStopsNothing) {
  Loop car = ready;
  car.bus = Burst{0, true};
  expect_time("MST-050: without torque in a burst of all messages", longest_ms_without_torque(car, 3'000, "all"),
              kTickMs, 50);
  LONGS_EQUAL(550'000, car.command.phase_current_ma);
}

// MST-001, MST-020, MST-050
TEST(Gaps, TorqueIsZeroFrom50MsOnAndComesBackByItselfWhenTheDataAreBackWithin100Ms) {
  for (const std::uint32_t id : {can::Pedals::kId, can::VehicleIo::kId, can::InverterStatus::kId, can::BmsStatus::kId,
                                 can::BmsLimits::kId}) {
    for (int lost = 1; lost <= 30; ++lost) {
      Loop car = ready;
      car.silent.insert(id);
      for (int n = 1; n <= lost; ++n) {
        car.tick();
        CHECK_EQUAL(10 * n < 50, car.command.phase_current_ma > 0);  // 10 n: the age of the last frame
      }
      car.silent.clear();
      car.run(1'000);
      const bool back = car.command.phase_current_ma == 550'000;
      // Behind nine lost frames the tenth comes 100 ms after the last one: in time. Limits ask for no released pedal.
      CHECK_EQUAL_TEXT(lost < 10 || id == can::BmsLimits::kId, back, std::to_string(id).c_str());
      CHECK_EQUAL(back, car.command.phase_current_ma > 0);
      if (back || !car.in(can::DriveState::kReadyToDrive)) continue;
      car.pedal(0);
      car.run(20);
      car.pedal(1000);
      car.run(200);
      LONGS_EQUAL(550'000, car.command.phase_current_ma);
    }
  }
}

// BMS-020, BMS-021
TEST(Gaps, ContactorsStayClosedForNineLostFramesAndOpenWithTheTenth) {
  for (const std::uint32_t id : {can::VehicleIo::kId, can::MasterStatus::kId}) {
    for (int lost = 1; lost <= 30; ++lost) {
      Loop car = ready;
      car.silent.insert(id);
      for (int n = 1; n <= lost; ++n) {
        car.tick();
        CHECK_EQUAL(n < 10, car.contactors.air_plus_close && car.contactors.air_minus_close);
      }
      car.silent.clear();
      car.run(500);
      CHECK_EQUAL(lost < 10, car.contactors.air_plus_close);
      LONGS_EQUAL(0, static_cast<long>(car.bms.state().faults.latched));
    }
  }
}

// BMS-001, MST-060
TEST(Gaps, LostAndLateFramesDrawnAtRandomStopNoCar) {
  const unsigned drawn = drawn_seed();
  std::int32_t longest = 0;
  for (const double lost : {0.02, 0.05}) {
    for (const double late : {0.0, 0.1, 0.5}) {
      for (unsigned k = 0; k < 4; ++k) {
        Loop car = ready;
        car.bus = Noise{drawn + k, lost, late};
        const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(drawn) + ", car " + std::to_string(k) + ", " +
                                 std::to_string(lost) + " lost, " + std::to_string(late) + " late";
        longest = std::max(longest, longest_ms_without_torque(car, 60'000, what));
        CHECK_TEXT(!car.bms.state().rx.contested(), what.c_str());
        CHECK_TEXT(car.command.phase_current_ma > 0, what.c_str());
      }
    }
  }
  std::printf("VOLTLAP_TEST_SEED=%u: 24 cars of 60 s, 2 and 5 %% lost, up to half late: none stopped, at most %d ms "
              "without torque\n", drawn, static_cast<int>(longest));
}

TEST(Gaps, BurstsDrawnAtRandomStopNoCar) {
  const unsigned drawn = drawn_seed();
  std::mt19937 random(drawn);
  const auto all = messages();
  Loop car = ready;
  for (int k = 0; k < 200; ++k) {
    car.bus = Burst{all[random() % all.size()].first};
    const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(drawn) + ", burst " + std::to_string(k);
    (void)longest_ms_without_torque(car, 400 + static_cast<std::int32_t>(random() % 20) * 10, what);
  }
  CHECK(car.command.phase_current_ma > 0);
}

// BMS-063: cells that were read before the pack's channel is there are held against nothing.
TEST(Gaps, ACarStartsWhateverMessageComesLast) {
  for (const auto& [id, cycle_ms] : messages()) {
    for (const int late_ms : {10, 20, 30, 50, 100, 400, 900}) {
      Loop car;
      car.silent.insert(id);
      car.run(late_ms);
      car.silent.clear();
      car.start_to_full_pedal();
      const std::string what = "message " + std::to_string(id) + ", " + std::to_string(late_ms) + " ms";
      CHECK_TEXT(car.command.phase_current_ma > 0, what.c_str());
      CHECK_TEXT(car.bms_status.faults == 0 && car.master_status.faults == 0, what.c_str());
    }
  }
}

TEST(Gaps, CarsStartUpOnABusThatLosesAndDelaysFrames) {
  const unsigned drawn = drawn_seed();
  for (unsigned k = 0; k < 20; ++k) {
    const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(drawn) + ", car " + std::to_string(k);
    Loop car;
    car.bus = Noise{drawn + k, 0.05, 0.5};
    car.start_to_ts_active();
    car.brake(20'000);  // well before the button: each comes in a message of its own
    car.run(500);
    car.io.rtd_button = true;
    car.run(200);
    car.io.rtd_button = false;
    car.brake(0);
    car.run(200);
    car.pedal(1000);
    car.run(500);
    CHECK_TEXT(car.command.phase_current_ma > 0, what.c_str());
    CHECK_TEXT(!car.bms.state().rx.contested() && car.master_status.faults == 0, what.c_str());
  }
}

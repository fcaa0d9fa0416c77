// SPDX-License-Identifier: Apache-2.0
// Plant and both nodes on a bus that loses frames, at each receiver by itself: no car stops.
#include <fmt/format.h>

#include <map>

#include "bench.hpp"
#include "drawn.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr int kCars = 12;  // of each loss
constexpr double kDrive_s = 60.0;

VehicleParameters of_cells(int cells) {
  VehicleParameters car = vtm16e();
  car.battery.cells_in_series = cells;
  car.sensors.temperature_count = (cells + 3) / 4;
  return car;
}

/// Why a car at full pedal is not driving any more; empty while it is.
class Watch {
 public:
  std::string stopped(const LoopBench& bench) {
    const can::MasterStatus& master = bench.commands.master();
    if (!bench.car.contactors.main_closed()) return "a contactor is open";
    if (master.drive_state != can::DriveState::kReadyToDrive) return "the master has left ready-to-drive";
    without_request_ = master.pedal_request_ppm == 0 ? without_request_ + 1 : 0;
    return without_request_ > 5 ? "the pedal must be released" : "";  // for 50 ms it may wait for the inverter
  }

 private:
  int without_request_ = 0;
};

}  // namespace

TEST_GROUP(LossyBus) {
  /// At full pedal for a minute. Longest time without torque [ms].
  static std::uint32_t drive_on(LoopBench & bench, const std::string& what) {
    Watch watch;
    std::uint32_t longest = 0, torque_at = bench.now_ms();
    const std::uint32_t end = bench.now_ms() + static_cast<std::uint32_t>(kDrive_s * 1000.0);
    while (bench.now_ms() < end) {
      bench.tick();
      const std::string why = watch.stopped(bench);
      if (!why.empty()) FAIL(fmt::format("{}: {} after {} ms, faults {:#x}", what, why, bench.now_ms(),
                                         bench.commands.bms().faults).c_str());
      if (bench.car.phase_current_a() > 0.0) torque_at = bench.now_ms();
      longest = std::max(longest, bench.now_ms() - torque_at);
    }
    bench.loop.loses = nullptr;
    bench.run_for(1.0);
    LONGS_EQUAL_TEXT(0, static_cast<long>(bench.commands.bms().faults), what.c_str());
    LONGS_EQUAL_TEXT(0, bench.commands.master().faults, what.c_str());
    return longest;
  }
};

// BMS-001, BMS-014, BMS-020, BMS-021, MST-001, MST-020, MST-060
TEST(LossyBus, RandomLossStopsNoCar) {
  const std::uint64_t drawn = drawn_seed();
  constexpr std::pair<double, int> kLostAndCells[] = {{0.02, 24}, {0.05, 24}, {0.05, 48}, {0.02, 144}};
  for (const auto& [lost, cells] : kLostAndCells) {
    std::uint32_t longest = 0;
    for (int k = 0; k < kCars; ++k) {
      LoopBench bench(of_cells(cells));
      bench.drive_off(2.0);
      CHECK(Watch{}.stopped(bench).empty());
      bench.loop.loses = RandomLoss(drawn + static_cast<std::uint64_t>(k), lost);
      longest = std::max(longest, drive_on(bench, fmt::format("VOLTLAP_TEST_SEED={}, {} % of {} cells, car {}", drawn,
                                                              100.0 * lost, cells, k)));
    }
    fmt::print("VOLTLAP_TEST_SEED={}: {} cars of {} cells, 60 s, {} % lost: none stopped, at most {} ms without "
               "torque\n", drawn, kCars, cells, 100.0 * lost, longest);
  }
}

// BMS-020, BMS-021, MST-001
TEST(LossyBus, BurstOfAnyMessageAtAllReceiversStopsNoCar) {
  LoopBench bench(vtm16e());
  bench.drive_off(2.0);
  std::uint32_t longest = 0;
  for (const can::MessageRow& row : can::kMessages) {
    std::map<std::uint32_t, int> lost;  // tick -> 1: both receivers of one frame lose it
    const int most = row.cycle_ms <= 10 ? 5 : 3;
    bench.loop.loses = [&](const Frame& frame) {
      if (frame.id != row.id) return false;
      if (lost.count(bench.now_ms()) == 0 && static_cast<int>(lost.size()) == most) return false;
      lost[bench.now_ms()] = 1;
      return true;
    };
    Watch watch;
    std::uint32_t torque_at = bench.now_ms();
    for (int i = 0; i < 150; ++i) {
      bench.tick();
      const std::string why = watch.stopped(bench);
      if (!why.empty()) FAIL(fmt::format("burst of {:#x}: {}", row.id, why).c_str());
      if (bench.car.phase_current_a() > 0.0) torque_at = bench.now_ms();
      longest = std::max(longest, bench.now_ms() - torque_at);
    }
  }
  fmt::print("bursts of every message: at most {} ms without torque\n", longest);
  CHECK(longest <= 50);
}

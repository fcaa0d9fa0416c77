// SPDX-License-Identifier: Apache-2.0
// Plant and both nodes with a Cascadia PM100 between them: it drives as the other inverter does, and what it drops out
// of stays off until the driver asks again.
#include <fmt/format.h>

#include "bench.hpp"
#include "can_dbc/pm100.hpp"
#include "drawn.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

VehicleParameters with_pm100() {
  VehicleParameters car = vtm16e();
  car.inverter.protocol = "pm100";
  return car;
}

bool has(const can::MasterStatus& status, can::MasterFault fault) {
  return (status.faults >> static_cast<unsigned>(fault) & 1U) != 0;
}

}  // namespace

TEST_GROUP(Pm100Loop) {
  LoopBench bench{with_pm100()};
  /// Loses the next frames of one message, at everybody who receives it.
  void lose(std::uint32_t id, std::uint32_t count, std::uint32_t cycle_ms = 10) {
    const std::uint32_t until = bench.now_ms() + count * cycle_ms;
    bench.loop.loses = [this, id, until](const Frame& frame) { return frame.id == id && bench.now_ms() < until; };
  }
  [[nodiscard]] bool ready() const {
    return bench.commands.master().drive_state == can::DriveState::kReadyToDrive;
  }
  [[nodiscard]] bool driving() const { return bench.car.phase_current_a() > 50.0; }
  /// Until it is told [ms]; fails when it is not within `most_ms`.
  std::uint32_t told(can::MasterFault fault, std::uint32_t most_ms) {
    const std::uint32_t begin = bench.now_ms();
    while (!has(bench.commands.master(), fault)) {
      bench.tick();
      if (bench.now_ms() - begin > most_ms) FAIL(fmt::format("not told within {} ms", most_ms).c_str());
    }
    return bench.now_ms() - begin;
  }
};

TEST(Pm100Loop, FullPedalDrivesAndFewLostFramesAreNoInterruption) {
  bench.drive_off(1.0);
  CHECK(driving());
  for (const std::uint32_t id : {can::Pm100Torque::kId, can::Pm100MotorPosition::kId, can::Pm100States::kId,
                                 can::Pm100Faults::kId, can::Pm100Voltages::kId}) {
    lose(id, 1);
    for (int k = 0; k < 40; ++k) {
      bench.tick();
      if (!ready() || !driving()) FAIL(fmt::format("id {:x}, tick {}", id, k).c_str());
    }
  }
}

// MST-060: what a harness loses. The torque may go from 50 ms on, and comes back with the frames.
TEST(Pm100Loop, BurstsOfFiveFastAndThreeSlowFramesNeverEndADrive) {
  bench.drive_off(1.0);
  const std::pair<std::uint32_t, std::uint32_t> cycles[] = {
      {can::Pm100Torque::kId, 10},  {can::Pm100MotorPosition::kId, 10},     {can::Pm100Currents::kId, 10},
      {can::Pm100Voltages::kId, 10}, {can::Pm100Command::kId, 10},          {can::Pm100States::kId, 100},
      {can::Pm100Faults::kId, 100}, {can::Pm100MotorTemperatures::kId, 100}, {can::Pm100ModuleTemperatures::kId, 100}};
  for (const auto& [id, cycle_ms] : cycles) {
    lose(id, cycle_ms == 10 ? 5 : 3, cycle_ms);
    for (int k = 0; k < 60; ++k) {
      bench.tick();
      if (!ready()) FAIL(fmt::format("id {:x}, tick {}: ready-to-drive left", id, k).c_str());
    }
    if (!driving()) FAIL(fmt::format("id {:x}: the torque does not come back", id).c_str());
    LONGS_EQUAL(0, bench.commands.master().faults);
  }
}

// MST-060: 5 % of every frame of the inverter, as of the other frames up to 48 cells, 2 % of its command, of which each
// takes the next one with it.
TEST(Pm100Loop, FramesLostAtRandomNeverEndADrive) {
  const std::uint64_t seed = drawn_seed();
  Drawn draw(seed);
  bench.drive_off(0.3);
  bench.loop.loses = [&](const Frame& frame) {
    if (frame.id < 0x1A0 || frame.id > can::Pm100Command::kId) return false;
    return draw.between(0.0, 1.0) < (frame.id == can::Pm100Command::kId ? 0.02 : 0.05);
  };
  for (int k = 0; k < 6'000; ++k) {
    bench.tick();
    if (!ready()) FAIL(fmt::format("seed {}, {} ms: ready-to-drive left", seed, 10 * k).c_str());
  }
}

// MST-065: the silence is heard by both nodes.
TEST(Pm100Loop, SilenceOfTheInverterEndsTheDriveAndThePedalAloneBringsNothingBack) {
  bench.drive_off(1.0);
  bench.loop.loses = [](const Frame& frame) { return frame.id >= 0x1A0 && frame.id < 0x1C0; };
  told(can::MasterFault::kInverterLost, 120);
  bench.run_for(0.05);
  CHECK(!driving());
  bench.run_for(0.1);
  CHECK(!ready());
  bench.loop.loses = nullptr;
  bench.run_for(1.0);
  CHECK(!ready());
  DOUBLES_EQUAL(0.0, bench.car.phase_current_a(), 1e-9);
}

// MST-065
TEST(Pm100Loop, ALockoutInTheMiddleOfADriveIsLostAndTheTorqueStaysOff) {
  bench.drive_off(1.0);
  bench.car.pm100.lock();
  bench.run_for(0.02);
  CHECK(!driving());
  told(can::MasterFault::kInverterLost, 120);
  bench.run_for(1.0);
  CHECK(!ready());
  CHECK(!bench.car.pm100.locked());  // disabled commands have released it
  DOUBLES_EQUAL(0.0, bench.car.phase_current_a(), 1e-9);
}

// MST-010, MST-063
TEST(Pm100Loop, FaultsOfRunningAndOfTheSelfTestOpenTheContactors) {
  for (const bool running : {true, false}) {
    LoopBench other{with_pm100()};
    other.drive_off(1.0);
    running ? other.car.pm100.fail_running(1) : other.car.pm100.fail_self_test(1);
    other.run_for(0.13);
    CHECK(has(other.commands.master(), can::MasterFault::kInverterFault));
    other.run_for(0.3);
    CHECK(!other.any_air_closed());
  }
}

TEST(Pm100Loop, EnduranceLapTakesTheSameTimeAsWithPhaseCurrent) {
  const std::uint64_t seed = drawn_seed();
  Drawn draw(seed);
  EnduranceOptions options = nominal(1);
  options.vehicle.vehicle.mass_kg *= draw.between(0.85, 1.25);
  options.vehicle.powertrain.final_drive *= draw.between(0.9, 1.15);
  options.vehicle.motor.constant_nm_per_a *= draw.between(0.9, 1.3);
  options.vehicle.bms.discharge_current_max_a *= draw.between(0.15, 0.4);  // so that it holds back
  const EnduranceResult phase = drive(options);
  options.vehicle.inverter.protocol = "pm100";
  const EnduranceResult torque = drive(options);
  const auto energy_kwh = [](const EnduranceResult& r) { return r.lap_rows.empty() ? 0.0 : r.lap_rows[0].energy_kwh; };
  const std::string told =
      fmt::format("seed {}: {:.3f} s, {:.5f} kWh; with a PM100 {:.3f} s, {:.5f} kWh, {}", seed, phase.total_time_s,
                  energy_kwh(phase), torque.total_time_s, energy_kwh(torque), torque.failure_cause);
  UT_PRINT(told.c_str());
  CHECK_TEXT(phase.finished && torque.finished, told.c_str());
  CHECK_TEXT(std::abs(torque.total_time_s / phase.total_time_s - 1.0) < 0.003, told.c_str());
  CHECK_TEXT(std::abs(energy_kwh(torque) / energy_kwh(phase) - 1.0) < 0.005, told.c_str());
}

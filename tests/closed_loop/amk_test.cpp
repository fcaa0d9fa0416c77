// SPDX-License-Identifier: Apache-2.0
// Plant and both nodes with four AMK inverters between them: all four drive or none, the energy's ledger closes, and
// four driven wheels are no slower than two.
#include <fmt/format.h>

#include "bench.hpp"
#include "car/vehicle/grip.hpp"
#include "codec/amk_frames.hpp"
#include "core/axle_motors.hpp"
#include "drawn.hpp"
#include "fixtures.hpp"
#include "race/track/lap_solver.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

bool has(const can::MasterStatus& status, can::MasterFault fault) {
  return (status.faults >> static_cast<unsigned>(fault) & 1U) != 0;
}

double grip_of(VehicleParameters car, double front_share) {
  car.powertrain.front_torque_share = front_share;
  return drive_grip(car, 0.0, 1.0, 0.0);
}

/// The shipped car with other numbers: masses, gear, shares, limits. Its front axle has no more than a share with which
/// the tyres hold as much as with none: an acceleration unloads them, and the first axle to spin ends it for both.
VehicleParameters drawn_car(Drawn& draw) {
  VehicleParameters car = amk_4wd();
  car.vehicle.mass_kg *= draw.between(0.85, 1.2);
  car.vehicle.cg_height_m *= draw.between(0.8, 1.2);
  car.vehicle.cg_rear_fraction = draw.between(0.46, 0.56);
  car.powertrain.final_drive *= draw.between(0.9, 1.15);
  double share = draw.between(0.1, 0.5);
  while (grip_of(car, share) < grip_of(car, 0.0)) share *= 0.95;
  car.powertrain.front_torque_share = share;
  car.powertrain.front_braking_share = draw.between(0.4, 0.7);
  car.inverter.efficiency = draw.between(0.94, 1.0);
  car.inverter.loss_w_per_a = draw.between(0.0, 1.0);
  car.master.regen_current_max_a = draw.between(0.0, 1.0) < 0.5 ? 0.0 : draw.between(20.0, 120.0);
  return car;
}

/// As strong, with nothing in front.
VehicleParameters at_the_rear_alone(VehicleParameters car) {
  const double each_a = full_phase_current_a(car) / 2.0;
  for (double& torque : car.motor.curve_torque_nm) torque *= each_a / car.inverter.current_max_a;
  car.inverter.current_max_a = each_a;
  car.powertrain.front_torque_share = 0.0;
  return car;
}

// Where a car comes to a corner's speed within the corner, the solver leaves it less to brake with than one that is
// still slower there: more grip may cost a thousandth of the lap.
constexpr double kSolver = 1.002;

}  // namespace

TEST_GROUP(AmkLoop) {
  LoopBench bench{amk_4wd()};

  [[nodiscard]] bool ready() const {
    return bench.commands.master().drive_state == can::DriveState::kReadyToDrive;
  }
  /// Every motor has torque, or none.
  [[nodiscard]] bool all_drive() const {
    for (const MotorDrive& drive : bench.car.drives) {
      if (drive.current_a < 5.0) return false;
    }
    return true;
  }
  [[nodiscard]] bool none_drives() const {
    for (const MotorDrive& drive : bench.car.drives) {
      if (drive.current_a != 0.0) return false;
    }
    return true;
  }
  void lose(std::uint32_t id, std::uint32_t count) {
    const std::uint32_t until = bench.now_ms() + 10 * count;
    bench.loop.loses = [this, id, until](const Frame& frame) { return frame.id == id && bench.now_ms() < until; };
  }
};

// MST-068, MST-069
TEST(AmkLoop, FullPedalDrivesAllFourByTheirShares) {
  bench.drive_off(0.5);
  CHECK(ready() && all_drive());
  LONGS_EQUAL(0, bench.commands.master().faults);
  const std::vector<MotorDrive>& d = bench.car.drives;
  DOUBLES_EQUAL(d[0].current_a, d[1].current_a, 1e-9);
  DOUBLES_EQUAL(d[2].current_a, d[3].current_a, 1e-9);
  DOUBLES_EQUAL(bench.car.parameters().powertrain.front_torque_share,
                2.0 * d[0].current_a / bench.car.phase_current_a(), 0.01);
  CHECK(bench.car.vehicle().speed_mps() > 3.0);
}

// MST-070: an inverter stops with an error, the other three follow.
TEST(AmkLoop, AnErrorAtOneEndsAllFourAndTheContactorsOpen) {
  for (std::size_t k = 0; k < 4; ++k) {
    LoopBench other{amk_4wd()};
    other.drive_off(1.0);
    other.car.drives[k].amk.fail(Amk::kPlanted);
    other.run_for(0.03);
    CHECK(has(other.commands.master(), can::MasterFault::kInverterFault));
    DOUBLES_EQUAL(0.0, other.car.phase_current_a(), 0.0);
    other.run_for(0.3);
    CHECK(!other.any_air_closed());
  }
}

// MST-070
TEST(AmkLoop, SilenceOfOneEndsTheDriveAndThePedalAloneBringsNothingBack) {
  bench.drive_off(1.0);
  lose(codec::AmkIds<codec::AmkActual1>::kId[1], 30);
  bench.run_for(0.09);
  CHECK(none_drives());
  bench.run_for(0.05);
  CHECK(!ready());
  bench.run_for(2.0);
  CHECK(!ready() && none_drives());
}

// MST-071: the inverter's own time-out is an error, and survives three lost setpoints.
TEST(AmkLoop, ThreeSetpointsInARowMayBeLostAndTenMayNot) {
  bench.drive_off(1.0);
  for (const std::uint32_t id : codec::AmkIds<codec::AmkSetpoints>::kId) {
    lose(id, 3);
    for (int k = 0; k < 20; ++k) {
      bench.tick();
      CHECK(ready() && all_drive());
    }
  }
  lose(codec::AmkIds<codec::AmkSetpoints>::kId[0], 10);
  bench.run_for(0.12);
  CHECK(none_drives());
  LONGS_EQUAL(Amk::kSetpointsLost, bench.car.drives[0].amk.error());
}

// MST-060
TEST(AmkLoop, BurstsOfFiveActualValuesNeverEndADrive) {
  bench.drive_off(1.0);
  for (const std::uint32_t id : codec::AmkIds<codec::AmkActual1>::kId) {
    lose(id, 5);
    for (int k = 0; k < 60; ++k) {
      bench.tick();
      if (!ready()) FAIL(fmt::format("id {:x}, tick {}: ready-to-drive left", id, k).c_str());
    }
    CHECK_TRUE_TEXT(all_drive(), "the torque does not come back");
  }
}

// MST-074
TEST(AmkLoop, AfterAnErrorTheButtonAtTheVehicleAndTheSequenceBringTheCarBack) {
  bench.drive_off(0.5);
  bench.car.drives[2].amk.fail(Amk::kPlanted);
  bench.pedals = {0.0, 1.0};
  bench.run_for(8.0);
  CHECK(bench.car.drives[2].amk.error() != 0);
  bench.switches.reset = true;
  bench.run_for(0.2);
  bench.switches.reset = false;
  LONGS_EQUAL(0, bench.car.drives[2].amk.error());
  bench.drive_off(0.5);
  CHECK(ready() && all_drive());
}

TEST(AmkLoop, BrakingNeverPushesTheCarBackwards) {
  bench.drive_off(2.0);
  bench.pedals = {0.0, 0.3};
  double least = 1e9, recovered_a = 0.0;
  for (int k = 0; k < 800; ++k) {
    bench.tick();
    least = std::min(least, bench.car.vehicle().speed_mps());
    recovered_a = std::min(recovered_a, bench.car.pack_current_a());
  }
  CHECK(recovered_a < -5.0);
  CHECK(least > -0.01);
}

// A drawn car completes its lap, its ledger closes, and it is no slower than with the same torque at the rear alone.
TEST(AmkLoop, ADrawnLapIsAtLeastAsFastAsWithTheSameTorqueAtTheRearAlone) {
  const std::uint64_t seed = drawn_seed();
  Drawn draw(seed);
  EnduranceOptions options = nominal(1);
  options.vehicle = drawn_car(draw);
  const EnduranceResult four = drive(options);
  options.vehicle = at_the_rear_alone(options.vehicle);
  const EnduranceResult two = drive(options);
  const std::string told = fmt::format("seed {}: {:.3f} s, two driven wheels {:.3f} s, ledger {:.2g} %, {}{}", seed,
                                       four.total_time_s, two.total_time_s, four.ledger.error_pct(),
                                       four.failure_cause, two.failure_cause);
  UT_PRINT(told.c_str());
  CHECK_TEXT(four.finished && two.finished, told.c_str());
  CHECK_TEXT(four.total_time_s <= two.total_time_s * kSolver, told.c_str());
  CHECK_TEXT(four.ledger.error_pct() < 1e-3, told.c_str());
}

TEST(AmkLoop, TheLapSolverKnowsTheDrivenAxles) {
  const std::uint64_t seed = drawn_seed();
  Drawn draw(seed);
  for (int k = 0; k < 20; ++k) {
    const VehicleParameters car = drawn_car(draw), rear = at_the_rear_alone(car);
    for (double share = 0.1; share <= 1.0; share += 0.1) {
      CHECK(drive_grip(car, 15.0, share, 100.0) >= drive_grip(rear, 15.0, share, 100.0));
    }
    const double four = solve_lap(car, michigan(2015), LapStart::kFlying).lap_time_s();
    const double two = solve_lap(rear, michigan(2015), LapStart::kFlying).lap_time_s();
    if (four > two * kSolver) FAIL(fmt::format("seed {}: car {}: {:.3f} s, {:.3f} s", seed, k, four, two).c_str());
  }
}

// SPDX-License-Identifier: Apache-2.0
#include "car/powertrain/amk.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>
#include <fmt/format.h>

#include "car/car.hpp"
#include "car/vehicle/grip.hpp"
#include "core/axle_motors.hpp"
#include "fixtures.hpp"

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr double kTick_s = 0.01, kLink_v = 500.0;

Amk::Setpoints dc_on() {
  Amk::Setpoints s;
  s.dc_on = true;
  return s;
}
Amk::Setpoints on(double torque_nm = 0.0) {
  Amk::Setpoints s = dc_on();
  s.enable = s.inverter_on = true;
  if (torque_nm > 0.0) {
    s.speed_rpm = 20'000.0;
    s.torque_positive_nm = torque_nm;
  }
  if (torque_nm < 0.0) s.torque_negative_nm = torque_nm;
  return s;
}

}  // namespace

TEST_GROUP(AmkInverter) {
  Amk amk{amk_4wd().inverter};

  void send(const Amk::Setpoints& s, int ticks = 1, double link_v = kLink_v) {
    for (int k = 0; k < ticks; ++k) {
      amk.receive(s);
      amk.advance(kTick_s, link_v);
    }
  }
  void switch_on() {
    send(dc_on(), 15);
    send(on(), 8);
  }
};

TEST(AmkInverter, ObeysOnlyAtTheEndOfItsSequence) {
  send(on(10.0), 40);
  CHECK(amk.dc_on());
  CHECK_FALSE(amk.inverter_on());  // its setpoints have never been zero
  send(on(), 8);
  CHECK(amk.inverter_on());
  send(on(10.0));
  DOUBLES_EQUAL(10.0, amk.torque_nm(0.0), 1e-9);
}

TEST(AmkInverter, ADcLinkThatIsNotChargedSwitchesNothingOn) {
  send(on(), 40, 100.0);
  CHECK_FALSE(amk.dc_on());
  switch_on();
  CHECK(amk.inverter_on());
  send(on(10.0), 1, 100.0);
  CHECK_FALSE(amk.inverter_on());
  DOUBLES_EQUAL(0.0, amk.torque_nm(0.0), 0.0);
  CHECK(amk.ready());
}

TEST(AmkInverter, SilenceIsAnErrorThatOnlyAResetWithZeroSetpointsEnds) {
  switch_on();
  for (int k = 0; k < 3; ++k) amk.advance(kTick_s, kLink_v);
  CHECK(amk.inverter_on());
  for (int k = 0; k < 2; ++k) amk.advance(kTick_s, kLink_v);
  LONGS_EQUAL(Amk::kSetpointsLost, amk.error());
  send(on(), 40);
  CHECK_FALSE(amk.dc_on());
  Amk::Setpoints reset = on(10.0);
  reset.error_reset = true;
  send(reset);
  CHECK(amk.error() != 0);
  reset = Amk::Setpoints{};
  reset.error_reset = true;
  send(reset);
  LONGS_EQUAL(0, amk.error());
  CHECK_FALSE(amk.dc_on());
  switch_on();
  CHECK(amk.inverter_on());
}

TEST(AmkInverter, BrakingEndsAtStandstillAndDrivingAtItsTargetVelocity) {
  switch_on();
  send(on(-15.0));
  DOUBLES_EQUAL(-15.0, amk.torque_nm(5'000.0), 1e-9);
  DOUBLES_EQUAL(0.0, amk.torque_nm(0.0), 0.0);
  DOUBLES_EQUAL(0.0, amk.torque_nm(-100.0), 0.0);
  send(on(15.0));
  DOUBLES_EQUAL(15.0, amk.torque_nm(5'000.0), 1e-9);
  DOUBLES_EQUAL(0.0, amk.torque_nm(20'000.0), 1e-9);
}

TEST(AmkInverter, DrawnEventsNeverGiveTorqueWithoutTheSequence) {
  const auto seed = std::random_device{}();
  UT_PRINT(fmt::format("seed {}", seed).c_str());
  std::mt19937 draw(seed);
  int zeros_when_on = 0, driven = 0;
  bool was_zero_on = false;
  for (int k = 0; k < 200'000; ++k) {
    const auto event = draw() % 1000;
    if (event < 900) {
      Amk::Setpoints s = on(draw() % 3 == 0 ? 0.0 : 12.0);
      s.enable = draw() % 100 != 0;
      s.inverter_on = draw() % 100 != 0;
      s.dc_on = draw() % 150 != 0;
      s.error_reset = draw() % 20 == 0;
      amk.receive(s);
      if (!s.enable || !s.inverter_on || !s.dc_on) was_zero_on = false;
      if (s.zero() && s.enable && s.inverter_on && amk.dc_on()) was_zero_on = true;
      zeros_when_on += was_zero_on ? 1 : 0;
    } else if (event < 904) {
      amk.fail(Amk::kPlanted);
    }
    amk.advance(kTick_s, draw() % 500 == 0 ? 100.0 : kLink_v);
    if (!amk.dc_on()) was_zero_on = false;
    if (amk.error() != 0 || !amk.dc_on()) CHECK_FALSE(amk.inverter_on());
    if (amk.torque_nm(0.0) != 0.0) {
      CHECK(was_zero_on && amk.inverter_on() && amk.dc_on() && amk.error() == 0);
      ++driven;
    }
  }
  CHECK(zeros_when_on > 1'000 && driven > 1'000);
}

TEST_GROUP(DrivenAxles) { VehicleParameters car = amk_4wd(); };

TEST(DrivenAxles, AFullPedalIsTheMostThatTheSharesLetNoMotorExceed) {
  for (const double share : {0.0, 0.3, 0.5, 0.8, 1.0}) {
    car.powertrain.front_torque_share = share;
    const double full = full_phase_current_a(car);
    const DrivenAxles axles = driving_axles(car.powertrain);
    const double most = std::max(axles.front.each(full), axles.rear.each(full));
    DOUBLES_EQUAL(car.inverter.current_max_a, most, 1e-9);
    DOUBLES_EQUAL(full, 2.0 * (axles.front.each(full) + axles.rear.each(full)), 1e-9);
  }
}

TEST(DrivenAxles, TheGripOfFourDrivenWheelsIsThatOfTheFirstAxleAtItsEdge) {
  double best = 0.0;
  for (double share = 0.0; share <= 1.0; share += 0.01) {
    car.powertrain.front_torque_share = share;
    const double force = drive_grip(car, 0.0, 1.0, 50.0);
    const double accelerating = (force - 50.0) / total_mass(car);
    const AxleLoads loads = axle_loads(car, accelerating, 0.0);
    const double front = peak_friction(car.tyres) * loads.front_n, rear = peak_friction(car.tyres) * loads.rear_n;
    CHECK(share * force <= front * (1.0 + 1e-9) && (1.0 - share) * force <= rear * (1.0 + 1e-9));
    CHECK(share * force > front * (1.0 - 1e-9) || (1.0 - share) * force > rear * (1.0 - 1e-9));
    best = std::max(best, force);
  }
  car.powertrain.front_torque_share = 0.0;
  CHECK(best > 1.2 * drive_grip(car, 0.0, 1.0, 50.0));
}

TEST(DrivenAxles, BothAxlesSlipForThemselvesAndTheirMotorsTurnWithThem) {
  Car four(car, true, 0.001);
  for (MotorDrive& drive : four.drives) drive.inverter.command(drive.front ? 60.0 : 10.0, true);
  four.contactors.air_minus.command(true);
  four.contactors.air_plus.command(true);
  for (int k = 0; k < 100; ++k) {
    for (MotorDrive& drive : four.drives) drive.inverter.command(drive.front ? 60.0 : 10.0, true);
    for (int i = 0; i < 10; ++i) four.step(0.0);
    four.renew(0.01);
  }
  CHECK(four.vehicle().front_omega() > 1.05 * four.vehicle().rear_omega());
  DOUBLES_EQUAL(four.vehicle().front_omega() * 13.0, four.motor_omega_rad_s(four.drives[0]), 1e-9);
  DOUBLES_EQUAL(four.vehicle().rear_omega() * 13.0, four.motor_omega_rad_s(four.drives[3]), 1e-9);
  CHECK(four.drives[0].thermal.copper_c() > four.drives[2].thermal.copper_c());
  DOUBLES_EQUAL(four.drives[0].thermal.copper_c(), four.motor_thermal().copper_c(), 1e-12);
  CHECK(four.ledger().error_pct() < 1e-6);
}

// SPDX-License-Identifier: Apache-2.0
// The whole controller with four AMK inverters, which answer as they are told and break in every order.
#include "master/inverter/amk_watch.hpp"
#include "master/command_veto.hpp"

#include <cstdio>
#include <random>

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"
#include "firmware/master/inverter/amk_bench.hpp"

using namespace voltlap;
using namespace voltlap::master;
using namespace voltlap::master::bench;

namespace {

/// An inverter that answers its setpoints a step later.
struct AnsweringAmk {
  bool ready = true, error = false, silent = false, frozen = false, dc_on = false, on = false;
  std::int32_t excess_ma = 0;
  codec::AmkSetpoints last{};

  void take(const codec::AmkSetpoints& m) {
    const bool zero =
        m.target_velocity_rpm == 0 && m.torque_limit_positive_ppm == 0 && m.torque_limit_negative_ppm == 0;
    if (m.error_reset && zero) error = false;
    dc_on = m.dc_on && ready && !error;
    on = dc_on && m.enable && m.inverter_on && (on || zero);
    last = m;
  }
  [[nodiscard]] bool torque() const {
    return last.torque_limit_positive_ppm != 0 || last.torque_limit_negative_ppm != 0;
  }
  [[nodiscard]] codec::AmkActual1 says(std::int32_t speed_rpm, std::int32_t constant_unm, std::int32_t nominal) const {
    codec::AmkActual1 m;
    m.system_ready = ready && !error;
    m.error = error;
    m.dc_on = m.quit_dc_on = dc_on && !error && ready;
    m.inverter_on = m.quit_inverter_on = on && m.dc_on;
    m.actual_velocity_rpm = speed_rpm;
    const std::int64_t ppm = std::int64_t{last.torque_limit_positive_ppm} + last.torque_limit_negative_ppm;
    const std::int64_t ma = (m.inverter_on ? ppm * nominal / constant_unm : 0) + excess_ma;
    m.torque_current = static_cast<std::int16_t>(ma * 16'384 / 107'200);
    return m;
  }
};

}  // namespace

TEST_GROUP(AmkWatch) {
  Car car;
  InverterLink link{};
  AnsweringAmk amk[kWheels];
  std::int32_t speed_rpm = 0;
  std::int32_t frozen_rpm = 0;
  bool torque_ever_early = false;

  void setup() override {
    car.config = amk_config();
    link = inverter_link(car.config);
  }
  /// Frames of all that speak, the controller's step, and its setpoints to all four.
  void step_all() {
    Input& in = car.in;
    in.now = in.now + Duration::from_ms(kStepMs);
    touch_all(in);
    for (std::size_t k = 0; k < kWheels; ++k) {
      if (amk[k].silent) continue;
      const std::int32_t rpm = amk[k].frozen ? frozen_rpm : speed_rpm;
      take_amk(wheel_frame(amk[k].says(rpm, car.config.motor_constant_unm_per_a, car.config.nominal_torque_mnm), k),
               link.amk, in);
      codec::AmkActual2 warm;
      warm.motor_temperature_dc = warm.inverter_temperature_dc = warm.igbt_temperature_dc = 400;
      warm.motor_temperature_ok = warm.inverter_temperature_ok = warm.igbt_temperature_ok = true;
      take_amk(wheel_frame(warm, k), link.amk, in);
    }
    for (Sample<Speed>& wheel : in.wheel_speed) wheel.value = Speed::from_raw(speed_rpm * 2);
    settle_amk(link.amk, in);
    car.out = step(car.config, in, car.state);
    bool all_on = true;
    for (const AnsweringAmk& one : amk) all_on = all_on && one.on && !one.error && one.ready;
    for (std::size_t k = 0; k < kWheels; ++k) {
      amk[k].take(amk_setpoints(car.out, k, link.amk_scale));
      torque_ever_early = torque_ever_early || (amk[k].torque() && !was_on);
    }
    was_on = all_on;
  }
  bool was_on = false;
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step_all();
  }
  void to_ts_active() {
    run(3);
    car.in.switches.value.ts_on_button = true;
    run(1);
    car.in.switches.value.ts_on_button = false;
    car.in.bms_state.value = BmsState::kTsActive;
    run(5);
  }
  void press_rtd() {
    car.pedal(0);
    car.brake(20'000);
    car.in.switches.value.rtd_button = true;
    run(1);
    car.in.switches.value.rtd_button = false;
    car.brake(0);
    run(1);
  }
  void to_full_pedal() {
    to_ts_active();
    run(40);
    press_rtd();
    run(8);
    car.pedal(1000);
    run(8);
  }
  [[nodiscard]] bool ready() const { return car.out.drive_state == DriveState::kReadyToDrive; }
  [[nodiscard]] bool driving() const { return car.out.phase_current > Current::from_raw(10'000); }
  [[nodiscard]] bool zero_everywhere() const {
    for (const AnsweringAmk& one : amk) {
      if (one.torque()) return false;
    }
    return true;
  }
};

// MST-068
TEST(AmkWatch, TheSequenceEndsInTorqueAtAllFour) {
  to_full_pedal();
  CHECK(ready() && driving());
  LONGS_EQUAL(0, car.out.faults.bits);
  for (const AnsweringAmk& one : amk) CHECK(one.torque());
  CHECK_FALSE(torque_ever_early);
}

// MST-068
TEST(AmkWatch, OneThatIsNotReadyKeepsTheCarFromReadyToDriveAndIsTold) {
  amk[1].ready = false;
  to_ts_active();
  press_rtd();
  CHECK_FALSE(ready());
  run(55);
  CHECK(car.out.faults.has(MasterFault::kInverterLost));
  amk[1].ready = true;
  run(3);
  CHECK_FALSE(car.out.faults.has(MasterFault::kInverterLost));
  press_rtd();
  CHECK(ready());
}

// MST-068: a button that is held counts when they are, one that was let go does not.
TEST(AmkWatch, TheButtonMayBeHeldUntilAllFourAreReady) {
  for (const bool held : {true, false}) {
    car = Car{};
    setup();
    for (AnsweringAmk& one : amk) one = AnsweringAmk{};
    amk[3].ready = false;
    to_ts_active();
    car.brake(20'000);
    car.in.switches.value.rtd_button = true;
    run(5);
    CHECK_FALSE(ready());
    car.in.switches.value.rtd_button = held;
    run(2);
    amk[3].ready = true;
    run(3);
    CHECK(ready() == held);
    car.in.switches.value.rtd_button = false;
  }
}

// MST-012, MST-068: it is waited for with a button that was pressed for it, not with one that is held from before.
TEST(AmkWatch, AButtonThatIsHeldFromBeforeIsNotWaitedWith) {
  amk[3].ready = false;
  run(3);
  car.in.switches.value.ts_on_button = true;
  run(1);
  car.in.switches.value.ts_on_button = false;
  car.in.switches.value.rtd_button = true;
  run(1);
  car.in.bms_state.value = BmsState::kTsActive;
  car.brake(20'000);
  run(5);
  amk[3].ready = true;
  run(10);
  CHECK_FALSE(ready());
}

// MST-012, MST-070: nor with the one that the drive began with.
TEST(AmkWatch, AButtonThatIsHeldThroughADriveDoesNotBeginTheNext) {
  amk[3].ready = false;
  to_ts_active();
  car.brake(20'000);
  car.in.switches.value.rtd_button = true;
  run(5);
  amk[3].ready = true;
  run(5);
  CHECK(ready());
  amk[3].ready = false;
  run(5);
  CHECK_FALSE(ready());
  amk[3].ready = true;
  run(20);
  CHECK_FALSE(ready());
}

// MST-070: an error is a fault of the inverter, and latches (MST-010).
TEST(AmkWatch, AnErrorOfOneTakesTheTorqueOfAllInTheSameStepAndNeedsTheButton) {
  for (std::size_t k = 0; k < kWheels; ++k) {
    setup();
    car = Car{};
    car.config = amk_config();
    for (AnsweringAmk& one : amk) one = AnsweringAmk{};
    to_full_pedal();
    CHECK(driving());
    amk[k].error = true;
    run(1);
    CHECK(zero_everywhere());
    CHECK(car.out.drive_state == DriveState::kFault && car.out.faults.has(MasterFault::kInverterFault));
    car.pedal(0);
    run(100);
    CHECK(car.out.drive_state == DriveState::kFault);
    CHECK(amk[k].error);
    car.in.switches.value.reset_button = true;  // MST-074
    run(4);
    CHECK_FALSE(amk[k].error);
    CHECK(car.out.drive_state == DriveState::kLvOn);
  }
}

// MST-070: within what MST-050 allows, and ready-to-drive is left 100 ms after the last sign of life.
TEST(AmkWatch, SilenceOfOneTakesTheTorqueOfAll) {
  to_full_pedal();
  amk[3].silent = true;
  run(4);
  CHECK(driving() && ready());
  run(1);
  CHECK(zero_everywhere());
  CHECK(car.out.faults.has(MasterFault::kInverterLost));
  run(6);
  CHECK_FALSE(ready());
  amk[3].silent = false;
  run(100);
  CHECK_FALSE(ready());
  press_rtd();
  run(8);
  car.pedal(1000);
  run(5);
  CHECK(ready() && driving());
}

// MST-070
TEST(AmkWatch, OneThatSwitchesOffByItselfEndsTheDrive) {
  to_full_pedal();
  amk[0].on = false;
  amk[0].dc_on = true;
  step_all();
  CHECK(zero_everywhere());
  CHECK_FALSE(ready());
  run(20);
  CHECK_FALSE(ready());
}

// MST-072
TEST(AmkWatch, ASpeedThatStandsAtOneIsFoundAtEachAxle) {
  for (std::size_t k = 0; k < kWheels; ++k) {
    car = Car{};
    setup();
    for (AnsweringAmk& one : amk) one = AnsweringAmk{};
    speed_rpm = 1'000;
    to_full_pedal();
    amk[k].frozen = true;
    frozen_rpm = speed_rpm;
    int steps = 0;
    while (!car.out.faults.has(MasterFault::kInverterFault) && steps < 100) {
      speed_rpm += 50;
      run(1);
      ++steps;
    }
    CHECK(steps <= 25);
    CHECK(zero_everywhere());
    speed_rpm = 0;
  }
}

// MST-041
TEST(AmkWatch, ACurrentThatNobodyAskedForIsFoundAtOneOfFour) {
  to_full_pedal();
  car.pedal(0);
  run(20);
  amk[2].excess_ma = 16'000;
  run(20);
  CHECK_FALSE(car.out.faults.has(MasterFault::kInverterFault));
  run(2);
  CHECK(car.out.faults.has(MasterFault::kInverterFault));
}

// MST-073
TEST(AmkWatch, ForeignSetpointsTakeTheTorque) {
  to_full_pedal();
  CHECK(driving());
  car.in.foreign_frames = true;
  run(1);
  CHECK(zero_everywhere());
}

// MST-051
TEST(AmkWatch, TheGateVetoesFourCurrentsThatAreNotTheCommand) {
  to_full_pedal();
  InverterCommand command{Current::from_raw(40'000), true};
  command.wheel = {{Current::from_raw(10'000), Current::from_raw(10'000), Current::from_raw(10'000),
                    Current::from_raw(10'000)}};
  CHECK(command_allowed(car.config, car.in, command));
  InverterCommand one_against = command;
  one_against.wheel.of[0] = Current::from_raw(-10'000);
  one_against.wheel.of[1] = Current::from_raw(30'000);
  CHECK_FALSE(command_allowed(car.config, car.in, one_against));
  InverterCommand more = command;
  more.wheel.of[2] = Current::from_raw(10'001);
  CHECK_FALSE(command_allowed(car.config, car.in, more));
  InverterCommand beyond = command;
  beyond.phase_current = Current::from_raw(80'801);
  beyond.wheel = {{Current::from_raw(80'801), Current{}, Current{}, Current{}}};
  CHECK_FALSE(command_allowed(car.config, car.in, beyond));
  InverterCommand disabled = command;
  disabled.enable = false;
  disabled.phase_current = Current{};
  CHECK_FALSE(command_allowed(car.config, car.in, disabled));
  car.in.inverter_state.value = InverterState::kDisabled;
  CHECK_FALSE(command_allowed(car.config, car.in, command));
}

// MST-068, MST-069, MST-070: whatever comes in whatever order.
TEST(AmkWatch, DrawnEventsNeverGiveTorqueBeforeAllFourObeyNorBesideOneThatHasFailed) {
  const unsigned seed = std::random_device{}();
  char text[64];
  std::snprintf(text, sizeof text, "seed %u", seed);
  UT_PRINT(text);
  std::mt19937 draw(seed);
  const auto one_in = [&](unsigned n) { return draw() % n == 0; };
  int driven = 0;
  for (int k = 0; k < 60'000; ++k) {
    AnsweringAmk& one = amk[draw() % kWheels];
    if (one_in(300)) one.error = true;
    if (one_in(300)) one.ready = false;
    if (one_in(40)) one.ready = true;
    if (one_in(200)) one.silent = true;
    if (one_in(20)) one.silent = false;
    if (one_in(400)) one.on = false;
    Switches& switches = car.in.switches.value;
    switches.ts_on_button = draw() % 4 == 0;
    switches.reset_button = draw() % 8 == 0;
    switches.rtd_button = draw() % 4 == 0;
    const bool off = car.out.drive_state == DriveState::kLvOn || car.out.drive_state == DriveState::kFault;
    car.in.bms_state.value = off ? BmsState::kIdle : BmsState::kTsActive;
    const bool braking = car.out.drive_state == DriveState::kTsActive;
    car.brake(braking ? 20'000 : 0);
    car.pedal(!braking && draw() % 10 != 0 ? 800 : 0);
    std::int32_t oldest_ms = 0;
    bool failed = false;
    step_all();
    for (std::size_t w = 0; w < kWheels; ++w) {
      const std::int32_t age = (car.in.now - link.amk.state[w].time).ms();
      oldest_ms = age > oldest_ms ? age : oldest_ms;
      failed = failed || link.amk.state[w].value != InverterState::kEnabled;
    }
    const bool torque = !zero_everywhere();
    if (torque && (failed || oldest_ms >= 50)) FAIL(text);
    if (torque) {
      ++driven;
      CHECK(ready());
      for (const Current current : car.out.wheel.of) CHECK(current <= car.config.motor_current_max);
    }
  }
  CHECK(driven > 500);
}

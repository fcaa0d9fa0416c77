// SPDX-License-Identifier: Apache-2.0
#include "master/master_step.hpp"

#include <utility>

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"

using namespace voltlap;
using namespace voltlap::master;

TEST_GROUP(MasterStep){bench::Car car;};

TEST(MasterStep, FullPedalGives550AmpereWithin30Ms) {
  car.drive_to_ready();
  car.pedal(1000);
  car.run(3);
  LONGS_EQUAL(550'000, car.out.phase_current.raw());
  CHECK(car.out.enable);
  CHECK_FALSE(car.out.faults.any());
  LONGS_EQUAL(1'000'000, car.out.pedal_request.raw());
}

TEST(MasterStep, DisabledCommandIsSentBeforeTheFirstEnabledOne) {
  car.drive_to_ts_active();
  CHECK_FALSE(car.out.enable);
}

// MST-001
TEST(MasterStep, LostPedalsGiveZeroInTheSameStep) {
  car.drive_at_full_pedal();
  car.in.apps1.quality = car.in.apps2.quality = Quality::kStale;
  car.run();
  LONGS_EQUAL(0, car.out.phase_current.raw());
  CHECK(car.out.faults.has(MasterFault::kPedalsLost));
}

TEST(MasterStep, LostInverterGivesZeroAndDisabledInTheSameStep) {
  car.drive_at_full_pedal();
  car.in.inverter_state.quality = Quality::kStale;
  car.run();
  LONGS_EQUAL(0, car.out.phase_current.raw());
  CHECK_FALSE(car.out.enable);
  CHECK(car.out.faults.has(MasterFault::kInverterLost));
}

// MST-005
TEST(MasterStep, BrakeWithFullPedalGivesZeroInTheSameStepAndStaysOff) {
  car.drive_at_full_pedal();
  car.brake(20'000);
  car.run();
  LONGS_EQUAL(0, car.out.phase_current.raw());
  car.brake(0);
  car.run(100);
  LONGS_EQUAL(0, car.out.phase_current.raw());
  car.pedal(40);
  car.run();
  LONGS_EQUAL(22'000, car.out.phase_current.raw());
}

// MST-050
TEST(MasterStep, SamplesThatNobodyAgesAreStillVetoedAt50Ms) {
  car.drive_at_full_pedal();
  for (std::int32_t ms = 10; ms <= 60; ms += 10) {
    car.in.now = car.in.now + Duration::from_ms(10);
    car.out = step(car.config, car.in, car.state);
    CHECK_EQUAL(ms < 50, car.out.phase_current.raw() > 0);
  }
  CHECK(car.out.faults.has(MasterFault::kGateVeto));
  CHECK(car.out.torque_reason == TorqueReason::kGate);
}

// MST-050: and what it is that is late is named, while the car stays ready to drive.
TEST(MasterStep, WhatIs50MsOldIsNamedAndWhatIs40MsOldIsNot) {
  Input& in = car.in;
  const std::pair<Instant*, MasterFault> kRows[] = {{&in.apps1.time, MasterFault::kPedalsLost},
                                                    {&in.apps2.time, MasterFault::kPedalsLost},
                                                    {&in.bms_state.time, MasterFault::kBmsLost},
                                                    {&in.discharge_limit.time, MasterFault::kBmsLost},
                                                    {&in.charge_limit.time, MasterFault::kBmsLost},
                                                    {&in.switches.time, MasterFault::kVehicleIoLost},
                                                    {&in.inverter_state.time, MasterFault::kInverterLost}};
  car.drive_at_full_pedal();
  for (const auto& [time, fault] : kRows) {
    for (const std::int32_t age_ms : {49, 50}) {
      in.now = in.now + Duration::from_ms(10);
      bench::touch_all(in);
      *time = Instant::from_ms(in.now.ms() - static_cast<std::uint32_t>(age_ms));
      car.out = step(car.config, in, car.state);
      CHECK_EQUAL(age_ms == 50, car.out.faults.has(fault));
      CHECK_EQUAL(age_ms == 50, car.out.phase_current.raw() == 0);
      CHECK(car.out.drive_state == DriveState::kReadyToDrive);
    }
  }
}

// MST-040
TEST(MasterStep, AnInverterThatHearsNoCommandsIsNamed) {
  car.drive_at_full_pedal();
  CHECK_FALSE(car.out.faults.any());
  car.in.inverter_state.value = InverterState::kCommandTimeout;
  CHECK(car.run().faults.has(MasterFault::kInverterLost));
  LONGS_EQUAL(0, car.out.phase_current.raw());
  car.in.inverter_state.value = InverterState::kEnabled;
  CHECK_FALSE(car.run().faults.any());
}

// MST-061
TEST(MasterStep, ForeignFramesEndTheTorqueUntilThePedalIsReleasedWhicheverNodeHearsThem) {
  for (bool Input::*heard : {&Input::foreign_frames, &Input::bms_hears_foreign}) {
    car = bench::Car{};
    car.drive_at_full_pedal();
    car.in.*heard = true;
    car.run();
    LONGS_EQUAL(0, car.out.phase_current.raw());
    CHECK_EQUAL(car.in.foreign_frames, car.out.faults.has(MasterFault::kForeignFrames));
    car.in.*heard = false;
    car.run(100);
    LONGS_EQUAL(0, car.out.phase_current.raw());
    car.pedal(0);
    car.run();
    car.pedal(1000);
    car.run(3);
    LONGS_EQUAL(550'000, car.out.phase_current.raw());
  }
}

TEST(MasterStep, TimeThatStandsStillOrRunsBackRaisesNothing) {
  car.drive_to_ready();
  car.pedal(1000);
  const Instant before = car.in.now;
  car.out = step(car.config, car.in, car.state);
  LONGS_EQUAL(0, car.out.phase_current.raw());
  car.in.now = Instant::from_ms(before.ms() - 100);
  car.out = step(car.config, car.in, car.state);
  LONGS_EQUAL(0, car.out.phase_current.raw());
}

TEST(MasterStep, LateStepGetsNoMoreCreditThanTwoSteps) {
  car.drive_to_ready();
  car.config.request_rise_ma_per_ms = 1'000;
  car.pedal(1000);
  car.in.now = car.in.now + Duration::from_ms(500);
  bench::touch_all(car.in);
  car.out = step(car.config, car.in, car.state);
  LONGS_EQUAL(20'000, car.out.phase_current.raw());
}

TEST(MasterStep, RefusedConfigurationWithoutPowerStillStepsAndGivesNothing) {
  car.config.power_max_mw = 0;
  car.in.pack_current = bench::good(Current::from_raw(10'000));
  car.run(3);
  CHECK(car.out.faults.has(MasterFault::kConfigInvalid));
  CHECK(car.out.drive_state == DriveState::kFault);
  CHECK_FALSE(car.out.enable);
  LONGS_EQUAL(0, car.out.phase_current.raw());
}

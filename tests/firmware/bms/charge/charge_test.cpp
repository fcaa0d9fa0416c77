// SPDX-License-Identifier: Apache-2.0
// How a charge begins, and what breaks it off.
#include "bms/charge/charge.hpp"

#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::ChargePhase;
using can::ChargeReason;

TEST_GROUP(Charge) {
  ChargeBench charger;
  Bench& bench = charger.bench;

  /// Off, open, and nothing but the switch begins again.
  void expect_stopped(ChargeReason why) {
    CHECK_EQUAL(static_cast<int>(ChargePhase::kStopped), static_cast<int>(charger.phase()));
    CHECK_EQUAL(static_cast<int>(why), static_cast<int>(charger.reason()));
    CHECK(bench.out.charge.asked == Current{});
    CHECK(charger.until([](const Output& o) { return all_open(o); }, 200) >= 0);
  }
  void expect_waiting(ChargeReason why) {
    charger.run(4'000);
    bench.io.charge_switch = true;
    charger.run(2'000);
    CHECK_EQUAL(static_cast<int>(ChargePhase::kWaiting), static_cast<int>(charger.phase()));
    CHECK_EQUAL(static_cast<int>(why), static_cast<int>(charger.reason()));
    CHECK(all_open(bench.out) && bench.out.charge.asked == Current{});
  }
};

// BMS-051
TEST(Charge, ContactorsCloseForTheChargerAndNoTorqueIsPossible) {
  bool ever_active = false, ever_drawn = false;
  charger.run(3'000);
  bench.io.charge_switch = true;
  const std::int32_t took = charger.until(
      [&](const Output& o) {
        ever_active = ever_active || o.state == can::BmsState::kTsActive;
        ever_drawn = ever_drawn || o.limits.discharge.value > Current{};
        return o.charge.asked == amps(20);
      },
      60'000);
  CHECK(took >= 0);
  CHECK_FALSE(ever_active || ever_drawn);
  CHECK(bench.out.state == can::BmsState::kCharging);
  CHECK(bench.out.limits.discharge.reason == can::LimitReason::kCharging);
  CHECK(bench.out.contactors.air_plus && bench.out.contactors.air_minus);
  CHECK(bench.out.waits_for == can::WaitsFor::kNone);
  expect_time("BMS-051", 0, 0, 10);
}

TEST(Charge, WithoutASwitchNothingIsAskedAndNothingIsTold) {
  charger.run(10'000);
  CHECK_FALSE(bench.out.charge.on);
  CHECK(bench.out.state == can::BmsState::kIdle);
}

TEST(Charge, WaitsForAChargerInThePack) {
  bench.config.charger_current_max = Current{};
  expect_waiting(ChargeReason::kNoChargerInPack);
}
TEST(Charge, WaitsForAChargerThatSpeaks) {
  bench.charger_talks = false;
  expect_waiting(ChargeReason::kChargerSilent);
}
TEST(Charge, WaitsForAChargerWithoutFault) {
  bench.charger.over_temperature = true;
  expect_waiting(ChargeReason::kChargerFault);
}
TEST(Charge, WaitsForTheShutdownCircuit) {
  bench.io.shutdown_closed = false;
  expect_waiting(ChargeReason::kShutdownCircuit);
  CHECK(bench.out.waits_for == can::WaitsFor::kShutdownCircuit);
}
TEST(Charge, WaitsForWarmerCells) {
  bench.temperature_dc[0] = -1;
  expect_waiting(ChargeReason::kTemperature);
}
TEST(Charge, WaitsForAMissingCell) {
  bench.invalid_cells.insert(3);
  expect_waiting(ChargeReason::kMeasurementLost);
}

TEST(Charge, ARequestToDriveComesBeforeTheCharger) {
  charger.run(3'000);
  bench.request(true);
  bench.io.charge_switch = true;
  charger.run(3'000);
  CHECK(charger.reason() == ChargeReason::kRequestReleased);
  CHECK(all_open(bench.out));
}

TEST(Charge, PluggingAChargerWhileDrivingOpensTheContactors) {
  charger.run(3'000);
  bench.request(true);
  charger.until([](const Output& o) { return o.state == can::BmsState::kTsActive; }, 10'000);
  bench.io.charge_switch = true;
  const std::int32_t took = charger.until([](const Output& o) { return all_open(o); }, 1'000);
  expect_time("BMS-051 plugged while driving", took, 500, 620);
}

// BMS-051
TEST(Charge, NothingIsClosedForADriveWhileTheSwitchIsOnHoweverShortly) {
  charger.run(3'000);
  bench.io.charge_switch = true;
  bench.request(true);
  for (int tick = 0; tick < 40; ++tick) {
    charger.run(10);
    CHECK(all_open(bench.out));
  }
}

// BMS-051
TEST(Charge, ASwitchThatBouncesDoesNotStopADrivingCar) {
  charger.run(3'000);
  bench.request(true);
  charger.until([](const Output& o) { return o.state == can::BmsState::kTsActive; }, 10'000);
  for (int bounce = 0; bounce < 5; ++bounce) {
    bench.io.charge_switch = true;
    charger.run(400);
    bench.io.charge_switch = false;
    charger.run(200);
    CHECK(bench.out.state == can::BmsState::kTsActive);
  }
}

// BMS-053
TEST(Charge, ASilentChargerEndsIt) {
  charger.charge();
  bench.charger_talks = false;
  const std::int32_t took = charger.until([](const Output& o) { return o.charge.asked == Current{}; }, 20'000);
  expect_time("BMS-053", took, 2'000, 3'010);  // counted from a report that may have come just before
  expect_stopped(ChargeReason::kChargerSilent);
  bench.charger_talks = true;
  charger.run(10'000);
  CHECK(charger.phase() == ChargePhase::kStopped && all_open(bench.out));
  CHECK(bench.out.waits_for == can::WaitsFor::kChargeSwitchOff);
  bench.io.charge_switch = false;
  charger.run(6'000);
  CHECK(bench.out.state == can::BmsState::kIdle);
  charger.charge();
}

// BMS-053
TEST(Charge, AChargerThatReportsAFaultEndsIt) {
  charger.charge();
  bench.charger.hardware_failure = true;
  const std::int32_t took = charger.until([](const Output& o) { return o.charge.asked == Current{}; }, 20'000);
  expect_time("BMS-053 fault", took, 0, 1'010);  // its report comes every second
  expect_stopped(ChargeReason::kChargerFault);
}

TEST(Charge, AChargerThatSeesNoBatteryOrHearsNothingEndsItAfterItsTime) {
  charger.charge();
  bench.charger.communication_timeout = true;
  const std::int32_t took = charger.until_phase(ChargePhase::kStopped, 20'000);
  CHECK(took >= 5'000 && took <= 6'010);
  expect_stopped(ChargeReason::kChargerNotConnected);
}

// BMS-054
TEST(Charge, CurrentThatWasNotAskedForEndsIt) {
  charger.charge();
  charger.run(30'000);
  charger.flows_besides_a = 2.5;  // beyond 5 % of 20 A and 1 A
  const std::int32_t took = charger.until_phase(ChargePhase::kStopped, 20'000);
  expect_time("BMS-054", took, 5'000, 5'010);
  expect_stopped(ChargeReason::kCurrentNotAsked);
}

// BMS-054
TEST(Charge, CurrentOutOfThePackEndsIt) {
  charger.charge();
  charger.gives_at_most_a = 0.0;
  charger.flows_besides_a = -1.2;
  expect_time("BMS-054 out", charger.until_phase(ChargePhase::kStopped, 20'000), 5'000, 5'010);
  expect_stopped(ChargeReason::kCurrentNotAsked);
}

TEST(Charge, CurrentWithinTheSensorsErrorEndsNothing) {
  charger.charge();
  charger.run(30'000);
  charger.flows_besides_a = 1.9;
  charger.run(60'000);
  CHECK(charger.phase() == ChargePhase::kCharging);
}

TEST(Charge, NoCurrentForTenMinutesIsSaid) {
  charger.charge();
  charger.gives_at_most_a = 0.0;
  charger.run(590'000);
  CHECK(charger.phase() == ChargePhase::kCharging);
  charger.run(30'000);
  expect_stopped(ChargeReason::kNoCurrent);
}

TEST(Charge, AnOpenShutdownCircuitOpensInTheSameStepAndTellsTheChargerInIt) {
  charger.charge();
  bench.io.shutdown_closed = false;
  charger.tick();
  CHECK(all_open(bench.out));
  CHECK(bench.out.charge.at_once && bench.out.charge.asked == Current{});
  expect_stopped(ChargeReason::kShutdownCircuit);
  bench.io.shutdown_closed = true;
  charger.run(10'000);
  CHECK(all_open(bench.out));
}

TEST(Charge, AFaultEndsIt) {
  charger.charge();
  bench.invalid_cells.insert(2);
  charger.run(700);
  expect_stopped(ChargeReason::kFault);
}

TEST(Charge, ADriverWhoAsksForTheTractiveSystemEndsIt) {
  charger.charge();
  bench.request(true);
  charger.run(100);
  expect_stopped(ChargeReason::kRequestReleased);
}

TEST(Charge, TheChargerIsToldForFiveSecondsThatTheSwitchIsOff) {
  charger.charge();
  bench.io.charge_switch = false;
  charger.tick();
  CHECK(bench.out.charge.on && bench.out.charge.at_once && bench.out.charge.asked == Current{});
  charger.run(200);
  CHECK(all_open(bench.out));
  charger.run(4'500);
  CHECK(bench.out.charge.on);
  charger.run(500);
  CHECK_FALSE(bench.out.charge.on);
}

TEST(Charge, CellsThatGetTooHotOrTooColdAreChargedLessOrNotUntilTheyAreWellAgain) {
  charger.charge();
  for (std::int32_t c = 250; c < 525; c += 5) {
    for (auto& t : bench.temperature_dc) t = c;
    charger.run(1'000);
  }
  CHECK(bench.out.charge.asked > amps(5) && bench.out.charge.asked < amps(7));  // 6 A at 52 degC
  for (std::int32_t c = 520; c > -5; c -= 5) {
    for (auto& t : bench.temperature_dc) t = c;
    charger.run(1'000);
  }
  CHECK(bench.out.charge.asked == amps(20) && charger.reason() == ChargeReason::kNone);
  for (auto& t : bench.temperature_dc) t = -1;
  charger.run(2'000);
  CHECK(bench.out.charge.asked == Current{} && charger.reason() == ChargeReason::kTemperature);
  CHECK(charger.phase() == ChargePhase::kCharging);
  for (auto& t : bench.temperature_dc) t = 10;
  charger.run(60'000);
  CHECK(bench.out.charge.asked == amps(20) && charger.reason() == ChargeReason::kNone);
}

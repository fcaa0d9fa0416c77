// SPDX-License-Identifier: Apache-2.0
// What a charge goes by, each thing missing or wrong; and what it does when nothing comes of it.
#include "bms/charge/charge.hpp"

#include "bms/faults.hpp"
#include "charge_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::ChargePhase;
using can::ChargeReason;

namespace {

constexpr std::int32_t kHour = 3'600'000;

}  // namespace

TEST_GROUP(ChargeInput) {
  ChargeBench charger;
  Bench& bench = charger.bench;

  void expect(ChargePhase phase, ChargeReason why) {
    CHECK_EQUAL(static_cast<int>(phase), static_cast<int>(bench.state.charge.phase));
    CHECK_EQUAL(static_cast<int>(why), static_cast<int>(bench.state.charge.reason));
  }
  /// The stage alone, in the step after the last one.
  void run_alone(bool slow) { run_charge(bench.config, bench.now(), Duration::from_ms(10), slow, bench.state); }
  void expect_waiting(ChargeReason why) {
    bench.io.charge_switch = true;
    charger.run(2'000);
    expect(ChargePhase::kWaiting, why);
    CHECK(all_open(bench.out) && bench.out.charge.asked == Current{});
  }
  void expect_ended(ChargeReason why, std::int32_t low_ms, std::int32_t high_ms) {
    const std::int32_t took = charger.until_phase(ChargePhase::kStopped, 2 * kHour);
    CHECK(took >= low_ms && took <= high_ms);
    expect(ChargePhase::kStopped, why);
    CHECK(charger.until([](const Output& o) { return all_open(o); }, 200) >= 0);
  }
};

// BMS-051, BMS-053
TEST(ChargeInput, ItLooksAtEverythingItselfWhateverTheFaultsSay) {
  charger.charge();
  charger.run(1'000);
  const State charges = bench.state;
  const auto ends = [&](ChargeReason why, const auto& change) {
    bench.state = charges;
    change(bench.state);
    run_alone(false);
    expect(ChargePhase::kStopped, why);
    CHECK(bench.state.charge.asked == Current{} && bench.state.charge.at_once);
    CHECK_FALSE(bench.state.charge.wants_contactors);
  };
  ends(ChargeReason::kFault, [](State& s) { s.faults.open = true; });
  ends(ChargeReason::kFault, [](State& s) { s.faults.bits = bit_of(can::BmsFault::kForeignFrames); });
  ends(ChargeReason::kShutdownCircuit, [](State& s) { s.measured.io.quality = Quality::kStale; });
  ends(ChargeReason::kRequestReleased, [](State& s) { s.measured.master.quality = Quality::kStale; });
  ends(ChargeReason::kChargerSilent, [](State& s) { s.measured.charger.quality = Quality::kStale; });
  ends(ChargeReason::kContactorsOpened, [](State& s) { s.contactors.state = can::BmsState::kOpen; });
  ends(ChargeReason::kMeasurementLost, [](State& s) { s.measured.current.quality = Quality::kStale; });
  bench.state = charges;
  run_alone(false);
  expect(ChargePhase::kCharging, ChargeReason::kNone);
}

TEST(ChargeInput, WaitsForASensor) {
  charger.run(3'000);
  bench.invalid_sensors.insert(2);
  expect_waiting(ChargeReason::kMeasurementLost);
}
TEST(ChargeInput, WaitsForTheCurrent) {
  charger.run(3'000);
  bench.pack.pack_current_ok = false;
  expect_waiting(ChargeReason::kMeasurementLost);
}
TEST(ChargeInput, WaitsForTheSensorsOffset) {
  Bench plain(charge_config());
  plain.charger_talks = plain.io.charge_switch = true;
  plain.current(amps(9));  // nothing flows
  plain.run(3'000);
  CHECK(plain.out.state == can::BmsState::kInvalid && plain.out.waits_for == can::WaitsFor::kCurrentOffset);
  CHECK(plain.state.pack.complete_once && plain.state.measured.charger.good());
  CHECK(plain.out.charge.reason == ChargeReason::kMeasurementLost);
}
TEST(ChargeInput, WaitsForCoolerCells) {
  for (auto& t : bench.temperature_dc) t = 550;
  charger.run(3'000);
  expect_waiting(ChargeReason::kTemperature);
  for (std::int32_t c = 550; c >= 545; --c) {
    for (auto& t : bench.temperature_dc) t = c;
    charger.run(1'000);
  }
  CHECK(charger.until_phase(ChargePhase::kCharging, 10'000) >= 0);
}

// BMS-004
TEST(ChargeInput, ASecondSenderOfAnyMessageEndsIt) {
  charger.charge();
  bench.again = [](Frame& f) {
    if (f.id != can::InverterStatus::kId) return false;  // that opens no contactor
    f.data[0] ^= 0x55U;
    codec::seal(f, static_cast<std::uint8_t>(codec::counter_of(f) + 40));
    return true;
  };
  expect_ended(ChargeReason::kFault, 0, 200);
  CHECK(has(bench.out, can::BmsFault::kForeignFrames));
}

// BMS-020
TEST(ChargeInput, LostNewsOfTheSwitchEndsItAtItsTimeout) {
  charger.charge();
  bench.silent.insert(can::VehicleIo::kId);
  const std::int32_t took = charger.until([](const Output& o) { return o.charge.asked == Current{}; }, 1'000);
  expect_time("BMS-020 in a charge", took, 90, 100);
  CHECK(bench.out.charge.at_once && all_open(bench.out));
  expect(ChargePhase::kStopped, ChargeReason::kFault);
}

// BMS-053
TEST(ChargeInput, EveryFaultOfTheChargerAndEachOfItsReasonsNotToBeConnectedEndsIt) {
  for (bool can::ChargerStatus::* const fault :
       {&can::ChargerStatus::hardware_failure, &can::ChargerStatus::over_temperature,
        &can::ChargerStatus::input_voltage_wrong, &can::ChargerStatus::battery_not_connected,
        &can::ChargerStatus::communication_timeout}) {
    ChargeBench own;
    own.charge();
    own.bench.charger.*fault = true;
    const bool connected = fault != &can::ChargerStatus::battery_not_connected &&
                           fault != &can::ChargerStatus::communication_timeout;
    const std::int32_t took = own.until_phase(ChargePhase::kStopped, 20'000);
    CHECK(connected ? took >= 0 && took <= 1'010 : took >= 5'000 && took <= 6'010);
    CHECK(own.reason() == (connected ? ChargeReason::kChargerFault : ChargeReason::kChargerNotConnected));
  }
}

// BMS-056: since it has gone, wherever in the ten minutes of its gain that was.
TEST(ChargeInput, ACurrentThatStaysAwayForTenMinutesEndsIt) {
  charger.charge();
  charger.run(300'000);
  charger.gives_at_most_a = 0.0;
  expect_ended(ChargeReason::kNoCurrent, 600'000, 600'020);
}

// BMS-056
TEST(ChargeInput, CellsThatAreTooHotToBeBledForAnHourEndIt) {
  ChargeBench hot(charge_config(), 0.97);
  hot.cells[2].soc = 0.985;
  hot.charge();
  CHECK(hot.until([](const Output& o) { return o.charge.cells_bled > 0; }, kHour) >= 0);
  for (std::int32_t c = 250; c <= 550; c += 5) {
    for (auto& t : hot.bench.temperature_dc) t = c;
    hot.run(1'000);
  }
  CHECK(hot.until([](const Output& o) { return o.charge.cells_bled == 0; }, 1'000) >= 0);
  const std::int32_t took = hot.until_phase(ChargePhase::kStopped, 2 * kHour);
  CHECK(took >= kHour - 1'000 && took <= kHour + 10);
  CHECK(hot.reason() == ChargeReason::kTemperature);
}

// BMS-056
TEST(ChargeInput, APackThatIsNeverWithoutCurrentIsNotLookedAtAndEndsAfterAnHour) {
  bench.config.balancing_current_max = Current::from_raw(500);
  for (const double amperes : {0.8, -0.8}) {
    ChargeBench own(bench.config, 0.97);
    own.charge();
    CHECK(own.until_phase(ChargePhase::kResting, kHour) >= 0);
    for (auto& cell : own.cells) cell.capacity = 100.0;  // that they stay where they are
    own.flows_besides_a = amperes;
    const std::int32_t took = own.until_phase(ChargePhase::kStopped, 2 * kHour);
    CHECK(took >= kHour - 10 && took <= kHour + 10);
    CHECK(own.reason() == ChargeReason::kCurrentNotAsked);
    CHECK_FALSE(own.bench.out.charge.spread_known);
  }
}

// BMS-056
TEST(ChargeInput, ALookThatIsNeverWholeEndsItAfterAnHour) {
  ChargeBench own(charge_config(), 0.97);
  own.charge();
  CHECK(own.until_phase(ChargePhase::kResting, kHour) >= 0);
  std::int32_t t = 0;
  for (; own.phase() == ChargePhase::kResting && t < 2 * kHour; t += 10) {
    own.flows_besides_a = t % 500 == 0 ? 0.999 + 0.002 : 0.0;  // 32 readings take longer
    own.tick();
  }
  CHECK(t >= kHour - 10 && t <= kHour + 10);
  CHECK(own.phase() == ChargePhase::kStopped);
  CHECK(own.reason() == ChargeReason::kMeasurementLost);
}

// BMS-052
TEST(ChargeInput, WithoutAResistanceTheHoldStandsAndWithOneItGoesOn) {
  charger.charge();
  const std::int32_t before = bench.state.charge.hold_ua;
  const State charges = bench.state;
  CHECK(before > 0 && before < 20'000'000);
  for (const std::int32_t uohm : {-1, 0, 2'000}) {
    bench.state = charges;
    bench.state.charge.steered = bench.now() + Duration::from_ms(-100);
    bench.state.cell_resistance = Resistance::from_raw(uohm);
    run_alone(true);
    CHECK_EQUAL(uohm > 0, bench.state.charge.hold_ua > before);
    if (uohm <= 0) LONGS_EQUAL(before, bench.state.charge.hold_ua);
  }
}

// BMS-056: what stops the charger is told at once, though the charge ends in the same step.
TEST(ChargeInput, ACurrentThatFallsToNothingInTheStepInWhichItEndsIsToldAtOnce) {
  charger.charge();
  charger.run(700'000);
  bench.state.charge.progress.gained = 0;
  bench.state.charge.progress.since = bench.now() + Duration::from_ms(-600'000);
  bench.state.limits.charge = Limit{};
  run_alone(true);
  expect(ChargePhase::kStopped, ChargeReason::kLimit);
  CHECK(bench.state.charge.at_once && bench.state.charge.asked == Current{});
}

// BMS-055: the step that begins the look anew is none of it.
TEST(ChargeInput, AReadingUnderCurrentIsNoPartOfALook) {
  charger.charge();
  charger.run(1'000);
  Charge& charge = bench.state.charge;
  charge.phase = ChargePhase::kResting;
  charge.asked = Current{};
  charge.entered = bench.now() + Duration::from_ms(-30'000);
  bench.state.measured.arrived = 0xFF;
  for (const std::int32_t ma : {1'001, 1'000, -1'001, -1'000}) {
    bench.state.look.samples[3] = 5;
    bench.state.measured.current.value = Current::from_raw(ma);
    run_alone(false);
    LONGS_EQUAL(std::abs(ma) > 1'000 ? 0 : 6, bench.state.look.samples[3]);
  }
}

// BMS-052: what was bled down to where none may be bled is charged again, and bled again, before anything is given up.
TEST(ChargeInput, CellsThatHaveComeDownToTheirFloorAreChargedAgain) {
  ChargeBench own(bench.config, 0.955);
  own.bench.config.balancing_voltage_min = CellVoltage::from_raw(41'750);
  own.cells[2].soc = 0.985;
  own.charge();
  CHECK(own.until_phase(ChargePhase::kBleeding, kHour) >= 0);
  const double before = own.cells[0].soc;
  CHECK(own.until_phase(ChargePhase::kCharging, 6 * kHour) >= 0);
  DOUBLES_EQUAL(4.175, 3.0 + 1.2 * own.cells[2].soc, 0.001);
  CHECK(own.bench.out.charge.spread > own.bench.config.balancing_difference);
  CHECK(own.until_phase(ChargePhase::kResting, kHour) >= 0);
  CHECK(own.cells[0].soc > before + 0.01);
  CHECK(own.until_phase(ChargePhase::kBleeding, 60'000) >= 0);
  CHECK(own.highest_v < 4.2);
}

// SPDX-License-Identifier: Apache-2.0
#include "bms/current_check.hpp"

#include "driven_bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;
using can::BmsFault;
using can::BmsState;
using can::SuspectWhy;
using can::WaitsFor;

TEST_GROUP(CurrentCheck) {
  DrivenBench car;
};

// BMS-068
TEST(CurrentCheck, OffsetOfTwoAmperesIsLearnedAndTakenOff) {
  car.sensor = [](double a) { return a + 2.0; };
  car.tick(0.0);
  CHECK(car.bench.out.waits_for != WaitsFor::kNone);
  const auto idle = [](const Output& o) { return o.state == BmsState::kIdle; };
  expect_time("BMS-068", car.bench.until(idle, 5000), 100, 300);
  LONGS_EQUAL(2'000, car.bench.out.current_offset.raw());
  car.drive();
  car.run(1.0, 50.0);
  LONGS_EQUAL(50'000, car.bench.state.measured.current.value.raw());
}

// BMS-068, BMS-035
TEST(CurrentCheck, OffsetBeyondFiveAmperesClosesNothingAndSaysWhy) {
  for (const double offset : {5.001, -5.001, 200.0}) {
    DrivenBench wrong;
    wrong.sensor = [=](double a) { return a + offset; };
    wrong.tick(0.0);
    expect_time("BMS-068 too large", wrong.bench.until(sees(BmsFault::kCurrentImplausible), 5000), 980, 1010);
    CHECK(wrong.bench.out.state == BmsState::kInvalid);
    CHECK(wrong.bench.out.waits_for == WaitsFor::kCurrentOffset);
    CHECK(wrong.bench.out.suspect_why == SuspectWhy::kOffset);
  }
  DrivenBench just;
  just.sensor = [](double a) { return a + 4.999; };
  just.tick(0.0);
  LONGS_EQUAL(-1, just.bench.until(sees(BmsFault::kCurrentImplausible), 3000));
  CHECK(just.bench.out.state == BmsState::kIdle);
}

// BMS-068
TEST(CurrentCheck, NothingIsLearnedWhileAContactSaysClosed) {
  car.drive();
  car.run(20.0, 3.0);
  LONGS_EQUAL(0, car.bench.out.current_offset.raw());
}

// BMS-066
TEST(CurrentCheck, ShuntTheWrongWayRoundIsFound) {
  car.sensor = [](double a) { return -a; };
  car.drive();
  car.scale = 0.5;
  expect_time("BMS-066 reversed", car.lap_until(sees(BmsFault::kCurrentImplausible)), 1000, 2500);
  CHECK(car.bench.out.suspect_why == SuspectWhy::kReversed);
}

// BMS-066
TEST(CurrentCheck, FrozenCurrentIsFoundByTheVoltageThatMoves) {
  car.drive();
  LONGS_EQUAL(-1, car.lap_until([](const Output& o) { return o.faults != 0; }, 20.0));
  car.sensor = [](double) { return 60.0; };
  expect_time("BMS-066 frozen", car.lap_until(sees(BmsFault::kCurrentImplausible), 120.0), 1000, 30'000);
  CHECK(car.bench.out.suspect_why == SuspectWhy::kCurrentFrozen);
}

// BMS-066
TEST(CurrentCheck, ResistanceThatIsConfiguredHalfOrTwiceAsLargeAccusesNoSensor) {
  for (const std::int32_t uohm : {1'000, 4'000}) {
    Config config = pack_config();
    for (Resistance& r : config.resistance.resistance) r = Resistance::from_raw(uohm);
    DrivenBench other(config);
    other.drive();
    LONGS_EQUAL(-1, other.lap_until([](const Output& o) { return o.faults != 0; }, 100.0));
  }
}

// BMS-066: voltage and current fall together, for the charge goes and the limit with it.
TEST(CurrentCheck, PackThatRunsEmptyAccusesNoSensor) {
  for (const double falls_a_per_s : {0.0, 2.0, 5.0}) {
    DrivenBench empty(pack_config(), 0.95);
    for (auto& cell : empty.cells) cell.capacity = 0.05;  // 67 mV/s at 100 A, as the end of a curve
    empty.drive();
    for (int i = 0; i < 1300; ++i) {
      CHECK_FALSE(has(empty.tick(100.0 - 0.01 * i * falls_a_per_s), BmsFault::kCurrentImplausible));
    }
  }
}

namespace {

/// At 300 A of phase current and 2000 rpm of 0.15 Nm/A: 9.4 kW on the shaft, 105 A of 90 V, and losses.
void turn_motor(DrivenBench& car, double phase_a) {
  car.bench.inverter.motor_speed_rpm = 2'000;
  car.bench.inverter.phase_current_ma = static_cast<std::int32_t>(1000.0 * phase_a);
}

Config with_motor() {
  Config config = pack_config();
  config.motor_constant_unm_per_a = 150'000;
  return config;
}

}  // namespace

// BMS-067
TEST(CurrentCheck, CurrentOfHalfTheTruthContradictsTheInvertersPower) {
  DrivenBench half(with_motor());
  half.sensor = [](double a) { return 0.45 * a; };
  half.drive();
  turn_motor(half, 300.0);
  for (int i = 0; i < 200 && !has(half.bench.out, BmsFault::kCurrentImplausible); ++i) half.tick(115.0);
  CHECK(has(half.bench.out, BmsFault::kCurrentImplausible));
  CHECK(half.bench.out.suspect_why == SuspectWhy::kPower);
}

// BMS-067
TEST(CurrentCheck, LossesAndTheLowVoltageLoadAreNoContradiction) {
  for (const double amperes : {80.0, 105.0, 150.0, 200.0}) {
    DrivenBench sound(with_motor());
    sound.drive();
    turn_motor(sound, 300.0);
    for (int i = 0; i < 500; ++i) CHECK_FALSE(has(sound.tick(amperes), BmsFault::kCurrentImplausible));
  }
}

// SPDX-License-Identifier: Apache-2.0
#include "bms/current_check.hpp"

#include <algorithm>
#include <cmath>
#include <random>

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

// BMS-068
TEST(CurrentCheck, NothingIsLearnedFromPowerOnWhileAnyContactSaysClosed) {
  for (bool can::VehicleIo::* const contact :
       {&can::VehicleIo::air_plus_aux, &can::VehicleIo::air_minus_aux, &can::VehicleIo::precharge_aux}) {
    DrivenBench welded;
    welded.sensor = [](double a) { return a + 3.0; };
    welded.bench.aux_follow_command = false;
    welded.bench.io.*contact = true;
    welded.run(2.0, 0.0);
    CHECK_FALSE(welded.bench.out.current_offset_known);
    LONGS_EQUAL(0, welded.bench.out.current_offset.raw());
  }
}

// BMS-068: a mean over 10 s, and after minutes the offset itself.
TEST(CurrentCheck, AnOffsetThatDriftsAtRestIsFollowedToItsEnd) {
  for (const double amperes : {2.0, -2.0}) {
    DrivenBench drifts;
    drifts.run(1.0, 0.0);
    LONGS_EQUAL(0, drifts.bench.out.current_offset.raw());
    drifts.sensor = [=](double a) { return a + amperes; };
    drifts.run(10.0, 0.0);
    DOUBLES_EQUAL(1e3 * amperes * -std::expm1(-1.0), drifts.bench.out.current_offset.raw(), 20.0);
    drifts.run(120.0, 0.0);
    DOUBLES_EQUAL(1e3 * amperes, drifts.bench.out.current_offset.raw(), 1.0);
  }
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

namespace {

/// Told within three seconds of a steady current.
bool accused(DrivenBench& car, double amperes) {
  for (int i = 0; i < 300; ++i) {
    if (has(car.tick(amperes), BmsFault::kCurrentImplausible)) return true;
  }
  return false;
}

}  // namespace

// BMS-067
TEST(CurrentCheck, ACurrentOfThreeTimesTheTruthContradictsTheInvertersPower) {
  DrivenBench triple(with_motor());
  triple.sensor = [](double a) { return 3.0 * a; };
  triple.drive();
  turn_motor(triple, 300.0);
  CHECK(accused(triple, 115.0));
  CHECK(triple.bench.out.suspect_why == SuspectWhy::kPower);
}

// BMS-067
TEST(CurrentCheck, WithoutAnyOfItsReadingsThePowerIsNotJudged) {
  for (bool can::InverterStatus::* const known :
       {&can::InverterStatus::phase_current_ok, &can::InverterStatus::motor_speed_ok,
        &can::InverterStatus::dc_link_voltage_ok}) {
    DrivenBench half(with_motor());
    half.sensor = [](double a) { return 0.45 * a; };
    half.drive();
    half.bench.inverter.*known = false;
    turn_motor(half, 300.0);
    CHECK_FALSE(accused(half, 115.0));
    half.bench.inverter.*known = true;
    CHECK(accused(half, 115.0));
  }
}

// BMS-067: above 60 % of the DC link in induced voltage, 53 V and 3390 rpm, the field is weakened, either way round.
TEST(CurrentCheck, ThePowerIsJudgedBelowFieldWeakeningInEitherDirection) {
  for (const std::int32_t rpm : {3'200, -3'200, 3'600, -3'600}) {
    DrivenBench half(with_motor());
    half.sensor = [](double a) { return 0.45 * a; };
    half.drive();
    turn_motor(half, rpm > 0 ? 300.0 : -300.0);
    half.bench.inverter.motor_speed_rpm = rpm;
    CHECK_EQUAL(std::abs(rpm) < 3'390, accused(half, 195.0));
  }
}

namespace {

/// How much more the voltage moves than 8 times what the resistance explains of it, as a share; above zero: frozen.
double twin_of_frozen(const Covariance& c, double table_uohm, double cells) {
  const double per_ma = 1e-5 * table_uohm * cells * 8.0;  // 0.1 mV
  const double explained = static_cast<double>(c.xx) * per_ma * per_ma / 256.0;
  const double least = 200.0 * 200.0 * cells * cells / 256.0;
  const double zz = static_cast<double>(c.zz);
  return std::min(zz / (explained + 1.0), zz / least) - 1.0;
}

}  // namespace

// BMS-066: with drawn numbers up to the largest; a pack of more than 2 ohm is not judged.
TEST(CurrentCheck, AFrozenCurrentIsThatOfItsTwinInDoublePrecision) {
  std::mt19937_64 random(5);
  const auto drawn = [&](double most) {
    return static_cast<std::int64_t>(std::exp(std::uniform_real_distribution(0.0, std::log(most))(random)));
  };
  int frozen = 0, wide = 0;
  for (int draw = 0; draw < 50'000; ++draw) {
    Config config = pack_config();
    config.cells_in_series = static_cast<std::uint16_t>(1 + draw % kMaxCells);
    State s;
    s.cell_resistance = Resistance::from_raw(static_cast<std::int32_t>(drawn(2e9)));
    s.measured.current.quality = s.measured.pack_voltage.quality = Quality::kGood;
    s.current_check.begun = true;
    s.current_check.answer.xx = drawn(4e12);
    s.current_check.answer.zz = drawn(3e11);
    check_current(config, Instant{}, Duration{}, s);  // without time nothing is forgotten and nothing learned
    const double table = s.cell_resistance.raw(), cells = config.cells_in_series;
    wide += table * cells > 2.5e6 ? 1 : 0;
    if (table * cells > 2.5e6 + 1e3) CHECK_FALSE(s.current_check.frozen);
    const double apart = twin_of_frozen(s.current_check.answer, table, cells);
    const double xx = static_cast<double>(s.current_check.answer.xx);
    const double unsure = 0.02 + 3e3 / (table * cells * 8.0 + 1.0) + 200.0 / xx;
    if (table * cells > 2.5e6 - 1e3 || std::abs(apart) < 3.0 * unsure) continue;
    CHECK_EQUAL(apart > 0.0, s.current_check.frozen);
    frozen += apart > 0.0 ? 1 : 0;
  }
  CHECK(frozen > 500 && wide > 500);
}

// SPDX-License-Identifier: Apache-2.0
#include "race/race_account.hpp"

#include <algorithm>
#include <random>
#include <stdexcept>
#include <string>

#include "ecu_words.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

TEST_GROUP(RaceAccount) {
  EcuWords bus;
  Car& car = bus.car;
  EnduranceResult result;
  RaceAccount account{result, car};
};

TEST(RaceAccount, AnExtremeKeepsTheTimeWhenItFirstCame) {
  car.vehicle().set_speed(10.0);
  account.note_step(car, 1.0);
  account.note_step(car, 2.0);
  car.vehicle().set_speed(5.0);
  account.note_step(car, 3.0);
  DOUBLES_EQUAL(10.0, result.max_speed_mps, 0.0);
  DOUBLES_EQUAL(1.0, result.extreme_times.speed_s, 0.0);
  DOUBLES_EQUAL(car.pack().voltage(), result.min_pack_voltage_v, 0.0);
  LONGS_EQUAL(1, result.min_cell);
}

TEST(RaceAccount, ALimitIsActiveForTheTicksInWhichItBound) {
  account.open(car);
  account.note_tick(car, bus.ecus, 2, 0.01, 0.01);
  account.note_tick(car, bus.ecus, 0, 0.02, 0.01);
  account.note_tick(car, bus.ecus, 2, 0.03, 0.01);
  DOUBLES_EQUAL(0.02, result.limit_active_s[2], 1e-12);
  DOUBLES_EQUAL(0.0, result.limit_active_s[0], 0.0);
}

TEST(RaceAccount, MoreThanWasAllowedInTheLastTenthOfASecondIsCounted) {
  account.open(car);
  const auto tick = [&](double allowed_a) {
    can::BmsLimits limits;
    limits.discharge_limit_ok = true;
    limits.discharge_limit_ma = static_cast<std::int32_t>(1e3 * allowed_a);
    bus.say(limits);
    account.note_tick(car, bus.ecus, 0, 0.01, 0.01);
    return result.beyond.over_discharge_s;
  };
  car.contactors.air_minus.command(true);
  car.contactors.air_plus.command(true);
  for (int t = 0; t < 10; ++t) car.renew(0.1);
  car.step(0.0);
  const double flows_a = car.pack_current_a();  // into the empty DC link
  CHECK(flows_a > 10.0);
  DOUBLES_EQUAL(0.0, tick(flows_a), 0.0);
  for (int t = 0; t < 9; ++t) DOUBLES_EQUAL(0.0, tick(0.5 * flows_a), 0.0);  // the old limit is 90 ms old
  DOUBLES_EQUAL(0.01, tick(0.5 * flows_a), 1e-12);
  DOUBLES_EQUAL(1.0, result.beyond.over_discharge_share, 1e-3);
  DOUBLES_EQUAL(0.5 * flows_a, result.beyond.over_discharge_a, 0.01 * flows_a);
}

TEST(RaceAccount, EachFallOfTheLinkBelowTheInverterCountsOnceAndOpenContactorsNot) {
  account.open(car);
  account.note_step(car, 0.001);  // an empty link behind open contactors
  LONGS_EQUAL(0, result.beyond.link_falls);
  car.contactors.air_minus.command(true);
  car.contactors.air_plus.command(true);
  for (int t = 0; t < 10; ++t) car.renew(0.1);
  CHECK(car.dc_link_voltage() < car.parameters().inverter.dc_voltage_min_v);
  for (int t = 2; t < 5; ++t) account.note_step(car, 1e-3 * t);
  LONGS_EQUAL(1, result.beyond.link_falls);
}

TEST(RaceAccount, TimeBelowTheLeastVoltageIsCounted) {
  account.open(car);
  account.note_tick(car, bus.ecus, 0, 0.01, 0.01);
  DOUBLES_EQUAL(0.0, result.beyond.cell_low_s, 0.0);
  VehicleParameters strict = vtm16e();
  strict.bms.cell_voltage_min_v = 5.0;
  const Car low(strict, true, 0.001);
  account.note_tick(low, bus.ecus, 0, 0.02, 0.01);
  DOUBLES_EQUAL(0.01, result.beyond.cell_low_s, 1e-12);
}

TEST(RaceAccount, TheBmssSocCountsOnceItHasOne) {
  account.open(car);
  can::BmsStatus status;
  status.soc_ppm = 900'000;
  bus.say(status);
  account.note_tick(car, bus.ecus, 0, 0.01, 0.01);
  DOUBLES_EQUAL(0.0, result.bms_soc_error_pct, 0.0);
  status.soc_ok = true;
  bus.say(status);
  account.note_tick(car, bus.ecus, 0, 0.02, 0.01);
  DOUBLES_EQUAL(100.0 * (car.pack().soc_mean() - 0.9), result.bms_soc_error_pct, 1e-9);
}

TEST(RaceAccount, ALapIsWrittenDownOnceWithItsOwnTime) {
  account.open(car);
  account.close_laps(car, 0, 10.0);
  account.close_laps(car, 1, 80.0);
  account.close_laps(car, 1, 80.01);
  account.close_laps(car, 2, 155.0);
  LONGS_EQUAL(2, result.lap_rows.size());
  LONGS_EQUAL(2, result.laps);
  DOUBLES_EQUAL(80.0, result.lap_rows[0].time_s, 0.0);
  DOUBLES_EQUAL(75.0, result.lap_rows[1].time_s, 0.0);
  DOUBLES_EQUAL(155.0, account.lap_start_s(), 0.0);
}

TEST(RaceAccount, ACarThatNeverDroveShowsTheStateItIsIn) {
  account.close(car);
  DOUBLES_EQUAL(car.pack().voltage(), result.min_pack_voltage_v, 0.0);
  DOUBLES_EQUAL(car.pack().temperature_max_c(), result.max_battery_temp_c, 0.0);
  DOUBLES_EQUAL(100.0, result.end_soc_pct, 1e-9);
}

TEST(RaceAccount, BooksThatAreNotOpenTakeNoLap) {
  CHECK_THROWS(std::logic_error, account.close_laps(car, 1, 80.0));
  CHECK_THROWS(std::logic_error, account.note_tick(car, bus.ecus, 0, 0.01, 0.01));
}

TEST(RaceAccount, MeanOf500MsIsTheEnergyOfItsWindowAndNeverAboveThePeak) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const std::string words = "seed " + std::to_string(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> power_w(-20e3, 80e3);
    MovingPower moving;
    std::vector<double> powers;
    double energy_j = 1e6, peak_w = 0.0;
    moving.open(energy_j);
    for (int tick = 0; tick < 300; ++tick) {
      powers.push_back(power_w(random));
      peak_w = std::max(peak_w, powers.back());
      energy_j += 0.01 * powers.back();
      const double mean_w = moving.advance(energy_j);
      double sum_w = 0.0;
      for (std::size_t i = powers.size() > 50 ? powers.size() - 50 : 0; i < powers.size(); ++i) sum_w += powers[i];
      DOUBLES_EQUAL_TEXT(sum_w / 50.0, mean_w, 1e-3, words.c_str());
      CHECK_TRUE_TEXT(mean_w <= peak_w + 1e-6, words.c_str());
    }
  }
}

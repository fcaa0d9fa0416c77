// SPDX-License-Identifier: Apache-2.0
#include "master/drive_power.hpp"

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "CppUTest/TestHarness.h"
#include "firmware/master/bench.hpp"
#include "master/arbitration.hpp"

using namespace voltlap;
using namespace voltlap::master;

namespace {

/// A drive whose losses the controller does not know: what is asked for flows a step later, and is measured then.
struct Drive {
  Config config{};
  Input in = bench::healthy(config);
  ArbitrationState state{};
  std::int64_t volts = 400, auxiliary_w = 0;
  std::int64_t stage_w = 400;             // lost at any current
  std::int64_t winding_mohm = 20;
  double gain = 1.0;                      // of the torque's constant, as the controller believes it
  double speed_rpm = 3'000.0, gains_rpm_per_s = 0.0, noise = 0.0;
  std::mt19937 random{1};
  double power_w = 0.0, sum_ms_above = 0.0;

  Drive() {
    config.motor_constant_unm_per_a = 750'000;
    in.pack_voltage.value = PackVoltage::from_raw(static_cast<std::int32_t>(volts * 10'000));
    in.discharge_limit.value = Current::from_raw(900'000);
    for (Sample<Speed>& wheel : in.wheel_speed) wheel.value = Speed::from_raw(20'000);
  }
  double truth_w(double amperes) const {
    const double shaft = gain * 0.75 * amperes * speed_rpm * 0.104720;
    const double winding = 1e-3 * static_cast<double>(winding_mohm) * amperes * amperes;
    return shaft + static_cast<double>(stage_w + auxiliary_w) + winding;
  }
  void tick(std::int32_t request_ma = 550'000) {
    const double flows = state.current.raw() * 1e-3;
    power_w = truth_w(flows);
    std::normal_distribution<double> error(1.0, noise > 0.0 ? noise : 1e-12);
    in.now = Instant::from_ms(static_cast<std::uint32_t>(in.now.ms() + 10));
    bench::touch_all(in);
    in.phase_current = bench::good(state.current, in.now);
    in.motor_speed.value = MotorSpeed::from_raw(static_cast<std::int32_t>(speed_rpm));
    in.pack_current.value =
        Current::from_raw(static_cast<std::int32_t>(1e3 * power_w * error(random) / static_cast<double>(volts)));
    arbitration_step(config, in, Current::from_raw(request_ma), Duration::from_ms(10), state);
    speed_rpm = std::clamp(speed_rpm + 0.01 * gains_rpm_per_s, 0.0, 5'500.0);
  }
  /// Mean power [W] over the last half second of `ms`.
  double settle(int ms) {
    double sum = 0.0;
    for (int t = 0; t < ms; t += 10) {
      tick();
      if (t >= ms - 500) sum += power_w;
    }
    return sum / 50.0;
  }
};

unsigned drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given == nullptr ? std::random_device{}() : static_cast<unsigned>(std::stoul(given));
}

}  // namespace

TEST_GROUP(DrivePower) { Drive drive; };

// MST-032
TEST(DrivePower, FullLimitIsUsedWhateverTheLosses) {
  const unsigned seed = drawn_seed();
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int k = 0; k < 200; ++k) {
    Drive d;
    d.random.seed(seed + static_cast<unsigned>(k));
    d.winding_mohm = static_cast<std::int64_t>(between(0.0, 60.0));
    d.stage_w = static_cast<std::int64_t>(between(0.0, 3'000.0));
    d.auxiliary_w = static_cast<std::int64_t>(between(0.0, 1'500.0));
    d.speed_rpm = between(2'200.0, 5'400.0);
    d.noise = between(0.0, 0.005);
    const double mean_kw = 1e-3 * d.settle(4'000);
    const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(seed) + ", drive " + std::to_string(k) + ": " +
                             std::to_string(mean_kw) + " kW";
    CHECK_TEXT(mean_kw > 78.0 && mean_kw < 79.5, what.c_str());
    CHECK_TEXT(d.state.reason == TorqueReason::kPower, what.c_str());
  }
}

// MST-032, MST-037: through slip, a fall of the losses' share, a change of speed: never 100 ms above 80 kW, nor 500 ms
// on the mean.
TEST(DrivePower, NoWindowOfTheRuleIsBroken) {
  const unsigned seed = drawn_seed();
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int k = 0; k < 100; ++k) {
    Drive d;
    d.winding_mohm = static_cast<std::int64_t>(between(0.0, 80.0));
    d.speed_rpm = between(500.0, 5'000.0);
    double sum = 0.0;
    std::vector<double> window(50, 0.0);
    int above = 0;
    for (int step = 0; step < 2'000; ++step) {
      if (step % 40 == 0) d.gains_rpm_per_s = between(-6'000.0, 6'000.0);
      if (step % 300 == 0) d.winding_mohm = static_cast<std::int64_t>(between(0.0, 80.0));
      d.tick(step % 100 < 85 ? 550'000 : 0);
      sum += d.power_w - window[step % 50];
      window[step % 50] = d.power_w;
      above = d.power_w > 80e3 ? above + 1 : 0;
      const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(seed) + ", drive " + std::to_string(k) +
                               ", step " + std::to_string(step) + ": " + std::to_string(d.power_w);
      CHECK_TEXT(above < 10, what.c_str());
      CHECK_TEXT(sum < 50 * 80e3, what.c_str());
    }
  }
}

// MST-032: an efficiency above one is a wrong constant or sensor; what is not measured is the low estimate.
TEST(DrivePower, MoreThanTheWholeIsNotBelieved) {
  drive.gain = 0.7;  // 30 % less torque than the constant says
  drive.settle(2'000);
  LONGS_EQUAL(1'000'000, drive.state.power.efficiency.raw());
  for (Quality* quality : {&drive.in.pack_current.quality, &drive.in.pack_voltage.quality}) {
    *quality = Quality::kInvalid;
    LONGS_EQUAL(900'000, drive_efficiency(drive.config, drive.in, drive.state.power).raw());
    *quality = Quality::kGood;
    LONGS_EQUAL(1'000'000, drive_efficiency(drive.config, drive.in, drive.state.power).raw());
  }
  drive.in.pack_current.quality = Quality::kInvalid;
  LONGS_EQUAL(900'000, drive_efficiency(drive.config, drive.in, DrivePower{}).raw());
  drive.state.power.efficiency = Ratio::from_raw(800'000);
  LONGS_EQUAL(800'000, drive_efficiency(drive.config, drive.in, drive.state.power).raw());
}

// MST-032: where nothing holds the torque nothing is learned: at part load the losses are another share.
TEST(DrivePower, OnlyACeilingTeaches) {
  for (int t = 0; t < 200; ++t) drive.tick(50'000);
  LONGS_EQUAL(0, drive.state.power.efficiency.raw());
  drive.settle(500);
  CHECK(drive.state.power.efficiency.raw() > 900'000);
}

// MST-032
TEST(DrivePower, WhatIsNotOfOneStepOrNotObeyedTeachesNothing) {
  const auto learns = [](const std::function<void(Drive&)>& break_it) {
    Drive d;
    for (int t = 0; t < 100; ++t) d.tick();
    DrivePower probe = d.state.power;
    probe.efficiency = Ratio{};
    break_it(d);
    watch_drive_power(d.config, d.in, d.state.current, true, Duration::from_ms(10), probe);
    return probe.efficiency > Ratio{};
  };
  const auto learns_when_asked = [](const std::function<void(Drive&)>& ask) {
    Drive d;
    for (int t = 0; t < 100; ++t) d.tick();
    ask(d);
    DrivePower probe = d.state.power;
    probe.efficiency = Ratio{};
    probe.asked_before = d.state.current;
    watch_drive_power(d.config, d.in, d.state.current, true, Duration::from_ms(10), probe);
    return probe.efficiency > Ratio{};
  };
  CHECK(learns([](Drive&) {}));
  CHECK_FALSE(learns([](Drive& d) { d.in.pack_current.time = Instant::from_ms(d.in.now.ms() - 10); }));
  CHECK_FALSE(learns([](Drive& d) { d.in.pack_voltage.time = Instant::from_ms(d.in.now.ms() - 10); }));
  CHECK_FALSE(learns([](Drive& d) { d.in.motor_speed.time = Instant::from_ms(d.in.now.ms() - 10); }));
  CHECK_FALSE(learns([](Drive& d) { d.in.phase_current.time = Instant::from_ms(d.in.now.ms() - 10); }));
  CHECK_FALSE(learns([](Drive& d) { d.in.phase_current.quality = Quality::kStale; }));
  // 95 % of what is asked for, to the milliampere
  const auto obeys_by = [](std::int32_t gives_ma, std::int32_t asked_ma) {
    return [=](Drive& d) {
      d.state.current = Current::from_raw(asked_ma);
      d.in.phase_current.value = Current::from_raw(gives_ma);
    };
  };
  CHECK(learns_when_asked(obeys_by(95'000, 100'000)));
  CHECK(learns_when_asked(obeys_by(-95'000, 100'000)));  // the sign is the sensor's
  CHECK_FALSE(learns_when_asked(obeys_by(94'999, 100'000)));
  CHECK_FALSE(learns([](Drive& d) { d.in.pack_current.value = -d.in.pack_current.value; }));
}

// MST-037
TEST(DrivePower, FiftyMillisecondsAboveTheRuleCutTheCeiling) {
  DrivePower watch;
  Input in = bench::healthy(drive.config);
  in.pack_voltage.value = PackVoltage::from_raw(4'000'000);
  const auto step = [&](std::int32_t pack_ma) {
    in.pack_current.value = Current::from_raw(pack_ma);
    watch_drive_power(drive.config, in, Current{}, false, Duration::from_ms(10), watch);
    return window_share(watch).raw();
  };
  for (int t = 0; t < 50; ++t) LONGS_EQUAL(1'000'000, step(100'000));
  for (int t = 10; t < 50; t += 10) LONGS_EQUAL(1'000'000, step(200'025));  // 80.01 kW
  LONGS_EQUAL(850'000, step(200'025));
  LONGS_EQUAL(850'000, step(200'025));
  LONGS_EQUAL(1'000'000, step(200'000));  // 80 kW are allowed
  LONGS_EQUAL(1'000'000, step(200'025));
}

// MST-037: of what was asked for when it began, for the ceiling may rest on a speed that lies.
TEST(DrivePower, AWindowHoldsWhatWasAskedForAndNotOnlyACeilingFarAboveIt) {
  DrivePower watch;
  Input in = bench::healthy(drive.config);
  in.pack_voltage.value = PackVoltage::from_raw(4'000'000);
  const auto step = [&](std::int32_t pack_ma, std::int32_t asked_ma) {
    in.pack_current.value = Current::from_raw(pack_ma);
    watch_drive_power(drive.config, in, Current::from_raw(asked_ma), false, Duration::from_ms(10), watch);
    return within_windows(Current::from_raw(500'000), watch).raw();
  };
  for (int t = 10; t < 50; t += 10) LONGS_EQUAL(500'000, step(210'000, 200'000));
  LONGS_EQUAL(170'000, step(210'000, 200'000));
  LONGS_EQUAL(170'000, step(210'000, 170'000));  // no less, the longer it lasts
  LONGS_EQUAL(425'000, within_windows(Current::from_raw(500'000), [&] {
                         DrivePower braking = watch;
                         braking.held = Current{};
                         return braking;
                       }()).raw());
  LONGS_EQUAL(100'000 * 85 / 100, within_windows(Current::from_raw(100'000), watch).raw());
  LONGS_EQUAL(500'000, step(190'000, 170'000));
  for (int t = 10; t < 50; t += 10) step(210'000, 180'000);
  LONGS_EQUAL(153'000, step(210'000, 180'000));
  // At the end of the motor's voltage less flows than is asked for, in either sense of the sensor.
  for (const std::int32_t flows : {100'000, -100'000}) {
    step(190'000, 180'000);
    in.phase_current = bench::good(Current::from_raw(flows));
    for (int t = 10; t < 50; t += 10) step(210'000, 180'000);
    LONGS_EQUAL(85'000, step(210'000, 180'000));
  }
  in.phase_current = bench::good(Current::from_raw(300'000));  // and never more
  step(190'000, 180'000);
  for (int t = 10; t < 50; t += 10) step(210'000, 180'000);
  LONGS_EQUAL(153'000, step(210'000, 180'000));
  in.phase_current = {Current::from_raw(100'000), Instant{}, Quality::kInvalid};
  step(190'000, 180'000);
  for (int t = 10; t < 50; t += 10) step(210'000, 180'000);
  LONGS_EQUAL(153'000, step(210'000, 180'000));
  in.phase_current = bench::good(Current{});  // a sensor that says nothing flows knows nothing of it
  step(190'000, 180'000);
  for (int t = 10; t < 50; t += 10) step(210'000, 180'000);
  LONGS_EQUAL(153'000, step(210'000, 180'000));
}

// MST-037
TEST(DrivePower, AMeanOfHalfASecondNearTheRuleLowersTheCeiling) {
  DrivePower watch;
  Input in = bench::healthy(drive.config);
  in.pack_voltage.value = PackVoltage::from_raw(4'000'000);
  const auto step = [&](std::int32_t pack_ma) {
    in.pack_current.value = Current::from_raw(pack_ma);
    watch_drive_power(drive.config, in, Current{}, false, Duration::from_ms(10), watch);
    return window_share(watch).raw();
  };
  for (int t = 0; t < 100; ++t) LONGS_EQUAL(1'000'000, step(199'250));  // 79.7 kW are no more than that
  for (int t = 0; t < 50; ++t) LONGS_EQUAL(1'000'000, step(0));
  for (int t = 0; t < 49; ++t) LONGS_EQUAL(1'000'000, step(199'500));  // 79.8 kW
  LONGS_EQUAL(970'000, step(199'500));
  LONGS_EQUAL(1'000'000, step(0));
  for (int t = 0; t < 100; ++t) LONGS_EQUAL(1'000'000, step(-100'000));  // braking earns nothing
  LONGS_EQUAL(0, static_cast<long>(watch.sum_mw));
}

// MST-032: only gaining speed is foreseen, in both directions of rotation.
TEST(DrivePower, SpeedIsForeseenWhereItGrows) {
  DrivePower watch;
  Input in = bench::healthy(drive.config);
  const auto at = [&](std::int32_t before, std::int32_t now) {
    for (const std::int32_t rpm : {before, (before + now) / 2}) {
      in.motor_speed.value = MotorSpeed::from_raw(rpm);
      watch_drive_power(drive.config, in, Current{}, false, Duration::from_ms(10), watch);
    }
    return speed_ahead(MotorSpeed::from_raw(now), watch).raw();
  };
  LONGS_EQUAL(3'175, at(3'000, 3'100));
  LONGS_EQUAL(3'000, at(3'100, 3'000));
  LONGS_EQUAL(-3'175, at(-3'000, -3'100));
  LONGS_EQUAL(-3'000, at(-3'100, -3'000));
  LONGS_EQUAL(0, at(100, 0));
}

// MST-037
TEST(DrivePower, WhatIsNotMeasuredIsNoPower) {
  for (const bool current : {true, false}) {
    DrivePower watch;
    Input in = bench::healthy(drive.config);
    in.pack_voltage.value = PackVoltage::from_raw(4'000'000);
    in.pack_current.value = Current::from_raw(300'000);
    (current ? in.pack_current.quality : in.pack_voltage.quality) = Quality::kStale;
    for (int t = 0; t < 100; ++t) {
      watch_drive_power(drive.config, in, Current{}, false, Duration::from_ms(10), watch);
      LONGS_EQUAL(1'000'000, window_share(watch).raw());
      LONGS_EQUAL(0, static_cast<long>(watch.sum_mw));
    }
  }
}

namespace {

/// One step of 100 A at a standing ceiling, all that is measured of it in this step.
struct HeldStep {
  Config config{};
  Input in = bench::healthy(config);
  DrivePower watch{};
  HeldStep() {
    in.motor_speed.value = MotorSpeed::from_raw(3'000);
    in.phase_current = bench::good(Current::from_raw(100'000));
    in.pack_voltage.value = PackVoltage::from_raw(1'000'000);
    watch.steady = Duration::from_ms(50);
    watch.asked_before = Current::from_raw(100'000);
  }
  /// The pack's current at which so much of its power arrives at the shaft.
  void arrives(std::int32_t share_ppm) {
    const std::int64_t shaft_uw = std::int64_t{induced_voltage(config, in.motor_speed.value).raw()} * 100'000;
    in.pack_current.value = Current::from_raw(static_cast<std::int32_t>(shaft_uw / share_ppm));
  }
  std::int32_t step(std::int32_t asked_ma = 100'000) {
    watch_drive_power(config, in, Current::from_raw(asked_ma), true, Duration::from_ms(10), watch);
    return watch.efficiency.raw();
  }
};

}  // namespace

// MST-032: 63 % of a change are the time that it takes.
TEST(DrivePower, EfficiencyFallsWithin40MsAndRisesWithin500Ms) {
  HeldStep held;
  held.arrives(900'000);
  CHECK(std::abs(held.step() - 900'000) < 100);  // the first one is taken as it is
  held.arrives(500'000);
  for (int t = 0; t < 4; ++t) held.step();
  CHECK(held.watch.efficiency.raw() < 500'000 + 370 * 400);
  for (int t = 0; t < 40; ++t) held.step();
  CHECK(std::abs(held.watch.efficiency.raw() - 500'000) < 100);
  held.arrives(900'000);
  for (int t = 0; t < 10; ++t) held.step();
  CHECK(held.watch.efficiency.raw() < 500'000 + 200 * 400);  // too high would cost the event
  for (int t = 0; t < 40; ++t) held.step();
  CHECK(held.watch.efficiency.raw() > 500'000 + 630 * 400);
}

// MST-032: a command that moves by more than a fiftieth a step is not measured by.
TEST(DrivePower, SteadyIsWhatMovesByAFiftiethAtMost) {
  for (const std::int32_t before_ma : {98'000, 102'000, 97'999, 102'001}) {
    HeldStep held;
    held.arrives(900'000);
    held.watch.asked_before = Current::from_raw(before_ma);
    CHECK_EQUAL(before_ma == 98'000 || before_ma == 102'000, held.step() > 0);
  }
}

// MST-032: beside a shut battery the car's own consumers would look like the worst of drives.
TEST(DrivePower, WithoutACommandOrWithoutPowerNothingIsLearned) {
  HeldStep idle;
  idle.watch.asked_before = Current{};
  idle.in.phase_current.value = Current{};
  idle.in.pack_current.value = Current::from_raw(10'000);
  for (int t = 0; t < 20; ++t) LONGS_EQUAL(0, idle.step(0));
  HeldStep dead;
  dead.in.pack_current.value = Current{};
  LONGS_EQUAL(0, dead.step());
  dead.in.pack_voltage.value = PackVoltage::from_raw(10'000);
  dead.in.pack_current.value = Current::from_raw(1);  // the least there is: 1 mW
  LONGS_EQUAL(1'000'000, dead.step());
}

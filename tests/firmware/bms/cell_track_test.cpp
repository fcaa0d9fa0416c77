// SPDX-License-Identifier: Apache-2.0
// What is remembered of current, pack and cell from step to step, beside its twin in double precision.
#include <algorithm>
#include <cmath>
#include <random>

#include "bms/cell_check.hpp"
#include "bench.hpp"

using namespace voltlap;
using namespace voltlap::bms;
using namespace voltlap::bms::test;

namespace {

constexpr double kResistanceOhm = 0.002;

void follow(double& mean, double x, double dt_s, double tau_s) { mean += (x - mean) * dt_s / (tau_s + dt_s); }

/// In A and V; the header of cell_check has the times.
struct Twin {
  double lagged = 0, mean = 0, x = 0, pack_lagged = 0, pack_mean = 0, z = 0, all = 0, slow = 0;
  double voltage = 0, pack = 0, level = 0, x_mean = 0, y_mean = 0, z_mean = 0, lagged_mean = 0;
  double xy = 0, xz = 0, x_lagged = 0;
  bool begun = false, read = false;

  void wave(double amperes, double pack_v, double dt_s) {
    if (!begun) {
      lagged = mean = amperes;
      pack_lagged = pack_mean = pack_v;
    }
    begun = true;
    follow(lagged, amperes, dt_s, 0.3);
    follow(mean, lagged, dt_s, 1.6);
    x = lagged - mean;
    follow(pack_lagged, pack_v, dt_s, 0.3);
    follow(pack_mean, pack_lagged, dt_s, 1.6);
    z = pack_lagged - pack_mean;
    follow(all, (amperes - mean) * (amperes - mean), dt_s, 4.0);
    follow(slow, x * x, dt_s, 4.0);
  }
  void cell(double amperes, double pack_v, double volts, double dt_s, bool loaded) {
    if (!read) {
      voltage = volts;
      pack = pack_v;
      level = volts + kResistanceOhm * amperes;
      read = true;
      return;
    }
    const double memory_s = loaded ? 4.0 : 0.2;
    follow(voltage, volts, dt_s, 1.6);
    follow(pack, pack_v, dt_s, 1.6);
    follow(level, volts + kResistanceOhm * amperes, dt_s, loaded ? 10.0 : 0.2);
    const double dx = x - x_mean, y = volts - voltage, all_z = pack_v - pack;
    follow(xy, dx * (y - y_mean), dt_s, memory_s);
    follow(x_lagged, dx * (z - lagged_mean), dt_s, memory_s);
    follow(xz, dx * (all_z - z_mean), dt_s, memory_s);
    follow(x_mean, x, dt_s, memory_s);
    follow(y_mean, y, dt_s, memory_s);
    follow(z_mean, all_z, dt_s, memory_s);
    follow(lagged_mean, z, dt_s, memory_s);
  }
};

State good_state() {
  State s;
  s.cell_resistance = Resistance::from_raw(2'000);
  s.measured.current.quality = s.measured.pack_voltage.quality = s.measured.cell[0].quality = Quality::kGood;
  return s;
}

}  // namespace

TEST_GROUP(CellTrack) {
  Config config = pack_config();
  State s = good_state();
  std::uint32_t now_ms = 5'000;
  std::mt19937 random{21};
  double drawn(double low, double high) { return std::uniform_real_distribution(low, high)(random); }

  /// A reading of current and pack, and of the first group of cells if `read`.
  void step(double amperes, double pack_v, double cell_v, bool read, bool slow = false) {
    Measured& m = s.measured;
    m.current.value = amps(amperes);
    m.pack_voltage.value = PackVoltage::from_raw(static_cast<std::int32_t>(std::lround(1e4 * pack_v)));
    m.cell[0].value = CellVoltage::from_raw(static_cast<std::int32_t>(std::lround(1e4 * cell_v)));
    m.current.time = Instant::from_ms(now_ms);
    m.arrived = read ? 1 : 0;
    m.cell_current[0] = m.current.value;
    m.cell_pack[0] = m.pack_voltage.value;
    check_cells(config, m.current.time, slow, s);
  }
  void expect_like(const Twin& twin) {
    const PackWave& w = s.cell_check.wave;
    DOUBLES_EQUAL(twin.lagged, 1e-3 * w.lagged, 0.5);
    DOUBLES_EQUAL(twin.mean, 1e-3 * w.mean, 0.8);
    DOUBLES_EQUAL(twin.x, 1e-3 * w.x, 0.8);
    DOUBLES_EQUAL(twin.z, 1e-4 * w.z, 0.05);
    DOUBLES_EQUAL(twin.all, 1e-6 * static_cast<double>(w.all), 10.0 + 0.01 * twin.all);
    DOUBLES_EQUAL(twin.slow, 1e-6 * static_cast<double>(w.slow), 10.0 + 0.02 * twin.slow);
    const CellTrack& t = s.cell_check.cell[0];
    if (!twin.read) return;
    DOUBLES_EQUAL(twin.voltage, 1e-4 / 256.0 * t.voltage, 0.002);
    DOUBLES_EQUAL(twin.pack, 1e-4 * t.pack, 0.05);
    DOUBLES_EQUAL(twin.level, 1e-4 / 256.0 * t.level, 0.002);
    DOUBLES_EQUAL(twin.xy, 1e-7 / 256.0 * static_cast<double>(t.xy), 0.2);
    DOUBLES_EQUAL(twin.y_mean, 1e-4 / 256.0 * t.y_mean, 0.002);
    DOUBLES_EQUAL(twin.x_lagged, 1e-7 * static_cast<double>(t.x_lagged), 5.0);
    DOUBLES_EQUAL(twin.lagged_mean, 1e-4 * t.lagged_mean, 0.05);
    DOUBLES_EQUAL(twin.xz, 1e-7 * static_cast<double>(t.pack_answer.xz), 5.0);
    DOUBLES_EQUAL(twin.x_mean, 1e-3 * t.pack_answer.x_mean, 0.8);
  }
};

// BMS-060, BMS-061
TEST(CellTrack, CurrentPackAndCellAreFollowedAsByTheirTwinInDoublePrecision) {
  for (const bool loaded : {true, false}) {
    s = good_state();
    s.contactors.command.air_minus = loaded;
    Twin twin;
    double amperes = 200.0, dt_s = 0.01, since_read_s = 0.0;
    for (int k = 0; k < 800; ++k) {
      if (k % 37 == 0) amperes = drawn(-300.0, 600.0);
      const double cell_v = 3.7 - 0.002 * amperes + drawn(-0.01, 0.01), pack_v = 24.0 * 3.7 - 0.05 * amperes;
      const bool read = k % 3 == 2;
      twin.wave(amperes, pack_v, k == 0 ? 5.0 : dt_s);
      since_read_s += dt_s;
      if (read) {
        twin.cell(amperes, pack_v, cell_v, since_read_s, loaded);
        since_read_s = 0.0;
      }
      step(amperes, pack_v, cell_v, read);
      expect_like(twin);
      dt_s = k % 50 == 49 ? 0.1 : 0.01;  // some steps are late
      now_ms += static_cast<std::uint32_t>(std::lround(1e3 * dt_s));
    }
    CHECK(twin.xy < -10.0 && twin.xz < -200.0);
  }
}

// BMS-060: what one of them has not seen yet, none has.
TEST(CellTrack, ACellIsTakenWithACurrentAndAPackVoltageOfItsStepAlone) {
  const auto taken = [&] { return s.cell_check.cell[0].begun; };
  const State fresh = s;
  s.measured.current.quality = Quality::kStale;
  step(10.0, 88.0, 3.7, true);
  CHECK_FALSE(taken());
  s = fresh;
  s.measured.pack_voltage.quality = Quality::kInvalid;
  step(10.0, 88.0, 3.7, true);
  CHECK_FALSE(taken());
  for (const int age_ms : {1, 10, 2}) {
    s = fresh;
    s.measured.arrived = 1;
    s.measured.current.time = Instant::from_ms(now_ms);
    check_cells(config, Instant::from_ms(now_ms) + Duration::from_ms(age_ms), false, s);
    CHECK_FALSE(taken() || s.cell_check.wave.begun);
  }
  s = fresh;
  s.measured.bled[0] = true;  // BMS-055
  step(10.0, 88.0, 3.7, true);
  CHECK_FALSE(taken());
  s = fresh;
  s.measured.cell[0].quality = Quality::kInvalid;
  step(10.0, 88.0, 3.7, true);
  CHECK_FALSE(taken());
  s = fresh;
  step(10.0, 88.0, 3.7, true);
  CHECK(taken());
}

// SPDX-License-Identifier: Apache-2.0
// Drawn sound packs under a drawn foot: steady, in steps, in ramps and in waves, from full to empty, cold and hot, with
// noise and lags of the sensors and a bus that loses frames. No channel of them is ever accused.
#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "accusations.hpp"
#include "bench.hpp"
#include "drawn.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr int kCars = 150;
constexpr double kDrive_s = 60.0;

class Draw : public Drawn {
 public:
  using Drawn::Drawn;
  int one_of(std::initializer_list<int> values) {
    return *(values.begin() + static_cast<std::ptrdiff_t>(between(0.0, 0.999) * static_cast<double>(values.size())));
  }

  VehicleParameters car() {
    VehicleParameters out = vtm16e();
    const int cells = one_of({6, 12, 24, 24, 48, 96, 144});
    out.battery.cells_in_series = cells;
    out.sensors.temperature_count = (cells + 3) / 4;
    draw_sensors(out.sensors, static_cast<std::size_t>(cells));
    draw_pack(out.battery, static_cast<std::size_t>(cells));
    out.environment.ambient_c = out.battery.initial_temperature_c;
    if (chance(0.5)) out.bms.resistance_ohm = between(0.0012, 0.0048);  // entered wrong by 2 both ways
    if (chance(0.5)) out.master.regen_current_max_a = between(20.0, 200.0);
    return out;
  }

 private:
  void draw_sensors(SensorSection& out, std::size_t cells) {
    out.noise = chance(0.7);
    out.quantisation = chance(0.7);
    out.pack_current.offset = between(-3.0, 3.0);
    out.pack_current.gain = between(0.98, 1.02);
    out.pack_voltage.gain = between(0.99, 1.01);
    out.phase_current.gain = between(0.97, 1.03);
    if (chance(0.5)) {
      out.pack_current.lag_s = between(0.0, 0.05);
      out.pack_voltage.lag_s = between(0.0, 0.05);
      out.all_cells.lag_s = between(0.0, 0.2);
    }
    out.cells.resize(cells);
    for (ChannelErrors& cell : out.cells) cell.offset = between(-0.01, 0.01);
  }
  void draw_pack(BatterySection& out, std::size_t cells) {
    out.cells.resize(cells);
    for (auto& cell : out.cells) {
      cell.capacity_scale = between(0.97, 1.0);
      cell.resistance_scale = between(0.9, 1.1);
    }
    auto& weak = out.cells[static_cast<std::size_t>(between(0.0, static_cast<double>(cells) - 0.1))];
    weak.capacity_scale = 0.85;
    weak.resistance_scale = chance(0.3) ? between(1.4, 3.0) : 1.4;
    if (chance(0.3)) out.cells.front().initial_soc_offset = between(-0.03, 0.0);
    out.initial_soc = chance(0.5) ? between(0.04, 0.3) : between(0.3, 1.0);
    out.initial_temperature_c = chance(0.3) ? between(-10.0, 5.0) : between(0.0, 50.0);
  }

};

/// What the foot does for a while.
class Foot {
 public:
  explicit Foot(std::uint64_t seed) : draw_(seed + 1) {}

  Pedals at(double t_s) {
    if (t_s >= until_s_) begin(t_s);
    const double along = (t_s - from_s_) / (until_s_ - from_s_);
    double pedal = 0.0;
    switch (kind_) {
      case 0: pedal = level_; break;
      case 1: pedal = level_ * (1.0 - along); break;
      case 2: pedal = level_ * along; break;
      case 3: pedal = level_ * (0.5 + 0.5 * std::sin(2.0 * M_PI * t_s / period_s_)); break;
      case 4: pedal = std::fmod(t_s, period_s_) < 0.5 * period_s_ ? level_ : 0.0; break;
      default: return {0.0, level_};
    }
    return {pedal, 0.0};
  }

 private:
  void begin(double t_s) {
    from_s_ = t_s;
    kind_ = draw_.one_of({0, 0, 1, 2, 3, 4, 5});
    until_s_ = t_s + (kind_ == 5 ? draw_.between(0.5, 4.0) : std::exp(draw_.between(std::log(0.5), std::log(40.0))));
    level_ = draw_.chance(0.3) ? 1.0 : draw_.between(0.02, 1.0);
    period_s_ = std::exp(draw_.between(std::log(0.05), std::log(10.0)));
  }

  Draw draw_;
  int kind_ = 0;
  double from_s_ = 0.0, until_s_ = 0.0, level_ = 0.0, period_s_ = 1.0;
};

struct Driven {
  std::string accused;  ///< empty: nothing was
  double seconds = 0.0;
};

std::string described(const VehicleParameters& car) {
  return fmt::format("{} cells, SOC {:.2f}, {:.0f} degC, R {:.4f} ohm, noise {}, lag of cells {:.2f} s",
                     car.battery.cells_in_series, car.battery.initial_soc, car.battery.initial_temperature_c,
                     car.bms.resistance_ohm, car.sensors.noise, car.sensors.all_cells.lag_s);
}

Driven drive_drawn(std::uint64_t of) {
  Draw draw(of);
  const VehicleParameters car = draw.car();
  const double most = car.battery.cells_in_series <= 48 ? 0.05 : 0.02;
  const double lost = draw.chance(0.3) ? 0.0 : most;
  LoopBench bench(car, false, of);
  Suspicion suspicion;
  bench.loop.loses = [&suspicion, loss = RandomLoss(of, lost)](const Frame& frame) mutable {
    suspicion.hear(frame);
    return loss(frame);
  };
  Foot foot(of);
  bench.drive_off(0.0);
  Driven out;
  while (out.seconds < kDrive_s && bench.any_air_closed()) {
    bench.pedals = foot.at(out.seconds);
    bench.tick();
    out.seconds += 0.01;
    if ((bench.commands.bms().faults & kAccuses) == 0) continue;
    out.accused = fmt::format("faults {:#x}, suspect {} because of {} after {:.2f} s, {} of the frames lost, {}",
                              bench.commands.bms().faults, suspicion.index, static_cast<int>(suspicion.why),
                              out.seconds, lost, described(car));
    break;
  }
  return out;
}

}  // namespace

TEST_GROUP(SoundPedals){};

// BMS-022, BMS-026, BMS-060, BMS-061, BMS-062, BMS-066, BMS-067
TEST(SoundPedals, NoChannelOfADrawnPackIsAccused) {
  const std::uint64_t drawn = drawn_seed();
  double seconds = 0.0;
  for (int k = 0; k < kCars; ++k) {
    const std::uint64_t of = drawn + static_cast<std::uint64_t>(k);
    const Driven driven = drive_drawn(of);
    if (!driven.accused.empty()) FAIL(fmt::format("VOLTLAP_TEST_SEED={}: {}", of, driven.accused).c_str());
    seconds += driven.seconds;
  }
  fmt::print("VOLTLAP_TEST_SEED={}: {} sound packs, {:.0f} s driven, none accused\n", drawn, kCars, seconds);
  CHECK(seconds > kCars * 20.0);
}

// Packs that were accused: cold cells that lag, under waves of a second and a half, of a pack voltage that disagrees
// with them (BMS-022); a cell that is read as often as the current is chopped, of a frozen channel (BMS-060).
TEST(SoundPedals, ThePacksThatWereAccusedOnceAreSound) {
  for (const std::uint64_t of : {89927401ULL, 5005070ULL}) {
    const Driven driven = drive_drawn(of);
    if (!driven.accused.empty()) FAIL(fmt::format("VOLTLAP_TEST_SEED={}: {}", of, driven.accused).c_str());
  }
}

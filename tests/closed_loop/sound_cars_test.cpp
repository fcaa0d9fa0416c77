// SPDX-License-Identifier: Apache-2.0
// Drawn sound cars: noise and steps of the sensors, offsets and gains of real harnesses, weak cells, cold and hot, and
// a bus that loses 2 % of its frames. No channel of them is ever accused.
#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "accusations.hpp"
#include "drawn.hpp"
#include "fixtures.hpp"
#include "loop.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr int kStretches = 40;   // of one lap, 60 to 80 s
constexpr int kEndurances = 3;   // of 22 km

class Draw : public Drawn {
 public:
  using Drawn::Drawn;
  VehicleParameters car() {
    VehicleParameters out = vtm16e();
    out.sensors.noise = out.sensors.quantisation = true;
    out.sensors.pack_current.offset = between(-3.0, 3.0);
    out.sensors.pack_current.gain = between(0.98, 1.02);
    out.sensors.pack_voltage.gain = between(0.99, 1.01);
    out.sensors.dc_link_voltage.gain = between(0.98, 1.02);
    out.sensors.phase_current.gain = between(0.97, 1.03);
    out.sensors.cells.resize(24);
    for (ChannelErrors& cell : out.sensors.cells) cell.offset = between(-0.01, 0.01);
    out.sensors.thermistors.resize(6);
    for (ChannelErrors& thermistor : out.sensors.thermistors) thermistor.offset = between(-2.0, 2.0);
    out.battery.cells.resize(24);
    for (auto& cell : out.battery.cells) {
      cell.capacity_scale = between(0.97, 1.0);
      cell.resistance_scale = between(0.9, 1.1);
    }
    auto& weak = out.battery.cells[static_cast<std::size_t>(between(0.0, 23.9))];
    weak.capacity_scale = 0.85;
    weak.resistance_scale = 1.4;
    out.battery.initial_soc = between(0.5, 1.0);
    const double at_c = chance(0.3) ? 0.0 : (chance(0.4) ? 45.0 : between(0.0, 45.0));
    out.battery.initial_temperature_c = out.environment.ambient_c = at_c;
    out.bms.resistance_ohm = chance(0.3) ? 0.0 : between(0.0012, 0.0048);  // entered wrong by 2 both ways
    out.assertions.speed_error_max_mps = 100.0;
    out.assertions.battery_temperature_max_c = 200.0;
    return out;
  }
};

/// Collects what the BMS says of its faults.
struct Faults final : Record {
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override {
    Record::on_frame(tick, sender, frame);
    can::BmsStatus status;
    if (!can::decode(frame, status)) return;
    if ((status.faults & kAccuses) != 0 && bits == 0) at_s = 0.01 * tick;
    bits |= status.faults & kAccuses;
  }
  std::uint32_t bits = 0;
  double at_s = 0.0;
};

struct Driven {
  std::string accused;  ///< empty: nothing was
  double seconds = 0.0;
  bool finished = false;
};

Driven drive_drawn(std::uint64_t of, int laps) {
  Draw draw(of);
  EnduranceOptions options = nominal(laps);
  options.vehicle = draw.car();
  options.representative_cell = false;
  options.seed = of;
  SilenceableLoop loop(options.vehicle);
  loop.loses = RandomLoss(of, 0.02);
  Faults faults;
  const EnduranceResult r = run_endurance(options, loop, faults);
  Driven out{"", r.total_time_s, r.finished};
  if (faults.bits != 0) {
    out.accused = fmt::format("faults {:#x} at {:.2f} s, SOC {:.2f}, {:.0f} degC", faults.bits, faults.at_s,
                              options.vehicle.battery.initial_soc, options.vehicle.environment.ambient_c);
  }
  return out;
}

/// A hot pack ends by its own temperature, an empty one by its charge: `least_s` is what they drive on average.
void none_is_accused(int cars, int laps, double least_s) {
  const std::uint64_t drawn = drawn_seed();
  double seconds = 0.0;
  int finished = 0;
  for (int k = 0; k < cars; ++k) {
    const std::uint64_t of = drawn + static_cast<std::uint64_t>(k);
    const Driven driven = drive_drawn(of, laps);
    if (!driven.accused.empty()) FAIL(fmt::format("VOLTLAP_TEST_SEED={}: {}", of, driven.accused).c_str());
    seconds += driven.seconds;
    finished += driven.finished ? 1 : 0;
  }
  fmt::print("VOLTLAP_TEST_SEED={}: {} sound cars, {} finished, {:.0f} s driven, none accused\n", drawn, cars, finished,
             seconds);
  CHECK(seconds > cars * least_s);
}

}  // namespace

TEST_GROUP(SoundCars){};

// BMS-018, BMS-024, BMS-060, BMS-061, BMS-062, BMS-063, BMS-064, BMS-065, BMS-066, BMS-067, BMS-068
TEST(SoundCars, StretchesOfDrawnCarsAccuseNoChannel) { none_is_accused(kStretches, 1, 60.0); }

TEST(SoundCars, EndurancesOfDrawnCarsAccuseNoChannel) { none_is_accused(kEndurances, 22, 600.0); }

// BMS-061: what the BMS is told is half of the truth, and on a hot day a third.
TEST(SoundCars, CellAgedToThreeTimesOnAHotDayAccusesNoChannelWhereTheTableIsWrongByTwo) {
  EnduranceOptions options = nominal(6);
  options.vehicle = vtm16e();
  options.vehicle.battery.cells.resize(24);
  options.vehicle.battery.cells[7].resistance_scale = 3.0;
  options.vehicle.battery.initial_temperature_c = options.vehicle.environment.ambient_c = 45.0;
  options.vehicle.bms.resistance_ohm = 0.0012;
  options.vehicle.bms.resistance_per_kelvin = -0.015;  // beyond the 40 degC of the cell's tables, too
  options.vehicle.assertions.battery_temperature_max_c = 200.0;
  options.representative_cell = false;
  SilenceableLoop loop(options.vehicle);
  Faults faults;
  const EnduranceResult r = run_endurance(options, loop, faults);
  CHECK_TEXT(faults.bits == 0, fmt::format("faults {:#x} at {:.2f} s", faults.bits, faults.at_s).c_str());
  CHECK(r.total_time_s > 400.0);
}

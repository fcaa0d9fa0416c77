// SPDX-License-Identifier: Apache-2.0
// MST-022, MST-031, MST-035: braking with the motor on drawn cars, frame by frame.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "can_dbc/car.hpp"
#include "drawn.hpp"
#include "loop.hpp"
#include "plant_sim/fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

/// What went beyond the charge limits of the last 100 ms, and what braked below 5 km/h.
struct BrakingRecord : Record {
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override {
    Record::on_frame(tick, sender, frame);
    can::PackSensor pack;
    can::BmsLimits limits;
    can::InverterCommand command;
    can::WheelSpeeds wheels;
    if (decode(frame, limits)) {
      allowed_a[next++ % allowed_a.size()] = 1e-3 * limits.charge_limit_ma;
    } else if (decode(frame, wheels)) {
      slowest_mps = 1e-3 * std::min({wheels.front_left_mmps, wheels.front_right_mmps, wheels.rear_left_mmps,
                                     wheels.rear_right_mmps});
    } else if (decode(frame, command)) {
      if (command.phase_current_ma < 0 && slowest_mps <= 1.389) ++too_slow;
    } else if (decode(frame, pack)) {
      const double most_a = *std::max_element(allowed_a.begin(), allowed_a.end());
      const double charges_a = -1e-3 * pack.pack_current_ma;
      most_charge_a = std::max(most_charge_a, charges_a);
      most_over_a = std::max(most_over_a, charges_a - most_a);
    }
  }
  std::array<double, 10> allowed_a{};
  std::size_t next = 0;
  double slowest_mps = 0.0, most_charge_a = 0.0, most_over_a = 0.0;
  int too_slow = 0;
};

}  // namespace

TEST_GROUP(Regeneration){};

TEST(Regeneration, DrawnCarsBrakeWithinTheChargeLimitAndNotBelowFiveKilometresPerHour) {
  const std::uint64_t drawn = drawn_seed();
  double least_gain = 1.0, most_gain = 0.0;
  for (int k = 0; k < 12; ++k) {
    Drawn draw(drawn + static_cast<std::uint64_t>(k));
    EnduranceOptions options = nominal(1);
    VehicleParameters& car = options.vehicle;
    if (draw.chance(0.5)) options.lap_start = LapStart::kStanding;
    const EnduranceResult without = drive(options);
    car.master.regen_current_max_a = draw.between(50.0, 400.0);
    car.master.regen_full_brake_bar = draw.between(10.0, 60.0);
    car.bms.charge_current_max_a = draw.between(10.0, 150.0);
    car.battery.initial_soc = draw.between(0.4, 0.999);
    BrakingRecord record;
    const EnduranceResult r = drive(options, record);
    const std::string what =
        fmt::format("VOLTLAP_TEST_SEED={}, car {}: {:.1f} A, {:.1f} A over, {} too slow; {}", drawn, k,
                    record.most_charge_a, record.most_over_a, record.too_slow, r.failure_cause);
    CHECK_TEXT(r.finished, what.c_str());
    CHECK_TEXT(record.most_over_a < 1.0, what.c_str());
    LONGS_EQUAL_TEXT(0, record.too_slow, what.c_str());
    CHECK_TEXT(r.energy_ledger_error_pct < 0.1, what.c_str());
    CHECK_TEXT(r.energy_back_kwh > 0.0 && r.energy_out_kwh < without.energy_out_kwh, what.c_str());
    const double gain = r.energy_back_kwh / r.energy_out_kwh;
    least_gain = std::min(least_gain, gain);
    most_gain = std::max(most_gain, gain);
  }
  fmt::print("VOLTLAP_TEST_SEED={}: 12 cars, {:.1f} to {:.1f} % more range\n", drawn, 100.0 * least_gain,
             100.0 * most_gain);
}

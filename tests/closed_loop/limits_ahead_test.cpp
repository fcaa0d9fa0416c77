// SPDX-License-Identifier: Apache-2.0
// Drawn packs under limits that look ahead: cold, with cells that nobody told the BMS of and a resistance that is
// entered wrong by up to two both ways. The limit binds, holds the cells where it says, and does not hunt.
#include <algorithm>

#include <fmt/format.h>

#include "apps/limit_race.hpp"
#include "drawn.hpp"
#include "loop.hpp"
#include "plant_sim/fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr int kRaces = 10;
constexpr double kBound_v = 3.2;  // high, so that it binds

EnduranceOptions drawn_race(Drawn& draw) {
  EnduranceOptions out = nominal(3);
  out.representative_cell = false;
  VehicleParameters& car = out.vehicle;
  car.bms.soc_method = "ekf";
  car.bms.limit_method = "ahead";
  car.bms.limit_horizon_s = draw.chance(0.5) ? 1.0 : 10.0;
  car.bms.cell_voltage_min_v = kBound_v;
  car.battery.initial_soc = draw.between(0.35, 0.6);
  car.battery.initial_temperature_c = car.environment.ambient_c = draw.between(-10.0, 5.0);
  car.battery.cells.resize(24);
  for (auto& cell : car.battery.cells) {
    cell.capacity_scale = draw.between(0.85, 1.0);
    cell.resistance_scale = draw.between(0.9, 1.4);
  }
  car.battery.cells[static_cast<std::size_t>(draw.whole(0, 23))].resistance_scale = draw.between(1.4, 3.0);
  car.sensors.noise = car.sensors.quantisation = true;
  car.assertions.speed_error_max_mps = 100.0;
  return out;
}

}  // namespace

TEST_GROUP(LimitsAhead){};

// BMS-045
TEST(LimitsAhead, DrawnPacksStayAtTheirBoundAndTheLimitDoesNotHunt) {
  const std::uint64_t drawn = drawn_seed();
  double bound_s = 0.0, lowest_v = 5.0;
  for (int k = 0; k < kRaces; ++k) {
    const std::uint64_t seed = drawn + static_cast<std::uint64_t>(k);
    Drawn draw(seed);
    EnduranceOptions options = drawn_race(draw);
    options.seed = seed;
    const double told = draw.between(0.5, 2.0);
    const LimitRaceResult race =
        run_limit_race(options, bms::LimitMethod::kAhead, told, [](double) { return false; });
    const std::string words = fmt::format("VOLTLAP_TEST_SEED={}: told {:.2f}, lowest {:.3f} V, {} reversals, {}", seed,
                                          told, race.lowest_cell_v, race.reversals, race.drive.failure_cause);
    CHECK_FALSE_TEXT(race.under_voltage, words.c_str());
    LONGS_EQUAL_TEXT(0, race.reversals, words.c_str());
    CHECK_TEXT(race.lowest_cell_v > kBound_v - 0.06, words.c_str());
    bound_s += race.bound_s;
    lowest_v = std::min(lowest_v, race.lowest_cell_v);
  }
  fmt::print("VOLTLAP_TEST_SEED={}: {} races, the limit bound for {:.0f} s, lowest cell {:.3f} V of {} V\n", drawn,
             kRaces, bound_s, lowest_v, kBound_v);
  CHECK(bound_s > 1.0);  // 10 s in the least of 150 drawn tens, 80 s on the mean
}

// SPDX-License-Identifier: Apache-2.0
// What the BMS's filter is told of the circuit over the temperature, beside the cell's own law.
#include "apps/firmware_circuit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include "apps/firmware_config.hpp"
#include "bms/estimate/cell_model.hpp"
#include "core/parameter_file.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

unsigned drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10)) : std::random_device{}();
}

}  // namespace

TEST_GROUP(FirmwareCircuit) {
  VehicleParameters car = load_vehicle(DataFolder(VOLTLAP_SOURCE_DIR "/plant_sim/data"), "vtm16e").parameters;
  unsigned seed = drawn_seed();
  std::mt19937_64 random{seed};

  void setup() override {
    car.bms.soc_method = "ekf";
    for (CellParameterMap* map : maps()) map->per_kelvin = map->per_ampere = 0.0;
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  std::vector<CellParameterMap*> maps() {
    std::vector<CellParameterMap*> out{&car.cell.r0_ohm};
    for (std::size_t k = 0; k < car.cell.branch_count(); ++k) {
      out.push_back(&car.cell.branches[k].r_ohm);
      out.push_back(&car.cell.branches[k].tau_s);
    }
    return out;
  }
  bms::WarmthCurve curve() {
    bms::CellModel model;
    bms::make_model(bms_config(car), model);
    return model.by_temperature;
  }
};

TEST(FirmwareCircuit, PartsFollowTheCellsKineticsOverItsTemperatures) {
  const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(seed);
  const double here_c = car.cell.reference_temperature_c, most_a = car.cell.current_breakpoints_a.back();
  double worst = 0.0;
  for (int draw = 0; draw < 40; ++draw) {
    car.cell.temperature_breakpoints_c = {uniform(-15.0, 5.0), uniform(10.0, 20.0), here_c, uniform(40.0, 60.0)};
    car.cell.kinetic_law = true;
    for (CellParameterMap* map : maps()) map->activation_energy_j_per_mol = uniform(0.0, 50e3);
    const CellTables tables(car.cell);
    const bms::WarmthCurve warmth = curve();
    LONGS_EQUAL(bms::kMaxWarmthPoints, warmth.points);
    const CircuitParameters here = tables.circuit(0.5, here_c, most_a);
    for (int counts = warmth.low(); counts <= warmth.high(); counts += 7) {
      const CircuitParameters there = tables.circuit(0.5, 0.1 * counts, most_a);
      const bms::PartFactors f = bms::factors_of(warmth, counts);
      const double wanted[] = {there.r0_ohm / here.r0_ohm, there.r_ohm[0] / here.r_ohm[0],
                               there.tau_s[0] / here.tau_s[0], there.r_ohm[1] / here.r_ohm[1],
                               there.tau_s[1] / here.tau_s[1]};
      const std::int32_t told[] = {f.r0, f.r1, f.time1, f.r2, f.time2};
      for (std::size_t k = 0; k < 5; ++k) {
        const double held = std::clamp(wanted[k], 0.1, 7.9);
        worst = std::max(worst, std::abs(std::ldexp(told[k], -bms::kUnitBits) / held - 1.0));
      }
    }
  }
  std::printf("%s: parts within %.1f %% of the cell's over the temperature\n", what.c_str(), 100.0 * worst);
  CHECK_TEXT(worst < 0.15, what.c_str());
}

// A table of few temperatures is straight between them, and so is the firmware: at each of them and in the middle.
TEST(FirmwareCircuit, ATableIsReadAtItsOwnTemperatures) {
  for (CellParameterMap* map : maps()) map->per_kelvin = -0.012;
  car.cell.temperature_breakpoints_c = {5.0, 22.0, 30.0, 47.0};
  const bms::WarmthCurve warmth = curve();
  LONGS_EQUAL(4, warmth.points);
  for (const double c : {5.0, 13.5, 22.0, 26.0, 30.0, 38.5, 47.0}) {
    const bms::PartFactors f = bms::factors_of(warmth, static_cast<std::int32_t>(10.0 * c));
    for (const std::int32_t part : {f.r0, f.r1, f.r2, f.time1, f.time2})
      DOUBLES_EQUAL(1.0 - 0.012 * (c - car.cell.reference_temperature_c), std::ldexp(part, -bms::kUnitBits), 1e-5);
  }
}

// However many temperatures a table has, and however near or far they are: the BMS takes them, from the first on.
TEST(FirmwareCircuit, AnyTemperaturesOfATableAreTaken) {
  const std::string what = "VOLTLAP_TEST_SEED=" + std::to_string(seed);
  for (int draw = 0; draw < 200; ++draw) {
    const double span = std::exp(uniform(std::log(0.3), std::log(180.0)));
    const double low = uniform(-60.0, 30.0);
    std::vector<double> at{low, low + span};
    for (int more = std::uniform_int_distribution<int>(0, 20)(random); more > 0; --more)
      at.push_back(low + span * uniform(0.0, 1.0));
    std::sort(at.begin(), at.end());
    at.erase(std::unique(at.begin(), at.end()), at.end());
    car.cell.temperature_breakpoints_c = at;
    car.cell.kinetic_law = draw % 2 == 0;
    const bms::WarmthCurve warmth = curve();
    CHECK_TEXT(warmth.points >= 1 && warmth.points <= bms::kMaxWarmthPoints, what.c_str());
    CHECK_TEXT(std::abs(0.1 * warmth.low() - low) < 0.06, what.c_str());
    // What is left out is less than the firmware's least step.
    CHECK_TEXT(std::abs(0.1 * warmth.high() - at.back()) < 1.2, what.c_str());
  }
}

TEST(FirmwareCircuit, OneTemperatureSaysNothingOfOthers) {
  car.cell.temperature_breakpoints_c = {car.cell.reference_temperature_c};
  const bms::WarmthCurve warmth = curve();
  LONGS_EQUAL(1, warmth.points);
  LONGS_EQUAL(bms::kUnit, bms::factors_of(warmth, -200).r1);
  LONGS_EQUAL(bms::kUnit, bms::factors_of(warmth, 600).time2);
}

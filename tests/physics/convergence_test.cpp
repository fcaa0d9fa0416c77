// SPDX-License-Identifier: Apache-2.0
// Halving the step halves the error: the order of the coupled integration, measured in every quantity of a drive.
#include <array>
#include <cmath>

#include "fixtures.hpp"
#include "variants.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr std::size_t kQuantities = 5;
constexpr std::array<const char*, kQuantities> kNames = {"speed", "distance", "charge", "energy",
                                                         "battery temperature"};

std::array<double, kQuantities> end_of_drive(const Variant& variant, int steps_per_period) {
  Drive drive(variant, steps_per_period);
  drive.switch_on();
  drive.car.vehicle().set_speed(5.0);
  drive.run(2.0, 450.0, 0.0);
  drive.run(0.5, 100.0, 0.0);
  drive.run(0.3, 0.0, 0.5);
  return {drive.car.vehicle().speed_mps(), drive.car.vehicle().distance_m(), drive.car.pack().charge_out_ah(),
          drive.car.energy_out_j(), drive.car.pack().temperature_max_c()};
}

}  // namespace

TEST_GROUP(Convergence){};

TEST(Convergence, TheErrorFallsWithTheStepAtFirstOrderInEveryQuantity) {
  for (const VehicleParameters& car : {vtm16e(), lossy_vtm16e()}) {
    const Variant variant{"", car, true};
    const auto coarse = end_of_drive(variant, 10), middle = end_of_drive(variant, 20), fine = end_of_drive(variant, 40);
    for (std::size_t q = 0; q < kQuantities; ++q) {
      const double order = std::log2(std::abs(coarse[q] - middle[q]) / std::abs(middle[q] - fine[q]));
      DOUBLES_EQUAL_TEXT(1.0, order, 0.1, kNames[q]);
    }
  }
}

TEST(Convergence, OneMillisecondIsWithinATwentiethOfAPercentOfTheLimit) {
  const Variant variant{"", vtm16e(), true};
  const auto used = end_of_drive(variant, 10), fine = end_of_drive(variant, 320);
  for (std::size_t q = 0; q < kQuantities; ++q) DOUBLES_EQUAL_TEXT(fine[q], used[q], 5e-4 * fine[q], kNames[q]);
}

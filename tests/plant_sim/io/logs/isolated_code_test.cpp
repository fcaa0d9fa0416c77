// SPDX-License-Identifier: Apache-2.0
#include "io/logs/isolated_code.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// A sensor's course with a little noise, in whole steps.
std::vector<double> course(double middle, double size, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<double> out;
  for (int k = 0; k < 2000; ++k) out.push_back(std::round(middle + size * std::sin(k / 100.0) + noise(generator)));
  return out;
}

}  // namespace

TEST_GROUP(IsolatedCode){};

TEST(IsolatedCode, MomentsAwayFromASteadyCourseAreNoValue) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::vector<double> value = course(9600, 500, seed);
    for (std::size_t k = 50; k < value.size(); k += 97) value[k] = 65535;
    value[700] = value[701] = value[702] = 65535;
    CHECK_TEXT(all_ones_is_no_value(value, 65535), std::to_string(seed).c_str());
  }
}

TEST(IsolatedCode, ValueThatIsReachedByAWayOrHeldIsAValue) {
  std::vector<double> ramp, held = course(20, 3, 2), pressed = course(20, 3, 3);
  for (int k = 0; k < 4000; ++k) ramp.push_back(std::abs(k % 510 - 255));  // 255, 254 ... 0 ... 255
  for (std::size_t k = 500; k < 700; ++k) held[k] = 255;
  pressed[500] = 120;
  pressed[501] = 255;
  CHECK_FALSE(all_ones_is_no_value(ramp, 255));
  CHECK_FALSE(all_ones_is_no_value(held, 255));
  CHECK_FALSE(all_ones_is_no_value(pressed, 255));
}

TEST(IsolatedCode, OneStretchThatIsAValueKeepsAll) {
  std::vector<double> value = course(9600, 500, 4);
  value[100] = value[300] = 65535;
  CHECK(all_ones_is_no_value(value, 65535));
  for (std::size_t k = 800; k < 900; ++k) value[k] = 65535;
  CHECK_FALSE(all_ones_is_no_value(value, 65535));
}

TEST(IsolatedCode, TheBeginningTheEndAndSignalsThatHardlyMoveSayNothing) {
  std::vector<double> value = course(9600, 500, 5);
  CHECK_FALSE(all_ones_is_no_value(value, 65535));
  value[0] = 65535;
  CHECK_FALSE(all_ones_is_no_value(value, 65535));
  std::vector<double> pedal(1000, 0.0);
  pedal[500] = 255;
  CHECK_FALSE(all_ones_is_no_value(pedal, 255));
  CHECK_FALSE(all_ones_is_no_value({}, 255));
}

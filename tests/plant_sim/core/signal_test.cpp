// SPDX-License-Identifier: Apache-2.0
#include "core/signal.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

using namespace voltlap::plant;

TEST_GROUP(Signal) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
};

TEST(Signal, TheMedianIsTheUpperMiddleAndIgnoresWhatIsNoNumber) {
  DOUBLES_EQUAL(2.0, median({3.0, 1.0, 2.0}), 0.0);
  DOUBLES_EQUAL(3.0, median({4.0, 1.0, nan, 2.0, 3.0}), 0.0);
  DOUBLES_EQUAL(0.0, median({nan}), 0.0);
}

TEST(Signal, AQuantileReachesBothEnds) {
  DOUBLES_EQUAL(1.0, quantile({3.0, 1.0, 2.0}, 0.0), 0.0);
  DOUBLES_EQUAL(3.0, quantile({3.0, 1.0, 2.0}, 1.0), 0.0);
  CHECK_THROWS(std::logic_error, static_cast<void>(quantile({1.0}, nan)));
}

TEST(Signal, NineTenthsAreCountedAsExactlyAsInIntegers) {
  std::vector<double> values;
  for (std::size_t n = 1; n <= 3000; ++n) {
    values.push_back(static_cast<double>(n - 1));
    DOUBLES_EQUAL(static_cast<double>(n * 9 / 10), quantile(values, 0.9), 0.0);
  }
}

TEST(Signal, TheRmsOfASignIsThatOfItsSize) {
  const std::vector<double> values{3.0, nan, -4.0};
  DOUBLES_EQUAL(std::sqrt(12.5), rms(values), 1e-15);
  DOUBLES_EQUAL(0.0, rms({}), 0.0);
}

TEST(Signal, TheStepOfACoarseSensorIsItsSmallestDifference) {
  DOUBLES_EQUAL(0.5, smallest_step({21.0, 20.0, 20.5, 20.0, nan}), 0.0);
  DOUBLES_EQUAL(0.0, smallest_step({20.0, 20.0}), 0.0);
}

TEST(Signal, DifferencesAreOneFewerThanValues) {
  LONGS_EQUAL(0, differences({1.0}).size());
  DOUBLES_EQUAL(2.0, differences({1.0, 3.0, 2.0})[0], 0.0);
  DOUBLES_EQUAL(-1.0, differences({1.0, 3.0, 2.0})[1], 0.0);
}

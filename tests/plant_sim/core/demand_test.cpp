// SPDX-License-Identifier: Apache-2.0
#include "core/demand.hpp"

#include <CppUTest/TestHarness.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

using namespace voltlap::plant;

TEST_GROUP(Demand) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
};

TEST(Demand, AMetDemandCostsNothingAndAnUnmetOneNamesConditionAndPlace) {
  VOLTLAP_DEMAND(1 + 1 == 2);
  std::string text;
  try {
    VOLTLAP_DEMAND(1 + 1 == 3);
  } catch (const std::logic_error& error) {
    text = error.what();
  }
  STRCMP_CONTAINS("demand_test.cpp:", text.c_str());
  STRCMP_CONTAINS("not so: 1 + 1 == 3", text.c_str());
}

TEST(Demand, NoNumberIsNeitherFiniteNorWithinNorIncreasing) {
  CHECK(all_finite(std::vector<double>{}));
  CHECK(!all_finite(std::vector<double>{1.0, nan}));
  CHECK(within(1.0, 1.0, 1.0) && !within(nan, 0.0, 1.0) && !within(1.1, 0.0, 1.0));
  CHECK(increasing(std::vector<double>{0.0, 0.1, 7.0}));
  CHECK(!increasing(std::vector<double>{0.0, 0.0}));
  CHECK(!increasing(std::vector<double>{0.0, nan, 1.0}));
}

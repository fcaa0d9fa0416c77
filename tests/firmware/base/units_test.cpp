// SPDX-License-Identifier: Apache-2.0
#include "base/units.hpp"

#include <type_traits>

#include "CppUTest/TestHarness.h"

using namespace voltlap;

static_assert(!std::is_convertible_v<std::int32_t, Current>, "no implicit way in");
static_assert(!std::is_convertible_v<Current, std::int32_t>, "no implicit way out");
static_assert(!std::is_convertible_v<CellVoltage, PackVoltage>, "a cell is no pack");

TEST_GROUP(Units) {
  const std::int32_t top = std::numeric_limits<std::int32_t>::max();
  const std::int32_t bottom = std::numeric_limits<std::int32_t>::min();
};

TEST(Units, SumsAndDifferencesSaturateAFewLsbFromTheEnds) {
  for (std::int32_t lsb : {0, 1, 2}) {
    LONGS_EQUAL(top, (Current::from_raw(top - lsb) + Current::from_raw(lsb + 1)).raw());
    LONGS_EQUAL(bottom, (Current::from_raw(bottom + lsb) - Current::from_raw(lsb + 1)).raw());
  }
  LONGS_EQUAL(top, (-Current::from_raw(bottom)).raw());
  LONGS_EQUAL(top - 1, (Current::from_raw(top - 2) + Current::from_raw(1)).raw());
}

TEST(Units, WideIntermediatesSaturate) {
  LONGS_EQUAL(top, Current::saturated(std::int64_t{top} + 1).raw());
  LONGS_EQUAL(bottom, Current::saturated(std::int64_t{bottom} - 1).raw());
}

TEST(Units, MagnitudeIsWithoutSignAndSaturates) {
  LONGS_EQUAL(0, magnitude(Current{}).raw());
  LONGS_EQUAL(1, magnitude(Current::from_raw(-1)).raw());
  LONGS_EQUAL(top, magnitude(Current::from_raw(top)).raw());
  LONGS_EQUAL(top, magnitude(Current::from_raw(bottom)).raw());
  CHECK(magnitude(std::int64_t{bottom}) == std::int64_t{top} + 1);
}

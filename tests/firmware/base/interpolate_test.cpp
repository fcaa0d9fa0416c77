// SPDX-License-Identifier: Apache-2.0
#include "base/interpolate.hpp"

#include "base/units.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(Interpolate) {
  const Soc x[3] = {Soc::from_raw(0), Soc::from_raw(10), Soc::from_raw(30)};
  const CellVoltage y[3] = {CellVoltage::from_raw(100), CellVoltage::from_raw(200), CellVoltage::from_raw(150)};
  std::int32_t at(std::int32_t v) { return interpolate(x, y, 3, Soc::from_raw(v)).raw(); }
};

TEST(Interpolate, PointsAreHitExactlyAndBothEndsAreHeld) {
  LONGS_EQUAL(100, at(-5));
  LONGS_EQUAL(100, at(0));
  LONGS_EQUAL(200, at(10));
  LONGS_EQUAL(150, at(30));
  LONGS_EQUAL(150, at(31));
}

TEST(Interpolate, BetweenPointsItIsLinearAndRoundedToNearest) {
  LONGS_EQUAL(110, at(1));
  LONGS_EQUAL(190, at(9));
  LONGS_EQUAL(197, at(11));  // a fall of 2.5 counts as 3
  LONGS_EQUAL(175, at(20));
}

TEST(Interpolate, OnePointIsAConstant) { LONGS_EQUAL(100, interpolate(x, y, 1, Soc::from_raw(7)).raw()); }

TEST(Interpolate, WideValuesDoNotOverflow) {
  const Soc wide_x[2] = {Soc::from_raw(0), Soc::from_raw(2'000'000'000)};
  const Current wide_y[2] = {Current::from_raw(-2'000'000'000), Current::from_raw(2'000'000'000)};
  LONGS_EQUAL(0, interpolate(wide_x, wide_y, 2, Soc::from_raw(1'000'000'000)).raw());
}

TEST(Interpolate, IncreasingIsTold) {
  CHECK(strictly_increasing(x, 3));
  CHECK_FALSE(strictly_increasing(y, 3));
  const Soc flat[2] = {Soc::from_raw(1), Soc::from_raw(1)};
  CHECK_FALSE(strictly_increasing(flat, 2));
}

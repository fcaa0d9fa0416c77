// SPDX-License-Identifier: Apache-2.0
#include "io/logs/wrapped_signal.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

bool fits_any(std::uint64_t, bool) { return true; }
bool fits_signed(std::uint64_t, bool is_signed) { return is_signed; }
bool fits_unsigned(std::uint64_t, bool is_signed) { return !is_signed; }

std::vector<std::uint64_t> wrapped(const std::vector<double>& values, unsigned length) {
  std::vector<std::uint64_t> out;
  const std::uint64_t mask = (std::uint64_t{1} << length) - 1;
  for (const double value : values) {
    out.push_back(static_cast<std::uint64_t>(static_cast<std::int64_t>(std::lround(value))) & mask);
  }
  return out;
}

std::vector<double> in_turns(double a, double b) {
  std::vector<double> out;
  for (int k = 0; k < 300; ++k) out.push_back(k / 50 % 2 == 0 ? a : b);
  return out;
}

Wrapping judged(const std::vector<std::uint64_t>& raw, unsigned length, bool (*fits)(std::uint64_t, bool)) {
  return wrapped_signal(raw, length, fits).wrapping;
}

}  // namespace

TEST_GROUP(WrappedSignal){};

TEST(WrappedSignal, CurrentThatTheRangeAllowsAsSignedOnlyIsSigned) {
  const auto raw = wrapped(in_turns(-300, 1000), 16);
  const WrapVerdict verdict = wrapped_signal(raw, 16, fits_signed);
  CHECK(verdict.wrapping == Wrapping::kSigned);
  LONGS_EQUAL(150, verdict.negative);
  LONGS_EQUAL(5, verdict.crossings);
  LONGS_EQUAL(65236, verdict.largest);
  LONGS_EQUAL(65236, verdict.lowest);
}

TEST(WrappedSignal, CurrentThatGoesThroughZeroGraduallyIsSignedWithoutAnyRange) {
  for (const unsigned length : {8U, 12U, 16U, 24U, 32U}) {
    std::mt19937 generator(length);
    std::normal_distribution<double> noise(0.0, 0.5);
    const double size = std::ldexp(0.1, static_cast<int>(length));
    std::vector<double> values;
    for (int k = 0; k < 5000; ++k) values.push_back(size * std::sin(k / 40.0) + noise(generator));
    CHECK(judged(wrapped(values, length), length, fits_any) == Wrapping::kSigned);
  }
}

TEST(WrappedSignal, JumpsThatMayBeEitherAreDoubtful) {
  CHECK(judged(wrapped(in_turns(-300, 1000), 12), 12, fits_any) == Wrapping::kDoubtful);
  CHECK(judged({5, 5, 250, 250, 250, 5, 5, 5}, 8, fits_any) == Wrapping::kDoubtful);
}

TEST(WrappedSignal, UnsignedSignalsStayUnsigned) {
  std::vector<std::uint64_t> counter, ramp, full;
  for (unsigned k = 0; k < 3000; ++k) {
    counter.push_back(k % 256);
    ramp.push_back(k % 512 < 256 ? k % 256 : 255 - k % 256);
    full.push_back(k / 100 % 2 == 0 ? 0 : 255);
  }
  CHECK(judged(counter, 8, fits_any) == Wrapping::kNone);
  CHECK(judged(ramp, 8, fits_any) == Wrapping::kNone);
  CHECK(judged(full, 8, fits_any) == Wrapping::kNone);  // pedal, not touched or to the floor
  CHECK(judged(wrapped(in_turns(-300, 1000), 16), 16, fits_unsigned) == Wrapping::kNone);
  CHECK(judged({}, 16, fits_any) == Wrapping::kNone);
  CHECK(judged({1, 2, 3}, 4, fits_any) == Wrapping::kNone);
}

TEST(WrappedSignal, AllOnesFarFromTheOthersAreACodeAndNoMinusOne) {
  std::vector<std::uint64_t> voltage, two_codes, around_zero;
  for (unsigned k = 0; k < 1000; ++k) {
    voltage.push_back(k % 50 == 0 ? 0xFFFF : 9600 + k % 7);
    two_codes.push_back(k % 50 == 0 ? 0xFFFF : k % 70 == 0 ? 0xFFFE : 960 + k % 7);
    around_zero.push_back((k % 3 - 1) & 0xFFFFU);
  }
  CHECK(judged(voltage, 16, fits_signed) == Wrapping::kNone);
  CHECK(judged(two_codes, 16, fits_signed) == Wrapping::kNone);
  CHECK(judged(around_zero, 16, fits_signed) == Wrapping::kSigned);
}

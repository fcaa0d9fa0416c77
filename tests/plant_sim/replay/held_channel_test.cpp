// SPDX-License-Identifier: Apache-2.0
#include "replay/held_channel.hpp"

#include <limits>

#include "CppUTest/TestHarness.h"

using namespace voltlap::plant;

namespace {

constexpr double kMasked = std::numeric_limits<double>::quiet_NaN();

Channel channel(std::vector<double> time_s, std::vector<double> value) {
  return {"current", "test", std::move(time_s), std::move(value)};
}

}  // namespace

TEST_GROUP(HeldChannel) {};

TEST(HeldChannel, without_a_recording_there_is_never_a_value) {
  HeldChannel held;
  held.advance(100.0);
  CHECK_FALSE(held.recorded());
  CHECK_FALSE(held.known());
}

TEST(HeldChannel, a_sample_counts_from_its_own_time_until_it_is_too_old) {
  const Channel c = channel({1.0, 2.0}, {10.0, 20.0});
  HeldChannel held(&c, 0.5);
  held.advance(0.99);
  CHECK_FALSE(held.known());
  held.advance(1.0);
  CHECK(held.known());
  DOUBLES_EQUAL(10.0, held.value(), 0.0);
  held.advance(1.5);
  CHECK(held.known());
  held.advance(1.51);
  CHECK_FALSE(held.known());
  held.advance(2.0);
  DOUBLES_EQUAL(20.0, held.value(), 0.0);
  CHECK(held.known());
}

TEST(HeldChannel, what_is_masked_refreshes_nothing) {
  const Channel c = channel({1.0, 1.4, 1.8}, {10.0, kMasked, kMasked});
  HeldChannel held(&c, 0.5);
  held.advance(1.4);
  CHECK(held.known());
  DOUBLES_EQUAL(1.0, held.sampled_s(), 0.0);
  held.advance(1.8);
  CHECK_FALSE(held.known());
}

TEST(HeldChannel, first_and_last_are_those_of_samples) {
  const Channel c = channel({1.0, 2.0, 3.0, 4.0}, {kMasked, 5.0, 6.0, kMasked});
  const HeldChannel held(&c, 1.0);
  DOUBLES_EQUAL(2.0, held.first_s(), 0.0);
  DOUBLES_EQUAL(3.0, held.last_s(), 0.0);
}

TEST(HeldChannel, the_usual_interval_lets_a_tenth_be_longer) {
  std::vector<double> time_s, value;
  for (int k = 0; k <= 100; ++k) {
    time_s.push_back(0.1 * k + (k > 50 ? 7.0 : 0.0));  // one gap
    value.push_back(1.0);
  }
  const Channel c = channel(time_s, value);
  DOUBLES_EQUAL(0.1, usual_interval_s({&c}), 1e-9);
}

TEST(HeldChannel, of_channels_read_once_the_round_is_the_interval) {
  const Channel a = channel({1.0}, {1.0}), b = channel({4.0}, {1.0});
  DOUBLES_EQUAL(3.0, usual_interval_s({&a, &b}), 1e-9);
}

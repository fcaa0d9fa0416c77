// SPDX-License-Identifier: Apache-2.0
// What the sentence says of a log of which nothing is told.
#include "explain/say/verdict.hpp"

#include <CppUTest/TestHarness.h>

#include <string>

namespace voltlap::explain {
namespace {

/// A log of half a second between its rows, with a thermistor's channel.
Observed log_with(double practical, double between_rows) {
  Observed out;
  out.comparison.log.time_s = VectorXd::LinSpaced(2001, 0.0, 1000.0);
  ReadChannel channel;
  channel.name = "temperature";
  channel.unit = "K";
  channel.balance = plant::Balance::kHeat;
  channel.practical = practical;
  channel.between_rows = between_rows;
  out.channels.push_back(channel);
  return out;
}

plant::Explanation with_left(double left, double floor) {
  plant::Explanation out;
  out.gain["temperature"] = {left, left, floor, 0.0, 0.0, "K"};
  return out;
}

}  // namespace

TEST_GROUP(Verdict){};

TEST(Verdict, WhatIsLeftAndWorthAWordIsSaid) {
  STRCMP_EQUAL(
      " What is left of the temperature (0.72 K RMS) may be what was between rows 0.5 s apart: a finer log tells.",
      left_untold(log_with(0.1, 6.0), with_left(0.72, 0.01)).c_str());
  STRCMP_EQUAL(
      " What is left of the temperature (0.27 K RMS) a sound log of such a model may have: a known good log tells.",
      left_untold(log_with(0.1, 0.5), with_left(0.27, 0.01)).c_str());
}

TEST(Verdict, NoiseAndTriflesAreNotSaid) {
  STRCMP_EQUAL("", left_untold(log_with(0.1, 6.0), with_left(0.19, 0.0)).c_str());
  STRCMP_EQUAL("", left_untold(log_with(0.1, 6.0), with_left(0.72, 0.71)).c_str());
  STRCMP_EQUAL("", left_untold(log_with(0.1, 6.0), {}).c_str());
}

}  // namespace voltlap::explain

// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/relaxation.hpp"

#include <cmath>
#include <random>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// Seconds until the rule sees no more than 1 mV/min; `voltage(t)` is what is read.
template <class Voltage>
double seconds_to_rest(RelaxationRule rule, double rate_hz, const Voltage& voltage) {
  rule.begin();
  for (int i = 1; i < 1'000'000; ++i) {
    const double t = i / rate_hz, v = voltage(t);
    rule.add({&v, 1});
    if (rule.known() && rule.rate_v_per_min() <= 0.001) return t;
  }
  return -1.0;
}

/// An exponential of amplitude a: mean of a minute minus that of the minute before, at time t.
double rise_seen(double a, double tau, double t) {
  const double minute = tau / 60.0 * (std::exp(60.0 / tau) - 1.0) * std::exp(-t / tau);
  return a * minute * (std::exp(60.0 / tau) - 1.0);
}

}  // namespace

TEST_GROUP(Relaxation) {
  RelaxationRule rule{1, 120.0, 8.0};
};

TEST(Relaxation, ASteadyRiseIsReadExactly) {
  for (int i = 0; i < 2000; ++i) {
    const double v = 3.5 + 0.0004 * i / 8.0;
    rule.add({&v, 1});
  }
  DOUBLES_EQUAL(0.024, rule.rate_v_per_min(), 1e-9);
}

TEST(Relaxation, NothingIsKnownBeforeTheWindowIsFull) {
  const double v = 3.7;
  for (int i = 0; i < 959; ++i) rule.add({&v, 1});
  CHECK_FALSE(rule.known());
  rule.add({&v, 1});
  CHECK(rule.known());
  rule.begin();
  CHECK_FALSE(rule.known());
}

TEST(Relaxation, AnExponentialEndsWhenItsClosedFormSaysSo) {
  constexpr double kAmplitude = 0.05, kTau = 400.0;
  const double measured =
      seconds_to_rest(rule, 8.0, [](double t) { return 3.7 - kAmplitude * std::exp(-t / kTau); });
  double expected = 120.0;
  while (rise_seen(kAmplitude, kTau, expected) > 0.001) expected += 0.01;
  DOUBLES_EQUAL(expected, measured, 0.25);
  // The rise at that moment is below the limit already: the rule looks back by half a window.
  const double rate = 60.0 * kAmplitude / kTau * std::exp(-measured / kTau);
  CHECK(rate < 0.001 && rate > 0.0008);
}

TEST(Relaxation, FastestCellDecidesAndAFallCountsAsWell) {
  RelaxationRule three(3, 120.0, 8.0);
  for (int i = 0; i < 1200; ++i) {
    const double v[] = {3.7, 3.6 - 0.0005 * i / 8.0, 3.5 + 0.0001 * i / 8.0};
    three.add(v);
  }
  DOUBLES_EQUAL(0.03, three.rate_v_per_min(), 1e-9);
}

TEST(Relaxation, NoiseAndStepsOfTheInstrumentsMoveTheEndByLittle) {
  constexpr double kAmplitude = 0.05, kTau = 400.0;
  const auto truth = [](double t) { return 3.7 - kAmplitude * std::exp(-t / kTau); };
  const double clean = seconds_to_rest(rule, 8.0, truth);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, 0.0015);
  for (int trial = 0; trial < 20; ++trial) {
    const double noisy = seconds_to_rest(
        rule, 8.0, [&](double t) { return 0.0015 * std::round((truth(t) + normal(random)) / 0.0015); });
    CHECK(std::abs(noisy - clean) < 0.3 * kTau);  // 30 % of a time constant: 0.3 mV/min
  }
}

TEST(Relaxation, OneReadingAMinuteAgoWouldBeFooledByTheSameNoise) {
  // Negative control: the naive rule, one reading against the one a minute before, ends in the steep part.
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0.0, 0.0015);
  const auto read = [&](double t) {
    return 0.0015 * std::round((3.7 - 0.05 * std::exp(-t / 400.0) + normal(random)) / 0.0015);
  };
  double t = 60.0;
  while (read(t) - read(t - 60.0) > 0.001) t += 0.125;
  const double rate = 60.0 * 0.05 / 400.0 * std::exp(-t / 400.0);
  CHECK(rate > 0.002);
}

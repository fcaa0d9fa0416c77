// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/signal_trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "courses.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

SignalTrace trace_of(const Samples& samples, std::size_t most_points) {
  SignalTrace out(course_of(samples), most_points);
  for (const auto& [time_s, value] : samples) out.add(time_s, value);
  out.finish();
  return out;
}

/// Spikes, plateaus, noise, steps, holes and values that are none, as a drawn recording has them.
Samples drawn(std::mt19937& random) {
  std::uniform_real_distribution<double> part(0.0, 1.0);
  const double interval = std::pow(10.0, -3.0 + 3.0 * part(random)), resolution = part(random) < 0.5 ? 1.0 : 0.01;
  const int count = 50 + static_cast<int>(5000 * part(random));
  const double restless = part(random);
  Samples out;
  double time = 0.0, value = 0.0;
  for (int k = 0; k < count; ++k) {
    time += interval * (0.5 + part(random));
    if (part(random) < 0.002) time += 200.0 * interval + 5.0;
    if (part(random) < restless) value += resolution * std::round(20.0 * (part(random) - 0.5));
    const double spike = part(random) < 0.002 ? 1e4 * (part(random) - 0.5) : 0.0;
    out.emplace_back(time, part(random) < 0.001 ? NAN : value + spike);
  }
  return out;
}

/// The piece of a trace that a point is in.
std::size_t piece_of(const SignalTrace& trace, std::size_t point) {
  return static_cast<std::size_t>(
      std::upper_bound(trace.begins().begin(), trace.begins().end(), point) - trace.begins().begin());
}

/// What is wrong with a trace; empty when nothing is.
std::string fault(const Samples& samples, const SignalTrace& trace, std::size_t most_points) {
  const auto& time = trace.time_s();
  const auto& value = trace.value();
  if (!std::is_sorted(time.begin(), time.end())) return "time runs back";
  if (time.size() > 2 * most_points + 2 * trace.begins().size()) return fmt::format("{} points", time.size());
  const double near = trace.bucket_s() * 1.001 + 1e-12;
  for (const auto& [at, sample] : samples) {
    if (!std::isfinite(sample)) continue;
    // Within a bucket there is a point at least as high, and one at least as low.
    bool above = false, below = false;
    const auto first = std::lower_bound(time.begin(), time.end(), at - near) - time.begin();
    const auto before = std::max<std::ptrdiff_t>(first - 1, 0);  // the plateau that it lies on
    for (auto k = static_cast<std::size_t>(before); k < time.size(); ++k) {
      above = above || value[k] >= sample;
      below = below || value[k] <= sample;
      if (time[k] > at + near) break;
    }
    if (!above || !below) return fmt::format("the value {} at {} s is lost", sample, at);
  }
  return {};
}

}  // namespace

TEST_GROUP(SignalTrace){};

TEST(SignalTrace, OfFewSamplesEveryChangeIsThere) {
  const SignalTrace trace = trace_of({{0.0, 1.25}, {0.1, 1.5}, {0.2, 1.0}}, 100);
  LONGS_EQUAL(3, trace.time_s().size());
  DOUBLES_EQUAL(0.0, trace.bucket_s(), 0.0);
  LONGS_EQUAL(1, trace.begins().size());
}

TEST(SignalTrace, APlateauIsItsTwoEnds) {
  Samples samples;
  for (int i = 0; i < 1000; ++i) samples.emplace_back(0.01 * i, i < 500 ? 2.0 : 3.0);
  const SignalTrace trace = trace_of(samples, 100);  // a step: a value lasts until the next
  LONGS_EQUAL(3, trace.time_s().size());
  DOUBLES_EQUAL(5.0, trace.time_s()[1], 1e-12);
  DOUBLES_EQUAL(9.99, trace.time_s()[2], 1e-12);
}

TEST(SignalTrace, ALineLeavesAPlateauAtItsLastSample) {
  Samples samples;
  for (int i = 0; i < 100; ++i) samples.emplace_back(0.01 * i, i < 50 ? 0.0 : i);
  const SignalTrace trace = trace_of(samples, 1000);
  DOUBLES_EQUAL(0.0, trace.time_s()[0], 0.0);
  DOUBLES_EQUAL(0.49, trace.time_s()[1], 1e-12);
  DOUBLES_EQUAL(0.50, trace.time_s()[2], 1e-12);
}

TEST(SignalTrace, NoLineCrossesAGapOrAValueThatIsNone) {
  Samples samples;
  for (int i = 0; i < 300; ++i) {
    const double shift = i < 100 ? 0.0 : 60.0;
    samples.emplace_back(0.01 * i + shift, i == 200 ? NAN : 0.1 * i);
  }
  const SignalTrace trace = trace_of(samples, 1000);
  LONGS_EQUAL(3, trace.begins().size());
  LONGS_EQUAL(2, trace.gaps());
  DOUBLES_EQUAL(61.0, trace.time_s()[trace.begins()[1]], 1e-9);
  DOUBLES_EQUAL(0.99, trace.time_s()[trace.begins()[1] - 1], 1e-9);
  DOUBLES_EQUAL(62.01, trace.time_s()[trace.begins()[2]], 1e-9);
}

TEST(SignalTrace, AValueThatReturnsBehindAGapIsDrawnAgain) {
  Samples samples;
  for (int i = 0; i < 100; ++i) samples.emplace_back(0.1 * i + (i < 50 ? 0.0 : 100.0), 4.0);
  const SignalTrace trace = trace_of(samples, 1000);
  LONGS_EQUAL(4, trace.time_s().size());
  LONGS_EQUAL(2, trace.begins().size());
}

TEST(SignalTrace, NoSamplesAreNoPoints) {
  LONGS_EQUAL(0, trace_of({}, 100).time_s().size());
  LONGS_EQUAL(0, trace_of({{0.0, NAN}, {1.0, NAN}}, 100).gaps());
}

TEST(SignalTrace, NoExtremeOfADrawnRecordingIsLostAndGapsStayGaps) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given != nullptr ? static_cast<unsigned>(std::atoi(given)) : std::random_device{}();
  std::mt19937 random(seed);
  for (int k = 0; k < 60; ++k) {
    const Samples samples = drawn(random);
    const std::size_t most = 16U << (random() % 8);
    const SignalTrace trace = trace_of(samples, most);
    const double gap_s = course_of(samples).gap_s();
    std::string found = fault(samples, trace, most);
    for (std::size_t i = 1; found.empty() && i < trace.time_s().size(); ++i) {
      // A stretch between two joined points has a sample at least every gap_s.
      if (piece_of(trace, i) != piece_of(trace, i - 1)) continue;
      double last = trace.time_s()[i - 1];
      for (const auto& [at, value] : samples) {
        if (at <= trace.time_s()[i - 1] || at > trace.time_s()[i] || !std::isfinite(value)) continue;
        if (at - last > gap_s) found = fmt::format("a line crosses the gap from {} s to {} s", last, at);
        last = at;
      }
    }
    if (!found.empty()) FAIL(fmt::format("VOLTLAP_TEST_SEED={}, draw {}: {}", seed, k, found).c_str());
  }
}

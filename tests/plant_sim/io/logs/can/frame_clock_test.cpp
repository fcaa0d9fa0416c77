// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/frame_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// A frame knows its true time by its line.
struct Stamped {
  double stamp_s;
  std::size_t line;
};

struct Result {
  std::vector<double> time_s;  ///< by line; NaN where left out
  std::vector<std::size_t> order;
  CanDefects defects;
  std::vector<ClockPart> parts;
};

Result clocked(const std::vector<Stamped>& frames, double turn_s = 0.0) {
  Result out;
  FrameClock clock(out.defects, turn_s);
  out.time_s.assign(frames.size(), std::nan(""));
  RecordedFrame given;
  std::size_t next = 0;
  for (;;) {
    if (clock.pop(given)) {
      out.time_s.at(given.line) = given.time_s;
      out.order.push_back(given.line);
    } else if (next < frames.size()) {
      clock.slot().time_s = frames[next].stamp_s;
      clock.slot().line = frames[next++].line;
      clock.push();
    } else if (!clock.finished()) {
      clock.finish();
    } else {
      break;
    }
  }
  out.parts = clock.parts();
  return out;
}

std::size_t count(const Result& result, const char* kind) {
  for (const CanDefect& defect : result.defects.all()) {
    if (defect.kind == kind) return defect.count;
  }
  return 0;
}

std::size_t left_out(const Result& result) {
  std::size_t out = 0;
  for (const CanDefect& defect : result.defects.all()) out += defect.used ? 0 : defect.count;
  return out;
}

using Random = std::mt19937;
double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// True times of a bus: mean interval drawn, some silence.
std::vector<double> drawn_times(Random& random, double begin_s) {
  std::vector<double> out;
  const double interval_s = std::pow(10.0, uniform(random, -3.3, -0.5));
  double time_s = begin_s;
  const int frames = static_cast<int>(uniform(random, 200, 3000));
  for (int k = 0; k < frames; ++k) {
    time_s += interval_s * uniform(random, 0.2, 1.8);
    out.push_back(time_s);
  }
  return out;
}

/// What is wrong with the recorder, drawn; the stamps and, per frame, whether the stamp can be known to be wrong.
struct Recording {
  std::vector<Stamped> frames;
  std::vector<double> true_s;    ///< by line
  std::vector<bool> wrong;       ///< by line: must be left out
  std::string disturbance;
  std::size_t joint = 0;         ///< line at which a new part begins; 0: none
};

Recording drawn_recording(Random& random) {
  Recording out;
  const double begin_s = uniform(random, 0.0, 1.0) < 0.5 ? 1.7e9 : 0.0;
  out.true_s = drawn_times(random, begin_s);
  const std::size_t size = out.true_s.size();
  out.wrong.assign(size, false);
  std::vector<double> stamp_s = out.true_s;
  const auto somewhere = [&] {
    return static_cast<std::size_t>(uniform(random, 20.0, static_cast<double>(size) - 20.0));
  };
  switch (static_cast<int>(uniform(random, 0.0, 6.0))) {
    case 0:
      out.disturbance = "none";
      break;
    case 1: {  // a second bus whose frames are written late
      out.disturbance = "order";
      const double late_s =
          std::min(std::pow(10.0, uniform(random, -3.0, 0.6)), 0.2 * (out.true_s.back() - out.true_s.front()));
      std::vector<std::pair<double, std::size_t>> written;
      for (std::size_t k = 0; k < size; ++k) written.push_back({out.true_s[k] + (k % 3 == 1 ? late_s : 0.0), k});
      std::stable_sort(written.begin(), written.end());
      for (const auto& [when, line] : written) out.frames.push_back({out.true_s[line], line});
      return out;
    }
    case 2: {  // single stamps of nowhere
      out.disturbance = "single stamps";
      constexpr double kWrong[] = {0.0, 1e9, 1e308, -5.0, 3e9};
      for (int k = 0; k < 5; ++k) {
        const std::size_t line = somewhere();
        const auto at = out.wrong.begin() + static_cast<long>(line);
        const bool near_another = std::find(at - 10, at + 10, true) != at + 10;
        if (near_another || std::abs(kWrong[k] - out.true_s[line]) < 100.0) continue;
        stamp_s[line] = kWrong[k];
        out.wrong[line] = true;
      }
      break;
    }
    case 3: {  // set back for good
      out.disturbance = "set back";
      out.joint = somewhere();
      const double by_s = uniform(random, 20.0, 4000.0);
      for (std::size_t k = out.joint; k < size; ++k) stamp_s[k] -= by_s;
      break;
    }
    case 4: {  // set ahead after boot
      out.disturbance = "set ahead";
      out.joint = somewhere();
      for (std::size_t k = 0; k < size; ++k) stamp_s[k] += (k < out.joint ? 0.0 : 1.7e9) - begin_s;
      break;
    }
    default: {  // a counter of 32 bits of us
      out.disturbance = "wrap";
      constexpr double kWidth = 4294.967296;
      const double whole_s = out.true_s.back() - out.true_s.front();  // a first frame before the wrap stands alone
      const double offset_s = kWidth - uniform(random, 0.05 * whole_s, whole_s);
      for (std::size_t k = 0; k < size; ++k) stamp_s[k] = std::fmod(out.true_s[k] - out.true_s[0] + offset_s, kWidth);
      break;
    }
  }
  for (std::size_t k = 0; k < size; ++k) out.frames.push_back({stamp_s[k], k});
  return out;
}

/// Nothing lost but what is wrong, everything in order, time between frames as it was.
std::string fault(const Recording& recording, const Result& result) {
  const std::size_t wrong = static_cast<std::size_t>(std::count(recording.wrong.begin(), recording.wrong.end(), true));
  if (result.order.size() + left_out(result) != recording.frames.size()) return "frames are lost or counted twice";
  if (left_out(result) != wrong) return fmt::format("{} left out, {} wrong", left_out(result), wrong);
  double before_s = -1e300;
  std::size_t before = recording.frames.size();
  for (const std::size_t line : result.order) {
    if (recording.wrong[line]) return fmt::format("the wrong stamp in line {} is used", line);
    if (result.time_s[line] < before_s) return fmt::format("line {} goes back", line);
    const bool joint = recording.joint > 0 && line == recording.joint;
    if (before < recording.frames.size() && !joint) {
      const double expected = recording.true_s[line] - recording.true_s[before];
      if (std::abs(result.time_s[line] - before_s - expected) > 2e-6) return fmt::format("line {}: interval", line);
    }
    if (joint && result.time_s[line] - before_s > 5.0) return "the parts are far from each other";
    before_s = result.time_s[line];
    before = line;
  }
  return {};
}

}  // namespace

TEST_GROUP(FrameClock){};

TEST(FrameClock, WhateverIsWrongWithTheStampsNothingIsLostAndTimeRunsOn) {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  const unsigned seed = given != nullptr ? static_cast<unsigned>(std::atoi(given)) : std::random_device{}();
  Random random(seed);
  for (int k = 0; k < 200; ++k) {
    const Recording recording = drawn_recording(random);
    const std::string found = fault(recording, clocked(recording.frames));
    if (!found.empty()) {
      FAIL(fmt::format("VOLTLAP_TEST_SEED={}, draw {} ({}): {}", seed, k, recording.disturbance, found).c_str());
    }
  }
}

TEST(FrameClock, ARecorderThatStartsAnewIsJoinedAndSaid) {
  std::vector<Stamped> frames;
  for (std::size_t k = 0; k < 200; ++k) frames.push_back({0.1 * static_cast<double>(k % 130) + 5.0 * (k < 130), k});
  const Result result = clocked(frames);
  LONGS_EQUAL(2, result.parts.size());
  CHECK(result.parts[1].begin == ClockPart::Begin::kAnew);
  LONGS_EQUAL(130, result.parts[1].first_line);
  DOUBLES_EQUAL(0.1, result.time_s[130] - result.time_s[129], 1e-3);
}

TEST(FrameClock, FramesFurtherBehindThanTheWindowAreLeftOutAndCounted) {
  std::vector<Stamped> frames;
  for (std::size_t k = 0; k < 100; ++k) {
    frames.push_back({100.0 + 0.1 * static_cast<double>(k) - (k % 2 ? 0.0 : 20.0), k});
  }
  const Result result = clocked(frames);
  // The first of them lies before all others and is no frame out of order.
  CHECK(count(result, "time far behind the frames around it") >= 49);
  LONGS_EQUAL(100, result.order.size() + left_out(result));
}

TEST(FrameClock, ALongSilenceIsAGapAndNoNewPart) {
  const Result result = clocked({{0.0, 0}, {1.0, 1}, {2.0, 2}, {7202.0, 3}, {7203.0, 4}});
  LONGS_EQUAL(1, result.parts.size());
  DOUBLES_EQUAL(7203.0, result.time_s[4], 1e-9);
}

TEST(FrameClock, SlowSendersAreNeverTakenForWrongStamps) {
  for (double period_s = 0.001; period_s < 2e3; period_s *= 1.17) {
    std::vector<Stamped> frames;
    for (std::size_t k = 0; k < 50; ++k) frames.push_back({period_s * static_cast<double>(k), k});
    const Result result = clocked(frames);
    LONGS_EQUAL(50, result.order.size());
    DOUBLES_EQUAL(49 * period_s, result.time_s[49], 1e-9);
  }
}

TEST(FrameClock, AStampOfAMinuteTurnsAndOneOfSixteenBitsIsTold) {
  for (const double width_s : {60.0, 65.536}) {
    std::vector<Stamped> frames;
    for (std::size_t k = 0; k < 3000; ++k) frames.push_back({std::fmod(0.1 * static_cast<double>(k), width_s), k});
    const Result result = clocked(frames, 60.0);
    DOUBLES_EQUAL(299.9, result.time_s[2999], 1e-6);
  }
}

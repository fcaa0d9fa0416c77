// SPDX-License-Identifier: Apache-2.0
// Drawn recordings, played to a sink of the test on a clock of the test: what is sent is what should be, when it
// should.
#include "io/play/player.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "closed_loop/drawn.hpp"
#include "io/play/play_list.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr std::int64_t kMicrosecond_ns = 1000, kMillisecond_ns = 1'000'000;

struct Drawing {
  std::int64_t at_us = 0;
  std::string bus, text;  ///< as candump writes it: identifier, mark and data
  std::uint32_t id = 0;
};

struct SentFrame {
  std::int64_t at_ns = 0;
  std::string text;
};

/// Wakes late by a drawn time; sending takes none.
class LateClock final : public PlayClock {
 public:
  LateClock(Drawn& drawn, int worst_us) : drawn_(drawn), worst_us_(worst_us) {}
  std::int64_t now_ns() override { return now_ns_; }
  void sleep_until(std::int64_t at_ns) override {
    CHECK(at_ns > now_ns_);
    longest_ns = std::max(longest_ns, at_ns - now_ns_);
    now_ns_ = at_ns + kMicrosecond_ns * drawn_.whole(0, worst_us_);
  }
  std::int64_t longest_ns = 0;

 private:
  Drawn& drawn_;
  int worst_us_;
  std::int64_t now_ns_ = 77'000'000'123;
};

std::string candump_text(const PlayFrame& frame) {
  const bool extended = (frame.id & RecordedFrame::kExtendedFlag) != 0;
  char id[16];
  std::snprintf(id, sizeof id, extended ? "%08X" : "%03X", frame.id & ~RecordedFrame::kExtendedFlag);
  std::string out = std::string(id) + "#";
  if (frame.remote) return out + "R" + std::to_string(frame.length);
  if (frame.flexible) out += "#" + std::to_string(frame.flags);
  for (int k = 0; k < frame.length; ++k) {
    char byte[4];
    std::snprintf(byte, sizeof byte, "%02X", frame.data[k]);
    out += byte;
  }
  return out;
}

class Sink final : public PlaySink {
 public:
  explicit Sink(PlayClock& clock) : clock_(clock) {}
  void send(const PlayFrame& frame) override {
    if (sent.size() == breaks_after) throw std::runtime_error("gone");
    sent.push_back({clock_.now_ns(), candump_text(frame)});
  }
  std::vector<SentFrame> sent;
  std::size_t breaks_after = static_cast<std::size_t>(-1);

 private:
  PlayClock& clock_;
};

std::string hex_bytes_of(Drawn& drawn, int length) {
  std::string out;
  for (int k = 0; k < 2 * length; ++k) out += "0123456789ABCDEF"[drawn.whole(0, 15)];
  return out;
}

Drawing drawn_frame(Drawn& drawn, std::int64_t at_us) {
  constexpr int kLengths[] = {0, 8, 12, 16, 20, 24, 32, 48, 64};
  Drawing out;
  out.at_us = at_us;
  out.bus = drawn.chance(0.3) ? "can1" : "can0";
  const bool extended = drawn.chance(0.3);
  out.id = static_cast<std::uint32_t>(extended ? drawn.whole(0x18FF0000, 0x18FF0003) : drawn.whole(0x100, 0x10F));
  char id[16];
  std::snprintf(id, sizeof id, extended ? "%08X#" : "%03X#", out.id);
  if (extended) out.id |= RecordedFrame::kExtendedFlag;
  out.text = id;
  if (drawn.chance(0.1)) {
    out.text += "R" + std::to_string(drawn.whole(0, 8));
  } else if (drawn.chance(0.2)) {
    out.text += "#" + std::to_string(drawn.whole(0, 3)) + hex_bytes_of(drawn, kLengths[drawn.whole(0, 8)]);
  } else {
    out.text += hex_bytes_of(drawn, drawn.whole(0, 8));
  }
  return out;
}

std::vector<Drawing> drawn_recording(Drawn& drawn) {
  constexpr int kGaps_us[] = {0, 0, 130, 1000, 10'000, 400'000};
  std::vector<Drawing> out;
  std::int64_t at_us = drawn.chance(0.5) ? 1'700'000'000'000'000 : 0;
  const int frames = drawn.whole(2, 300);
  for (int k = 0; k < frames; ++k, at_us += kGaps_us[drawn.whole(0, 5)]) out.push_back(drawn_frame(drawn, at_us));
  return out;
}

std::string candump_of(const std::vector<Drawing>& frames) {
  std::string out;
  for (const Drawing& frame : frames) {
    char stamp[40];
    std::snprintf(stamp, sizeof stamp, "(%lld.%06lld) ", static_cast<long long>(frame.at_us / 1'000'000),
                  static_cast<long long>(frame.at_us % 1'000'000));
    out += stamp + frame.bus + " " + frame.text + "\n";
  }
  return out;
}

FrameChoice drawn_choice(Drawn& drawn, const std::vector<Drawing>& frames) {
  FrameChoice out;
  const double span_s = 1e-6 * static_cast<double>(frames.back().at_us - frames.front().at_us);
  // Half a microsecond beside every stamp: none is drawn on an edge.
  const auto edge = [&](double share) { return std::floor(1e6 * share * span_s) * 1e-6 + 0.5e-6; };
  if (drawn.chance(0.5)) out.from_s = edge(drawn.between(0.0, 0.5));
  if (drawn.chance(0.5)) out.to_s = edge(drawn.between(0.5, 1.0));
  if (drawn.chance(0.5)) out.ids = {{0x104, 0x10A}, {0x18FF0001U | RecordedFrame::kExtendedFlag,
                                                     0x18FF0001U | RecordedFrame::kExtendedFlag}};
  out.channel = drawn.chance(0.7) ? "can0" : "can1";
  return out;
}

/// What the choice should come to, by the drawing alone.
std::vector<Drawing> wanted(const std::vector<Drawing>& frames, const FrameChoice& choice) {
  std::vector<Drawing> out;
  for (const Drawing& frame : frames) {
    const double time_s = 1e-6 * static_cast<double>(frame.at_us - frames.front().at_us);
    const bool id = choice.ids.empty() || (frame.id >= 0x104 && frame.id <= 0x10A) ||
                    frame.id == (0x18FF0001U | RecordedFrame::kExtendedFlag);
    if (id && frame.bus == choice.channel && time_s >= choice.from_s && time_s <= choice.to_s) out.push_back(frame);
  }
  return out;
}

PlayList list_of(const std::string& path, const FrameChoice& choice) {
  CanReading reading;
  reading.keep_remote = true;
  CanRecording recording(path, reading);
  return read_play_list(recording, path, choice, [](std::size_t) {}).frames;
}

}  // namespace

TEST_GROUP(Player) {
  Scratch scratch;

  void check_played(const std::vector<SentFrame>& sent, const std::vector<Drawing>& frames, const PlayPlan& plan,
                    std::int64_t round_ns, int worst_us, const char* drawn) {
    LONGS_EQUAL_TEXT(frames.size() * plan.rounds, sent.size(), drawn);
    std::int64_t least_ns = 1'000'000'000'000;
    std::vector<std::int64_t> off_ns;
    for (std::size_t k = 0; k < sent.size(); ++k) {
      const Drawing& frame = frames[k % frames.size()];
      STRCMP_EQUAL_TEXT(frame.text.c_str(), sent[k].text.c_str(), drawn);
      CHECK_TEXT(k == 0 || sent[k].at_ns >= sent[k - 1].at_ns, drawn);
      if (plan.speed == 0.0) continue;
      const auto round = static_cast<std::int64_t>(k / frames.size());
      const double recorded_ns = static_cast<double>(1000 * (frame.at_us - frames.front().at_us) + round * round_ns);
      off_ns.push_back(sent[k].at_ns - std::llround(recorded_ns / plan.speed));
      least_ns = std::min(least_ns, off_ns.back());
    }
    // No frame is farther off than one sleep is late, however many came before it: nothing adds up.
    for (const std::int64_t off : off_ns) CHECK_TEXT(off - least_ns <= kMicrosecond_ns * (worst_us + 1), drawn);
  }
};

TEST(Player, DrawnRecordingsAreSentWholeInOrderAndInTime) {
  const std::uint64_t seed = drawn_seed();
  Drawn drawn(seed);
  int played = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const std::string name = "VOLTLAP_TEST_SEED=" + std::to_string(seed) + ", trial " + std::to_string(trial);
    const std::vector<Drawing> recording = drawn_recording(drawn);
    const FrameChoice choice = drawn_choice(drawn, recording);
    const std::vector<Drawing> frames = wanted(recording, choice);
    const std::string path = scratch.write("drawn.log", candump_of(recording));
    if (frames.empty()) {
      CHECK_TEXT(complaint([&] { static_cast<void>(list_of(path, choice)); }) != "no error", name.c_str());
      continue;
    }
    const PlayList list = list_of(path, choice);
    constexpr double kSpeeds[] = {0.0, 0.5, 1.0, 1.0, 7.3};
    PlayPlan plan{kSpeeds[drawn.whole(0, 4)], 1};
    if (list.round_ns() > 0) plan.rounds = static_cast<std::uint64_t>(drawn.whole(1, 3));
    const int worst_us = drawn.whole(0, 3000);
    LateClock clock(drawn, worst_us);
    Sink sink(clock);
    Player player(list, plan, clock, sink);
    player.run([] { return false; });
    check_played(sink.sent, frames, plan, list.round_ns(), worst_us, name.c_str());
    LONGS_EQUAL_TEXT(plan.rounds, player.result().rounds, name.c_str());
    LONGS_EQUAL_TEXT(sink.sent.size(), player.result().sent, name.c_str());
    CHECK_TEXT(clock.longest_ns <= 100 * kMillisecond_ns, name.c_str());  // a stop is seen meanwhile
    ++played;
  }
  CHECK(played > 50);
}

TEST(Player, FramesOfSeveralBusesAreRefusedByName) {
  const std::string path = scratch.write("a.log", "(1.0) can0 044#00\n(1.1) can1 045#00\n");
  STRCMP_CONTAINS("frames of can0, can1", complaint([&] { static_cast<void>(list_of(path, {})); }).c_str());
  FrameChoice choice;
  choice.channel = "can7";
  STRCMP_CONTAINS("one of can0, can1", complaint([&] { static_cast<void>(list_of(path, choice)); }).c_str());
  choice.channel = "can1";
  LONGS_EQUAL(1, list_of(path, choice).size());
  choice.channel = "";
  choice.ids = {{0x44, 0x44}};
  LONGS_EQUAL(1, list_of(path, choice).size());
}

TEST(Player, IdentifiersThatAreNotThereAreNamed) {
  const std::string path = scratch.write("a.log", "(1.0) can0 044#00\n(1.1) can0 045#00\n");
  CanRecording recording(path);
  FrameChoice choice;
  choice.ids = {{0x44, 0x44}, {0x50, 0x5F}};
  const ReadPlayList read = read_play_list(recording, path, choice, [](std::size_t) {});
  LONGS_EQUAL(1, read.absent.size());
  LONGS_EQUAL(0x50, read.absent[0].first);
}

TEST(Player, ARoundBeginsAMeanIntervalBehindTheLastFrame) {
  const std::string path = scratch.write("a.log", "(1.0) c 044#00\n(1.01) c 044#01\n(1.03) c 044#02\n");
  LONGS_EQUAL(45 * kMillisecond_ns, list_of(path, {}).round_ns());
  FrameChoice choice;
  choice.to_s = 0.001;
  LONGS_EQUAL(0, list_of(path, choice).round_ns());
}

TEST(Player, WhatWasSentIsToldWhenItIsStoppedOrTheBusGoes) {
  const std::string path = scratch.write("a.log", "(1.0) c 044#00\n(1.01) c 044#01\n(1.03) c 044#02\n");
  const PlayList list = list_of(path, {});
  Drawn drawn(1);
  LateClock clock(drawn, 0);
  Sink stopped(clock), broken(clock);
  Player endless(list, {1.0, 0}, clock, stopped);
  endless.run([&] { return stopped.sent.size() == 7; });
  LONGS_EQUAL(7, endless.result().sent);
  LONGS_EQUAL(2, endless.result().rounds);
  LONGS_EQUAL(90 * kMillisecond_ns, endless.result().planned_ns);
  broken.breaks_after = 2;
  Player breaking(list, {1.0, 1}, clock, broken);
  CHECK_THROWS(std::runtime_error, breaking.run([] { return false; }));
  LONGS_EQUAL(2, breaking.result().sent);
  LONGS_EQUAL(0, breaking.result().rounds);
}

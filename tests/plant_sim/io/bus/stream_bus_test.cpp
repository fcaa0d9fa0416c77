// SPDX-License-Identifier: Apache-2.0
// The plant's side of a stream against a board of the test's, which says what the test has written ahead.
#include "io/bus/stream_bus.hpp"

#include <unistd.h>

#include <cstring>
#include <deque>
#include <string>
#include <vector>

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

namespace {

struct Ends {
  int read = -1, write = -1;
  Ends() {
    int ends[2];
    CHECK(::pipe(ends) == 0);
    read = ends[0];
    write = ends[1];
  }
  ~Ends() {
    if (read >= 0) ::close(read);
    if (write >= 0) ::close(write);
  }
  void close_write() {
    ::close(write);
    write = -1;
  }
};

/// Nodes in this process, for those that a board does not have.
struct Inside final : Ecus {
  std::vector<std::uint32_t> bms_heard, master_heard;
  void bms(Instant, FrameView rx, TxQueue& tx) override {
    bms_heard.clear();
    for (const Frame& frame : rx) bms_heard.push_back(frame.id);
    CHECK(tx.push({0x0C0, 1, {1}}));
  }
  void master(Instant, FrameView rx, TxQueue& tx) override {
    master_heard.clear();
    for (const Frame& frame : rx) master_heard.push_back(frame.id);
    CHECK(tx.push({0x0D0, 1, {1}}));
  }
};

struct Recorder final : FrameSink {
  std::vector<std::pair<Sender, std::uint32_t>> seen;
  void on_frame(std::uint32_t, Sender sender, const Frame& frame) override { seen.emplace_back(sender, frame.id); }
};

}  // namespace

TEST_GROUP(StreamBus) {
  Ends to_board, from_board;
  Inside inside;
  std::deque<BoardStream> boards;

  BoardStream& board() { return boards.back(); }
  StreamBus bus(double answer_within_s = 5.0) {
    boards.emplace_back(StreamOptions{.to_ecu = to_board.write,
                                      .from_ecu = from_board.read,
                                      .answer_within_s = answer_within_s,
                                      .what_became_of_it = [] { return std::string("has gone for the test"); }});
    return StreamBus(board(), inside);
  }
  void say(const void* bytes, std::size_t count) {
    LONGS_EQUAL(static_cast<long>(count), ::write(from_board.write, bytes, count));
  }
  void say(const Frame& frame) {
    std::uint8_t bytes[port::kFrameBytes];
    port::frame_to_bytes(frame, bytes);
    say(bytes, sizeof bytes);
  }
  void greet(bool has_bms, bool has_master) {
    port::Greeting greeting;
    greeting.has_bms = has_bms;
    greeting.has_master = has_master;
    say(&greeting, sizeof greeting);
  }
  template <class Done>
  void done(std::uint32_t tick, std::uint16_t frames) {
    Done m;
    m.tick = tick;
    m.frames_sent = frames;
    Frame frame;
    encode(m, frame);
    say(frame);
  }
  std::string failure(const std::function<void()>& action) {
    try {
      action();
    } catch (const BusFailure& error) {
      return error.what();
    }
    return "none";
  }
  TxQueue plant_frames() {
    TxQueue tx;
    CHECK(tx.push({0x0B0, 1, {7}}));
    return tx;
  }
  std::vector<Frame> heard_by_board() {
    std::uint8_t bytes[1024];
    const ssize_t got = ::read(to_board.read, bytes, sizeof bytes);
    std::vector<Frame> frames(static_cast<std::size_t>(got) / port::kFrameBytes);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      CHECK(port::frame_from_bytes(bytes + i * port::kFrameBytes, frames[i]));
    }
    return frames;
  }
};

TEST(StreamBus, BothNodesOfABoardAreToldApartByTheirDone) {
  StreamBus bus = this->bus();
  Recorder recorder;
  bus.attach(recorder);
  greet(true, true);
  LONGS_EQUAL(1, board().await_greeting().has_master);
  static_cast<void>(bus.begin_tick(3));
  can::ReadyBms ready;
  Frame frame;
  encode(ready, frame);
  say(frame);
  say({0x0C0, 1, {1}});
  done<can::DoneBms>(3, 1);
  say({0x0D0, 1, {1}});
  done<can::DoneMaster>(3, 1);
  const FrameView back = bus.exchange(plant_frames());
  LONGS_EQUAL(2, back.count);
  LONGS_EQUAL(3, recorder.seen.size());
  CHECK(recorder.seen[1] == std::pair(Sender::kBms, std::uint32_t{0x0C0}));
  CHECK(recorder.seen[2] == std::pair(Sender::kMaster, std::uint32_t{0x0D0}));
  const auto heard = heard_by_board();
  LONGS_EQUAL(2, heard.size());
  can::Sync sync;
  CHECK(decode(heard[1], sync));
  LONGS_EQUAL(3, sync.tick);
}

TEST(StreamBus, ANodeThatTheBoardDoesNotHaveIsSteppedHereInItsTurn) {
  {
    StreamBus bus = this->bus();
    greet(true, false);
    static_cast<void>(board().await_greeting());
    for (std::uint32_t tick = 0; tick < 2; ++tick) {
      static_cast<void>(bus.begin_tick(tick));
      say({0x0C1, 1, {1}});
      done<can::DoneBms>(tick, 1);
      static_cast<void>(bus.exchange(plant_frames()));
      CHECK((inside.master_heard == std::vector<std::uint32_t>{0x0B0, 0x0C1}));
    }
    const auto heard = heard_by_board();  // the second batch begins with what the master sent in the first tick
    LONGS_EQUAL(5, heard.size());
    LONGS_EQUAL(0x0D0, heard[2].id);
  }
  StreamBus bus = this->bus();
  greet(false, true);
  static_cast<void>(board().await_greeting());
  static_cast<void>(bus.begin_tick(0));
  done<can::DoneMaster>(0, 0);
  static_cast<void>(bus.exchange(plant_frames()));
  CHECK((inside.bms_heard == std::vector<std::uint32_t>{0x0B0}));
  LONGS_EQUAL(0x0C0, heard_by_board()[1].id);
}

TEST(StreamBus, WhatIsNoGreetingIsAFailure) {
  StreamBus bus = this->bus();
  const std::uint8_t bytes[sizeof(port::Greeting)] = {1, 2, 3};
  say(bytes, sizeof bytes);
  STRCMP_CONTAINS("does not greet", failure([&] { static_cast<void>(board().await_greeting()); }).c_str());
  CHECK(board().failed());
}

TEST(StreamBus, TheGreetingOfAnEarlierImageIsAFailureAtOnceHoweverShortItIs) {
  StreamBus bus = this->bus();
  const std::uint32_t earlier[7] = {0x3248'4C56};  // "VLH2", 28 bytes
  say(earlier, sizeof earlier);
  STRCMP_CONTAINS("does not greet", failure([&] { static_cast<void>(board().await_greeting()); }).c_str());
}

TEST(StreamBus, ABoardThatIsGoneIsAFailureThatSaysWhatBecameOfItAndWhen) {
  StreamBus bus = this->bus();
  greet(true, true);
  static_cast<void>(board().await_greeting());
  static_cast<void>(bus.begin_tick(123));
  from_board.close_write();
  const std::string said = failure([&] { static_cast<void>(bus.exchange(plant_frames())); });
  STRCMP_CONTAINS("has gone for the test (tick 123, 1.23 s after power-on)", said.c_str());
}

TEST(StreamBus, ABoardThatIsSilentIsAFailureAfterTheTimeThatWasGiven) {
  StreamBus bus = this->bus(0.2);
  greet(true, true);
  static_cast<void>(board().await_greeting());
  static_cast<void>(bus.begin_tick(0));
  STRCMP_CONTAINS("has not answered for 0.2 s",
                  failure([&] { static_cast<void>(bus.exchange(plant_frames())); }).c_str());
}

TEST(StreamBus, AnAnswerToAnotherTickAndWhatIsNoFrameAreFailures) {
  StreamBus late = this->bus();
  greet(true, true);
  static_cast<void>(board().await_greeting());
  static_cast<void>(late.begin_tick(5));
  done<can::DoneBms>(4, 0);
  STRCMP_CONTAINS("answers tick 4 instead of 5",
                  failure([&] { static_cast<void>(late.exchange(plant_frames())); }).c_str());
  StreamBus garbled = this->bus();
  greet(true, true);
  static_cast<void>(board().await_greeting());
  static_cast<void>(garbled.begin_tick(0));
  const std::vector<std::uint8_t> noise(port::kFrameBytes, 0xA5);
  say(noise.data(), noise.size());
  STRCMP_CONTAINS("no frame", failure([&] { static_cast<void>(garbled.exchange(plant_frames())); }).c_str());
}

TEST(StreamBus, CountsOfStepsAddUpAndTheStackComesAtTheEnd) {
  StreamBus bus = this->bus();
  greet(true, true);
  static_cast<void>(board().await_greeting());
  for (std::uint32_t tick = 0; tick < 2; ++tick) {
    static_cast<void>(bus.begin_tick(tick));
    for (const can::Member member : {can::Member::kBms, can::Member::kMaster}) {
      can::StepCost cost;
      cost.member = member;
      cost.instructions = (member == can::Member::kBms ? 1'000U : 100U) * (tick + 1);
      Frame frame;
      encode(cost, frame);
      say(frame);
    }
    done<can::DoneBms>(tick, 0);
    done<can::DoneMaster>(tick, 0);
    static_cast<void>(bus.exchange(plant_frames()));
  }
  can::StackUse use;
  use.used = 900;
  use.size = 4096;
  Frame frame;
  encode(use, frame);
  say(frame);
  board().stop();
  const BoardAccount& account = board().account();
  LONGS_EQUAL(3'000, account.bms.instructions);
  LONGS_EQUAL(2'000, account.bms.worst);
  LONGS_EQUAL(1, account.bms.worst_tick);
  LONGS_EQUAL(2'200, account.both.worst);
  LONGS_EQUAL(900, account.stack_used);
}

TEST(StreamBus, ABoardThatIsResetIsHandedItsNodesAgain) {
  StreamBus bus = this->bus();
  const std::uint32_t config[2] = {1, 2};
  for (int start = 0; start < 2; ++start) {
    if (start > 0) board().reset();
    greet(true, true);
    static_cast<void>(board().await_greeting());
    board().configure(std::as_bytes(std::span(config, 1)), std::as_bytes(std::span(config + 1, 1)), 7,
                      {.bms = false, .master = true});
    CHECK_FALSE(board().nodes().bms);
  }
  std::uint8_t bytes[256];
  constexpr std::size_t kConfiguration = sizeof(port::ConfigurationHead) + sizeof config;
  LONGS_EQUAL(2 * kConfiguration + port::kFrameBytes, ::read(to_board.read, bytes, sizeof bytes));
  Frame frame;
  can::MemberReset reset;
  CHECK(port::frame_from_bytes(bytes + kConfiguration, frame) && decode(frame, reset));
  CHECK(reset.member == can::Member::kMaster);
}

TEST(StreamBus, ARunThatEndsBeforeItsFirstTickEndsWell) {
  StreamBus bus = this->bus();
  greet(true, true);
  static_cast<void>(board().await_greeting());
  can::ReadyBms ready;
  can::StackUse use;
  use.used = 500;
  Frame frame;
  encode(ready, frame);
  say(frame);
  encode(use, frame);
  say(frame);
  board().stop();
  LONGS_EQUAL(500, board().account().stack_used);
}

// SPDX-License-Identifier: Apache-2.0
// A board in lockstep against a plant of the test's: what it writes, byte for byte, and what it makes of each batch.
#include "port/lockstep/lockstep_port.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "port/lockstep/greeting.hpp"
#include "port/lockstep/simulated_board.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::port;

namespace {

/// The end of a run, which never returns on a board.
struct Ended {
  bool good;
};

/// The reset of a board, which never returns either.
struct Restarted {};

/// Gives what the test has put in, `step` bytes at a time, and keeps what comes out.
class FakeRig final : public Rig {
 public:
  std::vector<std::uint8_t> in, out;
  std::size_t step = 4096;
  bool counting = false;
  mutable std::uint32_t counted = 0;

  std::size_t read(std::uint8_t* bytes, std::size_t capacity) override {
    const std::size_t count = std::min({capacity, step, in.size()});
    std::copy_n(in.begin(), count, bytes);
    in.erase(in.begin(), in.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  bool write(const std::uint8_t* bytes, std::size_t count) override {
    ++writes;
    out.insert(out.end(), bytes, bytes + count);
    return !closed;
  }
  [[nodiscard]] bool counts() const override { return counting; }
  [[nodiscard]] std::uint32_t instructions() const override { return counted += 40; }
  [[nodiscard]] std::uint32_t stack_used() const override { return 1'200; }
  [[nodiscard]] std::uint32_t stack_size() const override { return 4'096; }
  [[noreturn]] void restart() override { throw Restarted{}; }
  [[noreturn]] void end(bool good) override { throw Ended{good}; }

  int writes = 0;
  bool closed = false;
};

constexpr ImageInfo kBoth{kImageMark, 144, true, true, 7, 8, "test", "0"};
constexpr ImageInfo kBmsAlone{kImageMark, 24, true, false, 7, 8, "test", "0"};
constexpr ImageInfo kMasterAlone{kImageMark, 24, false, true, 7, 8, "test", "0"};

Frame frame_of(std::uint32_t id) { return {id, 2, {1, 2}}; }

TxQueue queue(std::size_t count) {
  TxQueue out;
  for (std::size_t i = 0; i < count; ++i) CHECK(out.push(frame_of(0x100 + static_cast<std::uint32_t>(i))));
  return out;
}

}  // namespace

TEST_GROUP(LockstepPort) {
  FakeRig rig;

  void put(const Frame& frame) {
    std::uint8_t bytes[kFrameBytes];
    frame_to_bytes(frame, bytes);
    rig.in.insert(rig.in.end(), bytes, bytes + kFrameBytes);
  }
  void put_sync(std::uint32_t tick, bool stop = false) {
    can::Sync sync;
    sync.tick = tick;
    sync.stop = stop;
    Frame frame;
    encode(sync, frame);
    put(frame);
  }
  std::vector<Frame> written(std::size_t from = 0) {
    std::vector<Frame> frames;
    for (std::size_t at = from; at + kFrameBytes <= rig.out.size(); at += kFrameBytes) {
      Frame frame;
      CHECK(frame_from_bytes(rig.out.data() + at, frame));
      frames.push_back(frame);
    }
    return frames;
  }
  bool ends_good(LockstepPort& port) {
    try {
      port.sleep_until({});
    } catch (const Ended& ended) {
      return ended.good;
    }
    FAIL("it has not ended");
    return false;
  }
};

TEST(LockstepPort, GreetsAndIsReadyBeforeTheFirstTick) {
  LockstepPort port(rig, kBoth);
  port.greet(nullptr, 0, nullptr, 0, 36);
  LONGS_EQUAL(sizeof(Greeting), rig.out.size());
  Greeting greeting;
  std::memcpy(&greeting, rig.out.data(), sizeof greeting);
  LONGS_EQUAL(kGreetingMark, greeting.mark);
  LONGS_EQUAL(7, greeting.config_layout);
  LONGS_EQUAL(8, greeting.node_sources);
  LONGS_EQUAL(0, greeting.bms_config_bytes);
  LONGS_EQUAL(144, greeting.cells_max);
  put_sync(0);
  port.sleep_until({});
  const auto frames = written(sizeof(Greeting));
  LONGS_EQUAL(2, frames.size());
  LONGS_EQUAL(can::ReadyBms::kId, frames[0].id);
  LONGS_EQUAL(can::ReadyMaster::kId, frames[1].id);
}

TEST(LockstepPort, SaysWhoseConfigurationItHas) {
  ImageInfo image = kBoth;
  image.bms_number = 0x1234'5678;
  image.master_number = 0x9ABC'DEF0;
  image.cells_in_series = 60;
  std::memcpy(image.car, "ours", 5);
  LockstepPort port(rig, image);
  port.greet(nullptr, 0, nullptr, 0, 36);
  Greeting greeting;
  std::memcpy(&greeting, rig.out.data(), sizeof greeting);
  LONGS_EQUAL(0x1234'5678, greeting.bms_number);
  UNSIGNED_LONGS_EQUAL(0x9ABC'DEF0, greeting.master_number);
  LONGS_EQUAL(60, greeting.cells_in_series);
  STRCMP_EQUAL("ours", greeting.car);
}

TEST(LockstepPort, TakesAConfigurationInPieces) {
  std::uint32_t bms[3] = {}, master[2] = {};
  const std::uint32_t sent[5] = {1, 2, 3, 4, 5};
  const ConfigurationHead head{kConfigurationMark, 7, sizeof bms, sizeof master};
  const auto* first = reinterpret_cast<const std::uint8_t*>(&head);
  rig.in.assign(first, first + sizeof head);
  const auto* numbers = reinterpret_cast<const std::uint8_t*>(sent);
  rig.in.insert(rig.in.end(), numbers, numbers + sizeof sent);
  rig.step = 3;
  LockstepPort port(rig, kBoth);
  port.greet(bms, sizeof bms, master, sizeof master, 36);
  LONGS_EQUAL(3, bms[2]);
  LONGS_EQUAL(5, master[1]);
}

TEST(LockstepPort, RefusesAConfigurationOfAnotherLayoutOrSize) {
  std::uint32_t bms = 0, master = 0;
  const ConfigurationHead heads[] = {{kConfigurationMark, 8, 4, 4}, {kConfigurationMark, 7, 8, 4},
                                     {kConfigurationMark, 7, 4, 8}, {kConfigurationMark + 1, 7, 4, 4},
                                     {kConfigurationMark, 7, 4, 4, 0, 0}};
  for (const ConfigurationHead& head : heads) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&head);
    rig.in.assign(bytes, bytes + sizeof head);
    rig.in.resize(rig.in.size() + 8);
    LockstepPort port(rig, kBoth);
    bool refused = false;
    try {
      port.greet(&bms, sizeof bms, &master, sizeof master, 36);
    } catch (const Ended& ended) {
      refused = !ended.good;
    }
    CHECK(refused);
  }
}

TEST(LockstepPort, ABoardOfBothNodesStepsTheOneThatThePlantWants) {
  std::uint32_t bms = 0, master = 0;
  const ConfigurationHead head{kConfigurationMark, 7, 4, 4, 0, 1};
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&head);
  rig.in.assign(bytes, bytes + sizeof head);
  rig.in.resize(rig.in.size() + 8);
  LockstepPort port(rig, kBoth);
  port.greet(&bms, sizeof bms, &master, sizeof master, 36);
  CHECK_FALSE(port.runs_bms());
  CHECK(port.runs_master());
  put_sync(0);
  put_sync(1);
  port.sleep_until({});
  CHECK(port.send(queue(1)));
  port.sleep_until({});
  const auto frames = written(sizeof(Greeting));
  LONGS_EQUAL(3, frames.size());
  LONGS_EQUAL(can::ReadyMaster::kId, frames[0].id);
  LONGS_EQUAL(can::DoneMaster::kId, frames[2].id);
}

TEST(LockstepPort, ALossOfTheSupplyIsAResetOfTheBoardAndNoTick) {
  LockstepPort port(rig, kBmsAlone);
  port.greet(nullptr, 0, nullptr, 0, 36);
  can::MemberReset reset;
  reset.member = can::Member::kBms;
  Frame frame;
  encode(reset, frame);
  put(frame);
  CHECK_THROWS(Restarted, port.sleep_until({}));
}

TEST(LockstepPort, ATickIsOneReadAndOneWriteInTheOrderOfTheBus) {
  LockstepPort port(rig, kBoth);
  port.greet(nullptr, 0, nullptr, 0, 36);
  put(frame_of(0x0B0));
  put(frame_of(0x0B1));
  put_sync(41);
  put_sync(42);
  port.sleep_until({});
  LONGS_EQUAL(410, port.now().ms());
  Frame inbox[8];
  LONGS_EQUAL(2, port.receive(inbox, 8));
  LONGS_EQUAL(0x0B1, inbox[1].id);
  const std::size_t before = rig.out.size();
  const int writes = rig.writes;
  CHECK(port.send(queue(2)));
  CHECK(port.send(queue(1)));
  LONGS_EQUAL(before, rig.out.size());
  port.sleep_until({});
  LONGS_EQUAL(writes + 1, rig.writes);
  const auto frames = written(sizeof(Greeting));
  LONGS_EQUAL(2 + 5, frames.size());
  LONGS_EQUAL(0x100, frames[2].id);
  can::DoneBms bms;
  can::DoneMaster master;
  CHECK(decode(frames[4], bms));
  CHECK(decode(frames[6], master));
  LONGS_EQUAL(41, bms.tick);
  LONGS_EQUAL(2, bms.frames_sent);
  LONGS_EQUAL(1, master.frames_sent);
}

TEST(LockstepPort, ABoardWithOneNodeSpeaksForThatNode) {
  for (const ImageInfo* image : {&kBmsAlone, &kMasterAlone}) {
    rig.out.clear();
    put_sync(0);
    put_sync(1);
    LockstepPort port(rig, *image);
    port.greet(nullptr, 0, nullptr, 0, 36);
    port.sleep_until({});
    Frame inbox[1];
    static_cast<void>(port.receive(inbox, 1));
    CHECK(port.send(queue(0)));
    port.sleep_until({});
    const auto frames = written(sizeof(Greeting));
    LONGS_EQUAL(2, frames.size());
    LONGS_EQUAL(image->has_bms ? can::ReadyBms::kId : can::ReadyMaster::kId, frames[0].id);
    LONGS_EQUAL(image->has_bms ? can::DoneBms::kId : can::DoneMaster::kId, frames[1].id);
  }
}

TEST(LockstepPort, FramesThatComeInPiecesAndMoreThanThereIsRoomForKeepTheTicks) {
  for (const std::size_t step : {1U, 7U, 16U, 4096U}) {
    rig.step = step;
    rig.in.clear();
    rig.out.clear();
    for (std::uint32_t i = 0; i < LockstepPort::kFramesInMax + 20; ++i) put(frame_of(i));
    put_sync(5);
    put(frame_of(0x700));
    put_sync(6);
    LockstepPort port(rig, kBmsAlone);
    port.greet(nullptr, 0, nullptr, 0, 36);
    port.sleep_until({});
    std::vector<Frame> inbox(2 * LockstepPort::kFramesInMax);
    LONGS_EQUAL(LockstepPort::kFramesInMax, port.receive(inbox.data(), inbox.size()));
    LONGS_EQUAL(0, port.receive(inbox.data(), inbox.size()));
    CHECK(port.send(queue(0)));
    port.sleep_until({});
    LONGS_EQUAL(60, port.now().ms());
    LONGS_EQUAL(1, port.receive(inbox.data(), inbox.size()));
    LONGS_EQUAL(0x700, inbox[0].id);
  }
}

TEST(LockstepPort, CountsAStepWhereSomebodyCounts) {
  rig.counting = true;
  put_sync(0);
  put_sync(1);
  LockstepPort port(rig, kBmsAlone);
  port.greet(nullptr, 0, nullptr, 0, 36);
  port.sleep_until({});
  Frame inbox[1];
  static_cast<void>(port.receive(inbox, 1));
  rig.counted += 12'000;
  CHECK(port.send(queue(0)));
  port.sleep_until({});
  can::StepCost cost;
  CHECK(decode(written(sizeof(Greeting))[1], cost));
  CHECK(cost.member == can::Member::kBms);
  LONGS_EQUAL(12'040, cost.instructions);
}

TEST(LockstepPort, TheEndOfARunTellsTheStackAndIsGood) {
  put_sync(9, true);
  LockstepPort port(rig, kBoth);
  port.greet(nullptr, 0, nullptr, 0, 36);
  CHECK(ends_good(port));
  can::StackUse use;
  CHECK(decode(written(sizeof(Greeting)).back(), use));
  LONGS_EQUAL(1'200, use.used);
  LONGS_EQUAL(4'096, use.size);
}

TEST(LockstepPort, APlantThatIsGoneOrSendsNoFramesEndsTheRunBadly) {
  {
    LockstepPort port(rig, kBoth);
    port.greet(nullptr, 0, nullptr, 0, 36);
    CHECK_FALSE(ends_good(port));  // nothing to read
  }
  rig.in.assign(kFrameBytes, 0xFF);
  LockstepPort port(rig, kBoth);
  port.greet(nullptr, 0, nullptr, 0, 36);
  CHECK_FALSE(ends_good(port));
  rig.closed = true;
  LockstepPort deaf(rig, kBoth);
  bool refused = false;
  try {
    deaf.greet(nullptr, 0, nullptr, 0, 36);
  } catch (const Ended& ended) {
    refused = !ended.good;
  }
  CHECK(refused);
}

TEST_GROUP(SimulatedBoard) {
  FakeRig rig;
};

TEST(SimulatedBoard, ItsMemoryKeepsEverySlotApartAndIsBlankBefore) {
  static RamNvm::Memory memory;
  RamNvm nvm(memory);
  CHECK(nvm.prepare());
  std::uint8_t read[4];
  nvm.read(NvmRecord::kSoc, 1, read, 4);
  for (const std::uint8_t byte : read) LONGS_EQUAL(0xFF, byte);
  const std::uint8_t trips[4] = {1, 2, 3, 4}, soc[4] = {5, 6, 7, 8};
  CHECK(nvm.write(NvmRecord::kTrips, 1, trips, 4) == NvmResult::kOk);
  CHECK(nvm.write(NvmRecord::kSoc, 0, soc, 4) == NvmResult::kOk);
  nvm.read(NvmRecord::kTrips, 1, read, 4);
  LONGS_EQUAL(4, read[3]);
  nvm.read(NvmRecord::kSoc, 0, read, 4);
  LONGS_EQUAL(8, read[3]);
  nvm.read(NvmRecord::kTrips, 0, read, 4);
  LONGS_EQUAL(0xFF, read[0]);
  std::vector<std::uint8_t> longer(RamNvm::kSlotBytes + 1);
  CHECK(nvm.write(NvmRecord::kSoc, 0, longer.data(), longer.size()) == NvmResult::kFailed);
  RamNvm after_reset(memory);
  after_reset.read(NvmRecord::kTrips, 1, read, 4);
  LONGS_EQUAL(4, read[3]);
}

TEST(SimulatedBoard, ItsWatchdogBitesInSimulatedTime) {
  struct FakeClock final : Clock {
    Instant at{};
    [[nodiscard]] Instant now() const override { return at; }
    void sleep_until(Instant until) override { at = until; }
  } clock;
  SimulatedWatchdog watchdog(clock, rig);
  watchdog.feed();  // sleeps
  CHECK(watchdog.start(Duration::from_ms(30)));
  clock.at = Instant::from_ms(30);
  watchdog.feed();
  clock.at = Instant::from_ms(61);
  bool bitten = false;
  try {
    watchdog.feed();
  } catch (const Ended& ended) {
    bitten = !ended.good;
  }
  CHECK(bitten);
}

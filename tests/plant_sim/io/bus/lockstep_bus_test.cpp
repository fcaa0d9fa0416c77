// SPDX-License-Identifier: Apache-2.0
// On the real vcan0, with members in threads that answer as a test tells them.
#include "io/bus/lockstep_bus.hpp"

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

#include "port/host/bus_error.hpp"
#include "port/host/lockstep_member.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;
using can::Member;
using port::Wake;

namespace {

constexpr double kLostAfter_s = 2.0;  // longer than a busy machine keeps a member that answers from doing it

/// Answers every tick with its frames until the plant stops.
class Answering {
 public:
  using Frames = std::function<TxQueue(std::uint32_t tick)>;

  Answering(Member member, Frames frames)
      : member_("vcan0", member, {port::only(0x0B0)}), frames_(std::move(frames)), thread_([this] { run(); }) {}
  ~Answering() {
    ended_ = true;
    thread_.join();
  }

  std::atomic<bool> silent{false};

 private:
  void run() {
    while (!ended_) {
      if (!member_.started()) member_.announce();
      const Wake wake = member_.wait();
      if (wake == Wake::kStop) return;
      if (wake == Wake::kStep && !silent) member_.done(frames_(member_.tick()));
    }
  }
  port::LockstepMember member_;
  Frames frames_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

Answering::Frames one(std::uint32_t id) {
  return [id](std::uint32_t tick) {
    TxQueue tx;
    static_cast<void>(tx.push({id, 8, {static_cast<std::uint8_t>(tick)}}));
    return tx;
  };
}

struct Seen : FrameSink {
  struct Row {
    std::uint32_t tick;
    Sender sender;
    std::uint32_t id;
    friend bool operator==(const Row&, const Row&) = default;
  };
  void on_frame(std::uint32_t tick, Sender sender, const Frame& frame) override {
    rows.push_back({tick, sender, frame.id});
  }
  std::vector<Row> rows;
};

template <class Message>
Frame framed(const Message& m) {
  Frame f;
  can::encode(m, f);
  return f;
}

std::string gather_error(LockstepBus& bus) {
  try {
    static_cast<void>(bus.await_members());
  } catch (const port::BusSetupError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_GROUP(LockstepBus) {
  LockstepOptions options{.interface = "vcan0", .members = {Member::kBms, Member::kMaster}, .lost_after_s = 30.0};
  port::SocketCan hand{"vcan0", {}};
  Seen seen;
  TxQueue plant;

  void setup() override { CHECK(plant.push({0x0B0, 8, {}})); }
  void send(const Frame& f) { hand.send(&f, 1); }
  std::vector<std::uint32_t> tick(LockstepBus & bus, std::uint32_t n) {
    bus.begin_tick(n);
    std::vector<std::uint32_t> ids;
    for (const Frame& f : bus.exchange(plant)) ids.push_back(f.id);
    return ids;
  }
};

TEST(LockstepBus, EveryTickIsPlantThenBmsThenMasterReadBackFromTheBus) {
  Answering bms(Member::kBms, one(0x0C0)), master(Member::kMaster, one(0x0C2));
  LockstepBus bus(options);
  bus.attach(seen);
  CHECK(bus.await_members());
  const std::vector<std::uint32_t> commands = {0x0C0, 0x0C2};
  for (std::uint32_t n = 0; n < 50; ++n) CHECK(commands == tick(bus, n));
  bus.stop();
  LONGS_EQUAL(150, bus.frames_sent());
  LONGS_EQUAL(3, bus.frames_in_tick_max());
  for (std::uint32_t n = 0; n < 50; ++n) {
    CHECK((seen.rows[3 * n] == Seen::Row{n, Sender::kPlant, 0x0B0}));
    CHECK((seen.rows[3 * n + 1] == Seen::Row{n, Sender::kBms, 0x0C0}));
    CHECK((seen.rows[3 * n + 2] == Seen::Row{n, Sender::kMaster, 0x0C2}));
  }
  CHECK(bus.lost().empty());
  LONGS_EQUAL(0, bus.statistics().missing_frames + bus.statistics().foreign_frames + bus.statistics().dropped_frames);
}

TEST(LockstepBus, SilentMasterIsLostAndItsDoneStoodInFor) {
  options.lost_after_s = kLostAfter_s;
  Answering bms(Member::kBms, one(0x0C0)), master(Member::kMaster, one(0x0C2));
  LockstepBus bus(options);
  CHECK(bus.await_members());
  LONGS_EQUAL(2, tick(bus, 0).size());
  master.silent = true;
  LONGS_EQUAL(1, tick(bus, 1).size());
  LONGS_EQUAL(1, bus.lost().size());
  STRCMP_EQUAL("master", bus.lost()[0].node.c_str());
  CHECK(bus.lost()[0].drives);
  for (std::uint32_t n = 2; n < 20; ++n) LONGS_EQUAL(1, tick(bus, n).size());
  bus.stop();
}

TEST(LockstepBus, SilentBmsIsLostAndTheMasterIsCalledInItsPlace) {
  options.lost_after_s = kLostAfter_s;
  Answering bms(Member::kBms, one(0x0C0)), master(Member::kMaster, one(0x0C2)),
      logger(Member::kLogger, [](auto) { return TxQueue{}; });
  options.members.push_back(Member::kLogger);
  LockstepBus bus(options);
  CHECK(bus.await_members());
  LONGS_EQUAL(2, tick(bus, 0).size());
  bms.silent = true;
  const std::vector<std::uint32_t> master_only = {0x0C2};
  for (std::uint32_t n = 1; n < 20; ++n) CHECK(master_only == tick(bus, n));
  LONGS_EQUAL(1, bus.lost().size());
  STRCMP_EQUAL("bms", bus.lost()[0].node.c_str());
  bus.stop();
}

TEST(LockstepBus, LostLoggerDoesNotDriveTheCar) {
  options.lost_after_s = kLostAfter_s;
  Answering bms(Member::kBms, one(0x0C0)), master(Member::kMaster, one(0x0C2)),
      logger(Member::kLogger, [](auto) { return TxQueue{}; });
  options.members.push_back(Member::kLogger);
  LockstepBus bus(options);
  CHECK(bus.await_members());
  logger.silent = true;
  for (std::uint32_t n = 0; n < 20; ++n) LONGS_EQUAL(2, tick(bus, n).size());
  LONGS_EQUAL(1, bus.lost().size());
  CHECK_FALSE(bus.lost()[0].drives);
  bus.stop();
}

TEST(LockstepBus, WordOfADeadProcessEndsTheWaitAtOnce) {
  Answering bms(Member::kBms, one(0x0C0)), master(Member::kMaster, one(0x0C2));
  LockstepBus bus(options);
  CHECK(bus.await_members());
  bms.silent = true;
  can::MemberLost lost;
  lost.member = Member::kBms;
  send(framed(lost));
  for (std::uint32_t n = 0; n < 5; ++n) LONGS_EQUAL(1, tick(bus, n).size());
  STRCMP_EQUAL("bms", bus.lost().at(0).node.c_str());
  bus.stop();
}

TEST(LockstepBus, AbsentMembersAreStoodInForWithoutBeingLost) {
  options.members = {Member::kMaster};
  Answering master(Member::kMaster, one(0x0C2));
  LockstepBus bus(options);
  CHECK(bus.await_members());
  for (std::uint32_t n = 0; n < 10; ++n) LONGS_EQUAL(1, tick(bus, n).size());
  CHECK(bus.lost().empty());
  bus.stop();
}

TEST(LockstepBus, OverrideHoldsFromItsTickAndFaultsActOnce) {
  options.members.clear();
  LockstepBus bus(options);
  CHECK(bus.await_members());
  tick(bus, 0);
  can::DriverOverride pedal;
  pedal.tick = 3;
  pedal.accelerator_ok = true;
  pedal.accelerator_ppm = 500'000;
  send(framed(pedal));
  pedal.tick = 6;
  pedal.accelerator_ok = false;
  send(framed(pedal));
  can::PlantFault fault;
  fault.fault = can::PlantFaultKind::kCellOffset;
  fault.tick = 4;
  fault.value = -120;
  send(framed(fault));
  tick(bus, 1);
  for (std::uint32_t n = 2; n < 8; ++n) {
    const Interventions& asked = bus.begin_tick(n);
    CHECK_EQUAL(n >= 3 && n < 6, asked.driver.accelerator_ok);
    LONGS_EQUAL(n == 4 ? 1 : 0, asked.faults.size());
    if (n == 4) LONGS_EQUAL(-120, asked.faults[0].value);
    bus.exchange(plant);
  }
}

TEST(LockstepBus, StopRequestSaysHowTheRunEnds) {
  options.members = {Member::kBms};
  Answering bms(Member::kBms, one(0x0C0));
  LockstepBus bus(options);
  CHECK(bus.await_members());
  tick(bus, 0);
  CHECK(bus.stop_asked() == StopAsked::kNo);
  can::StopRequest stop;
  stop.reason = can::StopReason::kFinished;
  send(framed(stop));
  tick(bus, 1);
  tick(bus, 2);
  CHECK(bus.stop_asked() == StopAsked::kFinished);
  bus.stop();
}

TEST(LockstepBus, ForeignFramesAreCountedAndGoNowhere) {
  options.members = {Member::kBms};
  Answering bms(Member::kBms, one(0x0C0));
  LockstepBus bus(options);
  bus.attach(seen);
  CHECK(bus.await_members());
  tick(bus, 0);
  send({0x555, 8, {}});
  send({0x0B0, 8, {}});                             // the plant's, and not by the plant
  send({0x0C0 | Frame::kExtendedFlag, 8, {}});      // looks like the BMS's
  LONGS_EQUAL(1, tick(bus, 1).size());
  LONGS_EQUAL(3, bus.statistics().foreign_frames);
  LONGS_EQUAL(4, seen.rows.size());
  bus.stop();
}

TEST(LockstepBus, FramesThatWereAnnouncedAndNeverCameAreCounted) {
  options.members = {Member::kBms};
  port::LockstepMember bms("vcan0", Member::kBms, {});
  LockstepBus bus(options);
  std::thread liar([&] {
    for (int i = 0; i < 3; ++i) bms.announce();
    while (bms.wait() != Wake::kStep) bms.announce();
    const Frame done = port::done_frame(Member::kBms, 0, 4, false);
    port::SocketCan("vcan0", {}).send(&done, 1);
  });
  CHECK(bus.await_members());
  tick(bus, 0);
  liar.join();
  LONGS_EQUAL(4, bus.statistics().missing_frames);
}

TEST(LockstepBus, NamesWhoIsNotReady) {
  options.members = {Member::kBms, Member::kMaster, Member::kHil};
  options.ready_within_s = kLostAfter_s;
  Answering master(Member::kMaster, one(0x0C2));
  LockstepBus bus(options);
  STRCMP_CONTAINS("bms, hil", gather_error(bus).c_str());
}

TEST(LockstepBus, ProcessThatDiesBeforeItIsReadyEndsTheStart) {
  options.members = {Member::kBms};
  LockstepBus bus(options);
  can::MemberLost lost;
  lost.member = Member::kBms;
  send(framed(lost));
  STRCMP_CONTAINS("node bms ended before", gather_error(bus).c_str());
}

TEST(LockstepBus, InterruptionEndsTheStartAndTheWait) {
  bool interrupted = false;
  options.interrupted = [&] { return interrupted; };
  Answering bms(Member::kBms, one(0x0C0)), master(Member::kMaster, one(0x0C2));
  LockstepBus bus(options);
  CHECK(bus.await_members());
  bms.silent = true;
  interrupted = true;
  tick(bus, 0);
  CHECK(bus.stop_asked() == StopAsked::kInterrupted);
  bus.stop();
  LockstepBus other(options);
  CHECK_FALSE(other.await_members());
}

TEST(LockstepBus, RunOfSomebodyElseIsRefused) {
  LockstepBus bus(options);
  can::Sync sync;
  sync.tick = 12;
  send(framed(sync));
  STRCMP_CONTAINS("found frame 7E0", gather_error(bus).c_str());
  LockstepBus again(options);
  send({0x0C0, 8, {}});
  STRCMP_CONTAINS("found frame 0C0", gather_error(again).c_str());
}

TEST(LockstepBus, EndOfAnEarlierRunAndWaitingNodesAreNoCompany) {
  LockstepOptions none = options;
  none.members.clear();
  LockstepBus bus(none);
  can::Sync sync;
  sync.stop = true;
  can::Alive alive;
  alive.stop = true;
  for (const Frame& f : {framed(sync), framed(alive), port::ready_frame(Member::kHil)}) send(f);
  STRCMP_EQUAL("", gather_error(bus).c_str());
}

TEST(LockstepBus, OverrideThatCameBeforeTheStartHoldsFromTheFirstTick) {
  options.members.clear();
  LockstepBus bus(options);
  can::DriverOverride pedal;
  pedal.brake_ok = true;
  pedal.brake_ppm = 1'000'000;
  send(framed(pedal));
  CHECK(bus.await_members());
  CHECK(bus.begin_tick(0).driver.brake_ok);
}

TEST(LockstepBus, PaceBoundsTheTicks) {
  options.members.clear();
  options.pace = 2.0;
  LockstepBus bus(options);
  CHECK(bus.await_members());
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint32_t n = 0; n <= 20; ++n) tick(bus, n);
  CHECK(std::chrono::steady_clock::now() - begin >= std::chrono::milliseconds(100));
}

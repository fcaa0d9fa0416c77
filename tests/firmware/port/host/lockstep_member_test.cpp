// SPDX-License-Identifier: Apache-2.0
// On the real vcan0, against frames by hand.
#include "port/host/lockstep_member.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::port;
using can::Member;

namespace {

template <class Message>
Frame framed(const Message& m) {
  Frame f;
  can::encode(m, f);
  return f;
}

Frame sync(std::uint32_t tick, bool stop = false) {
  can::Sync m;
  m.tick = tick;
  m.stop = stop;
  return framed(m);
}

Frame alive(bool stop) {
  can::Alive m;
  m.stop = stop;
  return framed(m);
}

}  // namespace

TEST_GROUP(LockstepMember) {
  SocketCan bus{"vcan0", {.filters = {kEveryFrame}}};
  LockstepMember bms{"vcan0", Member::kBms, {only(0x0B0)}};
  LockstepMember master{"vcan0", Member::kMaster, {only(0x0B0), only(0x0C0)}};

  void send(const Frame& f) { bus.send(&f, 1); }
  /// The first tick, for both.
  void begin() {
    send(sync(0));
    CHECK(bms.wait() == Wake::kStep);
    bms.done({});
    CHECK(master.wait() == Wake::kStep);
  }
  std::vector<Frame> heard() {
    std::vector<Arrival> arrivals;
    bus.drain(arrivals);
    std::vector<Frame> out;
    for (const Arrival& a : arrivals) out.push_back(a.frame);
    return out;
  }
};

TEST(LockstepMember, AnnouncesItselfUnderItsOwnIdentifier) {
  bms.announce();
  master.announce();
  const auto frames = heard();
  LONGS_EQUAL(2, frames.size());
  LONGS_EQUAL(can::ReadyBms::kId, frames[0].id);
  LONGS_EQUAL(1, frames[0].data[0]);
  LONGS_EQUAL(can::ReadyMaster::kId, frames[1].id);
  LONGS_EQUAL(2, frames[1].data[0]);
}

TEST(LockstepMember, RunIsJoinedAtItsFirstTickOnly) {
  send(sync(4));
  CHECK(bms.wait() == Wake::kAlive);
  CHECK_FALSE(bms.started());
  begin();
  CHECK(bms.started() && master.started());
}

TEST(LockstepMember, BmsStepsOnSyncAndTheMasterOnTheDoneOfTheBms) {
  begin();
  send(sync(7));
  CHECK(bms.wait() == Wake::kStep);
  LONGS_EQUAL(7, bms.tick());
  LONGS_EQUAL(70, bms.now().ms());
  CHECK(master.wait() == Wake::kNone);
  bms.done({});
  CHECK(master.wait() == Wake::kStep);
  LONGS_EQUAL(7, master.tick());
  CHECK(bms.wait() == Wake::kNone);
}

TEST(LockstepMember, LoggerAndHarnessStepOnTheDoneOfTheMaster) {
  LockstepMember logger("vcan0", Member::kLogger, {}), hil("vcan0", Member::kHil, {});
  send(done_frame(Member::kBms, 0, 0, false));
  CHECK(logger.wait() == Wake::kNone);
  send(done_frame(Member::kMaster, 0, 0, true));
  CHECK(logger.wait() == Wake::kStep && hil.wait() == Wake::kStep);
}

TEST(LockstepMember, WhatWasSentBeforeItsTurnIsThereThen) {
  for (std::uint8_t i = 0; i < 20; ++i) send({0x0B0, 8, {i}});
  send({0x0B1, 8, {}});
  send(sync(0));
  CHECK(bms.wait() == Wake::kStep);
  Frame inbox[64];
  LONGS_EQUAL(20, bms.data().receive(inbox, 64));
  LONGS_EQUAL(19, inbox[19].data[0]);
}

TEST(LockstepMember, ItsFramesAndItsDoneGoOutTogetherWithTheirCount) {
  begin();
  send(sync(5));
  CHECK(bms.wait() == Wake::kStep);
  static_cast<void>(heard());
  TxQueue tx;
  CHECK(tx.push({0x0C0, 8, {1}}) && tx.push({0x0C1, 8, {2}}));
  bms.done(tx);
  const auto frames = heard();
  LONGS_EQUAL(3, frames.size());
  LONGS_EQUAL(0x0C1, frames[1].id);
  can::DoneBms done;
  CHECK(done_of(frames[2], done) == Member::kBms);
  LONGS_EQUAL(5, done.tick);
  LONGS_EQUAL(2, done.frames_sent);
  CHECK_FALSE(done.in_place);
}

TEST(LockstepMember, RepeatedOrOlderTickIsASignOfLifeAndNoSecondStep) {
  begin();
  send(sync(5));
  CHECK(bms.wait() == Wake::kStep);
  for (const std::uint32_t tick : {5U, 4U}) {
    send(sync(tick));
    CHECK(bms.wait() == Wake::kAlive);
  }
  send(sync(6));
  CHECK(bms.wait() == Wake::kStep);
}

TEST(LockstepMember, PlantThatWaitsIsAliveAndAPlantThatStopsEndsEverybody) {
  begin();
  send(alive(false));
  CHECK(bms.wait() == Wake::kAlive && master.wait() == Wake::kAlive);
  send(sync(0, true));
  CHECK(bms.wait() == Wake::kStop);
  send(alive(true));
  CHECK(master.wait() == Wake::kStop);
}

TEST(LockstepMember, EndOfARunThatItNeverJoinedIsNotItsEnd) {
  send(sync(40, true));
  send(alive(true));
  CHECK(bms.wait() == Wake::kAlive);
  CHECK(master.wait() == Wake::kAlive);
  CHECK_FALSE(bms.started());
}

TEST(LockstepMember, LockstepIdentifiersAreTheLastThirtyTwo) {
  CHECK_FALSE(is_lockstep(0x7DF));
  CHECK(is_lockstep(0x7E0) && is_lockstep(0x7FF));
  CHECK_FALSE(is_lockstep(0x7E0 | Frame::kExtendedFlag));
  can::DoneBms done;
  CHECK(done_of({can::DoneBms::kId - 1, 8, {}}, done) == Member::kNone);
  CHECK(done_of({can::DoneHil::kId + 1, 8, {}}, done) == Member::kNone);
  CHECK(done_of(done_frame(Member::kHil, 9, 0, true), done) == Member::kHil);
  CHECK(done.in_place);
}

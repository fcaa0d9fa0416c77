// SPDX-License-Identifier: Apache-2.0
#include "port/host/lockstep_member.hpp"

#include <algorithm>
#include <array>

namespace voltlap::port {
namespace {

constexpr std::uint32_t kLockstepFirst = 0x7E0, kLockstepMask = 0x7E0;

std::uint32_t place(can::Member member) { return static_cast<std::uint32_t>(member) - 1; }

// The members' messages differ in nothing but the identifier, one after the other.
static_assert(can::DoneMaster::kId == can::DoneBms::kId + 1 && can::DoneLogger::kId == can::DoneBms::kId + 2 &&
              can::DoneHil::kId == can::DoneBms::kId + 3);
static_assert(can::ReadyMaster::kId == can::ReadyBms::kId + 1 && can::ReadyLogger::kId == can::ReadyBms::kId + 2 &&
              can::ReadyHil::kId == can::ReadyBms::kId + 3);

/// The frame on which it is a member's turn.
std::uint32_t turn_id(can::Member member) {
  switch (member) {
    case can::Member::kBms: return can::Sync::kId;
    case can::Member::kMaster: return can::DoneBms::kId;
    default: return can::DoneMaster::kId;
  }
}

}  // namespace

const char* member_name(can::Member member) {
  constexpr std::array<const char*, 5> kNames = {"none", "bms", "master", "logger", "hil"};
  return kNames[static_cast<std::size_t>(member)];
}

bool is_lockstep(std::uint32_t id) {
  return (id & Frame::kExtendedFlag) == 0 && (id & kLockstepMask) == kLockstepFirst;
}

Frame done_frame(can::Member member, std::uint32_t tick, std::size_t frames_sent, bool in_place) {
  can::DoneBms m;
  m.tick = tick;
  m.frames_sent = static_cast<std::uint16_t>(frames_sent);
  m.in_place = in_place;
  Frame frame;
  encode(m, frame);
  frame.id += place(member);
  return frame;
}

Frame ready_frame(can::Member member) {
  can::ReadyBms m;
  m.member = member;
  Frame frame;
  encode(m, frame);
  frame.id += place(member);
  return frame;
}

can::Member done_of(const Frame& frame, can::DoneBms& done) {
  if (frame.id < can::DoneBms::kId || frame.id > can::DoneHil::kId) return can::Member::kNone;
  Frame same_shape = frame;
  same_shape.id = can::DoneBms::kId;
  if (!decode(same_shape, done)) return can::Member::kNone;
  return static_cast<can::Member>(frame.id - can::DoneBms::kId + 1);
}

LockstepMember::LockstepMember(const std::string& interface, can::Member member, std::vector<CanFilter> listen_to)
    : member_(member),
      ready_(ready_frame(member)),
      turn_(interface, {.filters = {only(turn_id(member)), only(can::Alive::kId)}}),
      data_(interface, {.filters = std::move(listen_to), .error_frames = true}) {}

Wake LockstepMember::wait() {
  const auto frame = turn_.wait();
  if (!frame) return Wake::kNone;
  can::Alive alive;
  // The end of a run that it never joined is nothing to a node that waits for its own.
  const auto stop = [&] { return started_ ? Wake::kStop : Wake::kAlive; };
  if (decode(*frame, alive)) return alive.stop ? stop() : Wake::kAlive;
  can::Sync sync;
  can::DoneBms done;
  std::uint32_t tick = 0;
  if (decode(*frame, sync)) {
    if (sync.stop) return stop();
    tick = sync.tick;
  } else if (done_of(*frame, done) != can::Member::kNone) {
    tick = done.tick;
  } else {
    return Wake::kAlive;
  }
  // A run is joined at its beginning or not at all.
  if (!started_ && tick != 0) return Wake::kAlive;
  // One step a tick: a repeated call counts as a sign of life.
  if (started_ && static_cast<std::int32_t>(tick - tick_) <= 0) return Wake::kAlive;
  started_ = true;
  tick_ = tick;
  return Wake::kStep;
}

void LockstepMember::done(const TxQueue& frames) {
  std::array<Frame, TxQueue::kCapacity + 1> batch;
  std::copy(frames.begin(), frames.end(), batch.begin());
  batch[frames.size()] = done_frame(member_, tick_, frames.size(), false);
  turn_.send(batch.data(), frames.size() + 1);
}

}  // namespace voltlap::port

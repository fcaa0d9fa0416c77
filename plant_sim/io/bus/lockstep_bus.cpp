// SPDX-License-Identifier: Apache-2.0
#include "io/bus/lockstep_bus.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "can_dbc/tables.hpp"
#include "core/demand.hpp"
#include "io/bus/quiet_bus.hpp"
#include "port/host/bus_error.hpp"
#include "port/host/lockstep_member.hpp"
#include "port/host/silence.hpp"

namespace voltlap::plant {
namespace {

using can::Member;

constexpr Member kAll[] = {Member::kBms, Member::kMaster, Member::kLogger, Member::kHil};
constexpr double kAlive_s = 0.5;
constexpr double kTick_us = can::kTickMs * 1000.0;

template <class Message>
Frame framed(const Message& message) {
  Frame frame;
  encode(message, frame);
  return frame;
}

/// What must reach a plant that waits for somebody.
std::vector<port::CanFilter> urgent_filters() {
  return {port::only(can::MemberLost::kId), port::only(can::StopRequest::kId)};
}

/// Takes what is due out of `waiting`, in order of arrival.
template <class Message, class Apply>
void apply_due(std::vector<Message>& waiting, std::uint32_t tick, const Apply& apply) {
  std::erase_if(waiting, [&](const Message& m) {
    if (m.tick > tick) return false;
    apply(m);
    return true;
  });
}

}  // namespace

LockstepBus::LockstepBus(LockstepOptions options)
    : SocketBus(options.interface),
      options_(std::move(options)),
      turn_(options_.interface, {.filters = urgent_filters()}) {
  for (const Member m : options_.members) present_[static_cast<std::size_t>(m)] = true;
  auto filters = urgent_filters();
  for (const Member m : kAll) filters.push_back(port::only(port::ready_frame(m).id));
  turn_.filter(filters);
}

LockstepBus::~LockstepBus() {
  try {
    stop();
  } catch (const port::BusDownError&) {
    // Nobody is left to be told.
  }
}

bool LockstepBus::await_members() {
  require_quiet_bus(data_, Pacing::kLockstep, arrivals_);
  port::Silence incomplete;
  const auto missing = [&] {
    std::vector<std::string> names;
    for (const Member m : kAll) {
      if (takes_part(m) && !ready_[static_cast<std::size_t>(m)]) names.emplace_back(port::member_name(m));
    }
    return names;
  };
  while (!missing().empty()) {
    if (options_.interrupted()) return false;
    if (const auto frame = turn_.wait()) handle(*frame);
    if (stop_ == StopAsked::kInterrupted) return false;
    if (incomplete.go_on() > options_.ready_within_s) {
      throw port::BusSetupError(fmt::format(
          "CAN interface \"{0}\": found that {1} did not become READY within {2:g} s; expected READY of every "
          "member. Start each (voltlap ecu bms|master --bus {0}, voltlap log), or leave it out of --members.",
          options_.interface, fmt::join(missing(), ", "), options_.ready_within_s));
    }
  }
  hear_last_done_only();
  read();
  queue_requests();
  arrivals_.clear();
  if (options_.pace > 0.0) pacer_.emplace(static_cast<std::int64_t>(kTick_us / options_.pace), port::Lag::kForget);
  running_ = true;
  return true;
}

/// One wake a tick: the DONE of the last in the row says that all before it are done. Once a member is lost, its
/// successor is called from here, and every DONE is heard.
void LockstepBus::hear_last_done_only() {
  const bool side = takes_part(Member::kLogger) || takes_part(Member::kHil);
  const bool whole = takes_part(Member::kBms) && takes_part(Member::kMaster);
  auto filters = urgent_filters();
  for (const Member m : kAll) {
    const bool last = side ? m == Member::kLogger || m == Member::kHil : m == Member::kMaster;
    if (takes_part(m) && (last || !whole)) filters.push_back(port::only(port::done_frame(m, 0, 0, false).id));
  }
  turn_.filter(filters);
}

void LockstepBus::stop() {
  if (!running_) return;
  running_ = false;
  can::Sync sync;
  sync.tick = tick_;
  sync.stop = true;
  can::Alive alive;
  alive.tick = tick_;
  alive.stop = true;
  const Frame frames[] = {framed(sync), framed(alive)};
  data_.send(frames, std::size(frames));
}

const Interventions& LockstepBus::begin_tick(std::uint32_t tick) {
  if (pacer_) {
    constexpr auto kAlive_us = static_cast<std::int64_t>(kAlive_s * 1e6);
    while (pacer_->ahead_us() > kAlive_us && !options_.interrupted()) {
      port::WallClock().sleep_until_us(kAlive_us);
      send_alive();
    }
    pacer_->wait();
  }
  VOLTLAP_DEMAND(tick >= tick_);
  tick_ = tick;
  now_.faults.clear();
  apply_due(overrides_, tick, [&](const can::DriverOverride& m) { now_.driver = m; });
  apply_due(faults_, tick, [&](const can::PlantFault& m) { now_.faults.push_back(m); });
  return now_;
}

FrameView LockstepBus::exchange(const TxQueue& plant) {
  try {
    begin_barrier(plant);
    await_barrier();
    VOLTLAP_DEMAND(all_done() || stop_ == StopAsked::kInterrupted);
    read();
    queue_requests();
    return hand_out(tick_);
  } catch (const port::BusDownError& error) {
    running_ = false;
    throw BusFailure(error.what());
  }
}

void LockstepBus::begin_barrier(const TxQueue& plant) {
  done_ = {};
  batch_.assign(plant.begin(), plant.end());
  can::Sync sync;
  sync.tick = tick_;
  sync.frames_sent = static_cast<std::uint16_t>(plant.size());
  batch_.push_back(framed(sync));
  add_done_in_place(batch_);
  data_.send(batch_.data(), batch_.size());
}

void LockstepBus::await_barrier() {
  port::Silence silence, shown;
  while (!all_done()) {
    const auto frame = turn_.wait();
    if (frame) {
      handle(*frame);
      send_done_in_place();
      silence.end();
      continue;
    }
    if (options_.interrupted()) {
      stop_ = StopAsked::kInterrupted;
      return;
    }
    if (shown.go_on() > kAlive_s) {
      send_alive();
      shown.end();
    }
    if (silence.go_on() > options_.lost_after_s) {
      hear_every_done();
      drop(first_missing());
      send_done_in_place();
      silence.end();
    }
  }
}

bool LockstepBus::all_done() const { return first_missing() == Member::kNone; }

Member LockstepBus::first_missing() const {
  // Without a BMS or master of its own the row still has their DONE: the plant sends it.
  for (const Member m : {Member::kBms, Member::kMaster}) {
    if (!is_done(m)) return m;
  }
  for (const Member m : {Member::kLogger, Member::kHil}) {
    if (takes_part(m) && !is_done(m)) return m;
  }
  return Member::kNone;
}

void LockstepBus::handle(const Frame& frame) {
  can::DoneBms done;
  can::MemberLost lost;
  can::StopRequest stop;
  if (const Member m = port::done_of(frame, done); m != Member::kNone) {
    mark_done(m, done);
  } else if (decode(frame, lost)) {
    drop(lost.member);
  } else if (decode(frame, stop)) {
    stop_ = stop.reason == can::StopReason::kFinished ? StopAsked::kFinished : StopAsked::kInterrupted;
  } else if (frame.id >= can::ReadyBms::kId && frame.id <= can::ReadyHil::kId) {
    ready_[frame.id - can::ReadyBms::kId + 1] = true;
  }
}

void LockstepBus::mark_done(Member member, const can::DoneBms& done) {
  if (done.tick != tick_) return;
  set_done(member);
  // A member answers only those before it in the row.
  if (member != Member::kBms) set_done(Member::kBms);
  if (member == Member::kLogger || member == Member::kHil) set_done(Member::kMaster);
}

/// Adds the DONE of each absent member whose turn it is.
void LockstepBus::add_done_in_place(std::vector<Frame>& batch) {
  const auto done_in_place = [&](Member m) {
    batch.push_back(port::done_frame(m, tick_, 0, true));
    set_done(m);
  };
  if (!takes_part(Member::kBms) && !is_done(Member::kBms)) done_in_place(Member::kBms);
  if (!takes_part(Member::kMaster) && is_done(Member::kBms) && !is_done(Member::kMaster))
    done_in_place(Member::kMaster);
  for (const Member m : {Member::kLogger, Member::kHil}) {
    if (was_lost(m) && is_done(Member::kMaster) && !is_done(m)) done_in_place(m);
  }
}

void LockstepBus::send_done_in_place() {
  batch_.clear();
  add_done_in_place(batch_);
  if (!batch_.empty()) data_.send(batch_.data(), batch_.size());
}

void LockstepBus::drop(Member member) {
  if (member == Member::kNone || !takes_part(member)) return;
  if (!running_) {
    throw port::BusSetupError(fmt::format(
        "CAN interface \"{}\": found that node {} ended before it was READY; expected it to wait for the first "
        "tick. What it said above tells why.",
        options_.interface, port::member_name(member)));
  }
  present_[static_cast<std::size_t>(member)] = false;
  lost_.push_back({port::member_name(member), member == Member::kBms || member == Member::kMaster});
  if (!running_) return;
  hear_last_done_only();
  hear_every_done();
}

/// The socket for turns hears the last in the row only; the whole story is on the other.
void LockstepBus::hear_every_done() {
  read();
  for (const port::Arrival& a : arrivals_) {
    can::DoneBms done;
    if (const Member m = port::done_of(a.frame, done); m != Member::kNone) mark_done(m, done);
  }
}

/// What came beside the car's frames in this tick: requests of a harness, and how much the control units say they sent.
void LockstepBus::queue_requests() {
  for (const port::Arrival& a : arrivals_) {
    if (!port::is_lockstep(a.frame.id)) continue;
    can::DoneBms done;
    can::DriverOverride driver;
    can::PlantFault fault;
    if (const Member m = port::done_of(a.frame, done); m == Member::kBms || m == Member::kMaster) {
      if (!done.in_place) announced_ += done.frames_sent;
    } else if (decode(a.frame, driver)) {
      overrides_.push_back(driver);
    } else if (decode(a.frame, fault)) {
      faults_.push_back(fault);
    }
  }
}

bool LockstepBus::was_lost(Member member) const {
  return std::any_of(lost_.begin(), lost_.end(),
                     [&](const LostNode& node) { return node.node == port::member_name(member); });
}

void LockstepBus::send_alive() {
  can::Alive alive;
  alive.tick = tick_;
  const Frame frame = framed(alive);
  data_.send(&frame, 1);
}

BusStatistics LockstepBus::statistics() const {
  BusStatistics out = SocketBus::statistics();
  out.pacing = "lockstep";
  const std::uint64_t seen =
      frames_of_[static_cast<std::size_t>(Sender::kBms)] + frames_of_[static_cast<std::size_t>(Sender::kMaster)];
  out.missing_frames = announced_ > seen ? announced_ - seen : 0;
  return out;
}

}  // namespace voltlap::plant

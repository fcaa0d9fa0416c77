// SPDX-License-Identifier: Apache-2.0
#include "io/bus/board_stream.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "can_dbc/tables.hpp"

namespace voltlap::plant {
namespace {

constexpr int kLook_ms = 100;  // for an interrupt, while the other side is silent

/// What a board says before its first tick.
bool is_ready(const Frame& frame) {
  can::ReadyBms bms;
  can::ReadyMaster master;
  return decode(frame, bms) || decode(frame, master);
}

}  // namespace

const port::Greeting& BoardStream::await_greeting() {
  read_all(&greeting_.mark, sizeof greeting_.mark);  // one of another length has another mark
  if (greeting_.mark != port::kGreetingMark) fail("does not greet as an image of this firmware does");
  read_all(reinterpret_cast<std::uint8_t*>(&greeting_) + sizeof greeting_.mark,
           sizeof greeting_ - sizeof greeting_.mark);
  if (greeting_.has_bms == 0 && greeting_.has_master == 0) fail("does not greet as an image of this firmware does");
  nodes_ = {greeting_.has_bms != 0, greeting_.has_master != 0};
  return greeting_;
}

void BoardStream::configure(std::span<const std::byte> bms, std::span<const std::byte> master, std::uint32_t layout,
                            BoardNodes nodes) {
  port::ConfigurationHead head;
  head.config_layout = layout;
  head.bms_config_bytes = static_cast<std::uint32_t>(bms.size());
  head.master_config_bytes = static_cast<std::uint32_t>(master.size());
  head.runs_bms = nodes.bms ? 1 : 0;
  head.runs_master = nodes.master ? 1 : 0;
  write_all(&head, sizeof head);
  write_all(bms.data(), bms.size());
  write_all(master.data(), master.size());
  nodes_ = {nodes_.bms && nodes.bms, nodes_.master && nodes.master};
}

void BoardStream::step(std::uint32_t tick, FrameView frames, const Heard& heard) {
  tick_ = tick;
  batch_.clear();
  const auto put = [&](const Frame& frame) {
    batch_.resize(batch_.size() + port::kFrameBytes);
    port::frame_to_bytes(frame, batch_.data() + batch_.size() - port::kFrameBytes);
  };
  for (const Frame& frame : frames) put(frame);
  can::Sync sync;
  sync.tick = tick_;
  sync.frames_sent = static_cast<std::uint16_t>(frames.count);
  Frame frame;
  encode(sync, frame);
  put(frame);
  write_all(batch_.data(), batch_.size());
  take_answer(heard);
}

void BoardStream::reset() {
  can::MemberReset reset;
  reset.tick = tick_;
  reset.member = nodes_.bms ? can::Member::kBms : can::Member::kMaster;
  Frame frame;
  encode(reset, frame);
  write_frame(frame);
}

void BoardStream::stop() {
  can::Sync sync;
  sync.tick = tick_;
  sync.stop = true;
  Frame frame;
  encode(sync, frame);
  write_frame(frame);
  Frame last = next_frame();
  while (is_ready(last)) last = next_frame();  // the run has ended before a tick
  can::StackUse use;
  if (!decode(last, use)) fail("does not end as an image of this firmware does");
  account_.stack_used = use.used;
  account_.stack_size = use.size;
}

void BoardStream::take_answer(const Heard& heard) {
  speaks_ = nodes_.bms ? Sender::kBms : Sender::kMaster;
  for (answered_ = false; !answered_;) {
    const Frame frame = next_frame();
    if (is_of_bus(frame)) heard(speaks_, frame);
  }
  if (cost_of_tick_ > 0) account_.both.add(std::exchange(cost_of_tick_, 0), tick_);
}

bool BoardStream::is_of_bus(const Frame& frame) {
  can::StepCost cost;
  can::DoneBms bms;
  can::DoneMaster master;
  if (decode(frame, bms)) {
    if (bms.tick != tick_) fail(fmt::format("answers tick {} instead of {}", bms.tick, tick_));
    speaks_ = Sender::kMaster;
    answered_ = !nodes_.master;
  } else if (decode(frame, master)) {
    if (master.tick != tick_) fail(fmt::format("answers tick {} instead of {}", master.tick, tick_));
    answered_ = true;
  } else if (decode(frame, cost)) {
    count(cost);
  } else {
    return !is_ready(frame);
  }
  return false;
}

void BoardStream::count(const can::StepCost& cost) {
  StepCosts& of = cost.member == can::Member::kBms ? account_.bms : account_.master;
  of.add(cost.instructions, tick_);
  cost_of_tick_ += cost.instructions;
}

Frame BoardStream::next_frame() {
  std::array<std::uint8_t, port::kFrameBytes> bytes{};
  read_all(bytes.data(), bytes.size());
  Frame frame;
  if (!port::frame_from_bytes(bytes.data(), frame)) fail("sends something that is no frame");
  return frame;
}

void BoardStream::write_frame(const Frame& frame) {
  std::array<std::uint8_t, port::kFrameBytes> bytes{};
  port::frame_to_bytes(frame, bytes.data());
  write_all(bytes.data(), bytes.size());
}

void BoardStream::write_all(const void* bytes, std::size_t count) {
  const auto* from = static_cast<const std::uint8_t*>(bytes);
  for (std::size_t done = 0; done < count;) {
    const ssize_t sent = ::write(options_.to_ecu, from + done, count - done);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) fail(options_.what_became_of_it());
    done += static_cast<std::size_t>(sent);
  }
}

void BoardStream::read_all(void* bytes, std::size_t count) {
  auto* to = static_cast<std::uint8_t*>(bytes);
  while (count > 0) {
    if (raw_taken_ == raw_count_ && !read_some()) fail(options_.what_became_of_it());
    const std::size_t part = std::min(count, raw_count_ - raw_taken_);
    std::memcpy(to, raw_.data() + raw_taken_, part);
    raw_taken_ += part;
    to += part;
    count -= part;
  }
}

/// False when the other side has closed.
bool BoardStream::read_some() {
  pollfd poll{options_.from_ecu, POLLIN, 0};
  int waited_ms = 0;
  for (int ready = 0; (ready = ::poll(&poll, 1, kLook_ms)) <= 0;) {
    if (ready < 0 && errno != EINTR) fail(std::strerror(errno));
    if (options_.interrupted()) fail("was interrupted");
    waited_ms += kLook_ms;
    if (waited_ms * 1e-3 > options_.answer_within_s) {
      fail(fmt::format("has not answered for {:g} s", options_.answer_within_s));
    }
  }
  const ssize_t got = ::read(options_.from_ecu, raw_.data(), raw_.size());
  if (got <= 0) return false;
  raw_taken_ = 0;
  raw_count_ = static_cast<std::size_t>(got);
  return true;
}

void BoardStream::fail(const std::string& what) {
  failed_ = true;
  throw BusFailure(fmt::format("the firmware outside of this process {} (tick {}, {:.2f} s after power-on)", what,
                               tick_, tick_ * can::kTickMs * 1e-3));
}

}  // namespace voltlap::plant

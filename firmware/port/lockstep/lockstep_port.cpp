// SPDX-License-Identifier: Apache-2.0
#include "port/lockstep/lockstep_port.hpp"

#include "base/require.hpp"
#include "can_dbc/tables.hpp"
#include "port/lockstep/greeting.hpp"

namespace voltlap::port {

void LockstepPort::greet(void* bms, std::size_t bms_bytes, void* master, std::size_t master_bytes,
                         std::size_t temperatures_max) {
  VOLTLAP_REQUIRE(!greeted_ && (bms == nullptr) == (master == nullptr));
  const bool asks = bms != nullptr;
  Greeting greeting;
  greeting.config_layout = image_.config_layout;
  greeting.node_sources = image_.node_sources;
  greeting.bms_config_bytes = asks ? static_cast<std::uint32_t>(bms_bytes) : 0;
  greeting.master_config_bytes = asks ? static_cast<std::uint32_t>(master_bytes) : 0;
  greeting.cells_max = image_.cells_max;
  greeting.temperatures_max = static_cast<std::uint16_t>(temperatures_max);
  greeting.has_bms = image_.has_bms ? 1 : 0;
  greeting.has_master = image_.has_master ? 1 : 0;
  greeting.cells_in_series = image_.cells_in_series;
  greeting.bms_number = image_.bms_number;
  greeting.master_number = image_.master_number;
  for (std::size_t i = 0; i < sizeof greeting.car; ++i) greeting.car[i] = image_.car[i];
  if (!rig_.write(reinterpret_cast<const std::uint8_t*>(&greeting), sizeof greeting)) rig_.end(false);
  greeted_ = true;
  if (!asks) return;
  ConfigurationHead head;
  read_whole(&head, sizeof head);
  const bool fits = head.mark == kConfigurationMark && head.config_layout == image_.config_layout &&
                    head.bms_config_bytes == bms_bytes && head.master_config_bytes == master_bytes;
  runs_bms_ = image_.has_bms && head.runs_bms != 0;
  runs_master_ = image_.has_master && head.runs_master != 0;
  if (!fits || (!runs_bms_ && !runs_master_)) rig_.end(false);
  read_whole(bms, bms_bytes);
  read_whole(master, master_bytes);
}

void LockstepPort::sleep_until(Instant /*at*/) {
  VOLTLAP_REQUIRE(greeted_);
  if (!started_) announce();
  const std::uint8_t nodes = static_cast<std::uint8_t>((runs_bms_ ? 1 : 0) + (runs_master_ ? 1 : 0));
  VOLTLAP_REQUIRE(!started_ || turns_ == nodes);  // every node sends once a tick, an empty queue if need be
  flush();
  take_batch();
  started_ = true;
  turns_ = 0;
}

std::size_t LockstepPort::receive(Frame* frames, std::size_t capacity) {
  std::size_t count = 0;
  for (; count < capacity && in_taken_ < in_count_; ++count) frames[count] = in_[in_taken_++];
  begin_ = rig_.instructions();
  return count;
}

bool LockstepPort::send(const TxQueue& frames) {
  const std::uint32_t spent = rig_.instructions() - begin_;
  const can::Member member = member_of_turn();
  for (const Frame& frame : frames) put(frame);
  Frame frame;
  if (rig_.counts()) {
    can::StepCost cost;
    cost.member = member;
    cost.instructions = spent;
    encode(cost, frame);
    put(frame);
  }
  can::DoneBms done;
  done.tick = tick_;
  done.frames_sent = static_cast<std::uint16_t>(frames.size());
  encode(done, frame);
  frame.id += static_cast<std::uint32_t>(member) - static_cast<std::uint32_t>(can::Member::kBms);
  put(frame);
  ++turns_;
  begin_ = rig_.instructions();
  return true;
}

can::Member LockstepPort::member_of_turn() const {
  VOLTLAP_REQUIRE(turns_ < 2 && (runs_bms_ || runs_master_));
  return turns_ == 0 && runs_bms_ ? can::Member::kBms : can::Member::kMaster;
}

void LockstepPort::announce() {
  Frame frame;
  can::ReadyBms bms;
  bms.member = can::Member::kBms;
  can::ReadyMaster master;
  master.member = can::Member::kMaster;
  if (runs_bms_) {
    encode(bms, frame);
    put(frame);
  }
  if (runs_master_) {
    encode(master, frame);
    put(frame);
  }
}

void LockstepPort::put(const Frame& frame) {
  VOLTLAP_REQUIRE(out_count_ + kFrameBytes <= sizeof out_);
  frame_to_bytes(frame, out_ + out_count_);
  out_count_ += kFrameBytes;
}

void LockstepPort::flush() {
  if (out_count_ > 0 && !rig_.write(out_, out_count_)) rig_.end(false);
  out_count_ = 0;
}

/// Frames up to the next Sync. What is more than a board has room for is lost, as on a controller that overruns.
void LockstepPort::take_batch() {
  in_count_ = 0;
  in_taken_ = 0;
  for (;;) {
    fill_to(kFrameBytes);
    Frame frame;
    if (!frame_from_bytes(raw_ + raw_taken_, frame)) rig_.end(false);
    raw_taken_ += kFrameBytes;
    if (take_sync(frame)) return;
    obey_reset(frame);
    if (in_count_ < kFramesInMax) in_[in_count_++] = frame;
  }
}

bool LockstepPort::take_sync(const Frame& frame) {
  can::Sync sync;
  if (!decode(frame, sync)) return false;
  if (sync.stop) {
    report_stack();
    rig_.end(true);
  }
  tick_ = sync.tick;
  now_ = Instant::from_ms(static_cast<std::uint32_t>(sync.tick * can::kTickMs));
  return true;
}

/// The loss of the supply comes between two ticks, when the image waits and every byte before it has been taken.
void LockstepPort::obey_reset(const Frame& frame) {
  can::MemberReset reset;
  if (decode(frame, reset)) rig_.restart();
}

void LockstepPort::report_stack() {
  can::StackUse use;
  use.used = rig_.stack_used();
  use.size = rig_.stack_size();
  Frame frame;
  encode(use, frame);
  put(frame);
  flush();
}

/// At least so many bytes of what was sent lie in raw_, from raw_taken_ on.
void LockstepPort::fill_to(std::size_t bytes) {
  if (raw_count_ - raw_taken_ >= bytes) return;
  const std::size_t left = raw_count_ - raw_taken_;
  for (std::size_t i = 0; i < left; ++i) raw_[i] = raw_[raw_taken_ + i];
  raw_taken_ = 0;
  raw_count_ = left;
  while (raw_count_ < bytes) {
    const std::size_t got = rig_.read(raw_ + raw_count_, sizeof raw_ - raw_count_);
    if (got == 0) rig_.end(false);
    raw_count_ += got;
  }
}

void LockstepPort::read_whole(void* to, std::size_t count) {
  auto* out = static_cast<std::uint8_t*>(to);
  for (std::size_t done = 0; done < count;) {
    const std::size_t got = rig_.read(out + done, count - done);
    if (got == 0) rig_.end(false);
    done += got;
  }
}

}  // namespace voltlap::port

// SPDX-License-Identifier: Apache-2.0
#include "io/bus/harness_bus.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "can_dbc/tables.hpp"

namespace voltlap::plant {
namespace {

constexpr std::uint32_t kRecordsMax = 4096;  // forty times what 500 kbit/s carries in a tick
constexpr std::uint32_t kGatewayFlag = 1;
constexpr unsigned kEverybody = (1U << kSenders) - 1U;

struct Head {
  std::uint32_t records, flag;
};

/// False when the pipe ends before the first byte; an end in the middle is a failure.
bool read_all(int pipe, void* into, std::size_t bytes) {
  auto* at = static_cast<std::uint8_t*>(into);
  for (std::size_t got = 0; got < bytes;) {
    const ssize_t n = ::read(pipe, at + got, bytes - got);
    if (n < 0 && errno == EINTR) continue;
    if (n == 0 && got == 0) return false;
    if (n <= 0) throw BusFailure("the pipe from the harness ended inside a batch");
    got += static_cast<std::size_t>(n);
  }
  return true;
}

void write_all(int pipe, const void* from, std::size_t bytes) {
  const auto* at = static_cast<const std::uint8_t*>(from);
  for (std::size_t sent = 0; sent < bytes;) {
    const ssize_t n = ::write(pipe, at + sent, bytes - sent);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw BusFailure("the pipe to the harness is closed");
    sent += static_cast<std::size_t>(n);
  }
}

}  // namespace

const Interventions& HarnessBus::begin_tick(std::uint32_t tick) {
  tick_ = tick;
  frames_in_tick_max_ = std::max(frames_in_tick_max_, frames_in_tick_);
  frames_in_tick_ = 0;
  now_.faults.clear();
  out_.clear();
  if (!read_batch()) stop_ = StopAsked::kFinished;
  const std::vector<Record> asked = batch_;
  for (const Record& r : asked) {
    Frame frame{r.id, r.dlc, {}};
    std::memcpy(frame.data, r.data, sizeof frame.data);
    request(frame);
  }
  return now_;
}

void HarnessBus::request(const Frame& frame) {
  can::DriverOverride driver;
  can::PlantFault fault;
  can::MemberReset reset;
  can::MemberLost lost;
  can::StopRequest stop;
  const auto node_of = [](can::Member m) { return m == can::Member::kBms ? Sender::kBms : Sender::kMaster; };
  const auto is_ecu = [](can::Member m) { return m == can::Member::kBms || m == can::Member::kMaster; };
  if (decode(frame, driver)) {
    now_.driver = driver;
  } else if (decode(frame, fault)) {
    now_.faults.push_back(fault);
  } else if (decode(frame, reset)) {
    if (is_ecu(reset.member)) {
      ecus_.reset(node_of(reset.member), Instant::from_ms(tick_ * can::kTickMs), Duration::from_ms(reset.off_ms));
    }
  } else if (decode(frame, lost)) {
    if (!is_ecu(lost.member)) return;
    ecus_.lose(node_of(lost.member));
    lost_.push_back({lost.member == can::Member::kBms ? "bms" : "master", true});
  } else if (decode(frame, stop)) {
    stop_ = stop.reason == can::StopReason::kFinished ? StopAsked::kFinished : StopAsked::kInterrupted;
  } else {
    if (!gateway_) hear(frame, kEverybody);
    add(frame, Sender::kPlant);
  }
}

FrameView HarnessBus::exchange(const TxQueue& plant) {
  if (stop_ != StopAsked::kNo) return {};
  const Instant now = Instant::from_ms(tick_ * can::kTickMs);
  TxQueue tx;
  pass_on(Sender::kPlant, plant);
  ecus_.bms(now, heard_by(Sender::kBms), tx);
  pass_on(Sender::kBms, tx);
  tx.clear();
  ecus_.master(now, heard_by(Sender::kMaster), tx);
  pass_on(Sender::kMaster, tx);
  if (!gateway_) write_batch();
  return heard_by(Sender::kPlant);
}

void HarnessBus::pass_on(Sender sender, const TxQueue& frames) {
  const auto others = kEverybody & ~(1U << static_cast<unsigned>(sender));
  for (const Frame& frame : frames) {
    add(frame, sender);
    if (!gateway_) hear(frame, others);
    for (FrameSink* sink : sinks_) sink->on_frame(tick_, sender, frame);
  }
  frames_in_tick_ += static_cast<std::uint32_t>(frames.size());
  frames_sent_ += frames.size();
  if (!gateway_) return;
  write_batch();
  if (!read_batch()) throw BusFailure("the harness ended in the middle of a tick");
  for (const Record& r : batch_) {
    Frame frame{r.id, r.dlc, {}};
    std::memcpy(frame.data, r.data, sizeof frame.data);
    hear(frame, r.who);
  }
}

void HarnessBus::add(const Frame& frame, Sender sender) {
  Record r{frame.id, frame.dlc, static_cast<std::uint8_t>(sender), 0, {}};
  std::memcpy(r.data, frame.data, sizeof r.data);
  out_.push_back(r);
}

void HarnessBus::hear(const Frame& frame, unsigned hearers) {
  for (std::size_t node = 0; node < kSenders; ++node) {
    if ((hearers >> node & 1U) != 0) inbox_[node].push_back(frame);
  }
}

FrameView HarnessBus::heard_by(Sender node) {
  const auto i = static_cast<std::size_t>(node);
  taken_[i].swap(inbox_[i]);
  inbox_[i].clear();
  return {taken_[i].data(), taken_[i].size()};
}

bool HarnessBus::read_batch() {
  batch_.clear();
  Head head{};
  if (!read_all(from_harness_, &head, sizeof head)) return false;
  if (head.records > kRecordsMax) {
    throw BusFailure(fmt::format("found a batch of {} records from the harness, expected at most {}", head.records,
                                 kRecordsMax));
  }
  gateway_ = (head.flag & kGatewayFlag) != 0;
  batch_.resize(head.records);
  if (head.records != 0 && !read_all(from_harness_, batch_.data(), batch_.size() * sizeof(Record))) {
    throw BusFailure("the pipe from the harness ended inside a batch");
  }
  for (const Record& r : batch_) {
    if (r.dlc > Frame::kMaxBytes) throw BusFailure(fmt::format("found a frame of {} bytes from the harness", r.dlc));
  }
  return true;
}

void HarnessBus::write_batch() {
  const Head head{static_cast<std::uint32_t>(out_.size()), 0};
  write_all(to_harness_, &head, sizeof head);
  write_all(to_harness_, out_.data(), out_.size() * sizeof(Record));
  out_.clear();
}

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
#include "app/iso_tp.hpp"

#include "base/payload.hpp"
#include "base/require.hpp"
#include "base/units.hpp"

namespace voltlap::app {
namespace {

// ISO 15765-2:2016 9.6: the high nibble of the first byte
constexpr std::uint8_t kSingle = 0x0, kFirst = 0x1, kConsecutive = 0x2, kFlow = 0x3;
constexpr std::uint8_t kGoOn = 0, kWait = 1, kOverflow = 2;
constexpr std::size_t kSingleMost = 7, kInFirst = 6, kInConsecutive = 7;
static_assert(IsoTp::kResponseMost <= 0xFF, "the length of a response fits the second byte of its first frame");
constexpr std::uint8_t kPadding = 0xCC;
constexpr std::uint8_t kWaitsMax = 10;              // N_WFTmax
constexpr std::uint8_t kSeparationMax_ms = 0x7F;    // STmin; a value that is reserved counts as this one

std::int32_t separation_of(std::uint8_t st_min) {
  if (st_min >= 0xF1 && st_min <= 0xF9) return 1;  // 100 to 900 us: a tick is longer
  return min(st_min, kSeparationMax_ms);
}

}  // namespace

bool IsoTp::receive(Instant now, const Frame& frame) {
  if (frame.id != receive_id_) return false;
  switch (frame.data[0] >> 4) {
    case kSingle: return receive_single(frame);
    case kFirst: receive_first(now, frame); return false;
    case kConsecutive: return receive_consecutive(now, frame);
    case kFlow: receive_flow(now, frame); return false;
    default: return false;
  }
}

bool IsoTp::receive_single(const Frame& frame) {
  const std::size_t count = frame.data[0] & 0xFU;
  if (count == 0 || count > kSingleMost || count + 1 > frame.dlc) return false;
  payload::copy(frame.data + 1, count, request_);
  request_bytes_ = count;
  expected_ = 0;
  return true;
}

void IsoTp::receive_first(Instant now, const Frame& frame) {
  const std::size_t count = (frame.data[0] & 0xFU) << 8 | frame.data[1];
  if (frame.dlc < Frame::kMaxBytes || count <= kSingleMost) return;  // an escaped length, too: 0
  expected_ = 0;
  if (count > kRequestMost) {
    flow_control(kOverflow);
    return;
  }
  payload::copy(frame.data + 2, kInFirst, request_);
  expected_ = count;
  received_ = kInFirst;
  next_in_ = 1;
  last_in_ = now;
  flow_control(kGoOn);
}

bool IsoTp::receive_consecutive(Instant now, const Frame& frame) {
  if (expected_ == 0) return false;
  const std::size_t count = min(expected_ - received_, kInConsecutive);
  if ((frame.data[0] & 0xFU) != next_in_ || frame.dlc < count + 1) {  // 9.6.4.4: a wrong number ends it
    expected_ = 0;
    return false;
  }
  payload::copy(frame.data + 1, count, request_ + received_);
  received_ += count;
  next_in_ = (next_in_ + 1U) & 0xFU;
  last_in_ = now;
  if (received_ < expected_) return false;
  request_bytes_ = expected_;
  expected_ = 0;
  return true;
}

// An unexpected N_PDU: flow control that nobody waits for, before the first frame or within a block, is not looked at.
void IsoTp::receive_flow(Instant now, const Frame& frame) {
  if (sent_ == 0 || may_send_ || frame.dlc < 3) return;
  switch (frame.data[0] & 0xFU) {
    case kGoOn:
      may_send_ = true;
      block_left_ = frame.data[1];
      separation_ms_ = separation_of(frame.data[2]);
      waits_ = 0;
      return;
    case kWait:
      last_out_ = now;
      if (++waits_ > kWaitsMax) give_up();
      return;
    default: return give_up();  // overflow, and what is reserved
  }
}

void IsoTp::flow_control(std::uint8_t status) {
  flow_due_ = true;
  flow_status_ = status;
}

void IsoTp::respond(const std::uint8_t* bytes, std::size_t count) {
  VOLTLAP_REQUIRE(count <= kResponseMost);
  response_bytes_ = count;
  payload::copy(bytes, count, response_);
  sent_ = 0;
  next_out_ = 0;
  may_send_ = false;
  waits_ = 0;
}

bool IsoTp::push(TxQueue& tx, const std::uint8_t* bytes, std::size_t count) {
  Frame frame;
  frame.id = send_id_;
  frame.dlc = Frame::kMaxBytes;
  for (std::uint8_t& byte : frame.data) byte = kPadding;
  payload::copy(bytes, count, frame.data);
  return tx.push(frame);
}

/// The next frame of the response; false when the queue is full, and the next tick tries it again.
bool IsoTp::send_next(TxQueue& tx) {
  std::uint8_t bytes[Frame::kMaxBytes];
  std::size_t head = 1;
  if (response_bytes_ <= kSingleMost) {
    bytes[0] = static_cast<std::uint8_t>(response_bytes_);
  } else if (sent_ == 0) {
    bytes[0] = kFirst << 4;
    bytes[1] = static_cast<std::uint8_t>(response_bytes_);
    head = 2;
  } else {
    bytes[0] = static_cast<std::uint8_t>(kConsecutive << 4 | next_out_);
  }
  const std::size_t count = min(response_bytes_ - sent_, Frame::kMaxBytes - head);
  payload::copy(response_ + sent_, count, bytes + head);
  if (!push(tx, bytes, head + count)) return false;
  next_out_ = (next_out_ + 1U) & 0xFU;
  sent_ += count;
  return true;
}

void IsoTp::tick(Instant now, TxQueue& tx) {
  if (now - last_in_ >= kTimeout) expected_ = 0;
  if (flow_due_) {
    const std::uint8_t flow[3] = {static_cast<std::uint8_t>(kFlow << 4 | flow_status_), 0, 0};
    flow_due_ = !push(tx, flow, sizeof flow);
  }
  if (!sending()) return;
  if (sent_ == 0) {
    if (send_next(tx)) last_out_ = now;
    return;
  }
  if (!may_send_) {
    if (now - last_out_ >= kTimeout) give_up();
    return;
  }
  if ((now - last_out_).ms() < separation_ms_ || !send_next(tx)) return;  // one a tick, whatever is allowed
  last_out_ = now;
  if (--block_left_ == 0) may_send_ = false;
}

}  // namespace voltlap::app

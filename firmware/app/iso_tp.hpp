// SPDX-License-Identifier: Apache-2.0
// Messages longer than a frame: ISO 15765-2 with normal addressing, one partner, one message each way at a time. All
// buffers and waits are bounded; whatever arrives, a tick sends at most kFramesPerTick frames.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"
#include "base/time.hpp"

namespace voltlap::app {

class IsoTp {
 public:
  static constexpr std::size_t kRequestMost = 64;   ///< bytes; a longer one is refused with "overflow"
  static constexpr std::size_t kResponseMost = 160;
  static constexpr std::size_t kFramesPerTick = 2;  ///< one of the response, one of flow control
  static constexpr Duration kTimeout = Duration::from_ms(1000);  ///< N_Bs, N_Cr

  IsoTp(std::uint32_t receive_id, std::uint32_t send_id) : receive_id_(receive_id), send_id_(send_id) {}

  /// Takes one frame; those of others are not looked at. True when a request is whole: request() holds it until the
  /// next.
  bool receive(Instant now, const Frame& frame);
  [[nodiscard]] const std::uint8_t* request() const { return request_; }
  [[nodiscard]] std::size_t request_bytes() const { return request_bytes_; }

  /// Begins to send a response of at most kResponseMost bytes; what is under way is given up.
  void respond(const std::uint8_t* bytes, std::size_t count);
  /// Once a tick, after the frames: what is due goes to `tx`, and what has waited too long is given up.
  void tick(Instant now, TxQueue& tx);
  [[nodiscard]] bool sending() const { return sent_ < response_bytes_; }

 private:
  bool receive_single(const Frame& frame);
  void receive_first(Instant now, const Frame& frame);
  bool receive_consecutive(Instant now, const Frame& frame);
  void receive_flow(Instant now, const Frame& frame);
  void flow_control(std::uint8_t status);
  bool push(TxQueue& tx, const std::uint8_t* bytes, std::size_t count);
  bool send_next(TxQueue& tx);
  void give_up() { response_bytes_ = sent_ = 0; }

  std::uint32_t receive_id_, send_id_;
  std::uint8_t request_[kRequestMost] = {};
  std::size_t request_bytes_ = 0;
  std::size_t expected_ = 0, received_ = 0;  ///< of a request in several frames; expected 0: none
  std::uint8_t next_in_ = 0;
  Instant last_in_{};
  bool flow_due_ = false;
  std::uint8_t flow_status_ = 0;

  std::uint8_t response_[kResponseMost] = {};
  std::size_t response_bytes_ = 0, sent_ = 0;
  std::uint8_t next_out_ = 0;
  bool may_send_ = false;      ///< flow control has come
  std::size_t block_left_ = 0;  ///< frames of this block; from 0 on it counts down past the longest response
  std::int32_t separation_ms_ = 0;
  std::uint8_t waits_ = 0;
  Instant last_out_{};
};

}  // namespace voltlap::app

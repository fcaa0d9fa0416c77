// SPDX-License-Identifier: Apache-2.0
#include "port/host/socket_can.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "port/host/bus_error.hpp"
#include "port/host/can_interface.hpp"
#include "port/host/send_all.hpp"

namespace voltlap::port {
namespace {

constexpr unsigned kBatch = 64;               // two ticks of a car's frames
constexpr int kReceiveBuffer_bytes = 4 << 20;  // some thousand frames

static_assert(Frame::kExtendedFlag == CAN_EFF_FLAG, "Frame carries the kernel's flag of 29-bit identifiers");

}  // namespace

CanFilter only(std::uint32_t id) {
  const bool extended = (id & Frame::kExtendedFlag) != 0;
  return {id, (extended ? CAN_EFF_MASK : CAN_SFF_MASK) | CAN_EFF_FLAG | CAN_RTR_FLAG};
}

struct SocketCan::Batch {
  static constexpr std::size_t kControl = CMSG_SPACE(sizeof(std::uint32_t)) + CMSG_SPACE(sizeof(timeval));
  std::array<can_frame, kBatch> frames{};
  std::array<iovec, kBatch> vectors{};
  std::array<mmsghdr, kBatch> headers{};
  std::array<std::array<char, kControl>, kBatch> control{};

  Batch() {
    for (unsigned i = 0; i < kBatch; ++i) {
      vectors[i] = {&frames[i], sizeof frames[i]};
      headers[i].msg_hdr.msg_iov = &vectors[i];
      headers[i].msg_hdr.msg_iovlen = 1;
    }
  }
};

SocketCan::SocketCan(std::string interface, const SocketOptions& options)
    : interface_(std::move(interface)), descriptor_(interface_), batch_(std::make_unique<Batch>()) {
  filter(options.filters);
  const int on = 1, own = options.own_frames ? 1 : 0, stamps = options.time_stamps ? 1 : 0;
  ::setsockopt(descriptor_.get(), SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &own, sizeof own);
  ::setsockopt(descriptor_.get(), SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
  ::setsockopt(descriptor_.get(), SOL_SOCKET, SO_TIMESTAMP, &stamps, sizeof stamps);
  const can_err_mask_t errors = options.error_frames ? CAN_ERR_MASK : 0;
  ::setsockopt(descriptor_.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
  // Beyond the system's limit only for root; the plain request takes what the limit allows.
  const int bytes = kReceiveBuffer_bytes;
  if (::setsockopt(descriptor_.get(), SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0) {
    ::setsockopt(descriptor_.get(), SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  }
  const auto wait_us = std::chrono::microseconds(options.wait).count();
  const timeval wait{static_cast<time_t>(wait_us / 1'000'000), static_cast<suseconds_t>(wait_us % 1'000'000)};
  ::setsockopt(descriptor_.get(), SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
  descriptor_.bind(interface_);
}

SocketCan::~SocketCan() = default;

void SocketCan::filter(const std::vector<CanFilter>& filters) {
  std::vector<can_filter> kernel;
  kernel.reserve(filters.size());
  for (const CanFilter& f : filters) kernel.push_back({f.id, f.mask});
  if (::setsockopt(descriptor_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, kernel.data(),
                   static_cast<socklen_t>(kernel.size() * sizeof(can_filter))) != 0) {
    throw BusSetupError(quoted(interface_) + ": found that the kernel refuses " + std::to_string(filters.size()) +
                        " filters (" + std::strerror(errno) +
                        "); expected room for them. Use another kernel: ./voltlap with-vcan COMMAND.");
  }
}

std::optional<Frame> SocketCan::wait() {
  can_frame raw{};
  if (::recv(descriptor_.get(), &raw, sizeof raw, 0) < 0) {
    if (errno == EAGAIN || errno == EINTR) return std::nullopt;
    fail_on_bus(interface_, errno, "receive");
  }
  Frame frame{raw.can_id, raw.len, {}};
  std::copy_n(raw.data, std::min<std::size_t>(raw.len, Frame::kMaxBytes), frame.data);
  return frame;
}

unsigned SocketCan::read_batch(unsigned capacity) {
  for (unsigned i = 0; i < capacity; ++i) {
    batch_->headers[i].msg_hdr.msg_control = batch_->control[i].data();
    batch_->headers[i].msg_hdr.msg_controllen = Batch::kControl;
  }
  const int count = ::recvmmsg(descriptor_.get(), batch_->headers.data(), capacity, MSG_DONTWAIT, nullptr);
  if (count >= 0) return static_cast<unsigned>(count);
  if (errno == EAGAIN || errno == EINTR) return 0;
  fail_on_bus(interface_, errno, "receive");
}

std::optional<Arrival> SocketCan::arrival(unsigned index) {
  const can_frame& raw = batch_->frames[index];
  msghdr& header = batch_->headers[index].msg_hdr;
  Arrival out;
  for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr; c = CMSG_NXTHDR(&header, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t dropped = 0;
      std::memcpy(&dropped, CMSG_DATA(c), sizeof dropped);
      counters_.dropped = dropped;
    } else if (c->cmsg_type == SCM_TIMESTAMP) {
      timeval time{};
      std::memcpy(&time, CMSG_DATA(c), sizeof time);
      out.time_us = std::int64_t{time.tv_sec} * 1'000'000 + time.tv_usec;
    }
  }
  if ((raw.can_id & CAN_ERR_FLAG) != 0) {
    note_error_frame(raw.can_id);
    return std::nullopt;
  }
  if ((raw.can_id & CAN_RTR_FLAG) != 0) return std::nullopt;
  out.frame.id = raw.can_id;
  out.frame.dlc = raw.len;
  std::copy_n(raw.data, std::min<std::size_t>(raw.len, Frame::kMaxBytes), out.frame.data);
  out.own = (header.msg_flags & MSG_CONFIRM) != 0;
  return out;
}

void SocketCan::note_error_frame(std::uint32_t id) {
  ++counters_.error_frames;
  if ((id & CAN_ERR_BUSOFF) != 0) {
    throw BusDownError(quoted(interface_) + " is bus-off: its controller has left the bus after too many errors. Check "
                       "wiring, termination and bit rate, then: ip link set " + interface_ + " down && ip link set " +
                       interface_ + " up");
  }
}

void SocketCan::drain(std::vector<Arrival>& out) {
  for (unsigned count = kBatch; count == kBatch;) {
    count = read_batch(kBatch);
    for (unsigned i = 0; i < count; ++i) {
      if (auto a = arrival(i)) out.push_back(*a);
    }
  }
}

std::size_t SocketCan::receive(Frame* frames, std::size_t capacity) {
  std::size_t taken = 0;
  while (taken < capacity) {
    const auto wanted = static_cast<unsigned>(std::min<std::size_t>(capacity - taken, kBatch));
    const unsigned count = read_batch(wanted);
    for (unsigned i = 0; i < count; ++i) {
      if (auto a = arrival(i)) frames[taken++] = a->frame;
    }
    if (count < wanted) break;
  }
  return taken;
}

void SocketCan::send(const Frame* frames, std::size_t count) {
  for (std::size_t begin = 0; begin < count; begin += kBatch) {
    const auto size = static_cast<unsigned>(std::min<std::size_t>(count - begin, kBatch));
    for (unsigned i = 0; i < size; ++i) {
      const Frame& frame = frames[begin + i];
      can_frame& raw = batch_->frames[i];
      raw = {};
      raw.can_id = frame.id;
      raw.len = frame.dlc;
      std::copy_n(frame.data, Frame::kMaxBytes, raw.data);
      batch_->headers[i].msg_hdr.msg_control = nullptr;
      batch_->headers[i].msg_hdr.msg_controllen = 0;
    }
    const SendOutcome outcome = send_all(
        size, [&](unsigned first) { return ::sendmmsg(descriptor_.get(), &batch_->headers[first], size - first, 0); },
        [] {
          const timespec pause{0, kSendRetryWait_us * 1000};
          ::nanosleep(&pause, nullptr);
        });
    counters_.send_retries += static_cast<std::uint64_t>(outcome.retries);
    if (outcome.error != 0) fail_on_bus(interface_, outcome.error, "send");
  }
}

bool SocketCan::send(const TxQueue& frames) {
  send(frames.begin(), frames.size());
  return true;
}

}  // namespace voltlap::port

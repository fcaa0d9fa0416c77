// SPDX-License-Identifier: Apache-2.0
// Sends a batch over a driver with a bounded queue: what did not fit is tried again, for a bounded time.
#pragma once
#include <cerrno>
#include <cstdint>

namespace voltlap::port {

inline constexpr int kSendRetriesMax = 500;
inline constexpr std::int64_t kSendRetryWait_us = 200;  // 500 of them: 100 ms, the time of 400 frames at 500 kbit/s

struct SendOutcome {
  unsigned sent = 0;
  int retries = 0;
  int error = 0;  ///< 0: all went out
};

/// `try_send(first)` returns how many frames from `first` on went out, at least 1, or -1 with errno. `wait()` lets
/// the driver make room. A full queue (ENOBUFS) has no event to wait for.
template <class TrySend, class Wait>
SendOutcome send_all(unsigned count, const TrySend& try_send, const Wait& wait) {
  SendOutcome out;
  while (out.sent < count) {
    const int sent = try_send(out.sent);
    if (sent > 0) {
      out.sent += static_cast<unsigned>(sent);
      continue;
    }
    if (errno == EINTR) continue;
    const bool full = errno == ENOBUFS || errno == EAGAIN;
    if (!full || out.retries == kSendRetriesMax) {
      out.error = errno;
      return out;
    }
    ++out.retries;
    wait();
  }
  return out;
}

}  // namespace voltlap::port

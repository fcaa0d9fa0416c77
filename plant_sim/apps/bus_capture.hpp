// SPDX-License-Identifier: Apache-2.0
// Everything that is heard on a CAN interface into a growing candump log, by a thread of its own, with the kernel's
// stamps. It only listens: nothing is ever written to its socket.
#pragma once
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

#include "io/growing_file.hpp"
#include "port/host/socket_can.hpp"

namespace voltlap::plant {

class BusCapture {
 public:
  /// Listens from here on. Throws port::BusSetupError; `log` must outlive it.
  BusCapture(port::SocketCan& socket, GrowingFile& log);
  ~BusCapture() { stop(); }
  BusCapture(const BusCapture&) = delete;
  BusCapture& operator=(const BusCapture&) = delete;

  /// While it is held, what is heard waits in memory: who reads the log meets whole lines and a fixed end.
  void hold() { held_.lock(); }
  void release() { held_.unlock(); }

  [[nodiscard]] std::uint64_t frames() const { return frames_.load(); }
  /// The bus went down, or the log can no longer be written.
  [[nodiscard]] bool ended() const { return ended_.load(); }
  /// Everything that was heard is in the log.
  void stop();
  /// After the end: frames that came faster than they were read; what ended it, if anything.
  [[nodiscard]] std::uint64_t dropped() const { return socket_.counters().dropped; }
  [[nodiscard]] std::exception_ptr failure() const { return failure_; }

 private:
  void listen();
  void take(bool last);
  void keep(bool wait);

  port::SocketCan& socket_;
  GrowingFile& log_;
  std::vector<port::Arrival> arrivals_;
  std::string waiting_;  ///< heard, and not in the log yet
  std::mutex held_;
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<bool> ended_{false}, stop_{false};
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace voltlap::plant

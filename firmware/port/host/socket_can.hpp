// SPDX-License-Identifier: Apache-2.0
// A raw SocketCAN socket: filtered in the kernel, read and written in batches, loss and errors counted.
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "port/can.hpp"
#include "port/host/can_interface.hpp"

namespace voltlap::port {

/// Frames with (id & mask) == (filter id & mask) pass; bit 31 is the flag of 29-bit identifiers, as in Frame.
struct CanFilter {
  std::uint32_t id = 0, mask = 0;
};
/// One identifier; the kernel finds such a filter without a search.
[[nodiscard]] CanFilter only(std::uint32_t id);
/// Every frame.
inline constexpr CanFilter kEveryFrame{};

struct SocketOptions {
  std::vector<CanFilter> filters{};      ///< none: nothing is received
  bool own_frames = false;               ///< frames sent here are received here too, marked
  bool error_frames = false;             ///< counted; bus-off throws
  bool time_stamps = false;              ///< the kernel's time of arrival
  std::chrono::milliseconds wait{100};   ///< longest `wait`
};

struct Arrival {
  Frame frame;
  bool own = false;          ///< sent through this very socket
  std::int64_t time_us = 0;  ///< since the epoch, with `time_stamps`
};

struct SocketCounters {
  std::uint64_t dropped = 0;       ///< lost because nobody read in time
  std::uint64_t error_frames = 0;
  std::uint64_t send_retries = 0;  ///< the driver's queue was full
};

/// Throws BusSetupError when made, BusDownError when used.
class SocketCan final : public Can {
 public:
  SocketCan(std::string interface, const SocketOptions& options);
  ~SocketCan();
  SocketCan(const SocketCan&) = delete;
  SocketCan& operator=(const SocketCan&) = delete;

  void filter(const std::vector<CanFilter>& filters);

  /// The next frame; nothing after the longest wait, or when a signal came.
  [[nodiscard]] std::optional<Frame> wait();
  /// Everything that has arrived, added to `out`; never waits.
  void drain(std::vector<Arrival>& out);
  void send(const Frame* frames, std::size_t count);

  std::size_t receive(Frame* frames, std::size_t capacity) override;
  bool send(const TxQueue& frames) override;

  [[nodiscard]] const std::string& interface() const { return interface_; }
  [[nodiscard]] const SocketCounters& counters() const { return counters_; }

 private:
  struct Batch;
  /// Puts one batch into batch_ and returns its size.
  unsigned read_batch(unsigned capacity);
  /// The frame at a place of the batch; nothing for error and remote frames.
  std::optional<Arrival> arrival(unsigned index);
  void note_error_frame(std::uint32_t id);

  std::string interface_;
  CanDescriptor descriptor_;
  SocketCounters counters_;
  std::unique_ptr<Batch> batch_;
};

}  // namespace voltlap::port

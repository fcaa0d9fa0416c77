// SPDX-License-Identifier: Apache-2.0
// Sends a list of frames at their own pace. Each frame has its absolute time on one monotonic clock, whatever became of
// those before: a late frame moves no other. Frames that are overdue go out at once; none is left out.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>

#include "io/play/lateness.hpp"
#include "io/play/play_list.hpp"

namespace voltlap::plant {

class PlayClock {
 public:
  virtual ~PlayClock() = default;
  [[nodiscard]] virtual std::int64_t now_ns() = 0;
  /// May end early, when a signal comes.
  virtual void sleep_until(std::int64_t at_ns) = 0;
};

/// CLOCK_MONOTONIC. The timers of the calling thread are as sharp as the kernel can make them from here on.
class MonotonicClock final : public PlayClock {
 public:
  MonotonicClock();
  [[nodiscard]] std::int64_t now_ns() override;
  void sleep_until(std::int64_t at_ns) override;
};

class PlaySink {
 public:
  virtual ~PlaySink() = default;
  virtual void send(const PlayFrame& frame) = 0;
};

struct PlayPlan {
  double speed = 1.0;        ///< times the recording's own; 0: as fast as they can be sent
  std::uint64_t rounds = 1;  ///< 0: until it is stopped
};

struct PlayResult {
  std::uint64_t sent = 0, rounds = 0;  ///< whole rounds
  std::int64_t took_ns = 0;            ///< from the first frame to the last
  std::int64_t planned_ns = 0;         ///< the same, as it should be
  Lateness lateness{};                 ///< with a pace
};

class Player {
 public:
  Player(const PlayList& list, PlayPlan plan, PlayClock& clock, PlaySink& sink)
      : list_(list), plan_(plan), clock_(clock), sink_(sink) {}

  /// Until the end, or until `stop` says so. What was sent is in result() even when the sink throws.
  void run(const std::function<bool()>& stop);
  [[nodiscard]] const PlayResult& result() const { return result_; }
  /// May be asked from another thread.
  [[nodiscard]] std::uint64_t sent() const { return sent_.load(std::memory_order_relaxed); }

 private:
  [[nodiscard]] std::int64_t due_ns(std::uint64_t round, std::int64_t at_ns) const;
  [[nodiscard]] bool wait_until(std::int64_t due_ns, const std::function<bool()>& stop);
  void note(std::int64_t due_ns);

  const PlayList& list_;
  PlayPlan plan_;
  PlayClock& clock_;
  PlaySink& sink_;
  PlayResult result_;
  std::atomic<std::uint64_t> sent_{0};
  std::int64_t start_ns_ = 0, first_ns_ = 0;
};

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
#include "io/play/player.hpp"

#include <sys/prctl.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kLead_ns = 5'000'000;    // the first frame is waited for as the others are
constexpr std::int64_t kLook_ns = 100'000'000;  // a stop is seen so often

}  // namespace

MonotonicClock::MonotonicClock() {
  // A sleep is rounded up by 50 us otherwise.
  ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
}

std::int64_t MonotonicClock::now_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecond_ns + now.tv_nsec;
}

void MonotonicClock::sleep_until(std::int64_t at_ns) {
  const timespec at{static_cast<time_t>(at_ns / kSecond_ns), static_cast<long>(at_ns % kSecond_ns)};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
}

std::int64_t Player::due_ns(std::uint64_t round, std::int64_t at_ns) const {
  const std::int64_t recorded_ns = static_cast<std::int64_t>(round) * list_.round_ns() + at_ns;
  if (plan_.speed == 1.0) return start_ns_ + recorded_ns;
  return start_ns_ + std::llround(static_cast<double>(recorded_ns) / plan_.speed);
}

/// False when it was stopped meanwhile.
bool Player::wait_until(std::int64_t due_ns, const std::function<bool()>& stop) {
  for (std::int64_t now = clock_.now_ns(); now < due_ns; now = clock_.now_ns()) {
    if (stop()) return false;
    clock_.sleep_until(std::min(due_ns, now + kLook_ns));
  }
  return !stop();
}

void Player::note(std::int64_t due_ns) {
  const std::int64_t now = clock_.now_ns();
  const bool paced = plan_.speed > 0.0;
  if (result_.sent++ == 0) first_ns_ = now;
  result_.took_ns = now - first_ns_;
  sent_.store(result_.sent, std::memory_order_relaxed);
  if (!paced) return;
  result_.planned_ns = due_ns - start_ns_;
  result_.lateness.add(now - due_ns);
}

void Player::run(const std::function<bool()>& stop) {
  VOLTLAP_DEMAND(!list_.empty() && plan_.speed >= 0.0 && std::isfinite(plan_.speed));
  VOLTLAP_DEMAND(plan_.rounds == 1 || list_.round_ns() > 0);
  result_ = {};
  start_ns_ = clock_.now_ns() + kLead_ns;
  for (std::uint64_t round = 0; plan_.rounds == 0 || round < plan_.rounds; ++round) {
    for (std::size_t k = 0; k < list_.size(); ++k) {
      const PlayFrame frame = list_[k];
      const std::int64_t due = plan_.speed > 0.0 ? due_ns(round, frame.at_ns) : 0;
      if (!wait_until(due, stop)) return;
      sink_.send(frame);
      note(due);
    }
    result_.rounds = round + 1;
  }
}

}  // namespace voltlap::plant

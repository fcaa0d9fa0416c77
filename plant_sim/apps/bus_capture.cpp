// SPDX-License-Identifier: Apache-2.0
#include "apps/bus_capture.hpp"

#include <chrono>

#include "can_dbc/tables.hpp"
#include "io/bus/candump_file.hpp"
#include "port/host/pacer.hpp"

namespace voltlap::plant {
namespace {

constexpr unsigned kWriteEvery = 20;  // reads of the socket

}  // namespace

BusCapture::BusCapture(port::SocketCan& socket, GrowingFile& log)
    : socket_(socket), log_(log), thread_([this] { listen(); }) {}

void BusCapture::stop() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
}

void BusCapture::take(bool last) {
  arrivals_.clear();
  try {
    socket_.drain(arrivals_);
  } catch (...) {
    failure_ = std::current_exception();
  }
  for (const port::Arrival& a : arrivals_) {
    waiting_ += candump_line(std::chrono::microseconds(a.time_us), a.frame, socket_.interface());
    waiting_ += '\n';
  }
  frames_ += arrivals_.size();
  if (failure_ || last) keep(true);
}

/// What was heard into the log, unless somebody reads it; `wait`: then.
void BusCapture::keep(bool wait) {
  std::unique_lock lock(held_, std::defer_lock);
  if (wait) {
    lock.lock();
  } else if (!lock.try_lock()) {
    return;
  }
  log_.write(waiting_);
  waiting_.clear();
}

void BusCapture::listen() {
  try {
    port::Pacer pacer(can::kTickMs * 1000, port::Lag::kForget);
    for (unsigned k = 1; !failure_; ++k) {
      const bool last = stop_.load();
      if (!last) pacer.wait();
      take(last);
      if (last) break;
      if (k % kWriteEvery == 0 && !failure_) keep(false);
    }
  } catch (...) {
    failure_ = std::current_exception();
  }
  ended_.store(true);
}

}  // namespace voltlap::plant

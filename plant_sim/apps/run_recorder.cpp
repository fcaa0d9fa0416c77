// SPDX-License-Identifier: Apache-2.0
#include "apps/run_recorder.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>

#include "apps/exit_code.hpp"

namespace voltlap::plant {
namespace {

// A signal handler has no other way in; only this file sees it.
std::atomic<int> interrupt_signal{0};  // the signal's number
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may only touch a lock-free flag");

constexpr std::chrono::milliseconds kTerminalPeriod{200};
constexpr std::chrono::seconds kLogPeriod{5};

bool to_terminal() {
  static const bool terminal = ::isatty(STDERR_FILENO) == 1;
  return terminal;
}

}  // namespace

void catch_interrupt() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    std::signal(signal, [](int number) { interrupt_signal.store(number); });
  }
}

int exit_code_of_interrupt() {
  constexpr int kBySignal = 128;  // as shells count
  const int number = interrupt_signal.load();
  return number == 0 || number == SIGINT ? kExitInterrupted : kBySignal + number;
}

bool interrupted() { return interrupt_signal.load() != 0; }

void RunRecorder::on_frame(std::uint32_t tick, Sender sender, const Frame& frame) {
  hash.on_frame(tick, sender, frame);
  if (candump) candump->on_frame(tick, sender, frame);
  if (load) load->on_frame(tick, sender, frame);
}

void RunRecorder::on_sample(const TimeSample& sample) {
  if (series) series->add(sample);
  if (report) report->add(sample);
  trace.add(sample);
}

void RunRecorder::on_progress(double fraction, double time_s) {
  const auto now = std::chrono::steady_clock::now();
  if (to_terminal() ? now - shown_ < kTerminalPeriod : now - shown_ < kLogPeriod) return;
  shown_ = now;
  const std::string share = fraction < 0.0 ? "" : fmt::format(" {:3.0f} %,", 100.0 * fraction);
  fmt::print(stderr, "{}driving:{} {:.0f} s of the race{}", to_terminal() ? "\r" : "", share, time_s,
             to_terminal() ? "   " : "\n");
  std::fflush(stderr);
  line_open_ = to_terminal();
}

bool RunRecorder::stop_requested() { return interrupted(); }

void RunRecorder::end_progress() {
  if (line_open_) fmt::print(stderr, "\r{:60}\r", "");
  line_open_ = false;
}

void RunRecorder::complete() {
  if (series) series->complete();
  if (candump) candump->complete();
}

void RunRecorder::commit() {
  if (series) series->commit();
  if (candump) candump->commit();
  if (report) report->commit();
}

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
#include "apps/limit_race.hpp"

#include <algorithm>
#include <deque>

#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/soc_listener.hpp"
#include "bms/faults.hpp"

namespace voltlap::plant {
namespace {

constexpr auto kCellVoltageReason = static_cast<std::size_t>(can::LimitReason::kCellVoltage);

/// Counts how often a limit falls and rises again, each by so much, within the time.
class Reversals {
 public:
  void add(double time_s, double limit_a) {
    while (!window_.empty() && window_.front().time_s < time_s - kReversal_s) window_.pop_front();
    window_.push_back({time_s, limit_a});
    double highest = window_.front().limit_a, fallen_to = highest;
    for (const Point& p : window_) {
      if (p.limit_a > highest && fallen_to > highest - kReversal_a) highest = fallen_to = p.limit_a;
      fallen_to = std::min(fallen_to, p.limit_a);
      if (highest - fallen_to < kReversal_a || p.limit_a - fallen_to < kReversal_a) continue;
      ++count_;
      window_ = {p};
      return;
    }
  }
  void pause() { window_.clear(); }
  [[nodiscard]] int count() const { return count_; }

 private:
  struct Point {
    double time_s, limit_a;
  };
  std::deque<Point> window_;
  int count_ = 0;
};

class RaceWatch final : public Ecus, public EnduranceObserver {
 public:
  RaceWatch(const EnduranceOptions& options, const bms::Config& config, const std::function<bool(double)>& progress)
      : firmware_(config, master_config(options.vehicle)), progress_(progress) {}

  void bms(Instant now, FrameView rx, TxQueue& tx) override {
    firmware_.bms(now, rx, tx);
    const bms::Output& out = firmware_.bms_node().output();
    result.under_voltage |= (out.faults & bms::bit_of(can::BmsFault::kCellVoltageLow)) != 0;
    if (!binds_) return;
    reversals_.add(1e-3 * now.ms(), 1e-3 * out.limits.discharge.value.raw());
  }
  void master(Instant now, FrameView rx, TxQueue& tx) override { firmware_.master(now, rx, tx); }
  void on_frame(std::uint32_t, Sender, const Frame&) override {}
  void on_sample(const TimeSample& sample) override {
    binds_ = sample.limit_reason == kCellVoltageReason;
    if (binds_) result.bound_s += 0.1;
    if (!binds_) reversals_.pause();
    result.reversals = reversals_.count();
  }
  void on_progress(double fraction, double) override { stop_ = progress_(fraction); }
  [[nodiscard]] bool stop_requested() override { return stop_; }

  LimitRaceResult result;

 private:
  FirmwareLoop firmware_;
  const std::function<bool(double)>& progress_;
  Reversals reversals_;
  bool binds_ = false, stop_ = false;
};

}  // namespace

LimitRaceResult run_limit_race(const EnduranceOptions& options, bms::LimitMethod method, double resistance,
                               const std::function<bool(double)>& progress) {
  bms::Config config = mistaken(bms_config(options.vehicle), {.resistance = resistance});
  config.limit_method = method;
  RaceWatch watch(options, config, progress);
  watch.result.drive = run_endurance(options, watch, watch);
  watch.result.lowest_cell_v = watch.result.drive.min_cell_voltage_v;
  return watch.result;
}

}  // namespace voltlap::plant

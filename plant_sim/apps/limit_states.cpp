// SPDX-License-Identifier: Apache-2.0
#include "apps/limit_states.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/limit_bisection.hpp"
#include "bms/limits/ahead.hpp"
#include "bms/limits/limits.hpp"
#include "car/battery/pack.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kLearning_s = 120.0;   // of driving, before anything is asked
constexpr double kRenewal_s = 0.01;
constexpr double kSample_s = 0.1;

struct Place {
  bool discharge;
  std::size_t horizon;
};

/// The pack after a constant current, in a copy of it.
double inside_after(const Pack& now, const VehicleParameters& car, double current_a, double time_s, double step_s) {
  Pack pack = now;
  const auto steps = static_cast<int>(std::lround(kRenewal_s / step_s));
  for (double t = 0.0; t < time_s - 0.5 * kRenewal_s; t += kRenewal_s) {
    for (int i = 0; i < steps; ++i) pack.advance(current_a);
    pack.renew(kRenewal_s, car.environment.ambient_c);
  }
  double lowest = pack.cell_voltage_after_step(0), highest = lowest;
  for (std::size_t k = 1; k < pack.cells(); ++k) {
    lowest = std::min(lowest, pack.cell_voltage_after_step(k));
    highest = std::max(highest, pack.cell_voltage_after_step(k));
  }
  return current_a >= 0.0 ? lowest : highest;
}

class Moments final : public Ecus, public EnduranceObserver {
 public:
  Moments(const LimitDrive& drive, const std::function<bool(double)>& progress)
      : drive_(drive),
        config_(bms_config(drive.options.vehicle)),
        firmware_(drive.options.vehicle),
        progress_(progress),
        random_(drive.seed) {}

  void bms(Instant now, FrameView rx, TxQueue& tx) override { firmware_.bms(now, rx, tx); }
  void master(Instant now, FrameView rx, TxQueue& tx) override { firmware_.master(now, rx, tx); }
  void on_frame(std::uint32_t, Sender, const Frame&) override {}
  void on_progress(double fraction, double) override {
    fraction_ = std::max(fraction, fraction_);
    stop_ = progress_(fraction);
  }
  [[nodiscard]] bool stop_requested() override { return stop_; }

  /// As many moments as are asked for over what is left of the drive.
  void on_sample(const TimeSample& sample) override {
    if (sample.time_s < kLearning_s || fraction_ <= 0.0) return;
    const double whole_s = sample.time_s / fraction_;
    const double samples = std::max(1.0, (whole_s - kLearning_s) / kSample_s);
    if (!std::bernoulli_distribution(std::min(1.0, drive_.moments / samples))(random_)) return;
    const double temperature_c = (*sample.cell_temperature_c)[0];
    for (const bool discharge : {true, false}) {
      for (std::size_t h = 0; h < kTriedHorizons; ++h) {
        LimitMoment moment{drive_.seed, sample.time_s, sample.soc, temperature_c, h, discharge, 0.0, {}, {}, {}};
        try_limits({discharge, h}, *sample.pack, moment);
        found_.push_back(moment);
      }
    }
  }

  [[nodiscard]] std::vector<LimitMoment> take() { return std::move(found_); }

 private:
  void try_limits(const Place& place, const Pack& pack, LimitMoment& out) const {
    const bms::State& state = firmware_.bms_node().state();
    look_ahead(place, state, out);
    out.equation = sibling(bms::LimitMethod::kEquation, place, state);
    out.table = sibling(bms::LimitMethod::kTable, place, state);
    const double time_s = 1e-3 * bms::kLimitHorizons[place.horizon].ms();
    const double step_s = kRenewal_s / drive_.options.steps_per_tick;
    for (LimitTrial* trial : {&out.ahead, &out.equation, &out.table}) {
      const double a = place.discharge ? trial->limit_a : -trial->limit_a;
      const double end_v = inside_after(pack, drive_.options.vehicle, a, time_s, step_s);
      trial->inside_v = place.discharge ? end_v - 1e-4 * config_.cell_voltage_min.raw()
                                        : 1e-4 * config_.cell_voltage_max.raw() - end_v;
    }
  }

  /// The least over the cells, each from its filter as it is now; and the same by bisection.
  void look_ahead(const Place& place, const bms::State& state, LimitMoment& out) const {
    using bms::Direction;
    const bms::HorizonBound bound =
        place.discharge
            ? bms::HorizonBound{Direction::kDischarge, config_.cell_voltage_min, config_.discharge_current_max.raw()}
            : bms::HorizonBound{Direction::kCharge, config_.cell_voltage_max, config_.charge_current_max.raw()};
    const bms::SocFilter& filter = state.soc.filter;
    const Duration time = bms::kLimitHorizons[place.horizon];
    const bms::Horizon horizon = bms::make_horizon(config_, filter, time, bms::heat_change(filter));
    double least = bound.most_ma, least_bisected = bound.most_ma;
    for (std::size_t k = 0; k < config_.cells_in_series; ++k) {
      const bms::CellAhead& last = state.ahead.cell[k];
      const std::int32_t from = place.discharge ? last.discharge[place.horizon] : last.charge[place.horizon];
      const std::int32_t warmer = bms::own_warmth(state, k);
      const bms::CellFilter& own = filter.cell[k].filter;
      const std::int32_t found =
          bms::current_until({filter, own, horizon, bms::prudent_fade(own), warmer}, bound, from);
      const LimitBisection bisection(config_, filter, k, time, warmer);
      least_bisected = std::min(least_bisected, bisection.current_ma(bound));
      if (found >= least) continue;
      least = found;
      const double v = bisection.end_v(place.discharge ? found : -found);
      out.ahead.by_voltage = std::abs(v - 1e-4 * bound.voltage.raw()) < 0.005;
    }
    out.ahead.limit_a = 1e-3 * least;
    out.bisected_a = 1e-3 * least_bisected;
  }

  [[nodiscard]] LimitTrial sibling(bms::LimitMethod method, const Place& place, const bms::State& state) const {
    bms::Config own = config_;
    own.limit_method = method;
    const bms::Limit limit =
        place.discharge ? bms::discharge_ceiling(own, state) : bms::charge_ceiling(own, state);
    return {1e-3 * limit.value.raw(), limit.reason == can::LimitReason::kCellVoltage, 0.0};
  }

  const LimitDrive& drive_;
  bms::Config config_;
  FirmwareLoop firmware_;
  const std::function<bool(double)>& progress_;
  std::mt19937_64 random_;
  std::vector<LimitMoment> found_;
  double fraction_ = 0.0;
  bool stop_ = false;
};

}  // namespace

std::vector<LimitMoment> run_limit_drive(const LimitDrive& drive, const std::function<bool(double)>& progress) {
  VOLTLAP_DEMAND(drive.options.vehicle.bms.limit_method == "ahead");
  Moments moments(drive, progress);
  (void)run_endurance(drive.options, moments, moments);
  return moments.take();
}

}  // namespace voltlap::plant

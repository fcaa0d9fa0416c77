// SPDX-License-Identifier: Apache-2.0
#include "apps/soc_trial.hpp"

#include <cmath>

#include "apps/firmware_config.hpp"
#include "apps/firmware_loop.hpp"
#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kUnjudged = 0.1;         // of the charge, the first of the drive
constexpr double kRestart_s = 30.0;       // of the drive, when a restarted BMS begins to listen
constexpr double kNothing_a = 1.0;        // up to it nothing is drawn

class Audience final : public Ecus, public EnduranceObserver {
 public:
  Audience(const EnduranceOptions& options, const std::vector<SocCase>& cases,
           const std::function<bool(double)>& progress)
      : firmware_(options.vehicle), progress_(progress) {
    const bms::Config config = bms_config(options.vehicle);
    for (const SocCase& each : cases) {
      for (const bms::SocMethod method : {bms::SocMethod::kEkf, bms::SocMethod::kCoulomb}) {
        bms::Config own = config;
        own.soc_method = method;
        listeners_.emplace_back(own, each.errors, options.vehicle.sensors, options.seed + listeners_.size());
      }
    }
  }

  void bms(Instant now, FrameView rx, TxQueue& tx) override {
    firmware_.bms(now, rx, tx);
    for (SocListener& listener : listeners_) listener.tick(now, rx, rests_);
  }
  void master(Instant now, FrameView rx, TxQueue& tx) override { firmware_.master(now, rx, tx); }

  void on_frame(std::uint32_t, Sender, const Frame&) override {}
  void on_sample(const TimeSample& sample) override {
    const SocTruth truth{sample.soc, *sample.cell_soc};
    if (std::abs(sample.pack_current_a) > kNothing_a) rests_ = false;
    if (std::isnan(begin_soc_)) begin_soc_ = sample.soc;
    const bool judged = sample.soc < begin_soc_ - kUnjudged;
    judged_ += judged ? 1 : 0;
    for (SocListener& listener : listeners_) {
      if (listener.waits() && sample.time_s >= kRestart_s) listener.begin(truth);
      if (judged) listener.judge(truth);
    }
  }
  void on_progress(double fraction, double) override { stop_ = progress_(fraction); }
  [[nodiscard]] bool stop_requested() override { return stop_; }

  [[nodiscard]] const std::vector<SocListener>& listeners() const { return listeners_; }
  [[nodiscard]] double judged_s() const { return 0.1 * judged_; }

 private:
  FirmwareLoop firmware_;
  const std::function<bool(double)>& progress_;
  std::vector<SocListener> listeners_;
  bool rests_ = true, stop_ = false;
  int judged_ = 0;
  double begin_soc_ = std::nan("");
};

SocScores scores_of(const SocListener& listener) { return {listener.pack(), listener.weakest()}; }

}  // namespace

SocTrialResult run_soc_trial(const EnduranceOptions& options, const std::vector<SocCase>& cases,
                             const std::function<bool(double)>& progress) {
  VOLTLAP_DEMAND(options.vehicle.bms.soc_method == "ekf");
  Audience audience(options, cases, progress);
  SocTrialResult out;
  out.drive = run_endurance(options, audience, audience);
  out.judged_s = audience.judged_s();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const SocListener& ekf = audience.listeners()[2 * i];
    const SocListener& coulomb = audience.listeners()[2 * i + 1];
    out.rows.push_back({cases[i].name, scores_of(ekf), scores_of(coulomb)});
  }
  return out;
}

}  // namespace voltlap::plant

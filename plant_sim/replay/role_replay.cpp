// SPDX-License-Identifier: Apache-2.0
#include "replay/role_replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "core/demand.hpp"
#include "core/listed.hpp"
#include "replay/cell_limits.hpp"
#include "replay/input_frames.hpp"
#include "replay/soc_start.hpp"

namespace voltlap::plant {
namespace {

constexpr double kTick_s = 1e-3 * can::kTickMs;

/// Contactors that follow their commands, and the capacitor behind them.
class IdealContacts {
 public:
  void follow(const can::ContactorCommand& command, double pack_v) {
    constexpr double kCharge_s = 0.1, kDischarge_s = 0.3;  // chosen: within every bound of the BMS
    air_plus = command.air_plus_close;
    air_minus = command.air_minus_close;
    precharge = command.precharge_close;
    const bool connected = air_minus && (air_plus || precharge);
    const double target_v = connected && std::isfinite(pack_v) ? pack_v : 0.0;
    const double share = air_plus && connected ? 1.0 : kTick_s / (connected ? kCharge_s : kDischarge_s);
    link_v += (target_v - link_v) * share;
  }
  bool air_plus = false, air_minus = false, precharge = false;
  double link_v = 0.0;
};

class RoleReplay {
 public:
  RoleReplay(const DriveLog& log, const ReplayCar& car, const PedalSensors& pedals, bool with_model, Ecus& ecus,
             ReplayResult& result)
      : inputs_(log, car),
        frames_(car.cells, car.thermistors, pedals, [this](std::size_t i) { return inputs_.cell(i); },
                [this](std::size_t i) { return inputs_.thermistor(i); }),
        loop_(ecus),
        watch_(result, with_model),
        result_(result),
        full_brake_bar_(car.full_brake_bar) {
    if (!with_model || !inputs_.begins_under_load() || car.ocv.empty() || !(car.capacity_ah > 0.0)) return;
    start_ = soc_under_load(log, car, inputs_.begin_s(), result.soc_jump.has_value());
    start_v_ = ocv_of_soc(car, start_->soc);
  }

  void run() {
    result_.begin_s = inputs_.begin_s();
    result_.duration_s = std::max(0.0, inputs_.end_s() - inputs_.begin_s());
    result_.assumptions = inputs_.assumptions();
    if (start_) {
      result_.assumptions.push_back(start_->said);
      result_.soc_from = start_->source;
    }
    const auto begin = std::chrono::steady_clock::now();
    const auto steps = static_cast<std::size_t>(std::floor(result_.duration_s / kTick_s + 1e-6)) + 1;
    show_before();
    for (std::size_t k = 0; k < steps; ++k) {
      time_s_ = inputs_.begin_s() + kTick_s * static_cast<double>(k);
      inputs_.advance(time_s_);
      if (restart_due()) bring_up();
      drive(k % kMomentTicks == 0);
    }
    watch_.finish();
    result_.firmware_s = kTick_s * tick_;
    result_.computed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }

 private:
  static constexpr std::size_t kMomentTicks = 10;  // every cell is looked at so often

  /// What the recording says before the firmware is started belongs to the picture.
  void show_before() {
    constexpr double kStep_s = 0.1;
    for (double t = inputs_.recorded_from_s(); t < inputs_.begin_s(); t += kStep_s) {
      inputs_.advance(t);
      watch_.tick(t, said_, inputs_.moment());
    }
  }

  [[nodiscard]] bool active() const { return said_.bms.state == can::BmsState::kTsActive; }

  /// A tick of the recording. A BMS that has opened waits for its restart: what the recording's cells do under a load
  /// that it does not carry it never sees.
  void drive(bool look_at_all) {
    Readings readings = inputs_.readings();
    const double logged_a = readings.current_a;
    if (active() || contacts_.air_plus) {
      readings.switches.shutdown_closed = true;
      const bool was_active = active();
      step(readings);
      if (was_active && !active()) next_try_s_ = time_s_ + kRetry_s;
    } else if (std::isfinite(logged_a)) {
      result_.open_s += kTick_s;
      result_.open_ah += logged_a * kTick_s / 3600.0;
    }
    if (look_at_all) moment_ = inputs_.moment();
    moment_.current_a = logged_a;
    watch_.tick(time_s_, said_, moment_);
  }

  /// At rest where one comes soon: a restart under load leaves the firmware a step of current without its sag.
  [[nodiscard]] bool restart_due() const {
    if (active() || time_s_ < next_try_s_) return false;
    return !tried_ || std::abs(inputs_.current_a()) <= kRest_a || time_s_ >= next_try_s_ + kWithoutRest_s;
  }

  /// The recording stands still until the units are ready to drive, or for as long as a driver would try.
  void bring_up() {
    const double longest_s = tried_ ? kRestart_s : kStartUp_s;
    double active_s = 0.0;
    if (!tried_) inputs_.show_alike(start_v_);
    for (double t = 0.0; t < longest_s && active_s < kRisen_s; t += kTick_s) {
      Readings readings = inputs_.readings();
      if (std::isfinite(readings.current_a)) readings.current_a = 0.0;
      readings.phase_current_a = readings.motor_speed_rpm = readings.accelerator = 0.0;
      readings.brake_bar = full_brake_bar_;
      readings.switches = switches(t, active_s);
      step(readings);
      watch_.note_faults(time_s_, said_);
      active_s = active() ? active_s + kTick_s : 0.0;
    }
    inputs_.show_alike(kUnknown);
    if (tried_ && active()) result_.closed_again_s.push_back(time_s_);
    tried_ = true;
    next_try_s_ = time_s_ + kRetry_s;
    if (active()) {
      if (!ready_once_ && !result_.never_ready.empty()) {
        result_.assumptions.push_back(fmt::format("the firmware was ready at {:.1f} s only: {}", time_s_,
                                                  result_.never_ready));
      }
      ready_once_ = true;
      result_.never_ready.clear();
    } else if (!ready_once_ && result_.never_ready.empty()) {
      result_.never_ready = fmt::format("it waits for {}, faults: {}",
                                        can::kWaitsForNames[static_cast<std::size_t>(said_.contactors.waits_for)],
                                        said_.bms.faults == 0 ? "none" : bms_fault_names(said_.bms.faults));
    }
  }

  [[nodiscard]] Switches switches(double time_s, double active_s) const {
    constexpr double kHeard_s = 0.5, kReset_s = 0.2, kPeriod_s = 1.5;
    const double in_period = std::fmod(time_s, kPeriod_s);
    Switches out;
    out.shutdown_closed = true;
    out.reset = tried_ && !active() && in_period >= kHeard_s && in_period < kHeard_s + kReset_s;
    out.ts_on = !active() && in_period >= kHeard_s + 2.0 * kReset_s;
    out.ready_to_drive = active_s >= kRisen_s - 2.0 * kReset_s;
    return out;
  }

  void step(Readings& readings) {
    contacts_.follow(said_.contactors, readings.pack_v);
    readings.air_plus = contacts_.air_plus;
    readings.air_minus = contacts_.air_minus;
    readings.precharge = contacts_.precharge;
    readings.dc_link_v = contacts_.link_v;
    loop_.begin_tick(tick_);
    tx_.clear();
    frames_.send(Instant::from_ms(tick_ * can::kTickMs), readings, tx_);
    for (const Frame& frame : loop_.exchange(tx_)) said_.take(frame);
    ++tick_;
  }

  static constexpr double kStartUp_s = 20.0, kRestart_s = 6.0, kRetry_s = 1.0;
  static constexpr double kRest_a = 5.0, kWithoutRest_s = 2.0;
  static constexpr double kRisen_s = 2.5;  // active for so long: the limits have risen

  RoleInputs inputs_;
  InputFrames frames_;
  InProcessLoop loop_;
  FirmwareWatch watch_;
  ReplayResult& result_;
  double full_brake_bar_;
  std::optional<SocStart> start_{};
  double start_v_ = kUnknown;
  IdealContacts contacts_{};
  Said said_{};
  LoggedMoment moment_{};
  TxQueue tx_;
  std::uint32_t tick_ = 0;
  double time_s_ = 0.0, next_try_s_ = -1e300;
  bool tried_ = false, ready_once_ = false;
};

/// Stretches without any reading of the battery.
void find_holes(const DriveLog& log, ReplayResult& result) {
  constexpr double kShortest_s = 0.5, kIntervals = 5.0;
  const Channel& current = *log.find("current");
  std::vector<const Channel*> voltages;
  for (const char* role : {"voltage", "pack_voltage", "bus_voltage"}) {
    if (const Channel* channel = log.find(role)) voltages.push_back(channel);
  }
  for (const auto& [n, channel] : log.numbered("cell_voltage_")) voltages.push_back(channel);
  const double longest_s = std::max(kShortest_s, kIntervals * usual_interval_s({&current}));
  for (std::size_t k = 1; k < current.size(); ++k) {
    const double begin_s = current.time_s[k - 1], end_s = current.time_s[k];
    if (end_s - begin_s <= longest_s) continue;
    const double margin_s = 0.1 * (end_s - begin_s);
    const bool silent = std::none_of(voltages.begin(), voltages.end(), [&](const Channel* channel) {
      const auto after = std::upper_bound(channel->time_s.begin(), channel->time_s.end(), begin_s + margin_s);
      return after != channel->time_s.end() && *after < end_s - margin_s;
    });
    if (silent) result.holes.push_back({begin_s, end_s});
  }
}

void find_logged_faults(const DriveLog& log, ReplayResult& result) {
  for (const auto& [n, channel] : log.numbered("fault_")) {
    double before = 0.0;
    for (std::size_t k = 0; k < channel->size(); ++k) {
      const double value = channel->value[k];
      if (!std::isfinite(value)) continue;
      if (value != before && value != 0.0) {
        result.logged_faults.push_back({channel->role, channel->source, channel->time_s[k], value});
      }
      before = value;
    }
  }
  std::stable_sort(result.logged_faults.begin(), result.logged_faults.end(),
                   [](const LoggedFault& a, const LoggedFault& b) { return a.time_s < b.time_s; });
}

/// Moments at which the mean cell stands near its open-circuit voltage, beside the one of the charge that the log's own
/// current leaves: a filter's SOC would follow the cell.
void find_quiet_cells(const ReplayCar& car, ReplayResult& result) {
  constexpr double kQuiet_per_h = 0.05, kSettled_s = 3.0, kLongest_s = 1.0;
  if (car.ocv.empty() || !(car.capacity_ah > 0.0)) return;
  double soc = kUnknown, quiet_s = 0.0, last_s = kUnknown;
  for (const ReplayRow& row : result.rows) {
    const double step_s = std::isfinite(last_s) ? row.time_s - last_s : 0.0;
    last_s = row.time_s;
    if (!std::isfinite(row.current_a) || step_s > kLongest_s) {
      if (std::isfinite(soc)) return;  // the count ends with the first hole
      continue;
    }
    soc = std::isfinite(soc) ? soc - row.current_a * step_s / 3600.0 / car.capacity_ah : row.soc;
    const double limit_a = std::max(car.rest_current_a, kQuiet_per_h * car.capacity_ah);
    quiet_s = std::abs(row.current_a) <= limit_a ? quiet_s + step_s : 0.0;
    const double volts = 0.5 * (row.cell_min_v + row.cell_max_v) + row.current_a * car.resistance_ohm;
    if (quiet_s < kSettled_s || !std::isfinite(soc) || !std::isfinite(volts)) continue;
    result.quiet_cells.push_back({row.time_s, volts, ocv_of_soc(car, soc), soc, soc_of_ocv(car, volts)});
  }
}

/// The channels that a fault about lost readings is about.
void name_lost_channels(const DriveLog& log, ReplayResult& result) {
  constexpr std::pair<const char*, const char*> kLost[] = {{"CellMeasurementLost", "cell_voltage_"},
                                                          {"TemperatureMeasurementLost", "temperature_"}};
  constexpr std::size_t kNamed = 4;
  for (ReplayFault& fault : result.faults) {
    for (const auto& [id, stem] : kLost) {
      if (fault.id != id || !fault.about.empty()) continue;
      std::vector<std::string> silent;
      const auto channels = log.numbered(stem);
      for (const auto& [n, channel] : channels) {
        HeldChannel held(channel, std::max(0.1, 2.0 * usual_interval_s({channel})));
        held.advance(fault.time_s);
        if (!held.known()) silent.push_back(channel->role);
      }
      if (silent.empty()) continue;
      fault.about = silent.size() == channels.size() && channels.size() > 1
                        ? fmt::format("all {} {}<n>", channels.size(), stem)
                        : first_of(silent, kNamed);
    }
  }
}

/// By the recording's own samples, not by what is held or carried between them.
void find_violations(const DriveLog& log, const ReplayCar& car, ReplayResult& result) {
  CellLimits limits(car.cell_min_v, car.cell_max_v, result.violations);
  for (const auto& [n, channel] : log.numbered("cell_voltage_")) {
    for (std::size_t k = 0; k < channel->size(); ++k) {
      limits.sample(channel->time_s[k], static_cast<std::size_t>(n) - 1, channel->value[k]);
    }
  }
  limits.finish();
}

/// A logged SOC that moves within seconds by what no current of those seconds can have moved.
void find_soc_jump(const DriveLog& log, double capacity_ah, ReplayResult& result) {
  constexpr double kWindow_s = 3.0, kJump = 0.03;
  const Channel* soc = log.find("soc");
  if (soc == nullptr) return;
  SocJump largest;
  double moved = kJump;
  std::size_t first = 0;
  for (std::size_t k = 0; k < soc->size(); ++k) {
    while (soc->time_s[k] - soc->time_s[first] > kWindow_s) ++first;
    for (std::size_t j = first; j < k; ++j) {
      if (!(std::abs(soc->value[k] - soc->value[j]) > moved)) continue;
      moved = std::abs(soc->value[k] - soc->value[j]);
      largest = {soc->time_s[j], soc->time_s[k], soc->value[j], soc->value[k], 0.0, kUnknown};
    }
  }
  if (!(largest.end_s > largest.begin_s)) return;
  HeldChannel current(log.find("current"), kWindow_s);
  for (double t = largest.begin_s; t < largest.end_s; t += kTick_s) {
    current.advance(t);
    if (current.known()) largest.charge_ah += current.value() * kTick_s / 3600.0;
  }
  if (capacity_ah > 0.0) largest.explained = std::abs(largest.charge_ah) / capacity_ah;
  result.soc_jump = largest;
}

}  // namespace

void replay_roles(const DriveLog& log, const ReplayCar& car, const PedalSensors& pedals, bool with_model, Ecus& ecus,
                  ReplayResult& result) {
  result.cells = car.cells;
  result.capacity_ah = car.capacity_ah;
  result.thermistors = car.thermistors;
  find_soc_jump(log, car.capacity_ah, result);
  RoleReplay(log, car, pedals, with_model, ecus, result).run();
  find_holes(log, result);
  find_logged_faults(log, result);
  name_lost_channels(log, result);
  result.cells_recorded = std::min(recorded_cells(log), car.cells);
  if (with_model) {
    find_violations(log, car, result);
    find_quiet_cells(car, result);
  }
  result.frames = log.frames;
  result.defects = log.defects;
  result.notes = log.notes;
  VOLTLAP_DEMAND(std::isfinite(result.open_ah));
}

}  // namespace voltlap::plant

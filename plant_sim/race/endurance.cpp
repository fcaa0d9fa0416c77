// SPDX-License-Identifier: Apache-2.0
#include "race/endurance.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "car/car.hpp"
#include "core/errors.hpp"
#include "race/actuators/command_receiver.hpp"
#include "race/driver/pi_driver.hpp"
#include "race/intervention.hpp"
#include "race/sensors/sensor_frames.hpp"

namespace voltlap::plant {
namespace {

constexpr double kTick_s = can::kTickMs * 1e-3;
constexpr std::uint32_t kTicksPerSample = 10;
constexpr double kTsButton_s = 0.5;        // after power-on: every ECU has heard every sensor
constexpr double kReadyButton_s = 2.0;      // after the contactors closed: the limits have risen
constexpr double kReadyTimeout_s = 20.0;   // longest start-up before the run counts as failed
constexpr double kAssertionRest_s = 10.0;  // after the start and after a seam of the tiled trace
constexpr double kStall_s = 30.0;          // without a metre of progress
constexpr std::size_t kReasonCharge = 9, kReasonPower = 10, kReasonTemperature = 11;

std::size_t binding_reason(const CommandReceiver& ecus) {
  switch (ecus.master().torque_reason) {
    case can::TorqueReason::kDischargeLimit: return static_cast<std::size_t>(ecus.limits().discharge_reason);
    case can::TorqueReason::kChargeLimit: return kReasonCharge;
    case can::TorqueReason::kPower: return kReasonPower;
    case can::TorqueReason::kTemperature: return kReasonTemperature;
    case can::TorqueReason::kNone:
    case can::TorqueReason::kGate: break;
  }
  return 0;
}

/// Keeps the largest value and when it first came.
void keep_largest(double& largest, double value, double& at_s, double time_s) {
  if (value <= largest) return;
  largest = value;
  at_s = time_s;
}

/// One run: owns everything that moves and writes down what the result asks for.
class Run {
 public:
  Run(const EnduranceOptions& options, Exchange& bus, EnduranceObserver& observer)
      : options_(options),
        bus_(bus),
        observer_(observer),
        profile_(options.drive ? SpeedProfile{} : solve_lap(options.vehicle, options.track, options.lap_start)),
        target_(make_target()),
        driver_(options.vehicle.driver),
        step_s_(kTick_s / options.steps_per_tick),
        car_(options.vehicle, options.representative_cell, step_s_),
        frames_(car_.parameters(), options.seed) {
    bus_.attach(observer);
    cell_voltage_.resize(car_.pack().cells());
    cell_temperature_.resize(car_.pack().cells());
    result_.min_pack_voltage_v = result_.min_cell_voltage_v = 1e9;
    result_.max_battery_temp_c = result_.max_motor_temp_c = -1e9;
    initial_soc_ = car_.pack().cell_soc(0);
    end_time_s_ = options.drive ? options.drive->duration_s() : options.laps * profile_.lap_time_s();
  }

  EnduranceResult run() {
    try {
      while (!over_) tick();
    } catch (const BusFailure& error) {
      note_failure(error.what());
    }
    finish();
    return result_;
  }

 private:
  [[nodiscard]] bool by_position() const { return !options_.drive && options_.lap_start == LapStart::kFlying; }
  [[nodiscard]] double drive_time() const { return static_cast<double>(tick_ - ready_tick_) * kTick_s; }
  /// The drive may end inside a tick.
  [[nodiscard]] double race_time() const { return end_of_drive_s_ >= 0.0 ? end_of_drive_s_ : drive_time(); }

  TargetCursor make_target() const {
    if (options_.drive) return TargetCursor::recorded(*options_.drive, options_.vehicle.driver);
    return by_position() ? TargetCursor::by_position(profile_, options_.vehicle.driver)
                         : TargetCursor::by_time(profile_, options_.vehicle.driver);
  }

  void tick() {
    asked_ = &bus_.begin_tick(tick_);
    plant_faults();
    if (ready_ && options_.driver == DriverKind::kLaps) {
      drive();
    } else {
      if (!ready_ && options_.driver != DriverKind::kNobody) start_up();
      stand();
    }
    car_.renew(kTick_s);
    exchange_frames();
    losses_.observe(tick_, bus_.lost(), car_.phase_current_a() != 0.0,
                    car_.contactors.air_plus.closed() || car_.contactors.air_minus.closed());
    ++tick_;
    if (ready_) {
      account();
    } else {
      await_ready();
    }
    end_from_outside();
  }

  void plant_faults() {
    for (const can::PlantFault& fault : asked_->faults) {
      if (plant_fault(fault, car_, frames_.faults)) continue;
      note_failure(fmt::format("the harness asked for plant fault {} of part {} (value {}), which this car does not have",
                               static_cast<int>(fault.fault), fault.index, fault.value));
    }
  }

  /// Low voltage -> tractive system -> ready to drive, as the rules' procedure asks (EV.9).
  void start_up() {
    const bool active = commands_.bms().state == can::BmsState::kTsActive;
    switches_.ts_on = !active && tick_ * kTick_s >= kTsButton_s;
    active_s_ = active ? active_s_ + kTick_s : 0.0;
    switches_.ready_to_drive = active_s_ >= kReadyButton_s;
  }

  /// No road to follow: the foot is on the brake until the car is ready, on no pedal then.
  void stand() {
    pedals_ = {0.0, !ready_ && options_.driver != DriverKind::kNobody ? 1.0 : 0.0};
    override_pedals(asked_->driver, pedals_);
    for (int i = 0; i < options_.steps_per_tick; ++i) {
      car_.step(pedals_.brake);
      if (ready_) note_extremes(drive_time() + (i + 1) * step_s_);
    }
  }

  void await_ready() {
    if (commands_.master().drive_state == can::DriveState::kReadyToDrive) {
      ready_ = true;
      ready_tick_ = tick_;
      switches_.ts_on = switches_.ready_to_drive = false;
      lap_ledger_ = start_ledger_ = car_.ledger();
      lap_energy_j_ = start_energy_j_ = car_.energy_out_j();
    } else if (losses_.car_is_lost()) {
      check_losses();
    } else if (options_.driver != DriverKind::kNobody && tick_ * kTick_s > kReadyTimeout_s) {
      fail(fmt::format("the car did not become ready to drive within {:.0f} s ({})", kReadyTimeout_s, ecu_state()));
    }
  }

  void drive() {
    const double tick_start = drive_time();
    for (int i = 0; i < options_.steps_per_tick; ++i) {
      const Target target = target_.at(tick_start + i * step_s_, car_.vehicle().distance_m());
      pedals_ = driver_.advance(target, car_.vehicle().speed_mps(), step_s_);
      override_pedals(asked_->driver, pedals_);
      car_.step(pedals_.brake);
      target_mps_ = target.speed_mps;
      note_extremes(tick_start + (i + 1) * step_s_);
      if (end_of_drive_s_ < 0.0 && reached_end(tick_start + (i + 1) * step_s_)) {
        end_of_drive_s_ = tick_start + (i + 1) * step_s_;
      }
    }
  }

  [[nodiscard]] bool reached_end(double time_s) const {
    if (by_position()) return car_.vehicle().distance_m() >= options_.laps * profile_.length_m();
    return time_s >= end_time_s_ - 0.5 * step_s_;
  }

  /// The steps behind the finish line, in its tick, count as the finish.
  void note_extremes(double step_end_s) {
    const double time_s = end_of_drive_s_ >= 0.0 ? end_of_drive_s_ : step_end_s;
    const Pack& pack = car_.pack();
    ExtremeTimes& at = result_.extreme_times;
    keep_largest(result_.max_battery_current_a, car_.pack_current_a(), at.battery_current_s, time_s);
    keep_largest(result_.max_speed_mps, car_.vehicle().speed_mps(), at.speed_s, time_s);
    if (pack.voltage() < result_.min_pack_voltage_v) {
      result_.min_pack_voltage_v = pack.voltage();
      at.pack_voltage_s = time_s;
    }
    if (pack.cell_voltage_min() < result_.min_cell_voltage_v) {
      result_.min_cell_voltage_v = pack.cell_voltage_min();
      result_.min_cell = static_cast<int>(pack.weakest_cell()) + 1;
      at.cell_voltage_s = time_s;
    }
  }

  void exchange_frames() {
    const Instant now = Instant::from_ms(tick_ * can::kTickMs);
    Switches switches = switches_;
    override_switches(asked_->driver, switches);
    tx_.clear();
    frames_.send(now, car_, pedals_, switches, tx_);
    commands_.receive(now, bus_.exchange(tx_), car_);
  }

  /// What a tick of driving leaves in the books, and whether the drive ends here.
  void account() {
    keep_largest(result_.max_battery_temp_c, car_.pack().temperature_max_c(), result_.extreme_times.battery_temp_s, race_time());
    keep_largest(result_.max_motor_temp_c, car_.motor_thermal().copper_c(), result_.extreme_times.motor_temp_s, race_time());
    const std::size_t reason = binding_reason(commands_);
    if (reason != 0) result_.limit_active_s[reason] += kTick_s;
    if (commands_.bms().soc_ok) {
      const double soc_error = commands_.bms().soc_ppm * 1e-6 - car_.pack().soc_mean();
      result_.bms_soc_error_pct = std::max(result_.bms_soc_error_pct, 100.0 * std::abs(soc_error));
    }
    if (options_.driver == DriverKind::kLaps) close_laps();
    if ((tick_ - ready_tick_) % kTicksPerSample == 0) sample(reason);
    if (end_of_drive_s_ >= 0.0) {
      over_ = result_.finished = true;
    } else if (losses_.car_is_lost()) {
      check_losses();
    } else if (options_.driver == DriverKind::kLaps) {
      check_assertions();
    }
  }

  /// A lost node ends the run once it is known what the car made of it.
  void check_losses() {
    if (!losses_.settled()) return;
    for (const LostNodeRow& row : losses_.rows()) {
      const auto text = [](const std::optional<double>& s) { return s ? fmt::format("after {:.2f} s", *s) : "never"; };
      fail(fmt::format("node {} was lost {:.2f} s after power-on; torque zero {}, contactors open {}", row.node, row.time_s,
                       text(row.torque_zero_s), text(row.contactors_open_s)));
    }
  }

  void end_from_outside() {
    const StopAsked asked = bus_.stop_asked();
    const bool interrupted = asked == StopAsked::kInterrupted || observer_.stop_requested();
    const bool time_over = options_.duration_s && tick_ * kTick_s >= *options_.duration_s - 0.5 * kTick_s;
    if (over_ || (!interrupted && !time_over && asked == StopAsked::kNo)) return;
    over_ = true;
    if (interrupted) {
      result_.stopped = true;
      note_failure("interrupted");
    } else {
      result_.finished = true;
    }
  }

  void close_laps() {
    const int done = end_of_drive_s_ >= 0.0 ? (options_.drive ? 1 : options_.laps) : laps_passed();
    if (done <= result_.laps) return;
    const double now = race_time();
    const EnergyLedger lap = car_.ledger().since(lap_ledger_);
    result_.lap_rows.push_back({done, now - lap_start_s_, (car_.energy_out_j() - lap_energy_j_) / kJoulesPerKwh,
                                100.0 * car_.pack().soc_mean(), lap.error_pct()});
    result_.energy_ledger_error_pct = std::max(result_.energy_ledger_error_pct, lap.error_pct());
    result_.laps = done;
    lap_ledger_ = car_.ledger();
    lap_energy_j_ = car_.energy_out_j();
    lap_start_s_ = now;
  }

  [[nodiscard]] int laps_passed() const {
    if (options_.drive) return 0;
    const double laps = by_position() ? car_.vehicle().distance_m() / profile_.length_m() : drive_time() / profile_.lap_time_s();
    return std::min(static_cast<int>(laps), options_.laps);
  }

  void sample(std::size_t reason) {
    const Pack& pack = car_.pack();
    for (std::size_t i = 0; i < pack.cells(); ++i) {
      cell_voltage_[i] = pack.cell_voltage(i);
      cell_temperature_[i] = pack.cell_temperature_c(i);
    }
    observer_.on_sample({.time_s = drive_time(), .distance_m = car_.vehicle().distance_m(), .lap = result_.laps + 1,
                         .speed_mps = car_.vehicle().speed_mps(), .target_mps = target_mps_,
                         .accelerator = pedals_.accelerator, .brake = pedals_.brake,
                         .pack_current_a = car_.pack_current_a(), .pack_voltage_v = pack.voltage(),
                         .dc_link_v = car_.dc_link_voltage(), .phase_current_a = car_.phase_current_a(),
                         .discharge_limit_a = commands_.limits().discharge_limit_ma * 1e-3,
                         .charge_limit_a = commands_.limits().charge_limit_ma * 1e-3, .limit_reason = reason,
                         .soc = pack.soc_mean(), .bms_soc = commands_.bms().soc_ppm * 1e-6,
                         .battery_temperature_c = pack.temperature_max_c(),
                         .motor_temperature_c = car_.motor_thermal().copper_c(), .front_rotor_c = car_.rotors().front_c(),
                         .rear_rotor_c = car_.rotors().rear_c(), .cell_voltage_v = &cell_voltage_,
                         .cell_temperature_c = &cell_temperature_});
    observer_.on_progress(std::min(1.0, progress()), drive_time());
  }

  [[nodiscard]] double progress() const {
    if (options_.duration_s) return tick_ * kTick_s / *options_.duration_s;
    if (options_.driver != DriverKind::kLaps) return -1.0;
    return by_position() ? car_.vehicle().distance_m() / (options_.laps * profile_.length_m()) : drive_time() / end_time_s_;
  }

  void check_assertions() {
    const AssertionSection& bounds = options_.vehicle.assertions;
    const double since_seam = by_position() || options_.drive ? drive_time() : drive_time() - lap_start_s_;
    const double error = target_mps_ - car_.vehicle().speed_mps();
    if (commands_.master().drive_state != can::DriveState::kReadyToDrive) {
      fail(fmt::format("the master controller left ready-to-drive ({})", ecu_state()));
    } else if (car_.voltage_collapsed()) {
      fail(fmt::format("the pack could not deliver the power that was asked: voltage collapsed at {:.1f} V", car_.pack().voltage()));
    } else if (since_seam > kAssertionRest_s && std::abs(error) > bounds.speed_error_max_mps) {
      fail(fmt::format("speed error {:.1f} m/s (target {:.1f}, driven {:.1f}) is beyond assertions.speed_error_max_mps = {:g}",
                       error, target_mps_, car_.vehicle().speed_mps(), bounds.speed_error_max_mps));
    } else if (car_.pack().temperature_max_c() > bounds.battery_temperature_max_c) {
      fail(fmt::format("battery at {:.1f} degC is beyond assertions.battery_temperature_max_c = {:g}",
                       car_.pack().temperature_max_c(), bounds.battery_temperature_max_c));
    } else if (car_.motor_thermal().copper_c() > bounds.motor_temperature_max_c) {
      fail(fmt::format("motor winding at {:.1f} degC is beyond assertions.motor_temperature_max_c = {:g}",
                       car_.motor_thermal().copper_c(), bounds.motor_temperature_max_c));
    } else if (by_position()) {
      check_progress();
    }
  }

  void check_progress() {
    if (car_.vehicle().distance_m() > progress_m_ + 1.0) {
      progress_m_ = car_.vehicle().distance_m();
      progress_s_ = drive_time();
    } else if (drive_time() - progress_s_ > kStall_s) {
      fail(fmt::format("the car has stood still for {:.0f} s ({})", kStall_s, ecu_state()));
    }
  }

  [[nodiscard]] std::string ecu_state() const {
    return fmt::format("drive state {}, master faults 0x{:04X}, BMS state {}, BMS faults 0x{:04X}; names in can_dbc/car.dbc",
                       static_cast<int>(commands_.master().drive_state), commands_.master().faults,
                       static_cast<int>(commands_.bms().state), commands_.bms().faults);
  }

  void fail(std::string cause) {
    if (!options_.keep_going && options_.driver == DriverKind::kLaps) over_ = true;
    note_failure(std::move(cause));
  }

  /// The first failure counts.
  void note_failure(std::string cause) {
    if (!result_.failure_cause.empty()) return;
    result_.failure_cause = std::move(cause);
    result_.failure_time_s = run_time();
  }

  [[nodiscard]] double run_time() const { return ready_ ? drive_time() : tick_ * kTick_s; }

  void finish() {
    const Pack& pack = car_.pack();
    result_.total_time_s = end_of_drive_s_ >= 0.0 ? end_of_drive_s_ : result_.finished ? run_time() : result_.failure_time_s;
    result_.lost_nodes = losses_.rows();
    result_.end_soc_pct = 100.0 * pack.soc_mean();
    result_.distance_m = car_.vehicle().distance_m();
    result_.energy_out_kwh = (car_.energy_out_j() - start_energy_j_) / kJoulesPerKwh;
    result_.ledger = car_.ledger().since(start_ledger_);
    const double counted = (initial_soc_ - pack.cell_soc(0)) * pack.capacity_ah(0);
    if (pack.charge_out_ah() != 0.0) {
      result_.charge_balance_error_pct = 100.0 * std::abs(counted / pack.charge_out_ah() - 1.0);
    }
    if (!ready_) {
      result_.min_pack_voltage_v = pack.voltage();
      result_.min_cell_voltage_v = pack.cell_voltage_min();
      result_.min_cell = static_cast<int>(pack.weakest_cell()) + 1;
      result_.max_battery_temp_c = pack.temperature_max_c();
      result_.max_motor_temp_c = car_.motor_thermal().copper_c();
    }
    result_.ticks = tick_;
    result_.frames = bus_.frames_sent();
    result_.frames_in_tick_max = bus_.frames_in_tick_max();
  }

  const EnduranceOptions& options_;
  Exchange& bus_;
  EnduranceObserver& observer_;
  SpeedProfile profile_;
  TargetCursor target_;
  PiDriver driver_;
  double step_s_;
  Car car_;
  SensorFrames frames_;
  CommandReceiver commands_;
  LossWatch losses_{kTick_s};
  const Interventions* asked_ = nullptr;
  TxQueue tx_;
  Pedals pedals_;
  Switches switches_{.shutdown_closed = true};
  EnduranceResult result_;
  EnergyLedger lap_ledger_, start_ledger_;
  std::vector<double> cell_voltage_, cell_temperature_;
  std::uint32_t tick_ = 0, ready_tick_ = 0;
  bool ready_ = false, over_ = false;
  double initial_soc_ = 0.0, end_time_s_ = 0.0, end_of_drive_s_ = -1.0, target_mps_ = 0.0;
  double lap_energy_j_ = 0.0, start_energy_j_ = 0.0, lap_start_s_ = 0.0, progress_m_ = 0.0, progress_s_ = 0.0, active_s_ = 0.0;
};

}  // namespace

const char* limit_reason_name(std::size_t reason) {
  static constexpr const char* kNames[kLimitReasons] = {"none", "config_maximum", "cell_voltage", "pack_voltage",
                                                        "temperature", "soc_low", "fault", "measurement_lost",
                                                        "contactors_open", "charge_limit", "power", "motor_temperature"};
  return reason < kLimitReasons ? kNames[reason] : "unknown";
}

int laps_of_endurance(const Track& track) {
  constexpr double kLength_m = 22'000.0;
  return std::max(1, static_cast<int>(std::floor(kLength_m / track.length_m())));
}

EnduranceResult run_endurance(const EnduranceOptions& options, Ecus& ecus, EnduranceObserver& observer) {
  InProcessLoop bus(ecus);
  return run_endurance(options, bus, observer);
}

EnduranceResult run_endurance(const EnduranceOptions& options, Exchange& bus, EnduranceObserver& observer) {
  if (!options.drive && options.laps < 1) {
    throw InputError("laps", fmt::format("{}", options.laps), "1 or more", "Give the number of laps to drive");
  }
  return Run(options, bus, observer).run();
}

}  // namespace voltlap::plant

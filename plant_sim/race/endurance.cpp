// SPDX-License-Identifier: Apache-2.0
#include "race/endurance.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "car/car.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"
#include "race/actuators/command_receiver.hpp"
#include "race/driver/line_keeping.hpp"
#include "race/driver/pi_driver.hpp"
#include "race/intervention.hpp"
#include "race/race_account.hpp"
#include "race/run_assertions.hpp"
#include "race/sensors/sensor_frames.hpp"
#include "race/start_up.hpp"

namespace voltlap::plant {
namespace {

/// NaN while the BMS has none.
double said_soc(const can::BmsStatus& bms) {
  return bms.soc_ok ? 1e-6 * bms.soc_ppm : std::numeric_limits<double>::quiet_NaN();
}

constexpr double kTick_s = can::kTickMs * 1e-3;
constexpr std::uint32_t kTicksPerSample = 10;

/// The lap that a driver means to drive. Who plans with all of the grip has none left to correct with; the trace from
/// rest is the reference study's, which plans with all of it.
SpeedProfile planned_lap(const VehicleParameters& car, const Track& track, LapStart start) {
  if (start == LapStart::kStanding) return solve_lap(car, track, start);
  VehicleParameters planned = car;
  planned.tyres.pacejka_d *= car.driver.grip_use;
  planned.brakes.force_scale *= car.driver.grip_use;
  return solve_lap(planned, track, start);
}

/// One run: owns everything that moves, and the order of a tick.
class Run {
 public:
  Run(const EnduranceOptions& options, PlantBus& bus, EnduranceObserver& observer)
      : options_(options),
        bus_(bus),
        observer_(observer),
        profile_(options.drive ? SpeedProfile{} : planned_lap(options.vehicle, options.track, options.lap_start)),
        target_(make_target()),
        driver_(options.vehicle.driver),
        line_(options.vehicle),
        step_s_(kTick_s / options.steps_per_tick),
        car_(options.vehicle, options.representative_cell, step_s_),
        frames_(car_.parameters(), options.seed, options.pedal_sensors),
        account_(result_, car_),
        assertions_(options.vehicle.assertions, by_position()) {
    VOLTLAP_DEMAND(options.steps_per_tick > 0);
    bus_.attach(observer);
    cell_voltage_.resize(car_.pack().cells());
    cell_temperature_.resize(car_.pack().cells());
    cell_soc_.resize(car_.pack().cells());
    end_time_s_ = options.drive ? options.drive->duration_s() : options.laps * profile_.lap_time_s();
  }

  EnduranceResult run() {
    try {
      while (!over_) tick();
    } catch (const BusFailure& error) {
      note_failure(error.what());
    }
    finish();
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool by_position() const { return !options_.drive && options_.lap_start == LapStart::kFlying; }
  [[nodiscard]] double drive_time() const { return static_cast<double>(tick_ - ready_tick_) * kTick_s; }
  [[nodiscard]] double race_time() const { return finish_s_.value_or(drive_time()); }

  TargetCursor make_target() const {
    if (options_.drive) return TargetCursor::recorded(*options_.drive, options_.vehicle.driver);
    return by_position() ? TargetCursor::by_position(profile_, options_.vehicle.driver)
                         : TargetCursor::by_time(profile_, options_.vehicle.driver);
  }

  void tick() {
    asked_ = &bus_.begin_tick(tick_);
    apply_plant_faults();
    if (ready_ && options_.driver == DriverKind::kLaps) {
      drive();
    } else {
      if (!ready_ && options_.driver != DriverKind::kNobody) {
        start_up_.press(tick_ * kTick_s, kTick_s, commands_.bms().state, switches_);
      }
      stand();
    }
    car_.renew(kTick_s);
    exchange_frames();
    losses_.observe(tick_, bus_.lost(), car_.phase_current_a() != 0.0,
                    car_.contactors.air_plus.closed() || car_.contactors.air_minus.closed());
    ++tick_;
    if (ready_) {
      close_tick();
    } else {
      await_ready();
    }
    end_from_outside();
  }

  void apply_plant_faults() {
    for (const can::PlantFault& fault : asked_->faults) {
      if (apply_plant_fault(fault, car_, frames_.faults)) continue;
      note_failure(
          fmt::format("the harness asked for plant fault {} of part {} (value {}), which this car does not have",
                      static_cast<int>(fault.fault), fault.index, fault.value));
    }
  }

  /// No road to follow: the foot is on the brake until the car is ready, on no pedal then.
  void stand() {
    pedals_ = {0.0, !ready_ && options_.driver != DriverKind::kNobody ? 1.0 : 0.0};
    override_pedals(asked_->driver, pedals_);
    for (int i = 0; i < options_.steps_per_tick; ++i) {
      car_.step(pedals_.brake);
      if (ready_) account_.note_step(car_, drive_time() + (i + 1) * step_s_);
    }
  }

  void await_ready() {
    if (commands_.master().drive_state == can::DriveState::kReadyToDrive) {
      ready_ = true;
      ready_tick_ = tick_;
      switches_.ts_on = switches_.ready_to_drive = false;
      // A flying lap is one of many: it begins at the speed with which the one before it ended.
      if (by_position() && options_.driver == DriverKind::kLaps) car_.vehicle().set_speed(profile_.speed_mps.front());
      account_.open(car_);
      ready_charge_c_ = car_.charge_out_c();
    } else if (losses_.car_is_lost()) {
      check_losses();
    } else if (options_.driver != DriverKind::kNobody && tick_ * kTick_s > StartUp::kLongest_s) {
      fail(fmt::format("the car did not become ready to drive within {:.0f} s ({})", StartUp::kLongest_s,
                       state_text(car_, commands_)));
    }
  }

  void drive() {
    const double tick_start = drive_time();
    for (int i = 0; i < options_.steps_per_tick; ++i) {
      const double speed = car_.vehicle().speed_mps(), driven = car_.vehicle().distance_m();
      const Target target = line_.eased(target_.at(tick_start + i * step_s_, line_.distance_m()));
      const Road road = line_.road(target, speed);
      car_.vehicle().set_road(road);
      if (i == 0 && by_position()) sense_ = feel_road(options_.vehicle, road, speed);
      pedals_ = driver_.advance(target, speed, step_s_, sense_);
      override_pedals(asked_->driver, pedals_);
      car_.step(pedals_.brake);
      line_.advance(car_.vehicle().distance_m() - driven, step_s_);
      target_mps_ = target.speed_mps;
      const double step_end = tick_start + (i + 1) * step_s_;
      result_.max_off_course_m = std::max(result_.max_off_course_m, std::abs(line_.offset_m()));
      // The steps behind the finish line, in its tick, count as the finish.
      account_.note_step(car_, finish_s_.value_or(step_end));
      if (!finish_s_ && reached_end(step_end)) finish_s_ = step_end;
    }
  }

  [[nodiscard]] bool reached_end(double time_s) const {
    if (by_position()) return line_.distance_m() >= options_.laps * profile_.length_m();
    return time_s >= end_time_s_ - 0.5 * step_s_;
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
  void close_tick() {
    const std::size_t reason = binding_limit_reason(commands_);
    account_.note_tick(car_, commands_, reason, race_time(), kTick_s);
    if (options_.driver == DriverKind::kLaps) close_laps();
    if ((tick_ - ready_tick_) % kTicksPerSample == 0) sample(reason);
    if (finish_s_) {
      over_ = result_.finished = true;
    } else if (losses_.car_is_lost()) {
      check_losses();
    } else if (options_.driver == DriverKind::kLaps) {
      check_assertions();
    }
  }

  void close_laps() {
    const int before = result_.laps;
    account_.close_laps(car_, laps_passed(), race_time());
    if (result_.laps != before) lap_start_m_ = by_position() ? result_.laps * profile_.length_m() : line_.distance_m();
  }

  /// Of the course where the car is. A recorded drive has none, and one that is driven by the clock feels none.
  [[nodiscard]] double course_curvature_per_m() const {
    if (!by_position()) return std::numeric_limits<double>::quiet_NaN();
    const auto& at = profile_.distance_m;
    const double lap_m = std::clamp(line_.distance_m() - lap_start_m_, 0.0, profile_.length_m());
    const auto behind = std::upper_bound(at.begin(), at.end(), lap_m);
    const auto interval = std::max<std::ptrdiff_t>(std::distance(at.begin(), behind) - 1, 0);
    return profile_.curvature_per_m[std::min(static_cast<std::size_t>(interval), profile_.curvature_per_m.size() - 1)];
  }

  /// A lost node ends the run once it is known what the car made of it.
  void check_losses() {
    if (!losses_.settled()) return;
    for (const LostNodeRow& row : losses_.rows()) {
      const auto text = [](const std::optional<double>& s) { return s ? fmt::format("after {:.2f} s", *s) : "never"; };
      fail(fmt::format("node {} was lost {:.2f} s after power-on; torque zero {}, contactors open {}", row.node,
                       row.time_s, text(row.torque_zero_s), text(row.contactors_open_s)));
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

  [[nodiscard]] int laps_passed() const {
    if (options_.drive) return finish_s_ ? 1 : 0;
    if (finish_s_) return options_.laps;
    const double laps =
        by_position() ? line_.distance_m() / profile_.length_m() : drive_time() / profile_.lap_time_s();
    return std::min(static_cast<int>(laps), options_.laps);
  }

  void sample(std::size_t reason) {
    const Pack& pack = car_.pack();
    const double speed = car_.vehicle().speed_mps();
    for (std::size_t i = 0; i < pack.cells(); ++i) {
      cell_voltage_[i] = pack.cell_voltage(i);
      cell_temperature_[i] = pack.cell_temperature_c(i);
      cell_soc_[i] = pack.cell_soc(i);
    }
    observer_.on_sample({.time_s = drive_time(), .distance_m = car_.vehicle().distance_m(), .lap = result_.laps + 1,
                         .speed_mps = speed, .target_mps = target_mps_,
                         .accelerator = pedals_.accelerator, .brake = pedals_.brake,
                         .pack_current_a = car_.pack_current_a(), .pack_voltage_v = pack.voltage(),
                         .dc_link_v = car_.dc_link_voltage(), .phase_current_a = car_.phase_current_a(),
                         .discharge_limit_a = commands_.limits().discharge_limit_ma * 1e-3,
                         .charge_limit_a = commands_.limits().charge_limit_ma * 1e-3, .limit_reason = reason,
                         .soc = pack.soc_mean(), .bms_soc = said_soc(commands_.bms()),
                         .battery_temperature_c = pack.temperature_max_c(),
                         .motor_temperature_c = car_.motor_thermal().copper_c(),
                         .front_rotor_c = car_.rotors().front_c(), .rear_rotor_c = car_.rotors().rear_c(),
                         .course_m = line_.distance_m(), .lap_distance_m = line_.distance_m() - lap_start_m_,
                         .power_w = car_.pack_current_a() * pack.voltage(), .power_mean_w = account_.power_mean_w(),
                         .longitudinal_mps2 = car_.vehicle().acceleration_mps2(),
                         .charge_drawn_ah = (car_.charge_out_c() - ready_charge_c_) / 3600.0,
                         .lateral_mps2 = speed * speed * course_curvature_per_m(),
                         .cell_voltage_v = &cell_voltage_, .cell_temperature_c = &cell_temperature_,
                         .cell_soc = &cell_soc_, .pack = &pack});
    observer_.on_progress(std::min(1.0, progress()), drive_time());
  }

  [[nodiscard]] double progress() const {
    if (options_.duration_s) return tick_ * kTick_s / *options_.duration_s;
    if (options_.driver != DriverKind::kLaps) return -1.0;
    return by_position() ? line_.distance_m() / (options_.laps * profile_.length_m())
                         : drive_time() / end_time_s_;
  }

  void check_assertions() {
    const double since_seam = by_position() || options_.drive ? drive_time() : drive_time() - account_.lap_start_s();
    const double distance_m = by_position() ? line_.distance_m() : car_.vehicle().distance_m();
    const double lap_m = options_.drive ? distance_m : std::fmod(distance_m, profile_.length_m());
    if (auto cause = assertions_.broken(
            car_, commands_, {drive_time(), since_seam, target_mps_, result_.laps + 1, lap_m, line_.offset_m()})) {
      fail(std::move(*cause));
    }
  }

  void fail(std::string cause) {
    if (!options_.keep_going && options_.driver == DriverKind::kLaps) over_ = true;
    note_failure(std::move(cause));
  }

  /// The first failure counts.
  void note_failure(std::string cause) {
    if (!result_.failure_cause.empty()) return;
    const bool is_said = cause.find("inverter.dc_voltage_min_v") != std::string::npos;
    if (result_.beyond.link_falls > 0 && !is_said)
      cause += fmt::format("; the DC link had fallen below inverter.dc_voltage_min_v = {:g} V: the inverter is off",
                           car_.parameters().inverter.dc_voltage_min_v);
    result_.failure_cause = std::move(cause);
    result_.failure_time_s = run_time();
  }

  [[nodiscard]] double run_time() const { return ready_ ? drive_time() : tick_ * kTick_s; }

  void finish() {
    account_.close(car_);
    result_.total_time_s = finish_s_ ? *finish_s_ : result_.finished ? run_time() : result_.failure_time_s;
    result_.lost_nodes = losses_.rows();
    result_.ticks = tick_;
    result_.frames = bus_.frames_sent();
    result_.frames_in_tick_max = bus_.frames_in_tick_max();
    VOLTLAP_DEMAND(result_.finished || !result_.failure_cause.empty());
    VOLTLAP_DEMAND(result_.total_time_s >= 0.0 && std::isfinite(result_.end_soc_pct));
  }

  const EnduranceOptions& options_;
  PlantBus& bus_;
  EnduranceObserver& observer_;
  SpeedProfile profile_;
  TargetCursor target_;
  PiDriver driver_;
  LineKeeping line_;
  RoadSense sense_;
  double step_s_;
  Car car_;
  SensorFrames frames_;
  CommandReceiver commands_;
  TimeToSafeState losses_{kTick_s};
  const Interventions* asked_ = nullptr;
  TxQueue tx_;
  Pedals pedals_;
  Switches switches_{.shutdown_closed = true};
  EnduranceResult result_;
  RaceAccount account_;
  RunAssertions assertions_;
  StartUp start_up_;
  std::vector<double> cell_voltage_, cell_temperature_, cell_soc_;
  std::uint32_t tick_ = 0, ready_tick_ = 0;
  double ready_charge_c_ = 0.0;
  bool ready_ = false, over_ = false;
  std::optional<double> finish_s_;  ///< when the drive ended: it may do so inside a tick
  double end_time_s_ = 0.0, target_mps_ = 0.0;
  double lap_start_m_ = 0.0;  ///< along the line
};

}  // namespace

int laps_of_endurance(const Track& track) {
  constexpr double kLength_m = 22'000.0;
  return std::max(1, static_cast<int>(std::floor(kLength_m / track.length_m())));
}

EnduranceResult run_endurance(const EnduranceOptions& options, Ecus& ecus, EnduranceObserver& observer) {
  InProcessLoop bus(ecus);
  return run_endurance(options, bus, observer);
}

EnduranceResult run_endurance(const EnduranceOptions& options, PlantBus& bus, EnduranceObserver& observer) {
  if (!options.drive && options.laps < 1) {
    throw InputError("laps", fmt::format("{}", options.laps), "1 or more", "Give the number of laps to drive");
  }
  return Run(options, bus, observer).run();
}

}  // namespace voltlap::plant

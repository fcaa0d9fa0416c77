// SPDX-License-Identifier: Apache-2.0
#include "explain/balances/car_balances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "car/powertrain/inverter.hpp"
#include "car/powertrain/motor.hpp"
#include "car/vehicle/brakes.hpp"
#include "explain/balances/car_motion.hpp"
#include "explain/balances/recorded_motor.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kMemory = 2.0;     // s, of the gain of speed
constexpr double kPads = 1.0;       // bar above a released pedal; from there on the pads touch
constexpr double kCoarse = 0.05;    // s between rows
constexpr double kRecovers = 0.4;   // s after braking, until wheels turn as the car goes
constexpr double kPulls = 0.05;     // of the largest torque
constexpr double kLetGo = 0.1;      // of that: what a pedal that stands still moves by
constexpr double kGap = 0.5;        // s without a row, over which no sum goes on
constexpr double kReleased = 0.02;  // of the accelerator; below it the torque is what the brakes ask for
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

bool has_torque(const Recording& log) {
  return log.find("motor_torque") || log.find("accelerator");
}

double largest_of(const VectorXd& values) {
  double most = 0.0;
  for (const double v : values) {
    if (std::isfinite(v)) most = std::max(most, v);
  }
  return most;
}

/// What a sensor of the line pressure reads with the pedal released: it is released for a tenth of any drive.
double released(const VectorXd& pressure) {
  std::vector<double> read;
  for (const double v : pressure) {
    if (std::isfinite(v)) read.push_back(v);
  }
  if (read.empty()) return 0.0;
  const auto tenth = read.begin() + static_cast<std::ptrdiff_t>(read.size() / 10);
  std::nth_element(read.begin(), tenth, read.end());
  return *tenth;
}

/// Rows in which all that moves the car is known. The sums below begin anew after any other row.
class Driving {
 public:
  explicit Driving(const Recording& log)
      : log_(log),
        speed_(*log.find("speed")),
        torque_(*(log.find("motor_torque") != nullptr ? log.find("motor_torque") : log.find("accelerator"))),
        brake_(log.find("brake")),
        lateral_(log.find("lateral_acceleration")),
        pressure_(log.find("brake_pressure")),
        pulls_(kPulls * largest_of(torque_)) {
    if (pressure_ != nullptr) pads_ = released(*pressure_) + kPads;
    const VectorXd* pressed = brake_ != nullptr ? brake_ : pressure_;
    if (pressed == nullptr) return;
    rolls_freely_.resize(static_cast<std::size_t>(log.rows()));
    double last_s = -1e300;
    for (Index row = 0; row < log.rows(); ++row) {
      if ((*pressed)(row) >= (brake_ != nullptr ? kTouch : pads_)) last_s = log.time_s(row);
      rolls_freely_[static_cast<std::size_t>(row)] = !(log.time_s(row) - last_s < kRecovers);
    }
  }

  [[nodiscard]] bool at(Index row) const {
    if (!(speed_(row) > kMoving) || !std::isfinite(torque_(row))) return false;
    if (lateral_ != nullptr && !std::isfinite((*lateral_)(row))) return false;
    if (brake_ != nullptr) return std::isfinite((*brake_)(row)) && (!is_coarse(row) || rolls_freely(row));
    if (pressure_ != nullptr) return rolls_freely(row);
    return torque_(row) > pulls_;  // the brakes may be on where the motor does not pull
  }

  /// What was gained since the row before is known: a pedal that moved between rows that are far apart moved at any
  /// time, and where it was let go a brake may have been tapped.
  [[nodiscard]] bool knows_gain(Index row) const {
    if (!is_coarse(row)) return true;
    const double before = torque_(row - 1), moved = std::abs(torque_(row) - before);
    return moved < (std::min(before, torque_(row)) < pulls_ ? kLetGo * pulls_ : pulls_);
  }

 private:
  /// Between rows that are further apart a pedal is anywhere.
  [[nodiscard]] bool is_coarse(Index row) const {
    return row > 0 && log_.time_s(row) - log_.time_s(row - 1) > kCoarse;
  }
  /// The pads do not touch and have not touched for a while: a wheel that is braked turns slower than the car goes.
  [[nodiscard]] bool rolls_freely(Index row) const { return rolls_freely_[static_cast<std::size_t>(row)]; }

  const Recording& log_;
  const VectorXd &speed_, &torque_;
  const VectorXd *brake_, *lateral_, *pressure_;
  double pulls_, pads_ = kPads;
  std::vector<bool> rolls_freely_;
};

/// What has come in over the last seconds: the sum of what each row adds as far as it is known, forgotten with the
/// time kMemory. Begins with nothing where the car gets moving.
template <class Added>
VectorXd remembered(const Recording& log, const Added& added) {
  const Driving driving(log);
  VectorXd out = VectorXd::Constant(log.rows(), kNothing);
  double last_dt = 0.0, keeps = 1.0;
  for (Index row = 0; row < log.rows(); ++row) {
    if (!driving.at(row)) continue;
    const double dt = row > 0 ? log.time_s(row) - log.time_s(row - 1) : kGap;
    const bool goes_on = dt < kGap && std::isfinite(out(row - 1));
    if (dt != last_dt) keeps = std::exp(-dt / kMemory), last_dt = dt;
    out(row) = !goes_on ? 0.0 : out(row - 1) * keeps + (driving.knows_gain(row) ? added(row) : 0.0);
  }
  return out;
}

/// values(t - delay_s) by cubics whose slope at a row is that between its neighbours. A straight line would take a
/// part of the row's own noise away, which the residual has too: every log would seem late.
VectorXd delayed(const VectorXd& time, const VectorXd& values, double delay_s) {
  const Index last = values.size() - 1;
  const auto slope = [&](Index k) {
    const Index a = std::max<Index>(0, k - 1), b = std::min(last, k + 1);
    return (values(b) - values(a)) / (time(b) - time(a));
  };
  VectorXd out = values;
  Index k = 0;
  for (Index row = 0; row <= last; ++row) {
    const double at = std::clamp(time(row) - delay_s, time(0), time(last));
    while (k > 0 && time(k) > at) --k;
    while (k + 2 <= last && time(k + 1) <= at) ++k;
    const double dt = time(k + 1) - time(k), x = (at - time(k)) / dt;
    const double a = slope(k) * dt, b = slope(k + 1) * dt, rise = values(k + 1) - values(k);
    out(row) = values(k) + x * (a + x * (3.0 * rise - 2.0 * a - b + x * (a + b - 2.0 * rise)));
  }
  return out;
}

/// Power [W] between the pack's terminals and the inverter: contactors, fuse and cables, and the bleed resistor.
double link_loss(const ContactorSection& contactors, double pack_v, double current_a) {
  const double link_v = pack_v - contactors.resistance_ohm * current_a;
  const double bleeds =
      contactors.bleed_resistance_ohm > 0.0 ? link_v * link_v / contactors.bleed_resistance_ohm : 0.0;
  return contactors.resistance_ohm * current_a * current_a + bleeds;
}

/// The current follows the torque that is reported, the work what the motor gives for it.
VectorXd power_of(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const MotorSection& m = world.car.motor;
  const Inverter inverter(world.car.inverter);
  // A motor whose speed was reckoned from the car's turns as the tyres slip in this world.
  const bool reckoned = log.derived.contains("motor_speed");
  const VectorXd reported = reported_torque(world, comparison), given = true_torque(world, comparison, reported),
                 speed = reckoned ? motor_speed_of(world, comparison) : *log.find("motor_speed");
  const VectorXd &volts = *pack_voltage(log), &current = *log.find("current");
  // A winding that is warm has more resistance, whatever its magnets do.
  const bool warms = m.winding_loss && m.winding_per_kelvin > 0.0;
  const VectorXd warm =
      warms ? winding_above_ambient(world, comparison, reported) : VectorXd(VectorXd::Zero(log.rows()));
  const double ambient_c = m.winding_per_kelvin > 0.0 ? world.car.environment.ambient_c : m.winding_reference_c;
  VectorXd out(log.rows());
  for (Index row = 0; row < log.rows(); ++row) {
    const double omega = speed(row) * kRpm, eta = given(row) * omega >= 0.0 ? m.efficiency : 1.0 / m.efficiency;
    const double phase = reported(row) / (m.constant_nm_per_a * eta);
    const double copper_c = ambient_c + warm(row);
    const double motor_w = motor_power(m, phase, omega, copper_c) + (given(row) - reported(row)) * omega / eta;
    const double dc_w = inverter.dc_power(motor_w) + inverter_stage_loss(world.car.inverter, phase, volts(row)) +
                        weakening_loss(world, omega);
    // Inverter and motor warm the same water: a log cannot tell whose losses changed.
    const double loss_w = dc_w - given(row) * omega;
    const double true_w = dc_w + world.loss_change * loss_w + world.car.low_voltage.power_w +
                          link_loss(world.car.contactors, volts(row), current(row));
    out(row) = true_w * (1.0 + world.current.gain) + volts(row) * world.current.offset;
    if (world.current_limit_a > 0.0) out(row) = std::min(out(row), volts(row) * world.current_limit_a);
  }
  if (world.current.delay_s != 0.0) out = delayed(log.time_s, out, world.current.delay_s);
  return power_as_torque(log, out);
}

/// Speed gained over the last seconds.
VectorXd gained_speed(const World& world, const Comparison& comparison) {
  return gain_of_speed(comparison.log, acceleration_of(world, comparison), spun_up(world, comparison.log));
}

/// Rows in which the driver does not ask the motor for torque.
bool is_released(const Recording& log, Index row) {
  return std::abs((*log.find("accelerator"))(row)) < kReleased && (*log.find("speed"))(row) > kMoving;
}

/// Torque with the accelerator released: the share of braking that the motor takes, beside what the brakes give.
VectorXd released_torque(const World& world, const Comparison& comparison) {
  const Recording& log = comparison.log;
  const VehicleParameters& car = world.car;
  const VectorXd &pedal = *log.find("accelerator"), &brake = *log.find("brake");
  const double beside = world.regen_split / (1.0 - world.regen_split);
  VectorXd out = VectorXd::Constant(log.rows(), kNothing);
  for (Index row = 0; row < log.rows(); ++row) {
    if (!is_released(log, row)) continue;
    const BrakeTorques t = brake_torques(car.brakes, brake(row));
    out(row) = motor_torque(car.motor, pedal(row) * car.inverter.current_max_a, 1.0) -
               beside * (t.front_nm + t.rear_nm) / car.powertrain.final_drive;
  }
  return out;
}

VectorXd measured_released_torque(const Recording& log) {
  VectorXd out = *log.find("motor_torque");
  for (Index row = 0; row < log.rows(); ++row) {
    if (!is_released(log, row)) out(row) = kNothing;
  }
  return out;
}

/// Rows as far apart as a gap say nothing of what was gained between them.
bool has_gain_of_speed(const Recording& log) {
  std::vector<double> steps;
  for (Index row = 1; row < log.rows(); ++row) steps.push_back(log.time_s(row) - log.time_s(row - 1));
  if (steps.empty() || log.find("speed") == nullptr) return false;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle < kGap;
}

VectorXd measured_gain_of_speed(const Recording& log) {
  const VectorXd& speed = *log.find("speed");
  return remembered(log, [&](Index row) { return speed(row) - speed(row - 1); });
}

}  // namespace

const VectorXd* pack_voltage(const Recording& log) {
  for (const char* role : {"pack_voltage", "bus_voltage"}) {
    if (const VectorXd* found = log.find(role)) return found;
  }
  return nullptr;
}

/// Rows whose torque is unknown are not judged.
VectorXd measured_power(const Recording& log) {
  const VectorXd power = power_as_torque(log, pack_voltage(log)->cwiseProduct(*log.find("current")));
  const VectorXd* pedal = log.find("motor_torque") != nullptr ? nullptr : log.find("accelerator");
  return pedal != nullptr ? VectorXd(pedal->array().isFinite().select(power, kNothing)) : power;
}

std::vector<BalanceChannel> car_channels(const World& model, const Recording& log) {
  if (model.car.tyres.radius_m <= 0.0) return {};
  std::vector<BalanceChannel> out;
  const VectorXd *volts = pack_voltage(log), *speed = log.find("speed"), *motor = log.find("motor_speed");
  if (has_torque(log) && motor != nullptr && volts != nullptr) {
    out.push_back({"power", Balance::kPower, "Nm", measured_power(log)});
  }
  if (has_torque(log) && has_gain_of_speed(log)) {
    out.push_back({"speed", Balance::kForce, "m/s", measured_gain_of_speed(log)});
  }
  if (motor != nullptr && speed != nullptr && has_torque(log) && !log.derived.contains("motor_speed")) {
    out.push_back({"motor_speed", Balance::kForce, "rpm", *motor});
  }
  if (log.find("accelerator") && log.find("motor_torque") && !log.derived.contains("motor_torque") &&
      log.find("brake") && speed != nullptr) {
    out.push_back({"motor_torque", Balance::kForce, "Nm", measured_released_torque(log)});
  }
  return out;
}

bool knows_cornering(const World& model, const Recording& log) {
  return model.car.tyres.cornering_stiffness_per_rad <= 0.0 || log.find("lateral_acceleration") != nullptr;
}

VectorXd power_as_torque(const Recording& log, const VectorXd& power) {
  constexpr double kCreep = 30.0;  // rad/s; below it the current's noise outweighs that of the torque
  const auto omega = log.find("motor_speed")->array() * kRpm;
  return (power.array() / (omega.square() + kCreep * kCreep).sqrt()).matrix();
}

VectorXd gain_of_speed(const Recording& log, const VectorXd& acceleration, const VectorXd& beside) {
  return remembered(log, [&](Index row) {
    const double gain = 0.5 * (acceleration(row) + acceleration(row - 1)) * (log.time_s(row) - log.time_s(row - 1));
    return beside.size() > 0 ? gain + beside(row) : gain;
  });
}

std::vector<bool> knows_gain(const Recording& log) {
  std::vector<bool> out(static_cast<std::size_t>(log.rows()), true);
  if (!has_torque(log) || log.find("speed") == nullptr) return out;
  const Driving driving(log);
  for (Index row = 1; row < log.rows(); ++row) out[static_cast<std::size_t>(row)] = driving.knows_gain(row);
  return out;
}

VectorXd car_prediction(const std::string& channel, const World& world, const Comparison& comparison,
                        const BatteryResponse&) {
  if (channel == "power") return power_of(world, comparison);
  if (channel == "speed") return gained_speed(world, comparison);
  if (channel == "motor_torque") return released_torque(world, comparison);
  return motor_speed_of(world, comparison);
}

}  // namespace voltlap::plant

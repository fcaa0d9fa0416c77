// SPDX-License-Identifier: Apache-2.0
#include "race/run_assertions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "race/limit_reason.hpp"

namespace voltlap::plant {
namespace {

/// The names of the bits that are set: "PrechargeTimeout, MasterLost", or "none".
template <std::size_t N>
std::string names_of(unsigned bits, const char* const (&names)[N]) {
  std::string out;
  for (std::size_t k = 0; k < N; ++k) {
    if ((bits >> k & 1U) != 0) out += (out.empty() ? "" : ", ") + std::string(names[k]);
  }
  return out.empty() ? "none" : out;
}

constexpr double kRest_s = 10.0;   // after the start and after a seam of the tiled trace the speed may be off
constexpr double kOvercharged = 1.001;  // a leak or the noise of sums aside
constexpr double kStall_s = 30.0;  // without a metre of progress

/// A pack whose voltage does not reach the inverter's: nothing else says why a car does not move.
std::string inverter_off_text(const Car& car) {
  const double least_v = car.parameters().inverter.dc_voltage_min_v, link_v = car.dc_link_voltage();
  if (!car.contactors.main_closed() || link_v >= least_v) return {};
  return fmt::format("; the inverter is off below inverter.dc_voltage_min_v = {:g} V, the DC link has {:.1f} V",
                     least_v, link_v);
}

std::string why_slow(const Car& car, const CommandReceiver& ecus) {
  if (ecus.master().faults != 0 || ecus.bms().faults != 0) return "; " + state_text(car, ecus);
  const std::size_t limit = binding_limit_reason(ecus);
  if (limit == 0) return inverter_off_text(car);
  return fmt::format("; {} held it back: with a higher assertions.speed_error_max_mps it drives on, slower",
                     limit_reason_name(limit));
}

}  // namespace

std::optional<std::string> RunAssertions::broken(const Car& car, const CommandReceiver& ecus, const DriveMoment& now) {
  VOLTLAP_DEMAND(now.time_s >= progress_s_);
  VOLTLAP_DEMAND(now.lap >= 1);
  VOLTLAP_DEMAND(within(now.since_seam_s, 0.0, now.time_s) && std::isfinite(now.target_mps));
  const double speed_mps = car.vehicle().speed_mps();
  const double error_mps = now.target_mps - speed_mps;
  const double battery_c = car.pack().temperature_max_c(), winding_c = car.motor_thermal().copper_c();
  const std::size_t emptiest = car.pack().emptiest_cell();
  if (car.pack().cell_soc(emptiest) <= 0.0) {
    return fmt::format("cell {} is empty, {:.0f} m into lap {}; the pack holds {:.1f} % on average", emptiest + 1,
                       now.lap_distance_m, now.lap, std::max(0.0, 100.0 * car.pack().soc_mean()));
  }
  const std::size_t fullest = car.pack().fullest_cell();
  if (car.pack().cell_soc(fullest) > kOvercharged) {
    return fmt::format("cell {} is charged to {:.1f} %, {:.0f} m into lap {}; the pack holds {:.1f} % on average",
                       fullest + 1, 100.0 * car.pack().cell_soc(fullest), now.lap_distance_m, now.lap,
                       100.0 * car.pack().soc_mean());
  }
  if (ecus.master().drive_state != can::DriveState::kReadyToDrive) {
    return fmt::format("the master controller left ready-to-drive ({})", state_text(car, ecus));
  }
  if (car.voltage_collapsed()) {
    return fmt::format("the pack could not deliver the power that was asked: voltage collapsed at {:.1f} V",
                       car.pack().voltage());
  }
  if (now.since_seam_s > kRest_s && std::abs(error_mps) > bounds_.speed_error_max_mps) {
    return fmt::format(
        "speed error {:.1f} m/s (target {:.1f}, driven {:.1f}) is beyond assertions.speed_error_max_mps = {:g}, "
        "{:.0f} m into lap {}{}",
        error_mps, now.target_mps, speed_mps, bounds_.speed_error_max_mps, now.lap_distance_m, now.lap,
        why_slow(car, ecus));
  }
  if (std::abs(now.offset_m) > bounds_.off_course_max_m) {
    return fmt::format(
        "the car ran off the course, {:.0f} m into lap {}: {:.1f} m beside its line at {:.1f} m/s (target {:.1f}), "
        "beyond assertions.off_course_max_m = {:g}",
        now.lap_distance_m, now.lap, std::abs(now.offset_m), speed_mps, now.target_mps, bounds_.off_course_max_m);
  }
  if (battery_c > bounds_.battery_temperature_max_c) {
    return fmt::format("battery at {:.1f} degC is beyond assertions.battery_temperature_max_c = {:g}", battery_c,
                       bounds_.battery_temperature_max_c);
  }
  if (winding_c > bounds_.motor_temperature_max_c) {
    return fmt::format("motor winding at {:.1f} degC is beyond assertions.motor_temperature_max_c = {:g}", winding_c,
                       bounds_.motor_temperature_max_c);
  }
  if (by_position_ && stalled(car.vehicle().distance_m(), now.time_s)) {
    return fmt::format("the car has stood still for {:.0f} s ({})", kStall_s, state_text(car, ecus));
  }
  return std::nullopt;
}

bool RunAssertions::stalled(double distance_m, double time_s) {
  if (distance_m > progress_m_ + 1.0) {
    progress_m_ = distance_m;
    progress_s_ = time_s;
    return false;
  }
  return time_s - progress_s_ > kStall_s;
}

std::string state_text(const Car& car, const CommandReceiver& ecus) {
  return fmt::format("drive state {}, master faults {}; BMS state {}, BMS faults {}{}",
                     can::kDriveStateNames[static_cast<std::size_t>(ecus.master().drive_state)],
                     names_of(ecus.master().faults, can::kMasterFaultNames),
                     can::kBmsStateNames[static_cast<std::size_t>(ecus.bms().state)],
                     names_of(ecus.bms().faults, can::kBmsFaultNames), inverter_off_text(car));
}

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// The rows of the firmware's configurations, and what a value that nobody gives follows.
#include <algorithm>

#include "core/axle_motors.hpp"
#include "core/parameter_rows.hpp"

namespace voltlap::plant {
namespace {

using Car = VehicleParameters;
using enum Presence;

constexpr double kTripMargin_v = 0.1;  // below the least cell voltage, where the limit already holds it
constexpr double kTripMarginHigh_v = 0.05;
constexpr double kCurrentTripFactor = 1.2;
constexpr double kCurrentRange_a = 1000.0;  // of PackSensor: above it nothing is seen to trip on
constexpr double kDeratingBand_k = 5.0;
constexpr double kBalancingBelowMax_v = 0.3;
constexpr double kEndShare_per_h = 0.02;  // of the capacity: a usual end of a charge
constexpr double kChargerStep_a = 0.1;    // of ChargerCommand

double cell_voltage_min_v(const Car& car) { return car.bms.cell_voltage_min_v.value_or(car.cell.voltage_min_v); }
double cell_voltage_max_v(const Car& car) { return car.bms.cell_voltage_max_v.value_or(car.cell.voltage_max_v); }
double cell_voltage_trip_low_v(const Car& car) { return cell_voltage_min_v(car) - kTripMargin_v; }
double cell_voltage_trip_high_v(const Car& car) { return cell_voltage_max_v(car) + kTripMarginHigh_v; }
double temperature_derating_start_c(const Car& car) { return car.bms.temperature_max_c - kDeratingBand_k; }
double discharge_current_trip_a(const Car& car) {
  return std::min(kCurrentRange_a, car.bms.discharge_current_max_a * kCurrentTripFactor);
}
double charge_current_trip_a(const Car& car) {
  const double most = std::max({1.0, car.bms.charge_current_max_a, car.bms.charger_current_max_a});
  return std::min(kCurrentRange_a, most * kCurrentTripFactor);
}
double balancing_voltage_min_v(const Car& car) {
  return std::max(0.0, cell_voltage_max_v(car) - kBalancingBelowMax_v);
}
double charge_current_end_a(const Car& car) {
  const double capacity_ah = car.bms.capacity_ah > 0.0 ? car.bms.capacity_ah
                                                       : car.cell.capacity_ah * car.battery.cells_in_parallel;
  const double most = car.bms.charger_current_max_a > 0.0 ? car.bms.charger_current_max_a : kChargerStep_a;
  return std::clamp(kEndShare_per_h * capacity_ah, kChargerStep_a, std::max(kChargerStep_a, most));
}
double phase_current_max_a(const Car& car) { return full_phase_current_a(car); }
double motor_constant_nm_per_a(const Car& car) { return car.motor.constant_nm_per_a; }

// clang-format off
const ParameterRow kRows[] = {
  {"bms.discharge_current_max_a", "A", 0, 1000, kRequired, at<&Car::bms, &BmsSection::discharge_current_max_a>,
    "largest discharge limit that the BMS gives"},
  {"bms.charge_current_max_a", "A", 0, 1000, kRequired, at<&Car::bms, &BmsSection::charge_current_max_a>,
    "largest charge limit that the BMS gives"},
  {"bms.temperature_max_c", "degC", 0, 100, kRequired, at<&Car::bms, &BmsSection::temperature_max_c>,
    "cell temperature that trips the BMS"},
  {"bms.resistance_ohm", "ohm", 0, 1, kOptional, at<&Car::bms, &BmsSection::resistance_ohm>,
    "a parallel group's resistance in the BMS's limit; 0: from the cell file"},
  {"bms.resistance_per_kelvin", "1/K", -0.2, 0.2, kOptional, at<&Car::bms, &BmsSection::resistance_per_kelvin>,
    "relative change of bms.resistance_ohm per kelvin from cell.reference_temperature_c"},
  {"bms.capacity_ah", "Ah", 0, 1000, kOptional, at<&Car::bms, &BmsSection::capacity_ah>,
    "the BMS's idea of the capacity of a parallel group; 0: the plant's"},
  {"bms.ocv_soc", "1", 0, 1, kOptional, at<&Car::bms, &BmsSection::ocv_soc>,
    "SOC of the BMS's own open-circuit voltage points, increasing; empty: the cell file's curve"},
  {"bms.ocv_v", "V", 0, 5, kOptional, at<&Car::bms, &BmsSection::ocv_v>,
    "open-circuit voltage of a cell at those points, increasing"},
  {"bms.soc_method", "-", 0, 0, kOptional, at<&Car::bms, &BmsSection::soc_method>,
    "coulomb: counted charge, started from the OCV at rest; ekf: a Kalman filter of every cell; none: not known"},
  {"bms.limit_method", "-", 0, 0, kOptional, at<&Car::bms, &BmsSection::limit_method>,
    "equation: from the voltage now and one resistance; ahead: what each cell can do for bms.limit_horizon_s, by its "
    "own filter; table: by temperature and charge"},
  {"bms.limit_horizon_s", "s", 0, 30, kOptional, at<&Car::bms, &BmsSection::limit_horizon_s>,
    "how long a limit must hold, for bms.limit_method ahead: 1, 10 or 30 s, or 0 for ever"},
  {"bms.soc_start_current_a", "A", 0, 100, kOptional, at<&Car::bms, &BmsSection::soc_start_current_a>,
    "cells count as at rest, and the count may start, up to this current"},
  {"bms.cell_voltage_min_v", "V", 0, 5, kOptional, at<&Car::bms, &BmsSection::cell_voltage_min_v>,
    "the discharge limit keeps every cell above it", {cell_voltage_min_v, "cell.voltage_min_v"}},
  {"bms.cell_voltage_max_v", "V", 0, 5, kOptional, at<&Car::bms, &BmsSection::cell_voltage_max_v>,
    "the charge limit keeps every cell below it", {cell_voltage_max_v, "cell.voltage_max_v"}},
  {"bms.limit_rise_a_per_s", "A/s", 0, 1e6, kOptional, at<&Car::bms, &BmsSection::limit_rise_a_per_s>,
    "a limit falls at once and rises so fast"},
  {"bms.temperature_derating_start_c", "degC", -40, 100, kOptional,
    at<&Car::bms, &BmsSection::temperature_derating_start_c>,
    "limits fall from here to zero at bms.temperature_max_c",
    {temperature_derating_start_c, "5 K below bms.temperature_max_c"}},
  {"bms.charge_temperature_min_c", "degC", -60, 60, kOptional, at<&Car::bms, &BmsSection::charge_temperature_min_c>,
    "no charging of a colder cell"},
  {"bms.soc_derating_start", "1", 0, 1, kOptional, at<&Car::bms, &BmsSection::soc_derating_start>,
    "the discharge limit falls from here to zero at SOC 0; 0: it does not"},
  {"bms.energy_to_go_km", "km", 0, 1000, kOptional, at<&Car::bms, &BmsSection::energy_to_go_km>,
    "the discharge limit spreads the charge over this distance since the last charge; 0: it does not"},
  {"bms.energy_to_go_reserve", "1", 0, 1, kOptional, at<&Car::bms, &BmsSection::energy_to_go_reserve>,
    "state of charge that bms.energy_to_go_km leaves at the end"},
  {"bms.cell_voltage_trip_low_v", "V", 0, 5, kOptional, at<&Car::bms, &BmsSection::cell_voltage_trip_low_v>,
    "cell voltage that trips, low", {cell_voltage_trip_low_v, "0.1 V below bms.cell_voltage_min_v"}},
  {"bms.cell_voltage_trip_high_v", "V", 0, 5, kOptional, at<&Car::bms, &BmsSection::cell_voltage_trip_high_v>,
    "cell voltage that trips, high", {cell_voltage_trip_high_v, "0.05 V above bms.cell_voltage_max_v"}},
  {"bms.cell_voltage_plausible_min_v", "V", 0, 5, kOptional, at<&Car::bms, &BmsSection::cell_voltage_plausible_min_v>,
    "a lower reading is a broken wire, not a voltage"},
  {"bms.cell_voltage_plausible_max_v", "V", 0, 10, kOptional, at<&Car::bms, &BmsSection::cell_voltage_plausible_max_v>,
    "a higher reading is a broken wire, not a voltage"},
  {"bms.discharge_current_trip_a", "A", 0, 100000, kOptional, at<&Car::bms, &BmsSection::discharge_current_trip_a>,
    "discharge current that trips",
    {discharge_current_trip_a, "1.2 times bms.discharge_current_max_a, at most 1000 A"}},
  {"bms.charge_current_trip_a", "A", 0, 100000, kOptional, at<&Car::bms, &BmsSection::charge_current_trip_a>,
    "charge current that trips",
    {charge_current_trip_a,
      "1.2 times the larger of bms.charge_current_max_a and bms.charger_current_max_a, 1.2 A to 1000 A"}},
  {"bms.voltage_mismatch", "1", 0, 1, kOptional, at<&Car::bms, &BmsSection::voltage_mismatch>,
    "share by which the pack voltage may differ from the sum of the cells"},
  {"bms.voltage_trip_time_s", "s", 0, 60, kOptional, at<&Car::bms, &BmsSection::voltage_trip_time_s>,
    "how long a cell voltage is beyond its trip before it trips"},
  {"bms.temperature_trip_time_s", "s", 0, 60, kOptional, at<&Car::bms, &BmsSection::temperature_trip_time_s>,
    "how long a temperature is at its trip before it trips"},
  {"bms.current_trip_time_s", "s", 0, 60, kOptional, at<&Car::bms, &BmsSection::current_trip_time_s>,
    "how long a current is beyond its trip before it trips"},
  {"bms.voltage_mismatch_time_s", "s", 0, 60, kOptional, at<&Car::bms, &BmsSection::voltage_mismatch_time_s>,
    "how long the pack voltage disagrees with the cells before it trips"},
  {"bms.measurement_lost_time_s", "s", 0, 60, kOptional, at<&Car::bms, &BmsSection::measurement_lost_time_s>,
    "age of the last good sample that trips"},
  {"bms.precharge_ratio", "1", 0, 1, kOptional, at<&Car::bms, &BmsSection::precharge_ratio>,
    "share of the pack voltage that the DC link must reach before AIR+ closes"},
  {"bms.precharge_timeout_s", "s", 0, 600, kOptional, at<&Car::bms, &BmsSection::precharge_timeout_s>,
    "a precharge that takes longer is given up"},
  {"bms.precharge_time_min_s", "s", 0, 600, kOptional, at<&Car::bms, &BmsSection::precharge_time_min_s>,
    "a precharge that takes less means a welded AIR+"},
  {"bms.contactor_time_s", "s", 0, 60, kOptional, at<&Car::bms, &BmsSection::contactor_time_s>,
    "for an auxiliary contact to follow its command"},
  {"bms.contactor_drop_time_s", "s", 0, 60, kOptional, at<&Car::bms, &BmsSection::contactor_drop_time_s>,
    "how long a contactor may be seen open while the system is active"},
  {"bms.isolation_time_s", "s", 0, 60, kOptional, at<&Car::bms, &BmsSection::isolation_time_s>,
    "how long the isolation monitor reports a fault before it trips"},
  {"bms.dc_link_discharge_time_s", "s", 0, 600, kOptional, at<&Car::bms, &BmsSection::dc_link_discharge_time_s>,
    "the DC link must be down so long after opening"},
  {"bms.dc_link_welded", "1", 0, 1, kOptional, at<&Car::bms, &BmsSection::dc_link_welded>,
    "share of the pack voltage above which the DC link counts as still connected"},
  {"bms.charger_current_max_a", "A", 0, 1000, kOptional, at<&Car::bms, &BmsSection::charger_current_max_a>,
    "largest current that the BMS asks of a charger; 0: this pack has none"},
  {"bms.charge_margin_v", "V", 0, 1, kOptional, at<&Car::bms, &BmsSection::charge_margin_v>,
    "the highest cell is charged to so much below bms.cell_voltage_max_v: error of its reading"},
  {"bms.charge_current_end_a", "A", 0, 1000, kOptional, at<&Car::bms, &BmsSection::charge_current_end_a>,
    "the highest cell is full when it is held by no more current",
    {charge_current_end_a, "a fiftieth of the capacity per hour, 0.1 A to bms.charger_current_max_a"}},
  {"bms.balancing_voltage_min_v", "V", 0, 5, kOptional, at<&Car::bms, &BmsSection::balancing_voltage_min_v>,
    "no balancing of a cell below it", {balancing_voltage_min_v, "0.3 V below bms.cell_voltage_max_v"}},
  {"bms.balancing_difference_v", "V", 0, 5, kOptional, at<&Car::bms, &BmsSection::balancing_difference_v>,
    "a cell so far above the lowest is balanced"},
  {"bms.balancing_current_max_a", "A", 0, 1000, kOptional, at<&Car::bms, &BmsSection::balancing_current_max_a>,
    "no balancing at more pack current than this"},
  {"bms.balancing_time_max_s", "s", 0, 1e6, kOptional, at<&Car::bms, &BmsSection::balancing_time_max_s>,
    "time of bleeding after which a charge is given up"},
  {"master.apps1_released_v", "V", 0, 5, kOptional, at<&Car::master, &MasterSection::apps1_released_v>,
    "accelerator sensor 1, pedal released; the pedal box follows it"},
  {"master.apps1_full_v", "V", 0, 5, kOptional, at<&Car::master, &MasterSection::apps1_full_v>,
    "accelerator sensor 1, pedal pressed"},
  {"master.apps1_range_min_v", "V", 0, 5, kOptional, at<&Car::master, &MasterSection::apps1_range_min_v>,
    "accelerator sensor 1 has failed below it"},
  {"master.apps1_range_max_v", "V", 0, 5, kOptional, at<&Car::master, &MasterSection::apps1_range_max_v>,
    "accelerator sensor 1 has failed above it"},
  {"master.apps2_released_v", "V", 0, 5, kOptional, at<&Car::master, &MasterSection::apps2_released_v>,
    "accelerator sensor 2, pedal released; the pedal box follows it"},
  {"master.apps2_full_v", "V", 0, 5, kOptional, at<&Car::master, &MasterSection::apps2_full_v>,
    "accelerator sensor 2, pedal pressed"},
  {"master.apps2_range_min_v", "V", 0, 5, kOptional, at<&Car::master, &MasterSection::apps2_range_min_v>,
    "accelerator sensor 2 has failed below it"},
  {"master.apps2_range_max_v", "V", 0, 5, kOptional, at<&Car::master, &MasterSection::apps2_range_max_v>,
    "accelerator sensor 2 has failed above it"},
  {"master.apps_disagreement_max", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::apps_disagreement_max>,
    "share of travel by which the accelerator sensors may differ"},
  {"master.apps_implausible_time_s", "s", 0, 60, kOptional, at<&Car::master, &MasterSection::apps_implausible_time_s>,
    "how long before an accelerator sensor's fault stops the torque"},
  {"master.brake_sensor_fail_time_s", "s", 0, 60, kOptional, at<&Car::master, &MasterSection::brake_sensor_fail_time_s>,
    "how long before a brake sensor's fault stops the torque"},
  {"master.brake_throttle_limit", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::brake_throttle_limit>,
    "accelerator travel that, with the brake on, stops the torque"},
  {"master.pedal_release_level", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::pedal_release_level>,
    "below this travel the accelerator counts as released"},
  {"master.pedal_dead_zone", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::pedal_dead_zone>,
    "travel of the accelerator without request"},
  {"master.pedal_at_half", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::pedal_at_half>,
    "share of the full request at half travel behind the dead zone: 0.5 is straight, less is finer at the start"},
  {"master.brake_pressed_bar", "bar", 0, 200, kOptional, at<&Car::master, &MasterSection::brake_pressed_bar>,
    "above this pressure the brake counts as pressed"},
  {"master.brake_compare_bar", "bar", 0, 200, kOptional, at<&Car::master, &MasterSection::brake_compare_bar>,
    "with more than this in one brake circuit a sensor has failed when the other is not pressed"},
  {"master.phase_current_max_a", "A", 0, 5000, kOptional, at<&Car::master, &MasterSection::phase_current_max_a>,
    "phase current of the full pedal, of all motors", {phase_current_max_a, "inverter.current_max_a"}},
  {"master.request_rise_a_per_s", "A/s", 0, 2e6, kOptional, at<&Car::master, &MasterSection::request_rise_a_per_s>,
    "the request grows so fast and falls at once"},
  {"master.regen_current_max_a", "A", 0, 5000, kOptional, at<&Car::master, &MasterSection::regen_current_max_a>,
    "phase current of full regeneration; 0: none"},
  {"master.regen_full_brake_bar", "bar", 0, 200, kOptional, at<&Car::master, &MasterSection::regen_full_brake_bar>,
    "brake pressure of full regeneration"},
  {"master.arbitration", "-", 0, 0, kOptional, at<&Car::master, &MasterSection::arbitration>,
    "power_balance: a battery limit is a ceiling on power; literal: on the phase current"},
  {"master.motor_constant_nm_per_a", "Nm/A", 0.001, 10, kOptional,
    at<&Car::master, &MasterSection::motor_constant_nm_per_a>,
    "the controller's idea of the motor's constant", {motor_constant_nm_per_a, "motor.constant_nm_per_a"}},
  {"master.drive_efficiency", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::drive_efficiency>,
    "the controller's idea of shaft power over DC power; a low one lowers the ceilings"},
  {"master.power_max_kw", "kW", 0, 1000, kOptional, at<&Car::master, &MasterSection::power_max_kw>,
    "DC power that the controller steers its mean below, an instant may exceed it; the rules allow 80"},
  {"master.motor_speed_max_rpm", "rpm", 0, 100000, kOptional, at<&Car::master, &MasterSection::motor_speed_max_rpm>,
    "no driving torque at or beyond this motor speed; it is assumed when the speed is not known"},
  {"master.ceiling_rise_a_per_s", "A/s", 0, 2e6, kOptional, at<&Car::master, &MasterSection::ceiling_rise_a_per_s>,
    "a ceiling on the phase current falls at once and rises so fast"},
  {"master.trim_gain", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::trim_gain>,
    "share of a measured excess over a limit that each step takes off the ceilings"},
  {"master.trim_max", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::trim_max>,
    "most that this may take off"},
  {"master.trim_decay_per_s", "1/s", 0, 1000, kOptional, at<&Car::master, &MasterSection::trim_decay_per_s>,
    "how fast it is given back"},
  {"master.battery_limit_off_a", "A", 0, 1000, kOptional, at<&Car::master, &MasterSection::battery_limit_off_a>,
    "a battery limit below it shuts that direction"},
  {"master.battery_limit_on_a", "A", 0, 1000, kOptional, at<&Car::master, &MasterSection::battery_limit_on_a>,
    "a battery limit above it opens that direction again"},
  {"master.regen_speed_min_mps", "m/s", 0, 200, kOptional, at<&Car::master, &MasterSection::regen_speed_min_mps>,
    "no regeneration at or below this speed of the slowest wheel"},
  {"master.inverter_excess_max_a", "A", 0, 2000, kOptional, at<&Car::master, &MasterSection::inverter_excess_max_a>,
    "phase current beyond all that was asked for from which the inverter has failed"},
  {"master.limp_share", "1", 0, 1, kOptional, at<&Car::master, &MasterSection::limp_share>,
    "share of the full current that is left when motor or inverter temperature is not known; 0: none"},
  {"master.motor_derating_start_c", "degC", -40, 500, kOptional,
    at<&Car::master, &MasterSection::motor_derating_start_c>,
    "a hotter motor gets less current"},
  {"master.motor_derating_end_c", "degC", -40, 500, kOptional, at<&Car::master, &MasterSection::motor_derating_end_c>,
    "a motor at this temperature gets none"},
  {"master.inverter_derating_start_c", "degC", -40, 500, kOptional,
    at<&Car::master, &MasterSection::inverter_derating_start_c>,
    "a hotter inverter gives less current"},
  {"master.inverter_derating_end_c", "degC", -40, 500, kOptional,
    at<&Car::master, &MasterSection::inverter_derating_end_c>,
    "an inverter at this temperature gives none"},
  {"master.ts_request_timeout_s", "s", 0, 600, kOptional, at<&Car::master, &MasterSection::ts_request_timeout_s>,
    "longest wait for the battery's contactors"},
  {"master.rtd_sound_time_s", "s", 0, 60, kOptional, at<&Car::master, &MasterSection::rtd_sound_time_s>,
    "length of the ready-to-drive sound"},
  {"master.rx_timeout_s", "s", 0, 60, kOptional, at<&Car::master, &MasterSection::rx_timeout_s>,
    "oldest input that may carry torque"},
};
// clang-format on

}  // namespace

std::span<const ParameterRow> firmware_parameter_rows() { return kRows; }

}  // namespace voltlap::plant

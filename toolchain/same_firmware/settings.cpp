// SPDX-License-Identifier: Apache-2.0
#include "settings.hpp"

#include <algorithm>

namespace same_firmware {
namespace {

constexpr double kChanged = 0.15;  // share of the settings that a run changes
constexpr double kRefused = 0.02;  // share of the runs with a configuration that a node refuses

void maybe(Draw& draw, std::int32_t& setting, std::int32_t low, std::int32_t high) {
  if (draw.chance(kChanged)) setting = draw.between(low, high);
}

BmsSettings draw_bms(Draw& draw) {
  BmsSettings s;
  if (draw.chance(0.3)) s.cells_in_series = draw.between(1, 144);
  s.temperature_sensors = std::clamp((s.cells_in_series + 3) / 4, 1, 36);
  maybe(draw, s.capacity_mah, 1'000, 200'000);
  maybe(draw, s.ocv_middle, 33'000, 40'000);
  maybe(draw, s.resistance_empty, 500, 20'000);
  maybe(draw, s.resistance_full, 500, 20'000);
  maybe(draw, s.resistance_ppm_per_kelvin, -30'000, 10'000);
  maybe(draw, s.soc_method, 0, 1);
  maybe(draw, s.discharge_current_max, 50'000, 600'000);
  maybe(draw, s.charge_current_max, 0, 300'000);
  maybe(draw, s.limit_rise_per_s, 1'000, 5'000'000);
  maybe(draw, s.soc_derating_start, 0, 500'000);
  maybe(draw, s.derating_start, 300, 590);
  maybe(draw, s.charge_temperature_min, -100, 250);
  maybe(draw, s.voltage_trip_time, 10, 1'000);
  maybe(draw, s.temperature_trip_time, 10, 1'000);
  maybe(draw, s.current_trip_time, 10, 1'000);
  maybe(draw, s.measurement_lost_time, 10, 1'000);
  maybe(draw, s.mismatch_time, 10, 1'000);
  maybe(draw, s.contactor_time, 20, 500);
  maybe(draw, s.precharge_timeout, 200, 5'000);
  maybe(draw, s.precharge_time_min, 0, 100);
  maybe(draw, s.discharge_time, 100, 5'000);
  maybe(draw, s.balancing_voltage_min, 30'000, 41'000);
  if (draw.chance(kRefused)) s.temperature_sensors = 0;
  return s;
}

MasterSettings draw_master(Draw& draw) {
  MasterSettings s;
  maybe(draw, s.phase_current_max, 50'000, 550'000);
  maybe(draw, s.request_rise_ma_per_ms, 100, 50'000);
  if (draw.chance(0.5)) s.regen_current_max = 50'000;
  maybe(draw, s.pedal_dead_zone, 0, 200'000);
  maybe(draw, s.arbitration, 0, 1);
  maybe(draw, s.motor_constant_unm_per_a, 50'000, 500'000);
  maybe(draw, s.drive_efficiency, 300'000, 1'000'000);
  maybe(draw, s.power_max_mw, 5'000'000, 80'000'000);
  maybe(draw, s.ceiling_rise_ma_per_s, 100'000, 10'000'000);
  maybe(draw, s.trim_gain, 0, 1'000'000);
  maybe(draw, s.motor_derate_start, 400, 1'500);
  maybe(draw, s.ts_request_timeout, 100, 10'000);
  maybe(draw, s.rtd_sound_time, 1'000, 3'000);
  maybe(draw, s.rx_timeout, 10, 50);
  if (draw.chance(kRefused)) s.rtd_sound_time = 500;
  return s;
}

}  // namespace

Settings draw_settings(Draw& draw) {
  const BmsSettings bms = draw_bms(draw);
  return {bms, draw_master(draw)};
}

std::vector<NamedSetting> settings_by_name(Settings& settings) {
  BmsSettings& b = settings.bms;
  MasterSettings& m = settings.master;
  static_assert(sizeof(Settings) == 42 * sizeof(std::int32_t), "a setting is missing below");
  return {
      {"cells_in_series", &b.cells_in_series}, {"temperature_sensors", &b.temperature_sensors},
      {"capacity_mah", &b.capacity_mah}, {"ocv_empty", &b.ocv_empty}, {"ocv_middle", &b.ocv_middle},
      {"ocv_full", &b.ocv_full}, {"resistance_empty", &b.resistance_empty},
      {"resistance_full", &b.resistance_full}, {"resistance_ppm_per_kelvin", &b.resistance_ppm_per_kelvin},
      {"soc_method", &b.soc_method}, {"discharge_current_max", &b.discharge_current_max},
      {"charge_current_max", &b.charge_current_max}, {"discharge_current_trip", &b.discharge_current_trip},
      {"charge_current_trip", &b.charge_current_trip}, {"limit_rise_per_s", &b.limit_rise_per_s},
      {"soc_derating_start", &b.soc_derating_start}, {"derating_start", &b.derating_start},
      {"charge_temperature_min", &b.charge_temperature_min}, {"voltage_trip_time", &b.voltage_trip_time},
      {"temperature_trip_time", &b.temperature_trip_time}, {"current_trip_time", &b.current_trip_time},
      {"measurement_lost_time", &b.measurement_lost_time}, {"mismatch_time", &b.mismatch_time},
      {"contactor_time", &b.contactor_time}, {"precharge_timeout", &b.precharge_timeout},
      {"precharge_time_min", &b.precharge_time_min}, {"discharge_time", &b.discharge_time},
      {"balancing_voltage_min", &b.balancing_voltage_min},
      {"phase_current_max", &m.phase_current_max}, {"request_rise_ma_per_ms", &m.request_rise_ma_per_ms},
      {"regen_current_max", &m.regen_current_max}, {"pedal_dead_zone", &m.pedal_dead_zone},
      {"arbitration", &m.arbitration}, {"motor_constant_unm_per_a", &m.motor_constant_unm_per_a},
      {"drive_efficiency", &m.drive_efficiency}, {"power_max_mw", &m.power_max_mw},
      {"ceiling_rise_ma_per_s", &m.ceiling_rise_ma_per_s}, {"trim_gain", &m.trim_gain},
      {"motor_derate_start", &m.motor_derate_start}, {"ts_request_timeout", &m.ts_request_timeout},
      {"rtd_sound_time", &m.rtd_sound_time}, {"rx_timeout", &m.rx_timeout}};
}

}  // namespace same_firmware

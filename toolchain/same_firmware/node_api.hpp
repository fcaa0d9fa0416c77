// SPDX-License-Identifier: Apache-2.0
// The one door between the comparison and the nodes of a version of the firmware. Each version is a shared object of
// its own, with hidden symbols, because both have the same names inside.
#pragma once
#include <cstddef>
#include <cstdint>

namespace same_firmware {

struct WireFrame {
  std::uint32_t id = 0;
  std::uint8_t dlc = 0;
  std::uint8_t data[8] = {};
};
inline constexpr std::size_t kSentMax = 32;

enum class Which : std::uint8_t { kBms = 0, kMaster = 1 };

/// The value that the version's own configuration has by itself, so that a changed default is seen.
inline constexpr std::int32_t kOwn = INT32_MIN;

/// In the firmware's units; every name is a field of bms::Config or master::Config, or says what it fills there.
struct BmsSettings {
  std::int32_t cells_in_series = 24, temperature_sensors = 6, capacity_mah = 10'000;
  std::int32_t ocv_empty = 30'000, ocv_middle = 37'000, ocv_full = 42'000;
  std::int32_t resistance_empty = 3'000, resistance_full = 2'000, resistance_ppm_per_kelvin = 0;
  std::int32_t soc_method = kOwn;
  std::int32_t discharge_current_max = 500'000, charge_current_max = 200'000;
  std::int32_t discharge_current_trip = 600'000, charge_current_trip = 300'000;
  std::int32_t limit_rise_per_s = kOwn, soc_derating_start = kOwn, derating_start = kOwn;
  std::int32_t charge_temperature_min = kOwn;
  std::int32_t voltage_trip_time = kOwn, temperature_trip_time = kOwn, current_trip_time = kOwn;
  std::int32_t measurement_lost_time = kOwn, mismatch_time = kOwn, contactor_time = kOwn;
  std::int32_t precharge_timeout = kOwn, precharge_time_min = kOwn, discharge_time = kOwn;
  std::int32_t balancing_voltage_min = kOwn;
};
struct MasterSettings {
  std::int32_t phase_current_max = kOwn, request_rise_ma_per_ms = kOwn, regen_current_max = kOwn;
  std::int32_t pedal_dead_zone = kOwn, arbitration = kOwn, motor_constant_unm_per_a = kOwn;
  std::int32_t drive_efficiency = kOwn, power_max_mw = kOwn, ceiling_rise_ma_per_s = kOwn, trim_gain = kOwn;
  std::int32_t motor_derate_start = kOwn, ts_request_timeout = kOwn, rtd_sound_time = kOwn, rx_timeout = kOwn;
};
struct Settings {
  BmsSettings bms;
  MasterSettings master;
};

struct NodeApi {
  void* (*create)(Which which, const Settings& settings);
  void (*destroy)(Which which, void* node);
  /// Number of frames sent, at most kSentMax.
  std::size_t (*tick)(Which which, void* node, std::uint32_t now_ms, const WireFrame* rx, std::size_t count,
                      WireFrame* tx);
};

/// Takes the place of require_failed; does not return.
using Failed = void (*)(const char* condition);

/// `same_firmware_nodes` of each shared object.
using OpenNodes = const NodeApi* (*)(Failed failed);

}  // namespace same_firmware

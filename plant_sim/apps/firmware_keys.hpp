// SPDX-License-Identifier: Apache-2.0
// The fields of the firmware's configurations that are keys of a car file: one row for each, with how finely the
// firmware counts. Words, tables and the BMS's idea of the capacity are not among them (firmware_config.cpp).
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "bms/config.hpp"
#include "core/parameters.hpp"
#include "master/config.hpp"

namespace voltlap::plant {

template <class Config>
struct FirmwareKey {
  std::string_view key;
  std::int32_t counts_per_unit;  ///< of the key's unit: 10 for degC in steps of 0.1
  std::int32_t (*get)(const Config&);
  void (*set)(Config&, std::int32_t counts);
};

[[nodiscard]] std::span<const FirmwareKey<bms::Config>> bms_keys();
[[nodiscard]] std::span<const FirmwareKey<master::Config>> master_keys();

/// Every row's value of the car, to the nearest count.
void fill_from_keys(const VehicleParameters& car, bms::Config& config);
void fill_from_keys(const VehicleParameters& car, master::Config& config);

/// How finely the firmware counts a key: "0.1 degC"; empty for a key that is not a number of the firmware.
[[nodiscard]] std::string firmware_step_text(std::string_view key);

}  // namespace voltlap::plant

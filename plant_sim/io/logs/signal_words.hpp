// SPDX-License-Identifier: Apache-2.0
// What the name of a column or of a CAN signal says about it, in the languages that loggers speak.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/table/unit_name.hpp"

namespace voltlap::plant {

enum class Meaning {
  kNothing,
  kTime,
  kCurrent,
  kVoltage,
  kTemperature,
  kSoc,
  kSpeed,
  kMotorSpeed,
  kMotorTorque,
  kLateralAcceleration,
  kAccelerator,
  kBrake,
  kOther,  ///< a quantity that no role has: power, energy, resistance
};

/// Whose quantity it is.
enum class Owner { kNobody, kPack, kCell, kBus, kAmbient, kWheel };

struct SpokenName {
  Meaning meaning = Meaning::kNothing;
  Owner owner = Owner::kNobody;
  bool is_actual = true;       ///< false: a limit, a set point, an extreme, a filtered or a calculated value
  bool is_others = false;      ///< of a motor, an inverter, a pump, a charger
  bool is_motors = false;      ///< of a motor or its phases together
  bool is_plain = false;       ///< nothing but the quantity, its owner, its unit and numbers
  bool is_letter = false;      ///< nothing but one Latin letter
  std::optional<long> number;  ///< the last one in the name
  std::string pattern;         ///< the name as written with <n> for that number; empty without one
};

/// Lower-case words: parted at blanks, marks, digits and capitals ("HvBatteryCurrent", "LB_Current", "zell_3").
[[nodiscard]] std::vector<std::string> words_of(std::string_view name);

[[nodiscard]] SpokenName spoken_name(std::string_view name);

/// Whether a quantity is the one that a meaning is about.
[[nodiscard]] bool is_of(Quantity quantity, Meaning meaning);

}  // namespace voltlap::plant

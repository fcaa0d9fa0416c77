// SPDX-License-Identifier: Apache-2.0
// Integer quantities: the unit is in the type, `from_raw` and `raw` are the only doors in and out, sums saturate.
#pragma once
#include <cstdint>
#include <limits>

namespace voltlap {

/// An amount of one unit, kept in 32 bits. Addition and subtraction saturate at the ends of the range: a limit that
/// overflows must never wrap from "none" to "everything".
template <class Tag>
class Quantity {
 public:
  using Raw = std::int32_t;

  constexpr Quantity() = default;
  [[nodiscard]] static constexpr Quantity from_raw(Raw value) { return Quantity(value); }
  /// From a wider intermediate, saturated.
  [[nodiscard]] static constexpr Quantity saturated(std::int64_t value) {
    constexpr std::int64_t low = std::numeric_limits<Raw>::min();
    constexpr std::int64_t high = std::numeric_limits<Raw>::max();
    return Quantity(static_cast<Raw>(value < low ? low : (value > high ? high : value)));
  }
  [[nodiscard]] constexpr Raw raw() const { return value_; }

  [[nodiscard]] friend constexpr Quantity operator+(Quantity a, Quantity b) {
    return saturated(std::int64_t{a.value_} + b.value_);
  }
  [[nodiscard]] friend constexpr Quantity operator-(Quantity a, Quantity b) {
    return saturated(std::int64_t{a.value_} - b.value_);
  }
  [[nodiscard]] constexpr Quantity operator-() const { return saturated(-std::int64_t{value_}); }
  friend constexpr bool operator==(Quantity a, Quantity b) { return a.value_ == b.value_; }
  friend constexpr bool operator!=(Quantity a, Quantity b) { return a.value_ != b.value_; }
  friend constexpr bool operator<(Quantity a, Quantity b) { return a.value_ < b.value_; }
  friend constexpr bool operator<=(Quantity a, Quantity b) { return a.value_ <= b.value_; }
  friend constexpr bool operator>(Quantity a, Quantity b) { return a.value_ > b.value_; }
  friend constexpr bool operator>=(Quantity a, Quantity b) { return a.value_ >= b.value_; }

 private:
  constexpr explicit Quantity(Raw value) : value_(value) {}
  Raw value_ = 0;
};

template <class T>
[[nodiscard]] constexpr T min(T a, T b) { return b < a ? b : a; }
template <class T>
[[nodiscard]] constexpr T max(T a, T b) { return a < b ? b : a; }
/// Without its sign, of a quantity or of a wider intermediate.
template <class T>
[[nodiscard]] constexpr T magnitude(T a) { return a < T{} ? -a : a; }

using CellVoltage = Quantity<struct CellVoltageTag>;  ///< 0.1 mV
using PackVoltage = Quantity<struct PackVoltageTag>;  ///< 0.1 mV (to 214 kV; same scale as a cell, another thing)
using Current = Quantity<struct CurrentTag>;          ///< 1 mA, discharge positive
using Temperature = Quantity<struct TemperatureTag>;  ///< 0.1 degC
using Soc = Quantity<struct SocTag>;                  ///< 1 ppm of full charge, 0 .. 1'000'000
using Resistance = Quantity<struct ResistanceTag>;    ///< 1 microohm
using Ratio = Quantity<struct RatioTag>;              ///< 1 ppm, for pedals and shares
using MotorSpeed = Quantity<struct MotorSpeedTag>;    ///< 1 rpm, forward positive
using Speed = Quantity<struct SpeedTag>;              ///< 1 mm/s
using Pressure = Quantity<struct PressureTag>;        ///< 1 mbar
using Potential = Quantity<struct PotentialTag>;      ///< 0.1 mV, of a sensor's output (APPS)

}  // namespace voltlap

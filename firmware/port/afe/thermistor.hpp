// SPDX-License-Identifier: Apache-2.0
// A thermistor between an input and ground, a resistor from the input to the reference: the share of the reference that
// the input sees, and the temperature that it means, by a table.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port::afe {

struct ThermistorPoint {
  std::uint16_t share;         ///< [2^-16] of the reference
  std::int16_t temperature_dc;  ///< [0.1 degC]
};
inline constexpr std::size_t kThermistorPointsMax = 40;

struct ThermistorTable {
  std::size_t count = 0;  ///< 2 to kThermistorPointsMax; shares fall (NTC), temperatures rise
  ThermistorPoint point[kThermistorPointsMax] = {};
};

[[nodiscard]] constexpr bool lawful(const ThermistorTable& t) {
  if (t.count < 2 || t.count > kThermistorPointsMax) return false;
  for (std::size_t i = 1; i < t.count; ++i) {
    if (t.point[i].share >= t.point[i - 1].share) return false;
    if (t.point[i].temperature_dc <= t.point[i - 1].temperature_dc) return false;
  }
  return true;
}

/// Straight between the points. False beyond both ends: an open wire, a short.
[[nodiscard]] constexpr bool temperature_of(const ThermistorTable& t, std::uint32_t share,
                                            std::int32_t& temperature_dc) {
  if (t.count < 2 || share > t.point[0].share || share < t.point[t.count - 1].share) return false;
  std::size_t i = 1;
  while (i + 1 < t.count && share < t.point[i].share) ++i;
  const std::int32_t x0 = t.point[i - 1].share, x1 = t.point[i].share;
  const std::int32_t y0 = t.point[i - 1].temperature_dc, y1 = t.point[i].temperature_dc;
  temperature_dc = y0 + (y1 - y0) * (x0 - static_cast<std::int32_t>(share)) / (x0 - x1);
  return true;
}

/// NTC of 10 kOhm at 25 degC with B25/85 = 3977 K (Vishay NTCLE100E3103), 10 kOhm to the reference: from
/// R = 10 kOhm exp(B (1/T - 1/298.15 K)), -40 to 120 degC in steps of 5 K.
inline constexpr ThermistorTable kNtc10k3977 = {33, {
    {63984, -400}, {63337, -350}, {62479, -300}, {61361, -250}, {59939, -200}, {58172, -150},
    {56031, -100}, {53505, -50}, {50608, 0}, {47379, 50}, {43887, 100}, {40220, 150},
    {36480, 200}, {32768, 250}, {29178, 300}, {25785, 350}, {22642, 400}, {19782, 450},
    {17217, 500}, {14944, 550}, {12950, 600}, {11213, 650}, {9709, 700}, {8411, 750},
    {7295, 800}, {6336, 850}, {5513, 900}, {4807, 950}, {4201, 1000}, {3680, 1050},
    {3231, 1100}, {2844, 1150}, {2510, 1200},
}};
static_assert(lawful(kNtc10k3977));

}  // namespace voltlap::port::afe

// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/resistance.hpp"

#include "base/interpolate.hpp"
#include "base/require.hpp"

namespace voltlap::bms {
namespace {

constexpr std::int64_t kOnePpm = 1'000'000;
constexpr std::int64_t kFactorMin = kOnePpm / 5;
constexpr std::int64_t kFactorMax = kOnePpm * 5;

Resistance highest(const ResistanceTable& table) {
  Resistance result = table.resistance[0];
  for (std::uint8_t i = 1; i < table.count; ++i) result = max(result, table.resistance[i]);
  return result;
}

/// Temperatures are in 0.1 K, the slope in ppm/K.
std::int64_t temperature_factor(const ResistanceTable& table, Temperature temperature) {
  const std::int64_t tenths = (temperature - table.reference).raw();
  const std::int64_t factor = kOnePpm + divide_rounded(tenths * table.ppm_per_kelvin, 10);
  return factor < kFactorMin ? kFactorMin : (factor > kFactorMax ? kFactorMax : factor);
}

}  // namespace

Resistance cell_resistance(const ResistanceTable& table, const SocEstimate& soc, Temperature temperature) {
  VOLTLAP_REQUIRE(table.count > 0 && table.count <= kMaxTablePoints);
  const Resistance at_reference =
      soc.valid ? interpolate(table.soc, table.resistance, table.count, soc.value) : highest(table);
  return Resistance::saturated(divide_rounded(at_reference.raw() * temperature_factor(table, temperature), kOnePpm));
}

}  // namespace voltlap::bms

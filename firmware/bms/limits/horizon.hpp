// SPDX-License-Identifier: Apache-2.0
// What a cell can give or take for a time: the constant current at whose end its voltage stands at a bound.
//
//   s(h)   = s - (1 + f) I h / C
//   v_k(h) = v_k + g_k (rho R_k I - v_k),  g_k = 1 - exp(-h / tau_k)      R_k, tau_k at the SOC in the middle
//   V(h)   = OCV(s(h)) - v_1(h) - v_2(h) - rho R0 I + miss                R0 at the SOC at the end
//   T(h)   = T + I (rho R0 I + g_1 v_1(h) + g_2 v_2(h)) h / C_th            for R0; for R_k half of the way
// from the present state of the cell's filter (cell_filter.hpp); R and tau also at the temperature now and at I.
// miss: what the readings of the last seconds were above the filter's model. The voltage falls with the current, so
// that the current is found by Newton's steps from where it was last, and by halves where these do not get there.
// Source: Plett, High-performance battery-pack power estimation using a dynamic cell model, IEEE Trans. Vehicular
// Technology 53, 2004.
// BMS-045: a bisection in double precision stands beside it in the tests and in voltlap limit-test.
#pragma once
#include <cstddef>
#include <cstdint>

#include "bms/estimate/cell_filter.hpp"
#include "bms/estimate/soc_filter.hpp"

namespace voltlap::bms {

/// What a cell's own heat does to its resistances until then; without a heat capacity nothing.
struct HorizonHeat {
  std::int32_t rise = 0;                    ///< of its temperature [0.1 K 2^-36] by a milliampere and a q 2^-28 of drop
  std::int32_t low = 0, high = 0;           ///< counts of 0.1 K from now to where the temperature's law begins, ends
  PartFactors change{0, 0, 0, 0, 0};        ///< heat_change()
};

/// A time ahead, the same for all cells in a step.
struct Horizon {
  std::int32_t ms = 0;     ///< 0: for ever, as far as the branches go, and neither charge nor heat is counted
  std::int32_t share = 0;  ///< of the configured capacity that a milliampere draws until then [2^-44]
  HorizonHeat heat{};
};
/// Of each part by a count of heat, as a share of it [2^-36]: the same for every horizon of a step.
[[nodiscard]] PartFactors heat_change(const SocFilter& filter);
/// `change`: heat_change() of this step.
[[nodiscard]] Horizon make_horizon(const Config& config, const SocFilter& filter, Duration time,
                                   const PartFactors& change);

/// One cell before a current that lasts.
struct HorizonCell {
  const SocFilter& pack;
  const CellFilter& filter;
  const Horizon& horizon;
  std::int32_t fade;        ///< f, with its doubt: prudent_fade()
  std::int32_t warmer = 0;  ///< than the pack [0.1 K]: where on the temperature's law the cell is
};

/// How much sooner the cell may be empty than the count says: f and its standard deviation, which is a seventh until a
/// good part of the charge has been drawn [2^-28].
[[nodiscard]] std::int32_t prudent_fade(const CellFilter& filter);

struct CellEnd {
  std::int32_t voltage;  ///< [q 2^-26]
  std::int32_t fall;     ///< by a milliampere more [q 2^-36]
};
[[nodiscard]] CellEnd cell_end(const HorizonCell& cell, std::int32_t ma);

enum class Direction : std::uint8_t { kDischarge = 0, kCharge = 1 };

struct HorizonBound {
  Direction direction;
  CellVoltage voltage;  ///< not to be fallen below, or risen above
  std::int32_t most_ma;
  bool by_charge = true;  ///< and not below empty or above full; on a charger the voltage alone says what full is
};

/// Size of the current, 0 .. most_ma, from its size the last time, not negative. Its end is on the bound, or by
/// a few mA on either side.
[[nodiscard]] std::int32_t current_until(const HorizonCell& cell, const HorizonBound& bound, std::int32_t last_ma);

}  // namespace voltlap::bms

// SPDX-License-Identifier: Apache-2.0
// Arcs in a row fitted to the points beside them, from arcs that need not go on from one another.
//
//   minimise  sum w_i (e_i / sigma)^2 + sum (ln(L_k / L_0) / s_L)^2 + sum (kappa_k / s_kappa)^2 + sum |m_k / tau|^2
//
// over the starts, the lengths L_k and the curvatures kappa_k (of straights: 0) of the arcs by Gauss-Newton, with e_i
// the distance of point i across its arc and m_k what the end of an arc misses the start of the next by (multiple
// shooting: Bock and Plitt, 1984). tau becomes smaller until they meet: far from the solution this converges where arcs
// that must go on from one another do not, as each is near its own points all the time.
//
// How probable such arcs are, whatever their lengths and curvatures, is the integral over these (Laplace, 1774):
//
//   -2 ln p = minimum + ln det H + sum ln tau^2 + sum ln s^2 + 2 ln 2 an arc,  but for what the ends add
//
// H: half the second derivatives; the last term, as an arc is one of two kinds.
#pragma once
#include <limits>
#include <optional>
#include <vector>

#include "race/track/import/arc_chain.hpp"

namespace voltlap::plant {

/// Arcs of which the last ends at `end`, or where the first begins.
struct ArcChain {
  std::vector<PlacedArc> arcs;
  PlanePose end;
  bool ring = false;
  bool start_held = false, end_held = false;  ///< of a course's own end only the place along is kept
};

struct ChainFit {
  double cost;           ///< what is minimised
  double improbability;  ///< -2 ln p; compares chains between the same ends
  bool meets;            ///< each arc begins where the one before ends; else the points want other arcs
};

/// None when the arcs cost more than `hopeless_above`.
std::optional<ChainFit> fit_chain(ArcChain& chain, const std::vector<WeightedPoint>& points, double noise_m,
                                  double hopeless_above = std::numeric_limits<double>::infinity());

}  // namespace voltlap::plant

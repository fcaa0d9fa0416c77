// SPDX-License-Identifier: Apache-2.0
// A log in plain units, for a model that misses more than one cause can explain: what of its error the named causes do
// explain together. A floor learned from such a log takes slow errors for wander, and shapes without a name win; the error
// that a user sees is an RMS. So here each channel counts in units of its own RMS, with no filter and no shape without a
// name, and 10 s count as one value, since errors of a drive change as its current does.
//
//   evidence(S) = -n/2 ln(1 - gain of S on pieces that did not fit it),   n: pieces times channels
#pragma once
#include <vector>

#include "discrepancy/judged.hpp"

namespace voltlap::plant {

struct PlainView {
  std::vector<Eigen::VectorXd> residual;  ///< by channel, without what references always show
  NoiseModel noise;              ///< of the channels: as white and as large as the error
  Usual usual;
  System system;
  Parts parts;                   ///< quarters of the minutes; no halves
  std::vector<WeighedSet> sets;  ///< of named causes that act on everything, by gain on pieces that were kept back
};

[[nodiscard]] PlainView plain_view(const Judged& judged);

/// The nonlinear fits of this view.
[[nodiscard]] Refinery plain_refinery(const Judged& judged, const PlainView& view);

/// Standard deviations by how the sizes change when one minute after the other is left out.
void widen_by_minutes(const PlainView& view, const Judged& judged, RefinedSet& set);

}  // namespace voltlap::plant

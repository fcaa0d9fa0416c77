// SPDX-License-Identifier: Apache-2.0
// Which values of an identification the recordings themselves have settled.
#pragma once
#include "learn/identify/identify.hpp"

namespace voltlap::plant {

/// Half width of the 95 % interval below which a value counts as settled: of R and tau relative, of the OCV in V.
inline constexpr double kSettledWithin = 0.20, kOcvSettledWithin_v = 0.010;

/// A node counts as excited when the recordings pass it and settle it: its 95 % interval, in which smoothness counts
/// only as much as it was found in these recordings, is narrower than +- 20 % of the value. `table`: R0 .. RK, then
/// tau1 .. tauK.
[[nodiscard]] bool is_excited(const IdentifyResult& result, Eigen::Index table, Eigen::Index node);
/// The same of a node of the OCV, with +- 10 mV.
[[nodiscard]] bool is_ocv_excited(const IdentifyResult& result, Eigen::Index node);

}  // namespace voltlap::plant

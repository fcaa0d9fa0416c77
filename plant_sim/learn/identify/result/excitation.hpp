// SPDX-License-Identifier: Apache-2.0
// Which values of an identification the recordings themselves have settled.
#pragma once
#include "learn/identify/identify.hpp"

namespace voltlap::plant {

/// A node counts as excited when the recordings pass it and say enough: its 95 % interval, in which smoothness counts
/// only as much as it was found in these recordings, is narrower than +- 1 % (R0), 5 % (R1 .. RK), 10 % (tau).
/// `table`: R0 .. RK, then tau1 .. tauK.
[[nodiscard]] bool is_excited(const IdentifyResult& result, Eigen::Index table, Eigen::Index node);
/// The same of a node of the OCV, with +- 2 mV.
[[nodiscard]] bool is_ocv_excited(const IdentifyResult& result, Eigen::Index node);

}  // namespace voltlap::plant

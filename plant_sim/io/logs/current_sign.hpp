// SPDX-License-Identifier: Apache-2.0
// Which sign of a current is discharge, as the battery's own voltage says over the whole recording:
//
//   V = a + b q + c I             q = integral of I
//
// by least squares, weighted by time, with an own a for each part between gaps. Of a battery that discharges with a
// positive current b and c are negative. Levels are held against levels, so that a voltage that comes late by a second
// or two, and a step of a slow recorder in whose interval a cell relaxes, do not decide as they do step by step.
#pragma once
#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

/// Explained by charge and current, b and c each with its sign, over what both explain: -1 where discharge is positive
/// as it stands, 1 where it is negative; near 0 where they contradict each other or nothing is explained.
[[nodiscard]] double whole_sign_evidence(const CellLog& log);

/// The same of two channels with rates of their own, the current held from its last sample; a silence of either of more
/// than a minute and fifty usual intervals is a gap.
[[nodiscard]] double whole_sign_evidence(const Channel& current, const Channel& voltage);

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// Which sign of a current is discharge, as the battery's own voltage says over the whole recording:
//
//   V = a + f(q) + c0 I + c1 I(2 s) + c2 I(30 s)
//
// by least squares, weighted by time, with an own a for each part between gaps; q is the integral of the current I,
// I(t) is the current behind a lag of t. Of a battery that discharges with a positive current f falls everywhere and
// all c are negative; with a negative one f rises and they are positive. Each is fitted so, f as a line from knot to
// knot. Levels are held against levels, so that a voltage that comes late by a second or
// two, and a step of a slow recorder in whose interval a cell relaxes, do not decide as they do step by step; f is no
// line, or a rest behind the steep end of a discharge would stand below all that went before, as if the current had
// raised the voltage.
#pragma once
#include "io/logs/cell_log.hpp"

namespace voltlap::plant {

/// What the one way explains less the other, over both: -1 where discharge is positive as it stands, 1 where it is
/// negative; near 0 where both explain as much, or neither anything.
[[nodiscard]] double whole_sign_evidence(const CellLog& log);

/// The same of two channels with rates of their own, the current held from its last sample; a silence of either of more
/// than a minute and fifty usual intervals is a gap.
[[nodiscard]] double whole_sign_evidence(const Channel& current, const Channel& voltage);

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// First estimates from the shape of a recording: pulses and rests, R0 from steps (reference study, 2016, Eq. 6.1),
// OCV from rests with its uncertainty, time constants from the relaxation (Eq. 6.2).
#pragma once
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

/// Current below which nothing flows [A]: a hundredth of the largest or, where the sensor is noisier than that, four
/// sigmas of what it shows at rest, and at most a twentieth of the largest.
[[nodiscard]] double quiet_current(const MeasuredRun& run);

/// A stretch of rows in which the current rests, is drawn or is fed. Last is exclusive.
struct PulseSegment {
  enum class Kind { kRest, kDischarge, kCharge } kind;
  Eigen::Index first, last;
  double duration_s;
};
[[nodiscard]] std::vector<PulseSegment> segments(const MeasuredRun& run);

struct StepEstimate {
  double soc, resistance_ohm;
};
/// dV/dI where the current changes by a tenth of its largest: between two rows at most two seconds apart or, where that
/// is seldom, over as much time.
[[nodiscard]] std::vector<StepEstimate> resistance_steps(const MeasuredRun& run);
/// R0 and the branches together over what a step shows: both branches add about as much again, each.
inline constexpr double kWholeOverStep = 3.0;
[[nodiscard]] std::size_t step_count(const std::vector<MeasuredRun>& runs);

/// The middle one of all steps of the runs [ohm]; 0 without any.
[[nodiscard]] double resistance_step_median(const std::vector<MeasuredRun>& runs);

/// OCV at the end of each rest of at least `shortest_s`. Its sigma: what the voltage still had to go by the
/// relaxation's own curve, half of what it went last, and never less than 0.5 mV.
[[nodiscard]] std::vector<OcvKnowledge> ocv_from_rests(const MeasuredRun& run, double shortest_s = 240.0);

/// A slow test (C/10 or slower) as an OCV: the middle of discharge and charge where both were recorded, with half
/// of their distance as sigma; the discharge alone with 10 mV where only that was.
struct SlowTest {
  std::vector<OcvKnowledge> ocv;
  double capacity_ah = 0.0;
};
/// Throws InputError when the recording holds no slow discharge.
[[nodiscard]] SlowTest ocv_from_slow_test(const CellLog& log);

}  // namespace voltlap::plant

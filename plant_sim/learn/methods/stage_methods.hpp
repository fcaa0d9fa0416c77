// SPDX-License-Identifier: Apache-2.0
// The estimation methods of the reference study, 2016, chapter 6, side by side.
//
//   ipo  initial pulse:   each pulse by itself from rest; R1 and R2 free at both its ends, the rest estimated
//   fpo  final pulse:     all six parameters free, from ipo; branch voltages carried over from the pulse before
//   ilo  initial layered: one value a node; R1, R2, tau1, tau2 free from the pulses before and after it, from fpo
//   flo  final layered:   the same with all six free, from ilo
//   ffo  final full:      every parameter of the whole test at once, from ipo
//
// Pulse methods find two values at every SOC at which pulses meet; they are averaged. All are then interpolated to
// the breakpoints of a cell file.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "learn/methods/pulse_sections.hpp"

namespace voltlap::plant {

enum class Method { kInitialPulse, kFinalPulse, kInitialLayered, kFinalLayered, kFinalFull };
inline constexpr std::array kMethods{Method::kInitialPulse, Method::kFinalPulse, Method::kInitialLayered,
                                     Method::kFinalLayered, Method::kFinalFull};
/// ipo, fpo, ilo, flo, ffo
[[nodiscard]] const char* name_of(Method method);
[[nodiscard]] std::optional<Method> method_of(const std::string& name);

/// How a method leaves one of its sections.
struct SectionScore {
  double square_v2;  ///< mean over time of the squared error, reference study, 2016, Eq. 6.6
  double snr;        ///< mean voltage over rms error
};
/// Score of the rows from begin to end: `voltage_v` is the model's.
[[nodiscard]] SectionScore score_of(const MeasuredRun& part, const Eigen::VectorXd& voltage_v);

struct StageFit {
  CircuitModel model;                  ///< on the breakpoints
  std::vector<SectionScore> sections;  ///< as the method left each, before averaging and interpolating
  int iterations = 0;
};

/// ipo, fpo, ilo or flo with the stages before it. `fitted` is `whole` with fewer rows in its rests; scores are over
/// all rows. Throws InputError for a run that is no pulse test.
[[nodiscard]] StageFit stage_fit(const MeasuredRun& whole, const MeasuredRun& fitted, Method method);

/// Square of the instrument's noise [V^2], from second differences of neighbouring rows in the second half of rests.
[[nodiscard]] double noise_floor(const MeasuredRun& whole);

}  // namespace voltlap::plant

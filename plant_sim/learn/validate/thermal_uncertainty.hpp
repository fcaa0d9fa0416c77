// SPDX-License-Identifier: Apache-2.0
// What temperatures tell about a thermal model, and what they do not.
//
//   H = J^T J / s^2 + A^T A,   covariance H^-1       J: slopes of the residuals, A: of what is assumed, over its sigma
//   s^2 = cost / freedom (1 + r) / (1 - r)           r: correlation from row to row of the residuals; so many rows say
//                                                    the same
#pragma once
#include "learn/validate/thermal_fit.hpp"
#include "learn/validate/thermal_system.hpp"

namespace voltlap::plant {

/// s^2 of weighted residuals.
[[nodiscard]] double residual_variance(const Eigen::VectorXd& residual, Eigen::Index parameters);

/// Which numbers are told, by their intervals: capacity within 30 %, conductance within 50 %, and of the entropy half
/// of what was assumed. Lithium-ion cells have 700 to 1300 J/kg/K, a cell in still to moving air 5 to 15 W/m2/K.
void judge_told(ThermalModel& model);

/// The model at a solution, with intervals and classes.
[[nodiscard]] ThermalModel told_model(const std::vector<ThermalRecording>& recordings, const ThermalPace& pace,
                                      const ThermalSolution& solution, double variance);

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// An identification as the cell that the plant takes: tables stacked over (SOC, temperature, current), an OCV that
// never falls, the body as told or assumed.
#pragma once
#include <string>
#include <vector>

#include "core/parameters.hpp"
#include "learn/identify/cell_identification.hpp"
#include "learn/identify/result/cell_body.hpp"

namespace voltlap::plant {

/// R and tau of a branch that was not fitted are tiny. An OCV that falls with SOC is levelled, and `notes` says by how
/// much, and what is implausible. Throws InputError for one that falls by a volt.
[[nodiscard]] CellParameters cell_parameters(const CellIdentification& identified, const CellBody& body,
                                             const std::string& name, std::vector<std::string>& notes);

/// Fit of fifth order to the OCV, from SOC^0 up (kind of reference study, 2016, Eq. 6.7), with its largest error.
struct OcvPolynomial {
  std::vector<double> coefficients_v;
  double error_max_v;
};
[[nodiscard]] OcvPolynomial ocv_polynomial(const CircuitModel& model);

}  // namespace voltlap::plant

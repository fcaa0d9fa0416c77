// SPDX-License-Identifier: Apache-2.0
// A refined cause in words and in numbers that a reader understands.
#pragma once
#include <string>
#include <vector>

#include "discrepancy/explain.hpp"
#include "discrepancy/judged.hpp"

namespace voltlap::plant {

/// Its cause's name, or what kind of shape it is.
[[nodiscard]] std::string name_of_candidate(const Judged& judged, std::size_t member);
[[nodiscard]] std::vector<std::string> names_of(const Judged& judged, const std::vector<std::size_t>& members);

/// Decimals that an interval of this half width calls for.
[[nodiscard]] int decimals_of(double half);

/// "cell 7" for cell_voltage_7, "pack voltage" for pack_voltage.
[[nodiscard]] std::string channel_words(const std::string& channel);

/// Parameters with their intervals, separation and sentence; share and probability are the caller's.
[[nodiscard]] FoundCause found_cause(const Judged& judged, const RefinedCause& fit);

}  // namespace voltlap::plant

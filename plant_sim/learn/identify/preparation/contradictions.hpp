// SPDX-License-Identifier: Apache-2.0
// A recording that no model shares with the others: another cell, a voltage measured behind a cable, a wrong unit. With
// it the model would follow none of them.
#pragma once
#include <string>
#include <vector>

#include "learn/identify/circuit/circuit_fit.hpp"
#include "learn/identify/preparation/prepared_log.hpp"

namespace voltlap::plant {

/// Quick fits with and without each recording: one without which the others are followed three times better, and by 5
/// mV, is taken out of `prepared` and named in `notes`; the worst first, until none is left. Of two that
/// contradict each other the one with fewer steps of the current goes. All recordings are anchored.
/// True when any was left out.
bool leave_out_contradictions(std::vector<PreparedLog>& prepared, const FitPriors& priors,
                              std::vector<std::string>& notes);

/// What was left out is no recording of this cell: neither its capacity nor its ends are. `logs` and their temperatures
/// are those that are prepared; these are to be prepared anew.
void forget_left_out(std::vector<PreparedLog>& prepared, std::vector<CellLog>& logs,
                     std::vector<double>& temperatures_c);

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// The verdict with its sentence, its causes and what speaks for and against them.
#pragma once
#include <vector>

#include "discrepancy/explain.hpp"
#include "discrepancy/judged.hpp"

namespace voltlap::plant {

/// Completes the explanation; `gate` are the causes that the integrity gate found.
void put_verdict(const Judged& judged, const std::vector<Reference>& references, const std::vector<FoundCause>& gate,
                 Explanation& out);

/// No cause stands out, yet an error is much larger than in any reference: says so, and which reference would tell.
void note_larger_than_references(const Design& design, const std::vector<Reference>& references, Explanation& out);

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// Whether all ones (of a signed signal an end of its range) means "no value" where the DBC does not say so: a sender
// without a measurement leaves its usual course for a moment and comes back to where it was. Full throttle is reached
// by a way, or held, or returned from to somewhere else.
#pragma once
#include <span>

namespace voltlap::plant {

/// `value`: samples of a signal in the order of time, `code` the value that may be a code. True when every
/// stretch of it
///   lasts at most 3 samples and has a sample on either side,
///   is left and entered by more than 20 times the usual step of the other samples, and by more than any of theirs,
///   and lies between two samples that are no farther from each other than 20 usual steps.
/// Usual is the median of the steps that are not zero; without 20 of these nothing is known and nothing is masked.
[[nodiscard]] bool all_ones_is_no_value(std::span<const double> value, double code);

}  // namespace voltlap::plant

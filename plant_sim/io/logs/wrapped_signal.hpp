// SPDX-License-Identifier: Apache-2.0
// A signal that the DBC calls unsigned and whose sender means two's complement: -1 A arrives as 2^n - 1. Read as it is
// declared, such a signal jumps between almost nothing and almost everything. What gives it away is in its values: they
// lie at both ends of the raw range and not between, and step from one end to the other by little when they are counted
// around the end (modulo 2^n), by almost the whole range when they are not.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace voltlap::plant {

enum class Wrapping {
  kNone,     ///< as declared
  kSigned,   ///< two's complement
  kDoubtful  ///< could be either
};

struct WrapVerdict {
  Wrapping wrapping = Wrapping::kNone;
  std::size_t negative = 0;   ///< samples in the upper quarter: below zero if it is signed
  std::size_t crossings = 0;  ///< steps from one end to the other
  std::uint64_t largest = 0;  ///< raw value, as unsigned
  std::uint64_t lowest = 0;   ///< of the upper quarter: the most negative if it is signed
};

/// `raw`: values of one signal of `length` bits in the order of time. `fits` says whether a raw value, read as signed
/// or not, is one that the signal can have at all (range of the DBC, of the role, of the map).
///   values in the middle half of the range                  not wrapped
///   fits as unsigned only, or as neither                    not wrapped
///   fits as signed only                                     signed, from 3 samples on
///   fits as both: crossed at least 5 times, at most
///   by 1/64 of the range as a rule                          signed, else doubtful from 3 samples on
/// When the upper end is nothing but the last four values these may be codes for "no value" and "error": then it has to
/// be crossed by single steps.
[[nodiscard]] WrapVerdict wrapped_signal(std::span<const std::uint64_t> raw, unsigned length,
                                         const std::function<bool(std::uint64_t raw, bool is_signed)>& fits);

}  // namespace voltlap::plant

// SPDX-License-Identifier: Apache-2.0
// How deep the stack has been: the start-up paints it, and what is painted still has never been used.
#pragma once
#include <cstdint>

namespace voltlap::port {

inline constexpr std::uint32_t kStackPaint = 0xA5A5'5A5AU;

/// Bytes from the top down to the lowest word that is not painted any more. A frame that was reserved and not written
/// is not seen: toolchain/stack_use.py bounds the rest from the calls.
[[nodiscard]] std::uint32_t stack_used();
[[nodiscard]] std::uint32_t stack_size();

}  // namespace voltlap::port

// SPDX-License-Identifier: Apache-2.0
// The seam to the image that runs: is all of it in flash as it was linked? toolchain/image_crc.py places the value
// behind the image: a mark, and the CRC-32 of all that lies before it. A board's start-up defines image_residue().
#pragma once
#include <cstdint>

namespace voltlap::port {

inline constexpr std::uint32_t kImageWhole = 0x2144'DF1CU;  ///< CRC-32 of anything with its own CRC-32 behind it

/// Of the image with its value; kImageWhole of one that is whole. Before the nodes start. Whoever judges it compares
/// twice: a bit may have changed in the comparison itself.
[[nodiscard]] std::uint32_t image_residue();

}  // namespace voltlap::port

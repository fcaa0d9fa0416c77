// SPDX-License-Identifier: Apache-2.0
// The memory of an image, before anything uses it.
#pragma once

namespace voltlap::port {

/// Marches through the data of the image and the unused stack (base/memory_march.hpp), and leaves both as they were.
/// First thing in main(), before start_board(): no interrupt may run. Some 10 ms for 60 kB at 168 MHz.
[[nodiscard]] bool memory_is_good();

}  // namespace voltlap::port

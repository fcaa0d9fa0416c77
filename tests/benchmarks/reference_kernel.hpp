// SPDX-License-Identifier: Apache-2.0
// A fixed piece of arithmetic that no change of the project touches. What it takes now tells how fast the machine is
// now.
#pragma once

namespace voltlap::benchmarks {

/// About a millisecond of dependent floating-point operations, table lookups and branches inside the first-level cache.
/// Returns a number that depends on all of it.
[[nodiscard]] double reference_kernel();

}  // namespace voltlap::benchmarks

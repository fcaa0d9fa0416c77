// SPDX-License-Identifier: Apache-2.0
// Times and factors in three or four digits, for people.
#pragma once
#include <string>

namespace voltlap::benchmarks {

/// 417 ns, 10.4 us, 1.38 s.
[[nodiscard]] std::string time_text(double ns);
/// 1465, 2 389 000.
[[nodiscard]] std::string factor_text(double factor);

}  // namespace voltlap::benchmarks
